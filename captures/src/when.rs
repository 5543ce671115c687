//! Time arguments: moments in a capture as typed by the operator.

use std::str::FromStr;
use std::time::{Duration, SystemTime};

use jiff::civil::{Date, DateTime, Time};
use jiff::tz::TimeZone;
use jiff::{Span, Timestamp};

/// A moment in a capture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum When {
    /// Time since the beginning of the capture.
    Since(Duration),
    /// Host time, nanoseconds since 1970.
    Wall(u64),
}

/// The text is not a time.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is not a time; try 90s, 1:30, 1:02:03.5 or 2025-03-14T09:26:53Z")]
pub struct NoMoment(String);

impl FromStr for When {
    type Err = NoMoment;

    /// Parses a time: `90`, `90s`, `2m`, `1.5h`, `250ms`; `1:30`, `1:02:03.5`; `2025-03-14T09:26:53Z` in UTC, also with a space for
    /// the T and without the Z.
    fn from_str(text: &str) -> Result<Self, NoMoment> {
        let moment = match text.split_once(['T', ' ']) {
            Some(_) => wall(text).map(Self::Wall),
            None if text.contains(':') => clock(text).map(Self::Since),
            None => span(text).map(Self::Since),
        };
        moment.ok_or_else(|| NoMoment(text.to_owned()))
    }
}

/// Parses `90`, `90s`, `1.5m`, `2h` or `250ms`; `None` for other text.
#[must_use]
pub fn span(text: &str) -> Option<Duration> {
    let digits = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let unit_s = match &text[digits.len()..] {
        "ms" => 0.001,
        "" | "s" => 1.0,
        "m" | "min" => 60.0,
        "h" => 3600.0,
        _ => return None,
    };
    let is_plain = digits.bytes().all(|b| b.is_ascii_digit() || b == b'.');
    let number: f64 = digits.parse().ok().filter(|_| is_plain)?;
    Duration::try_from_secs_f64(number * unit_s).ok()
}

/// Parses minutes and seconds, or hours, minutes and seconds.
fn clock(text: &str) -> Option<Duration> {
    let mut parts = text.rsplit(':');
    let seconds = span(parts.next()?).filter(|s| *s < Duration::from_mins(1))?;
    let minutes: u64 = whole(parts.next()?)?;
    let hours = parts.next().map_or(Some(0), whole)?;
    let is_whole = parts.next().is_none() && text.ends_with(|c: char| c.is_ascii_digit());
    let minutes = hours.checked_mul(60)?.checked_add(minutes)?;
    let passed = Duration::from_secs(minutes.checked_mul(60)?);
    passed.checked_add(seconds).filter(|_| is_whole)
}

fn whole(text: &str) -> Option<u64> {
    let is_plain = text.bytes().all(|b| b.is_ascii_digit());
    text.parse().ok().filter(|_| is_plain)
}

/// Parses a date with a time of day; returns nanoseconds since 1970.
fn wall(text: &str) -> Option<u64> {
    u64::try_from(timestamp(text)?.as_nanosecond()).ok()
}

/// Parses a date with a time of day, in UTC unless it has an offset.
fn timestamp(text: &str) -> Option<Timestamp> {
    if let Ok(timestamp) = text.parse() {
        return Some(timestamp);
    }
    let civil: DateTime = text.trim_end_matches('Z').parse().ok()?;
    TimeZone::UTC.to_timestamp(civil).ok()
}

/// A range of wall-clock time, as typed: a day, a minute or a moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stretch {
    /// Beginning of the range; included.
    pub start: SystemTime,
    /// End of the range; excluded.
    pub end: SystemTime,
}

/// The text is neither a day nor a time.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "`{0}` is not a date; try 2026-11-20, yesterday, \"2 days\", \"2026-11-20 14:30\" or 14:30 (UTC)"
)]
pub struct NoDate(String);

impl Stretch {
    /// Parses `2026-11-20`, `today`, `yesterday`, `14:30` of today, `2026-11-20 14:30`, and `2 days` or `3h` before `now`, with or
    /// without `ago`; in UTC.
    ///
    /// # Errors
    /// If the text has another form.
    pub fn parse(text: &str, now: SystemTime) -> Result<Self, NoDate> {
        Self::of(&text.trim().to_lowercase(), now).ok_or_else(|| NoDate(text.to_owned()))
    }

    fn of(text: &str, now: SystemTime) -> Option<Self> {
        let now = Timestamp::try_from(now).ok()?;
        let here = TimeZone::UTC.to_datetime(now);
        let today = here.date();
        let is_date_alone = !text.contains([':', 't', ' ']);
        let day = match text {
            "today" => Some(today),
            "yesterday" => today.yesterday().ok(),
            _ if is_date_alone => text.parse::<Date>().ok(),
            _ => None,
        };
        if let Some(day) = day {
            let midnight = day.to_datetime(Time::midnight());
            return Self::from(midnight, Span::new().days(1));
        }
        if let Some(timestamp) = timestamp(text) {
            return Self::from(TimeZone::UTC.to_datetime(timestamp), resolution(text));
        }
        let has_short_hour = text.find(':') == Some(1);
        let padded = if has_short_hour { "0" } else { "" }.to_owned() + text;
        if let Ok(time) = padded.parse::<Time>() {
            return Self::from(today.to_datetime(time), resolution(text));
        }
        let before: Span = text.trim_start_matches('-').parse().ok()?;
        let moment = here.checked_sub(before.abs()).ok()?;
        Self::from(moment, Span::new())
    }

    fn from(start: DateTime, length: Span) -> Option<Self> {
        let at = |civil: DateTime| TimeZone::UTC.to_timestamp(civil).ok();
        Some(Self {
            start: at(start)?.into(),
            end: at(start.checked_add(length).ok()?)?.into(),
        })
    }
}

/// Unit of the last digit of a time of day.
fn resolution(text: &str) -> Span {
    let is_to_the_second = text.matches(':').count() > 1;
    let unit = Span::new();
    if is_to_the_second {
        unit.seconds(1)
    } else {
        unit.minutes(1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::name::utc;
    use std::time::UNIX_EPOCH;

    #[test]
    fn moments_since_the_beginning() {
        let known = [
            ("90", 90_000),
            ("90s", 90_000),
            ("2m", 120_000),
            ("1.5h", 5_400_000),
            ("250ms", 250),
            ("1:30", 90_000),
            ("0:00", 0),
            ("1:02:03.5", 3_723_500),
            ("100:00", 6_000_000),
        ];
        for (text, ms) in known {
            let expected = When::Since(Duration::from_millis(ms));
            assert_eq!(text.parse(), Ok(expected), "{text}");
        }
    }

    #[test]
    fn moments_by_the_clock_are_what_captures_print() {
        for s in [0_u64, 951_827_696, 1_741_944_413, 4_102_444_799] {
            let text = utc(UNIX_EPOCH + Duration::from_secs(s));
            assert_eq!(text.parse(), Ok(When::Wall(s * 1_000_000_000)), "{text}");
        }
        let expected = Ok(When::Wall(1_741_944_413_250_000_000));
        assert_eq!("2025-03-14 09:26:53.25".parse(), expected);
    }

    #[test]
    fn dates_are_typed_as_a_person_types_them() {
        let at = |text: &str| {
            UNIX_EPOCH + Duration::from_secs(text.parse::<Timestamp>().unwrap().as_second() as u64)
        };
        let now = at("2026-11-23T08:20:36Z");
        for (text, start, end) in [
            ("2026-11-20", "2026-11-20T00:00:00Z", "2026-11-21T00:00:00Z"),
            ("today", "2026-11-23T00:00:00Z", "2026-11-24T00:00:00Z"),
            ("Yesterday", "2026-11-22T00:00:00Z", "2026-11-23T00:00:00Z"),
            (
                "2026-11-20 14:30",
                "2026-11-20T14:30:00Z",
                "2026-11-20T14:31:00Z",
            ),
            (
                "2026-11-20T14:30:05Z",
                "2026-11-20T14:30:05Z",
                "2026-11-20T14:30:06Z",
            ),
            (
                "2026-11-20T14:30:05+01:00",
                "2026-11-20T13:30:05Z",
                "2026-11-20T13:30:06Z",
            ),
            ("7:30", "2026-11-23T07:30:00Z", "2026-11-23T07:31:00Z"),
            ("07:30", "2026-11-23T07:30:00Z", "2026-11-23T07:31:00Z"),
            ("2 days", "2026-11-21T08:20:36Z", "2026-11-21T08:20:36Z"),
            ("2 days ago", "2026-11-21T08:20:36Z", "2026-11-21T08:20:36Z"),
            ("3h", "2026-11-23T05:20:36Z", "2026-11-23T05:20:36Z"),
            ("1 week", "2026-11-16T08:20:36Z", "2026-11-16T08:20:36Z"),
        ] {
            let expected = Stretch {
                start: at(start),
                end: at(end),
            };
            assert_eq!(Stretch::parse(text, now), Ok(expected), "{text}");
        }
        for text in ["", "soon", "2026-02-30", "20.11.2026", "25:00", "2 parsecs"] {
            let wrong = Stretch::parse(text, now).unwrap_err().to_string();
            assert!(wrong.contains("try 2026-11-20, yesterday"), "{wrong}");
        }
    }

    #[test]
    fn text_that_is_not_a_time_is_refused() {
        let wrong = [
            "",
            "s",
            "-1",
            "1:60",
            "1:2:3:4",
            ":30",
            "1:",
            "1:3s",
            "ten",
            "1d",
            "1e3",
            "+1:30",
            "2025-02-29T00:00:00",
            "2025-13-01T00:00",
            "2025-01-01T24:00:00",
            "1969-12-31T00:00:00",
            "2025-01-01T",
            "99999999999999999999h",
            "inf",
            "nan",
        ];
        for text in wrong {
            assert!(text.parse::<When>().is_err(), "{text}");
        }
    }
}
