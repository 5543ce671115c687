//! The acknowledgement: the state of the robot's receiver, 30 bits in every line.
//!
//! ```text
//! bit  29-27  26-24    23-21     20-18    17     16-0
//!      boot   session  sequence  outcome  kind   detail
//!                                         0      owner (10 bits), robot id (7)
//!                                         1      first missing block (7, up to 75), tag (2), window (8)
//!                                         1      two set bits, receipt of a STOP (15)
//!                                         1      bits 101, era of the session (14)
//!                                         1      bits 1001111000, robot id (7): the robot cannot hear
//! ```
//!
//! All counters are the low bits of larger counters. An acknowledgement is a snapshot, not an event: a lost line loses no acknowledgement.

use super::FieldError;
use super::fields::{Fields, Parsed, byte, bytes, digits};
use crate::command::{ERA_MAX, RECEIPT_MAX};
use crate::{crc, sixbit};
use nom::Parser;
use nom::combinator::{map_opt, verify};

/// Length of an acknowledgement line including CR LF, bytes.
pub const ACK_LINE_BYTES: usize = 14;

/// Number of blocks after the first missing one that an acknowledgement covers.
pub const WINDOW_BLOCKS: u8 = 8;

/// Result of the latest command.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Outcome {
    /// Executed.
    #[default]
    Done = 0,
    /// Refused: the layer or mode is not fitted.
    NotFitted = 1,
    /// Refused: a value is out of range.
    BadValue = 2,
    /// Refused: waypoints of the list are missing.
    ListIncomplete = 3,
    /// Refused: the staged list does not match the announced digest.
    DigestMismatch = 4,
    /// Refused in the robot's current state.
    NotNow = 5,
    /// Refused: unknown command.
    Unknown = 6,
    /// Accepted, but not carried out.
    Failed = 7,
}

impl Outcome {
    /// All outcomes, indexed by their number.
    pub const ALL: [Self; 8] = [
        Self::Done,
        Self::NotFitted,
        Self::BadValue,
        Self::ListIncomplete,
        Self::DigestMismatch,
        Self::NotNow,
        Self::Unknown,
        Self::Failed,
    ];

    /// Stable code.
    #[must_use]
    pub const fn code(self) -> &'static str {
        match self {
            Self::Done => "done",
            Self::NotFitted => "not-fitted",
            Self::BadValue => "bad-value",
            Self::ListIncomplete => "list-incomplete",
            Self::DigestMismatch => "digest-mismatch",
            Self::NotNow => "not-now",
            Self::Unknown => "unknown",
            Self::Failed => "failed",
        }
    }

    /// The outcome with a code; `None` for an unknown one.
    #[must_use]
    pub fn from_code(code: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|outcome| outcome.code() == code)
    }
}

/// The detail of an acknowledgement, bits 17 to 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Detail {
    /// No list is being staged.
    Idle {
        /// Nonce of the station that opened the session, 10 bits; 0 if no session is open.
        owner: u16,
        /// The robot's id; a station that has just started needs it to address the robot.
        robot_id: u8,
    },
    /// A list is being staged.
    Staging {
        /// The first block of waypoints that has not arrived, 7 bits.
        first_missing: u8,
        /// Low 2 bits of the list's tag.
        tag: u8,
        /// The blocks that have arrived; bit `n` is block `first_missing + 1 + n`.
        window: u8,
    },
    /// No session is open, because of a STOP with a receipt.
    Stopped {
        /// Receipt of the latest STOP, 15 bits.
        receipt: u16,
    },
    /// The robot has no working receiver.
    CannotHear {
        /// The robot's id, 7 bits.
        robot_id: u8,
    },
    /// The era, the high part of the session's full number.
    Era {
        /// Count of rounds of session numbers, 14 bits.
        era: u16,
    },
}

/// Value of bits 16 and 15, with bit 17 set, before a receipt; no block number has it.
const RECEIPT: u32 = 0b11;

/// Value of bits 16 to 14, with bit 17 set, before an era; no block number has it.
const ERA: u32 = 0b101;

/// Value of bits 16 to 7, with bit 17 set, for a robot that cannot hear: block 79, which no list has.
const CANNOT_HEAR: u32 = 79 << 3;

/// The state of the robot's receiver at a moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Ack {
    /// Boot counter, low 3 bits.
    pub boot: u8,
    /// Session number, 1 to 7 in turn; 0 until a session is opened after a boot.
    pub session: u8,
    /// Sequence of the latest command taken in this session, low 3 bits; 0 before the first command.
    pub sequence: u8,
    /// Result of the latest command.
    pub outcome: Outcome,
    /// Session owner, or progress of the staged list.
    pub detail: Detail,
}

impl Default for Ack {
    fn default() -> Self {
        Self {
            boot: 0,
            session: 0,
            sequence: 0,
            outcome: Outcome::Done,
            detail: Detail::Idle {
                owner: 0,
                robot_id: 0,
            },
        }
    }
}

impl Ack {
    /// Whether no session is open.
    #[must_use]
    pub const fn is_closed(&self) -> bool {
        matches!(
            self.detail,
            Detail::Idle { owner: 0, .. } | Detail::Stopped { .. }
        )
    }

    /// Encodes the acknowledgement as five characters, for columns 70 to 74.
    #[must_use]
    pub fn encode(&self) -> [u8; 5] {
        let (kind, detail) = match self.detail {
            Detail::Idle { owner, robot_id } => (
                0,
                u32::from(owner & 0x3FF) << 7 | u32::from(robot_id & 0x7F),
            ),
            Detail::Staging {
                first_missing,
                tag,
                window,
            } => (
                1,
                u32::from(first_missing & 0x7F) << 10 | u32::from(tag & 3) << 8 | u32::from(window),
            ),
            Detail::Era { era } => (1, ERA << 14 | u32::from(era & ERA_MAX)),
            Detail::Stopped { receipt } => (1, RECEIPT << 15 | u32::from(receipt & RECEIPT_MAX)),
            Detail::CannotHear { robot_id } => (1, CANNOT_HEAR << 7 | u32::from(robot_id & 0x7F)),
        };
        let bits = u32::from(self.boot & 7) << 27
            | u32::from(self.session & 7) << 24
            | u32::from(self.sequence & 7) << 21
            | (self.outcome as u32) << 18
            | kind << 17
            | detail;
        let mut out = [0; 5];
        sixbit::encode_into(bits, &mut out);
        out
    }

    pub(super) fn parse(input: &[u8]) -> Parsed<'_, Self> {
        map_opt(bytes, Self::decode).parse(input)
    }

    /// Decodes five characters; `None` if one is not a 6-bit character.
    #[must_use]
    pub fn decode(characters: [u8; 5]) -> Option<Self> {
        let bits = sixbit::decode_from(&characters)?;
        let detail = if bits & 1 << 17 == 0 {
            Detail::Idle {
                owner: (bits >> 7 & 0x3FF) as u16,
                robot_id: (bits & 0x7F) as u8,
            }
        } else if bits >> 15 & 3 == RECEIPT {
            Detail::Stopped {
                receipt: bits as u16 & RECEIPT_MAX,
            }
        } else if bits >> 7 & 0x3FF == CANNOT_HEAR {
            Detail::CannotHear {
                robot_id: (bits & 0x7F) as u8,
            }
        } else if bits >> 14 & 7 == ERA {
            Detail::Era {
                era: bits as u16 & ERA_MAX,
            }
        } else {
            Detail::Staging {
                first_missing: (bits >> 10 & 0x7F) as u8,
                tag: (bits >> 8 & 3) as u8,
                window: bits as u8,
            }
        };
        Some(Self {
            boot: (bits >> 27 & 7) as u8,
            session: (bits >> 24 & 7) as u8,
            sequence: (bits >> 21 & 7) as u8,
            outcome: Outcome::ALL[(bits >> 18 & 7) as usize],
            detail,
        })
    }
}

/// An acknowledgement line: `K` or `G`, sequence, acknowledgement, CRC, CR LF. A robot sends `K` while the
/// ground is sending; a half-duplex robot sends `G` (go ahead) when it will listen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AckLine {
    /// Sequence of the line, 0 to 99, counted over all lines.
    pub sequence: u8,
    /// The state of the robot's receiver just before column 4 was sent.
    pub ack: Ack,
    /// Whether the robot is silent and listens after this line (`G`).
    pub listens: bool,
}

impl AckLine {
    /// Possible first letters: `K`, or `G` if the robot listens after the line.
    pub const LETTERS: [u8; 2] = *b"KG";

    /// The 14 bytes on the wire.
    #[must_use]
    pub fn encode(&self) -> [u8; ACK_LINE_BYTES] {
        let mut line = [0; ACK_LINE_BYTES];
        line[..3].copy_from_slice(&Self::head(self.sequence, self.listens));
        line[3..8].copy_from_slice(&self.ack.encode());
        let remainder = crc::update(crc::DOWNLINK_INIT, &line[..8]);
        line[8..12].copy_from_slice(&crc::characters(remainder));
        line[12..].copy_from_slice(b"\r\n");
        line
    }

    /// Columns 1 to 3: type and sequence.
    #[must_use]
    pub const fn head(sequence: u8, listens: bool) -> [u8; 3] {
        let letter = Self::LETTERS[listens as usize];
        [letter, b'0' + sequence / 10 % 10, b'0' + sequence % 10]
    }

    /// Whether an acknowledgement line begins with this byte.
    #[must_use]
    pub fn begins_with(byte: u8) -> bool {
        Self::LETTERS.contains(&byte)
    }

    /// Parses a line. The caller has verified the checksum.
    ///
    /// # Errors
    /// The first column of the field that cannot be read.
    pub fn parse(line: &[u8; ACK_LINE_BYTES]) -> Result<Self, FieldError> {
        Fields::of(line, |line| {
            let letter = line.next(verify(byte, |&letter| Self::begins_with(letter)))?;
            Ok(Self {
                sequence: line.next(digits::<2, u8>)?,
                ack: line.next(Ack::parse)?,
                listens: letter == Self::LETTERS[1],
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing;
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn acknowledgements_survive_a_round_trip(ack in testing::ack(), sequence in 0..100_u8, listens: bool) {
            prop_assert_eq!(Ack::decode(ack.encode()), Some(ack));
            let line = AckLine { sequence, ack, listens };
            prop_assert_eq!(AckLine::parse(&line.encode()), Ok(line));
        }

        #[test]
        fn any_thirty_bits_are_an_acknowledgement(bits in 0..1_u32 << 30) {
            let mut characters = [0; 5];
            sixbit::encode_into(bits, &mut characters);
            let ack = Ack::decode(characters).expect("every 6-bit character is valid");
            prop_assert_eq!(ack.encode(), characters);
        }

        #[test]
        fn values_larger_than_their_field_keep_their_low_bits(
            boot: u8, session: u8, sequence: u8, owner: u16, robot_id: u8, line: u8
        ) {
            let detail = Detail::Idle { owner, robot_id };
            let ack = Ack { boot, session, sequence, outcome: Outcome::Done, detail };
            let cut = Ack {
                boot: boot % 8,
                session: session % 8,
                sequence: sequence % 8,
                outcome: Outcome::Done,
                detail: Detail::Idle { owner: owner % 1024, robot_id: robot_id % 128 },
            };
            let read = AckLine::parse(&AckLine { sequence: line, ack, listens: false }.encode());
            prop_assert_eq!(read, Ok(AckLine { sequence: line % 100, ack: cut, listens: false }));
        }
    }

    /// Tests one field at a time, to detect a misplaced bit.
    #[test]
    fn each_field_has_the_bits_of_the_specification() {
        let none = Ack::default();
        let staging = |first_missing, tag, window| Ack {
            detail: Detail::Staging {
                first_missing,
                tag,
                window,
            },
            ..none
        };
        let era = |era| Ack {
            detail: Detail::Era { era },
            ..none
        };
        let stopped = |receipt| Ack {
            detail: Detail::Stopped { receipt },
            ..none
        };
        let idle = |owner, robot_id| Ack {
            detail: Detail::Idle { owner, robot_id },
            ..none
        };
        let cannot_hear = |robot_id| Ack {
            detail: Detail::CannotHear { robot_id },
            ..none
        };
        for (ack, bits) in [
            (none, 0),
            (Ack { boot: 1, ..none }, 1 << 27),
            (Ack { boot: 7, ..none }, 7 << 27),
            (Ack { session: 1, ..none }, 1 << 24),
            (
                Ack {
                    sequence: 1,
                    ..none
                },
                1 << 21,
            ),
            (
                Ack {
                    outcome: Outcome::Failed,
                    ..none
                },
                7 << 18,
            ),
            (
                Ack {
                    outcome: Outcome::NotFitted,
                    ..none
                },
                1 << 18,
            ),
            (idle(1, 0), 1 << 7),
            (idle(0x3FF, 0), 0x3FF << 7),
            (idle(0, 1), 1),
            (idle(0, 127), 127),
            (staging(0, 0, 0), 1 << 17),
            (staging(1, 0, 0), 1 << 17 | 1 << 10),
            (staging(75, 0, 0), 1 << 17 | 75 << 10),
            (staging(0, 1, 0), 1 << 17 | 1 << 8),
            (staging(0, 3, 0), 1 << 17 | 3 << 8),
            (staging(0, 0, 1), 1 << 17 | 1),
            (staging(0, 0, 0x80), 1 << 17 | 0x80),
            (stopped(0), 0b111 << 15),
            (era(0), 0b1101 << 14),
            (era(0x3FFF), 0b1101 << 14 | 0x3FFF),
            (stopped(0x7FFF), 0x3_FFFF),
            (cannot_hear(0), 1 << 17 | 0b100_1111 << 10),
            (cannot_hear(127), 1 << 17 | 0b100_1111 << 10 | 127),
        ] {
            assert_eq!(sixbit::decode_from(&ack.encode()), Some(bits), "{ack:?}");
        }
    }

    #[test]
    fn bad_acknowledgement_lines_are_blamed_by_column() {
        let good = AckLine {
            sequence: 42,
            ack: Ack::default(),
            listens: false,
        }
        .encode();
        for (column, character, blamed) in [
            (1, b'A', 1),
            (2, b' ', 2),
            (3, b'x', 2),
            (4, b' ', 4),
            (8, b'a', 4),
            (6, b'\r', 4),
        ] {
            let mut line = good;
            line[column - 1] = character;
            assert_eq!(AckLine::parse(&line), Err(FieldError { column: blamed }));
        }
    }
}
