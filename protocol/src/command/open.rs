//! `O`: opens a session.
//!
//! ```text
//! O  ppp
//!    0, boot (3 bits), session replaced (3), owner (10)
//! ```

use super::{Frame, Parsed, number};
use nom::{Parser, combinator::map_opt};

/// Asks for a session of one's own. The robot agrees only when `boot` and `replaces` are what it has:
/// a request that was overtaken by another station, a reboot or its own copy changes nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Open {
    /// The boot counter seen in the latest acknowledgement, 3 bits.
    pub boot: u8,
    /// The session number seen there, 3 bits.
    pub replaces: u8,
    /// A random nonce that tells this station from others, 10 bits, not 0.
    pub owner: u16,
}

impl Open {
    pub(super) fn write(self, frame: &mut Frame) {
        frame.push(b'O');
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
