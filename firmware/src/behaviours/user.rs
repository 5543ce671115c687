//! Layer 0: manual driving, which ends soon after the last drive frame (dead man's handle).

use super::behaviour::Behaviour;
use crate::arbiter::Request;
use crate::drive::Motion;
use crate::sensors::Senses;
use crate::units::ticks;
use groundwave_protocol::status_codes::Mode;

/// Validity of a drive frame: one second, after which a released key or a broken link stops the robot within a foot.
pub const DEAD_MAN_TICKS: u8 = ticks(1) as u8;

/// Latest manual motion and its remaining validity.
#[derive(Clone, Debug, Default)]
pub struct User {
    motion: Motion,
    lease_ticks: u8,
}

impl User {
    /// Takes a drive frame.
    pub const fn drive(&mut self, motion: Motion) {
        self.motion = motion;
        self.lease_ticks = DEAD_MAN_TICKS;
    }
}

impl Behaviour for User {
    /// A valid drive frame overrides all layers in every mode in which this layer runs; in mode User the robot otherwise
    /// stands still.
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
            ..Senses::idle()
        }
    }

    #[test]
    fn drive_frame_is_valid_for_exactly_one_second() {
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
    fn each_drive_frame_restarts_the_second() {
        let mut user = User::default();
        for _ in 0..3 {
            user.drive(Motion::new(1, 0));
            for _ in 0..19 {
                assert!(user.decide(&senses(Mode::Prowl)).flag);
            }
        }
    }

    #[test]
    fn mode_user_without_drive_frames_stands_still() {
        let mut user = User::default();
        let still = Request::raise(Motion::STILL);
        assert_eq!(user.decide(&senses(Mode::User)), still);
        assert_eq!(user.decide(&senses(Mode::Reactive)), Request::QUIET);
    }

    #[test]
    fn rest_forgets_the_drive_frame() {
        let mut user = User::default();
        user.drive(Motion::new(6, 0));
        user.rest();
        assert_eq!(user.decide(&senses(Mode::Prowl)), Request::QUIET);
    }
}
