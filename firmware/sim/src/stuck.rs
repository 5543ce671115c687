//! Detects a stuck robot.

use sr04_firmware::board::Outputs;

use crate::geometry::Pose;
use crate::plant::Truth;
use crate::time::TICK_MS;

/// Minimum distance that counts as progress, inches.
const STUCK_IN: f64 = 12.0;
/// Time with the motors on and without progress after which the robot is stuck, milliseconds.
const STUCK_MS: u64 = 5 * 60 * 1000;

/// Detects less than 12 inches of progress in 5 minutes with the motors on. Driving back and forth within that circle is
/// not progress.
#[derive(Clone, Debug, Default)]
pub(crate) struct StuckDetector {
    anchor: Pose,
    driven_ms: u64,
}

impl StuckDetector {
    /// Takes the state of a tick. Call once per tick.
    pub(crate) fn observe(&mut self, truth: &Truth, outputs: Outputs) {
        let (x, y) = (
            truth.pose.x_in - self.anchor.x_in,
            truth.pose.y_in - self.anchor.y_in,
        );
        if x * x + y * y >= STUCK_IN * STUCK_IN {
            self.anchor = truth.pose;
            self.driven_ms = 0;
        } else if outputs.pwm_left != 0 || outputs.pwm_right != 0 {
            self.driven_ms += TICK_MS;
        }
    }

    pub(crate) const fn is_stuck(&self) -> bool {
        self.driven_ms >= STUCK_MS
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn truth_at(y_in: f64) -> Truth {
        Truth {
            now_ms: 0,
            pose: Pose {
                x_in: 0.0,
                y_in,
                theta_deg: 0.0,
            },
            is_touching: false,
            has_fallen: false,
            is_hooked: false,
            is_docked: false,
            arm_raised: 0.0,
            speed_in_s: 0.0,
            path_in: 0.0,
            charge: 1.0,
        }
    }

    #[test]
    fn rocking_in_place_is_stuck_and_resting_is_not() {
        let driving = Outputs {
            pwm_left: 100,
            pwm_right: 100,
            ..Outputs::default()
        };
        let mut watch = StuckDetector::default();
        let ticks = STUCK_MS / TICK_MS;
        for tick in 0..ticks - 1 {
            watch.observe(&truth_at(if tick % 2 == 0 { 0.0 } else { 11.0 }), driving);
        }
        assert!(!watch.is_stuck());
        watch.observe(&truth_at(0.0), driving);
        assert!(watch.is_stuck());
        watch.observe(&truth_at(12.5), driving);
        assert!(!watch.is_stuck());
        for _ in 0..2 * ticks {
            watch.observe(&truth_at(12.5), Outputs::default());
        }
        assert!(!watch.is_stuck());
    }
}
