//! The robot never drives over an edge of the floor.

use crate::common::{Rig, parameters};
use sr04_firmware::board::Edges;
use sr04_firmware::parameters::Parameter;
use sr04_sim::World;

/// A floor of eight by eight feet surrounded by drops, with `middle` as its middle rows.
fn table(middle: &str) -> World {
    let drop = format!("{}\n", "~".repeat(24)).repeat(4);
    let floor = format!("~~~~{}~~~~\n", ".".repeat(16));
    let text = format!(
        "name = \"table\"\ncell_in = 6\nplan = '''\n{drop}{}{middle}~~~~.......^........~~~~\n{}{drop}'''\n",
        floor.repeat(8),
        floor.repeat(7),
    );
    World::parse("table", &text).expect("the table is a valid world")
}

/// Result of prowling.
#[derive(Default)]
struct Outcome {
    falls: u32,
    /// Number of times a sensor found an edge after a second without one.
    approaches: u32,
    /// Maximum distance driven toward the edge after that, inches.
    farthest_in: f64,
    path_in: f64,
}

impl Outcome {
    fn prowl(&mut self, world: &World, seed: u64, guard: i16, minutes: u32) {
        let mut rig = Rig::new(world, seed, parameters(&[(Parameter::CliffGuard, guard)]));
        let (mut floor_ticks, mut seen_at, mut forward) = (1000, None, false);
        for _ in 0..minutes * 1200 {
            rig.tick();
            let truth = rig.plant.truth();
            if truth.has_fallen {
                self.falls += 1;
                break;
            }
            let edges = rig.inputs.cliff.unwrap_or_default();
            let ahead = edges.meets(Edges::FRONT);
            if edges.any() {
                let toward = (ahead && truth.speed_in_s > 0.0)
                    || (edges.meets(Edges::REAR) && truth.speed_in_s < 0.0);
                if floor_ticks > 20 {
                    self.approaches += 1;
                    if toward {
                        forward = truth.speed_in_s > 0.0;
                        seen_at = Some(truth.path_in);
                    }
                }
                floor_ticks = 0;
            } else {
                floor_ticks += 1;
            }
            if let Some(from_in) = seen_at {
                let goes_on = truth.speed_in_s.abs() > 0.3 && (truth.speed_in_s > 0.0) == forward;
                if goes_on {
                    self.farthest_in = self.farthest_in.max(truth.path_in - from_in);
                } else {
                    seen_at = None;
                }
            }
        }
        self.path_in += rig.plant.truth().path_in;
    }
}

#[test]
fn prowling_on_a_table_never_falls_and_stops_within_an_inch() {
    // Without obstacles, and with obstacles near the edges.
    let cluttered = "~~~~.o............o.~~~~\n~~~~...o........o...~~~~\n".to_owned();
    for middle in [String::new(), cluttered] {
        let world = table(&middle);
        let mut outcome = Outcome::default();
        for seed in 1..=20 {
            outcome.prowl(&world, seed, 1, 5);
        }
        let Outcome {
            falls,
            approaches,
            farthest_in,
            ..
        } = outcome;
        assert_eq!(falls, 0);
        assert!(approaches > 500, "{approaches}");
        assert!(farthest_in <= 1.0, "{farthest_in} in");
    }
}

#[test]
fn prowling_beside_stairs_falls_only_without_the_guard() {
    let world = World::built_in("stairs").expect("the world is built in");
    let (mut guarded, mut free) = (Outcome::default(), Outcome::default());
    for seed in 1..=10 {
        guarded.prowl(&world, seed, 1, 10);
        free.prowl(&world, seed, 0, 10);
    }
    assert_eq!(guarded.falls, 0);
    assert!(free.falls >= 8, "{}", free.falls);
}

#[test]
fn backing_off_an_obstacle_stops_before_the_stairs() {
    // A shelf 18 inches deep between a low rail and the drop.
    let plan = format!(
        "{}#....^.....#\n#..........#\n#{}#\n",
        "############\n#oooooooooo#\n#..........#\n",
        "~".repeat(10)
    );
    let text = format!(
        "name = \"shelf\"\ncell_in = 6\nplan = '''\n{plan}#~~~~~~~~~~#\n#~~~~~~~~~~#\n############\n'''\n"
    );
    let world = World::parse("shelf", &text).expect("the shelf is a valid world");
    let (mut guarded, mut free) = (Outcome::default(), Outcome::default());
    for seed in 1..=20 {
        guarded.prowl(&world, seed, 1, 5);
        free.prowl(&world, seed, 0, 5);
    }
    assert_eq!((guarded.falls, free.falls), (0, 20));
    // The robot keeps moving.
    assert!(guarded.path_in > 20.0 * 100.0, "{}", guarded.path_in);
}
