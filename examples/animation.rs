//! Remakes the README's animation: the demo prowls, is sent a route, drives it and is stopped; in virtual time, as SVG.
//!
//! `cargo run --release --example animation > docs/demo.svg`

mod pictures;

use std::error::Error;

use pictures::flight::Flight;
use pictures::svg;

/// Duration of each picture.
const EACH_S: f64 = 1.2;

fn main() -> Result<(), Box<dyn Error>> {
    let mut flight = Flight::begin(1, (110, 34))?;
    let mut screens = Vec::new();
    for at_s in [4.0, 9.0, 14.0] {
        flight.fly_to(at_s);
        screens.push(flight.screen()?);
    }
    flight.send_route(&[(-40, 30), (-90, 50), (-60, 100), (0, 0)]);
    for at_s in [14.4, 15.5, 20.0, 25.0, 30.0, 35.0] {
        flight.fly_to(at_s);
        screens.push(flight.screen()?);
    }
    flight.press(":mode home");
    screens.push(flight.screen()?);
    flight.press("\n");
    for at_s in [35.6, 42.0] {
        flight.fly_to(at_s);
        screens.push(flight.screen()?);
    }
    flight.press(" ");
    flight.fly_to(43.0);
    screens.push(flight.screen()?);
    print!("{}", svg::moving(&screens, EACH_S));
    Ok(())
}
