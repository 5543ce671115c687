//! The demo's house: the robot prowls without getting stuck, and with the demo's seed it soon bumps into an obstacle.

use crate::common::{on_all_cores, seeds};
use groundwave_protocol::status_codes::Layer;
use sr04_firmware::arbiter::Holder;
use sr04_sim::{Simulation, SimulationConfig, World};

fn house(seed: u64) -> Simulation {
    let world = World::built_in("house").expect("it comes with the program");
    Simulation::new(&SimulationConfig::new(world, seed))
}

/// A robot is stuck if it moves less than 12 inches in 5 minutes in a driving mode.
#[test]
fn nineteen_of_twenty_robots_prowl_ten_minutes_without_a_stuck() {
    let stuck = on_all_cores(seeds(20), |seed| {
        let mut simulation = house(seed);
        (0..600).any(|_| {
            simulation.run_for_ms(1000);
            while simulation.poll_downlink().is_some() {}
            simulation.is_stuck()
        })
    });
    let seeds: Vec<u64> = stuck
        .iter()
        .filter(|(_, stuck)| *stuck)
        .map(|(seed, _)| *seed)
        .collect();
    println!(
        "stuck on {} of {} seeds: {seeds:?}",
        seeds.len(),
        stuck.len()
    );
    assert!(seeds.len() * 20 <= stuck.len(), "stuck on seeds {seeds:?}");
}

/// The scene of `groundwave demo` without options.
#[test]
fn the_demo_moves_at_once_and_bumps_within_ten_seconds() {
    let mut simulation = house(1);
    simulation.run_for_ms(2000);
    assert!(simulation.truth().path_in > 3.0, "{:?}", simulation.truth());
    let mut winners = vec![];
    for _ in 0..8000 {
        simulation.step();
        let holder = simulation.robot().holder();
        if winners.last() != Some(&holder) {
            winners.push(holder);
        }
    }
    assert!(
        winners.contains(&Some(Holder::Layer(Layer::Bumpers))),
        "{winners:?}"
    );
    assert!(
        winners.len() >= 3,
        "the ladder's winner hardly changes: {winners:?}"
    );
}
