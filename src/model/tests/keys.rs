//! What keys, typed words and dialogs want done.

use super::*;
use crate::event::SaveProblem;
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
        assert_eq!(scene.model.overlay, Overlay::None, "after `{keys}`");
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
        scene.model.config.keys = keys.clone();
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
    assert_eq!(scene.model.overlay, Overlay::None);
}

#[test]
fn nobody_drives_over_a_link_that_only_receives() {
    let mut scene = scene();
    scene.event(Event::Link(LinkEvent::Opened {
        name: "radio".to_owned(),
        can_send: false,
    }));
    assert_eq!(scene.type_text("d"), []);
    assert_eq!(scene.model.overlay, Overlay::None);
}

#[test]
fn a_layer_key_asks_for_the_opposite_of_what_was_asked_or_reported() {
    let mut scene = scene();
    let sonar = LayerMask::NONE.with(Layer::Sonar);
    let disable = Request::Disable(sonar);
    assert_eq!(scene.type_text("4"), [Effect::Send(disable.clone())]);
    scene.event(Event::Command {
        id: CommandId(1),
        step: CommandStep::Queued(disable),
    });
    assert_eq!(
        scene.type_text("4"),
        [Effect::Send(Request::Enable(sonar))],
        "asked, not yet answered"
    );
    assert_eq!(scene.type_text("5"), [], "photo is not fitted");
    let mut unheard = Scene::new(Config::default());
    assert_eq!(unheard.type_text("4"), [], "nobody knows what is allowed");
}

#[test]
fn a_route_is_drafted_on_the_map_and_sent() {
    let mut scene = scene();
    scene.press(&[KeyCode::Up, KeyCode::Up]);
    scene.type_text("w");
    scene.press(&[KeyCode::Right, KeyCode::Enter, KeyCode::Right]);
    scene.type_text("wu");
    assert_eq!(
        scene.model.chart.draft.waypoints(),
        route(&[(0, 12), (6, 12)])
    );
    let sent = Request::Route(route(&[(0, 12), (6, 12)]));
    assert_eq!(scene.type_text("S"), [Effect::Send(sent.clone())]);
    assert!(scene.model.chart.draft.waypoints().is_empty());
    assert_eq!(scene.type_text("S"), [], "nothing is left to send");
    scene.command(1, sent, CommandStep::Failed(Failure::TimedOut));
    assert_eq!(
        scene.model.chart.draft.waypoints(),
        route(&[(0, 12), (6, 12)]),
        "what did not arrive can be sent again"
    );
}

#[test]
fn a_draft_never_outgrows_the_robots_list() {
    let mut scene = scene();
    scene.press(&[KeyCode::Up]);
    for _ in 0..WAYPOINTS_MAX + 5 {
        scene.type_text("w");
    }
    assert_eq!(scene.model.chart.draft.waypoints().len(), WAYPOINTS_MAX);
    assert_eq!(scene.type_text("S").len(), 1);
}

#[test]
fn a_route_file_is_read_by_somebody_else() {
    for keys in ["l tour.txt ", ":route tour.txt"] {
        let mut scene = scene();
        scene.type_text(keys);
        assert_eq!(
            scene.press(&[KeyCode::Enter]),
            [Effect::LoadRoute("tour.txt".to_owned())]
        );
        let waypoints = route(&[(48, 0), (48, 48)]);
        scene.event(Event::RouteLoaded {
            path: "tour.txt".to_owned(),
            route: Ok(waypoints.clone()),
        });
        assert_eq!(scene.model.chart.draft.waypoints(), waypoints);
        scene.event(Event::RouteLoaded {
            path: "tour.txt".to_owned(),
            route: Err("tour.txt:2:1: `x` is not a whole number".to_owned()),
        });
        assert_eq!(
            scene.model.chart.draft.waypoints(),
            waypoints,
            "the draft stays"
        );
        let newest = scene.model.log.newest_first().next().expect("a log entry");
        assert!(newest.text.starts_with("tour.txt:2:1"));
    }
}

/// What is wrong with a name can be mended where it was typed.
#[test]
fn a_prompt_for_a_file_stays_until_the_file_is_right() {
    for keys in ["ltuor.txt", ":route tuor.txt"] {
        let mut scene = scene();
        scene.type_text(keys);
        scene.press(&[KeyCode::Enter]);
        scene.event(Event::RouteLoaded {
            path: "tuor.txt".to_owned(),
            route: Err("cannot read tuor.txt: no such file".to_owned()),
        });
        let Overlay::Text(entry) = &scene.model.overlay else {
            panic!("{keys}: {:?}", scene.model.overlay);
        };
        assert!(entry.text.ends_with("tuor.txt"));
        assert_eq!(
            entry.error.as_deref(),
            Some("cannot read tuor.txt: no such file")
        );
        scene.press(&[KeyCode::Backspace; 8]);
        scene.type_text("tour.txt");
        scene.press(&[KeyCode::Enter]);
        scene.event(Event::RouteLoaded {
            path: "tour.txt".to_owned(),
            route: Ok(route(&[(48, 0)])),
        });
        assert_eq!(scene.model.overlay, Overlay::None, "{keys}");
    }
    let mut scene = scene();
    scene.type_text("w");
    scene.type_text("wes/nowhere/a.txt");
    scene.press(&[KeyCode::Enter]);
    let (path, saved) = (
        "/nowhere/a.txt".to_owned(),
        Err(SaveProblem::Failed("no such folder".to_owned())),
    );
    scene.event(Event::RouteSaved { path, saved });
    let Overlay::Text(entry) = &scene.model.overlay else {
        panic!("{:?}", scene.model.overlay);
    };
    assert_eq!(entry.error.as_deref(), Some("no such folder"));
    // Whoever has gone on to something else is not called back.
    scene.press(&[KeyCode::Esc]);
    scene.event(Event::RouteSaved {
        path: "a.txt".to_owned(),
        saved: Ok(()),
    });
    assert_eq!(scene.model.overlay, Overlay::None);
}

#[test]
fn a_point_is_gone_to_at_once_when_that_is_typed() {
    let mut scene = scene();
    scene.type_text(":goto 48 -36 --go");
    let list = Request::Route(route(&[(48, -36)]));
    assert_eq!(
        scene.press(&[KeyCode::Enter]),
        [Effect::Send(list), Effect::Send(Request::Mode(Mode::Prowl))]
    );
}

#[test]
fn typed_words_are_those_of_the_command_line() {
    let mut scene = scene();
    scene.type_text(":goto 48 -36");
    let goto = Request::Route(route(&[(48, -36)]));
    assert_eq!(scene.press(&[KeyCode::Enter]), [Effect::Send(goto)]);
    scene.type_text(":mode prawl");
    assert_eq!(scene.press(&[KeyCode::Enter]), []);
    let Overlay::Text(entry) = &scene.model.overlay else {
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
    let Overlay::Text(entry) = &scene.model.overlay else {
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
        ("P", Mode::Passive),
        ("W", Mode::Wander),
        ("h", Mode::GoHome),
        ("D", Mode::Forage),
    ] {
        let wanted = Effect::Send(Request::Mode(mode));
        assert_eq!(scene().type_text(key), [wanted], "{key}");
    }
}

#[test]
fn the_question_of_the_origin_names_the_dock() {
    let mut scene = scene();
    scene.type_text("O");
    let Overlay::Question(question) = &scene.model.overlay else {
        panic!("it asks");
    };
    assert!(question.text.contains("looks for its dock from there"));
}

#[test]
fn a_route_is_edited_in_a_list_undone_and_sent() {
    let mut scene = scene();
    scene.type_text("ewww");
    let three = scene.model.chart.draft.waypoints().to_vec();
    assert_eq!(three.len(), 3);
    scene.press(&[KeyCode::Right]);
    assert_eq!(
        scene.model.chart.draft.waypoints()[2].x_in,
        three[2].x_in + 6
    );
    scene.type_text("L");
    assert_eq!(
        scene.model.chart.draft.waypoints()[2].x_in,
        three[2].x_in + 7
    );
    scene.type_text("uu");
    assert_eq!(scene.model.chart.draft.waypoints(), three);
    scene.ctrl('r');
    assert_eq!(
        scene.model.chart.draft.waypoints()[2].x_in,
        three[2].x_in + 6
    );
    scene.type_text("ug");
    scene.press(&[KeyCode::Up]);
    let shifted: Vec<i16> = scene
        .model
        .chart
        .draft
        .waypoints()
        .iter()
        .map(|w| w.y_in)
        .collect();
    let wanted: Vec<i16> = three.iter().map(|w| w.y_in + 6).collect();
    assert_eq!(shifted, wanted, "all of it");
    let draft = scene.model.chart.draft.waypoints().to_vec();
    assert_eq!(scene.type_text("S"), [Effect::Send(Request::Route(draft))]);
    assert!(
        scene.model.editor.is_none(),
        "what is sent is no draft any more"
    );
    scene.type_text("e");
    assert_eq!(
        scene.type_text(" "),
        [Effect::Send(Request::Stop)],
        "STOP from here too"
    );
}

#[test]
fn a_draft_is_saved_and_nothing_is_overwritten_unasked() {
    let mut scene = scene();
    scene.type_text("ew");
    let text = crate::route::format(scene.model.chart.draft.waypoints());
    scene.type_text("stour.txt");
    let save = |overwrite| Effect::SaveRoute {
        path: "tour.txt".to_owned(),
        text: text.clone(),
        overwrite,
    };
    assert_eq!(scene.press(&[KeyCode::Enter]), [save(false)]);
    scene.event(Event::RouteSaved {
        path: "tour.txt".to_owned(),
        saved: Err(SaveProblem::Exists),
    });
    assert_eq!(scene.type_text("y"), [save(true)]);
    scene.event(Event::RouteSaved {
        path: "tour.txt".to_owned(),
        saved: Ok(()),
    });
    let newest = scene.model.log.newest_first().next().expect("a log entry");
    assert_eq!(newest.text, "tour.txt: 1 waypoints saved");
    assert!(scene.model.editor.is_some(), "back in the editor");
}

/// Nobody answers a question or drives where there is no room to show it.
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
        assert!(scene.model.chart.draft.waypoints().is_empty());
        assert_eq!(scene.type_text(" "), [STOP], "after `{keys}`");
        scene.event(Event::Resize {
            width: 80,
            height: 24,
        });
        assert_eq!(scene.model.overlay, Overlay::None, "after `{keys}`");
    }
}

#[test]
fn a_pasted_route_is_a_draft_and_what_is_none_says_so() {
    let mut scene = scene();
    for text in ["10,20\n30,40\n# end\n", "10,20\r30,40\r", "10,20\r\n30,40"] {
        scene.event(Event::Paste(text.to_owned()));
        let wanted = route(&[(10, 20), (30, 40)]);
        assert_eq!(scene.model.chart.draft.waypoints(), wanted, "{text:?}");
        scene.type_text("u");
    }
    scene.event(Event::Paste("milk\n".to_owned()));
    let newest = scene.model.log.newest_first().next().expect("a log entry");
    assert!(newest.text.starts_with("pasted:1:1"), "{}", newest.text);
}

/// A slow line hands Esc and the key behind it over at once, which terminals take for Alt with the key. Esc counts
/// everywhere, STOP too, and nothing else: Alt may have been meant.
#[test]
fn of_esc_and_a_key_in_one_burst_esc_and_stop_count() {
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
        for typed in ["", ":runs", ":mode wander", "?", "l"] {
            let mut scene = scene();
            scene.type_text(typed);
            assert_eq!(scene.event(alt(code)), wanted, "{code:?} after {typed:?}");
            assert_eq!(
                scene.model.overlay,
                Overlay::None,
                "{code:?} after {typed:?}"
            );
        }
        let mut scene = scene();
        scene.type_text(":runs");
        scene.press(&[KeyCode::Enter]);
        scene.event(Event::Runs(Ok(listed())));
        assert_eq!(scene.event(alt(code)), wanted, "{code:?} over the runs");
        assert_eq!(scene.model.overlay, Overlay::None);
    }
}

#[test]
fn the_screen_is_drawn_anew_wherever_the_operator_is() {
    let ctrl = |c| Event::Key(KeyEvent::new(KeyCode::Char(c), KeyModifiers::CONTROL));
    for typed in ["", "?", "e", ":mode", "y", "d"] {
        let mut scene = scene();
        scene.type_text(typed);
        assert_eq!(scene.event(ctrl('l')), [Effect::Redraw], "after {typed:?}");
        assert_eq!(scene.event(ctrl('z')), [Effect::Suspend], "after {typed:?}");
    }
}
