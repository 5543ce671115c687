//! Robots with faulty sensors.

use crate::common::{Rig, hall, parameters};
use groundwave_protocol::status_codes::Mode;
use sr04_firmware::board::Side;
use sr04_sim::{Conditions, Faults, World};

fn with(faults: Faults) -> Conditions {
    Conditions {
        faults,
        ..Conditions::default()
    }
}

#[test]
fn broken_encoder_stops_the_robot() {
    for side in [Side::Left, Side::Right] {
        for seed in 1..=4 {
            let dead = with(Faults {
                dead_encoder: Some(side),
                ..Faults::default()
            });
            let mut rig = Rig::with(&hall(), seed, parameters(&[]), &dead);
            let stopped_s = rig.run_to(Mode::Stop, 30).expect("the robot stops");
            assert!(stopped_s < 10.0, "{stopped_s} s");
            rig.run_s(1);
            assert!(rig.plant.truth().speed_in_s.abs() < 0.1);
        }
    }
}

#[test]
fn obstacles_and_worn_sensors_are_no_broken_encoder() {
    for name in ["house", "office", "living-room"] {
        let world = World::built_in(name).expect("the world is built in");
        for seed in 1..=3 {
            let mut rig = Rig::with(&world, seed, parameters(&[]), &with(Faults::WORN));
            assert_eq!(rig.run_to(Mode::Stop, 600), None, "{name} {seed}");
        }
    }
}
