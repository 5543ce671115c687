//! Counts lines as they arrive: which were lost before them, which are damaged, and where the robot booted.

use super::reckoning::AtCounters;
use super::robots::{Sender, Silence};
use super::{DamageKind, Decoder, Lost};
use crate::LINE_BYTES;
use crate::life::Life;
use crate::received::Received;
use crate::telemetry::{ACK_LINE_BYTES, SEQUENCE_MODULUS};

/// Minimum number of lines lost between two lines with the same sequence.
const FULL_ROUND: u64 = SEQUENCE_MODULUS as u64 - 1;

/// Number of lines that may be lost in addition to `lost`, in whole hundreds, if at most `most` are lost in total.
const fn hundreds_beyond(lost: u64, most: u64) -> u64 {
    let round = SEQUENCE_MODULUS as u64;
    most.saturating_sub(lost) / round * round
}

/// Maximum number of lines by which a late or repeated line is behind the newest; a line further behind ends a long gap.
pub(super) const LATE_LINES_MAX: u8 = 5;

/// Maximum time by which a radio delays a line, ms (SPEC.md, section 12).
const LATE_MS_MAX: u64 = 5000;

/// Maximum number of lines whose sender is not known yet: more than a robot that takes a list sends between two lines with its id.
pub(super) const UNDECIDED_MAX: usize = 16;

/// Minimum noise of a damaged line, long or short, bytes.
const NOISE_MIN: u64 = 10;

/// Maximum number of lines in a gap whose damaged lines are recognized by the amount of noise alone.
const FEW_LINES: u64 = 4;

/// Maximum difference of a damaged line's length from a line's, bytes.
const LENGTH_TOLERANCE: u64 = 6;

/// The newest line by its sequence; later lines are counted from it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Newest {
    /// The robot's boot counter, from its acknowledgements.
    pub(super) boot: u8,
    pub(super) sequence: u8,
    /// Bit `n`: the line `n` lines before this one arrived, or was sent before counting began.
    arrived: u8,
    /// Whether the next line may be late, because there was no interruption since this line.
    pub(super) is_late_possible: bool,
}

impl Newest {
    /// Takes an earlier line, by a number of lines, for the newest.
    const fn go_back(&mut self, lines: u8) {
        self.sequence = (self.sequence + SEQUENCE_MODULUS - lines) % SEQUENCE_MODULUS;
        self.arrived = self.arrived >> lines | !(u8::MAX >> lines);
    }
}

/// The state after a gap.
#[derive(Clone, Copy, Debug)]
pub(super) struct AfterGap {
    boot: AtCounters,
    /// Number of lines in the gap.
    lost: u64,
    /// Number of damaged lines in the gap.
    damaged: u64,
    /// Maximum number of lines that the robot can have sent in the gap, by the ground's clock; 0 without one.
    most: u64,
    /// Whether the lost lines take longer than the ground's clock shows.
    is_impossible: bool,
    /// Whether the lines do not count as lost yet, because a boot fits the clock.
    is_doubtful: bool,
}

/// A line whose sender the next line decides, and the state when it arrived.
#[derive(Clone, Copy, Debug)]
pub(super) struct Undecided {
    pub(super) received: Received,
    length: usize,
    time_ms: Option<u64>,
    damaged: u64,
    noise_bytes: u64,
}

impl Decoder {
    /// Takes an intact line of `length` bytes.
    pub(super) fn accept(&mut self, received: &Received, length: usize) {
        self.fresh = 0;
        self.counters.noise_bytes -= length as u64;
        let silence = self.silence();
        if let Some(is_own) = self.sent_own(received, silence) {
            let boot = received.ack().boot;
            let is_one = self.undecided[1].is_none();
            self.decide_all(|line| is_own && (is_one || line.received.ack().boot == boot));
        }
        match received {
            Received::Line(..) => self.counters.lines += 1,
            Received::Ack(_) => self.counters.ack_lines += 1,
        }
        let sender = self.robots.take(received, silence);
        self.sender = sender;
        self.counters.robot = self.robots.own_id();
        self.counters.replaced_robot = self.robots.replaced_id();
        self.counters.other_robots = self.robots.other_ids();
        match sender {
            Sender::Own => self.count_own(received, length),
            Sender::Other(_) => self.count_other(received),
            // The replaced robot may have sent until now, or not at all.
            Sender::Successor => self.count_first(received, length, 0),
            Sender::Unclear(skipped) => self.count_first(received, length, skipped),
            Sender::Undecided(missing) => {
                if self.undecided.iter().all(Option::is_some) {
                    let boot = self.newest.map(|newest| newest.boot);
                    self.decide_all(|line| Some(line.received.ack().boot) == boot);
                }
                self.counters.undecided = self.counters.undecided.max(missing.into());
                let free = self.undecided.iter_mut().find(|line| line.is_none());
                if let Some(free) = free {
                    *free = Some(Undecided {
                        received: *received,
                        length,
                        time_ms: self.reckoning.time(),
                        damaged: self.damaged,
                        noise_bytes: self.counters.noise_bytes,
                    });
                }
            }
        }
    }

    /// Counts the first line of a robot; between the line before and this one, up to `skipped` lines are lost, or as many as fit in the silence.
    fn count_first(&mut self, received: &Received, length: usize, skipped: u8) {
        let skipped = u64::from(skipped);
        let is_timed = self.reckoning.silence_ms().is_some();
        let fitting = self.reckoning.fitting(length);
        let silent = self.reckoning.take_pause(false, length);
        let most = match silent {
            Some(most) => most.max(skipped),
            None if is_timed => skipped.min(fitting),
            None => skipped,
        };
        self.skip();
        self.life = Life::default();
        self.counters.hidden = self.counters.hidden.and(Lost {
            min: 0,
            max: most,
            is_open: self.reckoning.time().is_none(),
        });
        self.count_own(received, length);
    }

    /// The ground's time since the latest line that may be the followed robot's; `None` if it is unknown.
    fn silence(&self) -> Option<Silence> {
        let ms = match self.undecided.iter().flatten().last() {
            Some(line) => self.reckoning.time()?.saturating_sub(line.time_ms?),
            None => self.reckoning.silence_ms()?,
        };
        let lines_max = self.reckoning.most_in(ms);
        Some(Silence { ms, lines_max })
    }

    /// Whether the followed robot sent the undecided lines, by the next line; `None` if that remains open, or without such lines.
    fn sent_own(&mut self, next: &Received, silence: Option<Silence>) -> Option<bool> {
        let first = self.undecided[0]?;
        let last = self.undecided.iter().flatten().last()?;
        let (first, last) = (&first.received, &last.received);
        self.robots.sent_own(first, last, next, silence)
    }

    /// Counts the undecided lines; `is_own` says which of them the followed robot sent.
    pub(super) fn decide_all(&mut self, is_own: impl Fn(&Undecided) -> bool) {
        let lines = core::mem::replace(&mut self.undecided, [None; UNDECIDED_MAX]);
        self.counters.undecided = 0;
        for line in lines.iter().flatten() {
            self.decide(line, is_own(line));
        }
    }

    /// Keeps a line of the followed robot for [`Self::next_own_line`].
    pub(super) fn hold(&mut self, line: Received) {
        if let Some(free) = self.held.iter_mut().find(|held| held.is_none()) {
            *free = Some(line);
        }
    }

    /// Counts what a line says of lost lines as of its arrival.
    fn decide(&mut self, line: &Undecided, is_own: bool) {
        if !is_own {
            self.count_other(&line.received);
            return;
        }
        self.hold(line.received);
        let (damaged, noise_bytes) = (self.damaged, self.counters.noise_bytes);
        let now_ms = self.reckoning.time();
        self.damaged = line.damaged;
        self.counters.noise_bytes = line.noise_bytes;
        self.reckoning.set_time(line.time_ms);
        self.count_own(&line.received, line.length);
        self.damaged = damaged.saturating_sub(line.damaged);
        self.counters.noise_bytes = noise_bytes;
        self.reckoning.set_time(now_ms);
    }

    const fn count_other(&mut self, received: &Received) {
        match received {
            Received::Line(..) => self.counters.other_lines += 1,
            Received::Ack(_) => self.counters.other_ack_lines += 1,
        }
    }

    fn count_own(&mut self, received: &Received, length: usize) {
        let is_boot = self.count_lost(received.sequence(), received.ack().boot, length);
        self.damaged = 0;
        self.is_interrupted = false;
        self.noise_before = self.counters.noise_bytes;
        self.bytes_before = self.counters.bytes;
        if matches!(received, Received::Ack(line) if line.listens) {
            self.reckoning.take_go_ahead();
        }
        let has_restarted = self.life.take(received);
        self.counters.restarts += u64::from(has_restarted);
        if has_restarted {
            // The boot counter in the acknowledgements may be equal.
            if !is_boot {
                // Without times, `hidden` is open from now on.
                self.counters.unsettled.is_open = false;
                self.reckoning.forget();
                let is_in_gap = |gap: &AfterGap| {
                    (self.longest_step > 0 || gap.is_doubtful || gap.lost == 0)
                        && (gap.is_impossible || self.before_repeated.is_none())
                };
                if let Some(gap) = self.after_longest.filter(is_in_gap) {
                    self.counters.lines_lost -= self.longest_step;
                    self.counters.damaged_in_gaps -= gap.damaged;
                    // The boot divides the gap: what may be lost in it is counted before and after the boot.
                    let doubted = if gap.is_doubtful { gap.lost } else { 0 };
                    let in_gap = doubted + hundreds_beyond(gap.lost, gap.most);
                    let unsettled = &mut self.counters.unsettled.max;
                    *unsettled = unsettled.saturating_sub(in_gap);
                    self.add_before_boot(gap.most.saturating_sub(gap.boot.lines_before()));
                    self.begin_life(gap.boot, gap.damaged);
                } else {
                    self.add_before_boot(self.before_repeated.unwrap_or(0));
                }
                self.counters.give_up_settling();
            }
            if self.reckoning.time().is_none() {
                self.counters.hidden.is_open = true;
                self.counters.unclocked_gaps += 1;
            }
            if let Some(newest) = &mut self.newest {
                // The gap is not counted, so late lines in it are not subtracted.
                newest.arrived = !0;
            }
        }
        // The clock in a repeated line C is old.
        let clock = received.clock().filter(|_| !self.reckoning.is_repeated());
        if let Some((uptime_s, frames_heard)) = clock {
            if self.reckoning.has_begun() {
                self.counters.unsettled = Lost::default();
                let gap = self
                    .after_longest
                    .filter(|gap| gap.is_doubtful && !has_restarted);
                self.counters.lines_lost += gap.map_or(0, |gap| gap.lost);
            } else {
                self.counters.give_up_settling();
            }
            let mut hidden = self
                .reckoning
                .take_uptime(uptime_s, frames_heard, &self.counters);
            if hidden.max > 0 {
                if let Some(newest) = &mut self.newest {
                    newest.go_back(self.reckoning.go_back());
                }
                if self.reckoning.is_late() {
                    self.open_unless_timed();
                }
            }
            // Each line that may be lost before the boot, already counted, takes the place of one after it in the same silence.
            let before = core::mem::take(&mut self.before_boot);
            hidden.max = hidden.max.saturating_sub(before).max(hidden.min);
            // A damaged line for which the sequence shows no place may be among the hundreds.
            let unplaced = self.counters.unplaced_damaged();
            let before = core::mem::replace(&mut self.unplaced_before, unplaced);
            hidden.min = hidden.min.saturating_sub(unplaced.saturating_sub(before));
            self.counters.hidden = self.counters.hidden.and(hidden);
        }
        if has_restarted || clock.is_some() {
            self.forget_gap();
        }
    }

    /// Forgets where the robot may have booted.
    pub(super) const fn forget_gap(&mut self) {
        self.longest_step = 0;
        self.after_longest = None;
        self.before_repeated = None;
    }

    /// Counts the lines that may be lost before a boot, at most `most`.
    const fn add_before_boot(&mut self, most: u64) {
        self.before_boot = most;
        self.counters.hidden = self.counters.hidden.and(Lost::between(0, most));
    }

    /// Begins a life of the robot (the time from boot to boot), whose first line was received after `damaged` damaged lines.
    fn begin_life(&mut self, boot: AtCounters, damaged: u64) {
        let max = boot.lines_before();
        let min = max.saturating_sub(damaged);
        self.counters.hidden = self.counters.hidden.and(Lost::between(min, max));
        self.reckoning.begin(boot);
    }

    /// Counts the lines lost before a line of the followed robot; returns whether the line is from another boot.
    fn count_lost(&mut self, sequence: u8, boot: u8, length: usize) -> bool {
        let Some(newest) = self.newest.as_mut().filter(|newest| newest.boot == boot) else {
            self.forget_gap();
            let newest = Newest {
                boot,
                sequence,
                arrived: !0,
                is_late_possible: true,
            };
            self.reckoning.advance(1);
            let fitting = self.reckoning.fitting(length);
            let silent = self.reckoning.take_pause(false, length);
            let most = silent.unwrap_or(fitting);
            let is_boot = self.newest.replace(newest).is_some();
            if is_boot {
                // The sequence restarts after a reboot, so there is no gap.
                self.counters.give_up_settling();
                let most_after = if sequence == 0 {
                    0
                } else {
                    silent.unwrap_or(0)
                };
                let is_open = self.reckoning.spend(sequence.into(), length);
                self.add_unsettled(sequence.into(), most_after, is_open);
                self.add_before_boot(most.saturating_sub(u64::from(sequence)));
                let unsettled = &mut self.counters.unsettled.max;
                *unsettled = unsettled.saturating_sub(self.before_boot);
                let boot = self.reckoning.boot(sequence, &self.counters, length);
                self.begin_life(boot, self.damaged);
            } else {
                self.reckoning.forget();
            }
            return is_boot;
        };
        let ahead = (sequence + SEQUENCE_MODULUS - newest.sequence) % SEQUENCE_MODULUS;
        let behind = (SEQUENCE_MODULUS - ahead) % SEQUENCE_MODULUS;
        let fitting = self.reckoning.fitting(length);
        let silence_ms = self.reckoning.silence_ms();
        let silent = self.reckoning.take_pause(ahead == 1, length);
        let most = silent.unwrap_or(0);
        let most_before = silent.unwrap_or(fitting);
        if most >= FULL_ROUND || silence_ms.is_some_and(|silence_ms| silence_ms > LATE_MS_MAX) {
            newest.is_late_possible = false;
        }
        if most >= FULL_ROUND {
            // The boot was in an earlier silence.
            self.before_boot = 0;
        }
        if behind > LATE_LINES_MAX || behind > 0 && !newest.is_late_possible {
            self.reckoning.advance(ahead);
            let lost = u64::from(ahead - 1);
            newest.sequence = sequence;
            newest.is_late_possible = true;
            newest.arrived = newest.arrived.unbounded_shl(u32::from(ahead)) | 1;
            let is_unclocked = self.reckoning.spend(lost, length);
            let is_impossible = is_unclocked && self.reckoning.time().is_some();
            // A boot fits where the lost lines do not.
            let is_doubtful = is_impossible && u64::from(sequence) <= fitting;
            let mut damaged = 0;
            if is_doubtful {
                // The gap is not counted, so late lines in it are not subtracted.
                newest.arrived = !0;
                self.counters.unsettled.max += lost;
            } else {
                self.add_unsettled(lost, most, is_unclocked);
                self.counters.lines_lost += lost;
                damaged = self.count_damaged_in_gap(lost);
                if damaged < lost {
                    self.open_unless_timed();
                }
            }
            let likeliest = self.after_longest;
            let likeliest = likeliest.map_or((false, 0), |gap| (gap.is_impossible, gap.lost));
            // The robot may also have booted in a silence after which the sequence goes on.
            let is_first_silence = silent.is_some() && self.after_longest.is_none();
            if (is_impossible, lost) > likeliest || is_first_silence {
                self.longest_step = if is_doubtful { 0 } else { lost };
                self.after_longest = Some(AfterGap {
                    boot: self.reckoning.boot(sequence, &self.counters, length),
                    lost,
                    damaged,
                    most: most_before,
                    is_impossible,
                    is_doubtful,
                });
            }
            return false;
        }
        if behind == 0 && most >= FULL_ROUND {
            self.counters.unsettled.max += FULL_ROUND + hundreds_beyond(FULL_ROUND, most);
        }
        let is_late = newest.arrived & 1 << behind == 0;
        self.reckoning.set_behind(behind, is_late);
        self.reckoning.spend(0, length);
        if is_late {
            // The line was counted as lost, but was only late.
            newest.arrived |= 1 << behind;
            self.counters.lines_lost -= 1;
            self.longest_step = self.longest_step.saturating_sub(1);
        } else {
            self.before_repeated = Some(most_before);
            if most_before < FULL_ROUND - u64::from(LATE_LINES_MAX) {
                self.reckoning.take_repeated(length);
            }
        }
        self.open_unless_timed();
        false
    }

    /// Adds the hundreds that may be lost besides the `lost` lines that the sequence shows, if the robot can have sent at most `most` lines in
    /// the silence; `is_open` if the ground's clock does not contain the silence.
    fn add_unsettled(&mut self, lost: u64, most: u64, is_open: bool) {
        self.counters.unclocked_gaps += u64::from(is_open);
        self.counters.unsettled = self.counters.unsettled.and(Lost {
            min: 0,
            max: hundreds_beyond(lost, most),
            is_open,
        });
    }

    /// Leaves the hundreds open after a line that does not continue the sequence, if no clock shows a pause.
    fn open_unless_timed(&mut self) {
        self.counters.unsettled.is_open |= self.reckoning.time().is_none();
    }

    /// Counts the damaged lines among the `lost` lines of a gap, including those with a damaged line feed: the noise is as
    /// long as these lines. Returns their number.
    fn count_damaged_in_gap(&mut self, lost: u64) -> u64 {
        let noise = self.counters.noise_bytes.saturating_sub(self.noise_before);
        let ended = self.damaged.min(lost);
        let (long, short) = (LINE_BYTES as u64, ACK_LINE_BYTES as u64);
        let is_all = |shorts: u64| {
            noise.abs_diff(long * (lost - shorts) + short * shorts) <= LENGTH_TOLERANCE
        };
        let is_few = lost <= FEW_LINES;
        let by_length = if is_few && self.reckoning.has_short() && (0..=lost).any(is_all) {
            lost
        } else {
            ((noise + long / 2) / long).max(u64::from(noise >= NOISE_MIN))
        };
        // Noise of the radio itself contains hardly any line ends.
        let arrived = by_length.min(lost);
        let arrived = if is_few || arrived <= 2 * ended {
            arrived.max(ended)
        } else {
            ended
        };
        for _ in ended..arrived {
            self.counters.damaged.count(DamageKind::Shape, &[]);
        }
        self.counters.damaged_in_gaps += arrived;
        arrived
    }
}
