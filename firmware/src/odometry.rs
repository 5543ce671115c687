//! Odometry: the robot's pose from the turns of its wheels.
//!
//! A 5-inch wheel gives 251 counts per turn and the track is 10 inches, so a full turn of the robot is a difference of
//! exactly 1004 counts. Parameters give the true wheels and track of a robot. The encoders have one channel: the caller
//! derives the sign of a count from the motor command.

use crate::angle::Angle;
use crate::parameters::{Parameter, Parameters};
use groundwave_protocol::Waypoint;

/// Difference of counts between the wheels per turn of the robot: 2 * 251 * 10 in / 5 in.
pub const COUNTS_PER_TURN: i32 = 1004;

/// Heading per count of difference with nominal wheels and track; a full turn is 2^32.
const TURN_PER_COUNT: i32 = (u32::MAX / COUNTS_PER_TURN as u32) as i32 + 1;

/// Movement of the centre per count of one nominal wheel, in 1/64 of a step (see [`STEP_PER_IN`]): half of
/// pi * 5 in / 251 is 0.0312905 in.
const STEP_PER_COUNT: i32 = 8203;

/// Number of steps per inch.
const STEP_PER_IN: i32 = 4096;

/// Number of units of position per inch: 32 bits reach 131,072 inches.
pub const UNITS_PER_IN: i32 = 16_384;

/// Shift from a step times a 15-bit sine to a unit.
const STEP_SHIFT: u32 = 15 - (UNITS_PER_IN / STEP_PER_IN).trailing_zeros();

/// Maximum number of counts per tick: 4 times the motors' top speed.
const COUNTS_MAX: i16 = 64;

/// Diameter of the nominal wheels in 1/1000 inch.
const NOMINAL_WHEEL: i32 = 5000;

/// Movement and heading per count of each wheel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Gauge {
    /// Movement of the centre in 1/64 of a step.
    left_step: i32,
    right_step: i32,
    /// Heading; a full turn is 2^32.
    left_turn: i32,
    right_turn: i32,
}

impl Gauge {
    const NOMINAL: Self = Self {
        left_step: STEP_PER_COUNT,
        right_step: STEP_PER_COUNT,
        left_turn: TURN_PER_COUNT,
        right_turn: TURN_PER_COUNT,
    };

    fn of(parameters: &Parameters) -> Self {
        let value = |parameter| i32::from(parameters.get(parameter)).max(1);
        let (left, right) = (value(Parameter::WheelLeft), value(Parameter::WheelRight));
        let track = value(Parameter::Track);
        let step = |wheel: i32| (wheel * STEP_PER_COUNT + NOMINAL_WHEEL / 2) / NOMINAL_WHEEL;
        // Ratio to the nominal wheel and track in 1/65,536: exactly 65,536 for nominal ones.
        let turn = |wheel: i32| {
            let ratio = (((wheel * 2) << 16) + track / 2) / track;
            (TURN_PER_COUNT >> 16) * ratio
                + (((TURN_PER_COUNT & 0xFFFF) as u32 * ratio as u32) >> 16) as i32
        };
        Self {
            left_step: step(left),
            right_step: step(right),
            left_turn: turn(left),
            right_turn: turn(right),
        }
    }
}

impl Default for Gauge {
    fn default() -> Self {
        Self::NOMINAL
    }
}

/// A position and a heading.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Pose {
    /// X in 1/[`UNITS_PER_IN`] of an inch.
    pub x_units: i32,
    /// Y in 1/[`UNITS_PER_IN`] of an inch.
    pub y_units: i32,
    /// Heading clockwise from +Y.
    pub heading: Angle,
}

impl Pose {
    /// X in tenths of an inch.
    #[must_use]
    pub const fn x_tenths_in(&self) -> i32 {
        tenths_in(self.x_units)
    }

    /// Y in tenths of an inch.
    #[must_use]
    pub const fn y_tenths_in(&self) -> i32 {
        tenths_in(self.y_units)
    }

    /// Heading in whole degrees, 0 to 359.
    #[must_use]
    pub const fn theta_deg(&self) -> u16 {
        self.heading.degrees()
    }

    /// X and Y distance to a point in sixteenths of an inch.
    #[must_use]
    pub const fn offset_to(&self, point: Waypoint) -> (i32, i32) {
        const SHIFT: u32 = (UNITS_PER_IN / 16).trailing_zeros();
        (
            point.x_in as i32 * 16 - (self.x_units >> SHIFT),
            point.y_in as i32 * 16 - (self.y_units >> SHIFT),
        )
    }
}

const fn tenths_in(units: i32) -> i32 {
    // Whole inches first: ten times the largest position would overflow.
    let whole = units >> UNITS_PER_IN.trailing_zeros();
    let part = units & (UNITS_PER_IN - 1);
    whole * 10 + (part * 10 + UNITS_PER_IN / 2) / UNITS_PER_IN
}

/// The odometer.
#[derive(Clone, Debug, Default)]
pub struct Odometer {
    x_units: i32,
    y_units: i32,
    /// Heading; a full turn is 2^32.
    heading: u32,
    /// Rounding remainder of the movement in 1/64 of a step.
    remainder: i32,
    gauge: Gauge,
}

impl Odometer {
    /// Takes wheels and track from the parameters.
    pub fn fit(&mut self, parameters: &Parameters) {
        self.gauge = Gauge::of(parameters);
    }

    /// Adds the counts of both wheels during a tick, negative backward.
    pub fn advance(&mut self, left: i16, right: i16) {
        let left = i32::from(left.clamp(-COUNTS_MAX, COUNTS_MAX));
        let right = i32::from(right.clamp(-COUNTS_MAX, COUNTS_MAX));
        let gauge = &self.gauge;
        let turn = left * gauge.left_turn - right * gauge.right_turn;
        // The heading at the middle of the tick gives the chord of the arc.
        let heading = Angle((self.heading.wrapping_add_signed(turn / 2) >> 16) as u16);
        self.heading = self.heading.wrapping_add_signed(turn);
        let path = left * gauge.left_step + right * gauge.right_step + self.remainder;
        let step = path >> 6;
        self.remainder = path & 63;
        let part = |share: i16| (step * i32::from(share) + (1 << (STEP_SHIFT - 1))) >> STEP_SHIFT;
        self.x_units = self.x_units.saturating_add(part(heading.sin()));
        self.y_units = self.y_units.saturating_add(part(heading.cos()));
    }

    /// Current pose.
    #[must_use]
    pub const fn pose(&self) -> Pose {
        Pose {
            x_units: self.x_units,
            y_units: self.y_units,
            heading: Angle((self.heading >> 16) as u16),
        }
    }

    /// Sets position and heading.
    pub fn set(&mut self, position: Waypoint, heading: Angle) {
        // A waypoint reaches 9999 inches: far below the limit of 32 bits.
        self.x_units = i32::from(position.x_in) * UNITS_PER_IN;
        self.y_units = i32::from(position.y_in) * UNITS_PER_IN;
        self.heading = u32::from(heading.0) << 16;
        self.remainder = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A 157-inch side is 10 turns of the wheel; a quarter turn is a difference of 251 counts.
    fn drive_square(clockwise: bool) -> Odometer {
        let mut odometer = Odometer::default();
        for _ in 0..4 {
            for _ in 0..251 {
                odometer.advance(10, 10);
            }
            // 251 is odd, so one wheel turns one count more.
            for step in 0..125 {
                let last = i16::from(step == 124);
                if clockwise {
                    odometer.advance(1 + last, -1);
                } else {
                    odometer.advance(-1, 1 + last);
                }
            }
        }
        odometer
    }

    #[test]
    fn square_ends_at_its_start_in_both_directions() {
        for clockwise in [true, false] {
            let pose = drive_square(clockwise).pose();
            assert_eq!(pose.theta_deg(), 0);
            // Within the half counts that the odd corners add.
            assert!(pose.x_tenths_in().abs() <= 2, "{pose:?}");
            assert!(pose.y_tenths_in().abs() <= 2, "{pose:?}");
        }
    }

    #[test]
    fn turn_of_the_wheels_is_their_circumference() {
        let mut odometer = Odometer::default();
        for _ in 0..251 {
            odometer.advance(10, 10);
        }
        // 10 * pi * 5 in = 157.08 in
        assert_eq!(odometer.pose().y_tenths_in(), 1571);
        assert_eq!(odometer.pose().x_units, 0);
        for _ in 0..251 {
            odometer.advance(-10, -10);
        }
        assert_eq!(odometer.pose().y_tenths_in(), 0);
    }

    #[test]
    fn quarter_circle_ends_at_its_radius() {
        // Radius 20 in: the wheels run at radii of 25 and 15 in; 753 counts to 502 less a quarter turn.
        let mut odometer = Odometer::default();
        let (mut left, mut right) = (0, 0);
        for step in 1..=100_i32 {
            let (l, r) = (step * 1255 / 200, step * 753 / 200);
            odometer.advance((l - left) as i16, (r - right) as i16);
            (left, right) = (l, r);
        }
        let pose = odometer.pose();
        assert_eq!(pose.theta_deg(), 90);
        assert!((pose.x_tenths_in() - 200).abs() <= 1, "{pose:?}");
        assert!((pose.y_tenths_in() - 200).abs() <= 1, "{pose:?}");
    }

    #[test]
    fn set_position_is_exact_at_the_limits() {
        let mut odometer = Odometer::default();
        odometer.set(
            Waypoint {
                x_in: -9999,
                y_in: 9999,
            },
            Angle::from_degrees(270),
        );
        let pose = odometer.pose();
        assert_eq!((pose.x_tenths_in(), pose.y_tenths_in()), (-99_990, 99_990));
        assert_eq!(pose.theta_deg(), 270);
        odometer.advance(8, 8);
        assert_eq!(odometer.pose().x_tenths_in(), -99_995);
        assert_eq!(
            odometer
                .pose()
                .offset_to(Waypoint {
                    x_in: -9999,
                    y_in: 9998
                })
                .1,
            -16
        );
    }

    #[test]
    fn tuned_gauge_is_exact_to_a_hundred_thousandth() {
        assert_eq!(Gauge::of(&Parameters::DEFAULT), Gauge::NOMINAL);
        for (left, right, track) in [
            (4500, 5500, 9000),
            (5013, 4987, 10_061),
            (5500, 4500, 11_000),
        ] {
            let mut parameters = Parameters::DEFAULT;
            for (parameter, value) in [
                (Parameter::WheelLeft, left),
                (Parameter::WheelRight, right),
                (Parameter::Track, track),
            ] {
                assert!(parameters.set(parameter, value));
            }
            let gauge = Gauge::of(&parameters);
            for (wheel, turn, step) in [
                (left, gauge.left_turn, gauge.left_step),
                (right, gauge.right_turn, gauge.right_step),
            ] {
                let exact = f64::from(wheel) * 2.0 / f64::from(track) * f64::from(TURN_PER_COUNT);
                assert!(
                    (f64::from(turn) / exact - 1.0).abs() < 1e-5,
                    "{turn} for {exact}"
                );
                let exact = f64::from(wheel) / 5000.0 * f64::from(STEP_PER_COUNT);
                assert!((f64::from(step) - exact).abs() <= 0.5, "{step} for {exact}");
            }
        }
    }

    #[test]
    fn equal_counts_of_unequal_wheels_are_an_arc() {
        let mut parameters = Parameters::DEFAULT;
        assert!(parameters.set(Parameter::WheelLeft, 5020));
        let mut odometer = Odometer::default();
        odometer.fit(&parameters);
        for _ in 0..251 {
            odometer.advance(10, 10);
        }
        // 10 turns; the left wheel runs 0.628 in farther over a track of 10 in: 3.6 degrees.
        let pose = odometer.pose();
        assert_eq!(pose.theta_deg(), 4);
        assert!((pose.y_tenths_in() - 1573).abs() <= 2, "{pose:?}");
        assert!((pose.x_tenths_in() - 49).abs() <= 2, "{pose:?}");
    }

    #[test]
    fn extreme_encoder_counts_do_not_overflow() {
        let mut odometer = Odometer::default();
        for _ in 0..10_000 {
            odometer.advance(i16::MAX, i16::MAX);
            odometer.advance(i16::MIN, i16::MAX);
        }
    }
}
