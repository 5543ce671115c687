//! Frame `O`: opens a session.
//!
//! ```text
//! O  ppp                                               eee
//!    0, boot (3 bits), session replaced (3), owner (10)   0, era replaced (14)
//! ```
//!
//! Without an era, the session has no full number, and its key is used again after seven sessions.

use super::{ERA_MAX, Frame, Parsed, number, small};
use nom::{
    Parser,
    combinator::{map_opt, opt},
};

/// Opens a session if `boot` and `replaces` are the robot's current ones. A late frame therefore changes nothing
/// after a reboot, after another station's session, or after its own copy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Open {
    /// Boot counter of the latest acknowledgement, 3 bits.
    pub boot: u8,
    /// Session number of the latest acknowledgement, 3 bits.
    pub replaces: u8,
    /// Random nonce of this station, 10 bits, not 0.
    pub owner: u16,
    /// Era of the replaced session, 14 bits.
    pub era: Option<u16>,
}

impl Open {
    pub(super) fn write(self, frame: &mut Frame) {
        frame.push_sixbit(
            3,
            u32::from(self.boot & 7) << 13
                | u32::from(self.replaces & 7) << 10
                | u32::from(self.owner & 0x3FF),
        );
        if let Some(era) = self.era {
            frame.push_sixbit(3, u32::from(era & ERA_MAX));
        }
    }

    pub(super) fn parse(input: &[u8]) -> Parsed<'_, Self> {
        let era = opt(map_opt(number(3), small::<ERA_MAX>));
        map_opt((number(3), era), |(bits, era)| {
            (bits >> 16 == 0 && bits & 0x3FF != 0).then_some(Self {
                boot: (bits >> 13 & 7) as u8,
                replaces: (bits >> 10 & 7) as u8,
                owner: (bits & 0x3FF) as u16,
                era,
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
        fn open_frames_survive_a_round_trip(boot in 0..8_u8, replaces in 0..8_u8, owner in 1..1024_u16, era in prop::option::of(0..0x4000_u16)) {
            let open = Message::Open(Open { boot, replaces, owner, era });
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
            era: None,
        };
        assert_eq!(Message::parse(b"O``!"), Some(Message::Open(first)));
    }
}
