//! Writes the radio's output to standard output. The raw captures in `captures/` are made with it.
//!
//! `cargo run --release -p sr04-sim --example capture -- WORLD SEED SECONDS [CHANNEL]`

use std::io::{self, Write};
use std::process::ExitCode;

use sr04_sim::{ChannelSpec, Simulation, SimulationConfig, World};

fn main() -> ExitCode {
    match capture(&std::env::args().skip(1).collect::<Vec<_>>()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("capture: {error}");
            ExitCode::FAILURE
        }
    }
}

fn capture(arguments: &[String]) -> Result<(), Box<dyn std::error::Error>> {
    let (world, seed, seconds, channel) = match arguments {
        [world, seed, seconds] => (world, seed, seconds, ""),
        [world, seed, seconds, channel] => (world, seed, seconds, channel.as_str()),
        _ => return Err("usage: capture WORLD SEED SECONDS [CHANNEL]".into()),
    };
    let mut config = SimulationConfig::new(World::open(world)?, seed.parse()?);
    config.robot_id = 4;
    config.channel = channel.parse::<ChannelSpec>()?;
    let mut simulation = Simulation::new(&config);
    let mut out = io::stdout().lock();
    // The simulated radio keeps only a few minutes of unread bytes.
    for _ in 0..seconds.parse::<u64>()? {
        simulation.run_for_ms(1000);
        let bytes: Vec<u8> = std::iter::from_fn(|| simulation.poll_downlink()).collect();
        out.write_all(&bytes)?;
    }
    Ok(())
}
