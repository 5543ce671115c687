//! The maps against the true walls of simulated houses.

mod outlines;

use std::collections::BTreeSet;
use std::time::Duration;

use groundwave_mapping::{DriveMap, FloorCell, LocalMap, Mapper, NoMap};
use groundwave_protocol::decoder::{Decoder, Received};
use groundwave_protocol::telemetry::{Body, StateLine};
use outlines::{FOUND_IN, Fit, Place, along, distance_in, edges};
use sr04_sim::{Outline, Pose, Simulation, SimulationConfig, World};

/// Distance from the robot within which walls count, inches.
const NEAR_IN: f64 = 72.0;

/// Steps of the shifts that are tried for a map laid over the true one: 48 in, and finer ones around them.
const FIT_STEPS: i32 = 8;

/// Time of a line on the air: its pose is older by this when it ends.
const LINE_MS: u64 = 350;

/// Counts over all moments.
#[derive(Clone, Copy, Debug, Default)]
struct Score {
    cells: u32,
    invented: u32,
    walls: u32,
    found: u32,
}

impl Score {
    fn invented(self) -> f64 {
        f64::from(self.invented) / f64::from(self.cells)
    }

    fn found(self) -> f64 {
        f64::from(self.found) / f64::from(self.walls)
    }

    fn add(&mut self, other: Self) {
        self.cells += other.cells;
        self.invented += other.invented;
        self.walls += other.walls;
        self.found += other.found;
    }
}

/// Compares the maps of houses every 20 s for 10 min.
fn score(seeds: std::ops::Range<u64>) -> Score {
    let mut score = Score::default();
    for seed in seeds {
        let config = SimulationConfig::new(World::generated(seed), seed);
        let mut simulation = Simulation::new(&config);
        let mut decoder = Decoder::default();
        let (mut map, mut poses) = (LocalMap::default(), Vec::new());
        let mut last = None;
        for ms in 0..600_000_u64 {
            simulation.step();
            poses.push(simulation.truth().pose);
            while let Some(byte) = simulation.poll_downlink() {
                if let Some(Received::Line(line, _)) = decoder.lines(&[byte]).next()
                    && let Body::State(state) = line.body
                {
                    map.take(&state);
                    last = Some((state, ms));
                }
            }
            if ms % 20_000 == 19_999
                && let Some((state, ms)) = last
            {
                let truth = poses[(ms - LINE_MS) as usize];
                compare(&mut score, &map, &state, truth, simulation.outlines());
            }
        }
    }
    score
}

fn compare(
    score: &mut Score,
    map: &LocalMap,
    state: &StateLine,
    truth: Pose,
    outlines: &[Outline],
) {
    let here = (
        f64::from(state.x_tenths_in) / 10.0,
        f64::from(state.y_tenths_in) / 10.0,
    );
    let turn_rad = (truth.theta_deg - f64::from(state.theta_deg)).to_radians();
    let cells: Vec<Place> = map
        .obstacles()
        .map(|[(west, south), (east, north)]| {
            let (x, y) = (
                f64::midpoint(west, east) - here.0,
                f64::midpoint(south, north) - here.1,
            );
            let (sin, cos) = turn_rad.sin_cos();
            (
                truth.x_in + x * cos + y * sin,
                truth.y_in - x * sin + y * cos,
            )
        })
        .filter(|cell| distance_in(*cell, (truth.x_in, truth.y_in)) < NEAR_IN)
        .collect();
    let robot = (truth.x_in, truth.y_in);
    let edges = edges(outlines);
    let surfaces: Vec<Place> = edges
        .iter()
        .flat_map(|edge| along(*edge))
        .filter(|place| distance_in(*place, robot) < NEAR_IN + FOUND_IN)
        .collect();
    let in_sight: Vec<Place> = surfaces
        .iter()
        .copied()
        .filter(|place| is_in_sight(robot, *place, &edges))
        .collect();
    score.cells += cells.len() as u32;
    score.invented += cells
        .iter()
        .filter(|cell| !is_near(**cell, &surfaces))
        .count() as u32;
    score.walls += in_sight.len() as u32;
    score.found += in_sight
        .iter()
        .filter(|wall| is_near(**wall, &cells))
        .count() as u32;
}

fn is_near(place: Place, places: &[Place]) -> bool {
    places
        .iter()
        .any(|other| distance_in(place, *other) < FOUND_IN)
}

/// A robot in a generated house, what the ground maps of it, and the true surfaces that the robot has passed.
struct Tour {
    simulation: Simulation,
    decoder: Decoder,
    mapper: Mapper,
    /// Whether lines are lost.
    is_deaf: bool,
    ms: u64,
    edges: Vec<[Place; 2]>,
    surfaces: Vec<Place>,
    /// Numbers of the surfaces that were in sight and near.
    passed: BTreeSet<usize>,
}

impl Tour {
    fn new(seed: u64) -> Self {
        let simulation = Simulation::new(&SimulationConfig::new(World::generated(seed), seed));
        let edges = edges(simulation.outlines());
        Self {
            simulation,
            decoder: Decoder::default(),
            mapper: Mapper::default(),
            is_deaf: false,
            ms: 0,
            surfaces: edges.iter().flat_map(|edge| along(*edge)).collect(),
            edges,
            passed: BTreeSet::new(),
        }
    }

    fn until(&mut self, minutes: u64) {
        while self.ms < minutes * 60_000 {
            self.simulation.step();
            while let Some(byte) = self.simulation.poll_downlink() {
                let received = self.decoder.lines(&[byte]).next();
                if let Some(Received::Line(line, _)) = received
                    && !self.is_deaf
                {
                    self.mapper
                        .handle_line(Duration::from_millis(self.ms), &line);
                }
            }
            if self.ms.is_multiple_of(20_000) {
                let pose = self.simulation.truth().pose;
                let robot = (pose.x_in, pose.y_in);
                let surfaces = self.surfaces.iter().enumerate();
                self.passed.extend(
                    surfaces
                        .filter(|(_, place)| {
                            distance_in(**place, robot) < NEAR_IN
                                && is_in_sight(robot, **place, &self.edges)
                        })
                        .map(|(at, _)| at),
                );
            }
            self.ms += 1;
        }
    }

    /// The map in the frame of the pose that was set, and the same map laid over the true one.
    fn scores(&self) -> [Score; 2] {
        let made = self.mapper.clone().finish();
        let map = made.iter().map(|made| &made.map);
        let cells: Vec<Place> = map
            .flat_map(|map| map.middles_in(FloorCell::Obstacle))
            .collect();
        let fit = Fit::best(&cells, &self.surfaces, FIT_STEPS);
        let laid: Vec<Place> = cells.iter().map(|cell| fit.true_place(*cell)).collect();
        [&cells, &laid].map(|cells| {
            let passed = self.passed.iter().map(|at| self.surfaces[*at]);
            let invented = cells.iter().filter(|cell| !is_near(**cell, &self.surfaces));
            Score {
                cells: cells.len() as u32,
                invented: invented.count() as u32,
                walls: self.passed.len() as u32,
                found: passed.filter(|wall| is_near(*wall, cells)).count() as u32,
            }
        })
    }
}

/// The figures of docs/acceptance.md, of houses that were not used for tuning.
#[test]
#[ignore = "simulates days"]
fn floor_maps_of_many_houses() {
    for (houses, times_min) in [(24, [10, 60]), (4, [60, 480])] {
        let mut sums = [[Score::default(); 2]; 2];
        for seed in 52_000..52_000 + houses {
            let mut tour = Tour::new(seed);
            for (minutes, sums) in times_min.into_iter().zip(&mut sums) {
                tour.until(minutes);
                let (made, scores) = (tour.mapper.clone().finish(), tour.scores());
                let end = made.as_ref().map(|made| made.until);
                println!("{seed}, {minutes} min: up to {end:?}, {scores:?}");
                for (sum, score) in sums.iter_mut().zip(scores) {
                    sum.add(score);
                }
            }
        }
        for (minutes, sums) in times_min.into_iter().zip(sums) {
            for (frame, sum) in ["as it is", "laid over"].iter().zip(sums) {
                println!(
                    "{houses} houses, {minutes} min, {frame}: invented {:.3}, found {:.3}",
                    sum.invented(),
                    sum.found()
                );
            }
        }
    }
}

/// After an outage the heading is not known: the map ends before it.
#[test]
fn map_ends_where_the_heading_is_not_known_well() {
    let mut tour = Tour::new(52_100);
    assert_eq!(tour.mapper.clone().finish(), Err(NoMap::NoPose));
    tour.until(10);
    let before = tour.mapper.clone().finish().expect("a map");
    assert_eq!((before.until, tour.mapper.since()), (None, None));
    tour.is_deaf = true;
    tour.until(20);
    tour.is_deaf = false;
    tour.until(21);
    let after = tour.mapper.clone().finish().expect("a map");
    let until = after.until.expect("an end").as_secs();
    assert!((598..=600).contains(&until), "{until}");
    assert!(after.map.cells.len() <= before.map.cells.len());
}

/// Maps of half an hour, laid over the true ones, have most walls.
#[test]
fn walls_of_houses_are_in_their_floor_maps() {
    let mut sum = Score::default();
    for seed in 52_100..52_104 {
        let mut tour = Tour::new(seed);
        tour.until(30);
        let [_, laid] = tour.scores();
        sum.add(laid);
    }
    let (invented, found) = (sum.invented(), sum.found());
    assert!(invented < 0.4 && found > 0.5, "{invented:.3}, {found:.3}");
}

/// Whether no edge is between two places.
fn is_in_sight(from: Place, to: Place, edges: &[[Place; 2]]) -> bool {
    // The edge on which the place is does not hide it.
    let near = 1.0 - 1.0 / distance_in(from, to).max(1.0);
    let sight = ((to.0 - from.0) * near, (to.1 - from.1) * near);
    let cross = |a: Place, b: Place| a.0 * b.1 - a.1 * b.0;
    !edges.iter().any(|[one, other]| {
        let edge = (other.0 - one.0, other.1 - one.1);
        let offset = (one.0 - from.0, one.1 - from.1);
        let both = cross(sight, edge);
        let (at, on) = (cross(offset, edge) / both, cross(offset, sight) / both);
        (0.0..1.0).contains(&at) && (0.0..1.0).contains(&on)
    })
}

/// The houses are not among those on which the models were tuned (seeds below 10,000).
#[test]
fn obstacles_stand_where_walls_and_furniture_do() {
    let score = score(20_000..20_008);
    let (invented, found) = (score.invented(), score.found());
    println!("invented {invented:.3}, found {found:.3}: {score:?}");
    assert!(invented < 0.2 && found > 0.3, "{invented:.3}, {found:.3}");
}

/// The map of a drive keeps what a local map held at its start and forgot, and what it holds at the end.
#[test]
fn the_map_of_a_drive_forgets_nothing() {
    let mut simulation = Simulation::new(&SimulationConfig::new(World::generated(20_001), 1));
    let (mut decoder, mut local, mut drive) =
        (Decoder::default(), LocalMap::default(), DriveMap::default());
    let middles = |map: &LocalMap| -> Vec<Place> {
        let corners = map.obstacles();
        corners.map(|[(x, y), _]| (x + 1.5, y + 1.5)).collect()
    };
    let (mut first, mut driven_in, mut last) = (Vec::new(), 0.0, None);
    for _ in 0..300_000 {
        simulation.step();
        while let Some(byte) = simulation.poll_downlink() {
            if let Some(Received::Line(line, _)) = decoder.lines(&[byte]).next()
                && let Body::State(state) = line.body
            {
                local.take(&state);
                drive.take(&state);
                let here = (f64::from(state.x_tenths_in), f64::from(state.y_tenths_in));
                driven_in += last
                    .replace(here)
                    .map_or(0.0, |last| distance_in(here, last))
                    / 10.0;
                if first.is_empty() && driven_in > 155.0 {
                    first = middles(&local);
                }
            }
        }
    }
    let forgotten = first
        .iter()
        .filter(|place| !middles(&local).contains(place));
    assert!(driven_in > 700.0 && forgotten.count() > 10, "{driven_in}");
    let obstacles = drive.into_obstacles();
    for (x, y) in middles(&local) {
        let holds = |[low, high]: &[Place; 2]| low.0 < x && x < high.0 && low.1 < y && y < high.1;
        assert_eq!(
            obstacles.iter().filter(|it| holds(it)).count(),
            1,
            "({x}, {y})"
        );
    }
    let kept = first.iter().filter(|(x, y)| {
        obstacles
            .iter()
            .any(|[low, high]| low.0 < *x && *x < high.0 && low.1 < *y && *y < high.1)
    });
    // The first obstacles were taken at 150 in, a few inches earlier.
    assert!(kept.count() * 10 > first.len() * 9);
}
