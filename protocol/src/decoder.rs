//! The ground's receiver: finds intact lines in any stream of bytes.
//!
//! At each line feed, the decoder tries the last 80 bytes, then the last 14. There is no start character
//! and no length field: only the checksum decides, so noise before an intact line never hides it.

mod arrival;
mod counting;
mod damage;
mod reckoning;
mod robots;

use crate::life::Life;
pub use crate::received::Received;
use crate::telemetry::{ACK_LINE_BYTES, AckLine, FieldError, Line, is_intact};
use crate::{BYTES_PER_S, LINE_BYTES};
pub use arrival::Arrival;
use counting::{AfterGap, Newest, UNDECIDED_MAX, Undecided};
pub use damage::{DamageKind, Damaged};
use reckoning::Reckoning;
pub use reckoning::{LASTING_SILENCE_MS, Lost};
pub use robots::OTHERS_MAX;
use robots::{Robots, Sender};

/// Counts of the decoder. Each byte belongs to an intact line or is noise; each line feed ends an intact
/// line or is rejected for one reason.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Number of received bytes.
    pub bytes: u64,
    /// Number of intact 80-byte lines.
    pub lines: u64,
    /// Number of intact acknowledgement lines.
    pub ack_lines: u64,
    /// Number of line feeds that ended bytes in the shape of a line (with CR LF in place) but with a wrong checksum.
    pub crc_rejected: u64,
    /// Number of line feeds that did not end bytes in the shape of a line.
    pub shape_rejected: u64,
    /// Number of lines with a valid checksum and an unreadable field.
    pub field_rejected: u64,
    /// Number of lines missing in the sequence. A gap of more than 93 lines is counted too short: 94 to 98 look like a late
    /// line, and longer gaps wrap.
    ///
    /// The sequence restarts after a reboot, so losses around a reboot are not counted here. If only line C reveals
    /// the reboot, the longest gap since the previous line C is attributed to the reboot and subtracted.
    pub lines_lost: u64,
    /// Number of reboots of the robot, as recognized by [`Life`].
    pub restarts: u64,
    /// Lost lines that the sequence does not show: mostly whole hundreds, from the uptime in lines C, and lines between a
    /// boot and the first line received after it.
    pub hidden: Lost,
    /// Further lines that may be lost, by the ground's clock: whole hundreds in silences since the latest line C. The next line C
    /// shows the number.
    pub unsettled: Lost,
    /// Lines that may be lost before lines whose sender is not known yet.
    pub undecided: u64,
    /// Number of gaps that take 2 s longer to send than the ground's clock shows: their pause is not in it, as in text without timestamps;
    /// and of boots without times.
    pub unclocked_gaps: u64,
    /// Damaged lines. A line feed in noise does not count as one.
    pub damaged: Damaged,
    /// Number of damaged lines included in `lines_lost`.
    pub damaged_in_gaps: u64,
    /// Number of lines of another robot included in `lines`.
    pub other_lines: u64,
    /// Number of lines of another robot included in `ack_lines`.
    pub other_ack_lines: u64,
    /// Id of the followed robot, once a line shows it.
    pub robot: Option<u8>,
    /// Id of the robot that was followed before another one replaced it.
    pub replaced_robot: Option<u8>,
    /// Ids of the other robots on the channel, in the order in which they appeared.
    pub other_robots: [Option<u8>; OTHERS_MAX],
    /// Number of bytes outside intact lines, including those of an unfinished line.
    pub noise_bytes: u64,
}

impl Counters {
    /// Number of intact lines of all robots.
    #[must_use]
    pub const fn received(&self) -> u64 {
        self.lines + self.ack_lines
    }

    /// Number of intact lines of the followed robot.
    #[must_use]
    pub const fn intact(&self) -> u64 {
        self.received() - self.other_lines - self.other_ack_lines
    }

    /// Number of lines that the robot sent and that did not arrive in any recognizable form; damaged lines are not included. The hundreds are
    /// known at the next line C.
    #[must_use]
    pub const fn lost(&self) -> Lost {
        let shown = self.lines_lost.saturating_sub(self.damaged_in_gaps);
        self.hidden
            .and(self.unsettled)
            .and(Lost::between(shown, shown + self.undecided))
    }

    /// Number of damaged lines in no gap of the sequence.
    fn unplaced_damaged(&self) -> u64 {
        self.damaged.total().saturating_sub(self.damaged_in_gaps)
    }

    /// Makes `unsettled` a permanent interval, because no line C will narrow it.
    const fn give_up_settling(&mut self) {
        self.hidden = self.hidden.and(self.unsettled);
        self.unsettled = Lost::between(0, 0);
    }
}

/// Finds lines in a stream. The result does not depend on how the stream is split into pieces.
#[derive(Clone, Debug)]
pub struct Decoder {
    /// The latest bytes, oldest first in `window[..filled]`.
    window: [u8; LINE_BYTES],
    filled: usize,
    /// Number of bytes since the end of the latest intact line; a new line cannot begin earlier.
    fresh: usize,
    newest: Option<Newest>,
    life: Life,
    /// Number of lines counted as lost in the longest gap since the latest line C.
    longest_step: u64,
    /// State after the longest gap, in case the gap was a boot.
    after_longest: Option<AfterGap>,
    /// Maximum number of lines sent and lost before the boot in the latest silence, until the next line C.
    before_boot: u64,
    /// Maximum number of lines sent before the latest line that came twice by its sequence, since the latest line C: it may be of another life.
    before_repeated: Option<u64>,
    reckoning: Reckoning,
    robots: Robots,
    /// The latest lines without an id, whose sender is not known yet, in the order of their arrival.
    undecided: [Option<Undecided>; UNDECIDED_MAX],
    /// Lines of the followed robot that [`Self::next_own_line`] has not returned yet.
    held: [Option<Received>; UNDECIDED_MAX + 1],
    /// The sender of the latest line.
    sender: Sender,
    /// Whether the link was lost since the latest line of the followed robot.
    is_interrupted: bool,
    /// Number of damaged lines since the latest line of the followed robot, and the noise bytes before that line.
    damaged: u64,
    noise_before: u64,
    /// Number of bytes up to the end of that line.
    bytes_before: u64,
    /// Number of damaged lines in no gap of the sequence at the latest line C.
    unplaced_before: u64,
    last_field_error: Option<FieldError>,
    counters: Counters,
}

impl Default for Decoder {
    fn default() -> Self {
        Self {
            window: [0; LINE_BYTES],
            filled: 0,
            fresh: 0,
            newest: None,
            life: Life::default(),
            longest_step: 0,
            after_longest: None,
            before_boot: 0,
            before_repeated: None,
            reckoning: Reckoning::default(),
            robots: Robots::default(),
            undecided: [None; UNDECIDED_MAX],
            held: [None; UNDECIDED_MAX + 1],
            sender: Sender::Own,
            is_interrupted: false,
            damaged: 0,
            noise_before: 0,
            bytes_before: 0,
            unplaced_before: 0,
            last_field_error: None,
            counters: Counters::default(),
        }
    }
}

impl Decoder {
    /// The counts so far.
    #[must_use]
    pub const fn counters(&self) -> &Counters {
        &self.counters
    }

    /// The counts if the stream ends at a time, ms, by the clock of [`Self::set_time`]. The lines that the robot can have sent since its
    /// latest line, in a silence or while the link is lost, may be lost; and those in a silence before that line, which may have begun earlier. Without times, they are
    /// any number if other bytes than the robot's have taken as long as a silence.
    #[must_use]
    pub fn counters_until(&self, now_ms: u64) -> Counters {
        let mut counters = self.counters;
        counters.unsettled.max += self.reckoning.most_until(now_ms, self.is_interrupted);
        let other_ms = (counters.bytes - self.bytes_before) * 1000 / u64::from(BYTES_PER_S);
        counters.unsettled.is_open |= self.reckoning.time().is_none()
            && self.newest.is_some()
            && other_ms >= LASTING_SILENCE_MS;
        counters
    }

    /// Marks an interruption of the link: a partial line is dropped, and lines sent meanwhile count as lost.
    pub const fn interrupt(&mut self) {
        self.fresh = 0;
        self.is_interrupted = true;
        if let Some(newest) = &mut self.newest {
            // After an interruption, a line 1 to 5 behind does not count as late.
            newest.is_late_possible = false;
        }
    }

    /// Marks received bytes that are missing from the stream: no line spans them, and lines in them do not count as lost.
    pub fn skip(&mut self) {
        let boot = self.newest.map(|newest| newest.boot);
        self.decide_all(|line| Some(line.received.ack().boot) == boot);
        self.newest = None;
        self.fresh = 0;
        self.forget_gap();
        self.before_boot = 0;
        self.reckoning.forget();
        self.reckoning.forget_time();
        self.counters.give_up_settling();
    }

    /// Forgets which robot is followed, as when the link leads to another station; nothing is known of the lines between.
    pub fn forget_robot(&mut self) {
        self.skip();
        self.life = Life::default();
        self.robots = Robots::default();
    }

    /// Keeps the followed robot however long only another one is heard, or lets the other one replace it again. A station holds the robot
    /// to which it sends.
    pub const fn hold_robot(&mut self, is_held: bool) {
        self.robots.hold(is_held);
    }

    /// Sets the ground's time of the next bytes, ms. The time limits the number of lines lost in a silence until the robot's clock shows
    /// the number; without a time, the number is unknown until then.
    pub const fn set_time(&mut self, now_ms: u64) {
        self.reckoning.set_time(Some(now_ms));
    }

    /// Counts a number of the latest bytes as a line of the robot's own; lines counted as damaged since `before` are not damaged.
    pub fn disown(&mut self, bytes: usize, before: Damaged) {
        self.noise_before += bytes as u64;
        let counted = self.counters.damaged.total() - before.total();
        self.damaged = self.damaged.saturating_sub(counted);
        self.counters.damaged = before;
    }

    /// The field error of the latest unreadable line with a valid checksum.
    #[must_use]
    pub const fn last_field_error(&self) -> Option<FieldError> {
        self.last_field_error
    }

    /// Iterates over the intact lines that `bytes` complete. Iteration consumes the bytes.
    pub fn lines(&mut self, mut bytes: &[u8]) -> impl Iterator<Item = Received> {
        core::iter::from_fn(move || self.next_line(&mut bytes))
    }

    /// The next intact line that `bytes` complete, or `None`. Consumes `bytes` from the front. For loops that use
    /// the decoder or its owner between two lines.
    pub fn next_line(&mut self, bytes: &mut &[u8]) -> Option<Received> {
        loop {
            let end = self.next_end(bytes)?;
            // Undecided lines were returned when they arrived.
            if self.held[0].is_some() {
                self.held = [None; UNDECIDED_MAX + 1];
            }
            if let End::Line(received) = end {
                return Some(received);
            }
        }
    }

    /// The next intact line of the followed robot; lines of other robots on the channel are skipped (see [`Self::next_line`]). The first robot received is followed. Another
    /// robot replaces it after 180 of its lines, and a minute where times are known, without a line of the followed one. A line that may be another robot's is
    /// returned once a later line shows that it is not, or at the end of the stream by [`Self::undecided_lines`].
    pub fn next_own_line(&mut self, bytes: &mut &[u8]) -> Option<Received> {
        loop {
            if let End::Line(received) = self.next_own_end(bytes)? {
                return Some(received);
            }
        }
    }

    /// The lines that [`Self::next_own_line`] has not returned yet: nothing has shown whether another robot sent them. They count as the followed robot's.
    pub fn undecided_lines(&self) -> impl Iterator<Item = Received> {
        let undecided = self.undecided.iter().flatten().map(|line| line.received);
        self.held.iter().flatten().copied().chain(undecided)
    }

    /// The latest line, if [`Self::undecided_lines`] holds it.
    #[must_use]
    pub fn latest_undecided(&self) -> Option<Received> {
        let lines = self.undecided.iter().flatten();
        let latest = lines.map(|line| line.received).next_back();
        latest.filter(|_| matches!(self.sender, Sender::Undecided(_)))
    }

    /// What ends at the next CR LF, without lines that are another robot's or may be, and with such lines that were found to be the followed robot's.
    fn next_own_end(&mut self, bytes: &mut &[u8]) -> Option<End> {
        loop {
            if let Some(received) = self.held[0].take() {
                self.held.rotate_left(1);
                return Some(End::Line(received));
            }
            match self.next_end(bytes)? {
                End::Line(received) => match self.sender {
                    Sender::Other(_) | Sender::Undecided(_) => {}
                    _ if self.held[0].is_none() => return Some(End::Line(received)),
                    _ => self.hold(received),
                },
                End::Damaged => return Some(End::Damaged),
            }
        }
    }

    /// What ends at the next CR LF of `bytes`; `None` without one. Consumes the bytes up to there.
    fn next_end(&mut self, bytes: &mut &[u8]) -> Option<End> {
        if let Some(received) = self.take_whole(bytes) {
            *bytes = &bytes[LINE_BYTES..];
            return Some(End::Line(received));
        }
        let line_end = self.find_line_end(bytes);
        let (run, rest) = bytes.split_at(line_end.unwrap_or(bytes.len()));
        *bytes = rest;
        self.append(run);
        line_end?;
        Some(self.look_back().map_or(End::Damaged, End::Line))
    }

    /// The latest bytes in which a line may be.
    fn seen(&self) -> &[u8] {
        &self.window[self.filled - self.filled.min(self.fresh)..self.filled]
    }

    /// The length of `bytes` up to and including the first CR LF. Counts the earlier line feeds, which end no line; a flood
    /// of them costs only a count each.
    fn find_line_end(&mut self, bytes: &[u8]) -> Option<usize> {
        let mut is_after_cr = self.window[..self.filled].last() == Some(&b'\r');
        for (n, &byte) in bytes.iter().enumerate() {
            if byte == b'\n' {
                if is_after_cr {
                    return Some(n + 1);
                }
                self.counters.shape_rejected += 1;
            }
            is_after_cr = byte == b'\r';
        }
        None
    }

    /// Shortcut for a whole line directly after another line, without search and copy. The result is the same,
    /// because an intact line has no line feed before its end.
    fn take_whole(&mut self, bytes: &[u8]) -> Option<Received> {
        let line = bytes.first_chunk::<LINE_BYTES>()?;
        if self.fresh != 0 || !ends_a_line(line) || !is_intact(line) {
            return None;
        }
        let received = Received::Line(Line::parse(line).ok()?, *line);
        self.counters.bytes += LINE_BYTES as u64;
        self.counters.noise_bytes += LINE_BYTES as u64;
        self.accept(&received, LINE_BYTES);
        Some(received)
    }

    fn append(&mut self, run: &[u8]) {
        self.counters.bytes += run.len() as u64;
        self.counters.noise_bytes += run.len() as u64;
        self.fresh = self.fresh.saturating_add(run.len());
        let run = &run[run.len().saturating_sub(LINE_BYTES)..];
        let keep = self.filled.min(LINE_BYTES - run.len());
        self.window.copy_within(self.filled - keep..self.filled, 0);
        self.window[keep..keep + run.len()].copy_from_slice(run);
        self.filled = keep + run.len();
    }

    fn look_back(&mut self) -> Option<Received> {
        let seen = self.seen();
        let mut shaped = false;
        let mut unreadable = None;
        let mut found = None;
        if let Some(line) = seen
            .last_chunk::<LINE_BYTES>()
            .filter(|line| ends_a_line(line))
        {
            shaped = true;
            if is_intact(line) {
                match Line::parse(line) {
                    Ok(parsed) => found = Some((Received::Line(parsed, *line), LINE_BYTES)),
                    Err(error) => unreadable = Some(error),
                }
            }
        }
        if found.is_none()
            && let Some(line) = seen
                .last_chunk::<ACK_LINE_BYTES>()
                .filter(|line| AckLine::begins_with(line[0]) && ends_a_line(line))
        {
            shaped = true;
            if is_intact(line) {
                match AckLine::parse(line) {
                    Ok(parsed) => found = Some((Received::Ack(parsed), ACK_LINE_BYTES)),
                    Err(error) => unreadable = unreadable.or(Some(error)),
                }
            }
        }
        match (found, unreadable) {
            (Some((received, length)), _) => {
                self.accept(&received, length);
                Some(received)
            }
            (None, Some(error)) => {
                self.counters.field_rejected += 1;
                self.last_field_error = Some(error);
                self.count_damaged(DamageKind::Field);
                None
            }
            (None, None) => {
                let kind = if shaped {
                    self.counters.crc_rejected += 1;
                    DamageKind::Checksum
                } else {
                    self.counters.shape_rejected += 1;
                    DamageKind::Shape
                };
                self.count_damaged(kind);
                None
            }
        }
    }

    /// Counts the bytes before a CR LF as a damaged line.
    fn count_damaged(&mut self, kind: DamageKind) {
        let seen = &self.window[self.filled - self.filled.min(self.fresh)..self.filled];
        self.counters.damaged.count(kind, seen);
        self.damaged += 1;
    }
}

/// What ends at a CR LF.
enum End {
    /// An intact line.
    Line(Received),
    /// A damaged line or noise.
    Damaged,
}

/// Whether the bytes end like a line, with CR LF.
fn ends_a_line<const N: usize>(line: &[u8; N]) -> bool {
    line.ends_with(b"\r\n")
}

#[cfg(test)]
mod tests;
