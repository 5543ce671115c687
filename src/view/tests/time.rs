//! The past and replays.

use super::*;
use crate::playback::Playback;

pub(super) fn playback(scene: &Scene, is_live: bool) -> Playback {
    Playback {
        is_live,
        paused: true,
        speed: 1.0,
        at: scene.now,
        from: Moment::ZERO,
        until: scene.now + Moment::from_secs(125),
        unix: Some(Moment::from_secs(1_795_294_008)),
        line: Some(57),
        read_until: None,
        is_partial: false,
        is_looking: false,
        markers: vec![Moment::from_secs(70)],
        repeat: None,
        note: None,
    }
}

pub(super) fn flight_at(config: Config, playback: impl FnOnce(&Scene) -> Playback) -> Scene {
    let mut scene = flight(config);
    let playback = playback(&scene);
    scene.show_moment(Some(playback));
    scene
}

#[test]
fn the_past_at_80_by_24() {
    let scene = flight_at(Config::default(), |scene| playback(scene, true));
    let screen = screen(&scene, 80, 24);
    insta::assert_snapshot!(screen);
    let row = row(&screen, "PAST 2 m 00 s ago");
    assert!(row.contains("◀◀") && row.contains('‖'), "{row}");
    assert!(screen.contains("commands go to the robot now, after a question; G returns"));
}

#[test]
fn the_past_at_120_by_40() {
    let scene = flight_at(Config::default(), |scene| playback(scene, true));
    let screen = screen(&scene, 120, 40);
    insta::assert_snapshot!(screen);
    let row = row(&screen, "PAST 2 m 00 s ago");
    assert!(
        row.contains("#57") && row.matches("◀◀").count() == 2,
        "{row}"
    );
}

#[test]
fn an_alarm_of_now_shows_in_the_past_with_its_own_age() {
    let mut hands = flight(Config::default());
    let past = hands.model.facts.clone();
    hands.wait_ms(60_000);
    hands.event(Event::Tick);
    hands.wait_ms(20_000);
    let until = hands.now;
    let playback = Playback {
        until,
        ..playback(&hands, true)
    };
    hands.show_moment(Some(playback));
    let at = flight(Config::default()).now;
    let screen = |hands: &Scene, width, height| {
        let shown = Shown {
            facts: &past,
            ..Shown::from(&hands.model)
        };
        text(&buffer_of(shown, at, width, height))
    };
    for (width, height) in [(80, 24), (120, 40), (200, 60)] {
        let screen = screen(&hands, width, height);
        row(&screen, "✖ NOW: ROBOT SILENT 1 m 20 s. Is it on");
        row(&screen, "BUMPERS hold the motors");
    }
    hands.type_text("A");
    assert!(!screen(&hands, 80, 24).contains("NOW:"));
}

#[test]
fn a_plain_terminal_marks_the_past_by_shape_and_reversed_row() {
    let mut scene = flight(Config {
        colors: Colors::Mono,
        ascii: true,
        ..Config::default()
    });
    let past = playback(&scene, true);
    scene.show_moment(Some(past));
    let buffer = buffer(&scene, 80, 24);
    let reversed = |x: u16| {
        let modifier = buffer[(x, 1)].modifier;
        modifier.contains(ratatui::style::Modifier::REVERSED)
    };
    assert!((0..80).all(reversed), "the whole row");
    let screen = screen(&scene, 80, 24);
    assert!(row(&screen, "<< PAST").is_ascii(), "{screen}");
}

#[test]
fn a_replay_at_80_by_24() {
    let scene = flight_at(Config::default(), |scene| Playback {
        paused: false,
        speed: 0.25,
        repeat: Some((Moment::from_secs(100), Some(Moment::from_secs(130)))),
        ..playback(scene, false)
    });
    let screen = screen(&scene, 80, 24);
    insta::assert_snapshot!(screen);
    let row = row(&screen, "REPLAY");
    for told in ["×0.25", "#57", "◇", "[", "]", "╋"] {
        assert!(row.contains(told), "{told}: {row}");
    }
    assert!(!screen.contains("PAST") && !screen.contains("recorded"));
}

#[test]
fn a_replay_while_reading_at_120_by_40() {
    let scene = flight_at(Config::default(), |scene| Playback {
        read_until: Some(scene.now / 2),
        is_partial: true,
        line: None,
        ..playback(scene, false)
    });
    let screen = screen(&scene, 120, 40);
    insta::assert_snapshot!(screen);
    let row = row(&screen, "REPLAY");
    assert!(row.contains("reading ") && row.contains('Z'), "{row}");
    assert!(screen.contains("still reading"));
}

#[test]
fn a_paused_moment_does_not_age() {
    for is_live in [false, true] {
        let scene = flight_at(Config::default(), |scene| playback(scene, is_live));
        let drawn = screen(&scene, 120, 40);
        assert_eq!(screen(&scene, 120, 40), drawn);
        assert!(!drawn.contains("LOST") && !drawn.contains("SILENT"));
        assert!(drawn.contains("newest <1 s"));
    }
}

#[test]
fn the_result_of_a_jump_shows() {
    let scene = flight_at(Config::default(), |scene| Playback {
        note: Some((Level::Warning, "there are no later alarms".to_owned())),
        ..playback(scene, true)
    });
    row(&screen(&scene, 80, 24), "! there are no later alarms");
}

#[test]
fn the_jump_prompt_names_its_targets() {
    let mut scene = flight(Config::default());
    scene.type_text("n");
    let told = screen(&scene, 80, 24);
    row(
        &told,
        "to the next Space STOP  a alarm  b bump  v layer  c command  m mark",
    );
}
