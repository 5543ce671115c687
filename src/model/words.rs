//! The robot's states in the words of the screen.

use groundwave_protocol::letters::{Cliff, Drive, Infrared, Layer, Mode, Power};
use groundwave_protocol::telemetry::{Note, Outcome, ParameterLine, SongLine};

use super::motors::Holder;
use crate::event::Reception;
use crate::request;

/// A layer's name.
pub(crate) const fn layer(layer: Layer) -> &'static str {
    match layer {
        Layer::User => "user",
        Layer::Bumpers => "bumpers",
        Layer::Rotation => "rotation",
        Layer::Infrared => "infrared",
        Layer::Sonar => "sonar",
        Layer::Photo => "photo",
        Layer::Motion => "motion",
        Layer::DeadReckoning => "dead reckoning",
    }
}

/// A holder's name.
pub(crate) const fn holder(holder: Holder) -> &'static str {
    match holder {
        Holder::Layer(holder) => layer(holder),
        Holder::Prowl => "prowl",
        Holder::CliffGuard => "cliff guard",
        Holder::ArmGuard => "arm guard",
        Holder::Nobody => "nobody",
    }
}

/// Who holds the motors, as a sentence.
pub(crate) fn holds(who: Holder) -> String {
    let verb = if who == Holder::Layer(Layer::Bumpers) {
        "hold"
    } else {
        "holds"
    };
    format!("{} {verb} the motors", holder(who).to_uppercase())
}

/// A mode's name.
pub(crate) const fn mode(mode: Mode) -> &'static str {
    request::mode_word(mode)
}

/// What the infrared detectors see.
pub(crate) const fn infrared(infrared: Infrared) -> &'static str {
    match infrared {
        Infrared::None => "clear",
        Infrared::Left => "left",
        Infrared::Right => "right",
        Infrared::Both => "both",
        Infrared::Jammed => "jammed: off 30 s",
        Infrared::NotFitted => "not fitted",
    }
}

/// What the floor sensors see.
pub(crate) const fn cliff(cliff: Cliff) -> &'static str {
    match cliff {
        Cliff::None => "floor",
        Cliff::Left => "EDGE left",
        Cliff::Center => "EDGE ahead",
        Cliff::Right => "EDGE right",
        Cliff::Several => "EDGE",
        Cliff::NotFitted => "not fitted",
    }
}

/// What the drive train does.
pub(crate) const fn drive(drive: Drive) -> &'static str {
    match drive {
        Drive::Ok => "ok",
        Drive::Saturated => "saturated",
        Drive::Stalled => "STALLED",
        Drive::OdometerReset => "odometer reset",
        Drive::OutOfRange => "position out of range",
    }
}

/// The battery's state; empty when there is nothing to say.
pub(crate) const fn power(power: Power) -> &'static str {
    match power {
        Power::Ok => "",
        Power::Low => "LOW",
        Power::Critical => "CRITICAL",
        Power::Docked => "docked",
        Power::Charging => "charging",
    }
}

/// A parameter, as the robot tells of it.
pub(crate) fn parameter(line: &ParameterLine) -> String {
    let ParameterLine {
        value,
        kept,
        least,
        most,
        ..
    } = line;
    let kept = if value == kept {
        String::new()
    } else {
        format!(", {kept} after a reset")
    };
    let (name, unit) = (line.name.as_str(), line.unit.as_str());
    format!("{name} is {value} {unit} ({least} to {most}{kept})")
}

/// What the robot sings: the notes in hertz, a dash for a rest.
pub(crate) fn song(song: &SongLine) -> String {
    let note = |note: Note| match note.hz {
        0 => "-".to_owned(),
        hz => hz.to_string(),
    };
    let notes: Vec<_> = song.notes().map(note).collect();
    format!("the robot sings {}", notes.join(" "))
}

/// Why the robot refused.
pub(crate) const fn outcome(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Done => "done",
        Outcome::NotFitted => "not fitted",
        Outcome::BadValue => "value out of range",
        Outcome::ListIncomplete => "waypoints missing",
        Outcome::DigestMismatch => "the list arrived differently",
        Outcome::NotNow => "not in its present state",
        Outcome::Unknown => "unknown to this firmware",
        Outcome::Failed => "could not carry it out",
    }
}

/// What comes when no line does, for so long.
pub(crate) fn reception(reception: Reception, age: &str) -> String {
    match reception {
        Reception::Lines => "lines".to_owned(),
        Reception::Nothing => format!("no bytes for {age}"),
        Reception::Noise => format!("only noise for {age}"),
        Reception::Damaged => format!("no intact line for {age}: weak signal?"),
        Reception::WrongRate(_) => format!("no intact line for {age}: wrong baud rate?"),
    }
}
