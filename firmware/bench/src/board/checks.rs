//! What the emulated board must show, each in a house of its own.

use std::collections::VecDeque;
use std::path::PathBuf;

use groundwave_protocol::BYTES_PER_S;
use groundwave_protocol::Waypoint;
use groundwave_protocol::command::{Key, Message, Open, Order, Slots};
use groundwave_protocol::parameter::key;
use groundwave_protocol::status_codes::{Arm, Bump, Cliff, Infrared, Mode, Power};
use groundwave_protocol::telemetry::{Ack, Body, StateLine};
use sr04_firmware::board::{Edges, Inputs, Sides};
use sr04_firmware::memory::BOOTS_BYTES;

use super::emulator::Loss;
use super::house::{Hand, House};
use crate::chip::Figures;
use crate::operator::{OWNER, Operator, ROBOT_ID, Task};
use crate::scenario::Scenario;

/// Most bytes that a step takes.
const STEP_BYTES: usize = 255;

/// Speed of the radio; 1 % of it is no fault.
const RADIO_BITS_PER_S: u16 = 2400;

/// Duration of a session while the radio is busy.
const SESSION_MS: u64 = 10_000;

/// Time in which a robot tells its first lines.
const FIRST_LINES_MS: u64 = 5000;

/// Time in which the operator's tasks are done.
const TASKS_MS: u64 = 30_000;

/// Time in which the robot has written its parameters, 3.4 ms a byte.
const WRITES_MS: u64 = 600;

/// Parameter that is kept.
const KEPT: &str = "top-speed";

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

/// A house with an operator at the radio.
struct Watched {
    house: House,
    operator: Operator,
    /// Bytes on their way to the board, and the time when they have come.
    queue: VecDeque<u8>,
    busy_to_ms: u64,
}

impl Watched {
    /// The whole program in a world.
    fn start(programs: &Programs, world: &str, seed: u64) -> Result<Self, String> {
        Ok(Self {
            house: House::new(world, seed, &programs.emulator, &programs.full)?,
            operator: Operator::default(),
            queue: VecDeque::new(),
            busy_to_ms: 0,
        })
    }

    fn step(&mut self) -> Result<(), String> {
        let count = self.queue.len().min(STEP_BYTES);
        let received: Vec<u8> = self.queue.drain(..count).collect();
        for byte in self.house.step(&received)? {
            self.operator.receive(byte);
        }
        let now_ms = self.house.now_ms;
        if let Some(ack) = self.house.ack
            && now_ms >= self.busy_to_ms
        {
            let bytes = self.operator.transmit(now_ms, ack);
            self.busy_to_ms = now_ms + bytes.len() as u64 * 1000 / u64::from(BYTES_PER_S) + 1;
            self.queue.extend(bytes);
        }
        Ok(())
    }

    fn run_ms(&mut self, ms: u64) -> Result<(), String> {
        for _ in 0..ms {
            self.step()?;
        }
        Ok(())
    }

    /// Lets the robot do orders one after the other.
    fn order(&mut self, orders: impl IntoIterator<Item = Order>) -> Result<(), String> {
        for order in orders {
            self.operator.queue(Task::Order(order));
        }
        let end_ms = self.house.now_ms + TASKS_MS;
        while !self.operator.is_idle() {
            if self.house.now_ms > end_ms {
                return Err("the robot does not confirm its orders".to_owned());
            }
            self.step()?;
        }
        Ok(())
    }

    /// Power is lost and restored.
    fn lose_power(&mut self) -> Result<(), String> {
        self.house.emulator.lose_power()?;
        self.forget();
        Ok(())
    }

    /// Another boot needs another session, which the operator opens when it has heard of it.
    fn forget(&mut self) {
        self.operator = Operator::default();
        self.house.forget();
        self.queue.clear();
    }

    /// Touches the robot; an error unless a line tells.
    fn feel(&mut self, (what, hand, shows): Touch) -> Result<(), String> {
        self.house.hand = hand;
        let from = self.house.lines.len();
        self.run_ms(TOUCH_MS)?;
        self.house.hand = Hand::OFF;
        let told: Vec<StateLine> = (self.house.lines.iter().skip(from))
            .filter_map(|(_, line)| match &line.body {
                Body::State(state) => Some(*state),
                _ => None,
            })
            .collect();
        self.run_ms(TOUCH_MS)?;
        if told.iter().any(shows) {
            Ok(())
        } else {
            Err(format!("{what}: the robot tells {:?}", told.last()))
        }
    }

    /// Does the queued tasks; returns whether the chip is reset meanwhile, in a write of the EEPROM, the next one counted
    /// as 1.
    fn is_lost_in(&mut self, write: u16, loss: Loss) -> Result<bool, String> {
        let boots = self.house.sent.len();
        self.house.emulator.lose_in(write, loss)?;
        let end_ms = self.house.now_ms + TASKS_MS;
        let mut rest_ms = WRITES_MS;
        while rest_ms > 0 {
            self.step()?;
            if self.house.sent.len() > boots {
                self.forget();
                return Ok(true);
            }
            if self.operator.is_idle() {
                rest_ms -= 1;
            } else if self.house.now_ms > end_ms {
                return Err("the robot does not confirm its orders".to_owned());
            }
        }
        self.house.emulator.lose_in(0, loss)?;
        Ok(false)
    }

    /// Keeps another value of a parameter again and again. The chip is reset in a write, each time `later` ones later, up to
    /// the time that has fewer writes.
    fn keep(
        &mut self,
        kept: &mut i32,
        mut write: u16,
        later: u16,
        loss: Loss,
    ) -> Result<(), String> {
        loop {
            let value = if *kept == 5 { 9 } else { 5 };
            let set = Order::SetParameter {
                key: key(KEPT),
                value,
            };
            for order in [set, Order::KeepParameters] {
                self.operator.queue(Task::Order(order));
            }
            let is_lost = self.is_lost_in(write, loss)?;
            if !is_lost {
                self.lose_power()?;
            }
            while self.house.ack.is_none() {
                self.step()?;
            }
            let found = self.parameter(KEPT)?;
            if found != value && (found != *kept || !is_lost) {
                return Err(format!(
                    "{loss:?} lost in write {write}: {found}, not {kept} or {value}"
                ));
            }
            *kept = found;
            if !is_lost {
                return Ok(());
            }
            write += later;
        }
    }

    fn newest_boots(&self) -> Result<u16, String> {
        let told = self.house.bodies(|body| match body {
            Body::Status(status) => Some(status.boots),
            _ => None,
        });
        told.last().copied().ok_or("no line B".to_owned())
    }

    /// Value of a parameter that the robot tells.
    fn parameter(&mut self, name: &str) -> Result<i32, String> {
        let from = self.house.lines.len();
        self.order([Order::ReadParameter { key: key(name) }])?;
        for _ in 0..FIRST_LINES_MS {
            let told = self.house.lines.iter().skip(from);
            let mut values = told.filter_map(|(_, line)| match &line.body {
                Body::Parameter(parameter) if parameter.name.as_str() == name => {
                    Some(parameter.value)
                }
                _ => None,
            });
            if let Some(value) = values.next_back() {
                return Ok(value);
            }
            self.step()?;
        }
        Err(format!("no line P about {name}"))
    }
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

/// A touch and the state that the robot then tells.
type Touch = (&'static str, Hand, fn(&StateLine) -> bool);

const fn touch(on_sensors: fn(&mut Inputs)) -> Hand {
    Hand {
        on_sensors,
        ..Hand::OFF
    }
}

const LEFT: Sides = Sides {
    left: true,
    right: false,
};
const RIGHT: Sides = Sides {
    left: false,
    right: true,
};

/// Touches that the robot tells of in mode STOP.
#[rustfmt::skip]
const STANDING: [Touch; 18] = [
    ("left bumper", touch(|inputs| inputs.bumper.left = true), |state| state.bump == Bump::Left),
    ("centre bumper", touch(|inputs| inputs.bumper.center = true), |state| state.bump == Bump::Center),
    ("right bumper", touch(|inputs| inputs.bumper.right = true), |state| state.bump == Bump::Right),
    ("no floor ahead", touch(|inputs| inputs.cliff = Some(Edges::AHEAD)), |state| state.cliff == Cliff::Center),
    ("no floor on the left", touch(|inputs| inputs.cliff = Some(Edges::AHEAD_LEFT)), |state| state.cliff == Cliff::Left),
    ("no floor on the right", touch(|inputs| inputs.cliff = Some(Edges::AHEAD_RIGHT)), |state| state.cliff == Cliff::Right),
    ("left photocell", touch(|inputs| inputs.photo_left = Some(250)), |state| state.photo_left_pct > Some(90)),
    ("right photocell", touch(|inputs| inputs.photo_right = Some(250)), |state| state.photo_right_pct > Some(90)),
    ("no floor beside the left wheel", touch(|inputs| inputs.cliff = Some(Edges::BESIDE_LEFT)), |state| state.cliff == Cliff::Left),
    ("no floor beside the right wheel", touch(|inputs| inputs.cliff = Some(Edges::BESIDE_RIGHT)), |state| state.cliff == Cliff::Right),
    ("no floor behind", touch(|inputs| inputs.cliff = Some(Edges::BEHIND)), |state| state.cliff == Cliff::Several),
    ("no floor behind on the left", touch(|inputs| inputs.cliff = Some(Edges::BEHIND_LEFT)), |state| state.cliff == Cliff::Several),
    ("no floor behind on the right", touch(|inputs| inputs.cliff = Some(Edges::BEHIND_RIGHT)), |state| state.cliff == Cliff::Several),
    ("charger", touch(|inputs| inputs.is_docked = true), |state| matches!(state.power, Power::Charging | Power::Docked)),
    ("left wheel", Hand { turns: LEFT, ..Hand::OFF }, |state| state.wheel_left_in_s > 0 && state.wheel_right_in_s == 0),
    ("right wheel", Hand { turns: RIGHT, ..Hand::OFF }, |state| state.wheel_right_in_s > 0 && state.wheel_left_in_s == 0),
    ("left sonar", Hand::OFF, |state| state.sonar_left_in.is_some()),
    ("right sonar", Hand::OFF, |state| state.sonar_right_in.is_some()),
];

/// Touches that it tells of in mode prowl, and in mode passive when the detectors have settled.
#[rustfmt::skip]
const PROWLING: [Touch; 2] = [
    ("hand on the left", Hand { before: LEFT, ..Hand::OFF }, |state| state.infrared == Infrared::Left),
    ("hand on the right", Hand { before: RIGHT, ..Hand::OFF }, |state| state.infrared == Infrared::Right),
];
#[rustfmt::skip]
const ARMED: [Touch; 3] = [
    ("motion on the left", touch(|inputs| inputs.motion = Some(LEFT)), |state| state.arm == Arm::MotionLeft),
    ("motion on the right", touch(|inputs| inputs.motion = Some(RIGHT)), |state| state.arm == Arm::MotionRight),
    ("top hat", touch(|inputs| inputs.top_hat = true), |state| state.arm == Arm::TopHat),
];

/// Time after which a touch is told, and after which the detectors have settled.
const TOUCH_MS: u64 = 1500;
const SETTLED_MS: u64 = 40_000;

/// A hand at each sensor, as docs/mega.md tells: each is at its pin.
pub(crate) fn by_hand(programs: &Programs, seed: u64) -> Result<Figures, String> {
    let mut watched = Watched::start(programs, "open-room", seed)?;
    watched.run_ms(FIRST_LINES_MS)?;
    watched.operator.queue(Task::Stop);
    watched.run_ms(FIRST_LINES_MS)?;
    for touch in STANDING {
        watched.feel(touch)?;
    }
    watched.order([Order::Mode(Mode::Prowl)])?;
    for touch in PROWLING {
        watched.feel(touch)?;
    }
    lifted(&mut watched)?;
    for touch in ARMED {
        watched.order([Order::Mode(Mode::Passive)])?;
        watched.run_ms(SETTLED_MS)?;
        watched.feel(touch)?;
    }
    watched.house.finish()
}

/// In the hand, a robot's wheels stand until its cliff guard is off.
fn lifted(watched: &mut Watched) -> Result<(), String> {
    let from = watched.house.lines.len();
    watched.house.hand = touch(|inputs| inputs.cliff = Some(Edges::ALL));
    watched.run_ms(TOUCH_MS)?;
    for _ in 0..TOUCH_MS {
        watched.step()?;
        if watched.house.drives {
            return Err("lifted: the wheels turn".to_owned());
        }
    }
    let guard = |value| Order::SetParameter {
        key: key("cliff-guard"),
        value,
    };
    watched.order([guard(0)])?;
    watched.run_ms(TOUCH_MS)?;
    if !watched.house.drives {
        return Err("lifted without a cliff guard: the wheels stand".to_owned());
    }
    watched.order([guard(1)])?;
    watched.house.hand = Hand::OFF;
    watched.run_ms(TOUCH_MS)?;
    let mut told = watched.house.lines.iter().skip(from);
    let is_told = told.any(|(_, line)| match &line.body {
        Body::Text(text) => text.as_str().contains("no floor"),
        _ => false,
    });
    if is_told {
        Ok(())
    } else {
        Err("lifted: the robot does not say so".to_owned())
    }
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
