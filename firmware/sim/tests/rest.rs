//! A resting robot moves for a new obstacle and for a low battery.

use crate::common::{Rig, parameters};
use groundwave_protocol::command::Order;
use groundwave_protocol::status_codes::{Layer, LayerMask, Mode};
use sr04_firmware::parameters::Parameter;
use sr04_sim::{Conditions, World};

/// A room of 20 by 20 feet with the robot in its middle. A person stands at the north end and walks up to the robot
/// after [`PAUSE_S`].
fn room() -> World {
    let wall = "#".repeat(40);
    let floor = format!("#{}#\n", ".".repeat(38));
    let start = format!("#{}^{}#\n", ".".repeat(19), ".".repeat(18));
    let plan = [
        format!("{wall}\n"),
        floor.repeat(19),
        start,
        floor.repeat(18),
        wall,
    ]
    .concat();
    let text = format!(
        "name = \"room\"\ndaylight_lux = 3\ncell_in = 6\nplan = '''\n{plan}\n'''\n[[walker]]\nkind = \"person\"\n\
         path = [[120, 225], [120, 148]]\nspeed_in_s = 40\npause_s = {PAUSE_S}\n"
    );
    World::parse("room", &text).unwrap_or_else(|error| panic!("{error}"))
}

/// Time for which the person stands before walking, seconds.
const PAUSE_S: u32 = 60;

#[test]
fn new_obstacle_moves_a_resting_robot_within_two_seconds() {
    let world = room();
    // Without the arm, which detects a distant person, and without the photocells.
    let allowed = LayerMask::ALL.without(Layer::Motion).without(Layer::Photo);
    for seed in 0..20 {
        let mut rig = Rig::new(&world, seed, parameters(&[]));
        rig.tick();
        rig.order(Order::Layers {
            which: LayerMask::ALL,
            allowed,
        });
        rig.order(Order::Mode(Mode::Reactive));
        while room_to_person_in(&rig) > NEAR_IN {
            rig.tick();
        }
        let path_in = rig.plant.truth().path_in;
        assert_eq!(rig.outputs.pwm_left, 0, "seed {seed}: the robot rests");
        rig.run_s(2);
        let truth = rig.plant.truth();
        assert!(truth.path_in > path_in + 0.5, "seed {seed}: {truth:?}");
    }
}

/// Distance from the robot's bumper to the person.
fn room_to_person_in(rig: &Rig) -> f64 {
    let (person, radius_in) = rig.plant.walkers().next().expect("the person is there");
    rig.distance_in(person.x_in, person.y_in) - radius_in - ROBOT_IN
}

/// Distance from the robot's centre to its bumper.
const ROBOT_IN: f64 = 7.0;

/// Distance at which sonar, and soon infrared, detects an obstacle, inches.
const NEAR_IN: f64 = 48.0;

#[test]
fn low_battery_sends_the_robot_to_its_dock_and_back() {
    let world = World::built_in("flat").expect("the world is built in");
    for seed in 1..=2 {
        let conditions = Conditions {
            charge: 0.85,
            ..Conditions::default()
        };
        // A high threshold keeps the charging time short.
        let forages = parameters(&[(Parameter::Forage, 1), (Parameter::LowBattery, 125)]);
        let mut rig = Rig::with(&world, seed, forages, &conditions);
        let begun_s = rig.run_to(Mode::Forage, 3600);
        assert!(begun_s.is_some(), "seed {seed}: the battery becomes low");
        let docks = (0..20 * 1200).any(|_| {
            rig.tick();
            rig.inputs.is_docked
        });
        assert!(docks, "seed {seed}: {:?}", rig.plant.truth());
        assert!(rig.run_to(Mode::Prowl, 8 * 3600).is_some(), "seed {seed}");
        let truth = rig.plant.truth();
        assert!(
            truth.charge > 0.9 && !truth.is_docked,
            "seed {seed}: {truth:?}"
        );
        let before_in = truth.path_in;
        rig.run_s(60);
        assert!(
            rig.plant.truth().path_in > before_in + 60.0,
            "seed {seed}: the robot continues"
        );
    }
}
