//! Effects of keys, typed words and dialogs.

use std::sync::Arc;

use super::*;
use groundwave_protocol::telemetry::{AbilitiesLine, Body};

use crate::model::Colors;
use crate::model::keys::{Keymap, Rebinding};

#[test]
fn stop_never_asks_and_works_under_everything() {
    for (keys, stop) in [
        ("", ' '),
        ("?", ' '),
        ("d", ' '),
        ("dy", ' '),
        ("C", ' '),
        (":goto 4", 's'),
        ("lroute", 's'),
    ] {
        let mut scene = scene();
        scene.type_text(keys);
        let effects = match stop {
            's' => scene.ctrl('s'),
            key => scene.type_text(&key.to_string()),
        };
        assert_eq!(effects, [STOP], "after `{keys}`");
        assert_eq!(scene.model.ui.overlay, Overlay::None, "after `{keys}`");
    }
}

#[test]
fn a_key_chosen_for_stop_works_under_everything() {
    let stop = Rebinding {
        context: "dashboard".to_owned(),
        name: "stop".to_owned(),
        keys: vec!["F12".to_owned()],
    };
    let keys = Keymap::with(&[stop]).unwrap();
    for typed in [
        "", "?", "d", "dy", "C", ":goto 4", "lroute", "e", "i", "y", "n", ":runs\n",
    ] {
        let mut scene = scene();
        Arc::make_mut(&mut scene.model.ui.config).keys = keys.clone();
        scene.type_text(typed.trim_end());
        if typed.ends_with('\n') {
            scene.press(&[KeyCode::Enter]);
        }
        assert_eq!(scene.press(&[KeyCode::F(12)]), [STOP], "after `{typed}`");
    }
}

#[test]
fn hazardous_commands_ask_first() {
    for (keys, wanted) in [
        ("C", Request::Route(Vec::new())),
        ("d", Request::Mode(Mode::User)),
        (
            "O",
            Request::Pose {
                position: Waypoint::default(),
                theta_deg: 0,
            },
        ),
        (
            ":set-pose 1 2 90\n",
            Request::Pose {
                position: Waypoint { x_in: 1, y_in: 2 },
                theta_deg: 90,
            },
        ),
        (":clear\n", Request::Route(Vec::new())),
        (":mode user\n", Request::Mode(Mode::User)),
    ] {
        let mut scene = scene();
        let typed = |scene: &mut Scene| {
            let mut effects = scene.type_text(keys.trim_end());
            if keys.ends_with('\n') {
                effects.extend(scene.press(&[KeyCode::Enter]));
            }
            effects
        };
        assert_eq!(typed(&mut scene), [], "{keys}");
        assert_eq!(scene.type_text("n"), [], "{keys}");
        assert_eq!(typed(&mut scene), [], "{keys}");
        assert_eq!(scene.type_text("y"), [Effect::Send(wanted)], "{keys}");
    }
}

#[test]
fn a_held_arrow_drives_and_letting_go_stops() {
    let mut scene = scene();
    scene.type_text("dy");
    let ahead = Effect::Drive {
        velocity_in_s: 8,
        rotation_in_s: 0,
    };
    assert_eq!(scene.press(&[KeyCode::Up]), [ahead]);
    let due = scene.model.poll_timeout().expect("a lease runs");
    scene.now = due;
    assert_eq!(scene.event(Event::Tick), [Effect::DriveEnd]);
    assert_eq!(scene.model.poll_timeout(), None);

    scene.press(&[KeyCode::Left]);
    let release = KeyEvent::new_with_kind(KeyCode::Left, KeyModifiers::NONE, KeyEventKind::Release);
    assert_eq!(scene.event(Event::Key(release)), [Effect::DriveEnd]);

    scene.press(&[KeyCode::Up]);
    assert_eq!(scene.press(&[KeyCode::Esc]), [Effect::DriveEnd]);
    assert_eq!(scene.model.ui.overlay, Overlay::None);
}

#[test]
fn receive_only_link_refuses_hand_driving() {
    let mut scene = scene();
    scene.event(Event::Link(LinkEvent::Opened {
        name: "radio".to_owned(),
        can_send: false,
    }));
    assert_eq!(scene.type_text("d"), []);
    assert_eq!(scene.model.ui.overlay, Overlay::None);
}

#[test]
fn a_robot_below_level_4_is_not_driven() {
    let mut scene = scene();
    scene.hear_line(Body::Abilities(AbilitiesLine {
        level: 3,
        ..AbilitiesLine::FULL
    }));
    assert_eq!(scene.type_text("d"), []);
    assert_eq!(scene.model.ui.overlay, Overlay::None);
    let aside = scene.model.ui.aside.as_ref();
    assert!(aside.is_some_and(|(_, text)| text.contains("needs level 4, the robot has level 3")));
}

#[test]
fn a_layer_key_asks_for_the_opposite_of_what_was_asked_or_reported() {
    let mut scene = scene();
    let sonar = LayerMask::NONE.with(Layer::Sonar);
    let disable = Request::Disable(sonar);
    assert_eq!(scene.type_text("4"), [Effect::Send(disable.clone())]);
    scene.ask(1, disable);
    assert_eq!(
        scene.type_text("4"),
        [Effect::Send(Request::Enable(sonar))],
        "asked, not yet answered"
    );
    scene.hear_status();
    scene.status_of(1, CommandStatus::Confirmed { digest: None });
    assert_eq!(
        scene.type_text("4"),
        [Effect::Send(Request::Enable(sonar))],
        "confirmed, and no line B since"
    );
    scene.ask(2, Request::Enable(sonar));
    scene.status_of(2, CommandStatus::Confirmed { digest: None });
    let disable = [Effect::Send(Request::Disable(sonar))];
    assert_eq!(scene.type_text("4"), disable, "the newest command counts");
    scene.wait_ms(100);
    scene.hear_status();
    assert_eq!(scene.type_text("4"), disable, "line B is newer");
    assert_eq!(scene.type_text("5"), [], "photo is not fitted");
    let mut unheard = Scene::new(Config::default());
    assert_eq!(unheard.type_text("4"), [], "the allowed layers are unknown");
}

#[test]
fn turning_a_protection_off_asks_first() {
    for keys in [
        "1",
        ":disable bumpers,sonar",
        ":only sonar",
        ":param set cliff-guard 0",
        ":param battery-critical 0",
        ":failsafe off",
    ] {
        let mut scene = scene();
        let mut effects = scene.type_text(keys);
        if keys.starts_with(':') {
            effects.extend(scene.press(&[KeyCode::Enter]));
        }
        assert_eq!(effects, [], "{keys}");
        let Overlay::Question(question) = &scene.model.ui.overlay else {
            panic!("{keys}: no question");
        };
        assert!(
            question.text.contains("This turns its "),
            "{}",
            question.text
        );
        let sent = scene.type_text("y");
        assert!(matches!(sent[..], [Effect::Send(_)]), "{keys}: {sent:?}");
    }
}

#[test]
fn typed_words_are_those_of_the_command_line() {
    let mut scene = scene();
    scene.type_text(":goto 48 -36");
    let goto = Request::Route(route(&[(48, -36)]));
    assert_eq!(scene.press(&[KeyCode::Enter]), [Effect::Send(goto)]);
    scene.type_text(":mode prawl");
    assert_eq!(scene.press(&[KeyCode::Enter]), []);
    let Overlay::Text(entry) = &scene.model.ui.overlay else {
        panic!("the text stays to be mended");
    };
    assert!(entry.error.as_ref().is_some_and(|e| e.contains("prawl")));
    scene.press(&[KeyCode::Backspace; 3]);
    scene.event(Event::Paste("owl\nstop".to_owned()));
    assert_eq!(
        scene.press(&[KeyCode::Enter]),
        [Effect::Send(Request::Mode(Mode::Prowl))],
        "one line of what was pasted"
    );
    scene.type_text(":route");
    scene.press(&[KeyCode::Enter]);
    let Overlay::Text(entry) = &scene.model.ui.overlay else {
        panic!("the text stays to be mended");
    };
    assert!(
        entry
            .error
            .as_ref()
            .is_some_and(|e| e.starts_with("`route` takes"))
    );
}

#[test]
fn every_mode_that_is_asked_for_often_has_a_key() {
    for (key, mode) in [
        ("p", Mode::Prowl),
        ("r", Mode::Reactive),
        ("s", Mode::Passive),
        ("w", Mode::Wander),
        ("h", Mode::GoHome),
        ("d", Mode::Forage),
    ] {
        let mut scene = scene();
        assert_eq!(scene.type_text("m"), [], "the menu alone moves nothing");
        let wanted = Effect::Send(Request::Mode(mode));
        assert_eq!(scene.type_text(key), [wanted], "{key}");
        assert_eq!(scene.model.ui.overlay, Overlay::None);
    }
    let mut scene = scene();
    scene.type_text("mx");
    assert_eq!(scene.model.ui.overlay, Overlay::Modes, "x is no mode");
    assert_eq!(scene.type_text(" "), [Effect::Send(Request::Stop)]);
}

#[test]
fn the_question_of_the_origin_names_the_dock() {
    let mut scene = scene();
    scene.type_text("O");
    let Overlay::Question(question) = &scene.model.ui.overlay else {
        panic!("it asks");
    };
    assert!(question.text.contains("looks for its dock from there"));
}

/// On a screen that is too small, there are no questions and no hand drive.
#[test]
fn on_a_screen_too_small_only_stop_and_leaving_work() {
    for keys in ["", ":go", "C", "dy", "e", "?"] {
        let mut scene = scene();
        scene.type_text(keys);
        scene.event(Event::Resize {
            width: 60,
            height: 15,
        });
        assert_eq!(scene.type_text("yw"), [], "after `{keys}`");
        assert_eq!(
            scene.press(&[KeyCode::Up, KeyCode::Enter]),
            [],
            "after `{keys}`"
        );
        scene.event(Event::Paste("1,2".to_owned()));
        assert!(scene.model.ui.map.draft.waypoints().is_empty());
        assert_eq!(scene.type_text(" "), [STOP], "after `{keys}`");
        scene.event(Event::Resize {
            width: 80,
            height: 24,
        });
        assert_eq!(scene.model.ui.overlay, Overlay::None, "after `{keys}`");
    }
}

/// Over a slow connection, Esc and the next key may arrive together, which reads as Alt and the key. Esc always counts;
/// of the second key only STOP counts, because the operator may have pressed Alt.
#[test]
fn esc_and_a_key_in_one_burst_act_as_esc_and_stop() {
    let alt = |code| Event::Key(KeyEvent::new(code, KeyModifiers::ALT));
    let stop = [Effect::Send(Request::Stop)];
    for code in [
        KeyCode::Char('p'),
        KeyCode::Char('D'),
        KeyCode::Enter,
        KeyCode::Backspace,
        KeyCode::Char(' '),
    ] {
        let wanted = if code == KeyCode::Char(' ') {
            &stop[..]
        } else {
            &[]
        };
        for typed in ["", ":runs", ":mode wander", "?", "r"] {
            let mut scene = scene();
            scene.type_text(typed);
            assert_eq!(scene.event(alt(code)), wanted, "{code:?} after {typed:?}");
            assert_eq!(
                scene.model.ui.overlay,
                Overlay::None,
                "{code:?} after {typed:?}"
            );
        }
        let mut scene = scene();
        scene.type_text(":runs");
        scene.press(&[KeyCode::Enter]);
        scene.event(Event::Runs(Ok(listed())));
        assert_eq!(scene.event(alt(code)), wanted, "{code:?} over the runs");
        assert_eq!(scene.model.ui.overlay, Overlay::None);
    }
}

#[test]
fn redraw_works_in_every_context() {
    let ctrl = |c| Event::Key(KeyEvent::new(KeyCode::Char(c), KeyModifiers::CONTROL));
    for typed in ["", "?", "e", ":mode", "y", "d"] {
        let mut scene = scene();
        scene.type_text(typed);
        assert_eq!(scene.event(ctrl('l')), [Effect::Redraw], "after {typed:?}");
        assert_eq!(scene.event(ctrl('z')), [Effect::Suspend], "after {typed:?}");
    }
}

/// The prompt has the editing keys of a shell.
#[test]
fn prompt_text_is_edited_at_the_caret_and_recalled() {
    let mut scene = scene();
    let enter = |scene: &mut Scene| scene.press(&[KeyCode::Enter]);
    scene.type_text(":gto 48 0");
    scene.press(&[KeyCode::Home, KeyCode::Right]);
    scene.type_text("o");
    let goto = Request::Route(vec![Waypoint { x_in: 48, y_in: 0 }]);
    assert_eq!(enter(&mut scene), [Effect::Send(goto.clone())]);
    scene.type_text(":sc");
    scene.press(&[KeyCode::Up]);
    assert_eq!(enter(&mut scene), [Effect::Send(goto)]);
    scene.type_text(":sc");
    scene.press(&[KeyCode::Up, KeyCode::Down]);
    scene.type_text("an");
    assert_eq!(enter(&mut scene), [Effect::Send(Request::Scan)]);
}

#[test]
fn pasted_tabs_separate_words() {
    let mut scene = scene();
    scene.type_text(":");
    scene.event(Event::Paste("\n \ngoto\t48\t0\nscan\n".to_owned()));
    let goto = Request::Route(vec![Waypoint { x_in: 48, y_in: 0 }]);
    assert_eq!(scene.press(&[KeyCode::Enter]), [Effect::Send(goto)]);
}

/// Tests the example in the printed configuration.
#[test]
fn rebound_stop_takes_no_key_from_a_prompt() {
    let stop = Rebinding {
        context: "dashboard".to_owned(),
        name: "stop".to_owned(),
        keys: ["F12", "Ctrl-B"].map(str::to_owned).to_vec(),
    };
    Keymap::with(&[stop]).unwrap();
}

#[test]
fn every_overlay_can_be_closed() {
    for (context, name) in [
        ("help-screen", "close"),
        ("text", "close"),
        ("drive", "leave-drive"),
    ] {
        let none = Rebinding {
            context: context.to_owned(),
            name: name.to_owned(),
            keys: Vec::new(),
        };
        let mistakes = Keymap::with(&[none]).unwrap_err();
        assert!(mistakes[0].message.contains("lead out of"), "{mistakes:?}");
    }
}

#[test]
fn a_key_steps_through_the_themes() {
    let mut scene = scene();
    let colors = |scene: &Scene| scene.model.ui.config.colors;
    let begin = colors(&scene);
    let mut seen = vec![begin];
    loop {
        scene.ctrl('t');
        if colors(&scene) == begin {
            break;
        }
        seen.push(colors(&scene));
    }
    let all = [
        Colors::Dark,
        Colors::Light,
        Colors::HighContrast,
        Colors::Mono,
    ];
    assert_eq!(seen, all);
}
