//! Two receivers on the robot that detect the dock's infrared beacon.

use sr04_firmware::board::Sides;

use super::View;
use crate::geometry::{bearing, wrap_deg};
use crate::rng::Rng;
use crate::scene::Scene;
use crate::world::Dock;

/// Reach of the beam, and its random spread as a share, inches.
const REACH_IN: f64 = 132.0;
const REACH_SPREAD: f64 = 0.02;
/// Distance of the beam's slot behind the dock's front, and half of the beam's width.
const BEHIND_IN: f64 = 6.0;
const HALF_LOBE_DEG: f64 = 30.0;
/// Limits of each receiver's field of view from the nose: to the other side and to its own side.
const ACROSS_DEG: f64 = 8.0;
const ASIDE_DEG: f64 = 60.0;
/// Share of ticks at which a receiver misses a visible beam.
const MISSES: f64 = 0.02;
/// Distance before the dock's front at which a ray to the dock ends.
const GAP_IN: f64 = 0.1;

/// Receivers that detect the beacon.
pub(crate) fn detect(scene: &Scene, dock: &Dock, view: View, rng: &mut Rng) -> Sides {
    let reach_in = REACH_IN * (1.0 + REACH_SPREAD * rng.normal());
    let misses = (rng.chance(MISSES), rng.chance(MISSES));
    let offset = dock.front - view.center;
    let from_slot = view.center - (dock.front - dock.facing * BEHIND_IN);
    let off_axis_deg = wrap_deg((bearing(from_slot) - bearing(dock.facing)).to_degrees());
    let distance_in = offset.length();
    let is_lit = -offset.dot(dock.facing) > GAP_IN
        && distance_in < reach_in
        && off_axis_deg.abs() < HALF_LOBE_DEG
        && scene
            .cast(
                view.center,
                offset / distance_in,
                distance_in - GAP_IN,
                |surface| surface.stops_beam,
            )
            .is_none();
    if !is_lit {
        return Sides::default();
    }
    let at_deg = wrap_deg((bearing(offset) - view.theta_rad).to_degrees());
    Sides {
        left: (-ASIDE_DEG..ACROSS_DEG).contains(&at_deg) && !misses.0,
        right: (-ACROSS_DEG..ASIDE_DEG).contains(&at_deg) && !misses.1,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Stream;
    use crate::testing::{docking, view_at};

    /// Whether the left and right receivers detect the beacon at more than 80 of 100 ticks.
    fn seen(scene: &Scene, view: View) -> (bool, bool) {
        let dock = scene.dock.expect("there is a dock");
        let mut rng = Rng::new(1, Stream::Beacon);
        let sides: Vec<Sides> = (0..100)
            .map(|_| detect(scene, &dock, view, &mut rng))
            .collect();
        let count = |is: fn(&Sides) -> bool| sides.iter().filter(|sides| is(sides)).count() > 80;
        (count(|sides| sides.left), count(|sides| sides.right))
    }

    #[test]
    fn beacon_shows_its_side_from_ten_feet() {
        // The dock stands at (120, 12) and faces north.
        let scene = docking("");
        let at = |theta_deg| seen(&scene, view_at(120.0, 132.0, theta_deg));
        assert_eq!(at(180.0), (true, true));
        assert_eq!(at(150.0), (false, true));
        assert_eq!(at(-150.0), (true, false));
        assert_eq!(at(0.0), (false, false));
        assert_eq!(seen(&scene, view_at(120.0, 180.0, 180.0)), (false, false));
    }

    #[test]
    fn beam_widens_with_distance_and_ends_at_its_edge() {
        let scene = docking("");
        let sees_it = |aside_in: i32, y_in: f64| {
            let mut view = view_at(120.0 + f64::from(aside_in), y_in, 0.0);
            view.theta_rad = bearing(scene.dock.expect("there is a dock").front - view.center);
            seen(&scene, view) == (true, true)
        };
        let widest = |y_in| (0..120).take_while(|&aside| sees_it(aside, y_in)).count();
        assert_eq!(widest(24.0), 11, "(12 + 6) tan 30 is 10.4");
        assert_eq!(widest(84.0), 46, "(72 + 6) tan 30 is 45.03");
    }

    #[test]
    fn walls_hide_the_beacon_and_shoes_do_not() {
        let between = |made_of: &str| {
            docking(&format!(
                "[[clutter]]\nkind = \"box\"\nat = [120, 60]\nsize_in = [40, 4]\nmade_of = \"{made_of}\"\n"
            ))
        };
        let view = view_at(120.0, 100.0, 180.0);
        assert_eq!(seen(&between("wood"), view), (false, false));
        assert_eq!(seen(&between("low"), view), (true, true));
    }
}
