//! What stands behind the arbiter, and what the robot says of it.

use super::Robot;
use crate::arbiter::MotorGuard;
use crate::board::{Inputs, TICK_HZ};
use crate::cliff::{Command, Missing};
use crate::drive::Motion;
use crate::parameters::Parameter;
use groundwave_protocol::letters::Mode;

/// What it says when the cliff guard takes the motors.
const EDGE_AHEAD: &str = "cliff guard: there is no floor ahead";
const EDGE_BEHIND: &str = "cliff guard: there is no floor behind";
const LIFTED: &str = "cliff guard: there is no floor under me";

/// What it says while the edge sensors guard nothing.
const GUARD_OFF: &str = "the cliff guard is switched off";

/// It says so again after this time.
const UNGUARDED_TICKS: u16 = 60 * TICK_HZ as u16;

impl Robot {
    /// Never drives with the arm up: what would move the robot stows it first.
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

    /// Who holds the motors in the place of who won them, from what the cliff guard made of that and the
    /// motion that it passed on to the arm's guard.
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

    /// Says once that the cliff guard has taken the motors, and from time to time that it never will.
    pub(super) fn tell_of_cliffs(&mut self, inputs: &Inputs) {
        if let Some(missing) = self.cliff_guard.take_news() {
            self.schedule.say(match missing {
                Missing::Ahead => EDGE_AHEAD,
                Missing::Behind => EDGE_BEHIND,
                Missing::Below => LIFTED,
            });
        }
        if inputs.cliff.is_none() || self.parameters.is_on(Parameter::CliffGuard) {
            self.unguarded_ticks = 0;
        } else if self.unguarded_ticks == 0 {
            self.unguarded_ticks = UNGUARDED_TICKS;
            self.schedule.say(GUARD_OFF);
            self.schedule.tell(Parameter::CliffGuard);
        } else {
            self.unguarded_ticks -= 1;
        }
    }
}
