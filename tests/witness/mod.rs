//! A robot and a station, both checked every millisecond: the robot executes every command once and in order, and every
//! claim of the station is true.

use std::time::Duration;

use groundwave::event::{CommandId, CommandStatus, Event};
use groundwave::request::Request;
use groundwave::station::Station;
use groundwave_protocol::Waypoint;
use groundwave_protocol::arq::{self, Config};
use groundwave_protocol::digest::digest;
use sr04_firmware::board::Duplex;
use sr04_sim::{ChannelSpec, Simulation, SimulationConfig, World};

use crate::common::{CoSimulation, Robot, owner};

/// Time without progress after which a task fails, seconds; a task that cannot start fails after a minute.
const GIVE_UP_S: u64 = 15;
const START_S: u64 = 60;

/// Maximum plausible step of the robot within a tick, inches.
const JUMP_IN: i32 = 20;

/// A command whose execution is visible on the robot.
#[derive(Clone, Debug, PartialEq)]
pub enum Deed {
    /// Replaces the active list; not empty.
    List(Vec<Waypoint>),
    /// Sets the robot's pose.
    Pose(Waypoint),
}

impl Deed {
    fn request(&self) -> Request {
        match self {
            Self::List(waypoints) => Request::Route(waypoints.clone()),
            Self::Pose(position) => Request::Pose {
                position: *position,
                theta_deg: 0,
            },
        }
    }

    /// Time within which the command must end, confirmed or not: fifteen seconds each for the session, for each block
    /// of four waypoints, for the command, and for a list that must be staged again.
    pub fn limit(&self) -> Duration {
        let blocks = match self {
            Self::List(waypoints) => waypoints.len().div_ceil(4) as u64,
            Self::Pose(_) => 0,
        };
        Duration::from_secs(START_S + GIVE_UP_S * (3 + blocks))
    }
}

#[derive(Debug)]
struct Issued {
    deed: Deed,
    at: Duration,
    /// Number of the command; `None` after its station has restarted.
    id: Option<CommandId>,
    end: Option<CommandStatus>,
}

/// Robot and station, and the observations so far.
pub struct Trial<R = Simulation> {
    pub co: CoSimulation<R>,
    issued: Vec<Issued>,
    /// Numbers of the executed commands, in order.
    executed: Vec<usize>,
    /// Number of poses executed since the robot's latest boot.
    poses_executed: usize,
    list: Vec<Waypoint>,
    digest: u32,
    pose_in: (i32, i32),
    stops: Vec<(CommandId, Option<CommandStatus>)>,
    /// Ends of frames and lines on the wire, milliseconds.
    pub boundaries_ms: Vec<u64>,
    /// Number of bytes of the station that have left the wire.
    bytes_gone: usize,
    rng: u64,
}

impl<R: Robot> Trial<R> {
    pub fn new(seed: u64, channel: &str) -> Self {
        Self::of(
            CoSimulation::with(&config(seed, channel), Config::new(owner(seed))),
            seed,
        )
    }

    /// A trial on a half-duplex radio known to both ends; the robot waits `patience` byte times for the ground's first
    /// byte.
    pub fn taking_turns(seed: u64, channel: &str, patience_bytes: u8, latency_ms: u64) -> Self {
        let robot = Duplex::Half { patience_bytes };
        Self::with(seed, channel, robot, arq::Duplex::Half, latency_ms)
    }

    /// A trial with a configured duplex for each end.
    pub fn with(
        seed: u64,
        channel: &str,
        robot: Duplex,
        station: arq::Duplex,
        latency_ms: u64,
    ) -> Self {
        let mut config = config(seed, channel);
        config.duplex = robot;
        let station = Config {
            duplex: station,
            latency_us: latency_ms * 1000,
            ..Config::new(owner(seed))
        };
        Self::of(CoSimulation::with(&config, station), seed)
    }

    pub fn of(co: CoSimulation<R>, seed: u64) -> Self {
        Self {
            pose_in: co.simulation.position_in(),
            co,
            issued: Vec::new(),
            executed: Vec::new(),
            poses_executed: 0,
            list: Vec::new(),
            digest: digest([].iter()),
            stops: Vec::new(),
            boundaries_ms: Vec::new(),
            bytes_gone: 0,
            rng: seed,
        }
    }

    /// A uniform random number from 0 to `below` - 1.
    pub fn below(&mut self, below: u64) -> u64 {
        self.rng = self.rng.wrapping_mul(6_364_136_223_846_793_005);
        self.rng = self.rng.wrapping_add(1_442_695_040_888_963_407);
        (self.rng >> 33) % below
    }

    /// A list that differs from all others.
    pub fn some_list(&mut self, count: usize) -> Deed {
        let mut part = || self.below(19_999) as i16 - 9999;
        let point = |_| Waypoint {
            x_in: part(),
            y_in: part(),
        };
        Deed::List((0..count).map(point).collect())
    }

    /// A pose far from that of any other command.
    pub fn some_pose(&mut self) -> Deed {
        let number = self.issued.len() as i16;
        Deed::Pose(Waypoint {
            x_in: (number * 37 % 60) * 300 - 9000,
            y_in: if number % 2 == 0 { 9000 } else { -9000 },
        })
    }

    /// A random list or pose.
    pub fn some_deed(&mut self) -> Deed {
        if self.below(2) == 0 {
            return self.some_pose();
        }
        let count = 1 + self.below(40) as usize;
        self.some_list(count)
    }

    /// Sends a command; returns its number for [`Trial::end`].
    pub fn order(&mut self, deed: Deed) -> usize {
        let id = self.co.request(deed.request());
        self.issued.push(Issued {
            deed,
            at: self.co.now(),
            id: Some(id),
            end: None,
        });
        self.take_events();
        self.issued.len() - 1
    }

    /// The last status of a command that has ended.
    pub fn end(&self, number: usize) -> Option<&CommandStatus> {
        self.issued[number].end.as_ref()
    }

    pub fn is_confirmed(&self, number: usize) -> bool {
        matches!(self.end(number), Some(CommandStatus::Confirmed { .. }))
    }

    pub fn is_executed(&self, number: usize) -> bool {
        self.executed.contains(&number)
    }

    /// Presses STOP.
    pub fn stop(&mut self) -> CommandId {
        let id = self.co.request(Request::Stop);
        self.stops.push((id, None));
        self.take_events();
        id
    }

    /// The last status of the latest STOP, if it has ended.
    pub fn stopped(&self) -> Option<&CommandStatus> {
        self.stops.last().and_then(|(_, end)| end.as_ref())
    }

    /// Reboots the robot: its list is lost, executed commands stay executed.
    pub fn reboot_robot(&mut self) {
        self.co.simulation.reboot();
        self.list.clear();
        self.digest = digest([].iter());
        self.poses_executed = 0;
        self.pose_in = self.co.simulation.position_in();
    }

    /// Replaces the station by a new one. Bytes already handed to the operating system are still sent.
    pub fn restart_station(&mut self, seed: u64) {
        self.co.station = Station::new(Config::new(owner(seed)), true);
        for issued in &mut self.issued {
            issued.id = None;
        }
        self.stops.clear();
    }

    /// Advances by a millisecond and checks both ends.
    pub fn step(&mut self) {
        self.co.step();
        self.note_boundary();
        self.look();
        self.take_events();
        let now = self.co.now();
        for issued in &self.issued {
            let is_late = now > issued.at + issued.deed.limit();
            assert!(
                issued.end.is_some() || issued.id.is_none() || !is_late,
                "has not ended: {issued:?}; {}",
                self.co.context()
            );
        }
    }

    /// Notes when the end of a frame has left the wire; doubled bytes count as pending.
    fn note_boundary(&mut self) {
        let pending = self.co.simulation.uplink_pending();
        let gone = self.co.sent.len().saturating_sub(pending);
        let now_gone = self.co.sent.get(self.bytes_gone..gone).unwrap_or_default();
        if now_gone.contains(&b'\n') {
            self.boundaries_ms.push(self.co.simulation.now_ms());
        }
        self.bytes_gone = self.bytes_gone.max(gone);
    }

    /// Runs for `time_ms` milliseconds.
    pub fn run_ms(&mut self, time_ms: u64) {
        for _ in 0..time_ms {
            self.step();
        }
    }

    /// Runs until a command has ended.
    pub fn run_to_end(&mut self, number: usize) {
        while self.end(number).is_none() {
            self.step();
        }
    }

    /// Checks that commands work again on a clean channel, and that the counts agree.
    pub fn finish(&mut self) {
        let spec = self.co.channel().clone();
        self.co.simulation.set_channel(&ChannelSpec {
            half_duplex: spec.half_duplex,
            modem: spec.modem,
            ..ChannelSpec::default()
        });
        for number in 0..self.issued.len() {
            if self.issued[number].id.is_some() {
                self.run_to_end(number);
            }
        }
        if !self.co.claims_hold {
            // Bytes delayed by up to two seconds must have arrived.
            self.run_ms(4500);
        }
        for deed in [self.some_pose(), self.some_list(9)] {
            let number = self.order(deed);
            self.run_to_end(number);
            let end = self.end(number);
            assert!(self.is_confirmed(number), "{end:?}: {}", self.co.context());
        }
        assert_eq!(
            self.co.simulation.odometer_resets(),
            self.poses_executed % 100,
            "an order was executed without being seen: {}",
            self.co.context()
        );
    }

    /// Compares the robot with its state one millisecond earlier.
    fn look(&mut self) {
        let now_ms = self.co.simulation.now_ms();
        let held = self.co.simulation.active_digest();
        if held != self.digest {
            let list = self.co.simulation.active_list();
            let number = self
                .issued
                .iter()
                .position(|i| i.deed == Deed::List(list.clone()));
            let number = number.unwrap_or_else(|| {
                panic!(
                    "a list that nobody ordered: {list:?}; {}",
                    self.co.context()
                )
            });
            self.execute(number);
            self.list = list;
            self.digest = digest(self.list.iter());
            assert_eq!(held, self.digest, "{}", self.co.context());
        } else if now_ms.is_multiple_of(if R::IS_IN_C { 160 } else { 16 }) {
            let list = self.co.simulation.active_list();
            assert_eq!(list, self.list, "{}", self.co.context());
        }
        let before = self.pose_in;
        self.pose_in = self.co.simulation.position_in();
        if distance_in(before, self.pose_in) > JUMP_IN {
            let number = self.issued.iter().position(|issued| match &issued.deed {
                Deed::Pose(at) => {
                    distance_in((i32::from(at.x_in), i32::from(at.y_in)), self.pose_in) < 5
                }
                Deed::List(_) => false,
            });
            let number = number.unwrap_or_else(|| {
                panic!(
                    "a pose that nobody ordered: {:?}; {}",
                    self.pose_in,
                    self.co.context()
                )
            });
            self.poses_executed += 1;
            self.execute(number);
        }
    }

    fn execute(&mut self, number: usize) {
        // Commands are executed in order: a smaller number is stale, an equal one is a repetition.
        assert!(
            self.executed.last().is_none_or(|latest| *latest < number),
            "order {number} was executed after {:?}: {}",
            self.executed,
            self.co.context()
        );
        self.executed.push(number);
    }

    fn take_events(&mut self) {
        for (at, event) in std::mem::take(&mut self.co.events) {
            if matches!(event, Event::Line { .. } | Event::Ack(_)) {
                self.boundaries_ms.push(at.as_millis() as u64);
            }
            let Event::Command { id, status } = event else {
                continue;
            };
            if !status.is_end() {
                continue;
            }
            if let Some((_, end)) = self.stops.iter_mut().find(|(stop, _)| *stop == id) {
                *end = Some(status);
            } else if let Some(number) = self.issued.iter().position(|i| i.id == Some(id)) {
                assert!(
                    !matches!(status, CommandStatus::Confirmed { .. })
                        || self.executed.contains(&number),
                    "claimed and not executed: {:?}; {}",
                    self.issued[number],
                    self.co.context()
                );
                let end = self.issued[number].end.replace(status);
                assert_eq!(end, None, "ended twice: {}", self.co.context());
            }
        }
    }
}

fn distance_in(a: (i32, i32), b: (i32, i32)) -> i32 {
    (a.0 - b.0).abs().max((a.1 - b.1).abs())
}

fn config(seed: u64, channel: &str) -> SimulationConfig {
    let world = World::built_in("open-room").expect("it comes with the program");
    let mut config = SimulationConfig::new(world, seed);
    config.channel = channel.parse().expect("a channel");
    config
}
