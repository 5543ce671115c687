//! Robots that drive by the ground's plans beside robots that drive by their odometer, judged by the true position: the tables of docs/acceptance.md.

use std::collections::BTreeSet;

use groundwave::model::Advise;
use groundwave::request::Request;
use groundwave_protocol::Waypoint;
use sr04_sim::{SimulationConfig, World};

use crate::advice::{Dashboard, wilson};
use crate::common::{Rng, on_all_cores};

/// Side of a square of floor, inches.
const SQUARE_IN: f64 = 12.0;

/// Clearance of a place that the robot's middle can reach, inches.
const CLEARANCE_IN: f64 = 6.0;

/// Distance from the destination that counts as there, inches.
const THERE_IN: f64 = 12.0;

/// Voltage of a half-full battery.
const SUPPLY_V: f64 = 12.4;

/// Whether the robot's middle can be at a place in the robot's coordinates.
fn is_free(world: &World, x_in: f64, y_in: f64) -> bool {
    let start = world.start();
    let (sin, cos) = start.theta_deg.to_radians().sin_cos();
    let plan = (
        start.x_in + x_in * cos + y_in * sin,
        start.y_in - x_in * sin + y_in * cos,
    );
    world.clearance_in(plan.0, plan.1) >= CLEARANCE_IN && world.has_floor(plan.0, plan.1)
}

fn middle_in((x, y): (i32, i32)) -> (f64, f64) {
    (f64::from(x) * SQUARE_IN, f64::from(y) * SQUARE_IN)
}

fn square((x_in, y_in): (f64, f64)) -> (i32, i32) {
    let round = |inches: f64| (inches / SQUARE_IN).round() as i32;
    (round(x_in), round(y_in))
}

/// Squares to whose middles a way leads from the start, over the middles of others, with the least number of steps.
fn reachable(world: &World) -> Vec<((i32, i32), usize)> {
    let mut found = vec![((0, 0), 0)];
    let mut known = BTreeSet::from([(0, 0)]);
    let mut next = 0;
    while let Some(&(at, steps)) = found.get(next) {
        next += 1;
        for (dx, dy) in [(1, 0), (-1, 0), (0, 1), (0, -1)] {
            let to = (at.0 + dx, at.1 + dy);
            let ((x, y), (to_x, to_y)) = (middle_in(at), middle_in(to));
            let is_way = [0.25, 0.5, 0.75, 1.0]
                .iter()
                .all(|part| is_free(world, x + (to_x - x) * part, y + (to_y - y) * part));
            if is_way && known.insert(to) {
                found.push((to, steps + 1));
            }
        }
    }
    found
}

/// Middles of some squares, at least this many steps from the start, inches.
fn somewhere(world: &World, seed: u64, count: usize, least_steps: usize) -> Vec<(f64, f64)> {
    let squares = reachable(world).into_iter();
    let far: Vec<_> = squares.filter(|(_, steps)| *steps >= least_steps).collect();
    let mut rng = Rng(seed);
    (0..count)
        .filter_map(|_| {
            let (square, _) = far.get(rng.below(far.len().max(1) as u64) as usize)?;
            Some(middle_in(*square))
        })
        .collect()
}

/// True distances from the last of some points after prowling for a time, inches: by the odometer, and by planned routes with `--advise=auto`. A robot
/// that has not stopped within the limit is infinitely far.
fn drive(
    world: &World,
    seed: u64,
    bit_errors: f64,
    points: &[(f64, f64)],
    prowl_s: u64,
    limit_s: u64,
) -> [f64; 2] {
    [Advise::Suggest, Advise::Auto].map(|advise| {
        let mut robot = Dashboard::new(world.clone(), seed, bit_errors, advise);
        robot.run(prowl_s);
        if advise == Advise::Auto {
            for (x_in, y_in) in points {
                robot.forget_notices();
                robot.drive_planned(&format!("plan {x_in} {y_in}"), limit_s);
            }
        } else {
            let point = |(x_in, y_in): &(f64, f64)| Waypoint {
                x_in: x_in.round() as i16,
                y_in: y_in.round() as i16,
            };
            robot
                .co
                .deliver(Request::Route(points.iter().map(point).collect()));
            robot.type_keys(":mode prowl\r");
            robot.run(20);
            robot.run_until(limit_s * points.len() as u64, Dashboard::has_stopped);
        }
        match points.last() {
            Some(point) if robot.has_stopped() => robot.distance_in(*point),
            _ => f64::INFINITY,
        }
    })
}

fn print(what: &str, ends: &[(u64, [f64; 2])]) {
    println!("{what}: {ends:.0?}");
    for by in [0, 1] {
        let mut off_in: Vec<f64> = ends.iter().map(|(_, end)| end[by]).collect();
        off_in.sort_by(f64::total_cmp);
        let count = off_in.iter().filter(|it| **it <= THERE_IN).count();
        let [share, low, high] = wilson(count, off_in.len());
        println!(
            "{}: {count} of {}, {share:.1} % ({low:.1} to {high:.1}), median {:.0} in",
            ["alone", "--advise=auto"][by],
            off_in.len(),
            off_in[off_in.len() / 2]
        );
    }
}

/// Four points anywhere in the living room, after 10 min of prowling; 10 min for each. Seeds that were not used for tuning.
#[test]
#[ignore = "takes minutes"]
fn four_points_in_the_living_room() {
    let world = World::built_in("living-room").expect("a world");
    for bit_errors in [0.0, 1e-3] {
        let ends = on_all_cores(63_000..63_030, |seed| {
            let points = somewhere(&world, seed, 4, 0);
            drive(&world, seed, bit_errors, &points, 20, 600)
        });
        print(&format!("living room, bit errors {bit_errors}"), &ends);
    }
}

/// A point at least 15 ft of way from the start of a generated house, after 20 min of prowling; 20 min for it. Seeds that were not used for tuning.
#[test]
#[ignore = "takes minutes"]
fn routes_in_generated_houses() {
    for bit_errors in [0.0, 1e-3] {
        let ends = on_all_cores(63_100..63_130, |seed| {
            let world = World::generated(seed);
            let points = somewhere(&world, seed, 1, 15);
            drive(&world, seed, bit_errors, &points, 1200, 1200)
        });
        print(&format!("generated houses, bit errors {bit_errors}"), &ends);
    }
}

/// Share of the reachable floor over which the robot's middle has been in 8 h of prowling.
#[test]
#[ignore = "takes half an hour"]
fn floor_covered_in_generated_houses() {
    let shares = on_all_cores(63_200..63_220, |seed| {
        let world = World::generated(seed);
        let floor: BTreeSet<_> = reachable(&world)
            .into_iter()
            .map(|(square, _)| square)
            .collect();
        [Advise::Suggest, Advise::Auto].map(|advise| {
            let mut house = SimulationConfig::new(world.clone(), seed);
            // A battery lasts five hours.
            house.conditions.supply_v = Some(SUPPLY_V);
            let mut robot = Dashboard::of(&house, advise);
            let mut covered = BTreeSet::new();
            for _ in 0..8 * 3600 {
                robot.run(1);
                let truth = robot.co.simulation.truth().pose;
                covered.insert(square((truth.x_in, truth.y_in)));
            }
            100.0 * floor.intersection(&covered).count() as f64 / floor.len() as f64
        })
    });
    for by in [0, 1] {
        let mut all: Vec<f64> = shares.iter().map(|(_, it)| it[by]).collect();
        all.sort_by(f64::total_cmp);
        println!(
            "{}: median {:.0} %, worst {:.0} %, {all:.0?}",
            ["alone", "--advise=auto"][by],
            all[all.len() / 2],
            all[0]
        );
    }
}
