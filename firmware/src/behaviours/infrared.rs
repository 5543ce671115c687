//! Layer 3: infrared collision avoidance. Away from the side that sees something.

use super::{Behaviour, prowl};
use crate::arbiter::Request;
use crate::drive::Motion;
use crate::sensors::Senses;
use crate::units::cps;

/// Turning away while driving on: 57 degrees a second, so that half a second clears a wall's edge.
const TURN_CPS: i16 = cps(10);

/// Turning on the spot: as fast, because both detectors see something within 30 inches.
const SPIN_CPS: i16 = cps(10);

/// It has no state: what it does follows from the detections alone.
#[derive(Clone, Debug, Default)]
pub struct InfraredAvoidance;

impl Behaviour for InfraredAvoidance {
    fn decide(&mut self, senses: &Senses) -> Request {
        let turn = |rotation_cps| Motion {
            velocity_cps: prowl::TOP_CPS / 2,
            rotation_cps,
        };
        match (senses.infrared.left, senses.infrared.right) {
            (false, false) => Request::QUIET,
            (true, false) => Request::raise(turn(TURN_CPS)),
            (false, true) => Request::raise(turn(-TURN_CPS)),
            (true, true) => Request::raise(Motion {
                velocity_cps: 0,
                rotation_cps: senses.the_way_it_turns(SPIN_CPS),
            }),
        }
    }

    fn rest(&mut self) {}
}
