//! Entering, running and leaving mode Passive, and its turns.

use super::Robot;
use crate::arbiter::Holder;
use crate::behaviours::{Ending, Passive, Step};
use crate::parameters::Parameter;
use crate::song::Song;
use groundwave_protocol::status_codes::{Layer, Mode};

/// Text when an obstacle has ended a scan early.
const SCAN_BROKEN_OFF: &str = "scan: broken off";

impl Robot {
    /// Whether bumps may send the robot into hiding: only while it prowls without a target.
    pub(super) fn may_hide(&self) -> bool {
        self.mode == Mode::Prowl
            && self.target().is_none()
            && self.parameters.is_on(Parameter::Behaviour)
            && self.allowed().contains(Layer::Motion)
            && self.allowed().contains(Layer::Rotation)
    }

    /// Begins mode Passive. After the dock and after a restart the robot still returns to the mode before it.
    pub(super) fn begin_hiding(&mut self) {
        if !matches!(self.mode, Mode::Forage | Mode::Passive) {
            self.mode_before = self.mode;
        }
        self.passive = Passive::default();
        self.bump_sequence.forget();
    }

    /// Reports a finished turn or scan and continues mode Passive. A layer above the rotation layer that controls the motors
    /// ends the turn.
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
            Some(Ending::Scanned) => self.schedule.queue_findings(),
            Some(Ending::BrokenOff) => self.schedule.queue_text(SCAN_BROKEN_OFF),
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
            Step::Sing => self.play_song(Song::Passive),
            Step::Over => self.enter(self.mode_before),
            Step::Continue => {}
        }
    }
}
