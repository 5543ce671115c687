//! Scenarios for the robot: each mode, and each fault of its link, its sensors and its supply.

use groundwave_protocol::Waypoint;
use groundwave_protocol::command::Order;
use groundwave_protocol::failsafe::Failsafe;
use groundwave_protocol::parameter::key;
use groundwave_protocol::status_codes::Mode;
use sr04_firmware::board::{Duplex, Identity, PATIENCE_BYTES, Side};
use sr04_firmware::parameters::Parameters;
use sr04_sim::{ChannelSpec, Conditions, Faults, Plant, Radio, SAMPLE_MS, TICK_MS, World};

use crate::operator::{Operator, ROBOT_ID, Task};
use crate::recorder::{Recorder, Recording};

/// Idle byte times after which a half-duplex robot listens.
const LISTENS_AFTER_BYTES: u32 = 2;

/// A run.
pub(crate) struct Scenario {
    pub(crate) name: &'static str,
    world: &'static str,
    channel: &'static str,
    duplex: Duplex,
    faults: Faults,
    /// Time between two resets, milliseconds.
    reset_ms: Option<u64>,
    /// Events and their times, milliseconds.
    script: Vec<(u64, Event)>,
    /// Time after which the script begins again, milliseconds.
    period_ms: u64,
}

/// An event of a script.
enum Event {
    Task(Task),
    Drive(Option<(i8, i8)>),
}

impl Scenario {
    fn new(name: &'static str, world: &'static str, script: Vec<(u64, Event)>) -> Self {
        Self {
            name,
            world,
            channel: "",
            duplex: Duplex::Full,
            faults: Faults::default(),
            reset_ms: None,
            script,
            period_ms: u64::MAX,
        }
    }

    fn mode(name: &'static str, world: &'static str, mode: Mode) -> Self {
        Self::new(name, world, vec![order(1000, Order::Mode(mode))])
    }

    fn every_ms(self, period_ms: u64) -> Self {
        Self { period_ms, ..self }
    }

    /// The scenario with a name; `None` if there is none.
    pub(crate) fn named(name: &str) -> Option<Self> {
        Self::all().into_iter().find(|run| run.name == name)
    }

    /// All scenarios.
    pub(crate) fn all() -> Vec<Self> {
        let patience_bytes = PATIENCE_BYTES;
        vec![
            Self::new("prowl", "house", Vec::new()),
            Self::mode("reactive", "living-room", Mode::Reactive),
            Self::mode("passive", "house", Mode::Passive),
            Self::mode("wander", "office", Mode::Wander).every_ms(240_000),
            Self::mode("forage", "flat", Mode::Forage),
            Self::mode("calibrate", "open-room", Mode::Calibrate).every_ms(120_000),
            Self::new(
                "go-home",
                "house",
                vec![
                    order(1000, Order::Mode(Mode::Prowl)),
                    order(60_000, Order::Mode(Mode::GoHome)),
                ],
            )
            .every_ms(150_000),
            Self::new("user", "living-room", hand_driving()).every_ms(20_000),
            Self::new("route-99", "open-room", vec![route(1000, 99)]).every_ms(240_000),
            Self::new(
                "stop-and-scan",
                "dark-room",
                vec![
                    order(1000, Order::Mode(Mode::Reactive)),
                    order(2000, Order::Scan),
                    (20_000, Event::Task(Task::Stop)),
                ],
            )
            .every_ms(30_000),
            Self::new("tour", "house", routes_and_modes()).every_ms(120_000),
            Self::new("parameters", "corridor", parameters()).every_ms(60_000),
            Self::new("failsafe", "house", failsafe()).every_ms(90_000),
            Self {
                channel: "ber=1e-3",
                ..Self::new("bit-errors", "house", routes_and_modes()).every_ms(120_000)
            },
            Self {
                channel: "half-duplex,ber=1e-4",
                duplex: Duplex::Half { patience_bytes },
                ..Self::new("half-duplex", "house", routes_and_modes()).every_ms(120_000)
            },
            Self {
                faults: Faults {
                    dead_encoder: Some(Side::Left),
                    ..Faults::WORN
                },
                ..Self::mode("broken-encoder", "house", Mode::Prowl).every_ms(60_000)
            },
            Self {
                reset_ms: Some(45_000),
                faults: Faults::ROTTEN,
                ..Self::new("resets", "stairs", routes_and_modes()).every_ms(60_000)
            },
        ]
    }

    /// Runs the robot on the host and records its calls.
    pub(crate) fn record(&self, seed: u64, duration_ms: u64) -> Result<Recording, String> {
        let world = World::open(self.world).map_err(|error| error.to_string())?;
        let channel: ChannelSpec = self.channel.parse().map_err(|error| format!("{error}"))?;
        let conditions = Conditions {
            faults: self.faults,
            ..Conditions::default()
        };
        let mut plant = Plant::new(&world, &conditions, seed);
        let mut radio = Radio::new(&channel, seed);
        let mut identity = Identity::new(ROBOT_ID, 1, seed as u32, self.duplex);
        let mut kept = Parameters::DEFAULT;
        let mut recorder = Recorder::new(identity, &kept);
        let mut operator = Operator::default();
        let (mut leds_on, mut idle_bytes) = (false, 0);
        for now_ms in 1..=duration_ms {
            if self
                .reset_ms
                .is_some_and(|reset_ms| now_ms.is_multiple_of(reset_ms))
            {
                identity.boots += 1;
                identity.rng_seed = identity.rng_seed.wrapping_mul(0x9E37_79B1);
                recorder.reboot(identity, &kept);
                plant.reset_board();
                leds_on = false;
            }
            plant.step();
            if now_ms.is_multiple_of(SAMPLE_MS) {
                let (left, right) = plant.infrared(leds_on);
                leds_on = recorder.infrared_sample(left, right);
            }
            if now_ms.is_multiple_of(TICK_MS) {
                let outputs = recorder.tick(&plant.inputs());
                if outputs.keep_parameters {
                    kept.clone_from(recorder.robot.parameters());
                }
                plant.apply(outputs);
            }
            radio.step(now_ms, || {
                let byte = recorder.poll_downlink();
                idle_bytes = if byte.is_some() { 0 } else { idle_bytes + 1 };
                byte
            });
            while let Some(byte) = radio.poll_uplink(now_ms) {
                recorder.handle_uplink(byte);
            }
            while let Some(byte) = radio.poll_downlink(now_ms) {
                operator.receive(byte);
            }
            self.act(now_ms, &mut operator);
            let listens = self.duplex == Duplex::Full || idle_bytes >= LISTENS_AFTER_BYTES;
            if listens && radio.uplink_pending() == 0 {
                radio.transmit(&operator.transmit(now_ms, recorder.robot.ack()));
            }
        }
        Ok(recorder.recording)
    }

    /// Gives the operator its tasks of this moment.
    pub(crate) fn act(&self, now_ms: u64, operator: &mut Operator) {
        for (at_ms, event) in &self.script {
            if now_ms % self.period_ms == *at_ms {
                match event {
                    Event::Task(task) => operator.queue(task.clone()),
                    Event::Drive(speeds) => operator.drive(*speeds),
                }
            }
        }
    }
}

fn order(at_ms: u64, order: Order) -> (u64, Event) {
    (at_ms, Event::Task(Task::Order(order)))
}

/// Points on a spiral of growing squares around the origin.
fn route(at_ms: u64, count: i16) -> (u64, Event) {
    let point = |n: i16| {
        let reach_in = 10 + n / 2;
        let (right, ahead) = [(1, 1), (1, -1), (-1, -1), (-1, 1)][n as usize % 4];
        Waypoint {
            x_in: right * reach_in,
            y_in: ahead * reach_in,
        }
    };
    (
        at_ms,
        Event::Task(Task::Route((0..count).map(point).collect())),
    )
}

fn hand_driving() -> Vec<(u64, Event)> {
    vec![
        order(500, Order::Mode(Mode::User)),
        (1000, Event::Drive(Some((6, 0)))),
        (5000, Event::Drive(Some((0, 8)))),
        (7000, Event::Drive(Some((-6, -3)))),
        (11_000, Event::Drive(None)),
        (14_000, Event::Drive(Some((12, 4)))),
    ]
}

fn parameters() -> Vec<(u64, Event)> {
    let set = |at_ms, name, value| {
        let key = key(name);
        order(at_ms, Order::SetParameter { key, value })
    };
    vec![
        order(500, Order::ReadParameters { place: 0 }),
        set(20_000, "top-speed", 5),
        set(21_000, "square", -200),
        set(22_000, "top-speed", 99),
        order(23_000, Order::KeepParameters),
        order(24_000, Order::ReadParameter { key: key("square") }),
    ]
}

fn failsafe() -> Vec<(u64, Event)> {
    let guard = Failsafe {
        silence_s: 20,
        mode: Mode::GoHome,
    };
    vec![
        order(1000, Order::Mode(Mode::Prowl)),
        order(2000, Order::Failsafe(Some(guard))),
        order(60_000, Order::Failsafe(None)),
    ]
}

fn routes_and_modes() -> Vec<(u64, Event)> {
    let position = Waypoint { x_in: 12, y_in: -7 };
    vec![
        route(1000, 14),
        order(20_000, Order::Mode(Mode::Wander)),
        order(30_000, Order::Scan),
        order(
            40_000,
            Order::Pose {
                position,
                theta_deg: 270,
            },
        ),
        order(41_000, Order::ReadParameters { place: 3 }),
        (50_000, Event::Task(Task::Stop)),
        order(52_000, Order::Mode(Mode::Prowl)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_capture_of_the_emulated_mega_equals_the_run_on_the_host() {
        let capture = include_bytes!("../../../captures/mega-tour.txt");
        let tour = Scenario::named("tour").unwrap();
        let recording = tour.record(1, 120_000).unwrap();
        assert!(
            recording.downlink == capture,
            "captures/README.md shows how to make the capture again"
        );
    }
}
