//! Layer 7: dead reckoning. Walks a list of points, or home.

use super::{Behaviour, prowl};
use crate::arbiter::Request;
use crate::sensors::Senses;
use groundwave_protocol::Waypoint;
use groundwave_protocol::letters::Mode;

/// Nearer than this to a point the robot is there: half its own width.
pub const ARRIVED_IN: i32 = 6;

/// The origin.
const HOME: Waypoint = Waypoint { x_in: 0, y_in: 0 };

/// The place in the list.
#[derive(Clone, Debug, Default)]
pub struct DeadReckoning {
    driven: u16,
    has_arrived: bool,
}

impl DeadReckoning {
    /// A new list: begin at its first point.
    pub fn restart(&mut self) {
        *self = Self::default();
    }

    /// Points of the list that have been reached.
    #[must_use]
    pub const fn driven(&self) -> u16 {
        self.driven
    }

    /// Where to go in a mode; `None` when the mode knows no target or the list is at its end.
    #[must_use]
    pub fn target(&self, mode: Mode, list: &[Waypoint]) -> Option<Waypoint> {
        match mode {
            Mode::Prowl => list.get(usize::from(self.driven)).copied(),
            Mode::GoHome => Some(HOME),
            _ => None,
        }
    }

    /// Moves on when the target was reached in this tick; returns whether it was the last one.
    pub fn take_arrival(&mut self, mode: Mode, list: &[Waypoint]) -> Option<bool> {
        if !core::mem::take(&mut self.has_arrived) {
            return None;
        }
        if mode == Mode::Prowl {
            self.driven += 1;
        }
        Some(mode == Mode::GoHome || usize::from(self.driven) >= list.len())
    }
}

impl Behaviour for DeadReckoning {
    fn decide(&mut self, senses: &Senses) -> Request {
        let Some(target) = senses.target else {
            return Request::QUIET;
        };
        self.has_arrived = prowl::distance_in(&senses.pose, target) < ARRIVED_IN;
        Request::raise(prowl::toward(senses, target))
    }

    /// The place in the list is kept.
    fn rest(&mut self) {
        self.has_arrived = false;
    }
}
