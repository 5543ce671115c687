//! Mistakes that intact lines show together: sequence, order of the lines, ids, boots and acknowledgements.

use std::collections::BTreeMap;
use std::time::Duration;

use groundwave_protocol::decoder::Received;
use groundwave_protocol::digest::digest;
use groundwave_protocol::status_codes::Power;
use groundwave_protocol::telemetry::{
    ACK_LINE_BYTES, AbilitiesLine, Ack, Body, CountersLine, Detail, Line, Reading, SEQUENCE_MODULUS,
};
use groundwave_protocol::{BYTES_PER_S, LINE_BYTES};

use super::kind::{self, Kind};

/// A robot must show the era at least once in this many consecutive lines; in twice as many while it acknowledges a STOP.
const ERA_EVERY: u32 = 4;

/// Maximum number of consecutive lines A from a robot with lines C; the sixth allows for an extra line.
const STATES_MAX: u32 = 6;

/// Maximum time between the beginnings of two lines, seconds: at the lowest rate, with turns.
const LINE_S_MAX: u32 = 4;

/// Maximum number of lines that a robot begins in a second.
const LINES_PER_S_MAX: u32 = 12;

/// Minimum time over which lines are counted by the receiver's clock, and the lines that may have waited in buffers before.
const RATE_TIME_MIN: Duration = Duration::from_secs(10);
const BUFFERED_LINES: f64 = 60.0;

/// Longest time between two lines C that are compared, seconds.
const COMPARED_S_MAX: u32 = 60;

/// Maximum number of consecutive lines without a line I from a robot that lacks something: 12 per second for 20 s.
const ABILITIES_EVERY: u32 = 240;

/// Minimum number of jumps of the sequence by one step that are the robot's, and of jumps by any steps.
const JUMPS_ALIKE: u64 = 8;
const JUMPS: u64 = 60;

/// Share of lines that directly follow the previous one, per cent; below it, jumps are the robot's.
const JUMPS_NEXT_PCT: u64 = 5;

/// Maximum number of whole rounds of the sequence for each line 00 that came too early. A turn of a half-duplex radio can swallow
/// the line before a line 00, but seldom.
const WHOLE_WRAPS_MAX: u64 = 20;

/// Maximum length of a line that a restart cut off, bytes.
const CUT_BYTES_MAX: u64 = 80;

/// A suspected mistake: column and kind.
pub(super) type Suspicion = (usize, &'static Kind);

/// A line that was judged.
pub(super) struct Taken {
    /// Suspicions that it raises.
    pub found: Vec<Suspicion>,
    /// Whether the sequence follows that of the previous line; other bytes may be between the two.
    pub is_next: bool,
}

/// State of the robot by the lines so far.
#[derive(Clone, Debug, Default)]
pub(super) struct Conduct {
    previous: Option<Previous>,
    /// Latest sequence of each type.
    by_type: BTreeMap<u8, u8>,
    /// Uptime and boots of the latest line C.
    counters: Option<(u32, u16)>,
    /// Uptime of an earlier line C, and the lines since, if none is missing.
    earlier: Option<(u32, u32)>,
    abilities: Option<AbilitiesLine>,
    /// Lines in a row without a line I.
    without_abilities: u32,
    /// The level of all lines but I.
    level: u8,
    /// Lines G.
    turns: u64,
    without_era: u32,
    has_receipt: bool,
    states: u32,
    /// Letter of the latest long line, if no line has been missing since.
    long: Option<u8>,
    has_status: bool,
    has_counters: bool,
    /// Sequences other than 99 that preceded a line 00 of the same boot, and how often.
    wraps: BTreeMap<u8, u64>,
    /// Number of lines 00 that directly followed a line 99.
    whole_wraps: u64,
    /// Number of jumps of the sequence by each step, modulo 100.
    jumps: BTreeMap<u8, u64>,
    /// Number of pairs of consecutive lines, and number of those pairs with two types.
    pub pairs: u64,
    pub changes: u64,
    /// Lines, and those at the beginning of a count by the receiver's clock.
    lines: u64,
    timed: Option<(Duration, u64)>,
    /// Counts with too many lines that no line has reported yet.
    overruns: u32,
}

#[derive(Debug, Clone, Copy)]
struct Previous {
    sequence: u8,
    letter: u8,
    boot: u8,
    noise: u64,
    is_era: bool,
    cannot_hear: bool,
}

impl Conduct {
    /// Takes a line; returns the suspected mistakes. `noise` is the total number of bytes outside lines.
    pub(super) fn take(&mut self, received: &Received, noise: u64) -> Taken {
        let mut found = Vec::new();
        let (letter, column) = place(received);
        self.lines += 1;
        if std::mem::take(&mut self.overruns) > 0 {
            found.push((1, kind::LINE_RATE));
        }
        let ack = *received.ack();
        let sequence = received.sequence();
        let now = Previous {
            sequence,
            letter,
            boot: ack.boot,
            noise,
            is_era: matches!(ack.detail, Detail::Era { .. }),
            cannot_hear: matches!(ack.detail, Detail::CannotHear { .. }),
        };
        let last_of_type = self.by_type.insert(letter, sequence);
        let previous = self.previous.replace(now);
        let follows = previous
            .is_some_and(|previous| self.judge_sequence(&mut found, previous, now, last_of_type));
        if let Some(previous) = previous {
            if previous.boot == now.boot && previous.cannot_hear != now.cannot_hear {
                found.push((column, kind::HEARING));
            }
            if follows && previous.is_era && now.is_era {
                found.push((column, kind::ERA_TWICE));
            }
        }
        let is_next = previous.is_some_and(|previous| {
            previous.boot == now.boot && now.sequence == (previous.sequence + 1) % SEQUENCE_MODULUS
        });
        if previous.is_some_and(|previous| previous.boot != now.boot) {
            (self.abilities, self.level) = (None, 0);
        }
        if !follows {
            (self.without_era, self.states, self.without_abilities) = (0, 0, 0);
            (self.earlier, self.long) = (None, None);
        }
        if let Some((_, lines)) = &mut self.earlier {
            *lines += 1;
        }
        self.without_abilities += 1;
        if now.cannot_hear || self.has_counters {
            self.without_abilities = 0;
        }
        let is_turn = matches!(received, Received::Ack(line) if line.listens);
        self.turns += u64::from(is_turn);
        self.level = self.level.max(super::examiner::level(received, false));
        self.judge_era(&mut found, ack, column);
        if let Received::Line(line, _) = received {
            self.judge_order(&mut found, letter, sequence);
            self.judge_content(&mut found, line);
        }
        if self.without_abilities > ABILITIES_EVERY {
            found.push((1, kind::NO_ABILITIES));
            self.without_abilities = 0;
        }
        Taken { found, is_next }
    }

    /// Takes the receiver's clock, which shows more lines a second than a robot may begin.
    pub(super) fn take_time(&mut self, now: Duration) {
        if self.lines == 0 {
            return;
        }
        let (since, before) = *self.timed.get_or_insert((now, self.lines));
        let passed = now.saturating_sub(since);
        let most = f64::from(LINES_PER_S_MAX) * passed.as_secs_f64() + BUFFERED_LINES;
        if passed >= RATE_TIME_MIN && (self.lines - before) as f64 > most {
            self.overruns += 1;
            self.timed = None;
        }
    }

    /// Judges the sequence of two lines; returns whether no line is missing between them.
    fn judge_sequence(
        &mut self,
        found: &mut Vec<Suspicion>,
        previous: Previous,
        now: Previous,
        last_of_type: Option<u8>,
    ) -> bool {
        let after = |sequence: u8| (sequence + 1) % SEQUENCE_MODULUS;
        let is_next = now.sequence == after(previous.sequence);
        self.whole_wraps += u64::from(is_next && now.sequence == 0);
        let noise = now.noise - previous.noise;
        // The number of short lines that the noise may have been.
        let missing = u64::from(SEQUENCE_MODULUS - 1 - previous.sequence);
        let is_explained = noise >= missing * ACK_LINE_BYTES as u64;
        let begins_anew = now.sequence == 0 && previous.sequence > 5 && last_of_type.is_some();
        if begins_anew && !is_next && !is_explained && noise < CUT_BYTES_MAX {
            // The previous line was sent before the boot, or the sequence wraps.
            if previous.boot == now.boot {
                *self.wraps.entry(previous.sequence).or_default() += 1;
                if let Some(kind) = self.wrap() {
                    found.push((2, kind));
                }
            }
            return false;
        }
        if noise > 0 {
            return false;
        }
        self.pairs += 1;
        let is_change = previous.letter != now.letter;
        self.changes += u64::from(is_change);
        let is_per_type = is_change && last_of_type.is_some_and(|last| now.sequence == after(last));
        if is_next {
            if previous.boot != now.boot && now.sequence != 0 {
                found.push((if now.letter == b'K' { 4 } else { 70 }, kind::BOOT_CHANGES));
            }
            return true;
        }
        if previous.boot == now.boot {
            let step = (now.sequence + SEQUENCE_MODULUS - previous.sequence) % SEQUENCE_MODULUS;
            *self.jumps.entry(step).or_default() += 1;
            found.push(match now.sequence {
                _ if is_per_type => (2, kind::PER_TYPE),
                same if same == previous.sequence => (2, kind::STUCK),
                _ => (2, kind::JUMP),
            });
        }
        false
    }

    /// Whether the robot, not the radio, makes the sequence jump: mostly by the same step, or nearly always. Lost lines cause jumps
    /// by various steps, and some lines still follow directly.
    pub(super) fn jumps(&self) -> bool {
        let most = self.jumps.values().max().copied().unwrap_or(0);
        let all: u64 = self.jumps.values().sum();
        let next = self.pairs.saturating_sub(all);
        let is_one_step = most >= JUMPS_ALIKE && most * 4 > self.pairs * 3;
        is_one_step || all >= JUMPS && next * 100 < self.pairs * JUMPS_NEXT_PCT
    }

    /// The mistake of a sequence that restarts too early: always at the same number, or at restarts. If the radio loses a quarter of the
    /// lines, or nearly every round is whole, no restart shows it.
    fn wrap(&self) -> Option<&'static Kind> {
        let early: u64 = self.wraps.values().sum();
        let is_rare = self.whole_wraps > early * WHOLE_WRAPS_MAX;
        if is_rare || self.jumps.values().sum::<u64>() * 4 > self.pairs {
            return None;
        }
        if self.wraps.values().any(|count| *count > 1) {
            return Some(kind::WRAP);
        }
        (self.wraps.len() > 1).then_some(kind::BOOT_SAME)
    }

    fn judge_era(&mut self, found: &mut Vec<Suspicion>, ack: Ack, column: usize) {
        match ack.detail {
            Detail::Era { .. } => (self.without_era, self.has_receipt) = (0, false),
            Detail::CannotHear { .. } => self.without_era = 0,
            Detail::Stopped { .. } => {
                self.without_era += 1;
                self.has_receipt = true;
            }
            Detail::Idle { robot_id, .. } => {
                self.without_era += 1;
                if robot_id == 0 {
                    found.push((column, kind::ID_ZERO));
                }
            }
            Detail::Staging { .. } => self.without_era += 1,
        }
        if self.without_era >= ERA_EVERY * if self.has_receipt { 2 } else { 1 } {
            found.push((column, kind::NO_ERA));
            self.without_era = 0;
        }
    }

    fn judge_order(&mut self, found: &mut Vec<Suspicion>, letter: u8, sequence: u8) {
        let before = self.long.replace(letter);
        if letter != b'A' {
            self.states = 0;
            // After boot line B follows line C.
            if before.is_some_and(|before| before != b'A') && sequence > 1 {
                found.push((1, kind::NO_STATE));
            }
            return;
        }
        self.states += 1;
        let max = match (self.has_counters, self.has_status) {
            (true, _) => STATES_MAX,
            (false, true) => 2 * STATES_MAX,
            (false, false) => u32::MAX,
        };
        if self.states > max {
            found.push((1, kind::ONLY_STATE));
            self.states = 0;
        }
    }

    fn judge_content(&mut self, found: &mut Vec<Suspicion>, line: &Line) {
        if let Some(abilities) = &self.abilities
            && let Some(column) = disagreement(abilities, &line.body)
        {
            found.push((column, kind::ABILITIES));
        }
        let (robot_id, boots, boots_column) = match &line.body {
            Body::Status(status) => {
                self.has_status = true;
                if status.list.count == 0 && status.digest != digest([].iter()) {
                    found.push((33, kind::DIGEST_EMPTY));
                }
                (status.robot_id, Some(status.boots), 60)
            }
            Body::Counters(counters) => {
                self.has_counters = true;
                self.judge_uptime(found, counters);
                (counters.robot_id, Some(counters.boots), 15)
            }
            Body::Abilities(abilities) => {
                self.without_abilities = 0;
                self.abilities = Some(*abilities);
                let hears = !matches!(line.ack.detail, Detail::CannotHear { .. });
                if hears && abilities.level < self.level {
                    found.push((8, kind::ABILITIES));
                }
                (abilities.robot_id, None, 0)
            }
            _ => return,
        };
        if let Some(boots) = boots
            && boots % 8 != u16::from(line.ack.boot)
        {
            found.push((boots_column, kind::BOOT_DISAGREES));
        }
        match line.ack.detail {
            Detail::Idle { robot_id: id, .. } | Detail::CannotHear { robot_id: id }
                if id != robot_id =>
            {
                found.push((5, kind::ID_DISAGREES));
            }
            _ => {}
        }
    }

    fn judge_uptime(&mut self, found: &mut Vec<Suspicion>, counters: &CountersLine) {
        let uptime_s = counters.uptime_s;
        let before = self.counters.replace((uptime_s, counters.boots));
        let earlier = self.earlier;
        let Some((before_s, boots)) = before else {
            self.earlier = Some((uptime_s, 0));
            return;
        };
        if boots != counters.boots || uptime_s < before_s {
            self.earlier = Some((uptime_s, 0));
            if boots == counters.boots && uptime_s + 500_000 > before_s {
                found.push((15, kind::BOOT_SAME));
            }
            return;
        }
        let Some((earlier_s, lines)) = earlier else {
            self.earlier = Some((uptime_s, 0));
            return;
        };
        let passed_s = uptime_s - earlier_s;
        let rate = self.abilities.map_or(BYTES_PER_S, |it| it.rate_bytes_per_s);
        let lines_max = (passed_s + 2) * LINES_PER_S_MAX;
        if rate > BYTES_PER_S && lines > lines_max {
            found.push((8, kind::LINE_RATE));
            self.earlier = Some((uptime_s, 0));
        } else if passed_s > self.longest_s(lines) || lines >= 2 * lines_max {
            found.push((8, kind::UPTIME));
            self.earlier = Some((uptime_s, 0));
        } else if passed_s > COMPARED_S_MAX {
            self.earlier = Some((uptime_s, 0));
        }
    }

    /// Longest time in which a robot begins these lines, seconds. Without turns and up to 2400 baud it sends without a gap.
    fn longest_s(&self, lines: u32) -> u32 {
        match self.abilities.map(|it| it.rate_bytes_per_s) {
            Some(rate) if rate <= BYTES_PER_S && self.turns == 0 => {
                2 * (lines + 1) * LINE_BYTES as u32 / rate + 1
            }
            _ => (lines + 1) * LINE_S_MAX,
        }
    }
}

/// The column of a line that line I contradicts.
fn disagreement(abilities: &AbilitiesLine, body: &Body) -> Option<usize> {
    let lacks = |reading| !abilities.measures(reading);
    match body {
        Body::State(state) if !abilities.has_mode(state.mode) => Some(61),
        Body::State(state) if lacks(Reading::Sonars) && state.sonar_left_in.is_some() => Some(39),
        Body::State(state) if lacks(Reading::Sonars) && state.sonar_right_in.is_some() => Some(43),
        Body::State(state)
            if lacks(Reading::Battery) && matches!(state.power, Power::Low | Power::Critical) =>
        {
            Some(58)
        }
        Body::Status(status) if lacks(Reading::Battery) && status.battery_dv > 0 => Some(8),
        Body::Status(status) if lacks(Reading::MaxCount) && status.max_count > 0 => Some(40),
        Body::Status(status) if status.list.count > abilities.capacity => Some(29),
        Body::Field(field) if field.count != abilities.fields => Some(7),
        Body::Values(values) => {
            let own = usize::from(abilities.fields);
            let beyond = values.values().skip(own).position(|it| it.is_some());
            beyond.map(|n| 5 + 7 * (own + n))
        }
        _ => None,
    }
}

/// Letter of a line, and column of its acknowledgement. Lines K and G count as one type.
fn place(received: &Received) -> (u8, usize) {
    match received {
        Received::Line(line, _) => (line.body.line_type().letter(), 70),
        Received::Ack(_) => (b'K', 4),
    }
}
