//! State of the robot by its lines, and transmission of frames.

use std::cell::RefCell;
use std::collections::{BTreeMap, VecDeque};
use std::future::poll_fn;
use std::rc::Rc;
use std::task::Poll;
use std::time::Duration;

use groundwave_protocol::command::{Frame, Key, Message};
use groundwave_protocol::crc;
use groundwave_protocol::decoder::Received;
use groundwave_protocol::telemetry::{
    AbilitiesLine, Ack, Body, CountersLine, Detail, ParameterLine, StateLine, StatusLine,
};

use super::Verdict;

/// Latency of the link in both directions together, after which an acknowledgement counts as an answer.
const LATENCY: Duration = Duration::from_millis(300);

/// Byte times from the composition of an acknowledgement to the end of its line; longer than any frame with a turn's line feeds.
pub(super) const ANSWER_BYTES: u32 = 11;

/// Time between copies of a frame that has had no effect yet.
const AGAIN: Duration = Duration::from_millis(1200);

/// Time within which a frame must have its effect; radios damage some copies and some answers.
pub(super) const LIMIT: Duration = Duration::from_secs(15);

/// Maximum wait for a line B or C. One comes every 4 s; radios damage half of them.
pub(super) const RARE: Duration = Duration::from_mins(1);

/// Number of copies of a frame that must have no effect, and the pause after each.
const COPIES: usize = 3;

/// Maximum wait for lines that show an effect which must not occur.
const LISTEN: Duration = Duration::from_secs(20);

/// Maximum number of bytes in a half-duplex turn.
const TURN_BYTES: usize = 200;

/// The latest lines of the robot.
#[derive(Debug, Default)]
pub(super) struct Seen {
    pub(super) robot_id: Option<u8>,
    pub(super) ack: Option<Ack>,
    /// Boot, session and era of the latest acknowledgement that showed an era.
    pub(super) era: Option<(u8, u8, u16)>,
    /// Owner in the latest acknowledgement that showed one; `None` for a receipt.
    pub(super) owner: Option<u16>,
    pub(super) receipt: Option<u16>,
    /// Boot and session of the latest acknowledgement with an owner, and whether that session has shown a receipt, too.
    open: Option<(u8, u8)>,
    pub(super) has_late_receipt: bool,
    /// First missing block and tag of the staged list in the latest acknowledgement that could show them.
    pub(super) staged: Option<(u8, u8)>,
    /// Window of the latest acknowledgement with a staged list.
    pub(super) window: u8,
    pub(super) cannot_hear: bool,
    pub(super) sequence: u8,
    /// Number of lines missing in the sequence.
    pub(super) missing: u64,
    /// Number of lines K, and number of lines A.
    pub(super) quick_acks: u64,
    pub(super) states: u64,
    /// Number of lines, number of lines K since the latest long line, and arrival of the latest line.
    pub(super) lines: u64,
    pub(super) quick_run: u8,
    pub(super) at: Duration,
    pub(super) state: Option<(Duration, StateLine)>,
    pub(super) status: Option<(Duration, StatusLine)>,
    pub(super) counters: Option<(Duration, CountersLine)>,
    pub(super) abilities: Option<AbilitiesLine>,
    pub(super) parameters: BTreeMap<u8, (Duration, ParameterLine)>,
    pub(super) is_half_duplex: bool,
    /// Number of lines G.
    turns: u64,
}

impl Seen {
    pub(super) fn take(&mut self, now: Duration, received: &Received) {
        let ahead = (u64::from(received.sequence()) + 199 - u64::from(self.sequence)) % 100;
        // The first line has no predecessor.
        self.missing += ahead * u64::from(self.ack.is_some());
        self.sequence = received.sequence();
        self.lines += 1;
        self.at = now;
        self.quick_run = match received {
            Received::Line(..) => 0,
            Received::Ack(_) => self.quick_run.saturating_add(1),
        };
        if let Some(robot_id) = received.robot_id() {
            self.robot_id = Some(robot_id);
        }
        let ack = *received.ack();
        self.ack = Some(ack);
        match ack.detail {
            Detail::Idle { owner, .. } => {
                (self.owner, self.staged) = (Some(owner), None);
                // Lines with and without the receipt alternate.
                if owner != 0 {
                    self.receipt = None;
                    self.open = Some((ack.boot, ack.session));
                }
            }
            Detail::Staging {
                first_missing,
                tag,
                window,
            } => (self.staged, self.window) = (Some((first_missing, tag)), window),
            Detail::Stopped { receipt } => {
                self.has_late_receipt |= self.open == Some((ack.boot, ack.session));
                (self.owner, self.staged, self.receipt) = (Some(0), None, Some(receipt));
            }
            Detail::Era { era } => self.era = Some((ack.boot, ack.session, era)),
            Detail::CannotHear { .. } => self.cannot_hear = true,
        }
        match received {
            Received::Ack(line) if line.listens => {
                self.is_half_duplex = true;
                self.turns += 1;
            }
            Received::Ack(_) => self.quick_acks += 1,
            Received::Line(line, _) => match line.body {
                Body::State(state) => {
                    self.states += 1;
                    self.state = Some((now, state));
                }
                Body::Status(status) => self.status = Some((now, status)),
                Body::Counters(counters) => self.counters = Some((now, counters)),
                Body::Abilities(abilities) => self.abilities = Some(abilities),
                Body::Parameter(line) => {
                    self.parameters.insert(line.place, (now, line));
                }
                _ => {}
            },
        }
    }

    /// The era of the current session.
    pub(super) fn present_era(&self) -> Option<u16> {
        let ack = self.ack?;
        let (boot, session, era) = self.era?;
        ((boot, session) == (ack.boot, ack.session)).then_some(era)
    }
}

/// State shared by the script and its driver.
#[derive(Debug, Default)]
pub(super) struct Shared {
    pub(super) now: Duration,
    pub(super) seen: Seen,
    pub(super) verdicts: VecDeque<Verdict>,
    pub(super) prompts: VecDeque<&'static str>,
    pub(super) awaits_reset: bool,
    pub(super) deadline: Option<Duration>,
    /// Frames queued for the radio.
    pub(super) waiting: VecDeque<Vec<u8>>,
    /// Time at which the last byte of the latest frame has left.
    left_at: Duration,
    pub(super) byte_time: Duration,
}

impl Shared {
    /// The bytes to send now. In half duplex: complete frames, in the turn that a line G began.
    pub(super) fn transmit(&mut self, is_turn: bool) -> Option<Vec<u8>> {
        if self.seen.is_half_duplex && !is_turn {
            return None;
        }
        let mut bytes = self.waiting.pop_front()?;
        if self.seen.is_half_duplex {
            while let Some(next) = self.waiting.front()
                && bytes.len() + next.len() <= TURN_BYTES
            {
                bytes.extend(self.waiting.pop_front().unwrap_or_default());
            }
            bytes.extend(Frame::over().as_bytes());
        }
        let count = u32::try_from(bytes.len()).unwrap_or(u32::MAX);
        self.left_at = self.left_at.max(self.now) + self.byte_time * count;
        Some(bytes)
    }
}

/// The script's end of the link.
#[derive(Clone, Default)]
pub(super) struct Probe(pub(super) Rc<RefCell<Shared>>);

impl Probe {
    pub(super) fn see<T>(&self, of: impl FnOnce(&Seen) -> T) -> T {
        of(&self.0.borrow().seen)
    }

    pub(super) fn now(&self) -> Duration {
        self.0.borrow().now
    }

    pub(super) fn ask_for_reset(&self, text: &'static str) {
        let mut shared = self.0.borrow_mut();
        shared.prompts.push_back(text);
        shared.awaits_reset = true;
    }

    /// Time of some bytes on the link.
    pub(super) fn byte_times(&self, count: u32) -> Duration {
        self.0.borrow().byte_time * count
    }

    /// Time at which the latest frame has left; the time for its answers begins then.
    pub(super) fn left_at(&self) -> Duration {
        self.0.borrow().left_at
    }

    /// Waits until the condition holds, at most `limit`; returns whether it does.
    pub(super) async fn until(&self, limit: Duration, holds: impl Fn(&Seen) -> bool) -> bool {
        let end = self.now() + limit;
        poll_fn(|_| {
            let mut shared = self.0.borrow_mut();
            if holds(&shared.seen) {
                return Poll::Ready(true);
            }
            if shared.now >= end {
                return Poll::Ready(false);
            }
            shared.deadline = Some(end);
            Poll::Pending
        })
        .await
    }

    pub(super) async fn pause(&self, time: Duration) {
        self.until(time, |_| false).await;
    }

    /// Waits until the frames have left. In half duplex, this depends on the robot's turns.
    pub(super) async fn sent(&self) {
        let end = self.now() + LIMIT;
        poll_fn(|_| {
            let mut shared = self.0.borrow_mut();
            if shared.waiting.is_empty() && shared.now >= shared.left_at {
                return Poll::Ready(());
            }
            if shared.now >= end {
                // The robot gives no turn.
                shared.waiting.clear();
                return Poll::Ready(());
            }
            shared.deadline = Some(if shared.waiting.is_empty() {
                shared.left_at
            } else {
                end
            });
            Poll::Pending
        })
        .await;
    }

    /// Waits for a turn in half duplex; needed before frames that name the newest line.
    pub(super) async fn turn(&self) {
        let turns = self.see(|seen| seen.turns);
        self.until(LIMIT, |seen| !seen.is_half_duplex || seen.turns != turns)
            .await;
    }

    pub(super) fn send(&self, bytes: &[u8]) {
        self.0.borrow_mut().waiting.push_back(bytes.to_vec());
    }

    /// Sends a message until the condition holds; returns whether it does.
    pub(super) async fn effect(
        &self,
        message: &Message,
        key: Key,
        holds: impl Fn(&Seen) -> bool,
    ) -> bool {
        self.effect_of(message.encode(key).as_bytes(), holds).await
    }

    pub(super) async fn effect_of(&self, frame: &[u8], holds: impl Fn(&Seen) -> bool) -> bool {
        self.effect_within(LIMIT, frame, holds).await
    }

    pub(super) async fn effect_within(
        &self,
        limit: Duration,
        frame: &[u8],
        holds: impl Fn(&Seen) -> bool,
    ) -> bool {
        let end = self.now() + limit;
        while self.now() < end {
            self.send(frame);
            self.sent().await;
            if self.until(AGAIN, &holds).await {
                return true;
            }
        }
        false
    }

    /// Sends copies of a frame that must have no effect; returns whether it had an effect.
    pub(super) async fn has_effect(
        &self,
        frame: &[u8],
        is_changed: impl Fn(&Seen) -> bool,
    ) -> bool {
        for _ in 0..COPIES {
            self.send(frame);
            self.sent().await;
            if self.until(AGAIN / 3, &is_changed).await {
                return true;
            }
        }
        self.lines_after(&is_changed).await
    }

    /// Waits for two lines A composed after the latest frame; returns whether the condition held before.
    pub(super) async fn lines_after(&self, holds: impl Fn(&Seen) -> bool) -> bool {
        let answers_at = self.left_at() + LATENCY + self.byte_times(ANSWER_BYTES);
        let wait = answers_at.saturating_sub(self.now());
        if self.until(wait, &holds).await {
            return true;
        }
        let states = self.see(|seen| seen.states) + 2;
        self.until(LISTEN, |seen| holds(seen) || seen.states >= states)
            .await;
        self.see(&holds)
    }

    /// Waits for a line B that was composed after the latest frame.
    pub(super) async fn status(&self) -> Option<StatusLine> {
        let from = self.left_at().max(self.now()) + LATENCY + Duration::from_millis(400);
        self.until(RARE, |seen| seen.status.is_some_and(|(at, _)| at >= from))
            .await;
        self.see(|seen| {
            seen.status
                .filter(|(at, _)| *at >= from)
                .map(|(_, line)| line)
        })
    }
}

/// A frame with arbitrary type and payload.
pub(super) fn raw_frame(key: Key, content: &[u8]) -> Vec<u8> {
    let trailer = crc::characters(crc::update(key.init(), content));
    [b"\n", content, &trailer, b"\n"].concat()
}
