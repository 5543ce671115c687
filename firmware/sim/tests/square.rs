//! The calibration square, driven by wheels of other than nominal size.

use crate::common::{Rig, hall, parameters};
use groundwave_protocol::command::Order;
use groundwave_protocol::status_codes::Mode;
use sr04_firmware::parameters::Parameter;
use sr04_sim::{Conditions, World};

/// True position, odometry position and seconds at the end of a square.
fn drive(seed: u64, side: i16, ideal_wheels: bool) -> ((f64, f64), (f64, f64), f64) {
    let conditions = Conditions {
        ideal_wheels,
        ..Conditions::default()
    };
    let mut rig = Rig::with(
        &hall(),
        seed,
        parameters(&[(Parameter::Square, side)]),
        &conditions,
    );
    rig.order(Order::Mode(Mode::Stop));
    rig.tick();
    rig.order(Order::Mode(Mode::Calibrate));
    rig.tick();
    let seconds = rig.run_to(Mode::Stop, 600).expect("the square ends");
    rig.run_s(2);
    let truth = rig.plant.truth().pose;
    let pose = rig.robot.pose();
    (
        (truth.x_in, truth.y_in),
        (
            f64::from(pose.x_tenths_in()) / 10.0,
            f64::from(pose.y_tenths_in()) / 10.0,
        ),
        seconds,
    )
}

#[test]
fn square_with_nominal_wheels_ends_at_its_start() {
    for seed in 1..=3 {
        for side in [157, -157, 60] {
            let (truth, odometry, _) = drive(seed, side, true);
            assert!(truth.0.hypot(truth.1) < 0.5, "seed {seed}: {truth:?}");
            assert!(
                odometry.0.hypot(odometry.1) < 0.3,
                "seed {seed}: {odometry:?}"
            );
        }
    }
}

#[test]
fn square_with_other_wheels_ends_at_its_start_only_by_odometry() {
    let mut worst: f64 = 0.0;
    for seed in 1..=5 {
        for side in [157, -157] {
            let (truth, odometry, seconds) = drive(seed, side, false);
            worst = worst.max(truth.0.hypot(truth.1));
            assert!(
                odometry.0.hypot(odometry.1) < 0.3,
                "seed {seed}: {odometry:?}"
            );
            assert!(seconds < 150.0, "{seconds}");
        }
    }
    assert!(worst > 10.0, "{worst}");
}

#[test]
fn contact_ends_the_square_early() {
    let world = World::built_in("house").expect("the world is built in");
    let mut rig = Rig::new(&world, 1, parameters(&[(Parameter::Square, 400)]));
    rig.order(Order::Mode(Mode::Calibrate));
    rig.tick();
    assert!(rig.run_to(Mode::Stop, 600).is_some());
    assert!(rig.distance_in(0.0, 0.0) > 12.0);
}
