//! Captures that are text: the robot's lines, when they came, and how somebody stored them.
//!
//! A tee writes what the radio delivered, byte for byte, and knows no time: its lines came as from a
//! 2400-baud radio that never paused. Other stations and tools put a time before each line, and what was
//! copied as text may have lost the CR of its line ends or got another one. The first intact lines say how a
//! capture is stored; everybody who reads one gets from here what the radio delivered, and when.

mod reader;
mod stamps;

use std::borrow::Cow;

use groundwave_protocol::decoder::{Decoder, Received};
use groundwave_protocol::telemetry::ACK_LINE_BYTES;
use groundwave_protocol::{BYTES_PER_S, LINE_BYTES};

use crate::event::Moment;
pub use reader::TextReader;
use stamps::{STAMP_BYTES_MAX, Stamps};

/// An intact line is looked for in so much of the beginning: four minutes of noise.
pub(super) const HEAD_BYTES: usize = 64 * 1024;

/// So many intact lines must be stored alike.
const WITNESSES: usize = 3;

/// The longest line with a time before it; what is longer is taken apart.
const STAMPED_BYTES_MAX: usize = STAMP_BYTES_MAX + LINE_BYTES + 1;

/// How the lines of a capture end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Ends {
    /// In CR LF, as the robot sends them.
    #[default]
    AsSent,
    /// In LF.
    Lf,
    /// In CR CR LF.
    CrCrLf,
}

/// How a capture is stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Style {
    stamps: Option<Stamps>,
    ends: Ends,
}

impl Style {
    /// As the first intact lines of a beginning say; `None` where there are too few of them. One that is as the robot
    /// sent it decides at once. One that is not may have come so: a radio loses a CR, and the end of one line stands before
    /// the next like a time.
    #[must_use]
    pub fn of(head: &[u8]) -> Option<Self> {
        let mut lines = head
            .split_inclusive(|&byte| byte == b'\n')
            .filter_map(Self::of_line);
        let mut style = lines.next()?;
        for _ in 1..WITNESSES {
            if style == Self::default() {
                break;
            }
            let other = lines.next()?;
            let is_like = |stamps: &Stamps| other.stamps.is_some_and(|it| it.is_like(stamps));
            style.stamps = style.stamps.filter(is_like);
            if other.ends != style.ends {
                style.ends = Ends::AsSent;
            }
        }
        // Times count from the first one, whatever stands behind it.
        if let Some(like) = style.stamps {
            let mut lines = head.split_inclusive(|&byte| byte == b'\n');
            let is_like = |stamps: &Stamps| stamps.is_like(&like);
            style.stamps = lines.find_map(|line| Stamps::like(line).filter(is_like));
        }
        Some(style)
    }

    /// How an intact line is stored; `None` of one that is not.
    fn of_line(line: &[u8]) -> Option<Self> {
        let ends = Ends::of(line);
        let length = match intact(&ends.restore(line))? {
            Received::Line(..) => LINE_BYTES,
            Received::Ack(_) => ACK_LINE_BYTES,
        };
        let before = line.len().saturating_sub(ends.stored_bytes(length));
        let stamps = Stamps::like(&line[..before]);
        Some(Self { stamps, ends })
    }

    /// What differs from the radio's bytes, for a person; nothing where nothing does.
    #[must_use]
    pub fn words(&self) -> Option<String> {
        let stamps = self.stamps.map(|_| "with a time before each line");
        let ends = match self.ends {
            Ends::AsSent => None,
            Ends::Lf => Some("with LF for CR LF"),
            Ends::CrCrLf => Some("with CR CR LF for CR LF"),
        };
        let words: Vec<&str> = stamps.into_iter().chain(ends).collect();
        (!words.is_empty()).then(|| words.join(", "))
    }

    /// Time of day at the beginning of the capture, since 1970, if its lines say it.
    #[must_use]
    pub fn unix(&self) -> Option<Moment> {
        self.stamps.and_then(|stamps| stamps.unix())
    }

    /// Whether its lines say their time.
    pub(super) const fn is_stamped(&self) -> bool {
        self.stamps.is_some()
    }

    /// Whether their time is that of a clock without a date.
    pub(super) fn goes_round(&self) -> bool {
        self.stamps.is_some_and(|stamps| stamps.go_round())
    }

    /// No piece is longer.
    pub(super) const fn reach(&self) -> usize {
        match (self.stamps, self.ends) {
            (Some(_), _) => STAMPED_BYTES_MAX,
            (None, Ends::CrCrLf) => LINE_BYTES + 1,
            (None, _) => LINE_BYTES,
        }
    }

    /// Bytes of the first piece of these, of which there are at least [`Self::reach`] unless the capture ends: a
    /// line, noise or not, or a part of one that is too long.
    pub(super) fn piece_bytes(&self, bytes: &[u8]) -> usize {
        let reach = bytes.len().min(self.reach());
        line_feed(&bytes[..reach]).map_or(reach, |at| at + 1)
    }

    /// The time that a piece says, after one that came at `last`.
    pub(super) fn said(&self, piece: &[u8], last: Moment) -> Option<Moment> {
        Some(self.stamps?.read(piece, last)?.at)
    }

    /// The time up to which a piece may have come by what it says: a whole second may be meant.
    pub(super) fn said_until(&self, piece: &[u8], last: Moment) -> Option<Moment> {
        let stamped = self.stamps?.read(piece, last)?;
        Some(stamped.at + stamped.resolution)
    }

    /// When a piece came, since the capture began. It ends at this byte of the file and comes after one that came at
    /// `last`. Lines that say the same time follow each other as on the radio.
    pub(super) fn time(&self, piece: &[u8], end: u64, last: Moment) -> Moment {
        let Some(stamps) = self.stamps else {
            return self.on_the_wire(end);
        };
        match stamps.read(piece, last) {
            Some(stamped) if stamped.at > last => stamped.at,
            Some(stamped) => {
                let latest = stamped.at + stamped.resolution * 9 / 10;
                let sent = piece.len().saturating_sub(stamped.length) as u64;
                last.max(latest.min(last + self.on_the_wire(sent)))
            }
            None => last,
        }
    }

    /// How long so many bytes of the file take on a 2400-baud radio.
    pub(super) fn on_the_wire(&self, bytes: u64) -> Moment {
        const LINE: u64 = LINE_BYTES as u64;
        on_the_wire(match self.ends {
            Ends::AsSent => bytes,
            // Nearly all lines have 80 bytes.
            Ends::Lf => bytes + bytes / (LINE - 1),
            Ends::CrCrLf => bytes - bytes / (LINE + 1),
        })
    }

    /// What the radio delivered of a piece.
    pub(super) fn radio<'a>(&self, piece: &'a [u8]) -> Cow<'a, [u8]> {
        let stamped = self
            .stamps
            .and_then(|stamps| stamps.read(piece, Moment::ZERO));
        self.ends
            .restore(&piece[stamped.map_or(0, |it| it.length)..])
    }
}

impl Ends {
    const fn of(line: &[u8]) -> Self {
        match line {
            [.., b'\r', b'\r', b'\n'] => Self::CrCrLf,
            [.., b'\r', b'\n'] => Self::AsSent,
            _ => Self::Lf,
        }
    }

    /// With the end that the robot gave it.
    fn restore(self, line: &[u8]) -> Cow<'_, [u8]> {
        let kept = match (self, Self::of(line)) {
            (Self::Lf, Self::Lf) => line.strip_suffix(b"\n"),
            (Self::CrCrLf, Self::CrCrLf) => line.strip_suffix(b"\r\r\n"),
            _ => None,
        };
        match kept {
            Some(kept) => Cow::Owned([kept, b"\r\n"].concat()),
            None => Cow::Borrowed(line),
        }
    }

    /// Bytes that a line of so many has in the file.
    const fn stored_bytes(self, sent: usize) -> usize {
        match self {
            Self::AsSent => sent,
            Self::Lf => sent - 1,
            Self::CrCrLf => sent + 1,
        }
    }
}

/// Where the first line feed is. Most often it is the last byte: whether there is one before it is found out several bytes
/// at a time.
pub(super) fn line_feed(bytes: &[u8]) -> Option<usize> {
    let (last, head) = bytes.split_last()?;
    if head.contains(&b'\n') {
        return head.iter().position(|&byte| byte == b'\n');
    }
    (*last == b'\n').then_some(head.len())
}

fn intact(line: &[u8]) -> Option<Received> {
    Decoder::default().lines(line).next()
}

/// How long so many bytes take at 2400 baud.
#[must_use]
pub fn on_the_wire(bytes: u64) -> Moment {
    const RATE: u64 = BYTES_PER_S as u64;
    let part = Moment::from_nanos(bytes % RATE * 1_000_000_000 / RATE);
    Moment::from_secs(bytes / RATE) + part
}

#[cfg(test)]
mod tests;
