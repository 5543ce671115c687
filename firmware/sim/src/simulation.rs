//! World, body, radio and the robot's real program together, in virtual time.

use sr04_firmware::board::{Duplex, Identity, Inputs, Outputs};
use sr04_firmware::parameters::Parameters;
use sr04_firmware::robot::Robot;

use crate::body::Conditions;
use crate::channel::{ChannelSpec, Radio};
use crate::geometry::Pose;
use crate::plant::{Plant, Truth};
use crate::rng::{Rng, Stream};
use crate::stuck::StuckDetector;
use crate::time::{SAMPLE_MS, TICK_MS};
use crate::world::{Outline, Point, World};

/// Start values of a simulation. Equal configurations give equal runs, byte for byte.
#[derive(Clone, Debug)]
pub struct SimulationConfig {
    /// The robot's surroundings.
    pub world: World,
    /// Seed of all random events.
    pub seed: u64,
    /// Faults of the radio.
    pub channel: ChannelSpec,
    /// Battery, load and wheels.
    pub conditions: Conditions,
    /// Robot number, 1 to 99.
    pub robot_id: u8,
    /// Boot counter at the first boot.
    pub boots: u16,
    /// Whether the robot takes turns with the ground station.
    pub duplex: Duplex,
    /// Parameters that the board has kept from earlier boots.
    pub parameters: Parameters,
}

impl SimulationConfig {
    /// A perfect radio and robot 1 at its first boot.
    #[must_use]
    pub fn new(world: World, seed: u64) -> Self {
        Self {
            world,
            seed,
            channel: ChannelSpec::default(),
            conditions: Conditions::default(),
            robot_id: 1,
            boots: 1,
            duplex: Duplex::default(),
            parameters: Parameters::DEFAULT,
        }
    }
}

/// A running simulation.
pub struct Simulation {
    now_ms: u64,
    plant: Plant,
    robot: Robot,
    identity: Identity,
    kept: Parameters,
    robot_rng: Rng,
    leds_on: bool,
    inputs: Inputs,
    radio: Radio,
    stuck: StuckDetector,
}

impl Simulation {
    /// A simulation at time 0: the robot is at its start and has just booted.
    #[must_use]
    pub fn new(config: &SimulationConfig) -> Self {
        let mut robot_rng = Rng::new(config.seed, Stream::Robot);
        let identity = Identity::new(
            config.robot_id,
            config.boots,
            robot_rng.next_u32(),
            config.duplex,
        );
        Self {
            now_ms: 0,
            plant: Plant::new(&config.world, &config.conditions, config.seed),
            robot: Robot::restored(identity, config.parameters.clone()),
            identity,
            kept: config.parameters.clone(),
            robot_rng,
            leds_on: false,
            inputs: Inputs::default(),
            radio: Radio::new(&config.channel, config.seed),
            stuck: StuckDetector::default(),
        }
    }

    /// Advances the simulation by one millisecond.
    pub fn step(&mut self) {
        self.now_ms += 1;
        self.plant.step();
        if self.now_ms.is_multiple_of(SAMPLE_MS) {
            let (left, right) = self.plant.infrared(self.leds_on);
            self.leds_on = self.robot.infrared_sample(left, right);
        }
        if self.now_ms.is_multiple_of(TICK_MS) {
            self.inputs = self.plant.inputs();
            let outputs = self.robot.tick(&self.inputs);
            if outputs.keep_parameters {
                self.kept.clone_from(self.robot.parameters());
            }
            self.plant.apply(outputs);
            self.stuck.observe(&self.plant.truth(), outputs);
        }
        self.radio.step(self.now_ms, || self.robot.poll_downlink());
        while let Some(byte) = self.radio.poll_uplink(self.now_ms) {
            self.robot.handle_uplink(byte);
        }
    }

    /// Advances the simulation by `time_ms` milliseconds.
    pub fn run_for_ms(&mut self, time_ms: u64) {
        for _ in 0..time_ms {
            self.step();
        }
    }

    /// Queues bytes from the ground station; the radio sends 240 bytes per second.
    pub fn handle_uplink(&mut self, bytes: &[u8]) {
        self.radio.transmit(bytes);
    }

    /// Delivers bytes to the robot's receiver at once, bypassing the radio: for tests of the robot alone.
    pub fn deliver_uplink(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.robot.handle_uplink(byte);
        }
    }

    /// Number of uplink bytes that the robot cannot have received yet: queued bytes and bytes in a modem.
    #[must_use]
    pub fn uplink_pending(&self) -> usize {
        self.radio.uplink_pending()
    }

    /// The next byte that the ground station has received by now.
    pub fn poll_downlink(&mut self) -> Option<u8> {
        self.radio.poll_downlink(self.now_ms)
    }

    /// Virtual time since the start, milliseconds.
    #[must_use]
    pub const fn now_ms(&self) -> u64 {
        self.now_ms
    }

    /// True state of the robot, independent of what it believes.
    #[must_use]
    pub fn truth(&self) -> Truth {
        self.plant.truth()
    }

    /// Walls and furniture in the robot's coordinates.
    #[must_use]
    pub fn outlines(&self) -> &[Outline] {
        self.plant.outlines()
    }

    /// Positions of people and animals in the robot's coordinates, each with its radius in inches.
    pub fn walkers(&self) -> impl Iterator<Item = (Point, f64)> {
        self.plant.walkers()
    }

    /// The robot's program.
    #[must_use]
    pub const fn robot(&self) -> &Robot {
        &self.robot
    }

    /// The robot's sensor inputs at its last tick.
    #[must_use]
    pub const fn inputs(&self) -> &Inputs {
        &self.inputs
    }

    /// The robot's outputs since its last tick.
    #[must_use]
    pub const fn outputs(&self) -> Outputs {
        self.plant.outputs()
    }

    /// Boot counter of the running program.
    #[must_use]
    pub const fn boots(&self) -> u16 {
        self.identity.boots
    }

    /// Parameters that the board keeps over a reset.
    #[must_use]
    pub const fn kept_parameters(&self) -> &Parameters {
        &self.kept
    }

    /// Whether the robot has moved less than 12 inches in 5 minutes with its motors on.
    #[must_use]
    pub const fn is_stuck(&self) -> bool {
        self.stuck.is_stuck()
    }

    /// Resets the robot. Its state is lost except for the kept parameters, its boot counter rises by one, and the world
    /// continues.
    pub fn reboot(&mut self) {
        self.identity.boots = self.identity.boots.wrapping_add(1);
        self.identity.rng_seed = self.robot_rng.next_u32();
        self.robot = Robot::restored(self.identity, self.kept.clone());
        self.leds_on = false;
        self.plant.reset_board();
    }

    /// Lifts the robot from the floor; its program continues.
    pub fn lift(&mut self) {
        self.plant.lift();
    }

    /// Puts the robot down at a free place in the coordinates of [`Truth`].
    pub fn set_down(&mut self, pose: Pose) {
        self.plant.set_down(pose);
    }

    /// Replaces the radio's faults; bytes on their way keep their arrival time.
    pub fn set_channel(&mut self, channel: &ChannelSpec) {
        self.radio.set(channel);
    }

    /// Switches a lamp by name; returns `false` if the world has no lamp of this name.
    pub fn set_lamp(&mut self, name: &str, on: bool) -> bool {
        self.plant.set_lamp(name, on)
    }
}
