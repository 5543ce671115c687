//! Ground to robot: short frames of printable ASCII between line feeds.
//!
//! ```text
//! LF  type  payload in 6-bit characters  CRC-24 in 4 characters  LF
//! ```
//!
//! The CRC starts from the [`Key`], so it fails for a frame of another robot, boot, session or station, and
//! for an echo of the robot's own lines. The first LF ends noise and aborts an unfinished frame.

mod drive;
mod open;
mod order;
#[cfg(test)]
mod testing;
mod waypoints;

pub use drive::{Drive, Keepalive};
pub use open::Open;
pub use order::{Command, Order, OrderType};
pub use waypoints::{BLOCK_WAYPOINTS, FRAME_WAYPOINTS_MAX, Slots};

use crate::status_codes::status_codes;
use crate::{crc, sixbit};
use nom::{
    IResult, Parser,
    bytes::complete::take,
    combinator::{map, map_opt, opt},
};

/// The result of a parser in this module. Errors have no details, because an unreadable frame is dropped.
type Parsed<'a, T> = IResult<&'a [u8], T, ()>;

/// Maximum era of a session.
pub const ERA_MAX: u16 = 0x3FFF;

/// Maximum receipt of a STOP.
pub const RECEIPT_MAX: u16 = 0x7FFF;

/// Maximum length of a frame including both line feeds, bytes.
pub const FRAME_BYTES_MAX: usize = 1 + 1 + 2 + 5 * FRAME_WAYPOINTS_MAX + crc::CHARACTERS + 1;

/// The initial remainder of a frame's CRC, 24 bits.
///
/// ```text
/// bit  23   22-16     15-13  12-10    9-0
///      0    robot id  boot   session  owner
/// ```
///
/// Frames that need no session have zeros in all parts except the robot id. Sessions are numbered from 1, so the
/// two kinds of key never coincide.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Key(u32);

impl Key {
    /// Key for a [`Message::Stop`] to every robot; a station can stop a robot of unknown id.
    pub const EVERY_ROBOT: Self = Self::robot(0);

    /// Key for frames that need no session: [`Message::Stop`] and [`Message::Open`].
    #[must_use]
    pub const fn robot(robot_id: u8) -> Self {
        Self((robot_id as u32 & 0x7F) << 16)
    }

    /// Key for all other frames: robot id, boot counter, session number and owner's nonce (low bits of each).
    #[must_use]
    pub const fn session(robot_id: u8, boot: u8, session: u8, owner: u16) -> Self {
        Self(
            Self::robot(robot_id).0
                | (boot as u32 & 7) << 13
                | (session as u32 & 7) << 10
                | owner as u32 & 0x3FF,
        )
    }

    /// The key of a session in this era, opened by its full number. The era's low half changes the bits of the robot's
    /// id, its high half those of the owner: sessions of one robot have different keys for 896 sessions; those that one
    /// owner opened for 114,688.
    #[must_use]
    pub const fn in_era(self, era: u16) -> Self {
        Self(self.0 ^ (era as u32 & 0x7F) << 16 ^ (era as u32 >> 7 & 0x7F))
    }

    /// The initial remainder of the frame's CRC.
    #[must_use]
    pub const fn init(self) -> u32 {
        self.0
    }
}

status_codes! {
    /// The type of a frame, its first letter.
    FrameType {
        /// Switches the motors off.
        Stop = b'X',
        /// Opens a session.
        Open = b'O',
        /// A command.
        Command = b'C',
        /// Waypoints of a list being staged.
        Waypoints = b'W',
        /// Hand drive.
        Drive = b'D',
        /// Keepalive.
        Keepalive = b'L',
    }
}

/// A message from the ground to the robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Message {
    /// Switches the motors off, in every state, from any station. Ends the session, so that no frame sent before it
    /// is executed after it. Acknowledgements return its receipt, 15 bits; a STOP typed by hand has none.
    Stop(Option<u16>),
    /// Opens a session.
    Open(Open),
    /// A command, which the robot executes exactly once.
    Command(Command),
    /// Some waypoints of a list being staged.
    Waypoints(Slots),
    /// Hand drive, valid for a second.
    Drive(Drive),
    /// Shows that the ground is alive.
    Keepalive(Keepalive),
}

impl Message {
    /// The type of the message's frame.
    #[must_use]
    pub const fn frame_type(&self) -> FrameType {
        match self {
            Self::Stop(_) => FrameType::Stop,
            Self::Open(_) => FrameType::Open,
            Self::Command(_) => FrameType::Command,
            Self::Waypoints(_) => FrameType::Waypoints,
            Self::Drive(_) => FrameType::Drive,
            Self::Keepalive(_) => FrameType::Keepalive,
        }
    }

    /// Whether the frame is checked with [`Key::robot`] and not with [`Key::session`].
    #[must_use]
    pub const fn is_sessionless(&self) -> bool {
        matches!(self, Self::Stop(_) | Self::Open(_))
    }

    /// Parses type and payload of a frame with a valid CRC; `None` if they are unreadable, as in another version of the protocol.
    #[must_use]
    pub fn parse(content: &[u8]) -> Option<Self> {
        let (&letter, payload) = content.split_first()?;
        let (left, message) = match FrameType::from_letter(letter)? {
            FrameType::Stop => {
                map(opt(map_opt(number(3), small::<RECEIPT_MAX>)), Self::Stop).parse(payload)
            }
            FrameType::Open => map(Open::parse, Self::Open).parse(payload),
            FrameType::Command => map(Command::parse, Self::Command).parse(payload),
            FrameType::Waypoints => map(Slots::parse, Self::Waypoints).parse(payload),
            FrameType::Drive => map(Drive::parse, Self::Drive).parse(payload),
            FrameType::Keepalive => map(Keepalive::parse, Self::Keepalive).parse(payload),
        }
        .ok()?;
        left.is_empty().then_some(message)
    }

    /// Encodes the frame. No robot accepts a frame with a key of the wrong kind.
    #[must_use]
    pub fn encode(&self, key: Key) -> Frame {
        let mut frame = Frame::default();
        frame.push(b'\n');
        frame.push(self.frame_type().letter());
        match self {
            Self::Stop(receipt) => {
                if let Some(receipt) = receipt {
                    frame.push_sixbit(3, u32::from(receipt & RECEIPT_MAX));
                }
            }
            Self::Open(open) => open.write(&mut frame),
            Self::Command(command) => command.write(&mut frame),
            Self::Waypoints(slots) => slots.write(&mut frame),
            Self::Drive(drive) => drive.write(&mut frame),
            Self::Keepalive(keepalive) => keepalive.write(&mut frame),
        }
        let remainder = crc::update(key.init(), &frame.as_bytes()[1..]);
        for character in crc::characters(remainder) {
            frame.push(character);
        }
        frame.push(b'\n');
        frame
    }
}

/// An encoded frame.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Frame {
    bytes: [u8; FRAME_BYTES_MAX],
    length: u8,
}

impl Default for Frame {
    fn default() -> Self {
        Self {
            bytes: [0; FRAME_BYTES_MAX],
            length: 0,
        }
    }
}

impl core::fmt::Debug for Frame {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "Frame({})", self.as_bytes().escape_ascii())
    }
}

impl Frame {
    /// A single line feed, which requests acknowledgement lines: they survive a bad channel seven times as often
    /// as long ones.
    #[must_use]
    pub fn knock() -> Self {
        let mut frame = Self::default();
        frame.push(b'\n');
        frame
    }

    /// Two line feeds to send after a frame: three consecutive line feeds end a half-duplex robot's turn to listen.
    #[must_use]
    pub fn over() -> Self {
        let mut frame = Self::default();
        frame.push(b'\n');
        frame.push(b'\n');
        frame
    }

    /// The bytes to send.
    #[must_use]
    pub fn as_bytes(&self) -> &[u8] {
        self.bytes
            .get(..usize::from(self.length))
            .unwrap_or_default()
    }

    fn push(&mut self, byte: u8) {
        if let Some(slot) = self.bytes.get_mut(usize::from(self.length)) {
            *slot = byte;
            self.length += 1;
        }
    }

    /// Appends the low `6 * characters` bits of `value`.
    fn push_sixbit(&mut self, characters: u32, value: u32) {
        for i in (0..characters).rev() {
            self.push(sixbit::encode((value >> (6 * i)) as u8));
        }
    }
}

/// A number of at most `MAX`; `None` for a larger number.
fn small<const MAX: u16>(bits: u32) -> Option<u16> {
    u16::try_from(bits).ok().filter(|&number| number <= MAX)
}

/// Parses a number in 6-bit characters.
fn number<'a>(characters: usize) -> impl Parser<&'a [u8], Output = u32, Error = ()> {
    map_opt(take(characters), sixbit::decode_from)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_part_of_a_key_has_its_own_bits() {
        assert_eq!(Key::EVERY_ROBOT.init(), 0);
        assert_eq!(Key::robot(1).init(), 1 << 16);
        assert_eq!(Key::robot(0x7F).init(), 0x7F << 16);
        assert_eq!(Key::session(0, 1, 0, 0).init(), 1 << 13);
        assert_eq!(Key::session(0, 0, 1, 0).init(), 1 << 10);
        assert_eq!(Key::session(0, 0, 0, 1).init(), 1);
        assert_eq!(Key::session(0xFF, 0xFF, 0xFF, 0xFFFF).init(), 0x7F_FFFF);
    }

    #[test]
    fn no_key_is_the_initial_remainder_of_a_line() {
        for robot_id in 0..=255 {
            assert_ne!(
                Key::session(robot_id, 7, 7, 0x3FF).init(),
                crc::DOWNLINK_INIT
            );
        }
    }

    #[test]
    fn a_knock_is_a_line_feed() {
        assert_eq!(Frame::knock().as_bytes(), b"\n");
    }

    #[test]
    fn the_longest_frame_fits() {
        let waypoints = [crate::Waypoint { x_in: 1, y_in: 2 }; FRAME_WAYPOINTS_MAX];
        let slots = Slots::new(1, 0, &waypoints);
        let frame = Message::Waypoints(slots).encode(Key::robot(1));
        assert_eq!(frame.as_bytes().len(), FRAME_BYTES_MAX);
    }
}
