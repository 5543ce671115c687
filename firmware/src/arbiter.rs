//! Arbitration: the motors go to the request with the highest priority.

use crate::drive::Motion;
use groundwave_protocol::status_codes::{Layer, LayerMask};
use groundwave_protocol::telemetry::HOLDERS;

/// Request of one behaviour in one tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Request {
    /// Whether the behaviour requests the motors.
    pub flag: bool,
    /// Requested motion.
    pub motion: Motion,
}

impl Request {
    /// No request.
    pub const QUIET: Self = Self {
        flag: false,
        motion: Motion::STILL,
    };

    /// A request for a motion.
    #[must_use]
    pub const fn raise(motion: Motion) -> Self {
        Self { flag: true, motion }
    }
}

/// The requests of layers 0 to 7 and of prowl, in order of priority.
pub type Requests = [Request; HOLDERS];

/// Winner of the arbitration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Holder {
    /// One of the eight layers.
    Layer(Layer),
    /// The default motion when no layer requests another.
    Prowl,
}

impl Holder {
    /// Index in [`Requests`].
    #[must_use]
    pub const fn place(self) -> usize {
        match self {
            Self::Layer(layer) => layer as usize,
            Self::Prowl => HOLDERS - 1,
        }
    }
}

/// A guard after the arbiter that can override the winner's motor commands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MotorGuard {
    /// There is no floor in the direction of travel.
    Cliff,
    /// The arm is not stowed.
    Arm,
}

/// Holder and motion of the request with the highest priority; `None` without any request.
#[must_use]
pub fn arbitrate(requests: &Requests) -> Option<(Holder, Motion)> {
    let place = requests.iter().position(|request| request.flag)?;
    let holder = Layer::ALL
        .get(place)
        .map_or(Holder::Prowl, |&layer| Holder::Layer(layer));
    requests.get(place).map(|request| (holder, request.motion))
}

/// Layers that request the motors.
#[must_use]
pub fn raised(requests: &Requests) -> LayerMask {
    Layer::ALL
        .iter()
        .zip(requests)
        .filter(|(_, request)| request.flag)
        .fold(LayerMask::NONE, |mask, (&layer, _)| mask.with(layer))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn highest_request_wins_with_its_own_motion(
            flags in any::<[bool; HOLDERS]>(),
            speeds in any::<[(i16, i16); HOLDERS]>(),
        ) {
            let requests: Requests = core::array::from_fn(|place| Request {
                flag: flags[place],
                motion: Motion { velocity_cps: speeds[place].0, rotation_cps: speeds[place].1 },
            });
            match arbitrate(&requests) {
                None => prop_assert!(flags.iter().all(|flag| !flag)),
                Some((holder, motion)) => {
                    prop_assert!(flags[holder.place()]);
                    prop_assert!(flags[..holder.place()].iter().all(|flag| !flag));
                    prop_assert_eq!(motion, requests[holder.place()].motion);
                }
            }
            for layer in Layer::ALL {
                prop_assert_eq!(raised(&requests).contains(layer), flags[layer as usize]);
            }
        }
    }
}
