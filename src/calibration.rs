//! What a robot's wheels and track really are, from where two squares really end.
//!
//! The robot drives a square by odometry, once clockwise and once counter-clockwise, until it believes to
//! be back where it began; somebody measures where it is. A track that is not what the robot takes it for
//! turns every corner too far or too little, a wheel larger than the other bends every side. The two differ
//! in what they do to the two squares, and so both follow from the four coordinates (J. Borenstein and
//! L. Feng, "Measurement and Correction of Systematic Odometry Errors in Mobile Robots", IEEE Transactions
//! on Robotics and Automation 12 (6), 1996: `UMBmark`). Their closed formulas hold for small errors; they are
//! where we begin, and the exact geometry of the square refines them. How large both wheels are together
//! does not show in a square that closes, and stays as it is.

use std::f64::consts::FRAC_PI_2;

/// What a robot takes its wheels and its track for, in thousandths of an inch, as its parameters have it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Gauge {
    /// Diameter of the left wheel.
    pub wheel_left: i16,
    /// Diameter of the right wheel.
    pub wheel_right: i16,
    /// From wheel to wheel.
    pub track: i16,
}

/// Where a robot really is less where its odometry says it is, in inches, as seen at the start of the square.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Offset {
    /// To the right of the start.
    pub right_in: f64,
    /// Ahead of it.
    pub ahead_in: f64,
}

impl Offset {
    /// How far that is.
    #[must_use]
    pub fn length_in(self) -> f64 {
        self.right_in.hypot(self.ahead_in)
    }

    /// The middle of several; `None` of none.
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

/// Where the squares of one calibration ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Squares {
    /// Side in inches.
    pub side_in: f64,
    /// Those driven clockwise, in the middle.
    pub clockwise: Offset,
    /// Those driven counter-clockwise.
    pub counter: Offset,
}

/// Why nothing follows from what was measured.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum CalibrationError {
    /// There is no square.
    #[error("a square of {0} in tells nothing: drive one of 40 in or more")]
    Side(f64),
    /// No wheels explain it.
    #[error(
        "no wheels and track explain that the squares end {clockwise_in:.1} and {counter_in:.1} in from the \
         start: measure again, to the right and ahead of the start as the robot stood there, and look \
         whether it slipped or touched something"
    )]
    Unexplained {
        /// Of the clockwise square.
        clockwise_in: f64,
        /// Of the other.
        counter_in: f64,
    },
    /// The corrected value is beyond what the robot accepts.
    #[error(
        "that takes {what} of {value_in:.3} in, and the robot accepts {least_in} to {most_in}: measure again"
    )]
    Limit {
        /// Which one.
        what: &'static str,
        /// The value.
        value_in: f64,
        /// The least that is accepted.
        least_in: f64,
        /// And the most.
        most_in: f64,
    },
}

/// The shortest side that tells something.
const SIDE_LEAST_IN: f64 = 40.0;

/// Limits of the robot's parameters for wheels and track, thousandths of an inch.
const WHEEL: (f64, f64) = (4500.0, 5500.0);
const TRACK: (f64, f64) = (9000.0, 11_000.0);

/// Passes of the refinement; it converges in three or four.
const PASSES: usize = 20;

/// What is left unexplained may be so much of the side: a hand's measurement, dust on the floor.
const UNEXPLAINED_SHARE: f64 = 0.02;

impl Squares {
    /// The gauge that would have brought both squares home; `present` is the one they were driven with.
    ///
    /// # Errors
    ///
    /// When the side is too short, no wheels explain the measurement, or the robot would not accept them.
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
        // The mean of both wheels stays.
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

    /// How far the worse of the two ended from the start: the paper's measure of systematic errors.
    #[must_use]
    pub fn error_in(&self) -> f64 {
        self.clockwise.length_in().max(self.counter.length_in())
    }

    /// The same as a share of the way driven.
    #[must_use]
    pub fn error_share(&self) -> f64 {
        self.error_in() / (4.0 * self.side_in)
    }

    /// The paper's closed formulas. Its x is our ahead, its y our left.
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
        // A side of length L that bends by `bend` has this radius, and its wheels' ways differ by the track.
        let curvature = 2.0 * (bend / 2.0).sin() / self.side_in;
        Errors {
            track: FRAC_PI_2 / (FRAC_PI_2 - corner) - 1.0,
            wheels: (1.0 + curvature * track_in / 2.0) / (1.0 - curvature * track_in / 2.0) - 1.0,
        }
    }

    /// One step of Gauss and Newton toward the errors whose squares end where they were measured.
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

    /// Where the squares of a robot with such errors end, less where they did.
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

/// What a robot's odometry is wrong by.
#[derive(Clone, Copy, Debug)]
struct Errors {
    /// True track by believed track, less one.
    track: f64,
    /// Right wheel by left wheel, true by believed, less one.
    wheels: f64,
}

impl Errors {
    /// Where a square really ends that closes in odometry; `hand` is 1 clockwise and -1 counter-clockwise.
    fn end_of_square(self, side_in: f64, track_in: f64, hand: f64) -> Offset {
        let ratio = 1.0 + self.wheels;
        let track_in = track_in * (1.0 + self.track);
        // To the right while believing to go straight, and at a corner.
        let bend = side_in * 2.0 * (1.0 - ratio) / (1.0 + ratio) / track_in;
        let corner = hand * FRAC_PI_2 / (1.0 + self.track);
        let mut end = Offset::default();
        let mut heading: f64 = 0.0;
        for _ in 0..4 {
            // The chord of an arc: half-way heading, and a little shorter than the arc.
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
    fn squares_that_close_change_nothing() {
        let none = Errors {
            track: 0.0,
            wheels: 0.0,
        };
        let squares = squares(none, 157.0);
        assert!(squares.error_in() < 1e-9);
        assert_eq!(squares.correct(DRAWN), Ok(DRAWN));
    }

    /// Type A of the paper: both squares end to the same side of the start along it, mirrored across it.
    #[test]
    fn a_wider_track_turns_too_little_and_is_found() {
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
        let gauge = squares.correct(DRAWN).expect("it follows");
        assert_eq!(
            gauge,
            Gauge {
                track: 10_100,
                ..DRAWN
            }
        );
    }

    /// Type B: mirrored along the start, to the same side across it.
    #[test]
    fn a_larger_right_wheel_bends_to_the_left_and_is_found() {
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
        let gauge = squares.correct(DRAWN).expect("it follows");
        assert_eq!(
            (gauge.wheel_left, gauge.wheel_right, gauge.track),
            (4990, 5010, 10_000)
        );
    }

    proptest! {
        #[test]
        fn whatever_the_errors_are_they_are_found(
            track in -0.03_f64..0.03,
            wheels in -0.01_f64..0.01,
            side_in in 60.0_f64..300.0,
        ) {
            let gauge = squares(Errors { track, wheels }, side_in).correct(DRAWN).expect("it follows");
            prop_assert!((f64::from(gauge.track) - 10_000.0 * (1.0 + track)).abs() <= 1.0, "{gauge:?}");
            let ratio = f64::from(gauge.wheel_right) / f64::from(gauge.wheel_left);
            prop_assert!((ratio - 1.0 - wheels).abs() < 3e-4, "{gauge:?}");
            let mean = f64::midpoint(gauge.wheel_left.into(), gauge.wheel_right.into());
            prop_assert!((mean - 5000.0).abs() <= 1.0, "{gauge:?}");
        }

        #[test]
        fn a_hands_half_inch_does_not_matter_much(
            track in -0.01_f64..0.01,
            wheels in -0.008_f64..0.008,
            slips in proptest::array::uniform4(-0.5_f64..0.5),
        ) {
            let mut squares = squares(Errors { track, wheels }, 157.0);
            squares.clockwise.right_in += slips[0];
            squares.clockwise.ahead_in += slips[1];
            squares.counter.right_in += slips[2];
            squares.counter.ahead_in += slips[3];
            let gauge = squares.correct(DRAWN).expect("it follows");
            prop_assert!((f64::from(gauge.track) - 10_000.0 * (1.0 + track)).abs() <= 15.0, "{gauge:?}");
        }
    }

    #[test]
    fn what_makes_no_sense_is_refused_with_a_reason() {
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
        // Left and right confused in one of the two.
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
    fn several_measurements_are_averaged() {
        let at = |right_in, ahead_in| Offset { right_in, ahead_in };
        assert_eq!(Offset::mean(&[]), None);
        assert_eq!(
            Offset::mean(&[at(1.0, 2.0), at(3.0, -2.0)]),
            Some(at(2.0, 0.0))
        );
    }
}
