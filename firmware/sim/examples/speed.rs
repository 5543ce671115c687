//! Prints the speed of the whole simulation on one core, in every built-in world.
//!
//! `cargo run --release -p sr04-sim --example speed [MINUTES]`

use std::time::Instant;

use sr04_sim::{Simulation, SimulationConfig, World};

fn main() {
    let minutes = std::env::args()
        .nth(1)
        .and_then(|text| text.parse().ok())
        .unwrap_or(30);
    println!("{minutes} simulated minutes each, seed 1");
    for name in World::built_in_names() {
        let Some(world) = World::built_in(name) else {
            continue;
        };
        let mut simulation = Simulation::new(&SimulationConfig::new(world, 1));
        let begun = Instant::now();
        for _ in 0..minutes * 60 {
            simulation.run_for_ms(1000);
            while simulation.poll_downlink().is_some() {}
        }
        let took_s = begun.elapsed().as_secs_f64();
        let truth = simulation.truth();
        println!(
            "{name:12} {:7.0} times real time, {:6.0} ns a step, {:6.0} ft driven",
            f64::from(minutes) * 60.0 / took_s,
            took_s * 1e6 / (f64::from(minutes) * 60.0),
            truth.path_in / 12.0,
        );
    }
}
