//! The state that the robot shows to its telemetry, its simulator and its tests.

use super::Robot;
use crate::arbiter::{Holder, MotorGuard, Requests};
use crate::drive::Motion;
use crate::infrared::Infrared;
use crate::odometry::Pose;
use crate::parameters::Parameters;
use groundwave_protocol::Waypoint;
use groundwave_protocol::arq::Lists;
use groundwave_protocol::status_codes::{Layer, LayerMask, Mode};
use groundwave_protocol::telemetry::Ack;

impl Robot {
    /// Current mode.
    #[must_use]
    pub const fn mode(&self) -> Mode {
        self.mode
    }

    /// Pose by odometry.
    #[must_use]
    pub const fn pose(&self) -> Pose {
        self.odometer.pose()
    }

    /// Winner of the arbitration, even if a guard controls the motors; `None` while they are off.
    #[must_use]
    pub const fn holder(&self) -> Option<Holder> {
        self.holder
    }

    /// Guard that controls the motors in place of the holder.
    #[must_use]
    pub const fn guarded(&self) -> Option<MotorGuard> {
        self.guarded
    }

    /// Requests of all layers at the last tick, in order of priority.
    #[must_use]
    pub const fn requests(&self) -> &Requests {
        &self.requests
    }

    /// Whether the bumper layer works the robot free from a switch that stays closed.
    #[must_use]
    pub const fn is_bumper_jammed(&self) -> bool {
        self.layers.bumpers.is_jammed()
    }

    /// Whether a wheel does not reach its speed at full pulse width.
    #[must_use]
    pub const fn is_saturated(&self) -> bool {
        self.drive.is_saturated()
    }

    /// Motion requested by the holder, or by a guard in its place.
    #[must_use]
    pub const fn motion(&self) -> Motion {
        self.motion
    }

    /// Point that the robot is driving to.
    #[must_use]
    pub fn target(&self) -> Option<Waypoint> {
        let list = self.farm.lists().active();
        let enabled = self.enabled().contains(Layer::DeadReckoning);
        self.layers
            .dead_reckoning
            .target(self.mode, list)
            .filter(|_| enabled)
    }

    /// Current parameters.
    #[must_use]
    pub const fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// Both waypoint banks.
    #[must_use]
    pub const fn lists(&self) -> &Lists {
        self.farm.lists()
    }

    /// Number of reached points of the active route.
    #[must_use]
    pub const fn driven(&self) -> u16 {
        self.layers.dead_reckoning.driven()
    }

    /// Layers that the operator allows, among those fitted.
    #[must_use]
    pub fn allowed(&self) -> LayerMask {
        self.allowed.and(self.fitted())
    }

    /// Acknowledgement at this moment.
    #[must_use]
    pub fn ack(&self) -> Ack {
        self.farm.ack()
    }

    /// The infrared detectors.
    #[must_use]
    pub const fn infrared(&self) -> &Infrared {
        &self.infrared
    }

    /// Whether the robot should make progress: standing in these modes means that it is stuck.
    #[must_use]
    pub fn should_move(&self) -> bool {
        matches!(self.mode, Mode::Prowl | Mode::GoHome | Mode::Wander)
            || self.motion != Motion::STILL
    }
}
