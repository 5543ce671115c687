//! Maps of several runs against the true places of the runs in simulated houses.

mod outlines;

use std::collections::BTreeSet;
use std::thread;
use std::time::Duration;

use groundwave_mapping::{FloorCell, HouseMap, Mapper, NoPlace, Placement, SessionMap};
use groundwave_protocol::decoder::{Decoder, Received};
use outlines::{Fit, Place, along, distance_in, edges};
use sr04_sim::{Pose, Simulation, SimulationConfig, World};

/// Steps of the shifts that are tried for the true place of a map: 120 in.
const FIT_STEPS: i32 = 20;

/// Side of the squares in which a run counts as having been, inches.
const SQUARE_IN: f64 = 24.0;

/// Greatest error of a run's place at the middle of the overlap, inches.
const RIGHT_IN: f64 = 24.0;

/// A run, what it mapped, and the truth.
struct Run {
    /// Start pose on the plan.
    start: Pose,
    made: Option<SessionMap>,
    surfaces: Vec<Place>,
    /// Squares of the plan in which the robot was.
    squares: BTreeSet<(i32, i32)>,
}

/// A place in the frame of a start pose, on the plan.
fn on_plan(start: Pose, (x_in, y_in): Place) -> Place {
    let (sin, cos) = start.theta_deg.to_radians().sin_cos();
    (
        start.x_in + x_in * cos + y_in * sin,
        start.y_in + y_in * cos - x_in * sin,
    )
}

/// The same house, with the start where another robot is after 10 min.
fn started_elsewhere(world: &World, seed: u64) -> World {
    let mut simulation = Simulation::new(&SimulationConfig::new(world.clone(), seed));
    let mut poses = Vec::new();
    for _ in 0..600 {
        simulation.run_for_ms(1000);
        poses.push(simulation.truth().pose);
    }
    let start = world.start();
    let starts = poses.iter().rev().map(|pose| {
        let (x_in, y_in) = on_plan(start, (pose.x_in, pose.y_in));
        Pose {
            x_in,
            y_in,
            theta_deg: start.theta_deg + pose.theta_deg,
        }
    });
    let mut worlds = starts.filter_map(|start| world.started_at(start));
    worlds.next().expect("a place where the robot fits")
}

impl Run {
    /// The run after each of some times, minutes.
    fn all(world: &World, seed: u64, times_min: &[u64]) -> Vec<Self> {
        let start = world.start();
        let mut simulation = Simulation::new(&SimulationConfig::new(world.clone(), seed));
        let surfaces: Vec<Place> = edges(simulation.outlines())
            .iter()
            .flat_map(|edge| along(*edge))
            .collect();
        let (mut decoder, mut mapper) = (Decoder::default(), Mapper::default());
        let mut squares = BTreeSet::new();
        let mut runs = Vec::new();
        for minutes in times_min {
            while simulation.now_ms() < minutes * 60_000 {
                simulation.step();
                while let Some(byte) = simulation.poll_downlink() {
                    if let Some(Received::Line(line, _)) = decoder.lines(&[byte]).next() {
                        mapper.handle_line(Duration::from_millis(simulation.now_ms()), &line);
                    }
                }
                if simulation.now_ms().is_multiple_of(1000) {
                    let pose = simulation.truth().pose;
                    let (x, y) = on_plan(start, (pose.x_in, pose.y_in));
                    squares.insert(((x / SQUARE_IN) as i32, (y / SQUARE_IN) as i32));
                }
            }
            runs.push(Self {
                start,
                made: mapper.clone().finish().ok(),
                surfaces: surfaces.clone(),
                squares: squares.clone(),
            });
        }
        runs
    }

    /// Two runs in a house, each after some times.
    fn pairs(seed: u64, times_min: &[u64]) -> Vec<[Self; 2]> {
        let world = World::generated(seed);
        let second = started_elsewhere(&world, seed + 2_000_000);
        let firsts = Self::all(&world, seed, times_min);
        let seconds = Self::all(&second, seed + 1_000_000, times_min);
        let pairs = firsts.into_iter().zip(seconds);
        pairs.map(|(first, second)| [first, second]).collect()
    }

    fn add_to(&self, first: &Self) -> Option<Result<Placement, NoPlace>> {
        let mut house = HouseMap::new(first.made.as_ref()?);
        Some(house.add(self.made.as_ref()?))
    }

    /// Lays the map over the true one.
    fn fit(&self) -> Option<Fit> {
        let map = &self.made.as_ref()?.map;
        let cells: Vec<Place> = map.middles_in(FloorCell::Obstacle).collect();
        Some(Fit::best(&cells, &self.surfaces, FIT_STEPS))
    }
}

/// Error of the second run's place at the middle of the floor on which both runs were, inches; `None` for a wrong quarter turn, and
/// without such a floor.
fn error_in([first, second]: &[Run; 2], placement: Placement) -> Option<f64> {
    let turn_deg = second.start.theta_deg - first.start.theta_deg - placement.turn_deg;
    let off_deg = (turn_deg + 180.0).rem_euclid(360.0) - 180.0;
    let both: Vec<_> = first.squares.intersection(&second.squares).collect();
    if off_deg.abs() > 45.0 || both.is_empty() {
        return None;
    }
    let mean = |sum: i32| (f64::from(sum) / both.len() as f64 + 0.5) * SQUARE_IN;
    let middle = (
        mean(both.iter().map(|square| square.0).sum()),
        mean(both.iter().map(|square| square.1).sum()),
    );
    let (of_first, of_second) = (first.fit()?, second.fit()?);
    // The place on the second map that is truly in the middle.
    let of_map = Pose {
        x_in: of_second.shift_in.0,
        y_in: of_second.shift_in.1,
        theta_deg: f64::from(of_second.turn_deg),
    };
    let on_first = placement.on_map(from_plan(of_map, from_plan(second.start, middle)));
    let found = on_plan(first.start, of_first.true_place(on_first));
    Some(distance_in(found, middle))
}

/// A place of the plan, in the frame of a start pose.
fn from_plan(start: Pose, (x_in, y_in): Place) -> Place {
    let (sin, cos) = start.theta_deg.to_radians().sin_cos();
    let (x, y) = (x_in - start.x_in, y_in - start.y_in);
    (x * cos - y * sin, x * sin + y * cos)
}

/// 95 % interval of a share (Wilson).
fn interval(count: usize, of: usize) -> String {
    let (n, p, z) = (of as f64, count as f64 / of as f64, 1.96_f64);
    let middle = (p + z * z / (2.0 * n)) / (1.0 + z * z / n);
    let half = z / (1.0 + z * z / n) * (p * (1.0 - p) / n + z * z / (4.0 * n * n)).sqrt();
    format!(
        "{count} of {of}: {:.1} % ({:.1} to {:.1})",
        p * 100.0,
        (middle - half).max(0.0) * 100.0,
        (middle + half) * 100.0
    )
}

/// The figures of docs/acceptance.md, of houses that were not used for tuning.
#[test]
#[ignore = "simulates days"]
fn runs_on_one_map() {
    const HOUSES: u64 = 120;
    const OTHERS: usize = 20;
    let times_min = [10, 20];
    let half = |from: u64| {
        move || -> Vec<_> {
            (from..from + HOUSES / 2)
                .map(|seed| (seed, Run::pairs(seed, &times_min)))
                .collect()
        }
    };
    let houses: Vec<(u64, Vec<[Run; 2]>)> = thread::scope(|scope| {
        let halves = [53_000, 53_000 + HOUSES / 2].map(|from| scope.spawn(half(from)));
        let houses = halves
            .into_iter()
            .flat_map(|half| half.join().expect("runs"));
        houses.collect()
    });
    for (at, minutes) in times_min.iter().enumerate() {
        let (mut mapped, mut placed, mut right, mut others, mut wrong) = (0, 0, 0, 0, 0);
        for (number, (seed, pairs)) in houses.iter().enumerate() {
            let pair = &pairs[at];
            for step in 1..=OTHERS {
                let other = &houses[(number + step) % houses.len()].1[at][1];
                if let Some(result) = other.add_to(&pair[0]) {
                    others += 1;
                    wrong += usize::from(result.is_ok());
                }
            }
            let Some(result) = pair[1].add_to(&pair[0]) else {
                continue;
            };
            mapped += 1;
            if let Ok(placement) = result {
                placed += 1;
                let error = error_in(pair, placement);
                right += usize::from(error.is_some_and(|error| error <= RIGHT_IN));
                println!("{seed}, {minutes} min: off by {error:?} in");
            } else {
                println!("{seed}, {minutes} min: {result:?}");
            }
        }
        println!("{minutes} min, placed: {}", interval(placed, mapped));
        println!("{minutes} min, right: {}", interval(right, placed));
        println!("{minutes} min, other houses: {}", interval(wrong, others));
    }
}

/// Two runs in one house make one map; a run in another house is left out.
#[test]
fn run_in_the_same_house_is_added_and_another_is_left_out() {
    let pair = Run::pairs(SAME, &[20]).remove(0);
    let other = Run::pairs(OTHER, &[20]).remove(0);
    let made = |run: &Run| run.made.clone().expect("a map");
    let mut house = HouseMap::new(&made(&pair[0]));
    let alone = house.floor_map().clone();
    assert_eq!(&made(&pair[0]).map, &alone);
    for run in &other {
        assert!(house.add(&made(run)).is_err());
        assert_eq!(house.floor_map(), &alone);
    }
    let placement = house.add(&made(&pair[1])).expect("a place");
    let error_in = error_in(&pair, placement).expect("a true quarter turn");
    assert!(error_in < RIGHT_IN, "{error_in}");
    let free = |map: &groundwave_mapping::FloorMap| map.middles_in(FloorCell::Free).count();
    assert!(free(house.floor_map()) > free(&alone));
    // The home of the second run was driven over.
    let (x, y) = placement.shift_in;
    let home = house
        .floor_map()
        .middles_in(FloorCell::Free)
        .any(|(fx, fy)| (fx - x).hypot(fy - y) < 6.0);
    assert!(home, "{placement:?}");
}

/// Houses of the test above.
const SAME: u64 = 53_000;
const OTHER: u64 = 53_001;
