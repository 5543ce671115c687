//! A session with the robot under test.

use std::time::Duration;

use groundwave_protocol::command::{Command, Key, Message, Open, Order};
use groundwave_protocol::telemetry::Outcome;

use super::Verdict;
use super::probe::{LIMIT, Probe, Seen, raw_frame};
use super::rule::{self, Rule};

/// The trials cannot continue.
pub(super) struct Ended;

/// The open session and the robot's identity.
pub(super) struct Session {
    pub(super) probe: Probe,
    pub(super) owner: u16,
    pub(super) robot_id: u8,
    pub(super) boot: u8,
    pub(super) number: u8,
    pub(super) era: u16,
    pub(super) key: Key,
    /// Sequence of the latest command.
    pub(super) sequence: u8,
    /// The latest command's frame.
    pub(super) latest: Vec<u8>,
    pub(super) tag: u8,
    /// Count of the latest drive frame.
    pub(super) count: u8,
    /// Receipt of the latest STOP.
    receipt: u16,
}

impl Session {
    pub(super) fn new(probe: Probe, owner: u16) -> Self {
        let robot_id = probe.see(|seen| seen.robot_id).unwrap_or_default();
        Self {
            probe,
            owner,
            robot_id,
            boot: 0,
            number: 0,
            era: 0,
            key: Key::robot(robot_id),
            sequence: 0,
            latest: Vec::new(),
            tag: 0,
            count: 0,
            receipt: owner << 5,
        }
    }

    pub(super) fn kept(&self, rule: &'static Rule) {
        self.say(Verdict::Kept(rule));
    }

    pub(super) fn broken(&self, rule: &'static Rule, did: impl Into<String>) {
        self.say(Verdict::Broken(rule, did.into()));
    }

    pub(super) fn not_tried(&self, rule: &'static Rule, why: &'static str) {
        self.say(Verdict::NotTried(rule, why));
    }

    fn say(&self, verdict: Verdict) {
        self.probe.0.borrow_mut().verdicts.push_back(verdict);
    }

    /// Adds a verdict: the rule is kept, or broken in the way that `did` describes.
    pub(super) fn judge(&self, rule: &'static Rule, is_kept: bool, did: impl FnOnce() -> String) {
        if is_kept {
            self.kept(rule);
        } else {
            self.broken(rule, did());
        }
    }

    /// Describes the silence after a frame, with line C's count of rejected frames if it has grown.
    pub(super) fn unheard(&self, rejected_before: Option<u16>) -> String {
        let rejected = self.rejected();
        match (rejected_before, rejected) {
            (Some(before), Some(after)) if before != after => format!(
                "no effect within {} s; line C counts {} more frames rejected",
                LIMIT.as_secs(),
                (after + 1000 - before) % 1000
            ),
            _ => format!("no effect within {} s", LIMIT.as_secs()),
        }
    }

    pub(super) fn rejected(&self) -> Option<u16> {
        self.probe
            .see(|seen| seen.counters.map(|(_, line)| line.frames_rejected))
    }

    /// Sends STOP until lines show its receipt; returns whether they do.
    pub(super) async fn stop(&mut self) -> bool {
        self.receipt = self.receipt & !0x1F | (self.receipt + 1) & 0x1F;
        let receipt = self.receipt;
        let stop = Message::Stop(Some(receipt));
        let key = Key::robot(self.robot_id);
        self.probe
            .effect(&stop, key, |seen| seen.receipt == Some(receipt))
            .await
    }

    /// The message that opens a session after the current one, with or without its era.
    pub(super) fn opening(&self, has_era: bool, owner: u16) -> Option<Open> {
        self.probe.see(|seen| {
            let ack = seen.ack?;
            Some(Open {
                boot: ack.boot,
                replaces: ack.session,
                owner,
                era: if has_era {
                    Some(seen.present_era()?)
                } else {
                    None
                },
            })
        })
    }

    /// Opens the next session.
    pub(super) async fn open(&mut self, has_era: bool) -> Result<bool, Ended> {
        if has_era {
            self.probe
                .until(LIMIT, |seen| seen.present_era().is_some())
                .await;
        }
        let open = self.opening(has_era, self.owner).ok_or(Ended)?;
        let era = self.probe.see(Seen::present_era).unwrap_or_default();
        let (era, number) = if open.replaces == 7 {
            ((era + 1) & 0x3FFF, 1)
        } else {
            (era, open.replaces + 1)
        };
        let owner = self.owner;
        let is_open = |seen: &Seen| {
            seen.ack.is_some_and(|ack| ack.session == number) && seen.owner == Some(owner)
        };
        let robot = Key::robot(self.robot_id);
        if !self
            .probe
            .effect(&Message::Open(open), robot, is_open)
            .await
        {
            return Ok(false);
        }
        (self.boot, self.number, self.era) = (open.boot, number, era);
        self.key = Key::session(self.robot_id, open.boot, number, owner).in_era(if has_era {
            era
        } else {
            0
        });
        (self.sequence, self.tag, self.count) = (0, 0, 0);
        Ok(true)
    }

    /// The frame of a command.
    pub(super) fn command(sequence: u8, order: Order, key: Key) -> Vec<u8> {
        let message = Message::Command(Command { sequence, order });
        message.encode(key).as_bytes().to_vec()
    }

    /// Gives an order as the next command; returns its outcome, `None` if not acknowledged.
    pub(super) async fn order(&mut self, order: Order) -> Option<Outcome> {
        let frame = Self::command((self.sequence + 1) & 0x3F, order, self.key);
        self.deliver(frame, LIMIT).await
    }

    /// Gives an order under another key; returns its outcome. Waits only briefly.
    pub(super) async fn order_under(&mut self, key: Key, order: Order) -> Option<Outcome> {
        let frame = Self::command((self.sequence + 1) & 0x3F, order, key);
        self.deliver(frame, LIMIT / 5).await
    }

    /// Gives an order of arbitrary bytes; returns its outcome.
    pub(super) async fn raw_order(&mut self, order: &[u8]) -> Option<Outcome> {
        let sequence = (self.sequence + 1) & 0x3F;
        let six = groundwave_protocol::sixbit::encode(sequence);
        let frame = raw_frame(self.key, &[b"C", &[six][..], order].concat());
        self.deliver(frame, LIMIT).await
    }

    async fn deliver(&mut self, frame: Vec<u8>, limit: Duration) -> Option<Outcome> {
        let sequence = (self.sequence + 1) & 0x3F;
        let number = self.number;
        let concluded = |seen: &Seen| {
            seen.ack
                .filter(|ack| ack.session == number && ack.sequence == sequence & 7)
                .map(|ack| ack.outcome)
        };
        self.probe
            .effect_within(limit, &frame, |seen| {
                concluded(seen).is_some_and(|it| it != Outcome::Failed)
            })
            .await;
        let outcome = self.probe.see(concluded)?;
        self.sequence = sequence;
        self.latest = frame;
        Some(outcome)
    }

    /// Gives an order that must have an outcome, and judges the rule by the actual outcome.
    pub(super) async fn expect(
        &mut self,
        rule: &'static Rule,
        order: Order,
        outcome: Outcome,
    ) -> bool {
        let rejected = self.rejected();
        let found = self.order(order).await;
        self.compare(rule, outcome, found, rejected)
    }

    pub(super) fn compare(
        &self,
        rule: &'static Rule,
        expected: Outcome,
        found: Option<Outcome>,
        rejected: Option<u16>,
    ) -> bool {
        let is_kept = found == Some(expected);
        self.judge(rule, is_kept, || {
            found.map_or_else(|| self.unheard(rejected), in_words)
        });
        is_kept
    }

    /// Sends a frame that must have no effect on session, sequence and mode; returns whether it had none.
    pub(super) async fn ignored(&self, rule: &'static Rule, frame: &[u8]) -> bool {
        let before = self.probe.see(Standing::of);
        let is_changed = |seen: &Seen| Standing::of(seen) != before;
        let has_effect = self.probe.has_effect(frame, is_changed).await;
        self.judge(rule, !has_effect, || {
            before
                .and_then(|it| Some(it.until(self.probe.see(Standing::of)?)))
                .unwrap_or_default()
        });
        !has_effect
    }

    /// Opens the session again after a broken rule that may have changed it.
    pub(super) async fn reopen(&mut self) -> Result<(), Ended> {
        if self.open(true).await? {
            return Ok(());
        }
        self.broken(rule::OPEN, self.unheard(None));
        Err(Ended)
    }

    pub(super) async fn pause(&self, milliseconds: u64) {
        self.probe.pause(Duration::from_millis(milliseconds)).await;
    }
}

pub(super) fn in_words(outcome: Outcome) -> String {
    format!("outcome {} ({})", outcome as u8, outcome.code())
}

/// State that a frame without effect does not change.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Standing {
    session: u8,
    sequence: u8,
    outcome: Outcome,
    mode: u8,
}

impl Standing {
    fn of(seen: &Seen) -> Option<Self> {
        let ack = seen.ack?;
        Some(Self {
            session: ack.session,
            sequence: ack.sequence,
            outcome: ack.outcome,
            mode: seen.state?.1.mode.letter(),
        })
    }

    fn until(self, after: Self) -> String {
        let mut changes = Vec::new();
        let mut number = |name: &str, before: u8, after: u8| {
            if before != after {
                changes.push(format!("{name} {after} after {before}"));
            }
        };
        number("session", self.session, after.session);
        number("command", self.sequence, after.sequence);
        number("outcome", self.outcome as u8, after.outcome as u8);
        if self.mode != after.mode {
            let (before, after) = (char::from(self.mode), char::from(after.mode));
            changes.push(format!("mode {after} after {before}"));
        }
        changes.join(", ")
    }
}
