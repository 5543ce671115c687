//! Verifies an MCAP.

use std::collections::HashMap;
use std::io::{self, Read};
use std::time::Duration;

use ::mcap::records::{MessageHeader, Record, op};
use prost::Message as _;

use super::derived::Derived;
use super::raw_file::{RawCopy, RawFile};
use super::{Lines, Verdict};
use crate::event::NoticeCode;
use crate::interrupted::is_library;
use crate::mcap_reader::{Channel, Entries, Entry};
use crate::messages::{RawBytes, StationEvent};
use crate::record::parse;
use crate::session::Session;
use crate::session_writer::LIBRARY;
use crate::source::Form;
use crate::topics::{RAW_RX, Topic};
use crate::words::counted;

/// Verifies an MCAP file, and that a raw text holds the same bytes.
///
/// # Errors
/// If one of the files cannot be read.
pub fn verify_mcap<R: Read>(source: R, raw: Option<RawCopy>) -> io::Result<Verdict> {
    let mut entries = Entries::new(source);
    let mut check = Check {
        verdict: Verdict::new(Form::Mcap),
        lines: Lines::default(),
        derived: Derived::new(),
        is_ours: false,
        is_unfinished: false,
        start_ns: None,
        last_ns: 0,
        sequences: HashMap::new(),
        raw: raw.map(RawFile::new),
        in_summary: false,
    };
    while let Some(entry) = entries.next_entry()? {
        match entry {
            Entry::Damage(damage) => {
                check.verdict.fault(damage.to_string());
                check.lines.skip();
                check.derived.lose_track();
            }
            Entry::Message {
                channel,
                header,
                data,
            } => check.take_message(channel, header, data)?,
            Entry::Other { opcode, body } => check.take_record(opcode, body),
        }
    }
    let has = |topic: Topic| {
        entries
            .channels()
            .values()
            .any(|channel| channel.topic == topic.name())
    };
    check.finish(entries.is_finished(), has)
}

struct Check {
    verdict: Verdict,
    lines: Lines,
    derived: Derived,
    /// Whether this version of Groundwave wrote the recording; if so, derived messages must equal those derived again.
    is_ours: bool,
    /// Whether the recording has no derived topics yet.
    is_unfinished: bool,
    start_ns: Option<u64>,
    last_ns: u64,
    sequences: HashMap<u16, u32>,
    raw: Option<RawFile>,
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
            self.derived.lose_track();
        }
        if header.log_time < self.last_ns {
            let what = format!("{topic}: the time of message {} goes back", header.sequence);
            self.verdict.fault(what);
        }
        self.last_ns = header.log_time;
        let is_first = self.start_ns.is_none();
        if self.is_ours && is_first && topic == Topic::Station.name() && begins(data) {
            self.derived.begin();
        }
        self.start_ns.get_or_insert(header.log_time);
        self.lines.end = self.lines.end.max(self.since_start(&header));
        if topic == RAW_RX {
            return self.take_received(header, data);
        }
        if topic == Topic::Station.name()
            && let Ok(event) = StationEvent::decode(data)
        {
            self.lines.take_event(&event, self.since_start(&header));
        }
        if let Some(topic) = Topic::from_name(topic) {
            self.derived.take(topic, header, data, &mut self.verdict);
        }
        Ok(())
    }

    fn since_start(&self, header: &MessageHeader) -> Duration {
        let start_ns = self.start_ns.unwrap_or(header.log_time);
        Duration::from_nanos(header.log_time.saturating_sub(start_ns))
    }

    fn take_received(&mut self, header: MessageHeader, data: &[u8]) -> io::Result<()> {
        let raw = match RawBytes::decode(data) {
            Ok(raw) => raw,
            Err(error) => {
                self.verdict.fault(format!("{RAW_RX}: {error}"));
                return Ok(());
            }
        };
        let received = self.lines.diagnosis.counters().bytes;
        let received = received.saturating_add(self.verdict.missing_bytes);
        let Some(missing) = raw.stream_offset.checked_sub(received) else {
            let at = raw.stream_offset;
            self.verdict
                .fault(format!("{RAW_RX}: the bytes at {at} are repeated"));
            return Ok(());
        };
        if missing > 0 {
            self.verdict.missing_bytes = self.verdict.missing_bytes.saturating_add(missing);
            let what = format!(
                "{RAW_RX}: {} missing at {received}",
                counted(missing, "byte")
            );
            self.verdict.fault(what);
            self.lines.skip();
            self.derived.lose_track();
        }
        let at = self.since_start(&header);
        self.lines.take(&raw.data, at, &mut self.verdict);
        if !self.is_unfinished {
            self.derived
                .take_received(header.log_time, missing, &raw.data, &mut self.verdict);
        }
        if let Some(file) = &mut self.raw {
            file.compare(&raw, &mut self.verdict)?;
        }
        Ok(())
    }

    fn take_record(&mut self, opcode: u8, body: &[u8]) {
        self.in_summary |= opcode == op::DATA_END;
        match parse(opcode, body) {
            Some(Record::Header(header)) => {
                self.is_ours = header.library == LIBRARY;
                self.is_unfinished = is_library(&header.library);
            }
            Some(Record::Metadata(table)) if table.name == Session::TABLE => {
                self.derived.take_session(&table.metadata);
                self.lines.take_session(&table.metadata);
                // The previous part contains earlier lines.
                if table.metadata.get("part").is_some_and(|n| n != "1") {
                    self.derived.forget_beginning();
                }
            }
            Some(Record::Statistics(statistics))
                if self.in_summary && self.verdict.fault_count == 0 =>
            {
                let found: u64 = self.verdict.messages.values().sum();
                let by_channel: u64 = statistics.channel_message_counts.values().sum();
                if statistics.message_count != found || by_channel != found {
                    let said = statistics.message_count;
                    let what = format!(
                        "the statistics say {}; there are {found}",
                        counted(said, "message")
                    );
                    self.verdict.fault(what);
                }
            }
            None if self.in_summary && opcode == op::STATISTICS => {
                self.verdict.fault("the statistics are malformed");
            }
            _ => {}
        }
    }

    fn finish(mut self, is_finished: bool, has: impl Fn(Topic) -> bool) -> io::Result<Verdict> {
        if !has(Topic::RawRx) {
            self.verdict.fault(format!("there is no channel {RAW_RX}"));
        }
        if !is_finished {
            self.verdict
                .fault("the recording was interrupted: its end is missing");
        }
        let has = |topic| topic == Topic::Telemetry || has(topic);
        self.derived.finish(has, &mut self.verdict);
        if let Some(file) = self.raw {
            self.verdict.raw_file = Some(file.finish(&mut self.verdict)?);
        }
        self.lines.finish(&mut self.verdict);
        Ok(self.verdict)
    }
}

/// Whether an event is the first message of a recording. A part that was cut out begins with another message.
fn begins(event: &[u8]) -> bool {
    StationEvent::decode(event).is_ok_and(|event| event.is_notice(NoticeCode::RecordingBegun))
}
