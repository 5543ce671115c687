//! Enlarged panels.

use super::*;

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

const PANELS: [(u8, &str); 7] = [
    (2, "sensors"),
    (3, "from above"),
    (4, "plots"),
    (5, "commands"),
    (6, "log"),
    (7, "link"),
    (8, "alarms"),
];
