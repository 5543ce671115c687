//! Descriptions of single keys that share a line of the help.

use groundwave_protocol::status_codes::Mode;

use super::{Action, RouteAction, notation};
use crate::model::text_entry::Caret;
use crate::playback::Control;
use crate::request::layer_word;

/// The description of a single key; `None` if the help has one.
pub(super) fn alone(action: Action) -> Option<String> {
    let words = match action {
        Action::Mode(mode) => return mode_words(mode).map(str::to_owned),
        Action::ToggleLayer(layer) => {
            format!("allow or forbid layer {}", layer_word(layer))
        }
        Action::MoveCursor { east, north } => {
            format!("move the cursor {}", way(east.into(), north.into()))
        }
        Action::Pan { east, north } => {
            format!("look further {}", way(east.into(), north.into()))
        }
        Action::Zoom(steps) => pick(steps, "zoom in", "zoom out"),
        Action::Show(panel) => {
            format!(
                "the panel {}; again: enlarge it",
                notation::action_name(panel)
            )
        }
        Action::TurnPage(steps) => pick(steps, "the next page", "the previous page"),
        Action::Playback(Control::Step { forward }) => {
            format!("one line {}", if forward { "forward" } else { "back" })
        }
        Action::Playback(Control::Newest) => "to the present, or to the end".to_owned(),
        Action::Speed(steps) => pick(steps, "faster", "slower"),
        Action::AskJump { forward } => {
            let which = if forward { "after" } else { "before" };
            format!("the alarm, bump, behaviour change, command or mark {which} this")
        }
        Action::JumpAgain { forward } => {
            let which = if forward { "after" } else { "before" };
            format!("the one {which} this of the same kind")
        }
        Action::Route(route) => return alone_in_route(route),
        Action::Push { ahead, right } => match (ahead, right) {
            (1.., _) => "hold to drive ahead".to_owned(),
            (..=-1, _) => "hold to drive back".to_owned(),
            _ => format!("hold to turn {}", way(right.into(), 0)),
        },
        Action::Faster(steps) => pick(steps, "drive faster", "drive slower"),
        Action::Choose(steps) => pick(steps, "choose the one below", "choose the one above"),
        Action::NextValue(steps) => pick(steps, "the next value", "the previous value"),
        Action::NextLine(steps) => {
            pick(steps, "the next kind of line", "the previous kind of line")
        }
        Action::Find(steps) => pick(steps, "an older line", "a newer line"),
        Action::EraseCharacter => "erase a character".to_owned(),
        Action::EraseAll => "erase everything".to_owned(),
        Action::ReadParameters => "read all from the robot".to_owned(),
        Action::SaveParameters => "keep them after a reset".to_owned(),
        Action::DefaultParameter => "change to the default".to_owned(),
        Action::WriteParameters => "save them in a file".to_owned(),
        Action::LoadParameters => "set those that differ from a file".to_owned(),
        Action::CompareParameters => "compare with a file".to_owned(),
        Action::Complete => "complete the word".to_owned(),
        Action::Recall(steps) => pick(steps, "the next typed line", "the previous typed line"),
        Action::Caret(Caret::Left) => "one character back".to_owned(),
        Action::Caret(Caret::Right) => "one character forward".to_owned(),
        Action::Playback(Control::Oldest) | Action::Caret(Caret::Start) => {
            "to the beginning".to_owned()
        }
        Action::Caret(Caret::End) => "to the end".to_owned(),
        _ => return None,
    };
    Some(words)
}

const fn mode_words(mode: Mode) -> Option<&'static str> {
    Some(match mode {
        Mode::Prowl => "prowl: move about, drive the route",
        Mode::GoHome => "home: back to the origin",
        Mode::Wander => "wander for a while, then home",
        Mode::Reactive => "reactive: wait to be pulled",
        Mode::Passive => "passive: hide and wait",
        Mode::Forage => "dock: charge the battery",
        Mode::Stop | Mode::User | Mode::Calibrate => return None,
    })
}

fn alone_in_route(action: RouteAction) -> Option<String> {
    let words = match action {
        RouteAction::Step { east, north, fine } => {
            let step_in = if fine { 1 } else { 6 };
            format!(
                "move the waypoint {step_in} in {}",
                way(east.into(), north.into())
            )
        }
        RouteAction::Select(1..) => "the next waypoint".to_owned(),
        RouteAction::Select(_) => "the previous waypoint".to_owned(),
        RouteAction::Rotate(deg) => {
            let way = if deg > 0 {
                "clockwise"
            } else {
                "counter-clockwise"
            };
            let degrees = if deg.abs() == 1 { "degree" } else { "degrees" };
            format!("turn the route by {} {degrees} {way}", deg.abs())
        }
        RouteAction::Scale(steps) => pick(steps, "make the route larger", "make the route smaller"),
        _ => return None,
    };
    Some(words)
}

fn pick(steps: impl Into<i32>, more: &str, less: &str) -> String {
    if steps.into() > 0 { more } else { less }.to_owned()
}

/// Name of a direction on the screen.
fn way(east: i32, north: i32) -> &'static str {
    match (east, north) {
        (1.., _) => "right",
        (..=-1, _) => "left",
        (_, 1..) => "up",
        _ => "down",
    }
}
