//! The behaviours, one file each, and the table that gives them their priority.
//!
//! A behaviour looks at the [`Senses`] and at its own small state and says what it wants. It knows
//! nothing of the others: which of them is heard is the arbiter's business.

mod bumpers;
mod dead_reckoning;
mod detour;
mod docking;
mod infrared;
pub mod prowl;
mod sonar;
mod square;
mod user;

pub use bumpers::Bumpers;
pub use dead_reckoning::DeadReckoning;
pub use docking::News;
pub use infrared::InfraredAvoidance;
pub use sonar::Sonar;
pub use user::{DEAD_MAN_TICKS, User};

use crate::arbiter::{Request, Requests};
use crate::sensors::Senses;
use groundwave_protocol::letters::{Layer, LayerMask};

/// One behaviour.
pub trait Behaviour {
    /// What it wants at this tick.
    fn decide(&mut self, senses: &Senses) -> Request;

    /// It is switched off at this tick, and forgets what it was about.
    fn rest(&mut self);
}

/// Layers that this firmware has.
pub const FITTED: LayerMask = LayerMask::NONE
    .with(Layer::User)
    .with(Layer::Bumpers)
    .with(Layer::Infrared)
    .with(Layer::Sonar)
    .with(Layer::DeadReckoning);

/// The eight layers' states.
#[derive(Clone, Debug, Default)]
pub struct Layers {
    /// Layer 0.
    pub user: User,
    /// Layer 1.
    pub bumpers: Bumpers,
    /// Layer 3.
    pub infrared: InfraredAvoidance,
    /// Layer 4.
    pub sonar: Sonar,
    /// Layer 7.
    pub dead_reckoning: DeadReckoning,
}

impl Layers {
    /// The table: every layer in falling priority, prowl last. Those not in `enabled` rest.
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
            run(Layer::Rotation, &mut NotFitted),
            run(Layer::Infrared, &mut self.infrared),
            run(Layer::Sonar, &mut self.sonar),
            run(Layer::Photo, &mut NotFitted),
            run(Layer::Motion, &mut NotFitted),
            run(Layer::DeadReckoning, &mut self.dead_reckoning),
            prowl::freely(senses),
        ]
    }

    /// All of them forget what they were about.
    pub fn rest(&mut self) {
        self.user.rest();
        self.bumpers.rest();
        self.infrared.rest();
        self.sonar.rest();
        self.dead_reckoning.rest();
    }
}

/// A layer this firmware does not have.
struct NotFitted;

impl Behaviour for NotFitted {
    fn decide(&mut self, _: &Senses) -> Request {
        Request::QUIET
    }

    fn rest(&mut self) {}
}
