//! Contacts of the body, and the bumper that yields before the chassis stops.

use crate::geometry::{Vec2, bearing};
use crate::scene::Near;
use crate::world::Material;
use sr04_firmware::board::Switches;

/// Travel of the bumper, inches.
pub(crate) const BUMPER_TRAVEL_IN: f64 = 0.25;
/// Travel at which a switch closes, inches.
const BUMPER_CLOSES_IN: f64 = 0.1;
/// The bumper yields fully up to the first angle to either side, and not at all from the second on.
const BUMPER_FULL_DEG: f64 = 70.0;
const BUMPER_END_DEG: f64 = 80.0;
/// Arcs of the three switches; they overlap, so that a hit between two closes both.
const CENTER_ARC_DEG: f64 = 25.0;
const SIDE_ARC_FROM_DEG: f64 = 15.0;
/// The dock's plate meets the chassis below the bumper when it is this close to straight ahead.
const PLATE_ARC_DEG: f64 = 20.0;

/// A contact of the round body with one solid.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Touch {
    /// Unit direction from the body's centre to the solid, in the plan.
    pub(crate) toward: Vec2,
    /// The same direction in the body's axes: ahead and right.
    pub(crate) ahead: f64,
    pub(crate) right: f64,
    /// Depth of the solid inside the uncompressed outline, inches.
    pub(crate) depth_in: f64,
    /// Depth at which the chassis stops it, inches.
    pub(crate) travel_in: f64,
    bearing_deg: f64,
    /// Impulses of the current step, along and across the direction.
    pub(crate) normal_impulse: f64,
    pub(crate) friction_impulse: f64,
}

impl Touch {
    pub(crate) fn new(near: &Near, radius_in: f64, forward: Vec2, rightward: Vec2) -> Self {
        let ahead = near.toward.dot(forward);
        let right = near.toward.dot(rightward);
        let bearing_deg = bearing(Vec2::new(right, ahead)).to_degrees();
        let taper = (BUMPER_END_DEG - bearing_deg.abs()) / (BUMPER_END_DEG - BUMPER_FULL_DEG);
        let is_below = near.material == Material::Dock && bearing_deg.abs() <= PLATE_ARC_DEG;
        Self {
            toward: near.toward,
            ahead,
            right,
            depth_in: radius_in - near.distance_in,
            travel_in: if is_below {
                0.0
            } else {
                BUMPER_TRAVEL_IN * taper.clamp(0.0, 1.0)
            },
            bearing_deg,
            normal_impulse: 0.0,
            friction_impulse: 0.0,
        }
    }

    /// Closes the switches that this contact presses.
    pub(crate) fn press(&self, switches: &mut Switches) {
        if self.travel_in < BUMPER_CLOSES_IN || self.depth_in < BUMPER_CLOSES_IN {
            return;
        }
        switches.left |= self.bearing_deg <= -SIDE_ARC_FROM_DEG;
        switches.center |= self.bearing_deg.abs() <= CENTER_ARC_DEG;
        switches.right |= self.bearing_deg >= SIDE_ARC_FROM_DEG;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::heading;

    fn pressed_at(bearing_deg: f64) -> Switches {
        pressed_by(Material::Wall, bearing_deg)
    }

    fn pressed_by(material: Material, bearing_deg: f64) -> Switches {
        let near = Near {
            distance_in: 5.3,
            toward: heading(bearing_deg.to_radians()),
            material,
            radius_in: None,
        };
        let mut switches = Switches::default();
        Touch::new(&near, 5.5, Vec2::Y, Vec2::X).press(&mut switches);
        switches
    }

    #[test]
    fn switch_arcs_overlap_and_end_with_the_bumper() {
        let closed = |left, center, right| Switches {
            left,
            center,
            right,
        };
        assert_eq!(pressed_at(0.0), closed(false, true, false));
        assert_eq!(pressed_at(-20.0), closed(true, true, false));
        assert_eq!(pressed_at(20.0), closed(false, true, true));
        assert_eq!(pressed_at(-50.0), closed(true, false, false));
        assert_eq!(pressed_at(74.0), closed(false, false, true));
        assert_eq!(pressed_at(90.0), Switches::default());
        assert_eq!(pressed_at(180.0), Switches::default());
    }

    #[test]
    fn dock_plate_presses_the_bumper_only_at_an_angle() {
        for bearing_deg in [-19.0, 0.0, 19.0] {
            assert!(!pressed_by(Material::Dock, bearing_deg).any());
        }
        assert!(pressed_by(Material::Dock, 40.0).right);
    }
}
