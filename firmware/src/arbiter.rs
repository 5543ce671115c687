//! Who gets the motors: the highest priority whose flag is up.

use crate::drive::Motion;
use groundwave_protocol::letters::{Layer, LayerMask};
use groundwave_protocol::telemetry::HOLDERS;

/// What one behaviour wants in one tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Request {
    /// Whether it wants the motors.
    pub flag: bool,
    /// What for.
    pub motion: Motion,
}

impl Request {
    /// The behaviour has nothing to say.
    pub const QUIET: Self = Self {
        flag: false,
        motion: Motion::STILL,
    };

    /// The behaviour wants the motors.
    #[must_use]
    pub const fn raise(motion: Motion) -> Self {
        Self { flag: true, motion }
    }
}

/// One request a place: layers 0 to 7, then prowl, in falling priority.
pub type Requests = [Request; HOLDERS];

/// Who won the motors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Holder {
    /// One of the eight layers.
    Layer(Layer),
    /// Nobody wants anything else.
    Prowl,
}

impl Holder {
    /// Its place in [`Requests`].
    #[must_use]
    pub const fn place(self) -> usize {
        match self {
            Self::Layer(layer) => layer as usize,
            Self::Prowl => HOLDERS - 1,
        }
    }
}

/// What stands behind the arbiter and may take the motors from whoever won them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MotorGuard {
    /// There is no floor where the robot would go.
    Cliff,
    /// The arm is not stowed yet.
    Arm,
}

/// The request of the highest priority, and whose it is; `None` when no flag is up.
#[must_use]
pub fn arbitrate(requests: &Requests) -> Option<(Holder, Motion)> {
    let place = requests.iter().position(|request| request.flag)?;
    let holder = Layer::ALL
        .get(place)
        .map_or(Holder::Prowl, |&layer| Holder::Layer(layer));
    requests.get(place).map(|request| (holder, request.motion))
}

/// The layers whose flag is up.
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
        fn the_highest_flag_wins_with_its_own_motion(
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
