//! The calibration square: four straight sides and four quarter turns on the spot, by odometry alone.
//!
//! The true end position reveals the true wheels and track (Borenstein and Feng, 1996); the ground station computes them.
//! The square must be precise: it is driven slowly, without turning back, and with a stop before each turn.

use crate::angle::Angle;
use crate::arbiter::Request;
use crate::drive::Motion;
use crate::odometry::UNITS_PER_IN;
use crate::parameters::Parameter;
use crate::sensors::Senses;
use crate::units::{cps, ticks};

/// Speed along a side: slow enough not to slip.
const CRUISE_CPS: i32 = cps(8) as i32;

/// Speed on the last inch.
const CREEP_CPS: i32 = cps(1) as i32;

/// Distance from a corner at which the robot slows down.
const SLOW_DOWN_PARTS: i32 = 16 * PARTS_PER_IN;

/// Distance from a corner that counts as reached: the robot creeps on by as much.
const THERE_PARTS: i32 = PARTS_PER_IN / 16;

/// Rotation on the spot: at most 29 degrees per second, at least 6.
const TURN_MOST_CPS: i32 = cps(5) as i32;
const TURN_LEAST_CPS: i32 = cps(1) as i32;

/// Heading error for each count per second of rotation.
const ERROR_PER_CPS: i32 = 60;

/// Heading error that counts as reached: a third of a degree, half a count.
const AIMED: i32 = 60;

/// Heading correction per inch off the line: 6 degrees.
const ERROR_PER_IN: i32 = 0x1_0000 / 60;

/// Maximum heading correction: 15 degrees.
const ERROR_MOST: i32 = 0x1_0000 / 24;

/// Duration of a stop between two movements.
const PAUSE_TICKS: u8 = ticks(1) as u8 / 2;

/// Unit of lengths in this file: 1/64 inch.
const PARTS_PER_IN: i32 = 64;

/// Number of sides.
const SIDES: u8 = 4;

/// Progress of the square.
#[derive(Clone, Debug, Default)]
pub struct Square {
    side: u8,
    is_turning: bool,
    pause_ticks: u8,
    is_done: bool,
}

impl Square {
    /// Whether the square was finished in this tick.
    pub fn take_done(&mut self) -> bool {
        core::mem::take(&mut self.is_done)
    }

    /// Request of this tick. The square begins at the origin along +Y.
    pub fn decide(&mut self, senses: &Senses) -> Request {
        if self.side >= SIDES {
            return Request::raise(Motion::STILL);
        }
        if self.pause_ticks > 0 {
            self.pause_ticks -= 1;
            return Request::raise(Motion::STILL);
        }
        let length_in = i32::from(senses.parameters.get(Parameter::Square));
        let hand = if length_in < 0 { -1 } else { 1 };
        let place = Place::on(self.side, senses, length_in.abs() * PARTS_PER_IN, hand);
        let motion = if self.is_turning {
            turn(&place)
        } else {
            drive(&place)
        };
        let Some(motion) = motion else {
            self.next();
            return Request::raise(Motion::STILL);
        };
        Request::raise(Motion {
            rotation_cps: motion.rotation_cps * hand as i16,
            ..motion
        })
    }

    fn next(&mut self) {
        self.pause_ticks = PAUSE_TICKS;
        if self.is_turning {
            self.side += 1;
            self.is_done = self.side >= SIDES;
        }
        self.is_turning = !self.is_turning;
    }
}

/// Pose relative to a side of a clockwise square; a counterclockwise one is mirrored.
struct Place {
    /// Distance left along the side.
    left_parts: i32,
    /// Distance from the line, positive to the right.
    off_parts: i32,
    /// Heading error, positive to the right.
    off_heading: i32,
    /// Angle left to the heading of the next side.
    to_turn: i32,
}

impl Place {
    fn on(side: u8, senses: &Senses, length_parts: i32, hand: i32) -> Self {
        let parts = |units: i32| units / (UNITS_PER_IN / PARTS_PER_IN);
        let x = parts(senses.pose.x_units) * hand;
        let y = parts(senses.pose.y_units);
        let (along, off_parts) = match side {
            0 => (y, x),
            1 => (x, length_parts - y),
            2 => (length_parts - y, length_parts - x),
            _ => (length_parts - x, y),
        };
        let heading = i32::from(senses.pose.heading.0) * hand;
        let off =
            |ahead: i32| i32::from(Angle(heading as u16).minus(Angle((ahead * 0x4000) as u16)));
        Self {
            left_parts: length_parts - along,
            off_parts,
            off_heading: off(i32::from(side)),
            to_turn: -off(i32::from(side) + 1),
        }
    }
}

/// Motion along the side; `None` at its end.
fn drive(place: &Place) -> Option<Motion> {
    if place.left_parts <= THERE_PARTS {
        return None;
    }
    let speed =
        (CRUISE_CPS * place.left_parts.min(SLOW_DOWN_PARTS) / SLOW_DOWN_PARTS).max(CREEP_CPS);
    let off = place.off_parts.clamp(-8 * PARTS_PER_IN, 8 * PARTS_PER_IN);
    let back = (off * ERROR_PER_IN / PARTS_PER_IN).clamp(-ERROR_MOST, ERROR_MOST);
    // At creeping speed, a large correction would be a turn.
    let limit = speed / 2;
    let rotation = (-(place.off_heading + back) / ERROR_PER_CPS).clamp(-limit, limit);
    Some(Motion {
        velocity_cps: speed as i16,
        rotation_cps: rotation as i16,
    })
}

/// Right turn on the spot; `None` at or past the heading of the next side.
fn turn(place: &Place) -> Option<Motion> {
    if place.to_turn <= AIMED {
        return None;
    }
    let rotation = (place.to_turn / ERROR_PER_CPS).clamp(TURN_LEAST_CPS, TURN_MOST_CPS);
    Some(Motion {
        velocity_cps: 0,
        rotation_cps: rotation as i16,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::odometry::Odometer;
    use crate::parameters::Parameters;

    /// Drives a square with wheels that follow commands at once; returns the odometer and the farthest corner.
    fn drive_square(length_in: i16) -> (Odometer, i32, i32) {
        let mut parameters = Parameters::DEFAULT;
        assert!(parameters.set(Parameter::Square, length_in));
        let mut square = Square::default();
        let mut odometer = Odometer::default();
        let (mut rest, mut farthest) = ((0, 0), (0, 0));
        for _ in 0..20_000 {
            let senses = Senses {
                parameters: &parameters,
                pose: odometer.pose(),
                ..Senses::idle()
            };
            let request = square.decide(&senses);
            assert!(request.flag);
            if square.take_done() {
                return (odometer, farthest.0, farthest.1);
            }
            let (left, right) = request.motion.wheels();
            rest = (rest.0 + left, rest.1 + right);
            odometer.advance(rest.0 / 20, rest.1 / 20);
            rest = (rest.0 % 20, rest.1 % 20);
            let pose = odometer.pose();
            farthest.0 = if pose.x_tenths_in().abs() > i32::abs(farthest.0) {
                pose.x_tenths_in()
            } else {
                farthest.0
            };
            farthest.1 = farthest.1.max(pose.y_tenths_in());
        }
        panic!("the square does not end within 20,000 ticks");
    }

    #[test]
    fn square_ends_at_its_start_with_exact_corners() {
        for (length_in, sign) in [(157, 1), (-157, -1), (40, 1), (-400, -1)] {
            let (odometer, x, y) = drive_square(length_in);
            let pose = odometer.pose();
            assert!(pose.x_tenths_in().abs() <= 5, "{length_in}: {pose:?}");
            assert!(pose.y_tenths_in().abs() <= 5, "{length_in}: {pose:?}");
            assert!(pose.heading.minus(Angle(0)).abs() < 200, "{pose:?}");
            let side = i32::from(length_in.abs()) * 10;
            assert!((x * sign - side).abs() <= 5, "{x}");
            assert!((y - side).abs() <= 5, "{y}");
        }
    }

    #[test]
    fn square_without_length_is_four_turns() {
        let (odometer, x, y) = drive_square(0);
        assert!(x.abs() <= 2 && y <= 2);
        assert!(odometer.pose().heading.minus(Angle(0)).abs() < 200);
    }
}
