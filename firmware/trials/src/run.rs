//! A robot in a world under the commands of a trial.

use std::fs::File;
use std::io::BufWriter;

use groundwave_protocol::Waypoint;
use groundwave_protocol::command::{Command, Key, Message, Open, Order, Slots};
use groundwave_protocol::decoder::{Decoder, Received};
use groundwave_protocol::digest::digest;
use groundwave_protocol::status_codes::{Layer, LayerMask, Mode};
use groundwave_protocol::telemetry::{Body, Outcome};
use sr04_firmware::arbiter::Holder;
use sr04_firmware::parameters::Parameter;
use sr04_sim::{Point, Pose, Simulation, SimulationConfig, TICK_MS, Trace, World};

use crate::arena::arena;
use crate::claim::Trial;

/// Robot number in the simulation.
const ROBOT_ID: u8 = 1;

/// Owner of the trial's session.
const OWNER: u16 = 7;

/// Start values of a run.
pub(crate) struct Setup<'a> {
    pub(crate) trial: &'a Trial,
    pub(crate) config: SimulationConfig,
    allowed: Option<LayerMask>,
    mode: Mode,
}

impl<'a> Setup<'a> {
    /// A robot at power-on, which prowls with every allowed layer.
    pub(crate) fn new(trial: &'a Trial, world: World) -> Self {
        Self {
            trial,
            config: SimulationConfig::new(world, trial.seed.value()),
            allowed: None,
            mode: Mode::Prowl,
        }
    }

    /// A robot at a random reachable position of a world.
    pub(crate) fn anywhere(trial: &'a Trial, world: &'static str) -> Self {
        let arena = arena(world);
        let start = arena.somewhere(&mut trial.rng());
        Self::new(trial, arena.started_at(start))
    }

    /// Allows only these layers, and layer 0.
    pub(crate) fn only(mut self, layers: &[Layer]) -> Self {
        let mask = layers
            .iter()
            .fold(LayerMask::NONE.with(Layer::User), |mask, &layer| {
                mask.with(layer)
            });
        self.allowed = Some(mask);
        self
    }

    /// Starts in this mode.
    pub(crate) fn mode(mut self, mode: Mode) -> Self {
        self.mode = mode;
        self
    }

    /// Changes a parameter.
    pub(crate) fn with(mut self, parameter: Parameter, value: i16) -> Self {
        assert!(
            self.config.parameters.set(parameter, value),
            "{value} is out of range for {parameter:?}"
        );
        self
    }

    /// Starts the robot and sends the first commands after its first tick.
    pub(crate) fn start(self) -> Run {
        let mut run = Run {
            simulation: Simulation::new(&self.config),
            decoder: Decoder::default(),
            received: Vec::new(),
            heard: 0,
            key: None,
            sequence: 0,
            trace: self.trial.trace.as_ref().map(|path| {
                let number = self.trial.traced.get() + 1;
                self.trial.traced.set(number);
                let path = match number {
                    1 => path.clone(),
                    _ => path.with_extension(format!("{number}.csv")),
                };
                File::create(&path)
                    .and_then(|file| Trace::new(BufWriter::new(file)))
                    .unwrap_or_else(|error| panic!("cannot write {}: {error}", path.display()))
            }),
        };
        // Before its first tick a robot does not know the sensors of its board.
        run.tick();
        if let Some(allowed) = self.allowed {
            let which = LayerMask::ALL;
            run.must(Order::Layers { which, allowed });
        }
        if self.mode != Mode::Prowl {
            run.must(Order::Mode(self.mode));
        }
        run
    }
}

/// A running robot.
pub(crate) struct Run {
    pub(crate) simulation: Simulation,
    decoder: Decoder,
    /// Contents of the lines that ended in the latest tick.
    received: Vec<Body>,
    /// Number of the newest received line.
    heard: u8,
    /// Key of the session, if one is open.
    key: Option<Key>,
    sequence: u8,
    trace: Option<Trace<BufWriter<File>>>,
}

impl Run {
    /// Runs one tick of the robot.
    pub(crate) fn tick(&mut self) {
        self.simulation.run_for_ms(TICK_MS);
        self.received.clear();
        while let Some(byte) = self.simulation.poll_downlink() {
            match self.decoder.lines(&[byte]).next() {
                Some(Received::Line(line, _)) => {
                    self.heard = line.sequence;
                    self.received.push(line.body);
                }
                Some(Received::Ack(line)) => self.heard = line.sequence,
                None => {}
            }
        }
        if let Some(trace) = &mut self.trace {
            trace
                .observe(&self.simulation)
                .unwrap_or_else(|error| panic!("cannot write the trace: {error}"));
        }
    }

    /// Runs for this many seconds.
    pub(crate) fn seconds(&mut self, seconds: f64) {
        self.until(seconds, |_| false);
    }

    /// Runs until a condition holds; returns the seconds it took, `None` after `limit_s`.
    pub(crate) fn until(
        &mut self,
        limit_s: f64,
        mut is_so: impl FnMut(&Simulation) -> bool,
    ) -> Option<f64> {
        let ticks = (limit_s * 1000.0) as u64 / TICK_MS;
        for tick in 1..=ticks {
            self.tick();
            if is_so(&self.simulation) {
                return Some((tick * TICK_MS) as f64 / 1000.0);
            }
        }
        None
    }

    /// Sends a command past the radio; the next tick acts on it. Opens a session first if necessary.
    pub(crate) fn order(&mut self, order: Order) -> Outcome {
        self.open();
        self.sequence = self.sequence % 63 + 1;
        self.send(&Message::Command(Command {
            sequence: self.sequence,
            order,
        }));
        self.simulation.robot().ack().outcome
    }

    /// Sends a command; panics if the robot refuses it.
    pub(crate) fn must(&mut self, order: Order) {
        let outcome = self.order(order);
        assert_eq!(outcome, Outcome::Done, "{order:?}");
    }

    /// Sends a route and activates it.
    pub(crate) fn route(&mut self, list: &[Waypoint]) {
        self.open();
        for (frame, points) in list.chunks(16).enumerate() {
            self.send(&Message::Waypoints(Slots::new(1, frame as u8 * 4, points)));
        }
        self.must(Order::Activate {
            tag: 1,
            count: list.len() as u16,
            digest: digest(list.iter()),
        });
    }

    /// Opens a session if none is open.
    pub(crate) fn open(&mut self) {
        if self.key.is_some() {
            return;
        }
        let ack = self.simulation.robot().ack();
        let open = Message::Open(Open {
            boot: ack.boot,
            replaces: ack.session,
            owner: OWNER,
            era: None,
        });
        self.send(&open);
        let ack = self.simulation.robot().ack();
        self.key = Some(Key::session(ROBOT_ID, ack.boot, ack.session, OWNER));
    }

    /// Sends a frame past the radio.
    pub(crate) fn send(&mut self, message: &Message) {
        let key = self.key_for(message);
        self.simulation
            .deliver_uplink(message.encode(key).as_bytes());
    }

    /// Sends a frame by radio.
    pub(crate) fn transmit(&mut self, message: &Message) {
        let key = self.key_for(message);
        self.simulation
            .handle_uplink(message.encode(key).as_bytes());
    }

    fn key_for(&self, message: &Message) -> Key {
        let robot = Key::robot(ROBOT_ID);
        if message.is_sessionless() {
            robot
        } else {
            self.key.unwrap_or(robot)
        }
    }

    /// Contents of the lines that ended in the latest tick.
    pub(crate) fn received(&self) -> &[Body] {
        &self.received
    }

    /// Number of the newest received line.
    pub(crate) const fn heard(&self) -> u8 {
        self.heard
    }

    /// True pose in the robot's coordinates.
    pub(crate) fn pose(&self) -> Pose {
        self.simulation.truth().pose
    }
}

/// Distance in inches between two positions.
pub(crate) fn distance_in(one: Pose, other: Pose) -> f64 {
    (one.x_in - other.x_in).hypot(one.y_in - other.y_in)
}

/// Signed turn between two headings in degrees, from -180 up to but not including 180.
pub(crate) fn turn_deg(from_deg: f64, to_deg: f64) -> f64 {
    (to_deg - from_deg + 540.0).rem_euclid(360.0) - 180.0
}

/// Bearing of a point from a pose in degrees clockwise from its heading, likewise.
pub(crate) fn bearing_deg(from: Pose, point: Point) -> f64 {
    let (x, y) = (point.x_in - from.x_in, point.y_in - from.y_in);
    turn_deg(from.theta_deg, x.atan2(y).to_degrees())
}

/// Pose by odometry.
pub(crate) fn believed(simulation: &Simulation) -> Pose {
    let pose = simulation.robot().pose();
    let inches = |units: i32| f64::from(units) / f64::from(sr04_firmware::odometry::UNITS_PER_IN);
    Pose {
        x_in: inches(pose.x_units),
        y_in: inches(pose.y_units),
        theta_deg: f64::from(pose.heading.0 as i16) * 360.0 / 65536.0,
    }
}

/// Whether a layer controls the motors.
pub(crate) fn is_held_by(simulation: &Simulation, layer: Layer) -> bool {
    simulation.robot().holder() == Some(Holder::Layer(layer))
}
