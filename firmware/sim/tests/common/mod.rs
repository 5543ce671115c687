//! The robot's program in a simulated world without a radio: commands arrive at once.
#![allow(dead_code, reason = "each test uses its own part")]

use groundwave_protocol::command::{Command, Key, Message, Open, Order};
use groundwave_protocol::status_codes::Mode;
use sr04_firmware::board::{Duplex, Identity, Inputs, Outputs};
use sr04_firmware::parameters::{Parameter, Parameters};
use sr04_firmware::robot::Robot;
use sr04_sim::{Conditions, Plant, SAMPLE_MS, TICK_MS, World};

const ROBOT_ID: u8 = 1;
const OWNER: u16 = 77;

pub struct Rig {
    pub plant: Plant,
    pub robot: Robot,
    pub inputs: Inputs,
    pub outputs: Outputs,
    leds_on: bool,
    now_ms: u64,
    sequence: u8,
}

/// An empty hall of 60 by 60 feet.
pub fn hall() -> World {
    let floor = format!("#{}#\n", ".".repeat(120));
    let wall = format!("{}\n", "#".repeat(122));
    let text = format!(
        "name = \"hall\"\ncell_in = 6\nplan = '''\n{wall}{}#{}^{}#\n{}{wall}'''\n",
        floor.repeat(60),
        ".".repeat(60),
        ".".repeat(59),
        floor.repeat(60)
    );
    World::parse("hall", &text).expect("the hall is a valid world")
}

pub fn parameters(changes: &[(Parameter, i16)]) -> Parameters {
    let mut parameters = Parameters::DEFAULT;
    for &(parameter, value) in changes {
        assert!(parameters.set(parameter, value), "{parameter:?} {value}");
    }
    parameters
}

impl Rig {
    pub fn new(world: &World, seed: u64, parameters: Parameters) -> Self {
        Self::with(world, seed, parameters, &Conditions::default())
    }

    pub fn with(world: &World, seed: u64, parameters: Parameters, conditions: &Conditions) -> Self {
        let identity = Identity::new(ROBOT_ID, 1, seed as u32, Duplex::Full);
        let mut rig = Self {
            plant: Plant::new(world, conditions, seed),
            robot: Robot::restored(identity, parameters),
            inputs: Inputs::default(),
            outputs: Outputs::default(),
            leds_on: false,
            now_ms: 0,
            sequence: 0,
        };
        let ack = rig.robot.ack();
        rig.send(
            &Message::Open(Open {
                boot: ack.boot,
                replaces: ack.session,
                owner: OWNER,
                era: None,
            }),
            Key::robot(ROBOT_ID),
        );
        rig
    }

    fn send(&mut self, message: &Message, key: Key) {
        for &byte in message.encode(key).as_bytes() {
            self.robot.handle_uplink(byte);
        }
    }

    pub fn order(&mut self, order: Order) {
        self.sequence += 1;
        let ack = self.robot.ack();
        let key = Key::session(ROBOT_ID, ack.boot, ack.session, OWNER);
        let sequence = self.sequence;
        self.send(&Message::Command(Command { sequence, order }), key);
        assert_eq!(
            self.robot.ack().sequence,
            sequence % 8,
            "the robot took the command"
        );
    }

    pub fn tick(&mut self) {
        for _ in 0..TICK_MS {
            self.now_ms += 1;
            self.plant.step();
            if self.now_ms.is_multiple_of(SAMPLE_MS) {
                let (left, right) = self.plant.infrared(self.leds_on);
                self.leds_on = self.robot.infrared_sample(left, right);
            }
        }
        self.inputs = self.plant.inputs();
        self.outputs = self.robot.tick(&self.inputs);
        self.plant.apply(self.outputs);
    }

    pub fn run_s(&mut self, seconds: u32) {
        for _ in 0..seconds * 20 {
            self.tick();
        }
    }

    /// Runs until the robot is in `mode` and returns the seconds; returns `None` after `seconds_max`.
    pub fn run_to(&mut self, mode: Mode, seconds_max: u32) -> Option<f64> {
        for tick in 0..seconds_max * 20 {
            if self.robot.mode() == mode {
                return Some(f64::from(tick) / 20.0);
            }
            self.tick();
        }
        None
    }

    /// Distance in inches of the robot's true position from a point.
    pub fn distance_in(&self, x_in: f64, y_in: f64) -> f64 {
        let pose = self.plant.truth().pose;
        (pose.x_in - x_in).hypot(pose.y_in - y_in)
    }
}
