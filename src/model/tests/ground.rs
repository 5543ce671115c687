//! The ground's estimate, and the rules of its suggestions, from lines.

use groundwave_protocol::telemetry::{
    AbilitiesLine, Body, Line, ParameterLine, ParameterName, Printable,
};

use groundwave_protocol::status_codes::Bump;

use super::*;
use crate::event::{SuggestionCode, SuggestionEvent, SuggestionStatus};
use crate::model::ground::Statement;

/// A name, and what happens.
type Case = (&'static str, fn(&mut Scene));

/// A wheel's parameter, thousandths of an inch.
fn hear_wheel(scene: &mut Scene, name: &str, value: i32) {
    scene.hear_line(Body::Parameter(ParameterLine {
        place: if name == "wheel-left" { 1 } else { 2 },
        count: 2,
        name: ParameterName::new(name),
        value,
        kept: value,
        least: 4000,
        most: 6000,
        unit: Printable::new("in/1000"),
    }));
}

/// A robot whose left wheel has become 3 % smaller than its new parameter says, after a straight way of 99 in: its heading is off by
/// 17 degrees. It has no echoes.
pub(super) fn off(right: Option<i32>) -> Scene {
    let mut scene = scene();
    hear_wheel(&mut scene, "wheel-left", 5000);
    hear_wheel(&mut scene, "wheel-left", 5150);
    if let Some(right) = right {
        hear_wheel(&mut scene, "wheel-right", right);
    }
    scene.drive(30, 3.3, 0);
    scene
}

/// The same robot, after it has stood for two seconds.
fn standing() -> Scene {
    let mut scene = off(None);
    stand(&mut scene);
    scene
}

pub(super) fn stand(scene: &mut Scene) {
    scene.state.velocity_in_s = 0;
    scene.state.wheel_left_in_s = 0;
    scene.state.wheel_right_in_s = 0;
    for _ in 0..8 {
        scene.hear();
    }
}

/// Receives the same line A for a time. Returns the new statuses of the suggestion.
fn pass(scene: &mut Scene, seconds: u64) -> Vec<SuggestionStatus> {
    let mut changes = Vec::new();
    for _ in 0..seconds * 3 {
        scene.hear_line(Body::State(scene.state));
        let new = scene.model.facts.suggestion_events().iter();
        changes.extend(new.map(|change| change.status));
    }
    changes
}

pub(super) fn offered(scene: &Scene) -> Option<SuggestionEvent> {
    let offered = scene.model.facts.suggestion(scene.now)?;
    Some(offered.event(SuggestionStatus::Begun))
}

fn sends(effects: &[Effect]) -> bool {
    effects
        .iter()
        .any(|effect| matches!(effect, Effect::Send(_)))
}

#[test]
fn a_pose_is_suggested_once_the_robot_has_stood() {
    let mut scene = off(None);
    assert_eq!(offered(&scene), None, "it drives");
    let Some(Statement::Pose(pose)) = scene.model.facts.ground.statement else {
        panic!("a pose");
    };
    scene.state.velocity_in_s = 0;
    scene.state.wheel_left_in_s = 0;
    scene.state.wheel_right_in_s = 0;
    for n in 0..8 {
        scene.hear_line(Body::State(scene.state));
        let changes = scene.model.facts.suggestion_events();
        let is_begun = changes
            .iter()
            .any(|it| it.status == SuggestionStatus::Begun);
        assert_eq!(is_begun, n == 7, "line {n} after it stood");
    }
    let begun = offered(&scene).expect("a suggestion");
    assert_eq!(begun.code, SuggestionCode::PoseOff);
    let (x_in, y_in) = (pose.x_in.round(), pose.y_in.round());
    let theta_deg = pose.theta_deg.value.round();
    assert_eq!(
        begun.commands,
        [format!("set-pose {x_in} {y_in} {theta_deg}")]
    );
    let heading = &begun.figures[1];
    assert_eq!((&*heading.code, &*heading.unit), ("heading", "deg"));
    assert!((heading.value - 17.0).abs() < 1.0, "{heading:?}");
    assert!(
        heading.value > 1.5 * heading.half.expect("an interval"),
        "{heading:?}"
    );
}

/// Receives the line A of the present state with one flipped bit.
fn hear_repaired(scene: &mut Scene) {
    let line = Line {
        sequence: 0,
        body: Body::State(scene.state),
        ack: scene.ack,
    };
    scene.event(Event::Repaired(Box::new(line)));
}

#[test]
fn a_repaired_line_moves_the_estimate_alone() {
    let shown = |scene: &Scene| {
        let facts = &scene.model.facts;
        let robot = (&facts.robot, &facts.motors, &facts.chart, &facts.plots);
        let ground = (&facts.link, &facts.ledger, &facts.log, &facts.alarms);
        format!("{robot:?} {ground:?} {:?}", facts.tally())
    };
    let mut scene = off(None);
    let (before, statement) = (shown(&scene), scene.model.facts.ground.statement);
    scene.state.y_tenths_in += 30;
    scene.state.mode = Mode::Stop;
    scene.state.bump = Bump::Left;
    hear_repaired(&mut scene);
    assert_eq!(shown(&scene), before);
    assert_ne!(scene.model.facts.ground.statement, statement);
    scene.hear_line(Body::State(scene.state));
    assert_ne!(shown(&scene), before, "an intact line shows");
}

/// The estimate is newer than the pose in the robot's newest intact line then.
#[test]
fn a_repaired_line_withholds_a_suggestion_and_allows_none() {
    let mut scene = off(None);
    let moving = scene.state;
    for _ in 0..7 {
        scene.state.velocity_in_s = 0;
        scene.state.wheel_left_in_s = 0;
        scene.state.wheel_right_in_s = 0;
        scene.hear();
    }
    let standing = std::mem::replace(&mut scene.state, moving);
    hear_repaired(&mut scene);
    scene.state = standing;
    scene.hear();
    assert_eq!(offered(&scene), None, "it has moved");
    for _ in 0..8 {
        scene.wait_ms(333);
        hear_repaired(&mut scene);
    }
    assert_eq!(offered(&scene), None, "no intact line");
}

#[test]
fn a_suggestion_is_accepted_by_a_key_or_a_command_and_only_once() {
    for keys in ["", ":advise"] {
        let mut scene = standing();
        let accept = |scene: &mut Scene| {
            if keys.is_empty() {
                return scene.ctrl('y');
            }
            scene.type_text(keys);
            scene.press(&[KeyCode::Enter])
        };
        let suggestion = offered(&scene).expect("a suggestion");
        let effects = accept(&mut scene);
        let [Effect::Suggestion(accepted), Effect::Send(request)] = &effects[..] else {
            panic!("{effects:?}");
        };
        assert_eq!(accepted.status, SuggestionStatus::Accepted);
        assert_eq!([request.to_string()], suggestion.commands[..]);
        scene.event(Event::Suggestion(accepted.clone()));
        assert_eq!(offered(&scene), None);
        assert!(!sends(&accept(&mut scene)), "{keys}");
        scene.hear();
        assert_eq!(offered(&scene), None);
        pass(&mut scene, 31);
        assert_eq!(offered(&scene), Some(suggestion), "the command was lost");
    }
}

/// STOP, a mode, driving by hand, an unfinished command and a moving robot have precedence.
#[test]
fn nothing_is_suggested_while_something_has_precedence() {
    let cases: [Case; 8] = [
        ("STOP", |scene| {
            scene.command(1, Request::Stop, CommandStatus::Confirmed { digest: None });
        }),
        ("a mode", |scene| {
            let prowl = Request::Mode(Mode::Prowl);
            scene.command(1, prowl, CommandStatus::Confirmed { digest: None });
        }),
        ("driving by hand", |scene| {
            scene.state.mode = Mode::User;
            scene.hear();
        }),
        ("a command", |scene| scene.ask(1, Request::Scan)),
        ("a turn", |scene| {
            scene.state.rotation_in_s = 3;
            scene.hear();
        }),
        ("a silent robot", |scene| scene.wait_ms(2000)),
        ("a receive-only link", |scene| {
            scene.event(Event::Link(LinkEvent::Opened {
                name: "sim".to_owned(),
                can_send: false,
            }));
        }),
        ("a calibration", |scene| {
            scene.state.mode = Mode::Calibrate;
            scene.hear();
        }),
    ];
    for (what, happens) in cases {
        let mut scene = standing();
        assert!(offered(&scene).is_some(), "{what}");
        happens(&mut scene);
        assert_eq!(offered(&scene), None, "{what}");
        assert!(!sends(&scene.ctrl('y')), "{what}");
    }
}

#[test]
fn suggestions_come_back_ten_seconds_after_stop() {
    let mut scene = off(None);
    scene.command(1, Request::Stop, CommandStatus::Confirmed { digest: None });
    stand(&mut scene);
    assert_eq!(offered(&scene), None, "after 2.7 s");
    assert_eq!(pass(&mut scene, 7), [], "after 9.7 s");
    assert_eq!(
        pass(&mut scene, 1),
        [SuggestionStatus::Begun],
        "after 10.7 s"
    );
}

#[test]
fn a_replay_and_the_past_accept_nothing() {
    for is_live in [true, false] {
        let mut scene = standing();
        scene.show_moment(Some(playback(is_live)));
        assert!(!sends(&scene.ctrl('y')), "live: {is_live}");
    }
}

#[test]
fn robots_that_cannot_take_it_get_no_suggestion() {
    let full = AbilitiesLine::FULL;
    for (abilities, is_offered) in [
        (full, true),
        (AbilitiesLine { level: 4, ..full }, true),
        (AbilitiesLine { level: 3, ..full }, false),
        (
            AbilitiesLine {
                measured: 0,
                ..full
            },
            false,
        ),
    ] {
        let mut scene = standing();
        scene.hear_line(Body::Abilities(abilities));
        assert_eq!(offered(&scene).is_some(), is_offered, "{abilities:?}");
    }
}

#[test]
fn a_suggestion_expires_and_rests() {
    let mut scene = standing();
    assert_eq!(pass(&mut scene, 299), []);
    assert!(offered(&scene).is_some());
    assert_eq!(pass(&mut scene, 2), [SuggestionStatus::Expired]);
    assert_eq!(offered(&scene), None);
    assert_eq!(pass(&mut scene, 897), []);
    assert_eq!(pass(&mut scene, 5), [SuggestionStatus::Begun]);
}

/// The parameters are suggested while the robot drives, too; with them the wheels are right.
#[test]
fn wheels_that_differ_from_the_reported_parameters_are_suggested() {
    assert_eq!(offered(&off(None)), None, "the right wheel is not reported");
    let mut scene = off(Some(5000));
    let suggestion = offered(&scene).expect("a suggestion");
    assert_eq!(suggestion.code, SuggestionCode::WheelsDiffer);
    let commands = ["param set wheel-left 5073", "param set wheel-right 5075"];
    assert_eq!(suggestion.commands, commands);
    let effects = scene.ctrl('y');
    let [
        Effect::Suggestion(accepted),
        Effect::Send(_),
        Effect::Send(_),
    ] = &effects[..]
    else {
        panic!("{effects:?}");
    };
    scene.event(Event::Suggestion(accepted.clone()));
    hear_wheel(&mut scene, "wheel-left", 5073);
    hear_wheel(&mut scene, "wheel-right", 5075);
    pass(&mut scene, 31);
    assert_eq!(offered(&scene), None);
}

/// Without echoes, the heading becomes unknown after some driving. Then a scan is all that is suggested, although the wheels seem to
/// differ from their parameters.
#[test]
fn an_unknown_heading_suggests_a_scan_and_nothing_else() {
    let mut scene = off(Some(5000));
    scene.status.fitted = LayerMask::ALL;
    scene.status.allowed = LayerMask::ALL;
    scene.hear_status();
    let mut begun = Vec::new();
    for _ in 0..400 {
        scene.drive(1, 3.3, 0);
        if scene.model.facts.ground.statement == Some(Statement::HeadingUnknown) {
            begun.extend(offered(&scene));
        }
    }
    assert!(!begun.is_empty());
    for suggestion in begun {
        assert_eq!(suggestion.code, SuggestionCode::HeadingUnknown);
        assert_eq!(suggestion.commands, ["scan"]);
    }
    scene.state.mode = Mode::Stop;
    stand(&mut scene);
    assert_eq!(offered(&scene), None, "a stopped robot does not scan");
}

#[test]
fn a_restart_of_the_robot_begins_the_estimate_again() {
    let mut scene = standing();
    scene.ack.boot = (scene.ack.boot + 1) % 8;
    scene.state.x_tenths_in = 0;
    scene.state.y_tenths_in = 0;
    scene.hear();
    assert_eq!(offered(&scene), None);
    let Some(Statement::Pose(pose)) = scene.model.facts.ground.statement else {
        panic!("a pose");
    };
    assert_eq!((pose.x_in, pose.y_in), (0.0, 0.0));
    assert!(pose.theta_deg.value.abs() < 1e-6 && pose.ellipse.long_in < 1e-6);
}

#[test]
fn the_beginning_and_the_acceptance_are_logged() {
    let mut scene = scene();
    for status in [
        SuggestionStatus::Begun,
        SuggestionStatus::Ended,
        SuggestionStatus::Expired,
        SuggestionStatus::Accepted,
    ] {
        scene.event(Event::Suggestion(SuggestionEvent {
            code: SuggestionCode::HeadingUnknown,
            status,
            commands: vec!["scan".to_owned()],
            figures: Vec::new(),
        }));
    }
    let log = scene.model.facts.log.newest_first();
    let texts = log.map(|entry| entry.text.as_str());
    let suggestions: Vec<&str> = texts
        .filter(|text| text.starts_with("suggestion"))
        .collect();
    assert_eq!(
        suggestions,
        [
            "suggestion accepted: scan (heading-unknown)",
            "suggestion begun: scan (heading-unknown)"
        ]
    );
}
