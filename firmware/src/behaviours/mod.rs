//! The behaviours, one file each, and the table of their priorities.
//!
//! A behaviour decides from the [`Senses`] and its own small state. It has no access to the other behaviours; the arbiter selects
//! among them.

mod behaviour;
mod bumpers;
mod dead_reckoning;
mod detour;
mod docking;
mod infrared;
mod motion;
mod panorama;
mod passive;
mod photo;
pub mod prowl;
mod refuge;
mod rotation;
mod sensor_switches;
mod sonar;
mod square;
mod user;

pub use behaviour::Behaviour;
pub use bumpers::Bumpers;
pub use dead_reckoning::DeadReckoning;
pub use docking::DockingEvent;
pub use infrared::InfraredAvoidance;
pub use motion::MotionDetector;
pub use panorama::{Findings, Panorama, SAMPLES};
pub use passive::{BumpSequence, Passive, Step};
pub use photo::Photo;
pub use rotation::{Ending, Rotation};
pub use sensor_switches::SensorSwitches;
pub use sonar::Sonar;
pub use user::{DEAD_MAN_TICKS, User};

use crate::arbiter::{Request, Requests};
use crate::sensors::Senses;
use groundwave_protocol::status_codes::{Layer, LayerMask};

/// Layers of this firmware. Photo and motion need sensors that some boards lack.
pub const FITTED: LayerMask = LayerMask::ALL;

/// Layers allowed after a boot: photo and motion would change the prowling.
pub const ALLOWED_AT_BOOT: LayerMask = FITTED.without(Layer::Photo).without(Layer::Motion);

/// States of the eight layers.
#[derive(Clone, Debug, Default)]
pub struct Layers {
    /// Layer 0: hand drive.
    pub user: User,
    /// Layer 1: bumpers.
    pub bumpers: Bumpers,
    /// Layer 2: rotation and scans.
    pub rotation: Rotation,
    /// Layer 3: infrared.
    pub infrared: InfraredAvoidance,
    /// Layer 4: sonar.
    pub sonar: Sonar,
    /// Layer 5: photocells.
    pub photo: Photo,
    /// Layer 6: motion detectors.
    pub motion: MotionDetector,
    /// Layer 7: dead reckoning.
    pub dead_reckoning: DeadReckoning,
}

impl Layers {
    /// Requests of all layers in order of priority, prowl last. Layers not in `enabled` are reset.
    pub fn decide(&mut self, enabled: LayerMask, senses: &Senses) -> Requests {
        let run = |layer: Layer, behaviour: &mut dyn Behaviour| {
            if enabled.contains(layer) {
                behaviour.decide(senses)
            } else {
                behaviour.rest();
                Request::QUIET
            }
        };
        [
            run(Layer::User, &mut self.user),
            run(Layer::Bumpers, &mut self.bumpers),
            run(Layer::Rotation, &mut self.rotation),
            run(Layer::Infrared, &mut self.infrared),
            run(Layer::Sonar, &mut self.sonar),
            run(Layer::Photo, &mut self.photo),
            run(Layer::Motion, &mut self.motion),
            run(Layer::DeadReckoning, &mut self.dead_reckoning),
            prowl::freely(senses),
        ]
    }

    /// Resets all layers.
    pub fn rest(&mut self) {
        self.user.rest();
        self.bumpers.rest();
        self.rotation.rest();
        self.infrared.rest();
        self.sonar.rest();
        self.photo.rest();
        self.motion.rest();
        self.dead_reckoning.rest();
    }
}
