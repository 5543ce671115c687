//! The model of the search: all steps of stations, network and robot.
//!
//! The network keeps all frames and lines sent and may deliver any of them at any time, to any station,
//! in any order, repeatedly or never: loss, duplication, reordering and delay. The network may delay a frame
//! forever, and a line until a timer for silence runs out.

use groundwave_protocol::arq::{CommandStatus, FopEvent};
use groundwave_protocol::decoder::Received;
use stateright::{Model, Property};
use std::hash::{Hash, Hasher};
use std::sync::Arc;

use super::ground::{Ground, Request, WAITS_US, digest_of};
use super::instants::{EPOCH_US, Quick};
use super::robot::{Epoch, Robot};

/// The setting of a search and its limits.
#[derive(Clone, Debug)]
pub struct Setting {
    /// Owner and tasks of each station.
    pub stations: Vec<(u16, Vec<Request>)>,
    /// Maximum number of reboots of the robot.
    pub reboots: u8,
    /// Maximum number of restarts of the first station, each with another owner.
    pub restarts: u8,
    /// Maximum number of requests for STOP by the stations' operators.
    pub stops: u8,
    /// Maximum number of frames and of lines that the network keeps; the oldest are lost.
    pub held: (usize, usize),
    /// Maximum number of sessions in a life. They are numbered modulo 7, and no radio delays a frame until its session's number
    /// repeats.
    pub sessions: u8,
    /// Maximum number of commands in a session.
    pub commands: u8,
    /// Whether the stations have different owners.
    pub owners_differ: bool,
}

/// A frame in the network.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Frame {
    bytes: Vec<u8>,
    /// The session that the sender took for its own.
    epoch: Option<Epoch>,
    /// Number of STOPs that the robot had taken when the frame was sent.
    stops: u8,
}

/// A line in the network.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Said {
    received: Received,
    /// The line of the same time that shows the era.
    era: Received,
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
    /// Names of the properties that the latest step broke or showed.
    pub happened: Vec<&'static str>,
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
        self.happened.hash(hasher);
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// A station begins its next task.
    Begin(usize),
    /// A station sends its next frame.
    Transmit(usize),
    /// The robot receives a frame.
    Hear(usize),
    /// A station receives a line: station, line.
    Receive(usize, usize),
    /// A station receives a line that shows the era.
    ReceiveEra(usize, usize),
    /// Time passes until timers of this kind have run out.
    Wait(usize),
    /// A station's operator stops the robot.
    Stop(usize),
    Reboot,
    /// The first station restarts.
    Restart,
}

pub const ONCE: &str = "each command executes at most once";
pub const EPOCH: &str = "nothing of a stale epoch executes";
pub const WHOLE: &str = "the active list is one that was sent, whole";
pub const SAME_LIFE: &str = "a command reported as done was done in the same life";
pub const REFUSAL: &str = "a command reported as refused was not done";
pub const AFTER_STOP: &str = "nothing sent before a STOP executes after it";
pub const STOP_AFTER_REQUEST: &str = "a confirmed STOP was taken after its request";
pub const ENDS: &str = "a channel that works again ends every task";

/// One in this number of states is continued over a good channel.
const CONTINUED_ONE_IN: u64 = 64;

/// Number of rounds of a good channel within which all tasks must have ended.
const ROUNDS_MAX: usize = 60;

/// Situations that a search must reach to be meaningful.
const CONFIRMED: &str = "something is confirmed";
const CONFIRMED_AFTER_REBOOT: &str = "something is confirmed after a reboot";
const LIST_CONFIRMED: &str = "a list is confirmed";
const STOP_CONFIRMED: &str = "STOP is confirmed";

macro_rules! always {
    ($name:ident) => {
        Property::always($name, |_, state: &State| !state.happened.contains(&$name))
    };
}

macro_rules! sometimes {
    ($name:ident) => {
        Property::sometimes($name, |_, state: &State| state.happened.contains(&$name))
    };
}

impl Model for Setting {
    type State = State;
    type Action = Step;

    fn init_states(&self) -> Vec<State> {
        let stations = self.stations.iter().enumerate();
        let mut state = State {
            now_us: EPOCH_US,
            grounds: stations
                .map(|(n, (owner, requests))| Arc::new(Ground::new(n, *owner, requests)))
                .collect(),
            robot: Arc::new(Robot::new()),
            frames: Vec::new(),
            lines: Vec::new(),
            reboots: self.reboots,
            restarts: self.restarts,
            stops: self.stops,
            happened: Vec::new(),
        };
        state.speak();
        vec![state]
    }

    fn actions(&self, state: &State, steps: &mut Vec<Step>) {
        for (n, ground) in state.grounds.iter().enumerate() {
            if ground.can_begin() {
                steps.push(Step::Begin(n));
            }
            steps.push(Step::Transmit(n));
            if state.stops > 0 {
                steps.push(Step::Stop(n));
            }
            steps.extend((0..state.lines.len()).map(|line| Step::Receive(n, line)));
            if !self.shows_eras() {
                steps.extend((0..state.lines.len()).map(|line| Step::ReceiveEra(n, line)));
            }
        }
        steps.extend((0..state.frames.len()).map(Step::Hear));
        steps.extend((0..WAITS_US.len()).map(Step::Wait));
        if state.reboots > 0 {
            steps.push(Step::Reboot);
        }
        if state.restarts > 0 {
            steps.push(Step::Restart);
        }
    }

    fn next_state(&self, state: &State, step: Step) -> Option<State> {
        let mut next = state.clone();
        next.happened.clear();
        match step {
            Step::Begin(n) => Arc::make_mut(&mut next.grounds[n]).begin(next.now_us),
            Step::Transmit(n) => next.transmit(n, self.held.0)?,
            Step::Hear(n) => {
                let frame = Arc::clone(&next.frames[n]);
                next.hear(&frame);
                if next.robot == state.robot {
                    return None;
                }
                next.speak();
            }
            Step::Receive(n, line) => {
                let line = Arc::clone(&next.lines[line]);
                if self.shows_eras() {
                    next.receive(n, &line, &line.era, self.owners_differ);
                }
                next.receive(n, &line, &line.received, self.owners_differ);
            }
            Step::ReceiveEra(n, line) => {
                let line = Arc::clone(&next.lines[line]);
                next.receive(n, &line, &line.era, self.owners_differ);
            }
            Step::Wait(kind) => {
                if kind > 0 {
                    next.lines.drain(..next.lines.len() - 1);
                }
                next.wait(WAITS_US[kind]);
            }
            Step::Stop(n) => {
                next.stops -= 1;
                let ground = Arc::make_mut(&mut next.grounds[n]);
                ground.stops_before[0] = next.robot.stops;
                ground.fop.stop(next.now_us);
            }
            Step::Reboot => {
                next.reboots -= 1;
                Arc::make_mut(&mut next.robot).reboot();
                next.speak();
            }
            Step::Restart => {
                next.restarts -= 1;
                let owner = self.stations[0].0 + 100 + u16::from(next.restarts);
                Arc::make_mut(&mut next.grounds[0]).restart(owner);
            }
        }
        next.drain();
        let lines = next.lines.len().saturating_sub(self.held.1);
        next.lines.drain(..lines);
        Some(next)
    }

    fn within_boundary(&self, state: &State) -> bool {
        let ack = state.robot.farm.ack();
        ack.session <= self.sessions && ack.sequence <= self.commands
    }

    fn properties(&self) -> Vec<Property<Self>> {
        let mut properties = vec![Property::always(WHOLE, |_, state: &State| {
            state.holds_a_list_that_was_sent()
        })];
        if self
            .stations
            .iter()
            .any(|(_, requests)| !requests.is_empty())
        {
            properties.push(sometimes!(CONFIRMED));
        }
        if self.owners_differ {
            properties.extend([
                always!(ONCE),
                always!(EPOCH),
                always!(SAME_LIFE),
                always!(REFUSAL),
                Property::always(ENDS, |_, state: &State| state.ends_well()),
            ]);
        }
        if self.stops > 0 {
            properties.extend([
                always!(AFTER_STOP),
                always!(STOP_AFTER_REQUEST),
                sometimes!(STOP_CONFIRMED),
            ]);
        }
        if self.reboots > 0 {
            properties.push(sometimes!(CONFIRMED_AFTER_REBOOT));
        }
        let mut requests = self.stations.iter().flat_map(|(_, requests)| requests);
        if requests.any(|request| matches!(request, Request::List(_))) {
            properties.push(sometimes!(LIST_CONFIRMED));
        }
        properties
    }
}

impl Setting {
    /// Whether a station receives the era with every line, because two stations have too many steps otherwise.
    const fn shows_eras(&self) -> bool {
        self.stations.len() > 1
    }
}

impl State {
    /// The robot sends without a pause; equal lines count as one.
    fn speak(&mut self) {
        let boots = self.robot.boots;
        let latest = self.lines.last().filter(|line| line.boots == boots);
        let sequence = latest.map_or(0, |line| line.received.sequence());
        let says = |sequence| Said {
            received: self.robot.say(sequence, self.robot.farm.ack()),
            era: self.robot.say(sequence, self.robot.farm.ack_in(1)),
            boots,
        };
        if latest.is_none_or(|latest| **latest != says(sequence)) {
            let said = says(sequence + u8::from(latest.is_some()));
            self.lines.push(Arc::new(said));
        }
    }

    fn transmit(&mut self, n: usize, held: usize) -> Option<()> {
        let ground = Arc::make_mut(&mut self.grounds[n]);
        let (bytes, off_us) = ground.transmit(self.now_us)?;
        let frame = Frame {
            bytes,
            epoch: ground.epoch,
            stops: self.robot.stops,
        };
        let known = self
            .frames
            .iter()
            .any(|f| (&f.bytes, f.epoch) == (&frame.bytes, frame.epoch));
        // A lone line feed asks for acknowledgement lines, and here they come anyway.
        if !known && frame.bytes != b"\n" {
            self.frames.push(Arc::new(frame));
            self.frames.drain(..self.frames.len().saturating_sub(held));
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
        let robot = Arc::make_mut(&mut self.robot);
        let Some(task) = robot.hear(&frame.bytes) else {
            return;
        };
        let epoch = robot.epoch();
        if robot.deeds.iter().filter(|deed| deed.task == task).count() > 1 {
            self.happened.push(ONCE);
        }
        if frame.epoch != Some(epoch) {
            self.happened.push(EPOCH);
        }
        if self.robot.stops > frame.stops {
            self.happened.push(AFTER_STOP);
        }
    }

    fn receive(&mut self, n: usize, line: &Said, received: &Received, owners_differ: bool) {
        let ground = Arc::make_mut(&mut self.grounds[n]);
        ground.fop.handle_received(self.now_us, received);
        while let Some(event) = ground.next_event() {
            match event {
                FopEvent::Session(Ok(())) => {
                    ground.epoch = Some(Epoch {
                        boots: line.boots,
                        session: line.received.ack().session,
                    });
                }
                FopEvent::Task(
                    status @ (CommandStatus::Confirmed { .. } | CommandStatus::Refused(_)),
                ) => {
                    let task = ground.task.take();
                    let deeds = &self.robot.deeds;
                    let deed = deeds.iter().find(|deed| Some(deed.task) == task);
                    let CommandStatus::Confirmed { digest } = status else {
                        if deed.is_some() {
                            self.happened.push(REFUSAL);
                        }
                        continue;
                    };
                    self.happened.push(CONFIRMED);
                    if line.boots > 1 {
                        self.happened.push(CONFIRMED_AFTER_REBOOT);
                    }
                    if digest.is_some() {
                        self.happened.push(LIST_CONFIRMED);
                    }
                    let same = ground.epoch == Some(self.robot.epoch());
                    let active = self.robot.farm.lists().active();
                    let lost = same && digest.is_some_and(|digest| digest != digest_of(active));
                    if deed.map(|deed| deed.epoch) != ground.epoch || lost && owners_differ {
                        self.happened.push(SAME_LIFE);
                    }
                }
                FopEvent::Stop(CommandStatus::Confirmed { .. }) => {
                    self.happened.push(STOP_CONFIRMED);
                    if self.robot.stops == ground.stops_before[1] {
                        self.happened.push(STOP_AFTER_REQUEST);
                    }
                }
                _ => {}
            }
        }
    }

    /// Handles events of timers and operators, which confirm nothing; notes the end of a task.
    fn drain(&mut self) {
        for ground in &mut self.grounds {
            let ground = Arc::make_mut(ground);
            while let Some(event) = ground.next_event() {
                let confirms = matches!(
                    event,
                    FopEvent::Task(CommandStatus::Confirmed { .. } | CommandStatus::Refused(_))
                        | FopEvent::Stop(CommandStatus::Confirmed { .. })
                );
                assert!(!confirms, "{event:?} though no line arrived");
            }
        }
    }

    fn holds_a_list_that_was_sent(&self) -> bool {
        let active = self.robot.farm.lists().active();
        active.is_empty() || self.grounds.iter().any(|ground| ground.sent_list(active))
    }

    /// Whether all tasks begin and end on a channel that is good from now on; checks a sample of the states.
    fn ends_well(&self) -> bool {
        let mut hasher = Quick::default();
        self.hash(&mut hasher);
        if !hasher.finish().is_multiple_of(CONTINUED_ONE_IN) {
            return true;
        }
        let mut state = self.clone();
        (0..ROUNDS_MAX).any(|_| {
            for n in 0..state.grounds.len() {
                state.talk(n);
            }
            let mut grounds = state.grounds.iter();
            grounds.all(|ground| !ground.fop.is_busy() && !ground.can_begin())
        })
    }

    /// A station sends its frames and receives the robot's lines.
    fn talk(&mut self, n: usize) {
        let ground = Arc::make_mut(&mut self.grounds[n]);
        if ground.can_begin() {
            ground.begin(self.now_us);
        }
        self.frames.clear();
        if self.transmit(n, 1).is_some()
            && let Some(frame) = self.frames.pop()
        {
            Arc::make_mut(&mut self.robot).hear(&frame.bytes);
        }
        self.speak();
        self.wait(WAITS_US[0]);
        if let Some(line) = self.lines.last().cloned() {
            for n in 0..self.grounds.len() {
                self.receive(n, &line, &line.era, true);
                self.receive(n, &line, &line.received, true);
            }
        }
        self.drain();
    }
}
