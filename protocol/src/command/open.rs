//! `O`: opens a session.
//!
//! ```text
//! O  ppp
//!    0, boot (3 bits), session replaced (3), owner (10)
//! ```

use super::{Frame, Parsed, number};
use nom::{Parser, combinator::map_opt};

/// Opens a session if `boot` and `replaces` are the robot's present ones. A late frame therefore changes nothing
/// after a reboot, another station's session or its own copy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Open {
    /// Boot counter of the latest acknowledgement, 3 bits.
    pub boot: u8,
    /// Session number of the latest acknowledgement, 3 bits.
    pub replaces: u8,
    /// Random nonce of this station, 10 bits, not 0.
    pub owner: u16,
}

impl Open {
    pub(super) fn write(self, frame: &mut Frame) {
        frame.push_sixbit(
            3,
            u32::from(self.boot & 7) << 13
                | u32::from(self.replaces & 7) << 10
                | u32::from(self.owner & 0x3FF),
        );
    }

    pub(super) fn parse(input: &[u8]) -> Parsed<'_, Self> {
        map_opt(number(3), |bits| {
            (bits >> 16 == 0 && bits & 0x3FF != 0).then_some(Self {
                boot: (bits >> 13 & 7) as u8,
                replaces: (bits >> 10 & 7) as u8,
                owner: (bits & 0x3FF) as u16,
            })
        })
        .parse(input)
    }
}

#[cfg(test)]
mod tests {
    use super::super::Message;
    use super::super::testing::read_back;
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn open_frames_survive_a_round_trip(boot in 0..8_u8, replaces in 0..8_u8, owner in 1..1024_u16) {
            let open = Message::Open(Open { boot, replaces, owner });
            prop_assert_eq!(read_back(open), Some(open));
        }
    }

    #[test]
    fn open_frames_need_an_owner_and_zero_leading_bits() {
        assert_eq!(Message::parse(b"O```"), None);
        assert_eq!(Message::parse(b"O0``"), None, "bit 16 is set");
        let first = Open {
            boot: 0,
            replaces: 0,
            owner: 1,
        };
        assert_eq!(Message::parse(b"O``!"), Some(Message::Open(first)));
    }
}
