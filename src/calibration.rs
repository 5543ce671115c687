//! Computes a robot's wheel and track size from the ends of two squares.
//!
//! The robot drives a square by odometry, once clockwise and once counter-clockwise, and the operator measures where each
//! ends. A wrong track turns every corner too far or too little; unequal wheels bend every side. The two errors affect the
//! two squares differently, so both follow from the four coordinates (J. Borenstein and L. Feng, "Measurement and Correction
//! of Systematic Odometry Errors in Mobile Robots", IEEE Transactions on Robotics and Automation 12 (6), 1996: `UMBmark`).
//! The closed formulas of the paper hold for small errors. Groundwave starts from them and refines the result with the exact
//! geometry of the square. The mean size of both wheels does not show in a square that closes, so it stays unchanged.

use std::f64::consts::FRAC_PI_2;

/// A robot's parameters for wheels and track, thousandths of an inch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Gauge {
    /// Diameter of the left wheel.
    pub wheel_left: i16,
    /// Diameter of the right wheel.
    pub wheel_right: i16,
    /// Distance between the wheels.
    pub track: i16,
}

/// The measured position minus the odometry's, inches, in the frame of the square's start.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Offset {
    /// Distance to the right of the start, inches.
    pub right_in: f64,
    /// Distance ahead of the start, inches.
    pub ahead_in: f64,
}

impl Offset {
    /// Distance from the start, inches.
    #[must_use]
    pub fn length_in(self) -> f64 {
        self.right_in.hypot(self.ahead_in)
    }

    /// The mean of several offsets; `None` if there are none.
    #[must_use]
    pub fn mean(offsets: &[Self]) -> Option<Self> {
        let count = offsets.len() as f64;
        let sum = |of: fn(&Self) -> f64| offsets.iter().map(of).sum::<f64>() / count;
        (!offsets.is_empty()).then(|| Self {
            right_in: sum(|offset| offset.right_in),
            ahead_in: sum(|offset| offset.ahead_in),
        })
    }
}

/// Measured ends of the squares of one calibration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Squares {
    /// Side of the square, inches.
    pub side_in: f64,
    /// Mean offset after the clockwise squares.
    pub clockwise: Offset,
    /// Mean offset after the counter-clockwise squares.
    pub counter: Offset,
}

/// Reason why a calibration has no result.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum CalibrationError {
    /// The side is too short.
    #[error("a square of {0} in is too small; drive one of 40 in or more")]
    Side(f64),
    /// No wheel and track size fits the measurements.
    #[error(
        "no wheel and track size fits squares that end {clockwise_in:.1} and {counter_in:.1} in from the start; check that \
         the robot did not slip or bump, and measure again, to the right and ahead as seen at the start"
    )]
    Unexplained {
        /// Distance of the clockwise square's end from the start, inches.
        clockwise_in: f64,
        /// Distance of the counter-clockwise square's end, inches.
        counter_in: f64,
    },
    /// The corrected value is beyond what the robot accepts.
    #[error(
        "the measurements give {what} of {value_in:.3} in, but the robot accepts {least_in} to {most_in}; measure again"
    )]
    Limit {
        /// Name of the dimension, with an article.
        what: &'static str,
        /// The computed value, inches.
        value_in: f64,
        /// The smallest accepted value, inches.
        least_in: f64,
        /// The largest accepted value, inches.
        most_in: f64,
    },
}

/// The shortest usable side, inches.
const SIDE_LEAST_IN: f64 = 40.0;

/// Limits of the robot's parameters for wheels and track, thousandths of an inch.
const WHEEL: (f64, f64) = (4500.0, 5500.0);
const TRACK: (f64, f64) = (9000.0, 11_000.0);

/// Number of refinement steps; three or four are enough to converge.
const PASSES: usize = 20;

/// Maximum residual as a share of the side; allows for measuring by hand and dust on the floor.
const UNEXPLAINED_SHARE: f64 = 0.02;

impl Squares {
    /// The gauge that closes both squares; `present` is the gauge that the robot used for them.
    ///
    /// # Errors
    ///
    /// If the side is too short, no gauge fits the measurements, or the robot does not accept it.
    pub fn correct(&self, present: Gauge) -> Result<Gauge, CalibrationError> {
        if !self.side_in.is_finite() || self.side_in < SIDE_LEAST_IN {
            return Err(CalibrationError::Side(self.side_in));
        }
        let track_in = f64::from(present.track) / 1000.0;
        let mut errors = self.first_order(track_in);
        for _ in 0..PASSES {
            errors = self.refine(errors, track_in);
        }
        let left = self.residuals(errors, track_in);
        let worst = left
            .iter()
            .fold(0.0, |worst: f64, part| worst.max(part.abs()));
        if !errors.track.is_finite()
            || !errors.wheels.is_finite()
            || worst > UNEXPLAINED_SHARE * self.side_in
        {
            return Err(CalibrationError::Unexplained {
                clockwise_in: self.clockwise.length_in(),
                counter_in: self.counter.length_in(),
            });
        }
        // The mean of both wheels does not change.
        let wheels = 1.0 + errors.wheels;
        let scaled = |what, value: i16, factor: f64, limits: (f64, f64)| {
            let value = f64::from(value) * factor;
            if (limits.0..=limits.1).contains(&value) {
                Ok(value.round() as i16)
            } else {
                Err(CalibrationError::Limit {
                    what,
                    value_in: value / 1000.0,
                    least_in: limits.0 / 1000.0,
                    most_in: limits.1 / 1000.0,
                })
            }
        };
        Ok(Gauge {
            wheel_left: scaled(
                "a left wheel",
                present.wheel_left,
                2.0 / (wheels + 1.0),
                WHEEL,
            )?,
            wheel_right: scaled(
                "a right wheel",
                present.wheel_right,
                2.0 / (1.0 / wheels + 1.0),
                WHEEL,
            )?,
            track: scaled("a track", present.track, 1.0 + errors.track, TRACK)?,
        })
    }

    /// Larger distance of the two squares' ends from their starts, inches: the paper's measure of systematic errors.
    #[must_use]
    pub fn error_in(&self) -> f64 {
        self.clockwise.length_in().max(self.counter.length_in())
    }

    /// The error as a share of the distance driven.
    #[must_use]
    pub fn error_share(&self) -> f64 {
        self.error_in() / (4.0 * self.side_in)
    }

    /// Errors by the paper's closed formulas. The paper's x is our ahead, its y our left.
    fn first_order(&self, track_in: f64) -> Errors {
        let (cw, ccw) = (self.clockwise, self.counter);
        let quarter = -4.0 * self.side_in;
        let corner = f64::midpoint(
            (cw.ahead_in + ccw.ahead_in) / quarter,
            (ccw.right_in - cw.right_in) / quarter,
        );
        let bend = f64::midpoint(
            (cw.ahead_in - ccw.ahead_in) / quarter,
            (-cw.right_in - ccw.right_in) / quarter,
        );
        // The curvature of a side that turns by `bend`; over one turn the wheels' paths differ by the track.
        let curvature = 2.0 * (bend / 2.0).sin() / self.side_in;
        Errors {
            track: FRAC_PI_2 / (FRAC_PI_2 - corner) - 1.0,
            wheels: (1.0 + curvature * track_in / 2.0) / (1.0 - curvature * track_in / 2.0) - 1.0,
        }
    }

    /// One Gauss-Newton step towards the errors for which the squares end at the measured positions.
    fn refine(&self, at: Errors, track_in: f64) -> Errors {
        const STEP: f64 = 1e-6;
        let here = self.residuals(at, track_in);
        let slope = |other: Errors| {
            let there = self.residuals(other, track_in);
            [0, 1, 2, 3].map(|i| (there[i] - here[i]) / STEP)
        };
        let by_track = slope(Errors {
            track: at.track + STEP,
            ..at
        });
        let by_wheels = slope(Errors {
            wheels: at.wheels + STEP,
            ..at
        });
        let dot = |a: &[f64; 4], b: &[f64; 4]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let (tt, tw, ww) = (
            dot(&by_track, &by_track),
            dot(&by_track, &by_wheels),
            dot(&by_wheels, &by_wheels),
        );
        let (t, w) = (dot(&by_track, &here), dot(&by_wheels, &here));
        let determinant = tt * ww - tw * tw;
        Errors {
            track: at.track - (ww * t - tw * w) / determinant,
            wheels: at.wheels - (tt * w - tw * t) / determinant,
        }
    }

    /// The ends of both squares for a robot with these errors, minus the measured ends, inches.
    fn residuals(&self, errors: Errors, track_in: f64) -> [f64; 4] {
        let cw = errors.end_of_square(self.side_in, track_in, 1.0);
        let ccw = errors.end_of_square(self.side_in, track_in, -1.0);
        [
            cw.right_in - self.clockwise.right_in,
            cw.ahead_in - self.clockwise.ahead_in,
            ccw.right_in - self.counter.right_in,
            ccw.ahead_in - self.counter.ahead_in,
        ]
    }
}

/// Relative errors of a robot's odometry.
#[derive(Clone, Copy, Debug)]
struct Errors {
    /// True track divided by the assumed track, minus 1.
    track: f64,
    /// True ratio of the wheel diameters (right to left) divided by the assumed ratio, minus 1.
    wheels: f64,
}

impl Errors {
    /// The end of a square that closes in odometry; `hand` is 1 for clockwise and -1 for counter-clockwise.
    fn end_of_square(self, side_in: f64, track_in: f64, hand: f64) -> Offset {
        let ratio = 1.0 + self.wheels;
        let track_in = track_in * (1.0 + self.track);
        // Turn to the right on a side, and at a corner.
        let bend = side_in * 2.0 * (1.0 - ratio) / (1.0 + ratio) / track_in;
        let corner = hand * FRAC_PI_2 / (1.0 + self.track);
        let mut end = Offset::default();
        let mut heading: f64 = 0.0;
        for _ in 0..4 {
            // The chord of the arc.
            let chord_in = if bend.abs() < 1e-9 {
                side_in
            } else {
                side_in * (bend / 2.0).sin() / (bend / 2.0)
            };
            let middle = heading + bend / 2.0;
            end.right_in += chord_in * middle.sin();
            end.ahead_in += chord_in * middle.cos();
            heading += bend + corner;
        }
        end
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const DRAWN: Gauge = Gauge {
        wheel_left: 5000,
        wheel_right: 5000,
        track: 10_000,
    };

    fn squares(errors: Errors, side_in: f64) -> Squares {
        Squares {
            side_in,
            clockwise: errors.end_of_square(side_in, 10.0, 1.0),
            counter: errors.end_of_square(side_in, 10.0, -1.0),
        }
    }

    #[test]
    fn closed_squares_change_nothing() {
        let none = Errors {
            track: 0.0,
            wheels: 0.0,
        };
        let squares = squares(none, 157.0);
        assert!(squares.error_in() < 1e-9);
        assert_eq!(squares.correct(DRAWN), Ok(DRAWN));
    }

    /// Type A of the paper: both ends at the same distance ahead, mirrored to the left and right.
    #[test]
    fn wider_track_is_recovered() {
        let squares = squares(
            Errors {
                track: 0.01,
                wheels: 0.0,
            },
            157.0,
        );
        let (cw, ccw) = (squares.clockwise, squares.counter);
        assert!(
            (cw.ahead_in - ccw.ahead_in).abs() < 1e-9 && (cw.right_in + ccw.right_in).abs() < 1e-9
        );
        let gauge = squares.correct(DRAWN).expect("a gauge");
        assert_eq!(
            gauge,
            Gauge {
                track: 10_100,
                ..DRAWN
            }
        );
    }

    /// Type B of the paper: both ends on the same side, mirrored ahead and behind.
    #[test]
    fn larger_right_wheel_is_recovered() {
        let squares = squares(
            Errors {
                track: 0.0,
                wheels: 0.004,
            },
            157.0,
        );
        let (cw, ccw) = (squares.clockwise, squares.counter);
        assert!(
            (cw.right_in - ccw.right_in).abs() < 1e-6
                || cw.right_in.signum() == ccw.right_in.signum()
        );
        let gauge = squares.correct(DRAWN).expect("a gauge");
        assert_eq!(
            (gauge.wheel_left, gauge.wheel_right, gauge.track),
            (4990, 5010, 10_000)
        );
    }

    proptest! {
        #[test]
        fn track_and_wheel_errors_are_recovered(
            track in -0.03_f64..0.03,
            wheels in -0.01_f64..0.01,
            side_in in 60.0_f64..300.0,
        ) {
            let gauge = squares(Errors { track, wheels }, side_in).correct(DRAWN).expect("a gauge");
            prop_assert!((f64::from(gauge.track) - 10_000.0 * (1.0 + track)).abs() <= 1.0, "{gauge:?}");
            let ratio = f64::from(gauge.wheel_right) / f64::from(gauge.wheel_left);
            prop_assert!((ratio - 1.0 - wheels).abs() < 3e-4, "{gauge:?}");
            let mean = f64::midpoint(gauge.wheel_left.into(), gauge.wheel_right.into());
            prop_assert!((mean - 5000.0).abs() <= 1.0, "{gauge:?}");
        }

        #[test]
        fn half_an_inch_of_measuring_error_changes_the_track_little(
            track in -0.01_f64..0.01,
            wheels in -0.008_f64..0.008,
            slips in proptest::array::uniform4(-0.5_f64..0.5),
        ) {
            let mut squares = squares(Errors { track, wheels }, 157.0);
            squares.clockwise.right_in += slips[0];
            squares.clockwise.ahead_in += slips[1];
            squares.counter.right_in += slips[2];
            squares.counter.ahead_in += slips[3];
            let gauge = squares.correct(DRAWN).expect("a gauge");
            prop_assert!((f64::from(gauge.track) - 10_000.0 * (1.0 + track)).abs() <= 15.0, "{gauge:?}");
        }
    }

    #[test]
    fn implausible_measurements_are_refused() {
        let good = squares(
            Errors {
                track: 0.01,
                wheels: 0.002,
            },
            157.0,
        );
        assert_eq!(
            Squares {
                side_in: 20.0,
                ..good
            }
            .correct(DRAWN),
            Err(CalibrationError::Side(20.0))
        );
        // Left and right are swapped in one measurement.
        let confused = Squares {
            clockwise: Offset {
                right_in: 30.0,
                ahead_in: -40.0,
            },
            counter: Offset {
                right_in: 35.0,
                ahead_in: 45.0,
            },
            ..good
        };
        let error = confused.correct(DRAWN).expect_err("no wheels do that");
        assert!(error.to_string().contains("measure again"), "{error}");
        let narrow = Gauge {
            track: 10_950,
            ..DRAWN
        };
        let error = good.correct(narrow).expect_err("the robot refuses it");
        assert!(
            error.to_string().contains("11.0") && error.to_string().contains("a track"),
            "{error}"
        );
    }

    #[test]
    fn mean_of_offsets() {
        let at = |right_in, ahead_in| Offset { right_in, ahead_in };
        assert_eq!(Offset::mean(&[]), None);
        assert_eq!(
            Offset::mean(&[at(1.0, 2.0), at(3.0, -2.0)]),
            Some(at(2.0, 0.0))
        );
    }
}
