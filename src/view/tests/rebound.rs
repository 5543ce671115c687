//! Rebound keys: texts name only the chosen keys.

use std::collections::BTreeSet;
use std::sync::Arc;

use groundwave_protocol::status_codes::Power;

use super::every::{SIZES, STATES, State, typed};
use super::time::{flight_at, playback};
use super::*;
use crate::figures::Listed;
use crate::model::alarms::rules;
use crate::model::keys::{Keymap, Rebinding};
use crate::request::dashboard_listing;

/// First of the characters used as keys: one column each, and unused elsewhere on the screen.
const SYLLABLES: u32 = 0x1401;

/// A keymap with every key rebound.
fn all_otherwise() -> Keymap {
    let table = Keymap::default();
    let rebindings = table
        .manual()
        .zip(SYLLABLES..)
        .map(|([context, _, _, name, _], key)| {
            let key = char::from_u32(key).unwrap();
            Rebinding {
                context: context.into_owned(),
                name: name.into_owned(),
                keys: vec![key.to_string()],
            }
        });
    Keymap::with(&rebindings.collect::<Vec<_>>()).unwrap()
}

/// Labels of the default keys, except the fixed ones of STOP.
fn labels_of_the_table() -> BTreeSet<String> {
    let table = Keymap::default();
    let labels = table.rows().flat_map(|row| {
        let written = format!("{} {}", row.label, row.key_names());
        written.split(' ').map(str::to_owned).collect::<Vec<_>>()
    });
    let stops = ["", "Space", "Ctrl-S"];
    labels.filter(|label| !stops.contains(&&**label)).collect()
}

/// Texts that look like keys.
const NO_KEYS: [&str; 6] = [
    "L none",
    "R none",
    "x y leg",
    "line A,",
    "preset P ",
    " s, bumps",
];

/// The default keys named in a text: long labels anywhere; letters and signs only before a colon, in brackets or before their
/// meaning, not as a unit, an article or a figure.
fn keys_named(text: &str, labels: &BTreeSet<String>) -> Vec<String> {
    let mut named = Vec::new();
    for line in text.lines() {
        let line = line.split_whitespace().collect::<Vec<_>>().join(" ");
        let line = NO_KEYS
            .iter()
            .fold(line, |line, words| line.replace(words, " ~ "));
        named.extend(named_in(&line, labels));
    }
    named
}

fn named_in(line: &str, labels: &BTreeSet<String>) -> Vec<String> {
    let words: Vec<&str> = line.split_whitespace().collect();
    let does = |word: &&str| word.len() > 1 && word.starts_with(|c: char| c.is_ascii_lowercase());
    let mut named = Vec::new();
    for (at, &word) in words.iter().enumerate() {
        let key = match word.trim_matches(['(', ':', ';', ')', ',']) {
            "" => word,
            key => key,
        };
        let is_unit = at > 0 && words[at - 1].ends_with(|c: char| c.is_ascii_digit());
        let is_word = is_unit || word == "a" || key.parse::<u8>().is_ok();
        let stands = key != word || words.get(at + 1).is_some_and(does);
        if labels.contains(key) && (key.len() > 1 || stands && !is_word) {
            named.push(words[at.saturating_sub(1)..words.len().min(at + 3)].join(" "));
        }
    }
    named
}

type Make = fn(Config) -> Scene;

/// Screens without a snapshot, with their texts about keys.
const MORE: &[(&str, Make, &str)] = &[
    (
        "an empty list",
        |config| typed(config, "e"),
        "<route/route-append> adds one where the robot is, <route/route-ask-to-load> loads a file",
    ),
    (
        "nothing to delete",
        |config| typed(config, "ex"),
        "is empty: <route/route-append> adds a waypoint, <route/route-ask-to-load> loads",
    ),
    (
        "the keys of the editor",
        |config| typed(config, "e?"),
        "<route/route-step-left..> move one, or all",
    ),
    (
        "all of a list",
        |config| typed(config, "ewwg"),
        "<route/route-step-left..> move all of it (<route/route-whole>: only one)",
    ),
    ("zoomed", |config| typed(config, "+"), "<follow>: follow"),
    (
        "no draft yet",
        |config| typed(config, "S"),
        "move the cursor, press <add-waypoint>",
    ),
    (
        "the cursor",
        |config| typed(config, "w"),
        "<move-cursor-left..> move it, <add-waypoint> drafts a waypoint there",
    ),
    (
        "a route",
        |config| {
            let mut scene = flight(config);
            let (path, route) = ("tour.txt".to_owned(), Ok(vec![Waypoint::default()]));
            scene.event(Event::RouteLoaded { path, route });
            scene
        },
        "1 waypoint drafted; <send-draft> sends them",
    ),
    (
        "a file",
        |config| {
            let mut scene = typed(config, "ltour.txt");
            scene.press(&[KeyCode::Enter]);
            scene
        },
        "reading that file; <text/close> cancel",
    ),
    (
        "no key of driving",
        |config| typed(config, "dy#"),
        "<drive/push-ahead..> drive, <drive/stop> stops, <drive/leave-drive> lets go",
    ),
    (
        "driven",
        |config| {
            let mut scene = typed(config, "dy");
            scene.press(&[KeyCode::Esc]);
            scene
        },
        "<modes/mode-prowl> prowls, <modes/mode-go-home> goes home, <enter-drive> drives on",
    ),
    (
        "STOP in the past",
        |config| past(config, " "),
        "STOP is sent to the robot now; <playback-newest> shows",
    ),
    (
        "a command in the past",
        |config| past(config, "4y"),
        "it is sent to the robot now; <playback-newest> shows",
    ),
    (
        "nothing to name",
        |config| {
            let mut scene = Scene::new(config);
            scene.type_text(":name x");
            scene.press(&[KeyCode::Enter]);
            scene
        },
        "<toggle-recording> begins a recording",
    ),
    (
        "no runs",
        |config| {
            let mut scene = typed(config, ":runs runs");
            scene.press(&[KeyCode::Enter]);
            let none = Listed {
                runs: Vec::new(),
                ..(*listed()).clone()
            };
            scene.event(Event::Runs(Ok(Arc::new(none))));
            scene
        },
        "<toggle-recording> records one",
    ),
    (
        "letters that are somewhere",
        |config| {
            let mut scene = flight(config);
            scene.ctrl('p');
            scene.type_text("lysonar");
            scene
        },
        "No match. Closest (<palette/choose-less..> choose):",
    ),
    (
        "a question",
        |config| typed(config, "C"),
        "<question/confirm> yes   <question/close> no   <question/stop> STOP",
    ),
    (
        "the ladder",
        |config| flight(config),
        "<toggle-layer-sonar> △ sonar",
    ),
    (
        "alarms",
        low,
        "Send it home (<modes/mode-go-home>) and charge it",
    ),
    ("more than a page", low, "<turn-page-less> 1/2"),
];

fn low(config: Config) -> Scene {
    let mut scene = flight(config);
    scene.state.power = Power::Low;
    scene.hear();
    scene
}

fn past(config: Config, keys: &str) -> Scene {
    let mut scene = flight_at(config, |scene| playback(scene, true));
    scene.type_text(keys);
    scene
}

fn otherwise() -> Config {
    Config {
        keys: all_otherwise(),
        ..demo()
    }
}

#[test]
fn no_screen_names_a_key_that_was_rebound() {
    let labels = labels_of_the_table();
    let states = STATES.iter().map(|State { name, make, .. }| (*name, *make));
    let more = MORE.iter().map(|(name, make, _)| (*name, *make));
    let mut survivors = BTreeSet::new();
    for (name, make) in states.chain(more) {
        let (scene, before) = (make(otherwise()), make(demo()));
        for (width, height) in SIZES {
            let named = keys_named(&screen(&scene, width, height), &labels);
            survivors.extend(named.into_iter().map(|key| format!("{name}: {key}")));
            let seen = keys_named(&screen(&before, width, height), &labels);
            assert!(!seen.is_empty(), "{name}: with the keys of the table");
        }
    }
    assert!(survivors.is_empty(), "{survivors:#?}");
}

#[test]
fn texts_name_the_chosen_keys() {
    for (name, make, says) in MORE {
        for config in [demo(), otherwise()] {
            let scene = make(config);
            let words = scene.model.ui.with_keys(says);
            let shown = SIZES.map(|(width, height)| screen(&scene, width, height));
            let is_said = shown.iter().any(|shown| shown.contains(&words));
            assert!(is_said, "{name}: `{words}`\n{}", shown[2]);
        }
    }
}

#[test]
fn remedies_and_commands_name_existing_keys() {
    let labels = labels_of_the_table();
    let rules = rules(&crate::model::Limits::default(), &[]);
    let hints = rules.iter().map(|rule| &*rule.hint);
    let hints = hints.chain([crate::model::alarms::DISK_IS_SILENT]);
    let listing = dashboard_listing().map(|(_, does)| does);
    for text in hints.chain(listing) {
        let told = Keymap::default().with_keys(text);
        assert!(!told.contains('<'), "{told}");
        let told = all_otherwise().with_keys(text);
        assert_eq!(keys_named(&told, &labels), [""; 0], "{told}");
    }
}

/// The default keys with one action of the dashboard rebound.
fn but(name: &str, keys: &[&str]) -> Config {
    let rebinding = Rebinding {
        context: "dashboard".to_owned(),
        name: name.to_owned(),
        keys: keys.iter().map(|&key| key.to_owned()).collect(),
    };
    Config {
        keys: Keymap::with(&[rebinding]).unwrap(),
        ..demo()
    }
}

#[test]
fn a_small_screen_names_the_stop_key() {
    let small = |config| screen(&Scene::new(config), 60, 15);
    assert!(small(but("stop", &["F12"])).contains("F12: STOP"));
    assert!(small(demo()).contains("Space: STOP"));
}

#[test]
fn an_action_without_a_key_is_not_offered() {
    let shown = screen(&flight(but("ask-mode", &[])), 200, 60);
    assert!(!shown.contains("mode "), "{shown}");
}

#[test]
fn several_keys_are_apart_from_their_meaning() {
    let help = screen(&typed(but("stop", &["F12"]), "?"), 80, 24);
    row(&help, " F12 Space Ctrl-S STOP ");
    let help = screen(&typed(but("scan", &["F10", "F11", "F12"]), "?"), 120, 40);
    row(&help, "F10 F11 F12 look around");
}
