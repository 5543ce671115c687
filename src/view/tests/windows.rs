//! Keys while a window is open: the prompt opens from each, and only a shown key sends to the robot.

use crossterm::event::{KeyEvent, KeyModifiers};
use proptest::prelude::*;
use proptest::sample::select;

use super::*;
use crate::model::Overlay;
use crate::model::keys::{Action, Context};

/// The keys that open each window from the dashboard.
const WINDOWS: [(Context, &[&str]); 13] = [
    (Context::Route, &["e"]),
    (Context::Drive, &["dy"]),
    (Context::Text, &[":", "g", "/", "r"]),
    (Context::Question, &["d", "C", "1", "O"]),
    (Context::Help, &["?", "e?"]),
    (Context::Palette, &["\u{10}"]),
    (Context::Modes, &["m"]),
    (Context::Jump, &["n", "N"]),
    (Context::Trace, &["i"]),
    (Context::Why, &["y"]),
    (Context::Runs, &[":runs\n", ":compare a b\n"]),
    (Context::Search, &["/bumper\n"]),
    (Context::Parameters, &["P"]),
];

fn windows() -> impl Iterator<Item = (Context, &'static str)> {
    let each = |(context, opened): (Context, &'static [&'static str])| {
        opened.iter().map(move |typed| (context, *typed))
    };
    WINDOWS.into_iter().flat_map(each)
}

/// A robot with a draft of a route, under a window.
fn under(typed: &str) -> Scene {
    let mut scene = flight(demo());
    scene.hear_parameter("cliff-guard", 1);
    scene.type_text("w");
    scene.press(&[KeyCode::Esc]);
    for c in typed.chars() {
        match c {
            '\n' => scene.press(&[KeyCode::Enter]),
            '\u{10}' => scene.ctrl('p'),
            _ => scene.type_text(&c.to_string()),
        };
    }
    if typed.contains("runs") {
        scene.event(Event::Runs(Ok(listed())));
    }
    if typed.contains("compare") {
        scene.event(Event::Overlaid(Ok(overlaid())));
    }
    scene
}

fn keys() -> Vec<KeyEvent> {
    let printable = (' '..='~').map(|c| (KeyCode::Char(c), KeyModifiers::NONE));
    let control = ('a'..='z').map(|c| (KeyCode::Char(c), KeyModifiers::CONTROL));
    let others = [
        KeyCode::Enter,
        KeyCode::Esc,
        KeyCode::Tab,
        KeyCode::BackTab,
        KeyCode::Backspace,
        KeyCode::Delete,
        KeyCode::Insert,
        KeyCode::Home,
        KeyCode::End,
        KeyCode::PageUp,
        KeyCode::PageDown,
    ];
    let arrows = [KeyCode::Up, KeyCode::Down, KeyCode::Left, KeyCode::Right];
    let others = others.into_iter().chain((1..=12).map(KeyCode::F));
    let held = [KeyModifiers::NONE, KeyModifiers::SHIFT];
    let arrows = arrows
        .into_iter()
        .flat_map(|code| held.map(|held| (code, held)));
    let others = others.map(|code| (code, KeyModifiers::NONE));
    let keys = printable.chain(control).chain(others).chain(arrows);
    keys.map(|(code, held)| KeyEvent::new(code, held)).collect()
}

/// Whether an effect reaches the robot; the end of a drive only stops it.
fn reaches_the_robot(effect: &Effect) -> bool {
    matches!(
        effect,
        Effect::Send(_) | Effect::Drive { .. } | Effect::CancelCommands
    )
}

#[test]
fn every_window_is_tried() {
    for context in Context::ALL {
        let opened = windows().filter(|(window, _)| *window == context).count();
        assert_eq!(opened == 0, context == Context::Dashboard, "{context:?}");
    }
    for (context, typed) in windows() {
        assert_eq!(under(typed).model.ui.context(), context, "{typed:?}");
    }
}

/// An alias, such as `h j k l` for the arrows, counts as shown if the key before it in the table is shown.
#[test]
fn under_a_window_only_stop_and_shown_keys_reach_the_robot() {
    for (context, typed) in windows() {
        let scene = under(typed);
        let shown = screen(&scene, 80, 24);
        let keymap = &scene.model.ui.config.keys;
        for key in keys() {
            let mut model = scene.model.clone();
            let effects = model.update(scene.now, Event::Key(key));
            let action = keymap.action(context, key);
            if action == Some(Action::Stop) {
                assert_eq!(effects.len(), 1, "{key:?} under {typed:?}");
                assert!(effects.contains(&Effect::Send(Request::Stop)));
            } else if effects.iter().any(reaches_the_robot) {
                let rows: Vec<_> = keymap.rows().filter(|row| row.context == context).collect();
                let at = rows.iter().position(|row| Some(row.action) == action);
                let at = at.unwrap_or_else(|| panic!("{key:?} acts through {typed:?}"));
                let named = rows[..=at].iter().rfind(|row| !row.footer.is_empty());
                let named = named.unwrap_or_else(|| panic!("{key:?} is not shown by {typed:?}"));
                let words = format!("{} {}", named.labels, named.footer);
                assert!(shown.contains(&words), "{words} under {typed:?}:\n{shown}");
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_command_typed_over_a_window_is_a_command(
        (context, typed) in select(windows().collect::<Vec<_>>()),
        command in "[ -~]{0,40}",
    ) {
        let mut scene = under(typed);
        for c in format!(":{command}").chars() {
            let effects = scene.event(Event::Key(KeyCode::Char(c).into()));
            prop_assert!(!effects.iter().any(reaches_the_robot), "{:?}", effects);
        }
        let typed = match context {
            Context::Text | Context::Palette => format!(":{command}"),
            _ => command,
        };
        match &scene.model.ui.overlay {
            Overlay::Text(entry) => prop_assert_eq!(&entry.text, &typed),
            Overlay::Palette(palette) => prop_assert_eq!(&palette.text, &typed),
            other => prop_assert!(false, "{:?}", other),
        }
    }
}

#[test]
fn the_prompt_over_hand_drive_lets_go() {
    let mut scene = under("dy");
    scene.press(&[KeyCode::Up]);
    let effects = scene.type_text(":");
    assert!(effects.contains(&Effect::DriveEnd), "{effects:?}");
    assert_eq!(scene.model.ui.context(), Context::Text);
}
