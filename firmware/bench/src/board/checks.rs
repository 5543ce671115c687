//! What the emulated board must show, each in a house of its own.

use std::collections::VecDeque;
use std::path::PathBuf;

use groundwave_protocol::BYTES_PER_S;
use groundwave_protocol::Waypoint;
use groundwave_protocol::command::{Key, Message, Open, Slots};
use groundwave_protocol::status_codes::{Arm, Bump, Cliff, Infrared, Mode};
use groundwave_protocol::telemetry::{Ack, Body, StateLine};
use sr04_firmware::memory::BOOTS_BYTES;

use super::emulator::Loss;
use super::house::House;
use super::watched::{FIRST_LINES_MS, KEPT, Watched};
use crate::chip::Figures;
use crate::operator::{OWNER, ROBOT_ID};
use crate::scenario::Scenario;

/// Speed of the radio; 1 % of it is no fault.
const RADIO_BITS_PER_S: u16 = 2400;

/// Duration of a session while the radio is busy.
const SESSION_MS: u64 = 10_000;

/// Programs that the checks run.
#[derive(Debug)]
pub(crate) struct Programs {
    pub(crate) emulator: PathBuf,
    /// The board with every sensor.
    pub(crate) full: PathBuf,
    /// The board without any sensor that can be left out.
    pub(crate) bare: PathBuf,
    /// The board with a display and a radio that takes turns.
    pub(crate) half: PathBuf,
    /// Address of the function that a panic calls.
    pub(crate) panic_at: u32,
    /// The ground station's program.
    pub(crate) groundwave: PathBuf,
}

/// The board drives through its pins, with the operator's tour, and a host's robot gets what it gets.
pub(crate) fn lockstep(programs: &Programs, seed: u64, seconds: u64) -> Result<Figures, String> {
    let tour = Scenario::named("tour").ok_or("no run is named tour")?;
    let mut watched = Watched::start(programs, "house", seed)?;
    for now_ms in 1..=seconds * 1000 {
        watched.step()?;
        tour.act(now_ms, &mut watched.operator);
    }
    let modes: Vec<Mode> = watched.house.bodies(|body| match body {
        Body::State(state) => Some(state.mode),
        _ => None,
    });
    if seconds >= 60 {
        for mode in [Mode::Prowl, Mode::Wander, Mode::Stop] {
            if !modes.contains(&mode) {
                return Err(format!("the robot was never in mode {mode:?}"));
            }
        }
    }
    let path_in = watched.house.path_in();
    if path_in < seconds as f64 {
        return Err(format!("the robot drove only {path_in:.0} in"));
    }
    watched.house.finish()
}

/// Both directions of the radio without a pause.
pub(crate) fn saturated(programs: &Programs, seed: u64, seconds: u64) -> Result<Figures, String> {
    let mut house = House::new("house", seed, &programs.emulator, &programs.full)?;
    house.run_ms(FIRST_LINES_MS)?;
    let mut queue: VecDeque<u8> = VecDeque::new();
    let mut byte_time = 0;
    let mut noise = seed as u32;
    let mut opens_ms = 0;
    for _ in 0..seconds * 1000 {
        if queue.is_empty() {
            let ack = house.ack.ok_or("the robot has not told its session")?;
            if house.now_ms >= opens_ms {
                opens_ms = house.now_ms + SESSION_MS;
                queue.extend(opening(ack));
            }
            queue.extend(waypoints(ack));
            noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            queue.extend(noise.to_be_bytes());
        }
        byte_time += BYTES_PER_S;
        let byte = if byte_time >= 1000 {
            byte_time -= 1000;
            queue.pop_front()
        } else {
            None
        };
        house.step(byte.as_slice())?;
    }
    let frames = house
        .bodies(|body| match body {
            Body::Counters(counters) => Some(counters.frames_heard),
            _ => None,
        })
        .last()
        .copied();
    if frames.is_none_or(|frames| u64::from(frames) < seconds) {
        return Err(format!("the board heard only {frames:?} frames"));
    }
    let chip = house.emulator.figures()?;
    if chip.lost_bytes > 0 {
        return Err(format!("{} received bytes were lost", chip.lost_bytes));
    }
    if chip.bits_per_s.abs_diff(RADIO_BITS_PER_S) > 24 {
        return Err(format!("the radio has {} bits a second", chip.bits_per_s));
    }
    house.finish()
}

/// A frame that opens another session.
fn opening(ack: Ack) -> Vec<u8> {
    let open = Message::Open(Open {
        boot: ack.boot,
        replaces: ack.session,
        owner: OWNER,
        era: None,
    });
    open.encode(Key::robot(ROBOT_ID)).as_bytes().to_vec()
}

/// A frame of waypoints in the present session.
fn waypoints(ack: Ack) -> Vec<u8> {
    let points: [Waypoint; 16] = std::array::from_fn(|n| Waypoint {
        x_in: n as i16 * 7,
        y_in: -(n as i16),
    });
    let session = Key::session(ROBOT_ID, ack.boot, ack.session, OWNER);
    let slots = Message::Waypoints(Slots::new(1, 0, &points));
    slots.encode(session).as_bytes().to_vec()
}

/// Watchdog, panic, brown-out and power: the motors stop, the board boots and tells the reason.
pub(crate) fn resets(programs: &Programs, seed: u64) -> Result<Figures, String> {
    let mut watched = Watched::start(programs, "open-room", seed)?;
    watched.run_ms(FIRST_LINES_MS)?;
    // The watchdog's two times, 16 ms and some to boot.
    let limits_ms = [
        ("watchdog", 145),
        ("watchdog with interrupts off", 270),
        ("panic", 20),
        ("brown-out", 2),
        ("power", 2),
    ];
    for (boots, (reason, limit_ms)) in (2..).zip(limits_ms) {
        if !watched.house.drives {
            return Err(format!("the robot does not drive before: {reason}"));
        }
        let from = watched.house.lines.len();
        let emulator = &mut watched.house.emulator;
        let told = match reason {
            "watchdog" => emulator.hang(true).map(|()| "watchdog"),
            "watchdog with interrupts off" => emulator.hang(false).map(|()| "watchdog"),
            "panic" => emulator.call(programs.panic_at).map(|()| "panicked"),
            "brown-out" => emulator.brown_out().map(|()| "voltage"),
            _ => emulator.lose_power().map(|()| ""),
        }?;
        watched.forget();
        let mut stopped_ms = 0;
        while watched.house.drives {
            watched.step()?;
            stopped_ms += 1;
            if stopped_ms > limit_ms {
                return Err(format!("{reason}: the motors run after {limit_ms} ms"));
            }
        }
        watched.run_ms(2 * FIRST_LINES_MS)?;
        let lines = watched.house.lines.iter().skip(from);
        let (mut texts, mut newest) = (Vec::new(), 0);
        for (_, line) in lines {
            match &line.body {
                Body::Text(text) if text.as_str().starts_with("restarted") => {
                    texts.push(text.as_str().to_owned());
                }
                Body::Status(status) => newest = status.boots,
                _ => {}
            }
        }
        let is_told = match texts.as_slice() {
            [] => told.is_empty(),
            [text] => !told.is_empty() && text.contains(told),
            _ => false,
        };
        if !is_told || newest != boots {
            return Err(format!(
                "{reason}: boot {newest}, not {boots}, with {texts:?}"
            ));
        }
    }
    watched.house.finish()
}

/// Power is lost in the middle of writes of parameters and boot counter: the old or the new ones are there afterwards.
pub(crate) fn power_lost(programs: &Programs, seed: u64) -> Result<Figures, String> {
    let mut watched = Watched::start(programs, "open-room", seed)?;
    watched.run_ms(FIRST_LINES_MS)?;
    let mut kept = 12;
    // Both copies of a blank memory have many writes, later ones only those of bytes that differ.
    for (write, later) in [(7, 0), (7, 0), (1, 1), (1, 1)] {
        watched.keep(&mut kept, write, later, Loss::Power)?;
    }
    // A write goes on while the chip boots.
    watched.keep(&mut kept, 1, 1, Loss::Voltage)?;
    // Both copies of the boot counter.
    for write in (1..=BOOTS_BYTES as u16).flat_map(|write| [write; 2]) {
        let boots = watched.newest_boots()?;
        watched.lose_power()?;
        if !watched.is_lost_in(write, Loss::Power)? {
            return Err(format!("a boot has no write {write}"));
        }
        watched.run_ms(FIRST_LINES_MS)?;
        let next = watched.newest_boots()?;
        if next != boots + 1 && next != boots + 2 {
            return Err(format!("boot {boots} and two more are boot {next}"));
        }
    }
    if watched.parameter(KEPT)? != kept {
        return Err("a boot changed a parameter".to_owned());
    }
    watched.house.finish()
}

/// A board without sensors says so.
pub(crate) fn bare(programs: &Programs, seed: u64) -> Result<Figures, String> {
    let mut house = House::new("open-room", seed, &programs.emulator, &programs.bare)?;
    house.run_ms(2 * FIRST_LINES_MS)?;
    let states: Vec<StateLine> = house.bodies(|body| match body {
        Body::State(state) => Some(*state),
        _ => None,
    });
    let is_bare = |state: &StateLine| {
        state.bump == Bump::NotFitted
            && state.infrared == Infrared::NotFitted
            && state.cliff == Cliff::NotFitted
            && state.arm == Arm::NotFitted
            && state.sonar_left_in.is_none()
            && state.sonar_right_in.is_none()
            && state.photo_left_pct.is_none()
            && state.photo_right_pct.is_none()
    };
    if states.is_empty() || !states.iter().all(is_bare) {
        return Err(format!("not every sensor is missing: {states:?}"));
    }
    house.finish()
}

/// The display shows what the lines tell.
pub(crate) fn display(programs: &Programs, seed: u64) -> Result<Figures, String> {
    let mut house = House::new("open-room", seed, &programs.emulator, &programs.half)?;
    house.run_ms(2 * FIRST_LINES_MS)?;
    let shown = house.emulator.display()?;
    let (_, state) = house
        .lines
        .iter()
        .rev()
        .find_map(|(at_ms, line)| match &line.body {
            Body::State(state) => Some((at_ms, *state)),
            _ => None,
        })
        .ok_or("no line A")?;
    let mut words = shown.split_whitespace();
    let mut number = || words.next().and_then(|word| word.parse::<i32>().ok());
    let (Some(x_in), Some(y_in), Some(theta_deg)) = (number(), number(), number()) else {
        return Err(format!("the display shows no pose: {shown:?}"));
    };
    let is_near = |shown: i32, tenths: i32| (shown * 10 - tenths).abs() < 200;
    if !is_near(x_in, state.x_tenths_in)
        || !is_near(y_in, state.y_tenths_in)
        || !(0..360).contains(&theta_deg)
        || !shown.contains("\nP 12.")
    {
        return Err(format!("the display shows {shown:?}, the line {state:?}"));
    }
    house.finish()
}
