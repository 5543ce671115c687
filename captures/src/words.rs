//! Words for codes and states of the wire.

use groundwave_protocol::decoder::Lost;
use groundwave_protocol::status_codes::{Layer, Mode};
use groundwave_protocol::telemetry::Outcome;

use crate::event::Moment;

/// Reason why the robot refused a command.
#[must_use]
pub const fn outcome_words(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Done => "it did not refuse",
        Outcome::NotFitted => "this robot has no such layer, mode or ability",
        Outcome::BadValue => "a value is out of range",
        Outcome::ListIncomplete => "waypoints are missing",
        Outcome::DigestMismatch => "the list it holds is not the one that was announced",
        Outcome::NotNow => "not in its present state",
        Outcome::Unknown => "its firmware does not know this command",
        Outcome::Failed => "it tried and could not",
    }
}

/// A number with its noun, whose plural ends in s: `1 gap`, `2 gaps`.
#[must_use]
pub fn counted(number: u64, noun: &str) -> String {
    format!("{number} {noun}{}", plural(number))
}

/// The ending of a noun after a number: nothing after 1, `s` after any other.
#[must_use]
pub const fn plural(number: u64) -> &'static str {
    if number == 1 { "" } else { "s" }
}

/// A number of lost lines as text: `165`, `165 to 265`, or `at least 65`.
#[must_use]
pub fn lost_words(Lost { min, max, is_open }: Lost) -> String {
    if is_open {
        format!("at least {min}")
    } else if min == max {
        min.to_string()
    } else {
        format!("{min} to {max}")
    }
}

/// A share that is known as an interval, as text: `7.5 %`, or `62.3 to 72.6 %`.
#[must_use]
pub fn interval_pct(min_pct: f64, max_pct: f64) -> String {
    if min_pct < max_pct {
        format!("{min_pct:.1} to {max_pct:.1} %")
    } else {
        format!("{min_pct:.1} %")
    }
}

/// Name of a layer.
#[must_use]
pub const fn layer_word(layer: Layer) -> &'static str {
    match layer {
        Layer::User => "user",
        Layer::Bumpers => "bumpers",
        Layer::Rotation => "rotation",
        Layer::Infrared => "infrared",
        Layer::Sonar => "sonar",
        Layer::Photo => "photo",
        Layer::Motion => "motion",
        Layer::DeadReckoning => "dead-reckoning",
    }
}

/// Name of a mode.
#[must_use]
pub const fn mode_word(mode: Mode) -> &'static str {
    match mode {
        Mode::Prowl => "prowl",
        Mode::Reactive => "reactive",
        Mode::Passive => "passive",
        Mode::Stop => "stop",
        Mode::User => "user",
        Mode::Wander => "wander",
        Mode::GoHome => "home",
        Mode::Forage => "dock",
        Mode::Calibrate => "calibrate",
    }
}

/// A moment as text: `12:30`, or `1:02:30` from an hour on.
#[must_use]
pub fn clock_words(at: Moment) -> String {
    let s = at.as_secs();
    match s / 3600 {
        0 => format!("{:02}:{:02}", s / 60, s % 60),
        hours => format!("{hours}:{:02}:{:02}", s / 60 % 60, s % 60),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_of_a_kind_is_in_the_singular() {
        let texts = [0, 1, 2].map(|number| counted(number, "line"));
        assert_eq!(texts, ["0 lines", "1 line", "2 lines"]);
    }
}
