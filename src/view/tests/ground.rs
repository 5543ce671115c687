//! The ground's estimate and its suggestion, under the map.

use groundwave_mapping::{CorrectedPose, Ellipse, Interval};
use groundwave_protocol::telemetry::{AbilitiesLine, Body};

use super::time::playback;
use super::*;
use crate::event::{Figure, GROUND, Moment, SuggestionCode};
use crate::model::Advise;
use crate::model::ground::{Statement, Suggestion};

/// A robot that stands, with an estimate of its pose that is off by 14 in and 9 degrees.
fn off(config: Config) -> Scene {
    let mut scene = flight(config);
    scene.state.bump = Bump::None;
    scene.state.velocity_in_s = 0;
    scene.state.wheel_left_in_s = 0;
    scene.state.wheel_right_in_s = 0;
    for _ in 0..8 {
        scene.hear();
    }
    let state = scene.state;
    let tenths = |tenths: i32| f64::from(tenths) / 10.0;
    scene.model.facts.ground.statement = Some(Statement::Pose(CorrectedPose {
        x_in: tenths(state.x_tenths_in) + 14.0,
        y_in: tenths(state.y_tenths_in),
        theta_deg: Interval {
            value: f64::from(state.theta_deg) + 9.0,
            half: 4.0,
        },
        ellipse: Ellipse {
            long_in: 9.0,
            short_in: 5.0,
            bearing_deg: 30.0,
        },
    }));
    scene
}

#[test]
fn the_estimate_and_the_suggestion_are_under_the_map() {
    let mut scene = off(Config::default());
    let state = scene.state;
    let x_in = (f64::from(state.x_tenths_in) / 10.0 + 14.0).round();
    let y_in = (f64::from(state.y_tenths_in) / 10.0).round();
    let theta_deg = state.theta_deg + 9;
    let pose = format!("{theta_deg} deg ±4, ({x_in:.0}, {y_in:.0}) ±9 in");
    row(&screen(&scene, 120, 40), &format!("ground: heading {pose}"));
    row(&screen(&scene, 80, 24), &format!("ground: {pose}"));

    scene.model.facts.watch_ground(scene.now);
    let wide = screen(&scene, 120, 40);
    insta::assert_snapshot!("suggestion_wide", wide);
    let words = format!("Ctrl-Y: set-pose {x_in:.0} {y_in:.0} {theta_deg}");
    row(&wide, &format!("{words} (off by 14 ±9 in, 9 ±4 deg)"));
    assert!(!wide.contains("ground:"), "{wide}");
    let narrow = screen(&scene, 80, 24);
    insta::assert_snapshot!("suggestion_narrow", narrow);
    row(&narrow, &words);

    // It cannot be accepted in the past, so it is not shown there.
    scene.show_moment(Some(playback(&scene, true)));
    let past = screen(&scene, 120, 40);
    assert!(!past.contains("set-pose"), "{past}");
    row(&past, "ground: heading");
}

/// A robot that was lifted has no place on the map.
#[test]
fn a_lifted_robot_is_said_to_be_lifted() {
    let mut scene = off(Config::default());
    scene.model.facts.ground.statement = Some(Statement::Lifted);
    scene.model.facts.watch_ground(scene.now);
    let wide = screen(&scene, 120, 40);
    row(&wide, "ground: lifted; put it down, then :set-pose");
    assert!(!wide.contains("Ctrl-Y"), "{wide}");
    row(&screen(&scene, 80, 24), "ground: lifted, pose unknown");
}

/// The way of a suggestion is on the map like a draft, and its reason is in words.
#[test]
fn a_suggested_way_is_on_the_map() {
    let mut scene = flight(Config::default());
    let figure = |code: &str, value| Figure {
        code: code.to_owned(),
        value,
        half: None,
        unit: "min".to_owned(),
    };
    let before = screen(&scene, 120, 40);
    let waypoints = [(40, 0), (40, 60)].map(|(x_in, y_in)| Waypoint { x_in, y_in });
    let suggestion = Suggestion {
        code: SuggestionCode::DockNow,
        requests: vec![
            Request::Route(waypoints.to_vec()),
            Request::Mode(Mode::Prowl),
        ],
        target_in: Some((40.0, 60.0)),
        figures: vec![figure("dock-takes", 9.2), figure("battery-lasts", 25.4)],
    };
    let until = scene.now + Moment::from_mins(1);
    scene.model.facts.ground.offer(suggestion, until);
    let with = screen(&scene, 120, 40);
    row(
        &with,
        "Ctrl-Y: route of 2, mode prowl (dock takes 9 min, battery lasts 25 min)",
    );
    let braille = |text: &str| {
        text.chars()
            .filter(|c| ('\u{2801}'..='\u{28ff}').contains(c))
            .count()
    };
    assert!(braille(&with) > braille(&before), "{with}");
    row(&screen(&scene, 80, 24), "Ctrl-Y: route of 2, mode prowl");
}

#[test]
fn the_ellipse_is_on_the_map_once_it_is_larger_than_the_robot() {
    let mut scene = off(Config {
        ascii: true,
        ..Config::default()
    });
    let without = screen(&scene, 120, 40);
    assert!(!without.contains('~') && !without.contains("dashed"));
    let Some(Statement::Pose(pose)) = &mut scene.model.facts.ground.statement else {
        panic!("a pose");
    };
    (pose.ellipse.long_in, pose.ellipse.short_in) = (24.0, 12.0);
    let with = screen(&scene, 120, 40);
    row(&with, "dashed: ground's 95 %");
    assert!(with.matches('~').count() > 8, "{with}");
    insta::assert_snapshot!("ellipse", with);
}

/// Commands that the station sends by itself are announced on every width, also while an operator has precedence.
#[test]
fn auto_is_on_the_status_line() {
    for (width, height) in [(80, 24), (120, 40)] {
        let mut scene = off(Config {
            advise: Advise::Auto,
            ..Config::default()
        });
        row(&screen(&scene, width, height), "AUTO  ");
        scene.ask(1, Request::Stop);
        row(&screen(&scene, width, height), "AUTO paused");
        let suggests = off(Config::default());
        assert!(!screen(&suggests, width, height).contains("AUTO"));
    }
}

#[test]
fn the_ledger_says_that_a_command_was_sent_unasked() {
    let mut scene = off(Config::default());
    scene.event(Event::Asked {
        id: CommandId(1),
        request: Request::Scan,
        by: Some(GROUND.to_owned()),
    });
    row(&screen(&scene, 120, 40), "sent by --advise=auto");
}

#[test]
fn an_unknown_heading_is_shown_and_a_robot_without_sonars_has_no_estimate() {
    let mut scene = off(Config::default());
    scene.model.facts.ground.statement = Some(Statement::HeadingUnknown);
    for (width, height) in [(80, 24), (120, 40)] {
        row(&screen(&scene, width, height), "ground: heading unknown");
    }
    scene.wait_ms(2500);
    row(&screen(&scene, 120, 40), "◌ ground: heading unknown");
    scene.hear_line(Body::Abilities(AbilitiesLine {
        measured: 0,
        ..AbilitiesLine::FULL
    }));
    assert!(!screen(&scene, 120, 40).contains("ground:"));
}

#[test]
fn the_estimate_is_plain_on_a_plain_terminal() {
    let mut scene = off(Config {
        ascii: true,
        ..Config::default()
    });
    row(&screen(&scene, 120, 40), "deg +-4, (");
    scene.model.facts.watch_ground(scene.now);
    let screen = screen(&scene, 120, 40);
    row(&screen, "(off by 14 +-9 in, 9 +-4 deg)");
    assert!(screen.is_ascii(), "{screen}");
}
