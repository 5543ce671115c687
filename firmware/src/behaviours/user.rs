//! Layer 0: the operator's hand, with a dead man's handle.

use super::Behaviour;
use crate::arbiter::Request;
use crate::drive::Motion;
use crate::sensors::Senses;
use crate::units::ticks;
use groundwave_protocol::letters::Mode;

/// A drive frame is good for this long: one second, by which an operator who lets go, or a link that
/// breaks, stops the robot within a foot.
pub const DEAD_MAN_TICKS: u8 = ticks(1) as u8;

/// What the hand asked for, and for how long that is still good.
#[derive(Clone, Debug, Default)]
pub struct User {
    motion: Motion,
    lease_ticks: u8,
}

impl User {
    /// A fresh drive frame.
    pub const fn drive(&mut self, motion: Motion) {
        self.motion = motion;
        self.lease_ticks = DEAD_MAN_TICKS;
    }

    /// Whether a drive frame is still good.
    #[must_use]
    pub const fn has_lease(&self) -> bool {
        self.lease_ticks > 0
    }
}

impl Behaviour for User {
    /// With a lease it overrides everything in every mode it runs in; in mode User without one it
    /// holds the robot still.
    fn decide(&mut self, senses: &Senses) -> Request {
        if self.lease_ticks > 0 {
            self.lease_ticks -= 1;
            Request::raise(self.motion)
        } else if senses.mode == Mode::User {
            Request::raise(Motion::STILL)
        } else {
            Request::QUIET
        }
    }

    fn rest(&mut self) {
        self.lease_ticks = 0;
    }
}
