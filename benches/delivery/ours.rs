//! One run of Groundwave's protocol: the real station and the robot's real program.

use groundwave::event::{CommandId, CommandStatus, Event};
use groundwave::request::Request;
use groundwave_protocol::Waypoint;
use groundwave_protocol::arq::Config;
use groundwave_protocol::status_codes::Mode;
use sr04_firmware::board;
use sr04_sim::{SimulationConfig, World};

use crate::common::{CoSimulation, owner};
use crate::selection::Duplex;

/// Limit of a run, seconds; every task ends earlier, confirmed or not.
const LIMIT_S: u64 = 600;

/// A robot and a station with an open session over this channel, after all traffic has ended.
fn at_rest(duplex: Duplex, spec: &str, seed: u64) -> CoSimulation {
    let mut co = switched_on(duplex, seed);
    co.deliver(Request::Mode(Mode::Reactive));
    co.simulation.set_channel(&channel(&duplex.over(spec)));
    co.run(5);
    co
}

/// Robot and station, configured for the kind of radio.
fn switched_on(duplex: Duplex, seed: u64) -> CoSimulation {
    let world = World::built_in("open-room").expect("it comes with the simulator");
    let mut config = SimulationConfig::new(world, seed);
    config.channel = channel(&duplex.over(""));
    if duplex == Duplex::Half {
        config.duplex = board::Duplex::Half {
            patience_bytes: board::PATIENCE_BYTES,
        };
    }
    CoSimulation::with(&config, Config::new(owner(seed)))
}

fn channel(spec: &str) -> sr04_sim::ChannelSpec {
    spec.parse().expect("the bench's own words")
}

/// Time from the command to send a list until the robot has confirmed it, seconds; the command is given when a line has
/// just arrived.
pub fn list_s(duplex: Duplex, spec: &str, seed: u64, count: usize) -> Option<f64> {
    let mut co = at_rest(duplex, spec, seed);
    let seen = co.events.len();
    co.run_until("a line is heard", 60, |co| {
        co.events[seen..]
            .iter()
            .any(|(_, event)| matches!(event, Event::Line { .. }))
    });
    confirmation_s(&mut co, Request::Route(route(seed, count)))
}

/// Time until a single command is confirmed, seconds; the command is given at a random time.
pub fn command_s(duplex: Duplex, spec: &str, seed: u64) -> Option<f64> {
    let mut co = at_rest(duplex, spec, seed);
    wait(&mut co, seed);
    confirmation_s(&mut co, Request::Mode(Mode::Prowl))
}

/// Time until a station that starts beside a running robot has the confirmation of `count` waypoints or of one command, seconds.
pub fn cold_s(duplex: Duplex, spec: &str, seed: u64, count: Option<usize>) -> Option<f64> {
    let mut co = switched_on(duplex, seed);
    co.simulation.run_for_ms(3000 + phase_ms(seed));
    while co.simulation.poll_downlink().is_some() {}
    co.simulation.set_channel(&channel(&duplex.over(spec)));
    let request = count.map_or(Request::Mode(Mode::Reactive), |count| {
        Request::Route(route(seed, count))
    });
    confirmation_s(&mut co, request)
}

fn confirmation_s(co: &mut CoSimulation, request: Request) -> Option<f64> {
    let begun_ms = co.simulation.now_ms();
    let id = co.request(request);
    co.run_until("it ends", LIMIT_S, |co| co.fate(id).is_some());
    matches!(co.fate(id), Some(CommandStatus::Confirmed { .. }))
        .then(|| (co.simulation.now_ms() - begun_ms) as f64 / 1000.0)
}

/// Speed below which the wheels count as standing still, in/s.
const STANDING_IN_S: f64 = 0.05;

/// An effect of a STOP, and whether it has occurred.
type Effect = (&'static str, fn(&CoSimulation, CommandId) -> bool);

/// The effects of a STOP, in any order.
pub const STOP_EFFECTS: [Effect; 5] = [
    ("robot in mode stop", |co, _| {
        co.simulation.robot().mode() == Mode::Stop
    }),
    ("motors braking", |co, _| {
        let outputs = co.simulation.outputs();
        outputs.pwm_left <= 0 && outputs.pwm_right <= 0
    }),
    ("motors off", |co, _| {
        let outputs = co.simulation.outputs();
        outputs.pwm_left == 0 && outputs.pwm_right == 0
    }),
    ("wheels standing", |co, _| {
        co.simulation.truth().speed_in_s.abs() < STANDING_IN_S
    }),
    ("confirmed at the station", |co, stop| {
        co.fate(stop).is_some()
    }),
];

/// Presses STOP `phase_ms` into a transfer of 100 waypoints to a driving robot; returns the time from the key until
/// each of [`STOP_EFFECTS`], milliseconds.
pub fn stop_ms(duplex: Duplex, phase_ms: u64) -> [u64; 5] {
    let mut co = switched_on(duplex, 1);
    co.deliver(Request::Mode(Mode::Prowl));
    co.request(Request::Route(route(1, 100)));
    for _ in 0..300 + phase_ms {
        co.step();
    }
    assert!(!co.station.is_settled(), "STOP must come in mid-transfer");
    let pressed_ms = co.simulation.now_ms();
    let stop = co.request(Request::Stop);
    let mut first_ms = [None; 5];
    co.run_until("STOP has done all that it does", LIMIT_S, |co| {
        let after_ms = co.simulation.now_ms() - pressed_ms;
        for (first_ms, (_, is_done)) in first_ms.iter_mut().zip(STOP_EFFECTS) {
            if first_ms.is_none() && is_done(co, stop) {
                *first_ms = Some(after_ms);
            }
        }
        first_ms.iter().all(Option::is_some)
    });
    first_ms.map(|ms| ms.expect("run_until has seen them all"))
}

/// Time from STOP, at a random time without traffic, to its effect on the robot and to its confirmation, seconds.
pub fn stop_s(duplex: Duplex, spec: &str, seed: u64) -> (Option<f64>, Option<f64>) {
    let mut co = at_rest(duplex, spec, seed);
    wait(&mut co, seed);
    let begun_ms = co.simulation.now_ms();
    let since_s = |co: &CoSimulation| (co.simulation.now_ms() - begun_ms) as f64 / 1000.0;
    let stop = co.request(Request::Stop);
    let mut effect_s = None;
    co.run_until("it ends", LIMIT_S, |co| {
        if co.simulation.robot().mode() == Mode::Stop {
            effect_s.get_or_insert(since_s(co));
        }
        co.fate(stop).is_some()
    });
    let is_confirmed = co.fate(stop) == Some(CommandStatus::Confirmed { digest: None });
    (effect_s, is_confirmed.then(|| since_s(&co)))
}

/// A time within a second, from the seed, in milliseconds.
fn phase_ms(seed: u64) -> u64 {
    seed * 617 % 1000
}

fn wait(co: &mut CoSimulation, seed: u64) {
    for _ in 0..phase_ms(seed) {
        co.step();
    }
}

/// Random waypoints over the whole plane, from the seed.
pub fn route(seed: u64, count: usize) -> Vec<Waypoint> {
    let mut state = seed;
    let mut part = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((state >> 33) % 19_999) as i16 - 9999
    };
    (0..count)
        .map(|_| Waypoint {
            x_in: part(),
            y_in: part(),
        })
        .collect()
}
