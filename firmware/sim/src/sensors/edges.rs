//! Downward-looking detectors of a missing floor.

use sr04_firmware::board::Edges;

use super::View;
use crate::scene::Scene;

/// Spots ahead of and behind a wheel, looked at from the ends of the bumper: inches to the right (mirrored for the
/// left) and ahead. They lie a little outside the wheel's track, so that an edge met at a flat angle reaches a spot
/// before it reaches the wheel.
const AHEAD_OF_WHEEL_IN: (f64, f64) = (5.4, 4.0);
const BEHIND_WHEEL_IN: (f64, f64) = (5.4, -3.0);
/// Spot of the detector at the middle of the bumper.
const CENTER_AHEAD_IN: f64 = 5.8;
/// Spot of the detector behind the caster.
const TAIL_AHEAD_IN: f64 = -5.8;

/// Detectors that see no floor. `rear` combines three of them: behind the caster and behind each wheel.
pub(crate) fn detect(scene: &Scene, view: View) -> Edges {
    if scene.drops.is_empty() {
        return Edges::default();
    }
    let has = |right_in: f64, ahead_in: f64| scene.drops.has(view.point(right_in, ahead_in));
    let (aside, ahead) = AHEAD_OF_WHEEL_IN;
    let (behind_aside, behind) = BEHIND_WHEEL_IN;
    Edges {
        left: has(-aside, ahead),
        center: has(0.0, CENTER_AHEAD_IN),
        right: has(aside, ahead),
        rear: has(0.0, TAIL_AHEAD_IN) || has(-behind_aside, behind) || has(behind_aside, behind),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{landing, view_at};

    #[test]
    fn each_detector_sees_an_edge_below_its_spot() {
        // No floor north of y = 120.
        let scene = landing();
        let edges = |y_in, theta_deg| detect(&scene, view_at(60.0, y_in, theta_deg));
        let none = Edges::default();
        assert_eq!(edges(114.0, 0.0), none);
        assert_eq!(
            edges(114.5, 0.0),
            Edges {
                center: true,
                ..none
            }
        );
        let front = Edges {
            left: true,
            center: true,
            right: true,
            rear: false,
        };
        assert_eq!(edges(116.5, 0.0), front);
        assert_eq!(edges(114.5, 180.0), Edges { rear: true, ..none });
        assert_eq!(
            edges(115.0, 90.0),
            Edges {
                left: true,
                rear: true,
                ..none
            }
        );
        assert_eq!(
            edges(115.0, -90.0),
            Edges {
                right: true,
                rear: true,
                ..none
            }
        );
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
