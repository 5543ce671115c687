//! A hand at each sensor of the emulated board.

use groundwave_protocol::command::Order;
use groundwave_protocol::parameter::key;
use groundwave_protocol::status_codes::{Arm, Bump, Cliff, Infrared, Mode, Power};
use groundwave_protocol::telemetry::{Body, StateLine};
use sr04_firmware::board::{Edges, Inputs, Sides};

use super::checks::Programs;
use super::house::Hand;
use super::watched::{FIRST_LINES_MS, Watched};
use crate::chip::Figures;
use crate::operator::Task;

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

/// Touches the robot; an error unless a line tells.
fn feel(watched: &mut Watched, (what, hand, shows): Touch) -> Result<(), String> {
    watched.house.hand = hand;
    let from = watched.house.lines.len();
    watched.run_ms(TOUCH_MS)?;
    watched.house.hand = Hand::OFF;
    let told: Vec<StateLine> = (watched.house.lines.iter().skip(from))
        .filter_map(|(_, line)| match &line.body {
            Body::State(state) => Some(*state),
            _ => None,
        })
        .collect();
    watched.run_ms(TOUCH_MS)?;
    if told.iter().any(shows) {
        Ok(())
    } else {
        Err(format!("{what}: the robot tells {:?}", told.last()))
    }
}

/// A hand at each sensor, as docs/mega.md tells: each is at its pin.
pub(crate) fn by_hand(programs: &Programs, seed: u64) -> Result<Figures, String> {
    let mut watched = Watched::start(programs, "open-room", seed)?;
    watched.run_ms(FIRST_LINES_MS)?;
    watched.operator.queue(Task::Stop);
    watched.run_ms(FIRST_LINES_MS)?;
    for touch in STANDING {
        feel(&mut watched, touch)?;
    }
    watched.order([Order::Mode(Mode::Prowl)])?;
    for touch in PROWLING {
        feel(&mut watched, touch)?;
    }
    lifted(&mut watched)?;
    for touch in ARMED {
        watched.order([Order::Mode(Mode::Passive)])?;
        watched.run_ms(SETTLED_MS)?;
        feel(&mut watched, touch)?;
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
