//! Derives the messages of every topic from bytes, times and events.

mod events;
mod lines;

use std::collections::{BTreeMap, VecDeque};

use foxglove::messages::log::Level;
use groundwave_lines::{Content, OwnLine, Recognizer};
use groundwave_protocol::decoder::{Counters, Decoder, Received};
use groundwave_protocol::telemetry::{ACK_LINE_BYTES, FirmwareVersion};
use groundwave_protocol::{BYTES_PER_S, LINE_BYTES};

use super::encoder::Encoder;
use super::log_messages::LogMessages;
use super::path::Path;
use super::scene::Scene;
use super::{Topic, TopicMessage};
use crate::chunk::{counters_until, set_time};
use crate::event::Moment;
use crate::outages::{Outage, Outages};
use crate::own_lines::{DescribedFields, Values, recognizer};
use crate::robot_clock::RobotClock;
use crate::session::Session;
use crate::text::line_feed;
use events::Command;

/// Maximum time for which the first of joined short lines waits for the others, nanoseconds: the transmission time of a line.
const JOINED_NS_MAX: u64 = LINE_BYTES as u64 * 1_000_000_000 / BYTES_PER_S as u64;

/// Derives every topic of a recording from received bytes, sent bytes and events, in their order.
///
/// Each `handle_*` calls `take` with the derived messages in the order of the recording. An error of `take` is returned
/// at once; the other messages of that call are then lost. Times are nanoseconds since 1970. A time before the
/// latest one counts as the latest, so the messages stay in order when a clock is set back.
///
/// Messages that follow from the robot's lines alone carry the robot's time as publish time. `/log` and `/uplink` also
/// hold events of the station, whose clock differs; there, publish time equals log time, so both orders of their
/// messages agree.
///
/// `/raw/rx` gets one message per line feed, or per 80 bytes without a line feed, however the bytes arrive. Lines too short to be
/// intact are joined to the bytes after them, up to about 80 bytes and a third of a second, because a flood of line feeds
/// would need 40 bytes of recording for each. [`Self::finish`] writes the rest.
#[derive(Debug, Default)]
pub struct Deriver {
    now_ns: u64,
    rx_offset: u64,
    tx_offset: u64,
    /// Received bytes of short lines and of an unfinished line.
    pending: Vec<u8>,
    /// Time of the first pending byte.
    pending_ns: u64,
    /// Length of the unfinished line, bytes.
    line_bytes: usize,
    /// Whether the first 80 bytes of the unfinished line are written.
    is_continued: bool,
    decoder: Decoder,
    own: Recognizer,
    own_lines: u64,
    described: DescribedFields,
    outages: Outages,
    lines: Lines,
    clock: RobotClock,
    ack: Option<(u8, u8, u8, u8)>,
    list_digest: Option<u32>,
    was_bumped: bool,
    /// Number and firmware of the robot, from line C.
    robot: Option<(u8, FirmwareVersion)>,
    is_new_robot: bool,
    commands: VecDeque<Command>,
    log_messages: LogMessages,
    path: Path,
    scene: Scene,
    encoder: Encoder,
}

/// Source of the decoded lines.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Lines {
    /// The deriver decodes the bytes.
    #[default]
    OfBytes,
    /// The deriver decodes the bytes, whose times were not measured.
    OfUntimedBytes,
    /// The caller passes the lines to [`Deriver::handle_received`].
    Decoded,
}

impl Deriver {
    /// A deriver at the beginning of both streams.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// A deriver whose caller decodes the bytes: it passes each line to [`Self::handle_received`] after its bytes.
    #[must_use]
    pub fn of_decoded_lines() -> Self {
        Self {
            lines: Lines::Decoded,
            ..Self::default()
        }
    }

    /// Takes the session's table: the form of the robot's own lines, which is recognized automatically until then, and whether times were
    /// measured.
    pub fn take_session(&mut self, table: &BTreeMap<String, String>) {
        self.own = recognizer(Some(table));
        if self.lines == Lines::OfBytes && !Session::has_times(table) {
            self.lines = Lines::OfUntimedBytes;
        }
    }

    /// The decoder's totals.
    #[must_use]
    pub const fn counters(&self) -> &Counters {
        self.decoder.counters()
    }

    /// Number of lines of the robot's own with values so far.
    #[must_use]
    pub const fn own_lines(&self) -> u64 {
        self.own_lines
    }

    /// Number of bytes received or missing so far, including those of an unfinished line.
    #[must_use]
    pub const fn rx_bytes(&self) -> u64 {
        self.rx_offset.saturating_add(self.pending.len() as u64)
    }

    /// Number of bytes sent or missing so far.
    #[must_use]
    pub const fn tx_bytes(&self) -> u64 {
        self.tx_offset
    }

    /// Returns number and firmware of the robot once after the first line C, and again after each change.
    pub fn take_robot(&mut self) -> Option<(u8, FirmwareVersion)> {
        std::mem::take(&mut self.is_new_robot)
            .then_some(self.robot)
            .flatten()
    }

    /// Skips missing received bytes: the offset in `/raw/rx` jumps, and no line spans the gap.
    ///
    /// # Errors
    /// The errors of `take`.
    pub fn skip_rx<E>(
        &mut self,
        bytes: u64,
        mut take: impl FnMut(TopicMessage<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        self.give_pending(&mut take)?;
        self.decoder.skip();
        self.own.interrupt();
        self.rx_offset = self.rx_offset.saturating_add(bytes);
        self.outages.handle_missing();
        self.give_outages(&mut take)
    }

    /// Skips missing sent bytes: the offset in `/raw/tx` jumps.
    pub const fn skip_tx(&mut self, bytes: u64) {
        self.tx_offset = self.tx_offset.saturating_add(bytes);
    }

    /// Takes bytes received, read at `at_ns`.
    ///
    /// # Errors
    /// The errors of `take`.
    pub fn handle_rx<E>(
        &mut self,
        at_ns: u64,
        mut bytes: &[u8],
        mut take: impl FnMut(TopicMessage<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        if self.line_bytes == 0 && at_ns.saturating_sub(self.pending_ns) > JOINED_NS_MAX {
            self.give_pending(&mut take)?;
        }
        self.now_ns = self.now_ns.max(at_ns);
        while !bytes.is_empty() {
            let reach = bytes.len().min(LINE_BYTES - self.line_bytes);
            let line_feed = line_feed(&bytes[..reach]);
            let run = match line_feed {
                // Takes as many empty lines at once as make a short line.
                Some(0) if self.line_bytes == 0 && !self.is_continued => {
                    let short = reach.min(ACK_LINE_BYTES - 1);
                    let room = LINE_BYTES.saturating_sub(self.pending.len()).max(1);
                    let empty = bytes[..short.min(room)].iter();
                    empty.take_while(|&&byte| byte == b'\n').count()
                }
                Some(at) => at + 1,
                None => reach,
            };
            let (head, rest) = bytes.split_at(run);
            bytes = rest;
            let line_bytes = self.line_bytes + run;
            let is_line = line_feed.is_some() || line_bytes == LINE_BYTES;
            self.line_bytes = if is_line { 0 } else { line_bytes };
            let is_short = line_bytes < ACK_LINE_BYTES && !self.is_continued;
            let is_whole = is_line && !(is_short && self.pending.len() + run < LINE_BYTES);
            self.is_continued = line_feed.is_none() && (is_line || self.is_continued);
            // Each line of the robot's own, however short, has its own message and time.
            let own = if is_short || line_feed.is_none() {
                self.take_own(head, false)
            } else {
                None
            };
            let is_whole = is_whole || own.is_some();
            let received_before = self.decoder.counters().received();
            if self.pending.is_empty() && is_whole {
                self.give_received(head, &mut take)?;
            } else {
                if self.pending.is_empty() {
                    self.pending_ns = self.now_ns;
                }
                self.pending.extend_from_slice(head);
                if is_whole {
                    self.give_pending(&mut take)?;
                }
            }
            let own = if is_short || line_feed.is_none() {
                own
            } else {
                let is_wire = self.decoder.counters().received() != received_before;
                self.take_own(head, is_wire)
            };
            if let Some(own) = own {
                self.give_own(&own, &mut take)?;
            }
        }
        Ok(())
    }

    /// Takes a line that the caller decoded from bytes read at `at_ns`.
    ///
    /// # Errors
    /// The errors of `take`.
    pub fn handle_received<E>(
        &mut self,
        at_ns: u64,
        received: &Received,
        mut take: impl FnMut(TopicMessage<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        self.now_ns = self.now_ns.max(at_ns);
        self.handle_line(received, &mut take)
    }

    fn take_own(&mut self, run: &[u8], is_wire: bool) -> Option<OwnLine> {
        (self.lines != Lines::Decoded)
            .then(|| self.own.take(run, is_wire))
            .flatten()
    }

    /// Takes a line of the robot's own from bytes read at `at_ns`.
    ///
    /// # Errors
    /// The errors of `take`.
    pub fn handle_own<E>(
        &mut self,
        at_ns: u64,
        line: &OwnLine,
        mut take: impl FnMut(TopicMessage<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        self.now_ns = self.now_ns.max(at_ns);
        self.give_own(line, &mut take)
    }

    fn give_own<E>(
        &mut self,
        line: &OwnLine,
        take: &mut impl FnMut(TopicMessage<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        match &line.content {
            Content::Damaged => Ok(()),
            Content::Text => {
                self.encoder
                    .log(self.now_ns, Level::Info, "robot", &line.text);
                take(self.encoder.message(Topic::Log, self.now_ns, None))
            }
            Content::Values(samples) => {
                self.own_lines += 1;
                self.encoder.encode(&Values::from(&samples[..]));
                take(self.encoder.message(Topic::Values, self.now_ns, None))
            }
        }
    }

    /// Takes bytes handed to the radio at `at_ns`.
    ///
    /// # Errors
    /// The errors of `take`.
    pub fn handle_tx<E>(
        &mut self,
        at_ns: u64,
        bytes: &[u8],
        mut take: impl FnMut(TopicMessage<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        self.now_ns = self.now_ns.max(at_ns);
        if bytes.is_empty() {
            return Ok(());
        }
        self.encoder.raw(self.tx_offset, bytes);
        self.tx_offset = self.tx_offset.saturating_add(bytes.len() as u64);
        take(self.encoder.message(Topic::RawTx, self.now_ns, None))
    }

    /// Writes the bytes of an unfinished line.
    ///
    /// # Errors
    /// The errors of `take`.
    pub fn flush<E>(
        &mut self,
        mut take: impl FnMut(TopicMessage<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        self.give_pending(&mut take)
    }

    /// Takes the end of the recording: writes the bytes of an unfinished line, the lines that may be another robot's, which count as the
    /// robot's now, the outages whose number of lost lines is not final, and the silence that lasts until the latest message.
    ///
    /// # Errors
    /// The errors of `take`.
    pub fn finish<E>(
        &mut self,
        mut take: impl FnMut(TopicMessage<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        self.give_pending(&mut take)?;
        let now = Moment::from_nanos(self.now_ns);
        let undecided: Vec<Received> = self.decoder.undecided_lines().collect();
        for received in undecided {
            self.outages
                .handle_line(now, &received, self.decoder.counters());
            self.handle_line(&received, &mut take)?;
        }
        self.outages
            .finish(now, &counters_until(&self.decoder, now));
        self.give_outages(&mut take)
    }

    fn give_pending<E>(
        &mut self,
        take: &mut impl FnMut(TopicMessage<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        if self.pending.is_empty() {
            return Ok(());
        }
        self.line_bytes = 0;
        let mut pending = std::mem::take(&mut self.pending);
        let result = self.give_received(&pending, take);
        pending.clear();
        self.pending = pending;
        result
    }

    fn give_received<E>(
        &mut self,
        mut bytes: &[u8],
        take: &mut impl FnMut(TopicMessage<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        self.encoder.raw(self.rx_offset, bytes);
        self.rx_offset = self.rx_offset.saturating_add(bytes.len() as u64);
        take(self.encoder.message(Topic::RawRx, self.now_ns, None))?;
        if self.lines != Lines::Decoded {
            let now = Moment::from_nanos(self.now_ns);
            if self.lines == Lines::OfBytes {
                set_time(&mut self.decoder, now);
            }
            while let Some(received) = self.decoder.next_own_line(&mut bytes) {
                self.outages
                    .handle_line(now, &received, self.decoder.counters());
                self.handle_line(&received, take)?;
            }
            self.give_outages(take)?;
        }
        Ok(())
    }

    /// Takes an outage from a caller that decodes the bytes. Its times count from `zero_ns` since 1970.
    ///
    /// # Errors
    /// The errors of `take`.
    pub fn handle_outage<E>(
        &mut self,
        at_ns: u64,
        zero_ns: u64,
        outage: &Outage,
        mut take: impl FnMut(TopicMessage<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        self.now_ns = self.now_ns.max(at_ns);
        self.encoder.encode(&outage.to_message(zero_ns));
        take(self.encoder.message(Topic::Outages, self.now_ns, None))
    }

    fn give_outages<E>(
        &mut self,
        take: &mut impl FnMut(TopicMessage<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        while let Some(outage) = self.outages.poll() {
            self.encoder.encode(&outage.to_message(0));
            take(self.encoder.message(Topic::Outages, self.now_ns, None))?;
        }
        Ok(())
    }
}
