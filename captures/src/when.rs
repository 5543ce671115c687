//! Time arguments: moments in a capture as typed by the operator.

use std::str::FromStr;
use std::time::Duration;

/// A moment in a capture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum When {
    /// Since the beginning of the capture.
    Since(Duration),
    /// Host time, nanoseconds since 1970.
    Wall(u64),
}

/// Text that is no moment.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is no moment; try 90s, 1:30, 1:02:03.5 or 2025-03-14T09:26:53Z")]
pub struct NoMoment(String);

impl FromStr for When {
    type Err = NoMoment;

    /// Parses `90`, `90s`, `2m`, `1.5h`, `250ms`; `1:30`, `1:02:03.5`; `2025-03-14T09:26:53Z` in UTC, also with a space for
    /// the T and without the Z.
    fn from_str(text: &str) -> Result<Self, NoMoment> {
        let moment = match text.split_once(['T', ' ']) {
            Some((day, time)) => wall(day, time.trim_end_matches('Z')).map(Self::Wall),
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

/// Nanoseconds since 1970 of a day and a time of day.
fn wall(day: &str, time: &str) -> Option<u64> {
    let [year, month, day] = numbers(day, '-')?;
    let time = clock(time).filter(|time| *time < Duration::from_hours(24))?;
    let leap = u64::from(year % 4 == 0 && (year % 100 != 0 || year % 400 == 0));
    let months = [31, 28 + leap, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];
    let before = months.get(..usize::try_from(month).ok()?.checked_sub(1)?)?;
    let length = months.get(before.len())?;
    // Nanoseconds since 1970 fit 64 bits until 2554.
    if !(1970..=2500).contains(&year) || !(1..=*length).contains(&day) {
        return None;
    }
    let years_before = year - 1;
    let leap_days = |years: u64| years / 4 - years / 100 + years / 400;
    let days = (year - 1970) * 365 + leap_days(years_before) - leap_days(1969)
        + before.iter().sum::<u64>()
        + day
        - 1;
    u64::try_from((Duration::from_secs(days * 86_400) + time).as_nanos()).ok()
}

fn numbers(text: &str, between: char) -> Option<[u64; 3]> {
    let numbers: Option<Vec<u64>> = text.split(between).map(whole).collect();
    numbers?.try_into().ok()
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
    fn text_that_is_no_moment_is_refused() {
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
