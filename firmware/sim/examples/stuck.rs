//! Prints the share of runs in one world in which the robot does not get stuck, with its 95 % interval.
//!
//! `cargo run --release -p sr04-sim --example stuck [WORLD] [SEEDS] [MINUTES]`

use sr04_sim::{Simulation, SimulationConfig, World};

fn main() {
    let mut arguments = std::env::args().skip(1);
    let name = arguments.next().unwrap_or_else(|| "house".to_owned());
    let mut number = |default: u64| {
        arguments
            .next()
            .and_then(|text| text.parse().ok())
            .unwrap_or(default)
    };
    let (seeds, minutes) = (number(100), number(10));
    let world = match World::open(&name) {
        Ok(world) => world,
        Err(error) => {
            eprintln!("{error}");
            return;
        }
    };
    let mut free = 0_u64;
    let mut first_bumps_s = Vec::new();
    let mut driven_ft = 0.0;
    for seed in 1..=seeds {
        let mut simulation = Simulation::new(&SimulationConfig::new(world.clone(), seed));
        let mut first_bump_s = None;
        let mut stuck_s = None;
        for tick in 0..minutes * 60 * 20 {
            simulation.run_for_ms(50);
            let bumper = simulation.inputs().bumper;
            let now_s = tick as f64 / 20.0;
            if first_bump_s.is_none() && (bumper.left || bumper.center || bumper.right) {
                first_bump_s = Some(now_s);
            }
            if stuck_s.is_none() && simulation.is_stuck() {
                stuck_s = Some(now_s);
            }
            while simulation.poll_downlink().is_some() {}
        }
        let truth = simulation.truth();
        driven_ft += truth.path_in / 12.0;
        first_bumps_s.extend(first_bump_s);
        match stuck_s {
            None => free += 1,
            Some(now_s) => println!(
                "seed {seed}: stuck after {now_s:.0} s at X {:.0} Y {:.0}, facing {:.0}",
                truth.pose.x_in, truth.pose.y_in, truth.pose.theta_deg
            ),
        }
    }
    first_bumps_s.sort_by(f64::total_cmp);
    let (low, high) = wilson(free, seeds);
    println!(
        "{name}: {free} of {seeds} runs of {minutes} min without getting stuck, 95 % interval {:.1} to {:.1} %",
        low * 100.0,
        high * 100.0
    );
    println!(
        "{:.0} ft driven a run; first bump after {:.1} s (earliest), {:.1} s (median)",
        driven_ft / seeds as f64,
        first_bumps_s.first().unwrap_or(&f64::NAN),
        first_bumps_s
            .get(first_bumps_s.len() / 2)
            .unwrap_or(&f64::NAN),
    );
}

/// Wilson score interval of a share at 95 %.
fn wilson(successes: u64, trials: u64) -> (f64, f64) {
    let (count, share, z) = (trials as f64, successes as f64 / trials as f64, 1.96_f64);
    let middle = share + z * z / (2.0 * count);
    let half = z * (share * (1.0 - share) / count + z * z / (4.0 * count * count)).sqrt();
    let scale = 1.0 + z * z / count;
    ((middle - half) / scale, (middle + half) / scale)
}
