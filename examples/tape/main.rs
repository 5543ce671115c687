//! Draws a picture in the documents from its tape: a list of keys with their times, played on the demo in virtual time. A
//! tape with one picture becomes a still SVG, with several an animation.
//!
//! `cargo run --release --example tape examples/tape/demo.tape > docs/demo.svg`

mod flight;
mod parse;
mod svg;

use std::error::Error;
use std::fs;

use flight::Flight;
use parse::{Act, Tape};

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args()
        .nth(1)
        .ok_or("name a tape, such as examples/tape/demo.tape")?;
    let text = fs::read_to_string(&path).map_err(|error| format!("{path}: {error}"))?;
    let tape: Tape = text
        .parse()
        .map_err(|problem| format!("{path}:{problem}"))?;
    print!("{}", play(tape)?);
    Ok(())
}

/// Plays a tape and draws its pictures.
fn play(tape: Tape) -> Result<String, Box<dyn Error>> {
    let mut flight = Flight::begin(&tape.world, tape.seed, tape.size)?;
    let has_captions = tape
        .steps
        .iter()
        .any(|step| matches!(step.act, Act::Caption(_)));
    let mut caption = has_captions.then(String::new);
    let mut screens = Vec::new();
    for step in tape.steps {
        flight.fly_to(step.at_s);
        match step.act {
            Act::Keys(keys) => keys.into_iter().for_each(|key| flight.press(key)),
            Act::Route(points) => flight.send_route(points),
            Act::Caption(words) => caption = Some(words),
            Act::Picture => screens.push(flight.screen(caption.as_deref())?),
        }
    }
    Ok(match &screens[..] {
        [screen] => svg::still(screen),
        screens => svg::moving(screens, tape.each_s),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const TAPES: [&str; 2] = [include_str!("dashboard.tape"), include_str!("demo.tape")];

    #[test]
    fn a_tape_gives_the_same_picture_each_time() {
        for tape in TAPES {
            let play = || play(tape.parse().unwrap()).unwrap();
            let first = play();
            assert!(first.starts_with("<svg") && first.ends_with("</svg>\n"));
            assert_eq!(first, play());
        }
    }
}
