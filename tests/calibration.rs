//! Calibration by two squares finds the true wheel diameters and track of a simulated robot.

use crate::rig::{Rig, hall, parameters};
use groundwave::calibration::{Gauge, Offset, Squares};
use groundwave_protocol::command::Order;
use groundwave_protocol::status_codes::Mode;
use sr04_firmware::parameters::Parameter;
use sr04_sim::Conditions;

const SIDE_IN: i16 = 157;

/// Drives a square in mode Calibrate; returns the offset of its end, as measured.
fn drive(seed: u64, side: i16, gauge: Gauge) -> Offset {
    let tuned = parameters(&[
        (Parameter::Square, side),
        (Parameter::WheelLeft, gauge.wheel_left),
        (Parameter::WheelRight, gauge.wheel_right),
        (Parameter::Track, gauge.track),
    ]);
    let mut rig = Rig::with(&hall(), seed, tuned, &Conditions::default());
    rig.order(Order::Mode(Mode::Stop));
    rig.tick();
    rig.order(Order::Mode(Mode::Calibrate));
    rig.tick();
    rig.run_to(Mode::Stop, 600).expect("the square ends");
    rig.run_s(2);
    let (truth, believed) = (rig.plant.truth().pose, rig.robot.pose());
    Offset {
        right_in: truth.x_in - f64::from(believed.x_tenths_in()) / 10.0,
        ahead_in: truth.y_in - f64::from(believed.y_tenths_in()) / 10.0,
    }
}

#[test]
fn two_squares_reduce_the_error_to_one_per_cent_of_the_path() {
    let drawn = Gauge {
        wheel_left: 5000,
        wheel_right: 5000,
        track: 10_000,
    };
    for seed in 1..=20 {
        let squares = |gauge| Squares {
            side_in: SIDE_IN.into(),
            clockwise: drive(seed, SIDE_IN, gauge),
            counter: drive(seed, -SIDE_IN, gauge),
        };
        let before = squares(drawn);
        let gauge = before
            .correct(drawn)
            .unwrap_or_else(|error| panic!("seed {seed}: {error}"));
        let after = squares(gauge);
        assert!(after.error_share() <= 0.01, "seed {seed}: {after:?}");
        // A robot that was accurate by chance cannot get five times better: one step of a parameter moves the end by an
        // inch and a half.
        if before.error_share() > 0.01 {
            let times = before.error_in() / after.error_in();
            assert!(times >= 5.0, "seed {seed}: {times} times better");
        }
    }
}
