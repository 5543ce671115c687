//! Advice for a link without intact lines.

use crate::event::{Level, LineRate, Reception};
use crate::io::link::BAUD;

/// The log entry for a kind of received bytes, with the remedy. `baud` is the port's rate if the station sets it.
pub(super) fn advice(reception: Reception, baud: Option<u32>) -> (Level, String) {
    let words = match reception {
        Reception::Lines => return (Level::Info, "intact lines arrive again".to_owned()),
        Reception::Nothing => "no bytes arrive: is the robot switched on?".to_owned(),
        Reception::Noise => {
            "only noise arrives: is the robot on, and the channel right?".to_owned()
        }
        Reception::Damaged => {
            "no line is intact, but it is text: a weak signal, or another kind of robot".to_owned()
        }
        Reception::WrongRate(rate) => {
            let hint = match baud {
                None => "check the serial server's baud rate".to_owned(),
                Some(BAUD) => format!("try --baud {}", other_rate(rate)),
                Some(baud) => format!("the port is at {baud}: try --baud {BAUD}"),
            };
            format!(
                "no line is intact: {hint}. Bytes arrive, but is the robot's radio at {BAUD} baud?"
            )
        }
    };
    (Level::Warning, words)
}

/// The most common rate above or below 2400 baud.
const fn other_rate(rate: LineRate) -> u32 {
    match rate {
        LineRate::Slower => BAUD / 2,
        LineRate::Faster => 4 * BAUD,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wrong_rate_names_the_rate_to_try() {
        let words = |rate, baud| advice(Reception::WrongRate(rate), baud).1;
        let faster = words(LineRate::Faster, Some(2400));
        assert_eq!(
            faster,
            "no line is intact: try --baud 9600. Bytes arrive, but is the robot's radio at 2400 baud?"
        );
        assert!(words(LineRate::Slower, Some(2400)).contains("try --baud 1200"));
        assert!(words(LineRate::Slower, Some(9600)).contains("at 9600: try --baud 2400"));
        assert!(words(LineRate::Faster, None).contains("serial server"));
    }
}
