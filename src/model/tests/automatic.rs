//! Commands that the station sends by itself with `--advise=auto`, and all that keeps it from them.

mod scans;

use std::sync::Arc;

use groundwave_protocol::telemetry::Body;

use super::ground::{off, offered, stand};
use super::routes::{between_walls, drive_between_walls};
use super::*;
use crate::event::{GROUND, SuggestionCode};
use crate::model::Advise;
use crate::model::ground::{Statement, Suggestion};

/// A name, and what happens.
type Case = (&'static str, fn(&mut Scene));

/// The digest of the route in the robot.
const DIGEST: u32 = 7;

fn advised(mut scene: Scene, advise: Advise) -> Scene {
    let config = Arc::new(Config {
        advise,
        ..Config::default()
    });
    scene.model.facts.config = Arc::clone(&config);
    scene.model.ui.config = config;
    scene
}

/// Commands that the station sends by itself while the robot sends the same line A for a time.
fn unasked(scene: &mut Scene, seconds: u64) -> Vec<Request> {
    (0..seconds * 3)
        .flat_map(|_| unasked_at_a_line(scene))
        .collect()
}

fn unasked_at_a_line(scene: &mut Scene) -> Vec<Request> {
    let mut sent = Vec::new();
    for effect in scene.hear_line(Body::State(scene.state)) {
        match effect {
            Effect::SendUnasked(request) => {
                scene.event(Event::Asked {
                    id: CommandId(100),
                    request: request.clone(),
                    by: Some(GROUND.to_owned()),
                });
                let digest = matches!(request, Request::Route(_)).then_some(DIGEST);
                scene.status_of(100, CommandStatus::Confirmed { digest });
                sent.push(request);
            }
            Effect::Suggestion(suggestion) => {
                scene.event(Event::Suggestion(suggestion));
            }
            Effect::Notice(notice) => {
                scene.event(Event::Notice(notice));
            }
            _ => {}
        }
    }
    sent
}

fn logged(scene: &Scene, text: &str) -> bool {
    let mut log = scene.model.facts.log.newest_first();
    log.any(|entry| entry.text.as_str().contains(text))
}

/// A command of a client of the shared link.
fn ask_by_client(scene: &mut Scene, request: Request) {
    scene.event(Event::Asked {
        id: CommandId(50),
        request,
        by: Some("pid 7".to_owned()),
    });
    scene.status_of(50, CommandStatus::Confirmed { digest: None });
}

#[test]
fn only_auto_sets_a_suggested_pose_by_itself() {
    for (advise, is_offered, is_sent) in [
        (Advise::Off, false, false),
        (Advise::Suggest, true, false),
        (Advise::Auto, false, true),
    ] {
        let mut scene = advised(off(None), advise);
        scene.state.velocity_in_s = 0;
        scene.state.wheel_left_in_s = 0;
        scene.state.wheel_right_in_s = 0;
        let sent = unasked(&mut scene, 4);
        assert_eq!(offered(&scene).is_some(), is_offered, "{advise:?}");
        let poses = sent.iter().filter(|it| matches!(it, Request::Pose { .. }));
        assert_eq!(poses.count(), usize::from(is_sent), "{advise:?}: {sent:?}");
        assert_eq!(sent.len(), usize::from(is_sent), "{advise:?}: {sent:?}");
        assert_eq!(logged(&scene, "asked by ground"), is_sent, "{advise:?}");
    }
}

/// Wheels that differ and a scan because of a lost heading are left to the operator.
#[test]
fn auto_sends_no_suggested_parameter_and_no_suggested_scan() {
    let mut scene = advised(off(Some(5000)), Advise::Auto);
    assert_eq!(unasked(&mut scene, 60), []);
    assert!(offered(&scene).is_some(), "wheels");
    let mut scene = advised(off(None), Advise::Auto);
    scene.status.fitted = LayerMask::ALL;
    scene.status.allowed = LayerMask::ALL;
    scene.hear_status();
    for _ in 0..400 {
        scene.drive(1, 3.3, 0);
    }
    let ground = &scene.model.facts.ground;
    assert_eq!(ground.statement, Some(Statement::HeadingUnknown));
    assert!(offered(&scene).is_some(), "a scan");
    assert_eq!(unasked(&mut scene, 60), []);
}

#[test]
fn auto_is_silent_for_a_minute_after_an_operator() {
    let cases: [Case; 5] = [
        ("STOP", |scene| {
            scene.command(1, Request::Stop, CommandStatus::Confirmed { digest: None });
        }),
        ("a mode", |scene| {
            let mode = Request::Mode(Mode::Wander);
            scene.command(1, mode, CommandStatus::Confirmed { digest: None });
        }),
        ("STOP by a client", |scene| {
            ask_by_client(scene, Request::Stop);
        }),
        ("a mode by a client", |scene| {
            ask_by_client(scene, Request::Mode(Mode::Reactive));
        }),
        ("a client's hand", |scene| {
            let mode = std::mem::replace(&mut scene.state.mode, Mode::User);
            scene.hear();
            scene.state.mode = mode;
        }),
    ];
    for (what, happens) in cases {
        let mut scene = advised(off(None), Advise::Auto);
        happens(&mut scene);
        scene.state.velocity_in_s = 0;
        scene.state.wheel_left_in_s = 0;
        scene.state.wheel_right_in_s = 0;
        assert_eq!(unasked(&mut scene, 58), [], "{what}");
        assert_eq!(scene.model.ui.is_automatic(scene.now), Some(true), "{what}");
        assert_eq!(unasked(&mut scene, 6).len(), 1, "{what}");
        assert_eq!(
            scene.model.ui.is_automatic(scene.now),
            Some(false),
            "{what}"
        );
    }
}

/// The operator's own hand is known before the robot says so.
#[test]
fn an_arrow_key_makes_auto_silent() {
    let mut scene = advised(off(None), Advise::Auto);
    stand(&mut scene);
    let effect = Effect::Drive {
        velocity_in_s: 8,
        rotation_in_s: 0,
    };
    scene.type_text("dy");
    assert_eq!(scene.model.ui.is_automatic(scene.now), Some(false));
    assert_eq!(scene.press(&[KeyCode::Up]), [effect]);
    assert_eq!(scene.model.ui.is_automatic(scene.now), Some(true));
}

/// A robot that drives a route home that the operator has planned and sent.
fn homeward() -> Scene {
    let mut scene = advised(between_walls(), Advise::Auto);
    scene.state.mode = Mode::Prowl;
    send_home(&mut scene);
    scene
}

/// Plans a route home and sends it.
fn send_home(scene: &mut Scene) {
    scene.type_text(":plan home");
    scene.press(&[KeyCode::Enter]);
    let [Effect::Send(route)] = &scene.type_text("S")[..] else {
        panic!("a route");
    };
    let digest = Some(DIGEST);
    scene.command(1, route.clone(), CommandStatus::Confirmed { digest });
    drive_to(scene, 0);
}

/// Reports that a number of waypoints was reached.
fn drive_to(scene: &mut Scene, driven: u16) {
    let active = scene.model.facts.ledger.active().expect("a route");
    scene.status.digest = DIGEST;
    scene.status.list = ListPlace {
        driven,
        count: active.waypoints.len() as u16,
    };
    scene.hear_status();
}

/// Reports that the route was driven, and stops.
fn end(scene: &mut Scene) {
    let active = scene.model.facts.ledger.active().expect("a route");
    let count = active.waypoints.len() as u16;
    scene.state.mode = Mode::Stop;
    scene.state.velocity_in_s = 0;
    scene.state.wheel_left_in_s = 0;
    scene.state.wheel_right_in_s = 0;
    drive_to(scene, count);
}

/// The route is planned again while the robot drives it; the new one is sent if it leads elsewhere.
#[test]
fn a_route_that_leads_elsewhere_is_replaced() {
    let mut scene = homeward();
    assert_eq!(unasked(&mut scene, 100), [], "it is the same route");
    let mut scene = sent_home_by(&[(60, 40)], false);
    replace_route(&mut scene);
    assert!(logged(&scene, "plan home: planned again, "));
    drive_to(&mut scene, 0);
    assert_eq!(unasked(&mut scene, 100), [], "it is the same route");
}

/// Waits until the station sends another route.
fn replace_route(scene: &mut Scene) {
    assert_eq!(unasked(scene, 19), []);
    let sent = unasked(scene, 2);
    let [Request::Route(waypoints)] = &sent[..] else {
        panic!("{sent:?}");
    };
    let end = waypoints.last().expect("a waypoint");
    assert!(end.x_in.abs() < 12 && end.y_in.abs() < 12, "{end:?}");
}

/// The robot arrives at the end of a list while the next one is on its way, and stops there. A stop elsewhere, or when it has driven the next
/// one, has another reason.
#[test]
fn a_robot_that_stopped_at_the_end_of_a_replaced_list_drives_on() {
    for (off_in, has_begun, drives_on) in [(3, false, true), (30, false, false), (3, true, false)] {
        let mut scene = sent_home_by(&[(60, 40)], false);
        replace_route(&mut scene);
        drive_to(&mut scene, 0);
        if has_begun {
            assert_eq!(unasked(&mut scene, 10), []);
        }
        scene.state.mode = Mode::Stop;
        (scene.state.x_tenths_in, scene.state.y_tenths_in) = ((60 + off_in) * 10, 400);
        let sent = unasked(&mut scene, 60);
        if drives_on {
            assert!(
                matches!(
                    &sent[..],
                    [Request::Route(_), Request::Mode(Mode::Prowl), ..]
                ),
                "{sent:?}"
            );
        } else {
            assert_eq!(sent, []);
        }
    }
}

#[test]
fn a_route_that_ends_elsewhere_is_continued() {
    let mut scene = homeward();
    scene.state.y_tenths_in = 600;
    end(&mut scene);
    let sent = unasked(&mut scene, 1);
    let [Request::Route(_), Request::Mode(Mode::Prowl)] = &sent[..] else {
        panic!("{sent:?}");
    };
}

#[test]
fn a_destination_that_was_reached_is_left() {
    let mut scene = homeward();
    scene.drive(4, -1.0, 0);
    scene.state.y_tenths_in = 0;
    end(&mut scene);
    let sent = unasked(&mut scene, 100);
    assert!(
        sent.iter().all(|it| matches!(it, Request::Pose { .. })),
        "{sent:?}"
    );
    assert!(logged(&scene, "plan home: arrived, within "));
}

/// A robot that prowls on after a detour does not drive what is left of its list.
#[test]
fn a_robot_that_stopped_at_the_end_of_a_replaced_detour_prowls_freely() {
    let mut scene = sent_home_by(&[(10, 0)], true);
    replace_route(&mut scene);
    drive_to(&mut scene, 0);
    scene.state.mode = Mode::Stop;
    (scene.state.x_tenths_in, scene.state.y_tenths_in) = (100, 0);
    let sent = unasked(&mut scene, 1);
    assert_eq!(
        sent,
        [Request::Route(Vec::new()), Request::Mode(Mode::Prowl)]
    );
}

/// An operator ends a drive by a STOP that this station only sees as the end of its own command, or by taking it back.
#[test]
fn a_command_that_an_operator_ended_is_not_sent_again() {
    for failure in [Failure::Stopped, Failure::TakenOver, Failure::Cancelled] {
        let mut scene = sent_home_by(&[(60, 40)], false);
        replace_route(&mut scene);
        drive_to(&mut scene, 0);
        scene.status_of(100, CommandStatus::Failed(failure));
        scene.state.mode = Mode::Stop;
        (scene.state.x_tenths_in, scene.state.y_tenths_in) = (600, 400);
        assert_eq!(unasked(&mut scene, 120), [], "{failure:?}");
    }
}

/// Each of these ends the drive to a destination, or keeps the station from planning.
#[test]
fn no_route_is_sent_against_the_operator() {
    let cases: [Case; 9] = [
        ("STOP", |scene| {
            scene.command(2, Request::Stop, CommandStatus::Confirmed { digest: None });
        }),
        ("STOP by a client", |scene| {
            ask_by_client(scene, Request::Stop);
        }),
        ("a mode by a client", |scene| {
            ask_by_client(scene, Request::Mode(Mode::GoHome));
        }),
        ("another route", |scene| {
            let other = Request::Route(route(&[(48, 0)]));
            let digest = Some(DIGEST);
            scene.command(2, other, CommandStatus::Confirmed { digest });
        }),
        ("another pose", |scene| {
            let pose = Request::Pose {
                position: Waypoint::default(),
                theta_deg: 0,
            };
            scene.command(2, pose, CommandStatus::Confirmed { digest: None });
        }),
        ("the robot's own stop", |scene| {
            scene.state.mode = Mode::Stop;
        }),
        ("a restart", |scene| {
            scene.ack.boot = (scene.ack.boot + 1) % 8;
            scene.hear();
        }),
        ("an unfinished command", |scene| scene.ask(2, Request::Scan)),
        ("a receive-only link", |scene| {
            scene.event(Event::Link(LinkEvent::Opened {
                name: "sim".to_owned(),
                can_send: false,
            }));
        }),
    ];
    for (what, happens) in cases {
        let mut scene = homeward();
        happens(&mut scene);
        let sent = unasked(&mut scene, 200);
        let routes = sent.iter().filter(|it| !matches!(it, Request::Pose { .. }));
        assert_eq!(routes.count(), 0, "{what}: {sent:?}");
    }
}

#[test]
fn a_changed_draft_and_a_route_that_failed_are_not_planned_again() {
    let mut scene = advised(between_walls(), Advise::Auto);
    scene.state.mode = Mode::Prowl;
    scene.type_text(":plan home");
    scene.press(&[KeyCode::Enter]);
    let mut changed = scene.model.ui.map.draft.waypoints().to_vec();
    changed.push(Waypoint { x_in: 50, y_in: 50 });
    let digest = Some(DIGEST);
    scene.command(
        1,
        Request::Route(changed),
        CommandStatus::Confirmed { digest },
    );
    assert_eq!(unasked(&mut scene, 130), [], "changed");

    let mut scene = homeward();
    scene.status_of(1, CommandStatus::Failed(Failure::TimedOut));
    assert_eq!(unasked(&mut scene, 130), [], "failed");
}

/// Without a known heading, the reason is logged once and the robot drives on.
#[test]
fn a_lost_heading_is_said_and_nothing_is_sent() {
    let mut scene = homeward();
    (scene.state.sonar_left_in, scene.state.sonar_right_in) = (None, None);
    let mut sent = Vec::new();
    for _ in 0..3000 {
        scene.state.y_tenths_in += 33;
        let new = unasked_at_a_line(&mut scene);
        if scene.model.facts.ground.statement == Some(Statement::HeadingUnknown) {
            sent.extend(new);
        }
    }
    let statement = scene.model.facts.ground.statement;
    assert_eq!(statement, Some(Statement::HeadingUnknown));
    assert_eq!(sent, []);
    let log = scene.model.facts.log.newest_first();
    let reasons = log.filter(|entry| {
        entry.text.contains("plan home: no route planned: ") && entry.text.contains("quarter turn")
    });
    assert_eq!(reasons.count(), 1);
}

#[test]
fn a_destination_is_given_up_after_twenty_minutes() {
    let mut scene = homeward();
    assert_eq!(unasked(&mut scene, 19 * 60), []);
    assert!(!logged(&scene, "plan home: given up"));
    assert_eq!(unasked(&mut scene, 5 * 60), []);
    assert!(logged(&scene, "plan home: given up"));
}

/// A robot that prowled, and that the station has sent to a place of its own choice.
fn detour() -> Scene {
    sent_home_by(&[(0, 0)], true)
}

/// A robot that the station has sent home by a route.
fn sent_home_by(points: &[(i16, i16)], is_detour: bool) -> Scene {
    let mut scene = advised(between_walls(), Advise::Auto);
    scene.state.mode = Mode::Prowl;
    let waypoints = route(points);
    let suggestion = Suggestion {
        code: if is_detour {
            SuggestionCode::Held
        } else {
            SuggestionCode::DockNow
        },
        requests: vec![Request::Route(waypoints.clone())],
        target_in: Some((0.0, 0.0)),
        figures: Vec::new(),
    };
    let automatic = &mut scene.model.ui.automatic;
    automatic.take_suggested(&suggestion, is_detour);
    scene.event(Event::Asked {
        id: CommandId(100),
        request: Request::Route(waypoints),
        by: Some(GROUND.to_owned()),
    });
    let digest = Some(DIGEST);
    scene.status_of(100, CommandStatus::Confirmed { digest });
    drive_to(&mut scene, 0);
    scene
}

#[test]
fn a_robot_prowls_on_after_a_detour() {
    let mut scene = detour();
    scene.drive(4, -1.0, 0);
    scene.state.y_tenths_in = 0;
    end(&mut scene);
    assert_eq!(unasked(&mut scene, 1), [Request::Mode(Mode::Prowl)]);
    assert!(logged(&scene, "plan 0 0: arrived, within "));

    let mut scene = detour();
    let prowl = Request::Mode(Mode::Prowl);
    let sent = unasked(&mut scene, 4 * 60);
    assert!(!sent.contains(&prowl), "{sent:?}");
    let sent = unasked(&mut scene, 2 * 60);
    assert_eq!(sent.last(), Some(&Request::Route(Vec::new())), "{sent:?}");
    assert!(logged(&scene, "plan 0 0: given up"));
}
