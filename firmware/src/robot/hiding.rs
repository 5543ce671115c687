//! Mode Passive as the robot enters, goes through and leaves it, and the turns it asks for.

use super::Robot;
use crate::arbiter::Holder;
use crate::behaviours::{Ending, Passive, Step};
use crate::parameters::Parameter;
use crate::song::Song;
use groundwave_protocol::letters::{Layer, Mode};

/// What it says when somebody or something was in the way of a look around.
const SCAN_BROKEN_OFF: &str = "scan: broken off";

impl Robot {
    /// Whether bumps may send it into hiding: only while it prowls without an aim.
    pub(super) fn may_hide(&self) -> bool {
        self.mode == Mode::Prowl
            && self.target().is_none()
            && self.parameters.is_on(Parameter::Behaviour)
            && self.allowed().contains(Layer::Motion)
            && self.allowed().contains(Layer::Rotation)
    }

    /// Mode Passive begins. After the dock it goes on in it, and then back to what was before both; begun anew
    /// it still goes back to what was before.
    pub(super) fn begin_hiding(&mut self) {
        if !matches!(self.mode, Mode::Forage | Mode::Passive) {
            self.mode_before = self.mode;
        }
        self.passive = Passive::default();
        self.bump_sequence.forget();
    }

    /// A turn or a look around that has ended is told, and mode Passive goes on. Whoever above the
    /// rotation layer holds the motors ends it.
    pub(super) fn finish_turns(&mut self) {
        let is_free = !matches!(
            self.holder,
            Some(Holder::Layer(Layer::User | Layer::Bumpers))
        );
        if !is_free {
            self.layers.rotation.break_off();
        }
        let ending = self.layers.rotation.take_ending();
        match ending {
            Some(Ending::Scanned) => self.schedule.say_findings(),
            Some(Ending::BrokenOff) => self.schedule.say(SCAN_BROKEN_OFF),
            Some(Ending::Turned) | None => {}
        }
        if self.mode != Mode::Passive {
            return;
        }
        let heading = self.odometer.pose().heading;
        let (rotation, motion) = (&mut self.layers.rotation, &self.layers.motion);
        match self
            .passive
            .step(heading, ending, is_free, rotation, motion)
        {
            Step::Sing => self.sing(Song::Passive),
            Step::Over => self.enter(self.mode_before),
            Step::Nothing => {}
        }
    }
}
