//! The interface of a behaviour.

use crate::arbiter::Request;
use crate::sensors::Senses;

/// A behaviour.
pub trait Behaviour {
    /// Request for this tick.
    fn decide(&mut self, senses: &Senses) -> Request;

    /// Resets the behaviour; called in ticks in which the behaviour is off.
    fn rest(&mut self);
}
