//! Routes: drafted, loaded, edited, saved, sent.

use super::*;
use crate::event::{FileKind, SaveProblem};

#[test]
fn a_route_is_drafted_on_the_map_and_sent() {
    let mut scene = scene();
    scene.press(&[KeyCode::Up, KeyCode::Up]);
    scene.type_text("w");
    scene.press(&[KeyCode::Right, KeyCode::Enter, KeyCode::Right]);
    scene.type_text("wu");
    assert_eq!(
        scene.model.ui.map.draft.waypoints(),
        route(&[(0, 12), (6, 12)])
    );
    let sent = Request::Route(route(&[(0, 12), (6, 12)]));
    assert_eq!(scene.type_text("S"), [Effect::Send(sent.clone())]);
    assert!(scene.model.ui.map.draft.waypoints().is_empty());
    assert_eq!(scene.type_text("S"), [], "nothing is left to send");
    scene.command(1, sent, CommandStatus::Failed(Failure::TimedOut));
    assert_eq!(
        scene.model.ui.map.draft.waypoints(),
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
    assert_eq!(scene.model.ui.map.draft.waypoints().len(), WAYPOINTS_MAX);
    assert_eq!(scene.type_text("S").len(), 1);
}

#[test]
fn route_file_is_read_by_an_effect() {
    for keys in ["r tour.txt ", ":route tour.txt"] {
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
        assert_eq!(scene.model.ui.map.draft.waypoints(), waypoints);
        scene.event(Event::RouteLoaded {
            path: "tour.txt".to_owned(),
            route: Err("tour.txt:2:1: `x` is not a whole number".to_owned()),
        });
        assert_eq!(
            scene.model.ui.map.draft.waypoints(),
            waypoints,
            "the draft stays"
        );
        let newest = scene
            .model
            .facts
            .log
            .newest_first()
            .next()
            .expect("a log entry");
        assert!(newest.text.starts_with("tour.txt:2:1"));
    }
}

#[test]
fn a_route_is_driven_at_once_when_that_is_typed() {
    let waypoints = route(&[(48, 0), (48, 48)]);
    let loaded = |waypoints: &[Waypoint]| Event::RouteLoaded {
        path: "my tour.txt".to_owned(),
        route: Ok(waypoints.to_vec()),
    };
    let driven = [
        Effect::Send(Request::Route(waypoints.clone())),
        Effect::Send(Request::Mode(Mode::Prowl)),
    ];
    for typed in [":route my tour.txt --go", ":route  'my tour.txt'  --go "] {
        let mut scene = scene();
        scene.type_text(typed);
        let asked = scene.press(&[KeyCode::Enter]);
        assert_eq!(
            asked,
            [Effect::LoadRoute("my tour.txt".to_owned())],
            "{typed}"
        );
        assert_eq!(scene.event(loaded(&waypoints)), driven, "{typed}");
        assert_eq!(scene.model.ui.overlay, Overlay::None);
        assert!(scene.model.ui.map.draft.waypoints().is_empty());
    }
    // A closed prompt still makes the route the draft, but sends nothing.
    let mut scene = scene();
    scene.type_text(":route my tour.txt --go");
    scene.press(&[KeyCode::Enter, KeyCode::Esc]);
    assert_eq!(scene.event(loaded(&waypoints)), []);
    assert_eq!(scene.model.ui.map.draft.waypoints(), waypoints);
    // A file name may end like this.
    scene.type_text(":route 'tour --go'");
    let asked = scene.press(&[KeyCode::Enter]);
    assert_eq!(asked, [Effect::LoadRoute("tour --go".to_owned())]);
}

#[test]
fn points_typed_for_a_file_get_the_remedy() {
    let mut scene = scene();
    scene.type_text(":route 40,20 60,40 --go");
    assert_eq!(scene.press(&[KeyCode::Enter]), []);
    let Overlay::Text(entry) = &scene.model.ui.overlay else {
        panic!("{:?}", scene.model.ui.overlay);
    };
    let error = entry.error.as_deref().unwrap_or_default();
    assert!(error.contains("a file with X,Y in each line"), "{error}");
}

/// A wrong file name can be corrected in the prompt.
#[test]
fn a_prompt_for_a_file_stays_until_the_file_is_right() {
    for keys in ["rtuor.txt", ":route tuor.txt"] {
        let mut scene = scene();
        scene.type_text(keys);
        scene.press(&[KeyCode::Enter]);
        scene.event(Event::RouteLoaded {
            path: "tuor.txt".to_owned(),
            route: Err("cannot read tuor.txt: no such file".to_owned()),
        });
        let Overlay::Text(entry) = &scene.model.ui.overlay else {
            panic!("{keys}: {:?}", scene.model.ui.overlay);
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
        assert_eq!(scene.model.ui.overlay, Overlay::None, "{keys}");
    }
    let mut scene = scene();
    scene.type_text("w");
    scene.type_text("wes/nowhere/a.txt");
    scene.press(&[KeyCode::Enter]);
    let (path, saved) = (
        "/nowhere/a.txt".to_owned(),
        Err(SaveProblem::Failed("no such folder".to_owned())),
    );
    scene.event(Event::Saved {
        kind: FileKind::Route,
        path,
        saved,
    });
    let Overlay::Text(entry) = &scene.model.ui.overlay else {
        panic!("{:?}", scene.model.ui.overlay);
    };
    assert_eq!(entry.error.as_deref(), Some("no such folder"));
    // Another overlay stays open.
    scene.press(&[KeyCode::Esc]);
    scene.event(Event::Saved {
        kind: FileKind::Route,
        path: "a.txt".to_owned(),
        saved: Ok(()),
    });
    assert_eq!(scene.model.ui.overlay, Overlay::None);
}

#[test]
fn a_typed_point_is_approached_at_once() {
    let mut scene = scene();
    scene.type_text(":goto 48 -36 --go");
    let list = Request::Route(route(&[(48, -36)]));
    assert_eq!(
        scene.press(&[KeyCode::Enter]),
        [Effect::Send(list), Effect::Send(Request::Mode(Mode::Prowl))]
    );
}

#[test]
fn a_route_is_edited_in_a_list_undone_and_sent() {
    let mut scene = scene();
    scene.type_text("ewww");
    let three = scene.model.ui.map.draft.waypoints().to_vec();
    assert_eq!(three.len(), 3);
    scene.press(&[KeyCode::Right]);
    assert_eq!(
        scene.model.ui.map.draft.waypoints()[2].x_in,
        three[2].x_in + 6
    );
    scene.type_text("L");
    assert_eq!(
        scene.model.ui.map.draft.waypoints()[2].x_in,
        three[2].x_in + 7
    );
    scene.type_text("uu");
    assert_eq!(scene.model.ui.map.draft.waypoints(), three);
    scene.ctrl('r');
    assert_eq!(
        scene.model.ui.map.draft.waypoints()[2].x_in,
        three[2].x_in + 6
    );
    scene.type_text("ug");
    scene.press(&[KeyCode::Up]);
    let shifted: Vec<i16> = scene
        .model
        .ui
        .map
        .draft
        .waypoints()
        .iter()
        .map(|w| w.y_in)
        .collect();
    let wanted: Vec<i16> = three.iter().map(|w| w.y_in + 6).collect();
    assert_eq!(shifted, wanted, "all of it");
    let draft = scene.model.ui.map.draft.waypoints().to_vec();
    assert_eq!(scene.type_text("S"), [Effect::Send(Request::Route(draft))]);
    assert!(
        scene.model.ui.editor.is_none(),
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
    let text = crate::route::format(scene.model.ui.map.draft.waypoints());
    scene.type_text("stour.txt");
    let save = |overwrite| Effect::Save {
        kind: FileKind::Route,
        path: "tour.txt".to_owned(),
        text: text.clone(),
        overwrite,
    };
    assert_eq!(scene.press(&[KeyCode::Enter]), [save(false)]);
    scene.event(Event::Saved {
        kind: FileKind::Route,
        path: "tour.txt".to_owned(),
        saved: Err(SaveProblem::Exists),
    });
    assert_eq!(scene.type_text("y"), [save(true)]);
    scene.event(Event::Saved {
        kind: FileKind::Route,
        path: "tour.txt".to_owned(),
        saved: Ok(()),
    });
    let newest = scene
        .model
        .facts
        .log
        .newest_first()
        .next()
        .expect("a log entry");
    assert_eq!(newest.text, "tour.txt: 1 waypoint saved");
    assert!(scene.model.ui.editor.is_some(), "back in the editor");
}

#[test]
fn pasted_route_is_drafted_and_other_text_refused() {
    let mut scene = scene();
    for text in ["10,20\n30,40\n# end\n", "10,20\r30,40\r", "10,20\r\n30,40"] {
        scene.event(Event::Paste(text.to_owned()));
        let wanted = route(&[(10, 20), (30, 40)]);
        assert_eq!(scene.model.ui.map.draft.waypoints(), wanted, "{text:?}");
        scene.type_text("u");
    }
    scene.event(Event::Paste("milk\n".to_owned()));
    let newest = scene
        .model
        .facts
        .log
        .newest_first()
        .next()
        .expect("a log entry");
    assert!(newest.text.starts_with("pasted:1:1"), "{}", newest.text);
}

/// A declined command in the past keeps the draft, and so does a command in a capture, which has no robot.
#[test]
fn declined_draft_stays() {
    for is_live in [true, false] {
        for typed in ["S", "eS", ":route tour.txt --go\n"] {
            let mut scene = scene();
            scene.show_moment(Some(playback(is_live)));
            let waypoints = route(&[(48, 0), (48, 48)]);
            let loaded = Event::RouteLoaded {
                path: "tour.txt".to_owned(),
                route: Ok(waypoints.clone()),
            };
            if !typed.starts_with(':') {
                scene.event(loaded.clone());
            }
            scene.type_text(typed.trim_end());
            if typed.starts_with(':') {
                scene.press(&[KeyCode::Enter]);
                assert_eq!(scene.event(loaded), [], "{typed}");
            }
            let asks = matches!(scene.model.ui.overlay, Overlay::Question(_));
            assert_eq!(asks, is_live, "{typed}");
            scene.type_text(if asks { "n" } else { "" });
            assert_eq!(scene.model.ui.map.draft.waypoints(), waypoints, "{typed}");
        }
    }
}

/// A robot that has driven to and fro between two walls until the ground knows them, with its heading 10 degrees off.
pub(super) fn between_walls() -> Scene {
    let mut scene = scene();
    drive_between_walls(&mut scene);
    scene
}

/// Drives between walls until their direction is known.
pub(super) fn drive_between_walls(scene: &mut Scene) {
    for turn in 0..8 {
        let heads_north = turn % 2 == 0;
        scene.state.theta_deg = if heads_north { 0 } else { 180 };
        for step in 0..30 {
            let y_in = if heads_north {
                step * 4
            } else {
                120 - step * 4
            };
            scene.state.y_tenths_in = y_in * 10;
            let ahead_in = if heads_north { 160 - y_in } else { y_in + 40 };
            (scene.state.sonar_left_in, scene.state.sonar_right_in) =
                (Some(ahead_in as u16), Some(ahead_in as u16));
            scene.hear();
        }
    }
}

#[test]
fn a_route_is_planned_into_the_draft_and_nothing_is_sent() {
    for (typed, end) in [
        (":plan home", (0, 0)),
        (":plan 10,30", (10, 30)),
        (":plan 10 30", (10, 30)),
    ] {
        let mut scene = between_walls();
        scene.type_text(typed);
        assert_eq!(
            scene
                .press(&[KeyCode::Enter])
                .iter()
                .filter(|effect| matches!(effect, Effect::Send(_)))
                .count(),
            0,
            "{typed}"
        );
        assert_eq!(scene.model.ui.overlay, Overlay::None, "{typed}");
        let draft = scene.model.ui.map.draft.waypoints().to_vec();
        let last = draft.last().expect("a waypoint");
        assert!(
            (last.x_in - end.0).abs() < 12 && (last.y_in - end.1).abs() < 12,
            "{typed}: {draft:?}"
        );
        assert_eq!(
            scene.type_text("S"),
            [Effect::Send(Request::Route(draft))],
            "{typed}"
        );
    }
}

#[test]
fn a_route_is_planned_from_the_moment_of_a_replay() {
    let mut scene = between_walls();
    scene.show_moment(Some(playback(false)));
    scene.type_text(":plan home");
    assert_eq!(scene.press(&[KeyCode::Enter]), []);
    assert!(!scene.model.ui.map.draft.waypoints().is_empty());
    assert_eq!(scene.type_text("S"), [], "a capture has no robot");
}

#[test]
fn a_route_that_cannot_be_planned_says_why() {
    for (typed, reason) in [
        (
            ":plan home",
            "no route planned: the ground does not know where the robot is: no position was received",
        ),
        (
            ":plan",
            "`plan` takes `home`, or X and Y in inches: plan 96 40",
        ),
        (
            ":plan away",
            "`plan` takes `home`, or X and Y in inches: plan 96 40",
        ),
        (
            ":plan 10 x",
            "`x` is not a whole number of inches from -9999 to 9999",
        ),
    ] {
        let mut scene = Scene::new(Config::default());
        scene.type_text(typed);
        assert_eq!(scene.press(&[KeyCode::Enter]), [], "{typed}");
        let Overlay::Text(entry) = &scene.model.ui.overlay else {
            panic!("{typed}: no prompt");
        };
        assert_eq!(entry.error.as_deref(), Some(reason), "{typed}");
        assert!(scene.model.ui.map.draft.waypoints().is_empty());
    }
}

#[test]
fn a_route_that_failed_is_the_draft_of_its_own_operator_alone() {
    for (by, is_drafted) in [(None, true), (Some("pid 7".to_owned()), false)] {
        let mut scene = scene();
        let id = CommandId(5);
        let request = Request::Route(route(&[(0, 12)]));
        scene.event(Event::Asked { id, request, by });
        scene.status_of(5, CommandStatus::Failed(Failure::TimedOut));
        let draft = scene.model.ui.map.draft.waypoints();
        assert_eq!(!draft.is_empty(), is_drafted);
    }
}

#[test]
fn a_replay_offers_no_menu_without_a_mode() {
    let mut scene = scene();
    scene.show_moment(Some(playback(false)));
    scene.type_text("m");
    assert_eq!(scene.model.ui.overlay, Overlay::None);
    assert!(scene.model.ui.aside.is_some());
}
