//! The square of the calibration, by wheels that are not as drawn.

mod common;

use common::{Rig, hall, parameters};
use groundwave_protocol::command::Order;
use groundwave_protocol::letters::Mode;
use sr04_firmware::parameters::Parameter;
use sr04_sim::{Conditions, World};

/// Where it stands at the end of a square in truth, and by odometry.
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
    let seconds = rig.run_to(Mode::Stop, 600).expect("it ends");
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
fn with_wheels_as_drawn_it_ends_where_it_began() {
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
fn with_other_wheels_only_its_odometry_does() {
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
fn a_contact_spoils_it() {
    let world = World::built_in("house").expect("it comes with the program");
    let mut rig = Rig::new(&world, 1, parameters(&[(Parameter::Square, 400)]));
    rig.order(Order::Mode(Mode::Calibrate));
    rig.tick();
    assert!(rig.run_to(Mode::Stop, 600).is_some());
    assert!(rig.distance_in(0.0, 0.0) > 12.0);
}
