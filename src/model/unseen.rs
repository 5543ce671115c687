//! Contacts that the infrared detectors did not see.

use groundwave_protocol::status_codes::{Bump, Infrared, Layer, LayerState};
use groundwave_protocol::telemetry::StateLine;

/// For the left and the right side, the number of contacts there since its infrared detector last triggered.
///
/// A detector that works triggers near most obstacles, so a long series of contacts without it means that it is dirty or dead.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Unseen {
    contacts: [u16; 2],
    was_touched: bool,
}

impl Unseen {
    pub(super) fn take(&mut self, state: &StateLine) {
        let is_off = state.layers.get(Layer::Infrared) == LayerState::Off;
        // Both switches at once, or the centre one, tell no side. The detectors of a layer that is off see nothing.
        let touched = match state.bump {
            _ if is_off => [false, false],
            Bump::Left | Bump::LeftCenter => [true, false],
            Bump::Right | Bump::RightCenter => [false, true],
            _ => [false, false],
        };
        let triggered = match state.infrared {
            Infrared::Left => [true, false],
            Infrared::Right => [false, true],
            Infrared::Both | Infrared::Jammed => [true, true],
            Infrared::None | Infrared::NotFitted => [false, false],
        };
        for (side, contacts) in self.contacts.iter_mut().enumerate() {
            if triggered[side] {
                *contacts = 0;
            } else if touched[side] && !self.was_touched {
                *contacts = contacts.saturating_add(1);
            }
        }
        self.was_touched = state.bump != Bump::None;
    }

    /// Contacts on the left side.
    pub(super) const fn left(self) -> u16 {
        self.contacts[0]
    }

    /// Contacts on the right side.
    pub(super) const fn right(self) -> u16 {
        self.contacts[1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use groundwave_protocol::telemetry::LayerStates;

    #[test]
    fn contacts_count_once_and_only_on_their_side() {
        use {Bump as B, Infrared as I};
        let mut unseen = Unseen::default();
        let mut layers = LayerStates::OFF;
        layers.set(Layer::Infrared, LayerState::Quiet);
        for (bump, infrared, left, right) in [
            (B::None, I::None, 0, 0),
            (B::Left, I::None, 1, 0),
            (B::LeftCenter, I::None, 1, 0),
            (B::None, I::None, 1, 0),
            (B::Center, I::None, 1, 0),
            (B::RightCenter, I::None, 1, 0),
            (B::None, I::None, 1, 0),
            (B::Right, I::None, 1, 1),
            (B::None, I::Left, 0, 1),
            (B::LeftCenter, I::Right, 1, 0),
            (B::None, I::Jammed, 0, 0),
            // Seen in the same line.
            (B::Left, I::Both, 0, 0),
            (B::None, I::None, 0, 0),
            (B::Sides, I::None, 0, 0),
            (B::Jammed, I::None, 0, 0),
            (B::Left, I::None, 0, 0),
        ] {
            unseen.take(&StateLine {
                bump,
                infrared,
                layers,
                ..StateLine::BLANK
            });
            let what = format!("{bump:?} {infrared:?}");
            assert_eq!((unseen.left(), unseen.right()), (left, right), "{what}");
        }
        // The layer is off.
        for bump in [B::None, B::Left] {
            unseen.take(&StateLine {
                bump,
                ..StateLine::BLANK
            });
        }
        assert_eq!(unseen.left(), 0);
    }
}
