//! Playback controls, positions in time, and the state of playback.

use std::str::FromStr;

pub use groundwave_captures::event::{Landmark, Mark};
use groundwave_captures::event::{Level, Moment};
pub use groundwave_captures::marks::{MARK_REACH, MARKS_MAX};
pub use groundwave_captures::words::clock_words;

/// Minimum speed, as a multiple of real time.
pub const SPEED_MIN: f64 = 0.1;

/// Maximum speed, as a multiple of real time.
pub const SPEED_MAX: f64 = 1000.0;

/// A playback control.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Control {
    /// Pause or play.
    TogglePause,
    /// Play at this multiple of real time.
    Speed(f64),
    /// Go to the next or previous line and pause.
    Step {
        /// Whether the target is the next one; `false` for the previous one.
        forward: bool,
    },
    /// Go to a typed position.
    Seek(Position),
    /// Go to the next or previous landmark.
    Jump {
        /// Kind of the landmark; `None` repeats the kind of the last jump.
        to: Option<Landmark>,
        /// Whether the target is the next one; `false` for the previous one.
        forward: bool,
    },
    /// Set a mark at a moment, or remove the one there.
    Mark(Moment),
    /// Begin a loop here, end it here, or remove it, in this order.
    Loop,
    /// End the current search.
    StopSearch,
    /// Go to the newest moment; in a live session, to now.
    Newest,
    /// Go to the oldest moment.
    Oldest,
}

/// Number of landmarks of each kind up to a moment, without marks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Number of intact 80-byte lines.
    pub lines: u64,
    /// Number of alarms.
    pub alarms: u64,
    /// Number of contacts.
    pub bumps: u64,
    /// Number of changes of behaviour.
    pub behaviours: u64,
    /// Number of commands.
    pub commands: u64,
}

impl Tally {
    /// The number of landmarks of a kind.
    #[must_use]
    pub const fn of(&self, landmark: Landmark) -> u64 {
        match landmark {
            Landmark::Line => self.lines,
            Landmark::Alarm => self.alarms,
            Landmark::Bump => self.bumps,
            Landmark::Behaviour => self.behaviours,
            Landmark::Command => self.commands,
            Landmark::Marker => 0,
        }
    }
}

/// A position in time that can be typed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Position {
    /// Time since the beginning: `12:30`, `1:02:30`, `90s`.
    At(Moment),
    /// Time after the displayed moment: `+30s`.
    Ahead(Moment),
    /// Time before the displayed moment: `-2m`.
    Back(Moment),
    /// Share of the whole, 0 to 100: `90%`.
    Percent(f64),
    /// Number of a line, from 1: `#1234`.
    Line(u64),
    /// Time of day, UTC, as time since midnight: `14:05Z`.
    Utc(Moment),
}

/// The forms of a position, for the prompt.
pub const POSITION_HELP: &str =
    "to 12:30, 1:02:30, +30s, -2m, 90%, #1234 (a line) or 14:05Z (time of day, UTC)";

/// The typed text is not a position.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is not a time; write 12:30, +30s, -2m, 90%, #1234 or 14:05Z")]
pub struct PositionError(String);

impl FromStr for Position {
    type Err = PositionError;

    fn from_str(text: &str) -> Result<Self, PositionError> {
        let text = text.trim();
        parse(text).ok_or_else(|| PositionError(text.to_owned()))
    }
}

fn parse(text: &str) -> Option<Position> {
    if let Some(number) = text.strip_prefix('#') {
        let number = number.trim().parse().ok()?;
        return (number > 0).then_some(Position::Line(number));
    }
    if let Some(number) = text.strip_suffix('%') {
        let percent = decimal(number.trim())?;
        return (percent <= 100.0).then_some(Position::Percent(percent));
    }
    if let Some(span) = text.strip_prefix('+') {
        return Some(Position::Ahead(time_span(span.trim())?));
    }
    if let Some(span) = text.strip_prefix('-') {
        return Some(Position::Back(time_span(span.trim())?));
    }
    if let Some(clock) = text.strip_suffix(['Z', 'z']) {
        let (hours, rest) = clock.split_once(':')?;
        let (minutes, seconds) = rest.split_once(':').unwrap_or((rest, "0"));
        let (hours, minutes) = (whole(hours)?, whole(minutes)?);
        let seconds = decimal(seconds)?;
        let is_clock = hours < 24 && minutes < 60 && seconds < 60.0;
        let since_midnight = Moment::from_secs(hours * 3600 + minutes * 60);
        return is_clock.then(|| Position::Utc(since_midnight + Moment::from_secs_f64(seconds)));
    }
    time_span(text).map(Position::At)
}

/// Parses a time: `12:30`, `1:02:30`, `30s`, `2m`, `1h`, or seconds without a unit.
fn time_span(text: &str) -> Option<Moment> {
    let parts: Vec<&str> = text.split(':').collect();
    let seconds = match parts[..] {
        [hours, minutes, seconds] => {
            let (minutes, seconds) = (whole(minutes)?, decimal(seconds)?);
            if minutes >= 60 || seconds >= 60.0 {
                return None;
            }
            whole(hours)? as f64 * 3600.0 + minutes as f64 * 60.0 + seconds
        }
        [minutes, seconds] => {
            let seconds = decimal(seconds)?;
            if seconds >= 60.0 {
                return None;
            }
            whole(minutes)? as f64 * 60.0 + seconds
        }
        [one] => {
            let (number, factor) = match one.char_indices().next_back()? {
                (at, 's') => (&one[..at], 1.0),
                (at, 'm') => (&one[..at], 60.0),
                (at, 'h') => (&one[..at], 3600.0),
                _ => (one, 1.0),
            };
            decimal(number.trim())? * factor
        }
        _ => return None,
    };
    Moment::try_from_secs_f64(seconds).ok()
}

fn is_digits(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit())
}

fn whole(text: &str) -> Option<u64> {
    is_digits(text).then(|| text.parse().ok()).flatten()
}

/// Parses a decimal number without sign and exponent.
fn decimal(text: &str) -> Option<f64> {
    let (before, after) = text.split_once('.').unwrap_or((text, "0"));
    let is_number = is_digits(before) && is_digits(after);
    is_number.then(|| text.parse().ok()).flatten()
}

/// State of playback, for the screen.
#[expect(clippy::struct_excessive_bools, reason = "each is a fact of its own")]
#[derive(Clone, Debug, PartialEq)]
pub struct Playback {
    /// Whether the session is live; `false` for a capture.
    pub is_live: bool,
    /// Whether playback is paused.
    pub paused: bool,
    /// Speed, as a multiple of real time.
    pub speed: f64,
    /// The displayed moment.
    pub at: Moment,
    /// The oldest moment that can be shown.
    pub from: Moment,
    /// The newest moment that can be shown.
    pub until: Moment,
    /// Time since 1970 at moment zero, if known.
    pub unix: Option<Moment>,
    /// Number of the newest displayed line, from 1; `None` while unknown.
    pub line: Option<u64>,
    /// Time up to which the capture has been read; `None` if read completely.
    pub read_until: Option<Moment>,
    /// Whether the displayed state lacks events long before it.
    pub is_partial: bool,
    /// Marked moments, in order.
    pub markers: Vec<Moment>,
    /// Beginning and end of the loop.
    pub repeat: Option<(Moment, Option<Moment>)>,
    /// Message about the last control, if any.
    pub note: Option<(Level, String)>,
    /// Whether the unread part is being searched.
    pub is_looking: bool,
}

impl Playback {
    /// Time from the displayed moment to the newest.
    #[must_use]
    pub fn behind(&self) -> Moment {
        self.until.saturating_sub(self.at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn ms(ms: u64) -> Moment {
        Moment::from_millis(ms)
    }

    #[test]
    fn positions_parse_in_every_form() {
        for (text, target) in [
            ("12:30", Position::At(ms(750_000))),
            (" 1:02:30 ", Position::At(ms(3_750_000))),
            ("90:00", Position::At(ms(5_400_000))),
            ("0:07.5", Position::At(ms(7_500))),
            ("45", Position::At(ms(45_000))),
            ("45s", Position::At(ms(45_000))),
            ("+30s", Position::Ahead(ms(30_000))),
            ("+1:30", Position::Ahead(ms(90_000))),
            ("-2m", Position::Back(ms(120_000))),
            ("-0.5h", Position::Back(ms(1_800_000))),
            ("90%", Position::Percent(90.0)),
            ("#1234", Position::Line(1234)),
            ("14:05Z", Position::Utc(ms(50_700_000))),
            ("14:05:07z", Position::Utc(ms(50_707_000))),
        ] {
            assert_eq!(text.parse(), Ok(target), "{text}");
        }
    }

    #[test]
    fn invalid_position_is_refused_with_examples() {
        for text in [
            "",
            "x",
            ":",
            "1:",
            "1:60",
            "1:2:3:4",
            "#0",
            "#",
            "101%",
            "%",
            "+",
            "--3",
            "1e9",
            "inf",
            "25:00Z",
            "Z",
            "14Z",
            "1:60:00",
            "9999999999999999999999h",
            "+ -3",
        ] {
            let error = text.parse::<Position>().expect_err(text);
            assert!(error.to_string().contains("+30s"), "{text}");
        }
    }

    #[test]
    fn clock_words_parse_as_positions() {
        for s in [0, 59, 60, 3599, 3600, 86_399] {
            let at = Moment::from_secs(s);
            assert_eq!(clock_words(at).parse(), Ok(Position::At(at)));
        }
    }
}
