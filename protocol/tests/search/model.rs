//! Everything that can happen, one step at a time.
//!
//! The network keeps every frame and every line that was ever said and may deliver any of them at any
//! time, to any station, in any order, as often as it likes, or never: loss, duplication, reordering
//! and delay without a bound.

use groundwave_protocol::arq::FopEvent;
use groundwave_protocol::decoder::Received;
use groundwave_protocol::telemetry::Outcome;
use stateright::{Model, Property};
use std::hash::{Hash, Hasher};
use std::sync::Arc;

use crate::ground::{Ground, WAITS_US, Wish, digest_of};
use crate::instants::EPOCH_US;
use crate::robot::{Epoch, Robot};

/// What there is and what may happen.
#[derive(Clone, Debug)]
pub struct Setting {
    /// Owner and wishes of each station.
    pub stations: Vec<(u16, Vec<Wish>)>,
    /// Times that the robot may boot anew.
    pub reboots: u8,
    /// Times that the first station may be started anew, with another owner.
    pub restarts: u8,
    /// Times that the first station's operator may say STOP.
    pub stops: u8,
    /// Frames and lines that the network holds, each way; what comes later is lost.
    pub held: usize,
    /// Whether stations know each other's sessions from their own.
    pub owners_differ: bool,
}

/// A frame on its way.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Frame {
    bytes: Vec<u8>,
    /// The session that its sender took for its own.
    epoch: Option<Epoch>,
    /// Sent before STOP was said.
    before_stop: bool,
}

/// A line on its way.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Said {
    received: Received,
    boots: u16,
}

impl Hash for Said {
    fn hash<H: Hasher>(&self, hasher: &mut H) {
        self.boots.hash(hasher);
        if let Received::Line(_, bytes) = &self.received {
            bytes.hash(hasher);
        }
    }
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub struct State {
    now_us: u64,
    pub grounds: Vec<Arc<Ground>>,
    pub robot: Arc<Robot>,
    frames: Vec<Arc<Frame>>,
    lines: Vec<Arc<Said>>,
    reboots: u8,
    restarts: u8,
    stops: u8,
    stop_said: bool,
    pub proofs: u8,
    pub list_proofs: u8,
    pub proofs_after_reboot: u8,
    pub stop_proofs: u8,
    pub refused: u8,
    /// Names of the properties that did not hold.
    pub broken: Vec<&'static str>,
}

impl Hash for State {
    fn hash<H: Hasher>(&self, hasher: &mut H) {
        for ground in &self.grounds {
            ground.hash_at(self.now_us, hasher);
        }
        self.robot.hash(hasher);
        self.frames.hash(hasher);
        self.lines.hash(hasher);
        [self.reboots, self.restarts, self.stops].hash(hasher);
        self.stop_said.hash(hasher);
        self.broken.hash(hasher);
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// A station's operator begins what is wished next.
    Begin(usize),
    /// A station says its next frame.
    Transmit(usize),
    /// The robot hears a frame.
    Hear(usize),
    /// A station hears a line: station, line.
    Receive(usize, usize),
    /// Time passes, until timers of this kind have run out.
    Wait(usize),
    /// The first station's operator says STOP.
    Stop,
    Reboot,
    /// The first station is started anew.
    Restart,
}

pub const ONCE: &str = "each command executes at most once";
pub const EPOCH: &str = "nothing of a stale epoch executes";
pub const WHOLE: &str = "the active list is one that was sent, whole";
pub const PROOF: &str = "what is claimed as done was done in the same life";
pub const REFUSAL: &str = "what is claimed as refused was not done";
pub const AFTER_STOP: &str = "nothing sent before a STOP executes after it";
pub const STOP_PROOF: &str = "a proven STOP was heard";
pub const ENDS: &str = "a good channel ends every task and delivers the next";

impl Model for Setting {
    type State = State;
    type Action = Step;

    fn init_states(&self) -> Vec<State> {
        let stations = self.stations.iter().enumerate();
        let mut state = State {
            now_us: EPOCH_US,
            grounds: stations
                .map(|(n, (owner, wishes))| Arc::new(Ground::new(n, *owner, wishes)))
                .collect(),
            robot: Arc::new(Robot::new()),
            frames: Vec::new(),
            lines: Vec::new(),
            reboots: self.reboots,
            restarts: self.restarts,
            stops: self.stops,
            stop_said: false,
            proofs: 0,
            list_proofs: 0,
            proofs_after_reboot: 0,
            stop_proofs: 0,
            refused: 0,
            broken: Vec::new(),
        };
        state.speak(self.held);
        vec![state]
    }

    fn actions(&self, state: &State, steps: &mut Vec<Step>) {
        for (n, ground) in state.grounds.iter().enumerate() {
            if ground.can_begin() {
                steps.push(Step::Begin(n));
            }
            steps.push(Step::Transmit(n));
            steps.extend((0..state.lines.len()).map(|line| Step::Receive(n, line)));
        }
        steps.extend((0..state.frames.len()).map(Step::Hear));
        steps.extend((0..WAITS_US.len()).map(Step::Wait));
        if state.stops > 0 {
            steps.push(Step::Stop);
        }
        if state.reboots > 0 {
            steps.push(Step::Reboot);
        }
        if state.restarts > 0 {
            steps.push(Step::Restart);
        }
    }

    fn next_state(&self, state: &State, step: Step) -> Option<State> {
        let mut next = state.clone();
        match step {
            Step::Begin(n) => Arc::make_mut(&mut next.grounds[n]).begin(next.now_us),
            Step::Transmit(n) => next.transmit(n, self.held)?,
            Step::Hear(n) => {
                let frame = Arc::clone(&next.frames[n]);
                next.hear(&frame);
                if next.robot == state.robot {
                    return None;
                }
                next.speak(self.held);
            }
            Step::Receive(n, line) => {
                let line = Arc::clone(&next.lines[line]);
                next.receive(n, &line, self.owners_differ);
            }
            Step::Wait(kind) => next.wait(WAITS_US[kind]),
            Step::Stop => {
                next.stops -= 1;
                next.stop_said = true;
                for frame in &mut next.frames {
                    Arc::make_mut(frame).before_stop = true;
                }
                Arc::make_mut(&mut next.grounds[0]).fop.stop(next.now_us);
            }
            Step::Reboot => {
                next.reboots -= 1;
                Arc::make_mut(&mut next.robot).reboot();
                next.speak(self.held);
            }
            Step::Restart => {
                next.restarts -= 1;
                let owner = self.stations[0].0 + 100 + u16::from(next.restarts);
                Arc::make_mut(&mut next.grounds[0]).restart(owner);
            }
        }
        next.drain();
        Some(next)
    }

    fn properties(&self) -> Vec<Property<Self>> {
        let mut properties = vec![
            Property::always(WHOLE, |_, state| state.holds_a_list_that_was_sent()),
            Property::sometimes("something is proven", |_, state| state.proofs > 0),
        ];
        if self.owners_differ {
            properties.extend([
                Property::always(ONCE, |_, state: &State| !state.broken.contains(&ONCE)),
                Property::always(EPOCH, |_, state: &State| !state.broken.contains(&EPOCH)),
                Property::always(PROOF, |_, state: &State| !state.broken.contains(&PROOF)),
                Property::always(REFUSAL, |_, state: &State| !state.broken.contains(&REFUSAL)),
            ]);
        }
        if self.stops > 0 {
            properties.extend([
                Property::always(AFTER_STOP, |_, s: &State| !s.broken.contains(&AFTER_STOP)),
                Property::always(STOP_PROOF, |_, s: &State| !s.broken.contains(&STOP_PROOF)),
                Property::sometimes("STOP is proven", |_, s| s.stop_proofs > 0),
            ]);
        }
        if self.reboots > 0 {
            properties.push(Property::sometimes(
                "something is proven after a reboot",
                |_, state| state.proofs_after_reboot > 0,
            ));
        }
        let wishes = self.stations.iter().flat_map(|(_, wishes)| wishes);
        if wishes.clone().any(|wish| matches!(wish, Wish::List(_))) {
            properties.push(Property::sometimes("a list is proven", |_, state| {
                state.list_proofs > 0
            }));
        }
        properties
    }
}

impl State {
    fn speak(&mut self, held: usize) {
        let said = Said {
            received: self.robot.say(),
            boots: self.robot.boots,
        };
        if self.lines.len() < held && !self.lines.iter().any(|line| **line == said) {
            self.lines.push(Arc::new(said));
        }
    }

    fn transmit(&mut self, n: usize, held: usize) -> Option<()> {
        let ground = Arc::make_mut(&mut self.grounds[n]);
        let (bytes, off_us) = ground.transmit(self.now_us)?;
        let frame = Frame {
            bytes,
            epoch: ground.epoch,
            before_stop: false,
        };
        let known = self
            .frames
            .iter()
            .any(|f| (&f.bytes, f.epoch) == (&frame.bytes, frame.epoch));
        // A lone line feed asks for acknowledgement lines, and here they come anyway.
        if !known && frame.bytes != b"\n" && self.frames.len() < held {
            self.frames.push(Arc::new(frame));
        }
        self.wait(off_us - self.now_us);
        Some(())
    }

    fn wait(&mut self, duration_us: u64) {
        self.now_us += duration_us;
        for ground in &mut self.grounds {
            Arc::make_mut(ground).fop.handle_timeout(self.now_us);
        }
    }

    fn hear(&mut self, frame: &Frame) {
        let stopped = self.robot.stopped;
        let robot = Arc::make_mut(&mut self.robot);
        let Some(task) = robot.hear(&frame.bytes) else {
            return;
        };
        let epoch = robot.epoch();
        if robot.deeds.iter().filter(|deed| deed.task == task).count() > 1 {
            self.broken.push(ONCE);
        }
        if frame.epoch != Some(epoch) {
            self.broken.push(EPOCH);
        }
        if stopped && frame.before_stop {
            self.broken.push(AFTER_STOP);
        }
    }

    fn receive(&mut self, n: usize, line: &Said, owners_differ: bool) {
        let ground = Arc::make_mut(&mut self.grounds[n]);
        ground.fop.handle_received(self.now_us, &line.received);
        while let Some(event) = ground.next_event() {
            match event {
                FopEvent::Session(Ok(())) => {
                    ground.epoch = Some(Epoch {
                        boots: line.boots,
                        session: line.received.ack().session,
                    });
                }
                FopEvent::Concluded { outcome, digest } => {
                    let task = ground.task.take();
                    let deeds = &self.robot.deeds;
                    let deed = deeds.iter().find(|deed| Some(deed.task) == task);
                    if outcome != Outcome::Done {
                        self.refused += 1;
                        if deed.is_some() {
                            self.broken.push(REFUSAL);
                        }
                        continue;
                    }
                    self.proofs += 1;
                    self.proofs_after_reboot += u8::from(line.boots > 1);
                    let same = ground.epoch == Some(self.robot.epoch());
                    let active = self.robot.farm.lists().active();
                    let lost = same && digest.is_some_and(|digest| digest != digest_of(active));
                    if deed.map(|deed| deed.epoch) != ground.epoch || lost && owners_differ {
                        self.broken.push(PROOF);
                    }
                    self.list_proofs += u8::from(digest.is_some());
                }
                FopEvent::StopProven => {
                    self.stop_proofs += 1;
                    if !self.robot.stopped {
                        self.broken.push(STOP_PROOF);
                    }
                }
                _ => {}
            }
        }
    }

    /// Events of timers and operators prove nothing; an end of a task is noted.
    fn drain(&mut self) {
        for ground in &mut self.grounds {
            let ground = Arc::make_mut(ground);
            while let Some(event) = ground.next_event() {
                let proves = matches!(event, FopEvent::Concluded { .. } | FopEvent::StopProven);
                assert!(!proves, "{event:?} though no line arrived");
            }
        }
    }

    fn holds_a_list_that_was_sent(&self) -> bool {
        let active = self.robot.farm.lists().active();
        active.is_empty() || self.grounds.iter().any(|ground| ground.sent_list(active))
    }
}
