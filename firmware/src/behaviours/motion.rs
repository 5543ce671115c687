//! Layer 6: the motion detectors. At rest it raises them on their arm, and charges at what moves.

use super::Behaviour;
use crate::arbiter::Request;
use crate::arm::SWING_TICKS;
use crate::board::Sides;
use crate::drive::Motion;
use crate::parameters::Parameter;
use crate::sensors::Senses;
use crate::units::{TICKS_PER_S, cps, ticks};

/// At rest for this long the robot has stopped, not paused.
const REST_TICKS: u8 = ticks(1) as u8;

/// What the arm was raised into may go away by then.
const RETRY_TICKS: u16 = ticks(30);

/// The detectors give a pulse of some tenths of a second for a body, and now and then one of a tick for
/// nothing.
const SURE_TICKS: u8 = 2;

/// Rotation while charging to a side: a bow of about 70 degrees in the 1.5 s of a robot never tuned.
const CHARGE_TURN_CPS: i16 = cps(8);

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum State {
    /// Stowed; the robot moves, or has only just stopped.
    #[default]
    Stowed,
    /// Up; the detectors settle.
    Settling { ticks: u16 },
    /// Waiting for motion, which has been seen for so many ticks.
    Armed { sure_ticks: u8 },
    /// On its way down, before the charge.
    Retracting { rotation_cps: i16, ticks_left: u8 },
    /// At whatever moved.
    Charging { rotation_cps: i16, ticks_left: u16 },
}

/// The sequence: deploy, settle, arm, detect, retract, charge.
#[derive(Clone, Debug, Default)]
pub struct MotionDetector {
    state: State,
    rest_ticks: u8,
    retry_ticks: u16,
    seen: Sides,
    touched: bool,
}

impl MotionDetector {
    /// Whether it wants the arm up.
    #[must_use]
    pub const fn wants_arm(&self) -> bool {
        matches!(self.state, State::Settling { .. } | State::Armed { .. })
    }

    /// Whether it waits for motion.
    #[must_use]
    pub const fn is_armed(&self) -> bool {
        matches!(self.state, State::Armed { .. })
    }

    /// Whether motion was detected, and the charge at it is not over.
    #[must_use]
    pub const fn has_fired(&self) -> bool {
        matches!(
            self.state,
            State::Retracting { .. } | State::Charging { .. }
        )
    }

    /// Where something moved, at the tick at which that was believed.
    #[must_use]
    pub const fn seen(&self) -> Sides {
        self.seen
    }

    /// Whether the arm touched something at this tick.
    #[must_use]
    pub const fn touched(&self) -> bool {
        self.touched
    }

    /// Another layer moves the robot: the sequence begins anew when it rests again.
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
                            (true, false) => -CHARGE_TURN_CPS,
                            (false, true) => CHARGE_TURN_CPS,
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
                    // Tenths of a second.
                    let charge_ticks = senses.parameters.get(Parameter::Charge) * TICKS_PER_S / 10;
                    self.state = State::Charging {
                        rotation_cps: *rotation_cps,
                        ticks_left: charge_ticks as u16,
                    };
                }
            }
            State::Charging { ticks_left, .. } => *ticks_left -= 1,
        }
        if let State::Charging { ticks_left: 0, .. } = self.state {
            self.interrupt();
        }
        match self.state {
            State::Stowed => Request::QUIET,
            State::Charging { rotation_cps, .. } => Request::raise(Motion {
                velocity_cps: senses.top_cps(),
                rotation_cps,
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
            ..Senses::nothing()
        }
    }

    fn armed() -> MotionDetector {
        let mut layer = MotionDetector::default();
        let mut ticks = 0;
        while !layer.is_armed() {
            layer.decide(&at_rest(BOTH));
            ticks += 1;
            assert!(ticks <= 320, "1 s of rest and 15 s of settling");
        }
        assert_eq!(ticks, 320);
        layer
    }

    #[test]
    fn at_rest_it_deploys_settles_and_arms_whatever_the_detectors_say_meanwhile() {
        let mut layer = armed();
        assert!(layer.wants_arm());
        let request = layer.decide(&at_rest(NONE));
        assert_eq!(request, Request::raise(Motion::STILL));
    }

    #[test]
    fn it_does_not_deploy_while_the_robot_moves() {
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
    fn it_retracts_and_charges_to_where_something_moved() {
        for (sides, sign) in [(LEFT, -1), (RIGHT, 1), (BOTH, 0)] {
            let mut layer = armed();
            assert!(layer.decide(&at_rest(sides)).flag && layer.wants_arm());
            assert_eq!(layer.decide(&at_rest(sides)).motion, Motion::STILL);
            assert_eq!(layer.seen(), sides);
            assert!(!layer.wants_arm() && layer.has_fired());
            for _ in 1..SWING_TICKS {
                assert_eq!(layer.decide(&at_rest(NONE)).motion, Motion::STILL);
            }
            for tick in 0..30 {
                let motion = layer.decide(&at_rest(NONE)).motion;
                assert_eq!(
                    motion.velocity_cps,
                    Senses::nothing().top_cps(),
                    "tick {tick}"
                );
                assert_eq!(motion.rotation_cps.signum(), sign);
            }
            assert_eq!(layer.decide(&at_rest(NONE)), Request::QUIET);
            assert!(!layer.has_fired());
        }
    }

    #[test]
    fn one_tick_of_it_is_no_motion() {
        let mut layer = armed();
        for tick in 0..100 {
            layer.decide(&at_rest(if tick % 2 == 0 { LEFT } else { NONE }));
            assert!(layer.is_armed());
        }
    }

    #[test]
    fn the_top_hat_switch_stows_the_arm_and_it_tries_again_later() {
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
    fn without_detectors_it_is_quiet() {
        let mut layer = MotionDetector::default();
        let senses = Senses {
            motion: None,
            ..at_rest(NONE)
        };
        assert!((0..400).all(|_| layer.decide(&senses) == Request::QUIET));
    }
}
