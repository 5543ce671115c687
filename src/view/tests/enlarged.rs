//! Enlarged panels.

use super::link::measured;
use super::*;
use crate::model::{Large, Panel};

#[test]
fn every_panel_is_one_key_away_and_can_be_enlarged() {
    let mut scene = flight(Config::default());
    for (key, title) in PANELS {
        scene.press(&[KeyCode::F(key)]);
        scene.press(&[KeyCode::Esc]);
        for (width, height) in [(80, 24), (100, 30), (110, 34), (120, 40), (200, 60)] {
            row(
                &screen(&scene, width, height),
                &format!("── F{key} {title}"),
            );
        }
        scene.type_text("z");
        let large = screen(&scene, 80, 24);
        row(&large, &format!("── F{key} {title}"));
        assert!(!large.contains("── map"), "{large}");
        scene.press(&[KeyCode::Esc]);
    }
}

#[test]
fn the_map_and_the_ladder_can_be_enlarged_too() {
    let mut scene = flight(demo());
    let shown = |scene: &mut Scene| {
        scene.type_text("z");
        screen(scene, 80, 24)
    };
    assert!(shown(&mut scene).contains("z map"));
    let map = shown(&mut scene);
    assert!(
        map.contains("── map") && !map.contains("who holds the motors"),
        "{map}"
    );
    insta::assert_snapshot!("map_enlarged", map);
    let ladder = shown(&mut scene);
    assert!(
        ladder.contains("who holds the motors") && !ladder.contains("── map"),
        "{ladder}"
    );
    insta::assert_snapshot!("ladder_enlarged", ladder);
    assert!(shown(&mut scene).contains("── map"));
    // Choosing a panel shows it.
    scene.type_text("zz");
    scene.press(&[KeyCode::F(6)]);
    assert!(screen(&scene, 80, 24).contains("── F6 log"));
}

/// An enlarged panel shows more than the same in a larger frame.
#[test]
fn enlarging_shows_more() {
    let four = [(80, 24), (100, 30), (120, 40), (200, 60)];
    let mut scene = measured(demo());
    scene.status.digest = commanded(&mut scene);
    scene.status.list = ListPlace {
        driven: 0,
        count: 2,
    };
    scene.hear_status();
    let expect = |scene: &Scene, facts: &[&str], what: &str| {
        let mut pictures = String::new();
        for (width, height) in four {
            let shown = screen(scene, width, height);
            for fact in facts {
                row(&shown, fact);
            }
            pictures += &shown;
        }
        insta::assert_snapshot!(what, pictures);
    };
    scene.model.ui.enlarged = Some(Large::Panel);
    let limits = [
        "alarm: 11.6 V low, 11.2 V critical",
        "alarm: stalled after 2 s",
        "sonar in",
        "now|",
    ];
    expect(&scene, &limits, "large_sensors");
    scene.model.ui.panel = Panel::Link;
    let history = ["not intact %", "damaged / 20 s", "airtime down %", "now|"];
    expect(&scene, &history, "large_link");
    scene.model.ui.enlarged = Some(Large::Map);
    // Coordinates along the edges, and the waypoints' numbers.
    expect(&scene, &[" 120 ", "◆1", "◆2"], "large_map");
    scene.model.ui.enlarged = Some(Large::Ladder);
    let reasons = [
        "right bumper",
        "no echo left",
        "no one drives by hand",
        "before, newest first",
        "00:15 ✖ right bumper hit at",
    ];
    expect(&scene, &reasons, "large_ladder");
}

const PANELS: [(u8, &str); 7] = [
    (2, "sensors"),
    (3, "from above"),
    (4, "plots"),
    (5, "commands"),
    (6, "log"),
    (7, "link"),
    (8, "alarms"),
];

#[test]
fn every_calm_alarm_has_a_row_on_a_large_screen() {
    let text = screen(&every::busy(Config::default()), 200, 60);
    let title = text
        .lines()
        .find(|line| line.contains("F8 alarms"))
        .unwrap();
    assert!(!title.contains("1/2"), "{title}");
    assert!(text.contains("right side blind"), "{text}");
}
