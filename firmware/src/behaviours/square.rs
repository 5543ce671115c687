//! The square of the calibration: four straight sides and four quarter turns on the spot, by odometry alone.
//!
//! Where the robot really ends tells what its wheels and its track really are (Borenstein and Feng, 1996);
//! the ground computes that. Here only precision counts: slow, never a turn back, and still before each turn.

use crate::angle::Angle;
use crate::arbiter::Request;
use crate::drive::Motion;
use crate::odometry::UNITS_PER_IN;
use crate::parameters::Parameter;
use crate::sensors::Senses;
use crate::units::{cps, ticks};

/// Along a side: slow enough to slip nowhere.
const CRUISE_CPS: i32 = cps(8) as i32;

/// The last inch.
const CREEP_CPS: i32 = cps(1) as i32;

/// From here on it slows down.
const SLOW_DOWN_PARTS: i32 = 16 * PARTS_PER_IN;

/// Nearer than this to a corner it is there: what creeping carries it on by.
const THERE_PARTS: i32 = PARTS_PER_IN / 16;

/// Turning on the spot: 29 degrees a second at most, 6 at least.
const TURN_MOST_CPS: i32 = cps(5) as i32;
const TURN_LEAST_CPS: i32 = cps(1) as i32;

/// Heading error for each count a second of rotation.
const ERROR_PER_CPS: i32 = 60;

/// Nearer than this to the heading it is there: a third of a degree, half a count.
const AIMED: i32 = 60;

/// Heading that a side off its line by an inch is driven with: 6 degrees.
const ERROR_PER_IN: i32 = 0x1_0000 / 60;

/// And at most: 15 degrees.
const ERROR_MOST: i32 = 0x1_0000 / 24;

/// Still for so long between two movements.
const PAUSE_TICKS: u8 = ticks(1) as u8 / 2;

/// Lengths here are 64ths of an inch.
const PARTS_PER_IN: i32 = 64;

/// Sides of a square.
const SIDES: u8 = 4;

/// Where in the square it is.
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

    /// The square begins where the odometer is zero, along +Y.
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

/// The pose as seen along a side of a clockwise square; a counter-clockwise one is its mirror image.
struct Place {
    /// Still to go along the side.
    left_parts: i32,
    /// Off its line, right positive.
    off_parts: i32,
    /// Off its heading, right positive.
    off_heading: i32,
    /// To the heading of the next side.
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

/// Along the side; `None` at its end.
fn drive(place: &Place) -> Option<Motion> {
    if place.left_parts <= THERE_PARTS {
        return None;
    }
    let speed =
        (CRUISE_CPS * place.left_parts.min(SLOW_DOWN_PARTS) / SLOW_DOWN_PARTS).max(CREEP_CPS);
    let off = place.off_parts.clamp(-8 * PARTS_PER_IN, 8 * PARTS_PER_IN);
    let back = (off * ERROR_PER_IN / PARTS_PER_IN).clamp(-ERROR_MOST, ERROR_MOST);
    // At a creep a correction would be a turn.
    let limit = speed / 2;
    let rotation = (-(place.off_heading + back) / ERROR_PER_CPS).clamp(-limit, limit);
    Some(Motion {
        velocity_cps: speed as i16,
        rotation_cps: rotation as i16,
    })
}

/// To the right on the spot; `None` when it looks along the next side, or past it.
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

    /// Drives a square with wheels that do at once what they are told; returns odometer and farthest corner.
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
                ..Senses::nothing()
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
        panic!("the square never ends");
    }

    #[test]
    fn it_ends_where_it_began_with_its_corners_where_they_belong() {
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
    fn a_square_of_no_length_is_four_turns() {
        let (odometer, x, y) = drive_square(0);
        assert!(x.abs() <= 2 && y <= 2);
        assert!(odometer.pose().heading.minus(Angle(0)).abs() < 200);
    }
}
