//! Downward-looking detectors of a missing floor.

use sr04_firmware::board::Edges;

use super::View;
use crate::faults::{EDGE_SENSORS, Faulty};
use crate::scene::Scene;

/// Spots of the detectors on the right and the input of each: inches to the right and ahead. Each has a twin on the
/// left. They form a ring around the body, 2 in apart, and 1 in behind the caster, which follows closely: an edge of any
/// shape, a corner too, reaches a spot before a wheel or the caster.
const RIGHT_SPOTS_IN: [(f64, f64, Edges); 13] = [
    (2.0, 5.7, Edges::AHEAD_RIGHT),
    (3.7, 4.9, Edges::AHEAD_RIGHT),
    (5.4, 4.0, Edges::AHEAD_RIGHT),
    (6.4, 2.4, Edges::BESIDE_RIGHT),
    (6.8, 0.8, Edges::BESIDE_RIGHT),
    (6.8, -0.8, Edges::BESIDE_RIGHT),
    (6.3, -2.8, Edges::BEHIND_RIGHT),
    (5.4, -4.0, Edges::BEHIND_RIGHT),
    (4.7, -5.0, Edges::BEHIND_RIGHT),
    (3.6, -5.9, Edges::BEHIND_RIGHT),
    (2.7, -6.4, Edges::BEHIND_RIGHT),
    (1.8, -6.7, Edges::BEHIND_RIGHT),
    (0.9, -6.9, Edges::BEHIND_RIGHT),
];

/// Spots of the detectors at the middle of the bumper and behind the caster.
const MIDDLE_SPOTS_IN: [(f64, Edges); 2] = [(5.9, Edges::AHEAD), (-6.9, Edges::BEHIND)];

const _: () = assert!(2 * RIGHT_SPOTS_IN.len() + MIDDLE_SPOTS_IN.len() == EDGE_SENSORS);

/// Inputs whose detectors see no floor.
pub(crate) fn detect(scene: &Scene, view: View, faulty: &mut Faulty) -> Edges {
    if scene.drops.is_empty() && !faulty.has_edge_faults() {
        return Edges::NONE;
    }
    let sides = RIGHT_SPOTS_IN
        .iter()
        .flat_map(|&(right_in, ahead_in, input)| {
            [
                (right_in, ahead_in, input),
                (-right_in, ahead_in, twin(input)),
            ]
        });
    let middle = MIDDLE_SPOTS_IN
        .iter()
        .map(|&(ahead_in, input)| (0.0, ahead_in, input));
    let mut edges = Edges::NONE;
    for (spot, (right_in, ahead_in, input)) in sides.chain(middle).enumerate() {
        let is_over = scene.drops.has(view.point(right_in, ahead_in));
        if faulty.edge(spot, is_over) {
            edges = edges.or(input);
        }
    }
    edges
}

/// The left input of a right one.
const fn twin(right: Edges) -> Edges {
    match right {
        Edges::AHEAD_RIGHT => Edges::AHEAD_LEFT,
        Edges::BESIDE_RIGHT => Edges::BESIDE_LEFT,
        _ => Edges::BEHIND_LEFT,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::faults::Faults;
    use crate::testing::{landing, view_at};

    fn detect(scene: &Scene, view: View) -> Edges {
        super::detect(scene, view, &mut Faulty::new(Faults::default(), 1))
    }

    #[test]
    fn each_detector_sees_an_edge_below_its_spot() {
        // No floor north of y = 120.
        let scene = landing();
        let edges = |y_in, theta_deg| detect(&scene, view_at(60.0, y_in, theta_deg));
        assert_eq!(edges(114.0, 0.0), Edges::NONE);
        assert_eq!(edges(114.2, 0.0), Edges::AHEAD);
        assert_eq!(edges(116.5, 0.0), Edges::FRONT);
        assert_eq!(edges(113.2, 180.0), Edges::REAR);
        assert_eq!(edges(113.5, 90.0), Edges::BESIDE_LEFT);
        assert_eq!(edges(113.5, -90.0), Edges::BESIDE_RIGHT);
    }

    #[test]
    fn edges_are_seen_before_a_wheel_reaches_them() {
        let scene = landing();
        for tenth in 0..3600 {
            let theta_deg = f64::from(tenth) / 10.0;
            let along = crate::geometry::heading(theta_deg.to_radians()).y;
            if along.abs() < 1e-3 {
                continue;
            }
            // Move north, nose or tail first, until a detector sees the edge.
            let mut y_in = 100.0;
            while !detect(&scene, view_at(60.0, y_in, theta_deg)).any() {
                y_in += 0.01;
            }
            let view = view_at(60.0, y_in, theta_deg);
            for (right_in, ahead_in) in [(-5.05, 0.0), (5.05, 0.0), (0.0, -5.0)] {
                let wheel = view.point(right_in, ahead_in);
                assert!(!scene.drops.has(wheel), "facing {theta_deg}: {wheel}");
            }
        }
    }
}
