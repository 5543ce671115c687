//! What holds of the screen whatever happens.

use proptest::prelude::*;

use super::*;
use crate::model::testing::any_event;

proptest! {
    #![proptest_config(ProptestConfig { cases: 128, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn nothing_panics_and_drawing_twice_draws_the_same(
        events in prop::collection::vec((any_event(), 0_u64..5000), 0..60),
        width in 1_u16..=250,
        height in 1_u16..=80,
        ascii in any::<bool>(),
    ) {
        let mut scene = Scene::new(Config { ascii, ..demo() });
        for (event, wait_ms) in events {
            scene.wait_ms(wait_ms);
            scene.event(event);
        }
        let before = format!("{:?}", scene.model);
        let once = buffer(&scene, width, height);
        prop_assert_eq!(once, buffer(&scene, width, height));
        prop_assert_eq!(format!("{:?}", scene.model), before, "drawing writes nothing");
    }

    #[test]
    fn a_row_says_active_only_with_a_digest_that_the_robot_acknowledged(
        events in prop::collection::vec(any_event(), 0..80),
    ) {
        let mut scene = Scene::new(Config::default());
        let mut acknowledged = Vec::new();
        for event in events {
            if let Event::Command { id, step: CommandStep::Proven { digest: Some(digest) } } = &event {
                acknowledged.push((format!("{} ", id.0), format!("ACTIVE {digest:08X}")));
            }
            scene.event(event);
        }
        let screen = screen(&scene, 200, 80);
        for row in screen.lines().filter(|row| row.contains("✔ ACTIVE ")) {
            let known = acknowledged
                .iter()
                .any(|(id, active)| row.starts_with(id) && row.contains(active));
            prop_assert!(known, "{row}");
        }
    }
}
