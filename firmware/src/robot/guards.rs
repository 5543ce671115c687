//! The guards behind the arbiter, and the texts about them.

use super::Robot;
use crate::arbiter::MotorGuard;
use crate::board::{Inputs, TICK_HZ};
use crate::cliff::{Command, Missing};
use crate::drive::Motion;
use crate::parameters::Parameter;
use groundwave_protocol::status_codes::Mode;

/// Texts when the cliff guard takes the motors.
const EDGE_AHEAD: &str = "cliff guard: there is no floor ahead";
const EDGE_BEHIND: &str = "cliff guard: there is no floor behind";
const LIFTED: &str = "cliff guard: there is no floor under me";

/// Text while the cliff guard is switched off.
const GUARD_OFF: &str = "the cliff guard is switched off";

/// Number of ticks between two reports of a safeguard that is off.
const UNGUARDED_TICKS: u16 = 60 * TICK_HZ as u16;

impl Robot {
    /// Prevents driving with the arm raised: a motion stows it first.
    pub(super) fn guard_arm(&mut self, inputs: &Inputs, motion: Motion) -> Motion {
        if inputs.motion.is_none() {
            return motion;
        }
        let wants_arm = self.layers.motion.wants_arm();
        if wants_arm && motion != Motion::STILL {
            self.layers.motion.interrupt();
        }
        self.arm.guard(wants_arm, motion)
    }

    /// Guard that controls the motors in place of the holder. `passed_on` is the motion from the cliff guard to the arm's
    /// guard.
    pub(super) fn guarded_by(&self, command: Command, passed_on: Motion) -> Option<MotorGuard> {
        if self.mode == Mode::Stop {
            None
        } else if command == Command::Brake || self.cliff_guard.acts() {
            Some(MotorGuard::Cliff)
        } else if self.motion != passed_on {
            Some(MotorGuard::Arm)
        } else {
            None
        }
    }

    /// Reports when the cliff guard takes the motors, and from time to time which safeguards are switched off: a station
    /// that has just begun to listen cannot know.
    pub(super) fn report_guards(&mut self, inputs: &Inputs) {
        if let Some(missing) = self.cliff_guard.take_report() {
            self.schedule.queue_text(match missing {
                Missing::Ahead => EDGE_AHEAD,
                Missing::Behind => EDGE_BEHIND,
                Missing::Below => LIFTED,
            });
        }
        let safeguards = [
            (Parameter::CliffGuard, inputs.cliff.is_some()),
            (Parameter::CriticalBattery, true),
        ];
        for ((safeguard, is_fitted), ticks) in safeguards.into_iter().zip(&mut self.unguarded_ticks)
        {
            if !is_fitted || self.parameters.is_on(safeguard) {
                *ticks = 0;
            } else if *ticks == 0 {
                *ticks = UNGUARDED_TICKS;
                self.schedule.queue_parameter(safeguard);
                if safeguard == Parameter::CliffGuard {
                    self.schedule.queue_text(GUARD_OFF);
                }
            } else {
                *ticks -= 1;
            }
        }
    }
}
