//! The real station against the real robot program in the simulated world, in one process and in
//! virtual time.
#![allow(dead_code, reason = "each test file uses its own part")]

#[cfg(unix)]
pub mod c_robot;

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;
use std::time::Duration;

use groundwave::event::{CommandId, CommandStatus, Event};
use groundwave::request::Request;
use groundwave::station::Station;
use groundwave_protocol::arq::Config;
use groundwave_protocol::decoder::{Decoder, Received};
use groundwave_protocol::status_codes::{LayerMask, Mode};
use groundwave_protocol::telemetry::{Body, Line};
use groundwave_protocol::{LINE_BYTES, Waypoint};
use sr04_sim::{ChannelSpec, Simulation, SimulationConfig, World};

/// A change of the C library's source: a text that occurs once, and its replacement.
pub type Patch = (&'static str, &'static str);

/// The seeds of a property: `few` seeds from 0 on. With `GROUNDWAVE_SEEDS=FIRST`, as set by `cargo xtask nightly`, 25
/// times as many from `FIRST` on.
pub fn seeds(few: u64) -> Range<u64> {
    match std::env::var("GROUNDWAVE_SEEDS").map(|first| first.parse::<u64>()) {
        Ok(Ok(first)) => first..first + 25 * few,
        Ok(Err(error)) => panic!("GROUNDWAVE_SEEDS is not a number: {error}"),
        Err(_) => 0..few,
    }
}

/// Whether `cargo xtask nightly` runs the tests; it tests all cases of which other runs test a sample.
pub fn is_nightly() -> bool {
    std::env::var_os("GROUNDWAVE_SEEDS").is_some()
}

/// Lets a simulated robot do what it does by itself for a time; passes on each intact line.
pub fn lines(
    config: &SimulationConfig,
    duration: Duration,
    mut take: impl FnMut(Duration, Line, [u8; LINE_BYTES]),
) {
    let (mut simulation, mut decoder) = (Simulation::new(config), Decoder::default());
    for ms in 0..duration.as_millis() as u64 {
        simulation.step();
        while let Some(byte) = simulation.poll_downlink() {
            for received in decoder.lines(&[byte]) {
                if let Received::Line(line, raw) = received {
                    take(Duration::from_millis(ms), line, raw);
                }
            }
        }
    }
}

/// Runs `run` for each seed on all cores; returns the results in order.
pub fn on_all_cores<T: Send>(seeds: Range<u64>, run: impl Fn(u64) -> T + Sync) -> Vec<(u64, T)> {
    let next = AtomicU64::new(seeds.start);
    let results = Mutex::new(Vec::new());
    thread::scope(|scope| {
        for _ in 0..thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(|| {
                // Tests in real time run beside these. On Linux, this concerns only the thread and its programs.
                #[cfg(target_os = "linux")]
                rustix::process::nice(10).expect("a lower priority");
                loop {
                    let seed = next.fetch_add(1, Ordering::Relaxed);
                    if seed >= seeds.end {
                        break;
                    }
                    let result = run(seed);
                    results
                        .lock()
                        .expect("no other seed has failed")
                        .push((seed, result));
                }
            });
        }
    });
    let mut results = results.into_inner().expect("no seed has failed");
    results.sort_by_key(|(seed, _)| *seed);
    results
}

/// A station's number as owner, from a seed.
pub const fn owner(seed: u64) -> u16 {
    (seed % 1023) as u16 + 1
}

/// A random generator with the same numbers on every platform: `SplitMix64` by Steele, Lea and Flood.
pub struct Rng(pub u64);

impl Rng {
    /// A number from 0 to `end` - 1.
    pub fn below(&mut self, end: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        (z ^ (z >> 31)) % end
    }
}

/// A robot behind its radio, in virtual time.
pub trait Robot: Sized {
    /// Whether it is a process in lockstep, which takes longer.
    const IS_IN_C: bool;

    /// A robot that has just booted.
    fn start(config: &SimulationConfig) -> Self;
    fn now_ms(&self) -> u64;
    /// Advances by a millisecond.
    fn step(&mut self);
    /// Queues bytes of the station.
    fn handle_uplink(&mut self, bytes: &[u8]);
    /// The next byte that the station has received.
    fn poll_downlink(&mut self) -> Option<u8>;
    /// Bytes of the station that the robot has not received yet.
    fn uplink_pending(&self) -> usize;
    fn set_channel(&mut self, channel: &ChannelSpec);
    fn reboot(&mut self);
    fn mode(&self) -> Mode;
    fn active_digest(&self) -> u32;
    fn active_list(&mut self) -> Vec<Waypoint>;
    fn position_in(&self) -> (i32, i32);
    /// Since the robot's boot, modulo 100.
    fn odometer_resets(&self) -> usize;
}

impl Robot for Simulation {
    const IS_IN_C: bool = false;

    fn start(config: &SimulationConfig) -> Self {
        Self::new(config)
    }

    fn now_ms(&self) -> u64 {
        self.now_ms()
    }

    fn step(&mut self) {
        self.step();
    }

    fn handle_uplink(&mut self, bytes: &[u8]) {
        self.handle_uplink(bytes);
    }

    fn poll_downlink(&mut self) -> Option<u8> {
        self.poll_downlink()
    }

    fn uplink_pending(&self) -> usize {
        self.uplink_pending()
    }

    fn set_channel(&mut self, channel: &ChannelSpec) {
        self.set_channel(channel);
    }

    fn reboot(&mut self) {
        self.reboot();
    }

    fn mode(&self) -> Mode {
        self.robot().mode()
    }

    fn active_digest(&self) -> u32 {
        self.robot().lists().active_digest()
    }

    fn active_list(&mut self) -> Vec<Waypoint> {
        self.robot().lists().active().to_vec()
    }

    fn position_in(&self) -> (i32, i32) {
        let pose = self.robot().pose();
        (pose.x_tenths_in() / 10, pose.y_tenths_in() / 10)
    }

    /// From the next line B of a copy of the robot.
    fn odometer_resets(&self) -> usize {
        let mut twin = self.robot().clone();
        let mut decoder = Decoder::default();
        for _ in 0..200 * LINE_BYTES {
            let Some(byte) = twin.poll_downlink() else {
                continue;
            };
            if let Some(Received::Line(line, _)) = decoder.lines(&[byte]).next()
                && let Body::Status(status) = line.body
            {
                return usize::from(status.odometer_resets);
            }
        }
        panic!("the robot sends no line B");
    }
}

/// A world, a robot, a radio and a station.
pub struct CoSimulation<R = Simulation> {
    pub simulation: R,
    pub station: Station,
    pub events: Vec<(Duration, Event)>,
    /// All bytes that the station has sent.
    pub sent: Vec<u8>,
    /// Modes reported by line A, in order, without repetitions.
    pub modes: Vec<Mode>,
    /// The latest mask of allowed layers in line B.
    pub allowed: Option<LayerMask>,
    /// The latest line B: waypoints driven, waypoints in the list, digest.
    pub list: Option<(u16, u16, u32)>,
    /// Whether a claim must be true of the robot at the moment of the claim. With delays it need not be, because the
    /// robot may restart before the confirmation arrives.
    pub claims_hold: bool,
    /// The last status of each command that has ended.
    fates: BTreeMap<CommandId, CommandStatus>,
    channel: ChannelSpec,
    context: String,
}

impl CoSimulation {
    /// A co-simulation; `channel` has the form of the command line.
    pub fn new(world: &str, seed: u64, channel: &str) -> Self {
        let world = World::built_in(world).expect("a world that comes with the program");
        let mut config = SimulationConfig::new(world, seed);
        config.channel = channel.parse::<ChannelSpec>().expect("a channel");
        Self::with(&config, Config::new(owner(seed)))
    }
}

impl<R: Robot> CoSimulation<R> {
    /// Joins a robot and a station.
    pub fn with(config: &SimulationConfig, station: Config) -> Self {
        Self::of(R::start(config), config, station)
    }

    /// Joins a robot that has been started with this configuration and a station.
    pub fn of(simulation: R, config: &SimulationConfig, station: Config) -> Self {
        Self {
            simulation,
            station: Station::new(station, true),
            events: Vec::new(),
            sent: Vec::new(),
            modes: Vec::new(),
            allowed: None,
            list: None,
            fates: BTreeMap::new(),
            channel: config.channel.clone(),
            claims_hold: config.channel.delay_ms == 0,
            context: format!(
                "{}, seed {}, channel `{}`",
                if R::IS_IN_C {
                    "robot in C".to_owned()
                } else {
                    format!("world {}", config.world.name())
                },
                config.seed,
                config.channel
            ),
        }
    }

    /// Seed and channel, printed with a failure.
    pub fn context(&self) -> String {
        format!("{}, at {:.3} s", self.context, self.now().as_secs_f64())
    }

    /// The channel at the start.
    pub const fn channel(&self) -> &ChannelSpec {
        &self.channel
    }

    pub fn now(&self) -> Duration {
        Duration::from_millis(self.simulation.now_ms())
    }

    /// Advances by a millisecond.
    pub fn step(&mut self) {
        self.step_telling(&mut |_| ());
    }

    /// Advances by a millisecond and passes on each byte from the robot.
    pub fn step_telling(&mut self, heard: &mut impl FnMut(u8)) {
        self.simulation.step();
        let now = self.now();
        while let Some(byte) = self.simulation.poll_downlink() {
            heard(byte);
            self.station.handle_bytes(now, &[byte]);
        }
        if self.station.poll_timeout().is_some_and(|at| at <= now) {
            self.station.handle_timeout(now);
        }
        while let Some(bytes) = self.station.poll_transmit(now) {
            self.simulation.handle_uplink(&bytes);
            self.sent.extend(bytes);
        }
        while let Some(event) = self.station.poll_event() {
            self.take_event(now, event);
        }
    }

    /// Takes an event of the station.
    pub fn take_event(&mut self, at: Duration, event: Event) {
        self.note(&event);
        self.events.push((at, event));
    }

    fn note(&mut self, event: &Event) {
        if let Event::Command { id, status } = event
            && status.is_end()
        {
            self.fates.insert(*id, *status);
        }
        match event {
            Event::Line { line, .. } => match &line.body {
                Body::State(state) if self.modes.last() != Some(&state.mode) => {
                    self.modes.push(state.mode);
                }
                Body::Status(status) => {
                    self.allowed = Some(status.allowed);
                    self.list = Some((status.list.driven, status.list.count, status.digest));
                }
                _ => {}
            },
            // A claim of the ledger must be true of the robot at this moment.
            Event::Command {
                status:
                    CommandStatus::Confirmed {
                        digest: Some(digest),
                    },
                ..
            } if self.claims_hold => {
                let held = self.simulation.active_digest();
                assert_eq!(held, *digest, "claimed and held differ: {}", self.context());
            }
            _ => {}
        }
    }

    pub fn run(&mut self, seconds: u64) {
        for _ in 0..seconds * 1000 {
            self.step();
        }
    }

    /// Runs until a condition holds; fails after `limit_s` virtual seconds.
    pub fn run_until(&mut self, what: &str, limit_s: u64, mut done: impl FnMut(&Self) -> bool) {
        for _ in 0..limit_s * 1000 {
            if done(self) {
                return;
            }
            self.step();
        }
        panic!("not within {limit_s} s: {what}; {}", self.context());
    }

    pub fn request(&mut self, request: Request) -> CommandId {
        let now = self.now();
        self.station.handle_request(now, request, None)
    }

    /// Delivers a request; returns its last status.
    pub fn deliver(&mut self, request: Request) -> CommandStatus {
        let what = format!("`{request}` ends");
        let id = self.request(request);
        let mut end = None;
        self.run_until(&what, 120, |co| {
            end = co.fate(id);
            end.is_some()
        });
        end.expect("run_until has seen it")
    }

    /// The last status of a command that has ended.
    pub fn fate(&self, id: CommandId) -> Option<CommandStatus> {
        self.fates.get(&id).copied()
    }
}
