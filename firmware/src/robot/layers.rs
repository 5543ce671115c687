//! Which layers run: those that the board has sensors for, that the operator allows, that the mode is
//! made of, and that the robot has not switched off itself.

use super::Robot;
use crate::behaviours::FITTED;
use crate::parameters::Parameter;
use groundwave_protocol::letters::{Layer, LayerMask, Mode};

/// Layers of a robot that hides.
const HIDING: LayerMask = LayerMask::NONE
    .with(Layer::User)
    .with(Layer::Bumpers)
    .with(Layer::Rotation)
    .with(Layer::Motion);

/// Layers of the calibration, which drives by odometry alone: whatever turned it aside would spoil the square.
const CALIBRATING: LayerMask = LayerMask::NONE.with(Layer::User).with(Layer::DeadReckoning);

impl Robot {
    /// Layers that the program has and the board has the sensors for.
    pub(super) fn fitted(&self) -> LayerMask {
        let mut fitted = FITTED;
        if self.latest.photo_left.is_none() || self.latest.photo_right.is_none() {
            fitted = fitted.without(Layer::Photo);
        }
        if self.latest.motion.is_none() {
            fitted = fitted.without(Layer::Motion);
        }
        fitted
    }

    /// The layers that are on in this mode.
    pub(super) fn enabled(&self) -> LayerMask {
        let mut allowed = self.allowed();
        if !allowed.contains(Layer::Bumpers) {
            // It looks at nothing but the light.
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

    /// Those of them that the robot itself has not switched off.
    #[must_use]
    pub fn running(&self) -> LayerMask {
        let enabled = self.enabled();
        if self.parameters.is_on(Parameter::Behaviour) {
            enabled.and(LayerMask::from_bits(!self.switches.off().bits()))
        } else {
            enabled
        }
    }

    /// Whoever wants a mode, operator, failsafe or the robot itself, wants the layers that it is made of: it
    /// would stand still otherwise, and call that going home.
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

    /// Whether the infrared detectors look: while the robot looks around they do, whether or not they may
    /// turn it.
    pub(super) fn looks_by_infrared(&self, running: LayerMask) -> bool {
        running.contains(Layer::Infrared)
            || self.layers.rotation.is_scanning() && self.allowed.contains(Layer::Infrared)
    }
}
