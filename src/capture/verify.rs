//! Whether a capture is what it should be.
//!
//! Of an MCAP every checksum, the numbers of the messages, the offsets of the bytes, the statistics, and
//! that each message of `/telemetry` is what decoding `/raw/rx` gives today; and that the bytes are those
//! of the raw file beside it. A raw capture has no checksums but those of its lines. What the radio lost
//! on the way is told and no fault of the capture.

use std::collections::{BTreeMap, HashMap, VecDeque};
use std::io::{self, Read, Write};
use std::time::Duration;

use ::mcap::parse_record;
use ::mcap::records::{MessageHeader, Record, op};
use groundwave_protocol::decoder::{Counters, Decoder};
use prost::Message as _;
use serde::Serialize;

use super::mcap_reader::{Channel, Entries, Entry};
use super::messages::{RawBytes, Telemetry};
use super::source::Form;
use super::text::TextReader;
use super::topics::{RAW_RX, Topic};

const TELEMETRY: &str = Topic::Telemetry.name();

/// Faults that are told one by one.
const FAULTS_TOLD: usize = 10;

/// Decoded lines that may wait for their message on `/telemetry`.
const LINES_WAITING_MAX: usize = 4096;

/// What was found.
#[derive(Clone, Debug, Serialize)]
pub struct Verdict {
    /// How it is stored.
    pub form: Form,
    /// Bytes received that it holds.
    pub bytes: u64,
    /// Bytes received that it does not hold.
    pub missing_bytes: u64,
    /// Intact lines.
    pub lines: u64,
    /// Lines that the radio lost, by their sequence.
    pub lines_lost: u64,
    /// Times in a row that lines were lost.
    pub gaps: u64,
    /// The longest of these.
    pub worst_gap: Option<Gap>,
    /// Messages by topic.
    pub messages: BTreeMap<String, u64>,
    /// Messages of `/telemetry` that are what decoding gives.
    pub telemetry_equal: u64,
    /// Messages of `/telemetry` whose bytes are missing.
    pub telemetry_unchecked: u64,
    /// Whether the bytes are those of the raw file beside it; unknown where there is none.
    pub is_as_side_car: Option<bool>,
    /// What is wrong, the first of it.
    pub faults: Vec<String>,
    /// How much is wrong.
    pub fault_count: u64,
}

/// Lines lost in a row.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Gap {
    /// How many.
    pub lines: u64,
    /// When the next one came, seconds since the beginning.
    pub until_s: f64,
}

impl Verdict {
    fn new(form: Form) -> Self {
        Self {
            form,
            bytes: 0,
            missing_bytes: 0,
            lines: 0,
            lines_lost: 0,
            gaps: 0,
            worst_gap: None,
            messages: BTreeMap::new(),
            telemetry_equal: 0,
            telemetry_unchecked: 0,
            is_as_side_car: None,
            faults: Vec::new(),
            fault_count: 0,
        }
    }

    /// Whether nothing is wrong.
    #[must_use]
    pub const fn is_good(&self) -> bool {
        self.fault_count == 0
    }

    fn fault(&mut self, what: impl Into<String>) {
        self.fault_count += 1;
        if self.faults.len() < FAULTS_TOLD {
            self.faults.push(what.into());
        }
    }

    /// Writes it for a person.
    ///
    /// # Errors
    /// When the output takes no more.
    pub fn write_text(&self, output: &mut impl Write) -> io::Result<()> {
        write!(output, "bytes      {}", self.bytes)?;
        match self.missing_bytes {
            0 => writeln!(output)?,
            missing => writeln!(output, ", and {missing} missing")?,
        }
        write!(
            output,
            "lines      {} intact, {} lost by the radio",
            self.lines, self.lines_lost
        )?;
        match self.worst_gap {
            None => writeln!(output)?,
            Some(gap) => writeln!(
                output,
                " in {} gaps; the longest, {} lines, until {:.1} s",
                self.gaps, gap.lines, gap.until_s
            )?,
        }
        if self.form == Form::Mcap {
            let messages: u64 = self.messages.values().sum();
            let topics = self.messages.len();
            writeln!(output, "messages   {messages} of {topics} topics")?;
            write!(
                output,
                "telemetry  {} messages are what {RAW_RX} decodes to",
                self.telemetry_equal
            )?;
            match self.telemetry_unchecked {
                0 => writeln!(output)?,
                unchecked => writeln!(output, ", of {unchecked} the bytes are missing")?,
            }
        }
        if self.is_as_side_car == Some(true) {
            writeln!(output, "side-car   holds the same bytes")?;
        }
        for fault in &self.faults {
            writeln!(output, "wrong      {fault}")?;
        }
        let untold = self.fault_count - self.faults.len() as u64;
        if untold > 0 {
            writeln!(output, "wrong      and {untold} more")?;
        }
        Ok(())
    }
}

/// Looks through a raw capture.
///
/// # Errors
/// When it cannot be read.
pub fn verify_raw(source: impl Read) -> io::Result<Verdict> {
    let mut verdict = Verdict::new(Form::Raw);
    let mut reader = TextReader::new(source);
    let mut lines = Lines::default();
    while let Some(piece) = reader.next_piece()? {
        lines.take(piece.radio, piece.at, &mut verdict, |_| {});
    }
    lines.finish(&mut verdict);
    if verdict.lines == 0 {
        verdict.fault("not one line of a robot");
    }
    Ok(verdict)
}

/// Looks through an MCAP; `side_car` holds the bytes that its `/raw/rx` should.
///
/// # Errors
/// When either cannot be read.
pub fn verify_mcap<R: Read>(source: R, side_car: Option<Box<dyn Read>>) -> io::Result<Verdict> {
    let mut entries = Entries::new(source);
    let mut check = Check {
        verdict: Verdict::new(Form::Mcap),
        lines: Lines::default(),
        expected: VecDeque::new(),
        is_aligned: true,
        start_ns: None,
        last_ns: 0,
        sequences: HashMap::new(),
        side_car: side_car.map(|source| SideCar { source, offset: 0 }),
        in_summary: false,
    };
    while let Some(entry) = entries.next_entry()? {
        match entry {
            Entry::Damage(damage) => {
                check.verdict.fault(damage.to_string());
                check.lose_track();
            }
            Entry::Message {
                channel,
                header,
                data,
            } => check.take_message(channel, header, data)?,
            Entry::Other { opcode, body } => check.take_record(opcode, body),
        }
    }
    let has_raw = entries.channels().any(|channel| channel.topic == RAW_RX);
    check.finish(entries.is_finished(), has_raw)
}

/// Counts the lines in a stream and the gaps between them.
#[derive(Default)]
struct Lines {
    decoder: Decoder,
}

impl Lines {
    fn take(
        &mut self,
        mut bytes: &[u8],
        at: Duration,
        verdict: &mut Verdict,
        mut line: impl FnMut(Telemetry),
    ) {
        while !bytes.is_empty() {
            let before = self.decoder.counters().lines_lost;
            let (taken, received) = self.decoder.handle_bytes(bytes);
            bytes = &bytes[taken..];
            let Some(received) = received else { continue };
            let lost = self.decoder.counters().lines_lost - before;
            if lost > 0 {
                verdict.gaps += 1;
                if verdict.worst_gap.is_none_or(|worst| worst.lines < lost) {
                    let until_s = at.as_secs_f64();
                    verdict.worst_gap = Some(Gap {
                        lines: lost,
                        until_s,
                    });
                }
            }
            line(Telemetry::from(&received));
        }
    }

    fn finish(&self, verdict: &mut Verdict) {
        let Counters {
            bytes,
            lines,
            ack_lines,
            lines_lost,
            ..
        } = *self.decoder.counters();
        verdict.bytes = bytes;
        verdict.lines = lines + ack_lines;
        verdict.lines_lost = lines_lost;
    }
}

struct SideCar {
    source: Box<dyn Read>,
    offset: u64,
}

struct Check {
    verdict: Verdict,
    lines: Lines,
    /// What was decoded and has not been met on `/telemetry` yet.
    expected: VecDeque<Telemetry>,
    /// Whether the next message of `/telemetry` must be the first of `expected`. Where something is missing
    /// it may be another.
    is_aligned: bool,
    start_ns: Option<u64>,
    last_ns: u64,
    sequences: HashMap<u16, u32>,
    side_car: Option<SideCar>,
    in_summary: bool,
}

impl Check {
    fn take_message(
        &mut self,
        channel: &Channel,
        header: MessageHeader,
        data: &[u8],
    ) -> io::Result<()> {
        let topic = &channel.topic;
        match self.verdict.messages.get_mut(topic) {
            Some(count) => *count += 1,
            None => drop(self.verdict.messages.insert(topic.clone(), 1)),
        }
        let next = self.sequences.entry(header.channel_id).or_insert(0);
        let expected = std::mem::replace(next, header.sequence.wrapping_add(1));
        if header.sequence != expected {
            let found = header.sequence;
            let what = format!("{topic}: message {expected} is missing; {found} follows");
            self.verdict.fault(what);
        }
        if header.log_time < self.last_ns {
            let what = format!("{topic}: the time of message {} goes back", header.sequence);
            self.verdict.fault(what);
        }
        self.last_ns = header.log_time;
        if topic == RAW_RX {
            self.take_bytes(header, data)?;
        } else if topic == TELEMETRY {
            self.take_telemetry(header, data);
        }
        Ok(())
    }

    fn take_bytes(&mut self, header: MessageHeader, data: &[u8]) -> io::Result<()> {
        let raw = match RawBytes::decode(data) {
            Ok(raw) => raw,
            Err(error) => {
                self.verdict.fault(format!("{RAW_RX}: {error}"));
                return Ok(());
            }
        };
        let received = self.lines.decoder.counters().bytes + self.verdict.missing_bytes;
        match raw.stream_offset.checked_sub(received) {
            None => {
                let at = raw.stream_offset;
                self.verdict
                    .fault(format!("{RAW_RX}: the bytes at {at} come twice"));
                return Ok(());
            }
            Some(0) => {}
            Some(missing) => {
                self.verdict.missing_bytes += missing;
                let what = format!("{RAW_RX}: {missing} bytes are missing at {received}");
                self.verdict.fault(what);
                self.lose_track();
            }
        }
        let start_ns = *self.start_ns.get_or_insert(header.log_time);
        let at = Duration::from_nanos(header.log_time.saturating_sub(start_ns));
        let expected = &mut self.expected;
        self.lines.take(&raw.data, at, &mut self.verdict, |line| {
            expected.push_back(line);
        });
        if self.expected.len() > LINES_WAITING_MAX {
            let what = format!("{LINES_WAITING_MAX} lines of {RAW_RX} are not on {TELEMETRY}");
            self.verdict.fault(what);
            self.expected.clear();
            self.lose_track();
        }
        self.compare(&raw)
    }

    /// The same bytes must stand in the side-car.
    fn compare(&mut self, raw: &RawBytes) -> io::Result<()> {
        let Some(side_car) = &mut self.side_car else {
            return Ok(());
        };
        let skipped = raw.stream_offset - side_car.offset;
        io::copy(&mut side_car.source.by_ref().take(skipped), &mut io::sink())?;
        let mut theirs = Vec::with_capacity(raw.data.len());
        let length = raw.data.len() as u64;
        side_car
            .source
            .by_ref()
            .take(length)
            .read_to_end(&mut theirs)?;
        side_car.offset = raw.stream_offset + length;
        if theirs != raw.data {
            let at = raw.stream_offset;
            let differ = theirs.iter().zip(&raw.data).take_while(|(a, b)| a == b);
            let byte = at + differ.count() as u64;
            self.verdict
                .fault(format!("the raw file differs from byte {byte} on"));
            self.verdict.is_as_side_car = Some(false);
            self.side_car = None;
        }
        Ok(())
    }

    fn take_telemetry(&mut self, header: MessageHeader, data: &[u8]) {
        let said = match Telemetry::decode(data) {
            Ok(said) => said,
            Err(error) => {
                self.verdict.fault(format!("{TELEMETRY}: {error}"));
                return;
            }
        };
        if self.is_aligned && self.expected.front() == Some(&said) {
            self.expected.pop_front();
            self.verdict.telemetry_equal += 1;
            return;
        }
        if self.is_aligned {
            let number = header.sequence;
            let what = format!("{TELEMETRY}: message {number} is not what {RAW_RX} decodes to");
            self.verdict.fault(what);
            self.lose_track();
        } else if let Some(place) = self.expected.iter().position(|line| *line == said) {
            self.expected.drain(..=place);
            self.is_aligned = true;
            self.verdict.telemetry_equal += 1;
            return;
        }
        self.verdict.telemetry_unchecked += 1;
    }

    /// Something is missing: lines without a message and messages without a line are to be expected.
    const fn lose_track(&mut self) {
        self.is_aligned = false;
    }

    fn take_record(&mut self, opcode: u8, body: &[u8]) {
        self.in_summary |= opcode == op::DATA_END;
        if !self.in_summary || opcode != op::STATISTICS || self.verdict.fault_count > 0 {
            return;
        }
        let Ok(Record::Statistics(statistics)) = parse_record(opcode, body) else {
            return self.verdict.fault("the statistics make no sense");
        };
        let found: u64 = self.verdict.messages.values().sum();
        let counted: u64 = statistics.channel_message_counts.values().sum();
        if statistics.message_count != found || counted != found {
            let said = statistics.message_count;
            let what = format!("the statistics say {said} messages; there are {found}");
            self.verdict.fault(what);
        }
    }

    fn finish(mut self, is_finished: bool, has_raw: bool) -> io::Result<Verdict> {
        if !has_raw {
            self.verdict.fault(format!("there is no channel {RAW_RX}"));
        }
        if !is_finished {
            self.verdict
                .fault("the recording was interrupted: its end is missing");
        }
        if self.is_aligned && !self.expected.is_empty() {
            let count = self.expected.len();
            let what = format!("{count} lines of {RAW_RX} are not on {TELEMETRY}");
            self.verdict.fault(what);
        }
        if let Some(side_car) = &mut self.side_car {
            let more = io::copy(&mut side_car.source, &mut io::sink())?;
            self.verdict.is_as_side_car = Some(more == 0);
            if more > 0 {
                let what = format!("the raw file holds {more} bytes more");
                self.verdict.fault(what);
            }
        }
        self.lines.finish(&mut self.verdict);
        Ok(self.verdict)
    }
}
