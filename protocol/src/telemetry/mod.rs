//! Robot to ground: lines of 80 bytes including CR LF, and acknowledgement lines of 14 bytes while the
//! ground is sending.
//!
//! ```text
//! column   1    2-3       4-69            70-74             75-78     79-80
//!        type  sequence   the line's own  acknowledgement   CRC-24    CR LF
//! ```

mod abilities;
mod ack;
mod columns;
mod counters;
mod fields;
mod own_fields;
mod parameter;
mod printable;
mod repair;
mod song;
mod state;
mod status;
#[cfg(test)]
mod testing;
mod text;

pub use abilities::{AbilitiesLine, FIELDS_MAX, LEVEL_MAX, Reading};
pub use ack::{ACK_LINE_BYTES, Ack, AckLine, Detail, Outcome, WINDOW_BLOCKS};
pub use counters::{CountersLine, FirmwareVersion, HOLDERS};
pub use own_fields::{DECIMALS_MAX, FieldLine, ValuesLine};
pub use parameter::{ParameterLine, ParameterName};
pub use printable::Printable;
pub(crate) use repair::repaired;
pub use song::{Note, SONG_NOTES, SongLine};
pub use state::{LayerStates, StateLine};
pub use status::{ListPlace, StatusLine};
pub use text::TextLine;

use crate::status_codes::status_codes;
use crate::{LINE_BYTES, crc};
use columns::Columns;
use fields::{Fields, Read, digits, letter, sixbits};
use nom::Parser;
use nom::bytes::complete::{tag, take};

/// Number of columns of a line before its acknowledgement.
pub const HEAD_BYTES: usize = 69;

/// Modulus of line sequences, which run from 0 to 99.
pub const SEQUENCE_MODULUS: u8 = 100;

status_codes! {
    /// The type of a line, its first letter.
    LineType {
        /// Motion, sensors, mode and layers.
        State = b'A',
        /// Battery, target, route and layers.
        Status = b'B',
        /// Uptime and counters.
        Counters = b'C',
        /// Text of the robot's program.
        Text = b'T',
        /// A parameter.
        Parameter = b'P',
        /// A song.
        Song = b'S',
        /// Abilities of the robot.
        Abilities = b'I',
        /// A field of the robot's own.
        Field = b'F',
        /// Values of the robot's own fields.
        Values = b'V',
    }
}

/// The fields of a line, by its type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Body {
    /// Line A.
    State(StateLine),
    /// Line B.
    Status(StatusLine),
    /// Line C.
    Counters(CountersLine),
    /// Line T.
    Text(TextLine),
    /// Line P.
    Parameter(ParameterLine),
    /// Line S.
    Song(SongLine),
    /// Line I.
    Abilities(AbilitiesLine),
    /// Line F.
    Field(FieldLine),
    /// Line V.
    Values(ValuesLine),
}

/// One 80-byte line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Line {
    /// Sequence of the line, 0 to 99, counted over all lines; a step other than one means lost lines.
    pub sequence: u8,
    /// The fields, by type.
    pub body: Body,
    /// The state of the robot's receiver just before column 70 was sent.
    pub ack: Ack,
}

/// The error for a line with a valid checksum and an unreadable field, as in another version of the protocol.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FieldError {
    /// The first column of the unreadable field, or the column that should hold a space; from 1.
    pub column: u8,
}

impl Body {
    /// The type of the line.
    #[must_use]
    pub const fn line_type(&self) -> LineType {
        match self {
            Self::State(_) => LineType::State,
            Self::Status(_) => LineType::Status,
            Self::Counters(_) => LineType::Counters,
            Self::Text(_) => LineType::Text,
            Self::Parameter(_) => LineType::Parameter,
            Self::Song(_) => LineType::Song,
            Self::Abilities(_) => LineType::Abilities,
            Self::Field(_) => LineType::Field,
            Self::Values(_) => LineType::Values,
        }
    }

    fn read(line_type: LineType, line: &mut Fields) -> Read<Self> {
        match line_type {
            LineType::State => StateLine::read(line).map(Self::State),
            LineType::Status => StatusLine::read(line).map(Self::Status),
            LineType::Counters => CountersLine::read(line).map(Self::Counters),
            LineType::Text => TextLine::read(line).map(Self::Text),
            LineType::Parameter => ParameterLine::read(line).map(Self::Parameter),
            LineType::Song => SongLine::read(line).map(Self::Song),
            LineType::Abilities => AbilitiesLine::read(line).map(Self::Abilities),
            LineType::Field => FieldLine::read(line).map(Self::Field),
            LineType::Values => ValuesLine::read(line).map(Self::Values),
        }
    }

    /// Encodes columns 1 to 69: type, sequence and fields.
    #[must_use]
    pub fn head(&self, sequence: u8) -> [u8; HEAD_BYTES] {
        let mut columns = Columns::blank();
        match self {
            Self::State(line) => line.write(&mut columns),
            Self::Status(line) => line.write(&mut columns),
            Self::Counters(line) => line.write(&mut columns),
            Self::Text(line) => line.write(&mut columns),
            Self::Parameter(line) => line.write(&mut columns),
            Self::Song(line) => line.write(&mut columns),
            Self::Abilities(line) => line.write(&mut columns),
            Self::Field(line) => line.write(&mut columns),
            Self::Values(line) => line.write(&mut columns),
        }
        columns.letter(1, self.line_type().letter());
        columns.digits(2, 2, u32::from(sequence % SEQUENCE_MODULUS));
        columns.into_head()
    }
}

impl Line {
    /// The 80 bytes on the wire.
    #[must_use]
    pub fn encode(&self) -> [u8; LINE_BYTES] {
        let mut line = [0; LINE_BYTES];
        line[..HEAD_BYTES].copy_from_slice(&self.body.head(self.sequence));
        line[HEAD_BYTES..74].copy_from_slice(&self.ack.encode());
        let remainder = crc::update(crc::DOWNLINK_INIT, &line[..74]);
        line[74..78].copy_from_slice(&crc::characters(remainder));
        line[78..].copy_from_slice(b"\r\n");
        line
    }

    /// Parses a line. The caller has verified the checksum.
    ///
    /// # Errors
    /// The first column of the field that cannot be read.
    pub fn parse(line: &[u8; LINE_BYTES]) -> Result<Self, FieldError> {
        Fields::of(line, |line| {
            let line_type = line.next(letter(LineType::from_letter))?;
            Ok(Self {
                sequence: line.next(digits::<2, u8>)?,
                body: Body::read(line_type, line)?,
                ack: line.field(Ack::parse)?,
            })
        })
    }
}

/// Whether the checksum of a line of 80 or 14 bytes is valid.
pub(crate) fn is_intact<const N: usize>(line: &[u8; N]) -> bool {
    let end = (sixbits::<{ crc::CHARACTERS }, u32>, tag("\r\n"));
    let content = take(N - crc::CHARACTERS - 2);
    (content, end)
        .parse(&line[..])
        .is_ok_and(|(_, (content, (checksum, _)))| {
            checksum == crc::update(crc::DOWNLINK_INIT, content)
        })
}
