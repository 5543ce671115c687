//! The servo arm at the rear that lifts the motion detectors above the bumper.

use crate::time::TICK_MS;

/// Travel time of the servo from one end to the other, milliseconds.
const TRAVEL_MS: f64 = 500.0;
/// Height of the switch on the arm's top, stowed and raised.
const STOWED_IN: f64 = 8.0;
const RAISED_IN: f64 = 16.0;

/// The arm's state.
#[derive(Clone, Debug, Default)]
pub(crate) struct Arm {
    /// 0 stowed to 1 raised.
    raised: f64,
    is_moving: bool,
    is_pressed: bool,
}

impl Arm {
    /// Moves the servo for one tick below a board at `headroom_in`.
    pub(crate) fn step(&mut self, up: bool, headroom_in: f64) {
        let stride = TICK_MS as f64 / TRAVEL_MS;
        let goal = self.raised + if up { stride } else { -stride };
        let ceiling = (headroom_in - STOWED_IN) / (RAISED_IN - STOWED_IN);
        let before = self.raised;
        self.is_pressed = goal.min(1.0) > ceiling;
        self.raised = goal.min(ceiling).clamp(0.0, 1.0);
        self.is_moving = (self.raised - before).abs() > 1e-9;
    }

    /// Position, 0 stowed to 1 raised.
    pub(crate) const fn raised(&self) -> f64 {
        self.raised
    }

    /// Whether the arm is raised and at rest.
    pub(crate) fn is_up(&self) -> bool {
        self.raised > 1.0 - 1e-9 && !self.is_moving
    }

    /// Whether the switch on the arm's top is pressed.
    pub(crate) const fn top_hat(&self) -> bool {
        self.is_pressed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arm_takes_half_a_second_up_and_down() {
        let mut arm = Arm::default();
        for (up, end) in [(true, 1.0), (false, 0.0)] {
            for tick in 1..=10 {
                arm.step(up, f64::INFINITY);
                assert!(!arm.is_up(), "tick {tick}");
            }
            assert!((arm.raised() - end).abs() < 1e-9, "{}", arm.raised());
            arm.step(up, f64::INFINITY);
            assert_eq!(arm.is_up(), up);
            assert!(!arm.top_hat());
        }
    }

    #[test]
    fn top_switch_stops_the_arm_below_a_low_board() {
        let mut arm = Arm::default();
        for _ in 0..20 {
            arm.step(true, 14.0);
        }
        assert!(arm.top_hat() && !arm.is_up());
        assert!((arm.raised() - 0.75).abs() < 1e-9, "{}", arm.raised());
        arm.step(false, 14.0);
        assert!(!arm.top_hat());
    }
}
