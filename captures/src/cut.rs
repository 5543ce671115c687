//! Cuts a time range out of a capture, as a capture of the same form.
//!
//! A line belongs, with all its bytes, to the range in which it ends. Adjacent ranges therefore add up to the whole
//! capture, and each part decodes and verifies by itself.

use std::collections::{BTreeMap, VecDeque};
use std::io::{self, Read, Write};
use std::time::{Duration, UNIX_EPOCH};

use ::mcap::records::Metadata;
use groundwave_protocol::LINE_BYTES;

use super::mcap_reader::Damages;
use super::messages::RawBytes;
use super::name::utc;
use super::observations::{Item, Observation, Observations};
use super::session_writer::{CHUNK_BYTES, SessionWriter};
use super::text::TextReader;
use super::topics::{RAW_RX, RAW_TX};
use super::when::When;

/// A time range; its end is excluded.
#[derive(Clone, Copy, Debug, Default)]
pub struct Window {
    /// Start of the range; `None` for the beginning of the capture.
    pub from: Option<When>,
    /// End of the range; `None` for the end of the capture.
    pub to: Option<When>,
}

/// Reason why a part could not be cut out.
#[derive(Debug, thiserror::Error)]
pub enum CutError {
    /// A wall-clock time was given for a raw capture without dates.
    #[error("its lines have no date; give --from and --to since the beginning, such as 1:30")]
    NoWallTime,
    /// The capture cannot be read.
    #[error("{0}")]
    Read(io::Error),
    /// The part cannot be written.
    #[error("{0}")]
    Write(io::Error),
}

/// Result of a cut.
#[derive(Clone, Debug, Default)]
pub struct Part {
    /// Number of bytes received.
    pub bytes: u64,
    /// Observations; none in a raw capture.
    pub observations: u64,
    /// Duration of the whole capture; of a raw capture only as far as it was read.
    pub whole: Duration,
    /// Reason why the capture could not be read completely.
    pub problem: Option<String>,
}

/// Cuts a raw capture; lines are copied unchanged.
///
/// # Errors
/// If a wall-clock time is given and no line has a date, and when reading or writing fails.
pub fn cut_raw(
    source: impl Read,
    window: Window,
    output: &mut impl Write,
) -> Result<Part, CutError> {
    let mut reader = TextReader::new(source);
    let unix = reader.style().map_err(CutError::Read)?.unix();
    let since = |when: Option<When>| match (when, unix) {
        (None, _) => Ok(None),
        (Some(When::Since(since)), _) => Ok(Some(since)),
        (Some(When::Wall(ns)), Some(unix)) => {
            Ok(Some(Duration::from_nanos(ns).saturating_sub(unix)))
        }
        (Some(When::Wall(_)), None) => Err(CutError::NoWallTime),
    };
    let (from, to) = (since(window.from)?.unwrap_or_default(), since(window.to)?);
    let mut part = Part::default();
    while let Some(piece) = reader.next_piece().map_err(CutError::Read)? {
        part.whole = piece.at;
        let is_after = to.is_some_and(|to| piece.at >= to);
        // If the range is empty, read to the end to learn the duration.
        if is_after && part.bytes > 0 {
            break;
        }
        if piece.at >= from && !is_after {
            output.write_all(piece.stored).map_err(CutError::Write)?;
            part.bytes += piece.radio.len() as u64;
        }
    }
    output.flush().map_err(CutError::Write)?;
    Ok(part)
}

/// Cuts a recording: bytes, station events and the topics derived from them, with all tables and attachments. `/raw/rx`
/// and `/raw/tx` start at offset 0; the table `cut` holds their original offsets.
///
/// # Errors
/// If reading or writing fails.
pub fn cut_mcap(source: impl Read, window: Window, output: impl Write) -> Result<Part, CutError> {
    let mut observations = Observations::new(source);
    let mut cutter = Cutter {
        writer: SessionWriter::with_chunks(output, CHUNK_BYTES).map_err(CutError::Write)?,
        window,
        start_ns: None,
        pending: VecDeque::new(),
        pending_bytes: 0,
        rx_offset: None,
        tx_offset: None,
        part: Part::default(),
    };
    let mut damages = Damages::default();
    let (mut rx_end, mut tx_end) = (0, 0);
    while let Some(item) = observations.next_item().map_err(CutError::Read)? {
        match item {
            Item::Damage(damage) => damages.push(damage),
            Item::Observation { at_ns, observation } => {
                let stream = match &observation {
                    Observation::Received(raw) => Some((RAW_RX, raw, &mut rx_end)),
                    Observation::Sent(raw) => Some((RAW_TX, raw, &mut tx_end)),
                    Observation::Event(_) => None,
                };
                if let Some((topic, raw, end)) = stream {
                    let at = raw.stream_offset;
                    if at < *end {
                        damages.push(format_args!("{topic}: the bytes at {at} are repeated"));
                        continue;
                    }
                    *end = at.saturating_add(raw.data.len() as u64);
                }
                cutter
                    .handle_observation(at_ns, observation)
                    .map_err(CutError::Write)?;
            }
            item => cutter.writer.handle_item(item).map_err(CutError::Write)?,
        }
    }
    let mut part = cutter.finish().map_err(CutError::Write)?;
    part.problem = if !damages.is_empty() {
        Some(damages.in_words())
    } else if observations.has_ended() {
        None
    } else {
        Some("the recording was interrupted: its end is missing".to_owned())
    };
    Ok(part)
}

struct Cutter<W: Write> {
    writer: SessionWriter<W>,
    window: Window,
    /// Time of the first observation, nanoseconds.
    start_ns: Option<u64>,
    /// Received bytes of an unfinished line, with their times.
    pending: VecDeque<(u64, RawBytes)>,
    pending_bytes: usize,
    /// Offset of each stream at the beginning of the part.
    rx_offset: Option<u64>,
    tx_offset: Option<u64>,
    part: Part,
}

impl Part {
    /// Whether no part of the capture is in the range.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.bytes == 0 && self.observations == 0
    }
}

impl<W: Write> Cutter<W> {
    fn handle_observation(&mut self, at_ns: u64, observation: Observation) -> io::Result<()> {
        let start_ns = *self.start_ns.get_or_insert(at_ns);
        match observation {
            Observation::Received(raw) => {
                let passed = Duration::from_nanos(at_ns.saturating_sub(start_ns));
                self.part.whole = self.part.whole.max(passed);
                self.handle_received(at_ns, raw)
            }
            observation if self.is_inside(at_ns) => self.write(at_ns, observation),
            _ => Ok(()),
        }
    }

    /// Takes received bytes; each belongs to the time at which its line ends.
    fn handle_received(&mut self, at_ns: u64, mut raw: RawBytes) -> io::Result<()> {
        if let Some(line_feed) = raw.data.iter().rposition(|byte| *byte == b'\n') {
            let rest = raw.data.split_off(line_feed + 1);
            let stream_offset = raw.stream_offset.saturating_add(raw.data.len() as u64);
            self.pending.push_back((at_ns, raw));
            self.give_pending(at_ns)?;
            raw = RawBytes {
                stream_offset,
                data: rest,
            };
        }
        self.pending_bytes += raw.data.len();
        self.pending.push_back((at_ns, raw));
        // Bytes older than the length of a line cannot belong to a line.
        while let Some((at_ns, raw)) = self.pending.front()
            && self.pending_bytes - raw.data.len() >= LINE_BYTES - 1
        {
            let at_ns = *at_ns;
            if let Some((_, raw)) = self.pending.pop_front() {
                self.pending_bytes -= raw.data.len();
                self.write_if_inside(at_ns, at_ns, raw)?;
            }
        }
        Ok(())
    }

    /// Writes the pending bytes; their line ended at `end_ns`.
    fn give_pending(&mut self, end_ns: u64) -> io::Result<()> {
        self.pending_bytes = 0;
        for (at_ns, raw) in std::mem::take(&mut self.pending) {
            self.write_if_inside(end_ns, at_ns, raw)?;
        }
        Ok(())
    }

    fn write_if_inside(&mut self, end_ns: u64, at_ns: u64, raw: RawBytes) -> io::Result<()> {
        if raw.data.is_empty() || !self.is_inside(end_ns) {
            return Ok(());
        }
        self.write(at_ns, Observation::Received(raw))
    }

    fn is_inside(&self, at_ns: u64) -> bool {
        let has_come = |when| match when {
            When::Wall(ns) => at_ns >= ns,
            When::Since(since) => {
                let start_ns = self.start_ns.unwrap_or(at_ns);
                at_ns >= start_ns.saturating_add(nanoseconds(since))
            }
        };
        self.window.from.is_none_or(has_come) && !self.window.to.is_some_and(has_come)
    }

    fn write(&mut self, at_ns: u64, mut observation: Observation) -> io::Result<()> {
        self.part.observations += 1;
        match &mut observation {
            Observation::Received(raw) => {
                self.part.bytes += raw.data.len() as u64;
                let base = *self.rx_offset.get_or_insert(raw.stream_offset);
                raw.stream_offset = raw.stream_offset.saturating_sub(base);
            }
            Observation::Sent(raw) => {
                let base = *self.tx_offset.get_or_insert(raw.stream_offset);
                raw.stream_offset = raw.stream_offset.saturating_sub(base);
            }
            Observation::Event(_) => {}
        }
        self.writer
            .handle_item(Item::Observation { at_ns, observation })
    }

    fn finish(mut self) -> io::Result<Part> {
        if let Some((end_ns, _)) = self.pending.back() {
            self.give_pending(*end_ns)?;
        }
        let in_words = |when: Option<When>| match when {
            None => "-".to_owned(),
            Some(When::Since(since)) => format!("{} s", since.as_secs_f64()),
            Some(When::Wall(ns)) => utc(UNIX_EPOCH + Duration::from_nanos(ns)),
        };
        let offset = |offset: Option<u64>| offset.unwrap_or_default().to_string();
        let table = [
            ("from", in_words(self.window.from)),
            ("to", in_words(self.window.to)),
            ("rx_offset", offset(self.rx_offset)),
            ("tx_offset", offset(self.tx_offset)),
        ];
        let table = table.map(|(name, value)| (name.to_owned(), value));
        self.writer.write_metadata(&Metadata {
            name: "cut".to_owned(),
            metadata: BTreeMap::from(table),
        })?;
        self.writer.finish()?;
        Ok(self.part)
    }
}

fn nanoseconds(duration: Duration) -> u64 {
    u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX)
}
