//! Clicks and the wheel.

use crossterm::event::KeyCode;
use ratatui::layout::Position;

use super::{buffer, demo, flight, screen};
use crate::event::{Event, Gesture, Spot};
use crate::model::Panel;
use crate::model::testing::Scene;
use crate::view::spot;

fn find(scene: &Scene, size: (u16, u16), at: Position) -> Option<Spot> {
    spot(&scene.model, scene.now, size, at.x, at.y)
}

/// Position of a text on the screen.
fn place(scene: &Scene, (width, height): (u16, u16), words: &str) -> Position {
    let text = screen(scene, width, height);
    let (row, line) = (0..)
        .zip(text.lines())
        .find(|(_, line)| line.contains(words))
        .unwrap_or_else(|| panic!("no `{words}` in\n{text}"));
    let before = line.split(words).next().unwrap_or_default();
    Position::new(before.chars().count() as u16, row)
}

#[test]
fn a_click_on_the_map_puts_the_cursor_there() {
    for size in [(80, 24), (120, 40), (200, 60)] {
        let mut scene = flight(demo());
        for (column, row) in [(10, 8), (17, 12), (30, 15)] {
            let at = Position::new(column, row);
            let on = find(&scene, size, at).expect("the map is there");
            assert!(matches!(on, Spot::Floor { .. }), "{on:?}");
            let gesture = Gesture::Click;
            scene.event(Event::Pointer { on, gesture });
            let drawn = buffer(&scene, size.0, size.1);
            assert_eq!(drawn[(column, row)].symbol(), "╋", "{size:?} {at}");
            scene.press(&[KeyCode::Esc]);
        }
    }
}

#[test]
fn a_click_chooses_a_panel_and_the_wheel_zooms_the_map() {
    let size = (120, 40);
    let mut scene = flight(demo());
    let on = find(&scene, size, place(&scene, size, "log")).expect("the log is there");
    let gesture = Gesture::Click;
    scene.event(Event::Pointer { on, gesture });
    assert_eq!(scene.model.ui.panel, Panel::Log);
    let map = find(&scene, size, Position::new(20, 12)).expect("the map is there");
    let gesture = Gesture::Wheel(1);
    let width_in = |scene: &Scene| {
        let (map, chart) = (&scene.model.ui.map, &scene.model.facts.chart);
        map.shown(chart).extent().0
    };
    let before_in = width_in(&scene);
    scene.event(Event::Pointer { on: map, gesture });
    let closer_in = width_in(&scene);
    assert!(closer_in < before_in * 0.8, "{before_in} {closer_in}");
    // Clicks do not pass through windows.
    scene.type_text("?");
    scene.event(Event::Pointer { on: map, gesture });
    assert!((width_in(&scene) - closer_in).abs() < 1e-9);
    assert_eq!(
        find(&scene, size, Position::new(0, 0)),
        None,
        "the status line"
    );
}

#[test]
fn in_the_route_editor_a_click_chooses_a_waypoint_or_a_place_for_one() {
    for size in [(80, 24), (120, 40), (200, 60)] {
        let mut scene = flight(demo());
        scene.type_text("e");
        let click = |scene: &mut Scene, at: Position| {
            let on = find(scene, size, at).expect("something to point at");
            let gesture = Gesture::Click;
            scene.event(Event::Pointer { on, gesture });
        };
        // Two waypoints on the map; the cursor marks the chosen one.
        let places = [Position::new(12, 9), Position::new(20, 13)];
        for place in places {
            click(&mut scene, place);
            scene.type_text("w");
        }
        let waypoints = scene.model.ui.map.draft.waypoints().to_vec();
        assert_eq!(waypoints.len(), 2, "{size:?}");
        let chosen = |scene: &Scene| scene.model.ui.map.draft.selected();
        let drawn = buffer(&scene, size.0, size.1);
        let marked = drawn
            .area
            .positions()
            .filter(|at| drawn[*at].symbol() == "╋");
        let on_map = marked.min_by_key(|at| at.x).expect("the cursor");
        let heading = place(&scene, size, "    n      x      y");
        click(&mut scene, Position::new(heading.x + 4, heading.y + 1));
        assert_eq!(chosen(&scene), Some(0), "in the list, {size:?}");
        click(&mut scene, on_map);
        assert_eq!(chosen(&scene), Some(1), "on the map, {size:?}");
        assert_eq!(scene.model.ui.map.draft.waypoints(), waypoints);
    }
}

#[test]
fn a_clicked_place_shows_and_outlives_a_refused_key() {
    let size = (80, 24);
    let mut scene = flight(demo());
    scene.type_text("e");
    assert!(screen(&scene, 80, 24).contains("w adds one where the robot is"));
    let on = find(&scene, size, Position::new(12, 9)).unwrap();
    let gesture = Gesture::Click;
    scene.event(Event::Pointer { on, gesture });
    let pointed = scene.model.ui.map.cursor;
    scene.press(&[KeyCode::Left]);
    let shown = screen(&scene, 80, 24);
    assert!(
        shown.contains("w adds one at the cursor") && shown.contains("loads a file"),
        "{shown}"
    );
    scene.type_text("w");
    assert_eq!(
        scene.model.ui.map.draft.waypoints().first().copied(),
        pointed
    );
}
