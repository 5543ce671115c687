//! Raw text: lines, their times, and the style in which they are stored.
//!
//! `tee` writes the radio's bytes without times. Readers time them as if the radio sent without pauses, at the rate that follows from
//! the robot's clock in lines C, or at 2400 baud. Other programs put a timestamp before each line, and copying text may remove the CR
//! of line ends or add a second one. The first intact lines determine the style; readers get the radio's bytes and their times.

mod reader;
mod stamps;

use std::borrow::Cow;

use groundwave_protocol::decoder::{Counters, Decoder, Received};
use groundwave_protocol::telemetry::{ACK_LINE_BYTES, Body, CountersLine, Line};
use groundwave_protocol::{BYTES_PER_S, LINE_BYTES};

use crate::event::Moment;
pub use reader::TextReader;
use stamps::{STAMP_BYTES_MAX, Stamps};

/// Number of bytes at the beginning of a file that are searched for intact lines: four minutes of noise.
pub(super) const HEAD_BYTES: usize = 64 * 1024;

/// Number of intact lines that must have the same style.
const WITNESSES: usize = 3;

/// Maximum length in bytes of a line with a timestamp; longer lines are split.
const STAMPED_BYTES_MAX: usize = STAMP_BYTES_MAX + LINE_BYTES + 1;

/// Line ends of a raw text.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Ends {
    /// CR LF, as the robot sends them.
    #[default]
    AsSent,
    /// LF.
    Lf,
    /// CR CR LF.
    CrCrLf,
}

/// Style of a raw text.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Style {
    stamps: Option<Stamps>,
    ends: Ends,
    /// Rate of the radio, if it is not 2400 baud.
    rate: Option<Rate>,
}

/// Rate of a robot's radio: a number of bytes, and the time in which the robot sent them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Rate {
    bytes: u64,
    seconds: u64,
}

impl Rate {
    /// Minimum time for estimating a rate, seconds.
    const SECONDS_MIN: u64 = 4;

    /// Maximum error of the robot's clock and its radio's clock, per cent.
    const ERROR_PCT: u64 = 3;

    /// The rate by the robot's clock in the first lines, if it differs from that of 2400 baud by more than the clock error. Only parts with a
    /// known number of lost lines count; the clock counts whole seconds, so each run of such parts is a second off at most.
    fn of(style: Style, mut head: &[u8]) -> Option<Self> {
        let mut decoder = Decoder::default();
        let mut rate = Self {
            bytes: 0,
            seconds: 0,
        };
        let mut latest: Option<(CountersLine, Counters)> = None;
        let (mut runs, mut is_in_run) = (0, false);
        while !head.is_empty() {
            let (piece, rest) = head.split_at(style.piece_bytes(head));
            head = rest;
            let radio = style.radio(piece);
            let mut bytes = &radio[..];
            while let Some(received) = decoder.next_own_line(&mut bytes) {
                let Received::Line(
                    Line {
                        body: Body::Counters(line),
                        ..
                    },
                    _,
                ) = received
                else {
                    continue;
                };
                let now = *decoder.counters();
                let was_in_run = std::mem::take(&mut is_in_run);
                if let Some((before, then)) = latest.replace((line, now))
                    && before.robot_id == line.robot_id
                    && now.hidden == then.hidden
                    && now.noise_bytes == then.noise_bytes
                    && now.restarts == then.restarts
                    && let Some(lost) = now.lines_lost.checked_sub(then.lines_lost)
                    && let Some(passed_s) = line.uptime_s.checked_sub(before.uptime_s)
                {
                    rate.bytes += now.bytes - then.bytes + lost * LINE_BYTES as u64;
                    rate.seconds += u64::from(passed_s);
                    runs += u64::from(!was_in_run);
                    is_in_run = true;
                }
            }
        }
        let usual_s = rate.bytes / u64::from(BYTES_PER_S);
        let is_usual =
            usual_s.abs_diff(rate.seconds) <= runs + rate.seconds * Self::ERROR_PCT / 100;
        (rate.seconds >= Self::SECONDS_MIN && rate.bytes > 0 && !is_usual).then_some(rate)
    }

    /// Transmission time of a number of bytes.
    fn time(self, bytes: u64) -> Moment {
        let nanos =
            u128::from(bytes) * u128::from(self.seconds) * 1_000_000_000 / u128::from(self.bytes);
        Moment::from_nanos(u64::try_from(nanos).unwrap_or(u64::MAX))
    }
}

impl Style {
    /// Style of the first intact lines; `None` if there are too few. One unchanged line decides at once. A changed
    /// line does not: the radio may lose a CR, or the rest of a damaged line may precede an intact line.
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
        // Times count from the first timestamp, even that of a damaged line.
        if let Some(like) = style.stamps {
            let mut lines = head.split_inclusive(|&byte| byte == b'\n');
            let is_like = |stamps: &Stamps| stamps.is_like(&like);
            style.stamps = lines.find_map(|line| Stamps::like(line).filter(is_like));
        } else {
            style.rate = Rate::of(style, head);
        }
        Some(style)
    }

    /// Style of a text without an intact line: with timestamps if its first lines, which may be a robot's own, have them.
    pub(crate) fn of_own_lines(head: &[u8]) -> Self {
        let lines = head.split_inclusive(|&byte| byte == b'\n');
        let mut lines = lines.filter(|line| !line.trim_ascii().is_empty());
        let stamps = lines.next().and_then(Stamps::before_own_line);
        let others: Vec<_> = lines
            .take(WITNESSES - 1)
            .map(Stamps::before_own_line)
            .collect();
        let is_like = |first: &Stamps| {
            let is_after = |it: &Option<Stamps>| it.is_some_and(|it| it.is_after(first));
            others.len() == WITNESSES - 1 && others.iter().all(is_after)
        };
        Self {
            stamps: stamps.filter(is_like),
            ..Self::default()
        }
    }

    /// Style of an intact line; `None` for any other line.
    fn of_line(line: &[u8]) -> Option<Self> {
        let ends = Ends::of(line);
        let length = match intact(&ends.restore(line))? {
            Received::Line(..) => LINE_BYTES,
            Received::Ack(_) => ACK_LINE_BYTES,
        };
        let before = line.len().saturating_sub(ends.stored_bytes(length));
        let stamps = Stamps::like(&line[..before]);
        Some(Self {
            stamps,
            ends,
            rate: None,
        })
    }

    /// Describes the differences from the radio's bytes; `None` if there are none.
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

    /// Start of the capture, as time since 1970, if timestamps have a date.
    #[must_use]
    pub fn unix(&self) -> Option<Moment> {
        self.stamps.and_then(|stamps| stamps.unix())
    }

    /// Whether lines have timestamps.
    pub(crate) const fn is_stamped(&self) -> bool {
        self.stamps.is_some()
    }

    /// Whether timestamps have no full date and therefore wrap around.
    pub(super) fn goes_round(&self) -> bool {
        self.stamps.is_some_and(|stamps| stamps.go_round())
    }

    /// Maximum length of a piece, bytes.
    pub(super) const fn reach(&self) -> usize {
        match (self.stamps, self.ends) {
            (Some(_), _) => STAMPED_BYTES_MAX,
            (None, Ends::CrCrLf) => LINE_BYTES + 1,
            (None, _) => LINE_BYTES,
        }
    }

    /// Length of the first piece of `bytes`: a line, or a part of a line that is too long. Lines shorter than the robot's shortest line
    /// are joined; otherwise each byte of a flood of line feeds would be a piece. Pass at least [`Self::reach`] bytes unless the
    /// capture ends.
    pub(super) fn piece_bytes(&self, bytes: &[u8]) -> usize {
        let reach = bytes.len().min(self.reach());
        let length = line_feed(&bytes[..reach]).map_or(reach, |at| at + 1);
        let Some(more) = bytes[..reach.min(ACK_LINE_BYTES)].get(length..) else {
            return length;
        };
        if self.is_stamped() {
            // The next line may have its own timestamp.
            return length + more.iter().take_while(|&&byte| byte == b'\n').count();
        }
        let end = more.iter().rposition(|&byte| byte == b'\n');
        end.map_or(length, |at| length + at + 1)
    }

    /// Timestamp of a piece; the previous piece has time `last`.
    pub(super) fn said(&self, piece: &[u8], last: Moment) -> Option<Moment> {
        Some(self.stamps?.read(piece, last)?.at)
    }

    /// Latest time that a piece's timestamp can stand for: its time plus the unit of its last digit.
    pub(super) fn said_until(&self, piece: &[u8], last: Moment) -> Option<Moment> {
        let stamped = self.stamps?.read(piece, last)?;
        Some(stamped.at + stamped.resolution)
    }

    /// Time of a piece since the capture began. The piece ends at byte `end` of the file; the previous piece has time `last`. Lines with the same
    /// timestamp are spaced by their transmission time.
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

    /// Transmission time of a number of bytes of the file.
    pub(super) fn on_the_wire(&self, bytes: u64) -> Moment {
        const LINE: u64 = LINE_BYTES as u64;
        let sent = match self.ends {
            Ends::AsSent => bytes,
            // Almost all lines have 80 bytes.
            Ends::Lf => bytes + bytes / (LINE - 1),
            Ends::CrCrLf => bytes - bytes / (LINE + 1),
        };
        self.rate
            .map_or_else(|| on_the_wire(sent), |rate| rate.time(sent))
    }

    /// The radio's bytes of a piece.
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

    /// Restores the robot's line ends of a line or of joined short lines.
    fn restore(self, line: &[u8]) -> Cow<'_, [u8]> {
        let is_one = line
            .split_last()
            .is_none_or(|(_, head)| !head.contains(&b'\n'));
        if self != Self::AsSent && !is_one {
            let lines = line.split_inclusive(|&byte| byte == b'\n');
            let mut restored = Vec::with_capacity(2 * line.len());
            for line in lines {
                match self.changed(line) {
                    Some(kept) => restored.extend([kept, b"\r\n"].into_iter().flatten()),
                    None => restored.extend_from_slice(line),
                }
            }
            return restored.into();
        }
        match self.changed(line) {
            Some(kept) => Cow::Owned([kept, b"\r\n"].concat()),
            None => Cow::Borrowed(line),
        }
    }

    /// A line without its end; `None` if the end is unchanged.
    fn changed(self, line: &[u8]) -> Option<&[u8]> {
        match (self, Self::of(line)) {
            (Self::Lf, Self::Lf) => line.strip_suffix(b"\n"),
            (Self::CrCrLf, Self::CrCrLf) => line.strip_suffix(b"\r\r\n"),
            _ => None,
        }
    }

    /// Length in the file of a line sent with `sent` bytes.
    const fn stored_bytes(self, sent: usize) -> usize {
        match self {
            Self::AsSent => sent,
            Self::Lf => sent - 1,
            Self::CrCrLf => sent + 1,
        }
    }
}

/// Index of the first line feed. Usually the last byte is the line feed, so all bytes before it are checked at once.
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

/// Transmission time of a number of bytes at 2400 baud.
#[must_use]
pub fn on_the_wire(bytes: u64) -> Moment {
    const RATE: u64 = BYTES_PER_S as u64;
    let part = Moment::from_nanos(bytes % RATE * 1_000_000_000 / RATE);
    Moment::from_secs(bytes / RATE) + part
}

#[cfg(test)]
mod tests;
