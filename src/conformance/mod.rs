//! Checks whether a robot keeps the rules of SPEC.md, with frames that a correct robot obeys, refuses or ignores.
//!
//! Sans-IO, like the station: the caller passes bytes and times, and gets frames and verdicts. The script is an `async` function that waits
//! for lines; [`Trials`] polls it.

mod commands;
mod driving;
mod lists;
mod parameters;
mod probe;
mod restart;
pub mod rule;
mod session;

use std::fmt;
use std::pin::Pin;
use std::task::{Context, Waker};
use std::time::Duration;

use groundwave_protocol::command::{Key, Message};
use groundwave_protocol::decoder::Decoder;
use groundwave_protocol::telemetry::LEVEL_MAX;

use probe::Probe;
use rule::Rule;
use session::Session;

/// Bits of a byte on the wire.
const BITS_PER_BYTE: u32 = 10;

/// Maximum wait for the first lines.
const FIRST_LINES: Duration = Duration::from_secs(20);

/// The result of a trial.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The robot keeps the rule.
    Kept(&'static Rule),
    /// The robot breaks the rule; with a description of its reaction.
    Broken(&'static Rule, String),
    /// The rule was not tried, for a reason.
    NotTried(&'static Rule, &'static str),
}

/// The trials of a robot.
pub struct Trials {
    probe: Probe,
    decoder: Decoder,
    script: Option<Pin<Box<dyn Future<Output = ()>>>>,
    is_turn: bool,
    verdicts: Vec<Verdict>,
}

impl fmt::Debug for Trials {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Trials")
            .field("verdicts", &self.verdicts)
            .finish_non_exhaustive()
    }
}

impl Trials {
    /// Begins trials over a link with rate `baud`, bit/s. `owner` is the station's nonce, 10 bits.
    #[must_use]
    pub fn new(owner: u16, baud: u32) -> Self {
        let probe = Probe::default();
        probe.0.borrow_mut().byte_time = Duration::from_secs(1) * BITS_PER_BYTE / baud.max(1);
        let script = Some(Box::pin(run(probe.clone(), owner.max(2))) as _);
        Self {
            probe,
            decoder: Decoder::default(),
            script,
            is_turn: false,
            verdicts: Vec::new(),
        }
    }

    /// Takes bytes from the robot.
    pub fn handle_bytes(&mut self, now: Duration, bytes: &[u8]) {
        let mut rest = bytes;
        while let Some(received) = self.decoder.next_own_line(&mut rest) {
            {
                let mut shared = self.probe.0.borrow_mut();
                shared.now = now;
                shared.seen.take(now, &received);
            }
            // A turn lasts until the next line.
            self.is_turn = matches!(received, groundwave_protocol::decoder::Received::Ack(line) if line.listens);
            self.poll();
        }
    }

    /// Handles the passing of time.
    pub fn handle_timeout(&mut self, now: Duration) {
        self.probe.0.borrow_mut().now = now;
        self.poll();
    }

    /// Time at which [`Self::handle_timeout`] is due.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Duration> {
        self.probe.0.borrow().deadline
    }

    /// The next bytes to send.
    pub fn poll_transmit(&mut self) -> Option<Vec<u8>> {
        let bytes = self.probe.0.borrow_mut().transmit(self.is_turn)?;
        if self.probe.see(|seen| seen.is_half_duplex) {
            self.is_turn = false;
        }
        // The script may wait until they are sent.
        self.poll();
        Some(bytes)
    }

    /// The next verdict.
    pub fn poll_verdict(&mut self) -> Option<Verdict> {
        let verdict = self.probe.0.borrow_mut().verdicts.pop_front()?;
        self.verdicts.push(verdict.clone());
        Some(verdict)
    }

    /// The next request to the person at the robot.
    pub fn poll_prompt(&mut self) -> Option<&'static str> {
        self.probe.0.borrow_mut().prompts.pop_front()
    }

    /// Whether the person at the robot was asked to reset it; its port may vanish for a moment then.
    #[must_use]
    pub fn awaits_reset(&self) -> bool {
        self.probe.0.borrow().awaits_reset
    }

    /// Whether all trials are over.
    #[must_use]
    pub const fn is_over(&self) -> bool {
        self.script.is_none()
    }

    /// The verdicts polled so far.
    #[must_use]
    pub fn verdicts(&self) -> &[Verdict] {
        &self.verdicts
    }

    /// Highest level whose rules, and those of all lower levels, were tried and kept; `None` if no rule was tried.
    #[must_use]
    pub fn level(&self) -> Option<u8> {
        let claimed = self.probe.see(level);
        self.verdicts
            .iter()
            .filter_map(|verdict| match verdict {
                Verdict::Broken(rule, _) => Some(rule.level - 1),
                Verdict::Kept(_) => Some(claimed),
                Verdict::NotTried(..) => None,
            })
            .min()
    }

    /// Bytes of a STOP for every robot, to send when the trials end early.
    #[must_use]
    pub fn farewell() -> Vec<u8> {
        Message::Stop(None)
            .encode(Key::EVERY_ROBOT)
            .as_bytes()
            .to_vec()
    }

    fn poll(&mut self) {
        self.probe.0.borrow_mut().deadline = None;
        if let Some(script) = &mut self.script
            && script
                .as_mut()
                .poll(&mut Context::from_waker(Waker::noop()))
                .is_ready()
        {
            self.script = None;
        }
    }
}

/// The level in line I.
fn level(seen: &probe::Seen) -> u8 {
    match (seen.cannot_hear, seen.abilities) {
        (true, _) => 1,
        (false, Some(abilities)) => abilities.level,
        (false, None) => LEVEL_MAX,
    }
}

async fn run(probe: Probe, owner: u16) {
    let is_known = probe
        .until(FIRST_LINES, |seen| {
            seen.cannot_hear
                || seen.robot_id.is_some() && seen.present_era().is_some() && seen.state.is_some()
        })
        .await;
    if !is_known || probe.see(|seen| seen.cannot_hear) {
        return;
    }
    let mut session = Session::new(probe, owner);
    if commands::run(&mut session).await.is_ok() {
        let level = session.probe.see(level);
        if level >= 3 {
            lists::run(&mut session).await;
        }
        if level >= 4 {
            driving::run(&mut session).await;
        }
        if level >= 5 {
            parameters::run(&mut session).await;
        }
        restart::run(&mut session).await;
    }
    session.stop().await;
}
