//! The robot's states as text on the screen.

use groundwave_protocol::status_codes::{Cliff, Drive, Infrared, Layer, Mode, Power};
use groundwave_protocol::telemetry::{Outcome, ParameterLine, SongLine};

use super::motors::Holder;
use crate::event::Reception;
use crate::{request, song};

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
        Holder::NoLayer => "no layer",
    }
}

/// The holder, as a sentence.
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

/// The infrared detectors' state.
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

/// The floor sensors' state.
pub(crate) const fn cliff(cliff: Cliff) -> &'static str {
    match cliff {
        Cliff::None => "floor OK",
        Cliff::Left => "EDGE left",
        Cliff::Center => "EDGE ahead",
        Cliff::Right => "EDGE right",
        Cliff::Several => "EDGE",
        Cliff::NotFitted => "no edge sensors",
    }
}

/// The drive train's state.
pub(crate) const fn drive(drive: Drive) -> &'static str {
    match drive {
        Drive::Ok => "ok",
        Drive::Saturated => "saturated",
        Drive::Stalled => "STALLED",
        Drive::OdometerReset => "odometer reset",
        Drive::OutOfRange => "position out of range",
    }
}

/// The battery's state; empty if normal.
pub(crate) const fn power(power: Power) -> &'static str {
    match power {
        Power::Ok => "",
        Power::Low => "LOW",
        Power::Critical => "CRITICAL",
        Power::Docked => "docked",
        Power::Charging => "charging",
    }
}

/// A value of a parameter in the unit that [`parameter_unit`] names.
pub(crate) fn parameter_number(value: i32, unit: &str) -> String {
    match unit.strip_prefix("1/") {
        Some(parts) => format!("{value}/{parts}"),
        None => request::in_whole_unit(value, unit).map_or(value.to_string(), |(number, _)| number),
    }
}

/// The unit in which a parameter is shown: none for a fraction, whose figures contain it, and for a switch.
pub(crate) fn parameter_unit(line: &ParameterLine) -> &str {
    let unit = line.unit.as_str();
    match request::in_whole_unit(line.value, unit) {
        Some((_, whole)) => whole,
        None if unit.starts_with("1/") || ["1", "0 or 1"].contains(&unit) => "",
        None => unit,
    }
}

/// A reported parameter as text.
pub(crate) fn parameter(line: &ParameterLine) -> String {
    let unit = line.unit.as_str();
    let number = |value| parameter_number(value, unit);
    let whole = match parameter_unit(line) {
        "" => String::new(),
        unit => format!(" {unit}"),
    };
    let kept = if line.value == line.kept {
        String::new()
    } else {
        format!(", {} after a reset", number(line.kept))
    };
    let (name, value) = (line.name.as_str(), number(line.value));
    let (least, most) = (number(line.least), number(line.most));
    format!("{name} is {value}{whole} ({least} to {most}{kept})")
}

/// A song as text: its meaning and its notes.
pub(crate) fn song(line: &SongLine) -> String {
    let notes: Vec<_> = line.notes().map(|note| song::note_name(note.hz)).collect();
    let notes = notes.join(" ");
    match song::meaning(line) {
        Some(meaning) => format!("sings \"{meaning}\": {notes}"),
        None => format!("sings {notes}"),
    }
}

/// The reason why the robot refused.
pub(crate) const fn outcome(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Done => "done",
        Outcome::NotFitted => "not fitted",
        Outcome::BadValue => "value out of range",
        Outcome::ListIncomplete => "waypoints missing",
        Outcome::DigestMismatch => "the received list differs from the sent one",
        Outcome::NotNow => "not in its present state",
        Outcome::Unknown => "unknown to this firmware",
        Outcome::Failed => "could not carry it out",
    }
}

/// Describes the kind of bytes received instead of lines, and the duration.
pub(crate) fn reception(reception: Reception, age: &str) -> String {
    match reception {
        Reception::Lines => "lines".to_owned(),
        Reception::Nothing => format!("no bytes for {age}"),
        Reception::Noise => format!("only noise for {age}"),
        Reception::Damaged => format!("no intact line for {age}: weak signal?"),
        Reception::WrongRate(_) => format!("no intact line for {age}: wrong baud rate?"),
    }
}

/// Returns the kind of bytes received, for display beside the time for which no line was intact.
pub(crate) const fn reception_alone(reception: Reception) -> &'static str {
    match reception {
        Reception::Lines => "lines",
        Reception::Nothing => "no bytes",
        Reception::Noise => "only noise",
        Reception::Damaged => "weak signal?",
        Reception::WrongRate(_) => "wrong baud rate?",
    }
}

#[cfg(test)]
mod tests {
    use groundwave_protocol::telemetry::{ParameterName, Printable};

    use super::*;

    #[test]
    fn parameters_have_each_figure_with_its_unit_once() {
        for (name, unit, value, most, said) in [
            ("photo-avoid", "0 or 1", 0, 1, "photo-avoid is 0 (0 to 1)"),
            (
                "photo-deadzone",
                "1/256",
                8,
                255,
                "photo-deadzone is 8/256 (0/256 to 255/256)",
            ),
            (
                "battery-critical",
                "V/10",
                112,
                130,
                "battery-critical is 11.2 V (0.0 to 13.0)",
            ),
            ("arrive", "in", 6, 24, "arrive is 6 in (0 to 24)"),
        ] {
            let line = ParameterLine {
                place: 1,
                count: 1,
                name: ParameterName::new(name),
                value,
                kept: value,
                least: 0,
                most,
                unit: Printable::new(unit),
            };
            assert_eq!(parameter(&line), said);
        }
    }
}
