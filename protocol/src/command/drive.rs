//! Frames `D` (hand drive) and `L` (keepalive).
//!
//! ```text
//! D  dddd  24 bits: velocity (6, signed), rotation (7, signed), line heard (7), count (4)
//! L  hh    line heard
//! ```
//!
//! These frames are not repeated until acknowledged: only the latest counts. The sequence of the newest line received
//! lets the robot reject delayed frames.

use super::{Frame, Parsed, number};
use crate::telemetry::SEQUENCE_MODULUS;
use nom::{Parser, combinator::map_opt};

const VELOCITY_MAX_IN_S: i8 = 31;
const ROTATION_MAX_IN_S: i8 = 63;

/// Speeds for the next second.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Drive {
    /// Speed at the centre, -31 to 31 in/s.
    pub velocity_in_s: i8,
    /// Speed of the left wheel minus that of the right wheel, -63 to 63 in/s.
    pub rotation_in_s: i8,
    /// Sequence of the newest line received.
    pub heard: u8,
    /// Count of drive frames, modulo 16.
    pub count: u8,
}

/// Shows the robot that the ground is alive, and requests acknowledgement lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Keepalive {
    /// Sequence of the newest line received.
    pub heard: u8,
}

impl Drive {
    pub(super) fn write(self, frame: &mut Frame) {
        let velocity = self
            .velocity_in_s
            .clamp(-VELOCITY_MAX_IN_S, VELOCITY_MAX_IN_S) as u32
            & 0x3F;
        let rotation = self
            .rotation_in_s
            .clamp(-ROTATION_MAX_IN_S, ROTATION_MAX_IN_S) as u32
            & 0x7F;
        frame.push_sixbit(
            4,
            velocity << 18
                | rotation << 11
                | u32::from(self.heard & 0x7F) << 4
                | u32::from(self.count & 0xF),
        );
    }

    pub(super) fn parse(input: &[u8]) -> Parsed<'_, Self> {
        map_opt(number(4), |bits| {
            let drive = Self {
                // Sign extension by shifting the field to the top of a byte and back.
                velocity_in_s: (bits >> 18 << 2) as u8 as i8 >> 2,
                rotation_in_s: (bits >> 11 << 1) as u8 as i8 >> 1,
                heard: (bits >> 4 & 0x7F) as u8,
                count: (bits & 0xF) as u8,
            };
            let in_range = drive.heard < SEQUENCE_MODULUS
                && drive.velocity_in_s >= -VELOCITY_MAX_IN_S
                && drive.rotation_in_s >= -ROTATION_MAX_IN_S;
            in_range.then_some(drive)
        })
        .parse(input)
    }
}

impl Keepalive {
    pub(super) fn write(self, frame: &mut Frame) {
        frame.push_sixbit(2, u32::from(self.heard));
    }

    pub(super) fn parse(input: &[u8]) -> Parsed<'_, Self> {
        map_opt(number(2), |heard| {
            (heard < u32::from(SEQUENCE_MODULUS)).then_some(Self { heard: heard as u8 })
        })
        .parse(input)
    }
}

#[cfg(test)]
mod tests {
    use super::super::Message;
    use super::super::testing::read_back;
    use super::*;
    use crate::sixbit;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn drive_and_keepalive_survive_a_round_trip(
            velocity_in_s in -31..=31_i8, rotation_in_s in -63..=63_i8,
            heard in 0..100_u8, count in 0..16_u8,
        ) {
            let drive = Message::Drive(Drive { velocity_in_s, rotation_in_s, heard, count });
            prop_assert_eq!(read_back(drive), Some(drive));
            let keepalive = Message::Keepalive(Keepalive { heard });
            prop_assert_eq!(read_back(keepalive), Some(keepalive));
        }

        #[test]
        fn speeds_saturate(velocity_in_s: i8, rotation_in_s: i8) {
            let drive = Drive { velocity_in_s, rotation_in_s, heard: 0, count: 0 };
            let said = Drive {
                velocity_in_s: velocity_in_s.clamp(-31, 31),
                rotation_in_s: rotation_in_s.clamp(-63, 63),
                ..drive
            };
            prop_assert_eq!(read_back(Message::Drive(drive)), Some(Message::Drive(said)));
        }
    }

    fn parse(kind: u8, characters: usize, bits: u32) -> Option<Message> {
        let mut content = [kind; 5];
        sixbit::encode_into(bits, &mut content[1..=characters]);
        Message::parse(&content[..=characters])
    }

    #[test]
    fn values_out_of_range_are_refused() {
        assert_eq!(parse(b'D', 4, 0b10_0000 << 18), None, "-32 in/s");
        assert_eq!(parse(b'D', 4, 0b100_0000 << 11), None, "-64 in/s");
        assert_eq!(parse(b'D', 4, 100 << 4), None, "line 100");
        assert_eq!(parse(b'L', 2, 100), None, "line 100");
        assert!(parse(b'D', 4, 99 << 4).is_some() && parse(b'L', 2, 99).is_some());
    }
}
