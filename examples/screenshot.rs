//! Remakes the README's picture: a minute of the demo in virtual time, its screen as SVG.
//!
//! `cargo run --release --example screenshot > docs/dashboard.svg`

mod pictures;

use std::error::Error;

use pictures::flight::Flight;
use pictures::svg;

/// When the route is sent and when the picture is taken, virtual seconds.
const ROUTE_AT_S: f64 = 18.0;
const PICTURE_AT_S: f64 = 40.0;

fn main() -> Result<(), Box<dyn Error>> {
    let mut flight = Flight::begin(1, (120, 40))?;
    flight.fly_to(ROUTE_AT_S);
    flight.send_route(&[(-40, 30), (-90, 50), (-60, 100), (0, 0)]);
    flight.fly_to(PICTURE_AT_S);
    print!("{}", svg::still(&flight.screen()?));
    Ok(())
}
