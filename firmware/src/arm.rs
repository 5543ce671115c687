//! The servo arm that carries the motion detectors, and the guard that never drives with it up.

use crate::drive::Motion;
use crate::units::ticks;

/// The servo needs half a second from one end to the other; two ticks more are for a tired one.
pub const SWING_TICKS: u8 = ticks(1) as u8 / 2 + 2;

/// Where the arm is, as far as that follows from what the servo was told.
///
/// A board that has just started may have been reset with the arm up: it counts as coming down.
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
    /// Guards the arbiter's output: the arm is up only while nothing would move the robot, whoever it
    /// is that would; and until it is down again the robot is held still.
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

    /// Whether it has had its time to come down.
    #[must_use]
    pub const fn is_stowed(&self) -> bool {
        !self.is_up && self.swing_ticks == 0
    }

    /// Whether the servo is told to raise it.
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
    fn what_would_move_the_robot_stows_the_arm_and_waits_until_it_is_down() {
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
    fn after_a_reset_the_arm_may_be_up() {
        let mut arm = ServoArm::default();
        let held = (0..20)
            .filter(|_| arm.guard(false, AHEAD) == Motion::STILL)
            .count();
        assert_eq!(held, usize::from(SWING_TICKS));
    }

    proptest! {
        #[test]
        fn nothing_moves_before_the_arm_has_had_its_time_to_come_down(
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
