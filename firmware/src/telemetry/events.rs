//! Events since the previous line A: a bump of one tick must not be missed between two lines.

use crate::board::Edges;
use crate::board::Sides;
use crate::board::Switches;
use crate::drive::DriveTrain;
use groundwave_protocol::status_codes::{Arm, Bump, Cliff, Drive, Infrared, LayerMask};

/// All events at any tick since the last line A.
#[derive(Clone, Debug, Default)]
#[expect(
    clippy::struct_excessive_bools,
    reason = "each is an independent event"
)]
pub struct Events {
    bumper: Switches,
    jammed: bool,
    infrared: Sides,
    /// Edges since the last line A; `None` if no sensors are fitted.
    cliff: Option<Edges>,
    saturated: bool,
    stalled: bool,
    odometer_reset: bool,
    motion: Sides,
    top_hat: bool,
    raised: LayerMask,
}

impl Events {
    /// Adds closed switches, and whether the jam sequence ignores them.
    pub const fn bumper(&mut self, now: Switches, jammed: bool) {
        self.bumper.left |= now.left;
        self.bumper.center |= now.center;
        self.bumper.right |= now.right;
        self.jammed |= jammed;
    }

    /// Adds infrared detections.
    pub const fn infrared(&mut self, now: Sides) {
        self.infrared = self.infrared.or(now);
    }

    /// Adds edges of the floor; returns `None` if no sensors are fitted.
    pub fn cliff(&mut self, now: Option<Edges>) {
        self.cliff = now.map(|now| now.or(self.cliff.unwrap_or_default()));
    }

    /// Adds the state of the drive train.
    pub const fn drive(&mut self, train: &DriveTrain) {
        self.saturated |= train.is_saturated();
        self.stalled |= train.is_stalled();
    }

    /// Adds motion detections, and whether the arm touched an obstacle.
    pub const fn arm(&mut self, motion: Sides, top_hat: bool) {
        self.motion = self.motion.or(motion);
        self.top_hat |= top_hat;
    }

    /// Adds a reset of the odometer.
    pub const fn odometer_reset(&mut self) {
        self.odometer_reset = true;
    }

    /// Adds layers that request the motors.
    pub const fn raised(&mut self, layers: LayerMask) {
        self.raised = LayerMask::from_bits(self.raised.bits() | layers.bits());
    }

    /// Layers that requested the motors.
    #[must_use]
    pub const fn layers_raised(&self) -> LayerMask {
        self.raised
    }

    /// Letter of the bumper.
    #[must_use]
    pub const fn bump(&self) -> Bump {
        if self.jammed {
            return Bump::Jammed;
        }
        match (self.bumper.left, self.bumper.center, self.bumper.right) {
            (false, false, false) => Bump::None,
            (true, false, false) => Bump::Left,
            (false, true, false) => Bump::Center,
            (false, false, true) => Bump::Right,
            (true, true, false) => Bump::LeftCenter,
            (false, true, true) => Bump::RightCenter,
            (true, false, true) => Bump::Sides,
            (true, true, true) => Bump::All,
        }
    }

    /// Letter of the infrared detectors.
    #[must_use]
    pub const fn infrared_letter(&self, jammed: bool) -> Infrared {
        match (self.infrared.left, self.infrared.right) {
            _ if jammed => Infrared::Jammed,
            (false, false) => Infrared::None,
            (true, false) => Infrared::Left,
            (false, true) => Infrared::Right,
            (true, true) => Infrared::Both,
        }
    }

    /// Letter of the edge sensors. The rear sensors have no letter of their own: they count as several.
    #[must_use]
    pub fn cliff_letter(&self) -> Cliff {
        const LEFT: Edges = Edges::AHEAD_LEFT.or(Edges::BESIDE_LEFT);
        const RIGHT: Edges = Edges::AHEAD_RIGHT.or(Edges::BESIDE_RIGHT);
        let Some(edges) = self.cliff else {
            return Cliff::NotFitted;
        };
        let groups = [LEFT, Edges::AHEAD, RIGHT, Edges::REAR].map(|group| edges.meets(group));
        match groups {
            [false, false, false, false] => Cliff::None,
            [true, false, false, false] => Cliff::Left,
            [false, true, false, false] => Cliff::Center,
            [false, false, true, false] => Cliff::Right,
            _ => Cliff::Several,
        }
    }

    /// Letter of the arm: an event, or else `now`.
    #[must_use]
    pub const fn arm_letter(&self, now: Arm) -> Arm {
        match (self.motion.left, self.motion.right) {
            _ if self.top_hat => Arm::TopHat,
            (true, true) => Arm::MotionBoth,
            (true, false) => Arm::MotionLeft,
            (false, true) => Arm::MotionRight,
            (false, false) => now,
        }
    }

    /// Letter of the drive train: the most important event.
    #[must_use]
    pub const fn drive_letter(&self, out_of_range: bool) -> Drive {
        if self.odometer_reset {
            Drive::OdometerReset
        } else if self.stalled {
            Drive::Stalled
        } else if self.saturated {
            Drive::Saturated
        } else if out_of_range {
            Drive::OutOfRange
        } else {
            Drive::Ok
        }
    }
}
