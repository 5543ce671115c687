//! Robots that drive by the ground's plans beside robots that drive by their odometer, judged by the true position: a table of docs/acceptance.md.

use std::collections::BTreeSet;

use groundwave::model::Advise;
use groundwave::request::Request;
use groundwave_protocol::Waypoint;
use sr04_sim::{SimulationConfig, World};

use crate::advice::{Dashboard, count_ends};
use crate::common::{Rng, on_all_cores};

/// Side of a square of floor, inches.
const SQUARE_IN: f64 = 12.0;

/// Clearance of a place that the robot's middle can reach, inches.
const CLEARANCE_IN: f64 = 6.0;

/// Distance from the destination that counts as there, inches.
const THERE_IN: f64 = 12.0;

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

/// Middles of the squares to which a way leads from the start, over the middles of others, inches.
fn reachable_in(world: &World) -> Vec<(f64, f64)> {
    let mut found = vec![(0, 0)];
    let mut known = BTreeSet::from([(0, 0)]);
    let mut next = 0;
    while let Some(&at) = found.get(next) {
        next += 1;
        for (dx, dy) in [(1, 0), (-1, 0), (0, 1), (0, -1)] {
            let to = (at.0 + dx, at.1 + dy);
            let ((x, y), (to_x, to_y)) = (middle_in(at), middle_in(to));
            let is_way = [0.25, 0.5, 0.75, 1.0]
                .iter()
                .all(|part| is_free(world, x + (to_x - x) * part, y + (to_y - y) * part));
            if is_way && known.insert(to) {
                found.push(to);
            }
        }
    }
    found.into_iter().map(middle_in).collect()
}

/// Number of points, and the limit for each, seconds.
const POINTS: u64 = 4;
const LIMIT_S: u64 = 600;

/// True distances from the last of some points, inches: of a robot that drives by its odometer, and of one with planned routes and
/// `--advise=auto`. A robot that has not stopped within the limit is infinitely far.
fn drive(world: &World, floor_in: &[(f64, f64)], seed: u64, bit_errors: f64) -> [f64; 2] {
    let mut rng = Rng(seed);
    let points =
        [(); POINTS as usize].map(|()| floor_in[rng.below(floor_in.len() as u64) as usize]);
    [Advise::Suggest, Advise::Auto].map(|advise| {
        let mut robot = Dashboard::new(world.clone(), seed, bit_errors, advise);
        robot.run(20);
        if advise == Advise::Auto {
            for (x_in, y_in) in points {
                robot.forget_notices();
                robot.drive_planned(&format!("plan {x_in} {y_in}"), LIMIT_S);
            }
        } else {
            let list = points.map(|(x_in, y_in)| Waypoint {
                x_in: x_in as i16,
                y_in: y_in as i16,
            });
            robot.co.deliver(Request::Route(list.to_vec()));
            robot.type_keys(":mode prowl\r");
            robot.run(20);
            robot.run_until(LIMIT_S * POINTS, Dashboard::has_stopped);
        }
        if robot.has_stopped() {
            robot.distance_in(points[POINTS as usize - 1])
        } else {
            f64::INFINITY
        }
    })
}

/// A point is counted from where home truly is, also when the robot believes that it is far from its true place.
#[test]
fn a_point_is_planned_in_the_frame_of_home() {
    let world = World::built_in("living-room").expect("a world");
    let mut robot = Dashboard::new(world, 61_000, 0.0, Advise::Suggest);
    robot.run(5 * 60);
    let off_in = robot.error().position_in;
    assert!(off_in > 2.0 * THERE_IN, "{off_in}");
    let [home, origin] =
        ["home", "0 0"].map(|to| robot.draft(to).replace(&format!("plan {to}"), "plan"));
    assert!(home.contains("drafted"), "{home}");
    assert_eq!(home, origin);
}

/// Points anywhere on the floor, 20 s after the start; seeds that were not used for tuning.
#[test]
#[ignore = "takes minutes"]
fn four_points_in_the_living_room() {
    let world = World::built_in("living-room").expect("a world");
    let floor_in = reachable_in(&world);
    for bit_errors in [0.0, 1e-3] {
        println!("bit errors {bit_errors}");
        let ends = on_all_cores(63_000..63_030, |seed| {
            drive(&world, &floor_in, seed, bit_errors)
        });
        count_ends(&ends, THERE_IN);
    }
}

/// Time of prowling before a route into another part of the house, and limit for that, seconds.
const PROWL_S: u64 = 20 * 60;
const ROUTE_LIMIT_S: u64 = 20 * 60;

/// Minimum distance of its destination, inches.
const ROUTE_MIN_IN: f64 = 120.0;

/// True distances from a point of the house, inches: of a robot that drives there by its odometer, and of one with planned routes and `--advise=auto`. A robot that
/// has not stopped within the limit is infinitely far.
fn drive_through_the_house(seed: u64, bit_errors: f64) -> [f64; 2] {
    let world = World::generated(seed);
    let floor_in = reachable_in(&world);
    [Advise::Suggest, Advise::Auto].map(|advise| {
        let mut robot = Dashboard::new(world.clone(), seed, bit_errors, advise);
        robot.run(PROWL_S);
        let far = |at: &&(f64, f64)| robot.distance_in(**at) >= ROUTE_MIN_IN;
        let far: Vec<_> = floor_in.iter().filter(far).collect();
        let (x_in, y_in) = *far[Rng(seed).below(far.len() as u64) as usize];
        if advise == Advise::Auto {
            robot.forget_notices();
            robot.drive_planned(&format!("plan {x_in} {y_in}"), ROUTE_LIMIT_S);
        } else {
            robot.type_keys(&format!(":goto {x_in} {y_in}\r:mode prowl\r"));
            robot.run(20);
            robot.run_until(ROUTE_LIMIT_S, Dashboard::has_stopped);
        }
        if robot.has_stopped() {
            robot.distance_in((x_in, y_in))
        } else {
            f64::INFINITY
        }
    })
}

/// Points anywhere on the floor of generated houses; seeds that were not used for tuning.
#[test]
#[ignore = "takes a quarter of an hour"]
fn routes_through_many_houses() {
    for bit_errors in [0.0, 1e-3] {
        println!("bit errors {bit_errors}");
        let ends = on_all_cores(54_100..54_130, |seed| {
            drive_through_the_house(seed, bit_errors)
        });
        count_ends(&ends, THERE_IN);
    }
}

/// Share of the floor within reach that the robot's middle has been on after a time of prowling on a supply, per cent.
fn covered_pct(seed: u64, seconds: u64, advise: Advise) -> f64 {
    let mut house = SimulationConfig::new(World::generated(seed), seed);
    house.conditions.supply_v = Some(12.4);
    let square = |place_in: f64| (place_in / SQUARE_IN).round() as i32;
    let floor_in = reachable_in(&house.world);
    let mut left: BTreeSet<_> = floor_in
        .iter()
        .map(|(x, y)| (square(*x), square(*y)))
        .collect();
    let all = left.len() as f64;
    let mut robot = Dashboard::of(&house, advise);
    for _ in 0..seconds {
        robot.run(1);
        let truth = robot.co.simulation.truth().pose;
        left.remove(&(square(truth.x_in), square(truth.y_in)));
    }
    100.0 * (1.0 - left.len() as f64 / all)
}

/// Floor covered in 8 h; seeds that were not used for tuning.
#[test]
#[ignore = "takes half an hour"]
fn floor_covered_in_many_houses() {
    for advise in [Advise::Suggest, Advise::Auto] {
        let runs = on_all_cores(54_200..54_212, |seed| covered_pct(seed, 8 * 3600, advise));
        let mut shares: Vec<f64> = runs.iter().map(|(_, share)| *share).collect();
        shares.sort_by(f64::total_cmp);
        println!(
            "{advise:?}: {shares:.0?}, median {:.1}",
            shares[shares.len() / 2]
        );
    }
}
