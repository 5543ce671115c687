//! Layer 6: motion detectors. Raises them on their arm at rest, and charges at a detected motion.

use super::behaviour::Behaviour;
use crate::arbiter::Request;
use crate::arm::SWING_TICKS;
use crate::board::Sides;
use crate::drive::Motion;
use crate::parameters::Parameter;
use crate::sensors::Senses;
use crate::units::{TICKS_PER_S, cps, ticks};

/// Number of ticks of standing that count as rest.
const REST_TICKS: u8 = ticks(1) as u8;

/// Number of ticks until the arm is raised again after it has touched an obstacle.
const RETRY_TICKS: u16 = ticks(30);

/// Number of ticks that a detection must last: a body gives a pulse of some tenths of a second, a false alarm often a single tick.
const SURE_TICKS: u8 = 2;

/// Turn on the spot before a charge to one side, 60 degrees: an arc would slow the charge.
const AIM_CPS: i16 = cps(16);
const AIM_TICKS: u16 = 14;

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum State {
    /// Stowed; the robot moves or has just stopped.
    #[default]
    Stowed,
    /// Raised; the detectors settle.
    Settling { ticks: u16 },
    /// Waits for motion, which has lasted for `sure_ticks`.
    Armed { sure_ticks: u8 },
    /// Stows the arm before the charge.
    Retracting { rotation_cps: i16, ticks_left: u8 },
    /// Charges at the motion.
    Charging {
        aim: Motion,
        aim_ticks: u16,
        ticks_left: u16,
    },
}

/// State of the layer: raise, settle, arm, detect, stow, charge.
#[derive(Clone, Debug, Default)]
pub struct MotionDetector {
    state: State,
    rest_ticks: u8,
    retry_ticks: u16,
    seen: Sides,
    touched: bool,
}

impl MotionDetector {
    /// Whether the layer requests the raised arm.
    #[must_use]
    pub const fn wants_arm(&self) -> bool {
        matches!(self.state, State::Settling { .. } | State::Armed { .. })
    }

    /// Whether the detectors are armed.
    #[must_use]
    pub const fn is_armed(&self) -> bool {
        matches!(self.state, State::Armed { .. })
    }

    /// Whether a motion was detected and its charge has not ended.
    #[must_use]
    pub const fn has_fired(&self) -> bool {
        matches!(
            self.state,
            State::Retracting { .. } | State::Charging { .. }
        )
    }

    /// Sides of a motion in the tick of its detection.
    #[must_use]
    pub const fn seen(&self) -> Sides {
        self.seen
    }

    /// Whether the arm touched an obstacle in this tick.
    #[must_use]
    pub const fn touched(&self) -> bool {
        self.touched
    }

    /// Restarts the sequence because another layer moves the robot.
    pub fn interrupt(&mut self) {
        self.state = State::Stowed;
        self.rest_ticks = 0;
    }

    fn watch_rest(&mut self, senses: &Senses) {
        self.rest_ticks = if senses.is_standing {
            self.rest_ticks.saturating_add(1)
        } else {
            0
        };
        if self.rest_ticks >= REST_TICKS && self.retry_ticks == 0 {
            self.state = State::Settling { ticks: 0 };
        }
    }

    fn wait(&mut self, senses: &Senses, sides: Sides) {
        if senses.top_hat {
            self.interrupt();
            self.touched = true;
            self.retry_ticks = RETRY_TICKS;
            return;
        }
        match &mut self.state {
            State::Settling { ticks } => {
                *ticks += 1;
                let settle_s = senses.parameters.get(Parameter::Settle) as u16;
                if *ticks >= settle_s.saturating_mul(TICKS_PER_S as u16) {
                    self.state = State::Armed { sure_ticks: 0 };
                }
            }
            State::Armed { sure_ticks } if sides.any() => {
                *sure_ticks += 1;
                if *sure_ticks >= SURE_TICKS {
                    self.seen = sides;
                    self.state = State::Retracting {
                        rotation_cps: match (sides.left, sides.right) {
                            (true, false) => -AIM_CPS,
                            (false, true) => AIM_CPS,
                            _ => 0,
                        },
                        ticks_left: SWING_TICKS,
                    };
                }
            }
            State::Armed { sure_ticks } => *sure_ticks = 0,
            _ => {}
        }
    }
}

impl Behaviour for MotionDetector {
    fn decide(&mut self, senses: &Senses) -> Request {
        let Some(sides) = senses.motion else {
            self.rest();
            return Request::QUIET;
        };
        self.seen = Sides::default();
        self.touched = false;
        self.retry_ticks = self.retry_ticks.saturating_sub(1);
        match &mut self.state {
            State::Stowed => self.watch_rest(senses),
            State::Settling { .. } | State::Armed { .. } => self.wait(senses, sides),
            State::Retracting {
                rotation_cps,
                ticks_left,
            } => {
                *ticks_left -= 1;
                if *ticks_left == 0 {
                    // The parameter is in tenths of a second.
                    let charge_ticks = senses.parameters.get(Parameter::Charge) * TICKS_PER_S / 10;
                    self.state = State::Charging {
                        aim: Motion {
                            velocity_cps: 0,
                            rotation_cps: *rotation_cps,
                        },
                        aim_ticks: if *rotation_cps == 0 { 0 } else { AIM_TICKS },
                        ticks_left: charge_ticks as u16,
                    };
                }
            }
            State::Charging { aim_ticks, .. } if *aim_ticks > 0 => *aim_ticks -= 1,
            State::Charging { ticks_left, .. } => *ticks_left -= 1,
        }
        if let State::Charging { ticks_left: 0, .. } = self.state {
            self.interrupt();
        }
        match self.state {
            State::Stowed => Request::QUIET,
            State::Charging { aim, aim_ticks, .. } if aim_ticks > 0 => Request::raise(aim),
            State::Charging { .. } => Request::raise(Motion {
                velocity_cps: senses.top_cps(),
                rotation_cps: 0,
            }),
            _ => Request::raise(Motion::STILL),
        }
    }

    fn rest(&mut self) {
        *self = Self::default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LEFT: Sides = Sides {
        left: true,
        right: false,
    };
    const RIGHT: Sides = Sides {
        left: false,
        right: true,
    };
    const BOTH: Sides = Sides {
        left: true,
        right: true,
    };
    const NONE: Sides = Sides {
        left: false,
        right: false,
    };

    fn at_rest(motion: Sides) -> Senses<'static> {
        Senses {
            motion: Some(motion),
            is_standing: true,
            ..Senses::idle()
        }
    }

    fn armed() -> MotionDetector {
        let mut layer = MotionDetector::default();
        let mut ticks = 0;
        while !layer.is_armed() {
            layer.decide(&at_rest(BOTH));
            ticks += 1;
            assert!(
                ticks <= 320,
                "the layer arms after 1 s of rest and 15 s of settling"
            );
        }
        assert_eq!(ticks, 320);
        layer
    }

    #[test]
    fn resting_robot_raises_and_arms_the_detectors() {
        let mut layer = armed();
        assert!(layer.wants_arm());
        let request = layer.decide(&at_rest(NONE));
        assert_eq!(request, Request::raise(Motion::STILL));
    }

    #[test]
    fn moving_robot_does_not_raise_the_arm() {
        let mut layer = MotionDetector::default();
        for tick in 0..1000 {
            let senses = Senses {
                is_standing: tick % 19 != 0,
                ..at_rest(NONE)
            };
            assert_eq!(layer.decide(&senses), Request::QUIET);
            assert!(!layer.wants_arm());
        }
    }

    #[test]
    fn detection_stows_the_arm_and_charges_to_its_side() {
        for (sides, sign) in [(LEFT, -1), (RIGHT, 1), (BOTH, 0)] {
            let mut layer = armed();
            assert!(layer.decide(&at_rest(sides)).flag && layer.wants_arm());
            assert_eq!(layer.decide(&at_rest(sides)).motion, Motion::STILL);
            assert_eq!(layer.seen(), sides);
            assert!(!layer.wants_arm() && layer.has_fired());
            for _ in 1..SWING_TICKS {
                assert_eq!(layer.decide(&at_rest(NONE)).motion, Motion::STILL);
            }
            let aim_ticks = if sign == 0 { 0 } else { AIM_TICKS };
            for _ in 0..aim_ticks {
                let motion = layer.decide(&at_rest(NONE)).motion;
                assert_eq!(
                    (motion.velocity_cps, motion.rotation_cps),
                    (0, AIM_CPS * sign)
                );
            }
            for tick in 0..30 {
                let motion = layer.decide(&at_rest(NONE)).motion;
                let full_speed = (Senses::idle().top_cps(), Senses::idle().top_cps());
                assert_eq!(motion.wheels(), full_speed, "tick {tick}");
            }
            assert_eq!(layer.decide(&at_rest(NONE)), Request::QUIET);
            assert!(!layer.has_fired());
        }
    }

    #[test]
    fn detection_of_one_tick_is_ignored() {
        let mut layer = armed();
        for tick in 0..100 {
            layer.decide(&at_rest(if tick % 2 == 0 { LEFT } else { NONE }));
            assert!(layer.is_armed());
        }
    }

    #[test]
    fn top_switch_stows_the_arm_until_a_later_try() {
        for wait_ticks in [5, 310] {
            let mut layer = MotionDetector::default();
            for _ in 0..20 + wait_ticks {
                layer.decide(&at_rest(NONE));
            }
            assert!(layer.wants_arm());
            let touching = Senses {
                top_hat: true,
                ..at_rest(NONE)
            };
            assert_eq!(layer.decide(&touching), Request::QUIET);
            assert!(layer.touched() && !layer.wants_arm());
            for _ in 1..RETRY_TICKS {
                layer.decide(&at_rest(NONE));
                assert!(!layer.wants_arm() && !layer.touched());
            }
            layer.decide(&at_rest(NONE));
            assert!(layer.wants_arm());
        }
    }

    #[test]
    fn missing_detectors_are_no_request() {
        let mut layer = MotionDetector::default();
        let senses = Senses {
            motion: None,
            ..at_rest(NONE)
        };
        assert!((0..400).all(|_| layer.decide(&senses) == Request::QUIET));
    }
}
