//! The compass against the true pose of robots in simulated houses, over a radio with bit errors.

use std::time::Duration;

use groundwave_mapping::{Compass, CorrectedPose};
use groundwave_protocol::decoder::{Decoder, Received};
use groundwave_protocol::status_codes::{Bump, Drive, LayerMask};
use groundwave_protocol::telemetry::{Ack, Body, Line, ListPlace, StateLine, StatusLine};
use sr04_sim::{Pose, Simulation, SimulationConfig, World};

/// Time of a line on the air: its pose is older by this when it ends.
const LINE_MS: usize = 350;

/// Share of bits that flip: half of the lines are lost.
const BIT_ERRORS: f64 = 1e-3;

/// A line A's statement beside the truth.
struct Moment {
    truth: Pose,
    odometer: Pose,
    stated: Option<CorrectedPose>,
}

impl Moment {
    fn heading_error_deg(&self) -> Option<f64> {
        let stated = self.stated?.theta_deg;
        Some(turn_deg(self.truth.theta_deg, stated.value).abs())
    }

    fn is_heading_inside(&self) -> bool {
        self.heading_error_deg()
            .zip(self.stated)
            .is_some_and(|(error, stated)| error <= stated.theta_deg.half)
    }

    fn is_position_inside(&self) -> bool {
        self.stated.is_some_and(|stated| {
            let (x, y) = (self.truth.x_in - stated.x_in, self.truth.y_in - stated.y_in);
            let (sin, cos) = stated.ellipse.bearing_deg.to_radians().sin_cos();
            let along = (x * sin + y * cos) / stated.ellipse.long_in.max(1.0);
            let across = (x * cos - y * sin) / stated.ellipse.short_in.max(1.0);
            along.hypot(across) <= 1.0
        })
    }
}

fn turn_deg(from: f64, to: f64) -> f64 {
    (to - from + 540.0).rem_euclid(360.0) - 180.0
}

fn drive(simulation: &mut Simulation, compass: &mut Compass, minutes: u64) -> Vec<Moment> {
    let mut decoder = Decoder::default();
    let (mut poses, mut moments) = (Vec::new(), Vec::new());
    for _ in 0..minutes * 60_000 {
        simulation.step();
        poses.push(simulation.truth().pose);
        while let Some(byte) = simulation.poll_downlink() {
            let Some(Received::Line(line, _)) = decoder.lines(&[byte]).next() else {
                continue;
            };
            compass.handle_line(Duration::from_millis(simulation.now_ms()), &line);
            assert!(!compass.is_lifted(), "{:?}", simulation.truth());
            if let Body::State(state) = line.body {
                moments.push(Moment {
                    truth: poses[poses.len().saturating_sub(LINE_MS + 1)],
                    odometer: Pose {
                        x_in: f64::from(state.x_tenths_in) / 10.0,
                        y_in: f64::from(state.y_tenths_in) / 10.0,
                        theta_deg: f64::from(state.theta_deg),
                    },
                    stated: compass.pose(),
                });
            }
        }
    }
    moments
}

fn line(body: Body) -> Line {
    Line {
        sequence: 0,
        body,
        ack: Ack::default(),
    }
}

fn blank_status() -> StatusLine {
    StatusLine {
        robot_id: 1,
        battery_dv: 124,
        target_in: None,
        list: ListPlace::default(),
        digest: 0,
        max_count: 12,
        photo_left: None,
        photo_right: None,
        fitted: LayerMask::NONE,
        allowed: LayerMask::NONE,
        boots: 1,
        odometer_resets: 0,
    }
}

fn house(seed: u64) -> SimulationConfig {
    let mut config = SimulationConfig::new(World::generated(seed), seed);
    config.channel.ber = BIT_ERRORS;
    config
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn share(moments: &[Moment], is_so: impl Fn(&Moment) -> bool) -> f64 {
    moments.iter().filter(|moment| is_so(moment)).count() as f64 / moments.len() as f64
}

/// The houses are not among those on which the constants were chosen (seeds below 10,000).
#[test]
fn statement_holds_and_beats_the_odometer() {
    let mut all = Vec::new();
    for seed in 20_100..20_110 {
        let mut simulation = Simulation::new(&house(seed));
        all.extend(drive(&mut simulation, &mut Compass::default(), 20));
    }
    let odometer_deg = |m: &Moment| turn_deg(m.truth.theta_deg, m.odometer.theta_deg).abs();
    let corrected = median(all.iter().filter_map(Moment::heading_error_deg).collect());
    let odometer = median(all.iter().map(odometer_deg).collect());
    let (heading, position) = (
        share(&all, Moment::is_heading_inside),
        share(&all, Moment::is_position_inside),
    );
    println!(
        "corrected {corrected:.1}, odometer {odometer:.1}, inside {heading:.3} and {position:.3}"
    );
    assert!(
        heading >= 0.9 && position >= 0.9,
        "{heading:.3}, {position:.3}"
    );
    assert!(
        corrected < odometer / 3.0,
        "{corrected:.1} of {odometer:.1}"
    );
}

/// Houses without bit errors, which were not used for tuning. Without matches, the median error is 28 in, in
/// ellipses of 109 in.
#[test]
fn position_is_matched_with_the_walls_of_the_house() {
    let mut all = Vec::new();
    for seed in 4_100..4_106 {
        let mut config = house(seed);
        config.channel.ber = 0.0;
        let mut simulation = Simulation::new(&config);
        all.extend(drive(&mut simulation, &mut Compass::default(), 40));
    }
    let off_in = |m: &Moment| {
        let stated = m.stated?;
        Some((m.truth.x_in - stated.x_in).hypot(m.truth.y_in - stated.y_in))
    };
    let odometer_in =
        |m: &Moment| (m.truth.x_in - m.odometer.x_in).hypot(m.truth.y_in - m.odometer.y_in);
    let long_in = |m: &Moment| Some(m.stated?.ellipse.long_in);
    let stated = median(all.iter().filter_map(off_in).collect());
    let odometer = median(all.iter().map(odometer_in).collect());
    let long = median(all.iter().filter_map(long_in).collect());
    let inside = share(&all, Moment::is_position_inside);
    println!("stated {stated:.1}, odometer {odometer:.1}, ellipse {long:.1}, inside {inside:.3}");
    assert!(inside >= 0.9, "{inside:.3}");
    assert!(stated < 20.0 && long < 80.0, "{stated:.1}, {long:.1}");
}

#[test]
fn unequal_wheels_are_found() {
    let per_in_deg = |moments: &[Moment]| {
        // The growth by truth, over stretches without a slip.
        let (mut products, mut squares) = (0.0, 0.0);
        for pair in moments.windows(2) {
            let (from, to) = (&pair[0], &pair[1]);
            let turned = turn_deg(from.odometer.theta_deg, to.odometer.theta_deg);
            let grown = turn_deg(turned, turn_deg(from.truth.theta_deg, to.truth.theta_deg));
            let middle = (from.odometer.theta_deg + turned / 2.0).to_radians();
            let (x, y) = (
                to.odometer.x_in - from.odometer.x_in,
                to.odometer.y_in - from.odometer.y_in,
            );
            let path_in = x * middle.sin() + y * middle.cos();
            if path_in > 3.0 && turned.abs() < 5.0 && grown.abs() < 3.0 {
                products += path_in * grown;
                squares += path_in * path_in;
            }
        }
        products / squares
    };
    let (mut inside, seeds) = (0, 20_120..20_128);
    for seed in seeds.clone() {
        let mut simulation = Simulation::new(&house(seed));
        let mut compass = Compass::default();
        let truth = per_in_deg(&drive(&mut simulation, &mut compass, 20));
        let stated = compass.growth_deg_per_in();
        println!(
            "{seed}: {truth:.4}, stated {:.4} within {:.4}",
            stated.value, stated.half
        );
        assert!(stated.half < 0.03, "{stated:?}");
        inside += usize::from((stated.value - truth).abs() <= stated.half);
    }
    assert!(inside >= seeds.count() - 1, "{inside}");
}

/// A pose of the robot that was taken from the statement is no more certain than the statement.
#[test]
fn stated_pose_keeps_its_uncertainty_and_another_is_taken_as_true() {
    let mut simulation = Simulation::new(&house(20_142));
    let mut compass = Compass::default();
    drive(&mut simulation, &mut compass, 6);
    let before = compass.pose().expect("a pose");
    let error = compass.heading_error_deg().expect("a heading");
    assert!(
        before.theta_deg.half > 1.0 && before.ellipse.long_in > 1.0,
        "{before:?}"
    );
    assert!(error.value.abs() > 2.0, "{error:?}");

    let now = Duration::from_mins(6);
    let set = |compass: &mut Compass, x_in: f64, theta_deg: f64| {
        let state = StateLine {
            x_tenths_in: x_in.round() as i32 * 10,
            y_tenths_in: before.y_in.round() as i32 * 10,
            theta_deg: theta_deg.round() as u16 % 360,
            drive: Drive::OdometerReset,
            ..StateLine::BLANK
        };
        compass.handle_line(now, &line(Body::State(state)));
        compass.pose().expect("a pose")
    };
    let theta_deg = before.theta_deg.value;
    let after = set(&mut compass, before.x_in, theta_deg);
    assert!(
        turn_deg(theta_deg, after.theta_deg.value).abs() < 1e-6,
        "{after:?}"
    );
    assert!(
        (after.theta_deg.half - before.theta_deg.half).abs() < 0.1,
        "{after:?}"
    );
    assert_eq!((after.x_in, after.y_in), (before.x_in, before.y_in));
    assert_eq!(after.ellipse, before.ellipse);
    let error = compass.heading_error_deg().expect("a heading");
    assert!(error.value.abs() <= 0.51, "{error:?}");

    let other = set(&mut compass, before.x_in + 20.0, theta_deg);
    assert!(
        other.ellipse.long_in < 1e-6 && other.theta_deg.half < 1.0,
        "{other:?}"
    );
}

/// The bumper's side that touches first holds the robot back: it turns there, and its wheels slip.
#[test]
fn contact_on_one_side_turns_the_robot_there() {
    let heading_error_deg = |bumps: &[Bump]| {
        let mut compass = Compass::default();
        for (at, bump) in bumps.iter().enumerate() {
            let state = StateLine {
                y_tenths_in: 30 * at as i32,
                wheel_left_in_s: 10,
                wheel_right_in_s: 10,
                velocity_in_s: 10,
                bump: *bump,
                ..StateLine::BLANK
            };
            let now = Duration::from_millis(300 * at as u64);
            compass.handle_line(now, &line(Body::State(state)));
        }
        compass.heading_error_deg().expect("a heading").value
    };
    let contact = |bump| heading_error_deg(&[Bump::None, Bump::None, bump, bump, Bump::None]);
    assert!(contact(Bump::None).abs() < 1e-6);
    assert!(contact(Bump::Center).abs() < 1e-6);
    assert!((0.7..1.3).contains(&contact(Bump::Right)));
    assert!((contact(Bump::Right) + contact(Bump::Left)).abs() < 1e-6);
}

/// Lines A and B tell of the same setting of the pose, in either order, and either may be lost.
#[test]
fn each_setting_of_the_pose_counts_once() {
    let state = |x_in: i32, drive| {
        Body::State(StateLine {
            x_tenths_in: x_in * 10,
            drive,
            ..StateLine::BLANK
        })
    };
    let status = |odometer_resets| {
        Body::Status(StatusLine {
            odometer_resets,
            ..blank_status()
        })
    };
    // The pose is set to (50, 0) and the robot drives on by 20 in; its ellipse must not vanish a second time.
    for bodies in [
        vec![state(50, Drive::OdometerReset), status(1)],
        vec![status(1), state(50, Drive::OdometerReset)],
        vec![status(1), state(50, Drive::Ok)],
    ] {
        let mut compass = Compass::default();
        let mut now = Duration::ZERO;
        let mut take = |body| {
            now += Duration::from_millis(300);
            compass.handle_line(now, &line(body));
            compass.pose()
        };
        take(status(0));
        take(state(0, Drive::Ok));
        for body in bodies {
            take(body);
        }
        for x_in in 51..70 {
            take(state(x_in, Drive::Ok));
        }
        take(status(1));
        let end = take(state(70, Drive::Ok)).expect("a pose");
        assert!((end.x_in - 70.0).abs() < 1e-6, "{end:?}");
        assert!(end.ellipse.long_in > 0.3, "{end:?}");
    }
}

/// The robot drives on while a minute of lines is lost, and then reboots in another place than it believes.
/// In the first minute too, when few walls are known.
#[test]
fn early_outage_widens_the_statement() {
    let world = World::built_in("house").expect("it comes with the simulator");
    let mut config = SimulationConfig::new(world, 1);
    config.channel.outages_ms.push(8_000..40_000);
    let mut simulation = Simulation::new(&config);
    let mut compass = Compass::default();
    let moments = drive(&mut simulation, &mut compass, 1);
    assert!(share(&moments, Moment::is_heading_inside) >= 0.9);
    // A line that was on its way when the outage began ends behind it, with the pose from before.
    assert!(share(&moments, Moment::is_position_inside) >= 0.9);
    let last = moments.last().and_then(|moment| moment.stated);
    let last = last.expect("a pose");
    assert!(last.ellipse.long_in > 20.0, "{last:?}");
}

#[test]
fn outage_widens_the_statement_and_a_restart_begins_it_again() {
    let mut config = house(20_141);
    config.channel.outages_ms.push(600_000..660_000);
    let mut simulation = Simulation::new(&config);
    let mut compass = Compass::default();
    drive(&mut simulation, &mut compass, 10);
    let before = compass.heading_error_deg().expect("a heading").half;
    let after = drive(&mut simulation, &mut compass, 4);
    let first = after[0].stated.expect("a heading");
    assert!(
        first.theta_deg.half > before,
        "{} after {before}",
        first.theta_deg.half
    );
    assert!(share(&after, Moment::is_heading_inside) >= 0.9);

    simulation.reboot();
    drive(&mut simulation, &mut compass, 1);
    let begun = compass.heading_error_deg().expect("a heading");
    assert!(begun.value.abs() < 15.0, "{begun:?}");
}
