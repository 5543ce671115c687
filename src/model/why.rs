//! The reason why a holder controls the motors, as text, from the robot's reports.

use std::cmp::Ordering;

use groundwave_protocol::status_codes::{
    Arm, Bump, Cliff, Drive, Infrared, Layer, LayerState, Mode,
};
use groundwave_protocol::telemetry::{ListPlace, StateLine};

use super::motors::{Holder, lacks_floor};
use super::robot::{Robot, detects, is_held, ordered_wheels_in_s, touches};
use super::words;
use crate::event::Moment;

/// Range of both sonars below which the sonar layer stops and turns, inches.
const SONAR_CLOSE_IN: u16 = 30;

/// Time for which a contact explains the bumper layer.
const CONTACT_EXPLAINS: Moment = Moment::from_secs(20);

/// The reason why a holder controls the motors, as text.
pub(crate) fn why(holder: Holder, state: &StateLine, robot: &Robot, now: Moment) -> String {
    match holder {
        Holder::Layer(Layer::User) => by_hand(state),
        Holder::Layer(Layer::Bumpers) => bumpers(state, robot, now),
        Holder::Layer(Layer::Rotation) => format!("looks around, {}", turning(state)),
        Holder::Layer(Layer::Infrared) => infrared(state, robot),
        Holder::Layer(Layer::Sonar) => sonar(state),
        Holder::Layer(Layer::Photo) => photo(state),
        Holder::Layer(Layer::Motion) => arm(state.arm).to_owned(),
        Holder::Layer(Layer::DeadReckoning) => route(state.mode, robot),
        Holder::Prowl => prowl(state, robot),
        Holder::CliffGuard => no_floor(state),
        Holder::ArmGuard => "stands until the arm is down".to_owned(),
        Holder::NoLayer => no_layer(state.mode).to_owned(),
    }
}

/// The readings that a layer acts on, as text.
pub(crate) fn reads(layer: Layer, state: &StateLine, robot: &Robot) -> String {
    let dark = |percent: Option<u8>| percent.map_or("none".to_owned(), |v| format!("{v} %"));
    match layer {
        Layer::User if state.mode == Mode::User => by_hand(state),
        Layer::User => "no one drives by hand".to_owned(),
        Layer::Bumpers => match bump(state.bump) {
            "free" => "no contact".to_owned(),
            touched => touched.to_owned(),
        },
        Layer::Rotation => "turns on request".to_owned(),
        Layer::Infrared => words::infrared(state.infrared).to_owned(),
        Layer::Sonar => {
            let (left, right) = (range(state.sonar_left_in), range(state.sonar_right_in));
            format!("{left} left, {right} right")
        }
        Layer::Photo => {
            let (left, right) = (dark(state.photo_left_pct), dark(state.photo_right_pct));
            format!("dark {left} left, {right} right")
        }
        Layer::Motion => format!("arm {}", arm(state.arm)),
        Layer::DeadReckoning => match robot.status.map(|status| status.value) {
            Some(status) if status.target_in.is_none() && status.list.count == 0 => {
                "no route, no target".to_owned()
            }
            _ => route(state.mode, robot),
        },
    }
}

fn by_hand(state: &StateLine) -> String {
    match (state.velocity_in_s, state.rotation_in_s) {
        (0, 0) => "by hand, standing".to_owned(),
        (0, _) => format!("by hand, {} on the spot", turning(state)),
        (velocity_in_s, _) => format!("by hand at {velocity_in_s:+} in/s, {}", turning(state)),
    }
}

fn turning(state: &StateLine) -> &'static str {
    match state.rotation_in_s {
        0 => "straight",
        1.. => "turning right",
        _ => "turning left",
    }
}

fn moving(state: &StateLine) -> &'static str {
    match (state.velocity_in_s, state.rotation_in_s) {
        (..0, 0) => "backs off",
        (..0, 1..) => "backs off to the right",
        (..0, _) => "backs off to the left",
        (_, 1..) => "turns right",
        (_, ..0) => "turns left",
        (0, 0) => "stands",
        (1.., 0) => "moves on",
    }
}

fn bumpers(state: &StateLine, robot: &Robot, now: Moment) -> String {
    if state.bump == Bump::Jammed {
        return "bumper held down: twisting free".to_owned();
    }
    if touches(state.bump) {
        return format!("{} hit; {}", bump(state.bump), moving(state));
    }
    match robot.bump.filter(|last| last.age(now) < CONTACT_EXPLAINS) {
        Some(last) => format!("{} after {} hit", moving(state), bump(last.value)),
        None => moving(state).to_owned(),
    }
}

/// The bumper's state as text.
pub(crate) const fn bump(bump: Bump) -> &'static str {
    match bump {
        Bump::None => "free",
        Bump::Left => "left bumper",
        Bump::Center => "centre bumper",
        Bump::Right => "right bumper",
        Bump::LeftCenter => "left and centre bumper",
        Bump::RightCenter => "right and centre bumper",
        Bump::Sides => "both sides of the bumper",
        Bump::All => "whole bumper",
        Bump::Jammed => "bumper jammed",
        Bump::NotFitted => "not fitted",
    }
}

fn infrared(state: &StateLine, robot: &Robot) -> String {
    let seen = if detects(state.infrared) {
        Some(state.infrared)
    } else {
        robot.infrared.map(|last| last.value)
    };
    match seen.and_then(near) {
        Some(near) => format!("{near}; {}", moving(state)),
        None => moving(state).to_owned(),
    }
}

/// What the infrared detectors report as text; `None` without an object.
const fn near(infrared: Infrared) -> Option<&'static str> {
    match infrared {
        Infrared::Left => Some("something near on the left"),
        Infrared::Right => Some("something near on the right"),
        Infrared::Both => Some("something near ahead"),
        Infrared::None | Infrared::Jammed | Infrared::NotFitted => None,
    }
}

fn sonar(state: &StateLine) -> String {
    match (state.sonar_left_in, state.sonar_right_in) {
        (Some(left), Some(right)) if left < SONAR_CLOSE_IN && right < SONAR_CLOSE_IN => {
            format!("{left} in left, {right} in right: too close, turns on the spot")
        }
        (left, right) => {
            // A side without an echo is the clearest.
            let clear = |range: Option<u16>| range.unwrap_or(u16::MAX);
            let side = match (clear(left).cmp(&clear(right)), state.rotation_in_s) {
                // At a corner the robot turns to the side that it has not looked to, whatever it sees.
                (Ordering::Greater, 1..) => "looks for a way on the right",
                (Ordering::Less, ..0) => "looks for a way on the left",
                (Ordering::Greater, _) => "left is clearer",
                (Ordering::Less, _) => "right is clearer",
                (Ordering::Equal, _) => "both sides alike",
            };
            format!("{side} ({} left, {} right)", range(left), range(right))
        }
    }
}

/// A range as text.
pub(crate) fn range(range_in: Option<u16>) -> String {
    range_in.map_or_else(|| "no echo".to_owned(), |range_in| format!("{range_in} in"))
}

fn photo(state: &StateLine) -> String {
    let side = match (state.photo_left_pct, state.photo_right_pct) {
        (Some(left), Some(right)) if left < right => "brighter on the left",
        (Some(left), Some(right)) if left > right => "brighter on the right",
        _ => "light",
    };
    format!("{side}; {}", moving(state))
}

/// The arm's state as text.
pub(crate) const fn arm(arm: Arm) -> &'static str {
    match arm {
        Arm::Stowed => "stowed",
        Arm::Up => "up, detectors settling",
        Arm::Armed => "armed, waits for motion",
        Arm::MotionLeft => "motion on the left",
        Arm::MotionRight => "motion on the right",
        Arm::MotionBoth => "motion ahead",
        Arm::TopHat => "something above the arm",
        Arm::NotFitted => "not fitted",
    }
}

fn route(mode: Mode, robot: &Robot) -> String {
    let Some(status) = robot.status.map(|status| status.value) else {
        return "drives its route".to_owned();
    };
    let ListPlace { driven, count } = status.list;
    match status.target_in {
        Some((0, 0)) if mode == Mode::GoHome => "heads for home".to_owned(),
        Some((x_in, y_in)) if count == 0 => format!("heads for ({x_in}, {y_in})"),
        Some((x_in, y_in)) => format!("heads for ({x_in}, {y_in}), {driven} of {count} reached"),
        None if count > 0 && driven == count => "has finished its route".to_owned(),
        None => "drives its route".to_owned(),
    }
}

fn prowl(state: &StateLine, robot: &Robot) -> String {
    let target = robot.status.and_then(|status| status.value.target_in);
    match (target, state.drive) {
        _ if lacks_floor(state) => format!("{}, and nothing guards", edge(state.cliff)),
        _ if touches(state.bump) => format!("{} pressed; {}", bump(state.bump), wheels(state)),
        (_, Drive::Stalled) => "the wheels do not turn".to_owned(),
        _ if is_held(state) => format!("held back; {}", wheels(state)),
        (Some((0, 0)), _) if state.mode == Mode::GoHome => {
            format!("on the way home; {} in to go", distance_in(state, (0, 0)))
        }
        (Some(target), _) => format!(
            "to ({}, {}); {} in to go",
            target.0,
            target.1,
            distance_in(state, target)
        ),
        (None, _) => match blind(state, robot)[..] {
            [] => near(state.infrared)
                .unwrap_or("nothing in the way")
                .to_owned(),
            ref layers => format!("drives without {}", layers.join(", ")),
        },
    }
}

fn wheels(state: &StateLine) -> String {
    let [left, right] = ordered_wheels_in_s(state);
    format!(
        "wheels at {} of {left}, {} of {right} in/s",
        state.wheel_left_in_s, state.wheel_right_in_s
    )
}

/// Names of the fitted layers and guards against obstacles that are off or jammed.
fn blind(state: &StateLine, robot: &Robot) -> Vec<&'static str> {
    let is_off = |layer: &Layer| {
        let is_jammed = *layer == Layer::Infrared && state.infrared == Infrared::Jammed;
        is_jammed
            || state.layers.get(*layer) == LayerState::Off && !robot.lacks(*layer)
            || robot.forbids(*layer)
    };
    let layers = [Layer::Bumpers, Layer::Infrared, Layer::Sonar];
    let layers = layers.into_iter().filter(is_off).map(words::layer);
    let guard = robot.is_unguarded().then_some("cliff guard");
    layers.chain(guard).collect()
}

fn no_floor(state: &StateLine) -> String {
    format!("{}; {}", edge(state.cliff), moving(state))
}

/// The edge sensors' state as text.
const fn edge(cliff: Cliff) -> &'static str {
    match cliff {
        Cliff::Left => "no floor on the left",
        Cliff::Center => "no floor ahead",
        Cliff::Right => "no floor on the right",
        Cliff::Several => "no floor on several sides",
        Cliff::None | Cliff::NotFitted => "floor",
    }
}

fn distance_in(state: &StateLine, (x_in, y_in): (i16, i16)) -> i32 {
    let dx = f64::from(x_in) - f64::from(state.x_tenths_in) / 10.0;
    let dy = f64::from(y_in) - f64::from(state.y_tenths_in) / 10.0;
    dx.hypot(dy).round() as i32
}

const fn no_layer(mode: Mode) -> &'static str {
    match mode {
        Mode::Stop => "stopped",
        Mode::Reactive => "at rest: nothing pulls",
        Mode::Passive => "hides and waits for motion",
        _ => "at rest",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use groundwave_protocol::decoder::{Decoder, Received};
    use groundwave_protocol::telemetry::Body;

    /// The reason never names the side from which the robot turns away.
    #[test]
    fn sonar_names_the_side_to_which_it_turns() {
        let mut turns = 0;
        for name in [
            "house-clean.txt",
            "house-noisy.txt",
            "living-room-bursts.txt",
        ] {
            let bytes = std::fs::read(groundwave_captures::samples().join(name)).unwrap();
            for received in Decoder::default().lines(&bytes) {
                let Received::Line(line, _) = received else {
                    continue;
                };
                let Body::State(state) = line.body else {
                    continue;
                };
                if Holder::of(&state) != Holder::Layer(Layer::Sonar) || state.rotation_in_s == 0 {
                    continue;
                }
                let why = sonar(&state);
                let names = |side: &str| {
                    why.starts_with(&format!("{side} is"))
                        || why.contains(&format!("on the {side}"))
                };
                let (to, from) = if state.rotation_in_s > 0 {
                    ("right", "left")
                } else {
                    ("left", "right")
                };
                assert!(!names(from), "{why}: turns {to}");
                turns += u32::from(names(to));
            }
        }
        assert!(turns > 50, "{turns}");
    }
}
