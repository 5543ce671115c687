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

#[cfg(test)]
mod tests {
    use super::*;

    fn senses(mode: Mode) -> Senses<'static> {
        Senses {
            mode,
            ..Senses::nothing()
        }
    }

    #[test]
    fn a_drive_frame_is_good_for_exactly_a_second_of_ticks() {
        let mut user = User::default();
        let motion = Motion::new(6, -4);
        user.drive(motion);
        for tick in 0..20 {
            let wanted = Request::raise(motion);
            assert_eq!(user.decide(&senses(Mode::Prowl)), wanted, "tick {tick}");
        }
        assert_eq!(user.decide(&senses(Mode::Prowl)), Request::QUIET);
    }

    #[test]
    fn each_frame_begins_the_second_anew() {
        let mut user = User::default();
        for _ in 0..3 {
            user.drive(Motion::new(1, 0));
            for _ in 0..19 {
                assert!(user.decide(&senses(Mode::Prowl)).flag);
            }
        }
    }

    #[test]
    fn without_a_hand_mode_user_stands_still_and_other_modes_are_free() {
        let mut user = User::default();
        let still = Request::raise(Motion::STILL);
        assert_eq!(user.decide(&senses(Mode::User)), still);
        assert_eq!(user.decide(&senses(Mode::Reactive)), Request::QUIET);
    }

    #[test]
    fn what_the_hand_wanted_is_forgotten_while_the_layer_is_off() {
        let mut user = User::default();
        user.drive(Motion::new(6, 0));
        user.rest();
        assert_eq!(user.decide(&senses(Mode::Prowl)), Request::QUIET);
    }
}
