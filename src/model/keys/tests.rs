//! Properties of the default table.

use super::*;
use crossterm::event::KeyEvent;

fn action(context: Context, key: KeyEvent) -> Option<Action> {
    Keymap::default().action(context, key)
}

#[test]
fn no_key_means_two_things_in_one_context() {
    for (n, a) in TABLE.iter().enumerate() {
        for b in TABLE[n + 1..].iter().filter(|b| b.context == a.context) {
            let shared = a.keys.iter().find(|key| b.keys.contains(key));
            assert_eq!(shared, None, "{} and {}", a.help, b.help);
        }
    }
}

#[test]
fn stop_is_one_key_from_anywhere() {
    let stop = KeyEvent::new(KeyCode::Char('s'), KeyModifiers::CONTROL);
    for context in Context::ALL {
        assert_eq!(action(context, stop), Some(Action::Stop), "{context:?}");
    }
    let space = KeyEvent::new(KeyCode::Char(' '), KeyModifiers::NONE);
    for context in [Dashboard, Drive, Question, Help, Jump, Route, Trace, Why] {
        assert_eq!(action(context, space), Some(Action::Stop), "{context:?}");
        let held = KeyEvent::new(space.code, KeyModifiers::CONTROL);
        assert_eq!(action(context, held), Some(Action::Stop), "{context:?}");
    }
}

#[test]
fn every_key_of_the_dashboard_is_in_the_help() {
    let mut told = "";
    for binding in TABLE.iter().filter(|binding| binding.context == Dashboard) {
        if !binding.help.is_empty() {
            told = binding.help;
        }
        assert!(!told.is_empty(), "{}", binding.label);
    }
}
