//! Selection of the running layers: those with sensors, allowed by the operator, part of the mode, and not switched
//! off by the robot itself.

use super::Robot;
use crate::behaviours::FITTED;
use crate::parameters::Parameter;
use groundwave_protocol::status_codes::{Layer, LayerMask, Mode};

/// Layers of mode Passive.
const HIDING: LayerMask = LayerMask::NONE
    .with(Layer::User)
    .with(Layer::Bumpers)
    .with(Layer::Rotation)
    .with(Layer::Motion);

/// Layers of the calibration, which drives by odometry alone: any diversion would spoil the square.
const CALIBRATING: LayerMask = LayerMask::NONE.with(Layer::User).with(Layer::DeadReckoning);

impl Robot {
    /// Layers that the program has and the board has sensors for.
    pub(super) fn fitted(&self) -> LayerMask {
        let mut fitted = FITTED.and(self.identity.fitted);
        if self.latest.photo_left.is_none() || self.latest.photo_right.is_none() {
            fitted = fitted.without(Layer::Photo);
        }
        if self.latest.motion.is_none() {
            fitted = fitted.without(Layer::Motion);
        }
        fitted
    }

    /// Layers that are on in the current mode.
    pub(super) fn enabled(&self) -> LayerMask {
        let mut allowed = self.allowed();
        if !allowed.contains(Layer::Bumpers) {
            // Without bumpers the photo layer would drive into obstacles.
            allowed = allowed.without(Layer::Photo);
        }
        match self.mode {
            Mode::Stop => LayerMask::NONE,
            Mode::Prowl | Mode::GoHome => allowed.without(Layer::Motion),
            Mode::Forage => self.enabled_foraging(allowed),
            Mode::Calibrate => allowed.and(CALIBRATING),
            Mode::Passive => allowed.and(HIDING),
            Mode::Reactive => allowed.without(Layer::DeadReckoning),
            Mode::User | Mode::Wander => {
                allowed.without(Layer::DeadReckoning).without(Layer::Motion)
            }
        }
    }

    /// Enabled layers, without those that the robot has switched off itself.
    #[must_use]
    pub fn running(&self) -> LayerMask {
        let enabled = self.enabled();
        if self.parameters.is_on(Parameter::Behaviour) {
            enabled.and(LayerMask::from_bits(!self.switches.off().bits()))
        } else {
            enabled
        }
    }

    /// Allows the layers that a mode needs, whether the operator, the failsafe or the robot selects it: without them the
    /// robot would stand still.
    pub(super) fn allow_for(&mut self, mode: Mode) {
        let needed = match mode {
            Mode::GoHome | Mode::Forage | Mode::Calibrate => {
                LayerMask::NONE.with(Layer::DeadReckoning)
            }
            Mode::Passive => LayerMask::NONE.with(Layer::Rotation).with(Layer::Motion),
            _ => LayerMask::NONE,
        };
        self.allowed = LayerMask::from_bits(self.allowed.bits() | needed.bits());
    }

    /// Whether the infrared detectors are on. A scan uses them even if they may not turn the robot.
    pub(super) fn needs_infrared(&self, running: LayerMask) -> bool {
        running.contains(Layer::Infrared)
            || self.layers.rotation.is_scanning() && self.allowed().contains(Layer::Infrared)
    }
}
