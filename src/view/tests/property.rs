//! Properties of the screen under random events.

use proptest::prelude::*;

use super::*;
use crate::model::testing::{any_event, any_happening};

proptest! {
    #![proptest_config(ProptestConfig { cases: 32, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn the_cost_of_a_frame_does_not_grow_with_the_session(
        events in prop::collection::vec((any_happening(), 0_u64..5000), 1..60),
    ) {
        let mut scene = Scene::new(demo());
        let mut most = [(0, 0); 2];
        for most in &mut most {
            for _ in 0..100 {
                for (event, wait_ms) in &events {
                    scene.wait_ms(*wait_ms);
                    scene.happen(event.clone());
                }
            }
            *most = cost(&scene);
        }
        let [(early_dots, early_kept), (late_dots, late_kept)] = most;
        prop_assert!(late_dots <= early_dots + 10_000, "{early_dots}, then {late_dots} dots");
        prop_assert!(late_kept <= early_kept + 1500, "{early_kept}, then {late_kept} kept");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 128, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn drawing_never_panics_and_prints_nothing(
        events in prop::collection::vec((any_happening(), 0_u64..5000), 0..60),
        width in 1_u16..=250,
        height in 1_u16..=80,
        ascii in any::<bool>(),
    ) {
        let mut scene = Scene::new(Config { ascii, ..demo() });
        for (event, wait_ms) in events {
            scene.wait_ms(wait_ms);
            scene.happen(event);
        }
        let before = format!("{:?}", scene.model);
        let once = buffer(&scene, width, height);
        prop_assert_eq!(once, buffer(&scene, width, height));
        prop_assert_eq!(format!("{:?}", scene.model), before, "drawing writes nothing");
    }

    #[test]
    fn a_route_is_confirmed_only_after_its_confirmation(
        events in prop::collection::vec(any_event(), 0..80),
    ) {
        let mut scene = Scene::new(Config::default());
        let mut acknowledged = Vec::new();
        for event in events {
            if let Event::Command { id, status: CommandStatus::Confirmed { .. } } = &event {
                acknowledged.push(format!("{} ", id.0));
            }
            scene.event(event);
        }
        let screen = screen(&scene, 200, 80);
        let is_claim = |row: &&str| {
            let states = ["✔ confirmed", "✔ driving", "✔ done"];
            let is_route = row.split_once(' ').is_some_and(|(_, asked)| {
                ["route of ", "goto "].iter().any(|route| asked.starts_with(route))
            });
            is_route && states.iter().any(|state| row.contains(state))
        };
        for row in screen.lines().filter(is_claim) {
            let known = acknowledged.iter().any(|id| row.starts_with(id));
            prop_assert!(known, "{row}");
        }
    }
}

/// The cost of a frame as counts: number of dots drawn, and of entries kept.
fn cost(scene: &Scene) -> (u64, usize) {
    use super::super::raster::DRAWN;
    DRAWN.set(0);
    buffer(scene, 120, 40);
    let dots = DRAWN.replace(0);
    let chart = &scene.model.facts.chart;
    let trail = chart.trail.recent().count() + chart.trail.older().count();
    let log = scene.model.facts.log.newest_first().count();
    (dots, trail + scene.model.facts.plots.size() + log)
}

#[test]
fn a_day_costs_no_more_than_its_first_hour() {
    let mut scene = flight(Config::default());
    let drive = |scene: &mut Scene, lines: u32| {
        for n in 0..lines {
            // Laps through a house of 40 by 40 ft.
            let turn = f64::from(n) / 97.0;
            scene.state.x_tenths_in = (2400.0 * (turn * 1.5).sin()) as i32;
            scene.state.y_tenths_in = (2400.0 * turn.cos()) as i32;
            scene.state.bump = [Bump::None, Bump::Left][n as usize / 50 % 2];
            scene.hear();
        }
    };
    drive(&mut scene, 3 * 3600);
    let (hour_dots, hour_kept) = cost(&scene);
    drive(&mut scene, 5 * 3 * 3600);
    let (later_dots, later_kept) = cost(&scene);
    assert!(later_kept <= hour_kept + 512, "{hour_kept}, {later_kept}");
    assert!(
        later_dots <= hour_dots + hour_dots / 4,
        "{hour_dots}, {later_dots}"
    );
    assert!(later_dots < 60_000, "{later_dots}");
}
