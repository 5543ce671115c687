//! The servo arm that carries the motion detectors, and the guard that prevents driving with it raised.

use crate::drive::Motion;
use crate::units::ticks;

/// Number of ticks of a servo movement: half a second from one end to the other, and two ticks for a slow servo.
pub const SWING_TICKS: u8 = ticks(1) as u8 / 2 + 2;

/// Position of the arm, derived from the servo commands.
///
/// After a reset the arm may be raised, so it counts as moving down.
#[derive(Clone, Debug)]
pub struct ServoArm {
    is_up: bool,
    swing_ticks: u8,
}

impl Default for ServoArm {
    fn default() -> Self {
        Self {
            is_up: false,
            swing_ticks: SWING_TICKS,
        }
    }
}

impl ServoArm {
    /// Guards the arbiter's output: raises the arm only without a motion, and stops the robot until the arm is stowed.
    pub fn guard(&mut self, wants_up: bool, motion: Motion) -> Motion {
        self.is_up = wants_up && motion == Motion::STILL;
        if self.is_up {
            self.swing_ticks = SWING_TICKS;
            return Motion::STILL;
        }
        if self.swing_ticks > 0 {
            self.swing_ticks -= 1;
            return Motion::STILL;
        }
        motion
    }

    /// Whether the arm has had time to stow.
    #[must_use]
    pub const fn is_stowed(&self) -> bool {
        !self.is_up && self.swing_ticks == 0
    }

    /// Whether the servo is commanded to raise the arm.
    #[must_use]
    pub const fn is_up(&self) -> bool {
        self.is_up
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const AHEAD: Motion = Motion::new(6, 0);

    #[test]
    fn motion_stows_the_arm_and_waits_until_it_is_down() {
        let mut arm = ServoArm::default();
        arm.guard(true, Motion::STILL);
        assert!(arm.is_up());
        for tick in 0..SWING_TICKS {
            assert_eq!(arm.guard(true, AHEAD), Motion::STILL, "tick {tick}");
            assert!(!arm.is_up());
        }
        assert_eq!(arm.guard(true, AHEAD), AHEAD);
    }

    #[test]
    fn arm_counts_as_raised_after_a_reset() {
        let mut arm = ServoArm::default();
        let held = (0..20)
            .filter(|_| arm.guard(false, AHEAD) == Motion::STILL)
            .count();
        assert_eq!(held, usize::from(SWING_TICKS));
    }

    proptest! {
        #[test]
        fn motion_waits_for_the_arm_to_stow(
            steps in proptest::collection::vec(any::<(bool, bool)>(), 0..200)
        ) {
            let (mut arm, mut since_up) = (ServoArm::default(), 0);
            for (wants_up, moves) in steps {
                let asked = if moves { AHEAD } else { Motion::STILL };
                let motion = arm.guard(wants_up, asked);
                since_up = if arm.is_up() { 0 } else { since_up + 1 };
                prop_assert!(motion == Motion::STILL || since_up > u32::from(SWING_TICKS));
                prop_assert!(motion == Motion::STILL || motion == asked);
            }
        }
    }
}
