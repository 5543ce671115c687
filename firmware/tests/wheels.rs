//! Wheel control with a small motor model.

use crate::common::{Bench, Motor};
use groundwave_protocol::status_codes::Drive;
use sr04_firmware::parameters::{Parameter, Parameters};
use sr04_firmware::pid::{Gains, Wheel};
use sr04_firmware::units::cps;

struct Rig {
    wheel: Wheel,
    gains: Gains,
    motor: Motor,
    pwm: i16,
    counts: i32,
    battery_v: f64,
    load: f64,
}

impl Rig {
    fn new(battery_v: f64, load: f64) -> Self {
        Self {
            wheel: Wheel::default(),
            gains: Gains::default(),
            motor: Motor::default(),
            pwm: 0,
            counts: 0,
            battery_v,
            load,
        }
    }

    fn run_ticks(&mut self, ticks: u32, ordered_cps: i16) {
        for _ in 0..ticks {
            for _ in 0..50 {
                self.motor.step_ms(self.pwm, self.battery_v, self.load);
            }
            let counts = self.wheel.signed_counts(self.motor.take_edges());
            self.counts += i32::from(counts);
            self.pwm = self.wheel.control(ordered_cps, counts, &self.gains);
        }
    }
}

#[test]
fn mean_speed_is_within_two_percent_at_any_battery_and_load() {
    for battery_v in [10.8, 12.0, 13.8] {
        for load in [0.05, 0.15, 0.25] {
            for speed_in_s in [-12, -2, 2, 3, 6, 12] {
                let mut rig = Rig::new(battery_v, load);
                rig.run_ticks(60, cps(speed_in_s));
                let before = rig.counts;
                rig.run_ticks(200, cps(speed_in_s));
                let mean = f64::from(rig.counts - before) / 10.0;
                let wanted = f64::from(cps(speed_in_s));
                assert!(
                    (mean - wanted).abs() <= wanted.abs() * 0.02,
                    "{speed_in_s} in/s at {battery_v} V, load {load}: {mean} for {wanted} counts/s"
                );
                assert!(!rig.wheel.is_saturated());
            }
        }
    }
}

#[test]
fn speed_settles_within_a_second_without_overshoot() {
    let mut rig = Rig::new(12.0, 0.08);
    rig.run_ticks(10, cps(12));
    let mut fastest: f64 = 0.0;
    for _ in 0..30 {
        rig.run_ticks(1, cps(12));
        fastest = fastest.max(rig.motor.speed_cps);
    }
    assert!(fastest < f64::from(cps(12)) * 1.15, "{fastest}");
    for _ in 0..100 {
        rig.run_ticks(1, cps(12));
        let error = rig.motor.speed_cps - f64::from(cps(12));
        assert!(error.abs() < f64::from(cps(1)), "{error}");
    }
}

/// The closed loop by analysis: the motor's differential equation solved from tick to tick, and the control law in real
/// numbers with an encoder of fractional counts.
#[derive(Default)]
struct Analytic {
    speed_cps: f64,
    ordered_cps: f64,
    behind: f64,
    pwm: f64,
}

impl Analytic {
    const TICK_S: f64 = 0.05;
    /// Number of counts per second per 1/255 of pulse width at 12 volts without load.
    const GAIN: f64 = 326.0 / 255.0;
    /// Time constant of the motor in seconds.
    const TIME_CONSTANT_S: f64 = 1.0 / 6.0;

    fn tick(&mut self, order_cps: i16, parameters: &Parameters) {
        let gain = |parameter| f64::from(parameters.get(parameter));
        let lasts = (-Self::TICK_S / Self::TIME_CONSTANT_S).exp();
        let settled_cps = Self::GAIN * self.pwm;
        let apart_cps = self.speed_cps - settled_cps;
        let counts = settled_cps * Self::TICK_S + apart_cps * Self::TIME_CONSTANT_S * (1.0 - lasts);
        self.speed_cps = settled_cps + apart_cps * lasts;

        let slew_cps = f64::from(cps(parameters.get(Parameter::Slew)) / 20);
        let change = (f64::from(order_cps) - self.ordered_cps).clamp(-slew_cps, slew_cps);
        self.ordered_cps += change;
        let slow_cps = self.ordered_cps - counts / Self::TICK_S;
        self.behind += slow_cps * Self::TICK_S;
        self.pwm = self.ordered_cps * gain(Parameter::PidFeed) / 256.0
            + change * gain(Parameter::PidD) / 256.0
            + self.behind * gain(Parameter::PidI)
            + slow_cps * gain(Parameter::PidP) / 256.0;
        assert!(
            self.pwm.abs() < 255.0,
            "the control law has no limit here: {}",
            self.pwm
        );
    }
}

#[test]
fn step_response_matches_the_analytic_one() {
    let mut tuned = Parameters::DEFAULT;
    for (parameter, value) in [
        (Parameter::PidFeed, 160),
        (Parameter::PidP, 60),
        (Parameter::PidI, 6),
        (Parameter::PidD, 400),
        (Parameter::Slew, 40),
    ] {
        assert!(tuned.set(parameter, value));
    }
    for parameters in [Parameters::DEFAULT, tuned] {
        for steps in [[12, 3], [4, 10], [8, 2]] {
            let mut rig = Rig::new(12.0, 0.0);
            rig.gains = Gains::of(&parameters);
            let mut analytic = Analytic::default();
            let mut way = 0.0;
            let mut squares = 0.0;
            for (tick, speed_in_s) in steps.into_iter().flat_map(|step| [step; 40]).enumerate() {
                rig.run_ticks(1, cps(speed_in_s));
                analytic.tick(cps(speed_in_s), &parameters);
                let apart_cps = rig.motor.speed_cps - analytic.speed_cps;
                squares += apart_cps * apart_cps;
                way += apart_cps * Analytic::TICK_S;
                // One count per tick, the resolution of the encoder, is 20 counts a second.
                assert!(
                    apart_cps.abs() < 12.0 && way.abs() < 3.0,
                    "tick {tick} of {steps:?}: {apart_cps} counts/s, {way} counts"
                );
            }
            let rms_cps = (squares / 80.0_f64).sqrt();
            assert!(rms_cps < 4.0, "{steps:?}: {rms_cps}");
        }
    }
}

#[test]
fn counts_lost_to_an_obstacle_are_made_up_within_a_limit() {
    let mut rig = Rig::new(12.0, 0.08);
    rig.run_ticks(60, cps(6));
    let speed = cps(6);
    // Held for a second, then free.
    for _ in 0..20 {
        rig.motor.speed_cps = 0.0;
        rig.pwm = rig.wheel.control(speed, 0, &Gains::default());
    }
    assert!(rig.wheel.is_saturated() || rig.pwm > 200);
    let before = rig.counts;
    rig.run_ticks(80, speed);
    let gained = rig.counts - before - 4 * i32::from(speed);
    assert!((20..=96).contains(&gained), "{gained}");
    rig.run_ticks(20, speed);
    assert!((rig.motor.speed_cps - f64::from(speed)).abs() < 16.0);
}

#[test]
fn saturated_wheel_recovers_without_a_dash() {
    let mut rig = Rig::new(7.0, 0.2);
    rig.run_ticks(100, cps(12));
    assert!(rig.wheel.is_saturated() && !rig.wheel.is_stalled());
    rig.battery_v = 12.0;
    // No windup: no dash when the voltage returns.
    let before = rig.counts;
    rig.run_ticks(80, cps(12));
    let dash = rig.counts - before - 4 * i32::from(cps(12));
    assert!(dash < 20, "{dash} counts");
    assert!(!rig.wheel.is_saturated());
}

#[test]
fn saturation_is_reported_only_outside_the_rated_range() {
    for load in [0.05, 0.25] {
        let mut low = Rig::new(10.8, load);
        low.run_ticks(400, cps(12));
        assert!(!low.wheel.is_saturated(), "10.8 V, load {load}");
    }
    for (battery_v, load) in [(7.5, 0.05), (10.8, 0.6), (12.0, 0.8)] {
        let mut rig = Rig::new(battery_v, load);
        rig.run_ticks(100, cps(12));
        assert!(rig.wheel.is_saturated(), "{battery_v} V, load {load}");
        let before = rig.counts;
        rig.run_ticks(100, cps(12));
        assert!(
            rig.counts - before < 5 * i32::from(cps(12)),
            "the wheel is too slow"
        );
    }
}

#[test]
fn wheel_brakes_within_three_ticks_and_three_quarters_of_an_inch() {
    for battery_v in [10.8, 12.0, 13.8] {
        for load in [0.0, 0.08, 0.25] {
            for speed_in_s in [-12, -8, 5, 12] {
                let mut rig = Rig::new(battery_v, load);
                rig.run_ticks(60, cps(speed_in_s));
                rig.motor.take_way();
                let mut counts = i16::MAX;
                for tick in 0..6 {
                    rig.pwm = if tick == 0 {
                        let last = (cps(speed_in_s) / 20).abs();
                        rig.wheel.brake(last)
                    } else {
                        rig.wheel.brake(counts)
                    };
                    for _ in 0..50 {
                        rig.motor.step_ms(rig.pwm, battery_v, load);
                    }
                    counts = rig.wheel.signed_counts(rig.motor.take_edges());
                    if tick >= 3 {
                        assert!(counts.abs() <= 2, "tick {tick}: {counts}");
                    }
                }
                let way = rig.motor.take_way();
                assert!(
                    way.abs() <= 12.0 && way.abs() >= 0.0,
                    "{speed_in_s} in/s at {battery_v} V, load {load}: {way} counts"
                );
                assert!(rig.motor.speed_cps.abs() <= 24.0, "{}", rig.motor.speed_cps);
            }
        }
    }
}

#[test]
fn gains_follow_the_parameters() {
    let mut slow = Parameters::DEFAULT;
    assert!(slow.set(Parameter::Slew, 6));
    let mut rig = Rig::new(12.0, 0.08);
    rig.gains = Gains::of(&slow);
    rig.run_ticks(20, cps(12));
    // A second of 6 in/s^2.
    assert!(
        (rig.motor.speed_cps - f64::from(cps(6))).abs() < 24.0,
        "{}",
        rig.motor.speed_cps
    );
    let mut open_loop = Parameters::DEFAULT;
    for parameter in [
        Parameter::PidFeed,
        Parameter::PidP,
        Parameter::PidI,
        Parameter::PidD,
    ] {
        assert!(open_loop.set(parameter, 0));
    }
    let mut wheel = Wheel::default();
    assert_eq!(wheel.control(cps(12), 0, &Gains::of(&open_loop)), 0);
}

/// Pulse widths of a held wheel, tick by tick.
fn held(wheel: &mut Wheel, gains: &Gains, ordered_cps: i16, ticks: usize) -> Vec<i16> {
    (0..ticks)
        .map(|_| wheel.control(ordered_cps, 0, gains))
        .collect()
}

#[test]
fn blocked_wheel_rests_after_a_second_and_tries_again() {
    let mut weak = Parameters::DEFAULT;
    // Feed-forward and the proportional part alone never give full width.
    assert!(weak.set(Parameter::PidI, 0));
    for gains in [Gains::default(), Gains::of(&weak)] {
        for speed_in_s in [12, -12] {
            let mut wheel = Wheel::default();
            let given = held(&mut wheel, &gains, cps(speed_in_s), 1200);
            let high = |&&pwm: &&i16| pwm.abs() >= 192;
            let first = given
                .iter()
                .position(|pwm| pwm.abs() >= 192)
                .expect("the power becomes high");
            assert_eq!(given[first..].iter().take_while(high).count(), 20);
            // Share of high power: a second per cycle, and the rise to it.
            let share = given.iter().filter(high).count() as f64 / given.len() as f64;
            assert!((0.1..=0.25).contains(&share), "{share}");
            assert!(wheel.is_stalled());
        }
    }
}

#[test]
fn stall_ends_when_the_wheel_moves_or_is_not_driven() {
    let mut wheel = Wheel::default();
    let gains = Gains::default();
    held(&mut wheel, &gains, cps(12), 60);
    assert!(wheel.is_stalled());
    // Escapes turn in the other direction at once.
    assert!(wheel.control(cps(-8), 0, &gains) < 0);
    assert!(wheel.is_stalled(), "the wheel has not moved");
    wheel.control(cps(-8), 4, &gains);
    assert!(!wheel.is_stalled());

    held(&mut wheel, &gains, cps(12), 60);
    assert!(wheel.is_stalled());
    held(&mut wheel, &gains, 0, 100);
    assert!(!wheel.is_stalled());

    held(&mut wheel, &gains, cps(12), 60);
    wheel.halt();
    assert!(!wheel.is_stalled());
    assert!(wheel.control(cps(12), 0, &gains) > 0);
}

/// Ticks until a slipping wheel with constant counts per tick counts as held.
fn slips(wheel: &mut Wheel, ordered_cps: i16, counts: u16, ticks: usize) -> usize {
    let gains = Gains::default();
    (0..ticks)
        .take_while(|_| {
            let counts = wheel.signed_counts(counts);
            wheel.control(ordered_cps, counts, &gains);
            !wheel.is_held()
        })
        .count()
}

#[test]
fn wheel_slipping_at_full_pulse_width_is_held_after_two_seconds() {
    for speed_in_s in [12, 8, -12] {
        let mut wheel = Wheel::default();
        let ticks = slips(&mut wheel, cps(speed_in_s), 3, 200);
        assert!((40..60).contains(&ticks), "{speed_in_s} in/s: {ticks}");
        assert!(!wheel.is_stalled());
        // Commanded in the other direction it is free at once.
        assert_eq!(slips(&mut wheel, -cps(speed_in_s), 3, 20), 20);
    }
}

#[test]
fn wheel_at_two_thirds_of_its_speed_is_not_held() {
    let mut wheel = Wheel::default();
    assert_eq!(slips(&mut wheel, cps(12), 7, 400), 400);
    assert!(wheel.is_saturated());
}

#[test]
fn stalled_wheel_is_held() {
    let mut wheel = Wheel::default();
    held(&mut wheel, &Gains::default(), cps(12), 60);
    assert!(wheel.is_held());
}

#[test]
fn counts_take_the_sign_of_a_followed_command() {
    let mut wheel = Wheel::default();
    assert!(wheel.control(cps(-6), 0, &Gains::default()) < 0);
    assert_eq!(wheel.signed_counts(2), -2);
    wheel.halt();
    // Coasting after the motor is off.
    assert_eq!(wheel.signed_counts(2), -2);
}

#[test]
fn wrong_direction_is_corrected_within_a_second() {
    let mut wheel = Wheel::default();
    // The wheel is turned back with its motor off, and then commanded ahead.
    for _ in 0..20 {
        let _ = wheel.signed_counts(6);
    }
    let mut motor = Motor::default();
    motor.speed_cps = -120.0;
    let mut is_right = Vec::new();
    let mut pwm = 0;
    for _ in 0..40 {
        for _ in 0..50 {
            motor.step_ms(pwm, 12.0, 0.08);
        }
        let counts = wheel.signed_counts(motor.take_edges());
        is_right.push((motor.take_way() - f64::from(counts)).abs() < 2.0);
        pwm = wheel.control(cps(6), counts, &Gains::default());
    }
    assert!(is_right[20..].iter().all(|&right| right), "{is_right:?}");
}

#[test]
fn repeated_reversals_lose_hardly_a_count() {
    for load in [0.05, 0.25] {
        let mut rig = Rig::new(12.0, load);
        let mut true_counts = 0.0;
        for turn in 0..40 {
            // As when avoidance and a target alternate: the slew never completes.
            let speed = [cps(12), cps(-12), cps(7), cps(-9)][turn % 4];
            for _ in 0..[9, 11, 8, 7][turn % 4] {
                rig.run_ticks(1, speed);
                true_counts += rig.motor.take_way();
            }
        }
        let error = (f64::from(rig.counts) - true_counts).abs();
        assert!(error < 10.0, "load {load}: {error} counts in 40 turns");
    }
}

#[test]
fn reversed_commands_lose_hardly_a_count() {
    for seed in 0..20_u32 {
        for (battery_v, load) in [(10.8, 0.25), (12.0, 0.08), (13.8, 0.05)] {
            let mut rig = Rig::new(battery_v, load);
            let mut rolled = seed;
            let mut roll = |sides: u32| {
                rolled = rolled.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                (rolled >> 16) % sides
            };
            let mut true_counts = 0.0;
            for _ in 0..500 {
                // As when infrared and a target alternate: a wheel is held back and released again.
                let speed = [1, -1, -2, -5, 6, 8, 11, 12][roll(8) as usize];
                for _ in 0..=roll(4) {
                    rig.run_ticks(1, cps(speed));
                    true_counts += rig.motor.take_way();
                }
            }
            let error = (f64::from(rig.counts) - true_counts).abs();
            assert!(
                error < 15.0,
                "seed {seed}, {battery_v} V, load {load}: {error} counts in 500 commands"
            );
        }
    }
}

#[test]
fn motor_is_off_at_rest() {
    let mut rig = Rig::new(12.0, 0.08);
    rig.run_ticks(40, cps(12));
    rig.run_ticks(40, 0);
    assert_eq!(rig.pwm, 0);
    assert!(rig.motor.speed_cps.abs() < 1.0);
}

#[test]
fn robot_drives_straight_at_top_speed() {
    let mut bench = Bench::new();
    bench.run_ms(30_000);
    let pose = bench.robot.pose();
    assert!(pose.y_tenths_in() > 3400, "{pose:?}");
    assert!(pose.x_tenths_in().abs() < 10, "{pose:?}");
    assert_eq!(bench.latest_state().wheel_left_in_s, 12);
    assert_eq!(bench.latest_state().drive, Drive::Ok);
}
