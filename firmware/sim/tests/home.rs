//! Wandering and going home.

use crate::common::{Rig, parameters};
use groundwave_protocol::Waypoint;
use groundwave_protocol::command::Order;
use groundwave_protocol::status_codes::Mode;
use sr04_firmware::parameters::Parameter;
use sr04_sim::World;

/// Two rooms side by side with two doors between them. The robot stands in the right one and its origin is in the
/// left one, so that a wall blocks the straight path home.
fn two_rooms() -> World {
    let mut rows = vec!["#".repeat(42)];
    for row in 0..30 {
        let wall = if (3..8).contains(&row) || (23..28).contains(&row) {
            '.'
        } else {
            '#'
        };
        let start = if row == 15 { '^' } else { '.' };
        rows.push(format!(
            "#{}{wall}{}{start}{}#",
            ".".repeat(20),
            ".".repeat(9),
            ".".repeat(9)
        ));
    }
    rows.push("#".repeat(42));
    let text = format!(
        "name = \"rooms\"\ncell_in = 6\nplan = '''\n{}\n'''\n",
        rows.join("\n")
    );
    World::parse("rooms", &text).expect("the rooms are a valid world")
}

fn go_home(world: &World, seed: u64, at: (i16, i16), seconds: u32) -> Option<f64> {
    let mut rig = Rig::new(world, seed, parameters(&[]));
    let position = Waypoint::new(at.0, at.1).expect("the position is in range");
    rig.order(Order::Pose {
        position,
        theta_deg: 0,
    });
    rig.order(Order::Mode(Mode::GoHome));
    rig.tick();
    rig.run_to(Mode::Stop, seconds)
}

#[test]
fn robot_finds_a_door_when_the_straight_path_home_is_blocked() {
    let world = two_rooms();
    let home = (1..=20).filter(|&seed| go_home(&world, seed, (120, 0), 600).is_some());
    assert!(home.count() >= 16);
}

#[test]
fn wandering_ends_on_time_with_an_alarm_and_the_drive_home() {
    let world = World::built_in("living-room").expect("the world is built in");
    for seed in 1..=5 {
        let mut rig = Rig::new(&world, seed, parameters(&[(Parameter::Wander, 60)]));
        rig.order(Order::Mode(Mode::Wander));
        for tick in 1..=60 * 20 {
            rig.tick();
            assert_eq!(rig.robot.mode(), Mode::Wander, "tick {tick}");
        }
        assert!(rig.plant.truth().path_in > 100.0, "the robot wanders");
        rig.tick();
        assert_eq!(rig.robot.mode(), Mode::GoHome);
        assert!(rig.outputs.note_hz > 0, "the alarm sounds");
        assert!(rig.run_to(Mode::Stop, 600).is_some(), "seed {seed}");
    }
}
