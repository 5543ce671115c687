//! Rectangles on the floor, and the one to show while the map follows the robot.

/// Step by which the known bounds grow, inches; keeps the picture from moving constantly.
const STEP_IN: f64 = 24.0;

/// Minimum remaining share of the margin; below it, another part of the floor is shown.
const LEFT: f64 = 1.0 / 3.0;

/// Maximum ratio of the shown width or height to the necessary one; above it, a smaller part is shown.
const GENEROUS: f64 = 1.5;

/// A rectangle on the floor, inches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds {
    pub(crate) min: (f64, f64),
    pub(crate) max: (f64, f64),
}

impl Default for Bounds {
    fn default() -> Self {
        Self::at((0.0, 0.0)).grown(2.0 * STEP_IN)
    }
}

impl Bounds {
    /// A single point.
    pub(crate) const fn at(point: (f64, f64)) -> Self {
        Self {
            min: point,
            max: point,
        }
    }

    /// A rectangle of a width and height around its middle.
    pub(crate) fn around((x_in, y_in): (f64, f64), (width_in, height_in): (f64, f64)) -> Self {
        let (across, up) = (width_in / 2.0, height_in / 2.0);
        Self {
            min: (x_in - across, y_in - up),
            max: (x_in + across, y_in + up),
        }
    }

    /// Extends to a point, in steps.
    pub(super) fn include(&mut self, x_in: f64, y_in: f64) {
        let down = |value: f64| (value / STEP_IN).floor() * STEP_IN;
        let up = |value: f64| (value / STEP_IN).ceil() * STEP_IN;
        if x_in < self.min.0 {
            self.min.0 = down(x_in);
        }
        if y_in < self.min.1 {
            self.min.1 = down(y_in);
        }
        if x_in > self.max.0 {
            self.max.0 = up(x_in);
        }
        if y_in > self.max.1 {
            self.max.1 = up(y_in);
        }
    }

    /// Width and height, inches.
    pub(crate) fn extent(&self) -> (f64, f64) {
        (self.max.0 - self.min.0, self.max.1 - self.min.1)
    }

    pub(crate) fn middle(&self) -> (f64, f64) {
        (
            f64::midpoint(self.min.0, self.max.0),
            f64::midpoint(self.min.1, self.max.1),
        )
    }

    /// The smallest rectangle around two rectangles.
    pub(crate) const fn union(self, other: Self) -> Self {
        Self {
            min: (self.min.0.min(other.min.0), self.min.1.min(other.min.1)),
            max: (self.max.0.max(other.max.0), self.max.1.max(other.max.1)),
        }
    }

    /// The rectangle enlarged on every side, inches.
    fn grown(self, by_in: f64) -> Self {
        Self {
            min: (self.min.0 - by_in, self.min.1 - by_in),
            max: (self.max.0 + by_in, self.max.1 + by_in),
        }
    }

    /// The part of the floor that shows this rectangle with a margin: the part shown so far if it has room
    /// for the rectangle and is not much too large.
    pub(super) fn followed_from(self, shown: Option<Self>, margin_in: f64) -> Self {
        let ideal = self.grown(margin_in);
        let still_good = shown.filter(|shown| {
            let (width_in, height_in) = shown.extent();
            let (ideal_width_in, ideal_height_in) = ideal.extent();
            shown.union(self.grown(margin_in * LEFT)) == *shown
                && width_in <= ideal_width_in * GENEROUS
                && height_in <= ideal_height_in * GENEROUS
        });
        still_good.unwrap_or(ideal)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const MARGIN_IN: f64 = 108.0;

    proptest! {
        /// The robot, its route and its target are always well inside, and a second call changes nothing.
        #[test]
        fn robot_route_and_target_are_inside(
            points in prop::collection::vec((-2000.0..2000.0, -2000.0..2000.0), 1..40)
        ) {
            let mut shown = None;
            for pair in points.windows(2) {
                let needed = Bounds::at(pair[0]).union(Bounds::at(pair[1]));
                let now = needed.followed_from(shown, MARGIN_IN);
                prop_assert_eq!(now.union(needed.grown(MARGIN_IN * LEFT)), now);
                prop_assert_eq!(needed.followed_from(Some(now), MARGIN_IN), now);
                shown = Some(now);
            }
        }
    }

    #[test]
    fn a_robot_that_goes_to_and_fro_moves_nothing() {
        let at = |x_in: f64| Bounds::at((x_in, 0.0));
        let shown = at(0.0).followed_from(None, MARGIN_IN);
        for x_in in [20.0, -20.0, 60.0, -60.0, 71.0] {
            assert_eq!(
                at(x_in).followed_from(Some(shown), MARGIN_IN),
                shown,
                "{x_in}"
            );
        }
        let moved = at(73.0).followed_from(Some(shown), MARGIN_IN);
        assert_ne!(moved, shown);
        assert_eq!(
            at(60.0).followed_from(Some(moved), MARGIN_IN),
            moved,
            "back a little"
        );
    }

    #[test]
    fn on_the_way_to_a_target_the_picture_closes_in_by_few_steps() {
        let mut shown = None;
        let mut steps = 0;
        for x_in in 0..1200 {
            let needed = Bounds::at((f64::from(x_in), 0.0)).union(Bounds::at((1200.0, 0.0)));
            let now = needed.followed_from(shown, MARGIN_IN);
            steps += usize::from(shown.is_some_and(|shown| shown != now));
            shown = Some(now);
        }
        assert!((2..=6).contains(&steps), "{steps}");
    }
}
