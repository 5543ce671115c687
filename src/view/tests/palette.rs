//! The command palette, and the effects of a choice.

use crossterm::event::KeyCode;
use groundwave_protocol::status_codes::Mode;

use super::time::{flight_at, playback};
use super::{Scene, demo, flight, row, screen};
use crate::event::{Effect, Event};
use crate::request::Request;

#[test]
fn a_few_letters_find_a_command_and_enter_runs_it() {
    let mut scene = flight(demo());
    scene.ctrl('p');
    for (width, height) in [(80, 24), (120, 40), (200, 60)] {
        let all = screen(&scene, width, height);
        row(&all, "╭ commands ─");
        row(&all, "STOP (Ctrl-S while typing)");
    }
    scene.type_text("go home");
    let found = screen(&scene, 80, 24);
    row(&found, "▶ home: back to the origin");
    row(&found, "Ctrl-S STOP");
    let effects = scene.press(&[KeyCode::Enter]);
    let home = Effect::Send(Request::Mode(Mode::GoHome));
    assert_eq!(effects, [home]);
    scene.ctrl('p');
    scene.type_text("failsa");
    scene.press(&[KeyCode::Enter]);
    row(&screen(&scene, 80, 24), ":failsafe ▏");
}

#[test]
fn commands_of_the_route_editor_run_in_it() {
    let mut scene = flight(demo());
    let draft = |scene: &Scene| scene.model.ui.map.draft.waypoints().to_vec();
    scene.event(Event::Paste("0,0\n12,24\n".to_owned()));
    let before = draft(&scene);
    scene.ctrl('p');
    scene.type_text("mirr");
    row(&screen(&scene, 80, 24), "▶ route: mirror it, east for west");
    assert_eq!(scene.press(&[KeyCode::Enter]), []);
    assert_ne!(draft(&scene), before);
    row(&screen(&scene, 80, 24), "route: 2, ");
    scene.press(&[KeyCode::Esc]);
    scene.ctrl('p');
    scene.type_text("save");
    scene.press(&[KeyCode::Enter]);
    row(&screen(&scene, 80, 24), "save as: ▏");
}

/// Other matches are shown, but the operator must choose one.
#[test]
fn only_a_match_at_the_start_is_preselected() {
    for typed in ["lysonar", "ound"] {
        let mut scene = flight(demo());
        scene.ctrl('p');
        scene.type_text(typed);
        let found = screen(&scene, 80, 24);
        row(&found, "No match. Closest (arrows choose):");
        assert!(!found.contains("▶ "), "{typed}\n{found}");
        assert_eq!(scene.press(&[KeyCode::Enter]), [], "{typed}");
        row(&screen(&scene, 80, 24), "╭ commands ─");
        scene.press(&[KeyCode::Down]);
        row(&screen(&scene, 80, 24), "│ ▶ ");
        assert_eq!(scene.press(&[KeyCode::Enter]).len(), 1, "{typed}");
    }
}

#[test]
fn declining_to_send_from_the_past_keeps_the_draft() {
    let mut scene = flight_at(demo(), |scene| playback(scene, true));
    scene.event(Event::Paste("0,0\n12,0\n".to_owned()));
    scene.ctrl('p');
    scene.type_text("send the draft");
    assert_eq!(scene.press(&[KeyCode::Enter]), []);
    row(&screen(&scene, 80, 24), "to the robot as it is now?");
    scene.type_text("n");
    assert_eq!(scene.model.ui.map.draft.waypoints().len(), 2);
}
