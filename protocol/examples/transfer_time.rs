//! Measures, in virtual time, how long 100 waypoints take from the order to send them until the robot
//! has proved that it holds them: session open, full duplex, no latency but the wire's, each data bit
//! flipped with a given probability in both directions.

#[path = "../tests/world/mod.rs"]
mod world;

use groundwave_protocol::arq::{FopEvent, Task};
use groundwave_protocol::command::Order;
use groundwave_protocol::letters::Mode;
use groundwave_protocol::telemetry::Outcome;
use world::{World, route};

const SEEDS: u64 = 500;

fn main() {
    println!("bit error rate   mean s   95 % within s   proved");
    for bit_error_rate in [0.0, 1e-4, 1e-3, 3e-3] {
        let mut times: Vec<f64> = (0..SEEDS)
            .filter_map(|seed| seconds(seed, bit_error_rate))
            .collect();
        times.sort_by(f64::total_cmp);
        let mean = times.iter().sum::<f64>() / times.len() as f64;
        let late = times.get(times.len() * 95 / 100).copied();
        println!(
            "{bit_error_rate:>14}   {mean:>6.2}   {:>13.2}   {:>2}/{SEEDS}",
            late.unwrap_or(f64::NAN),
            times.len(),
        );
    }
}

/// `None` when the transfer ended without proof.
fn seconds(seed: u64, bit_error_rate: f64) -> Option<f64> {
    let mut world = World::new(seed, bit_error_rate);
    world.deliver(Task::Order(Order::Mode(Mode::Reactive)));
    let begun_us = world.now_us;
    match world.deliver(Task::List(&route(seed, 100))) {
        FopEvent::Concluded {
            outcome: Outcome::Done,
            ..
        } => Some((world.now_us - begun_us) as f64 / 1e6),
        _ => None,
    }
}
