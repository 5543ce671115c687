//! The readings on a path.

use std::f64::consts::TAU;
use std::sync::Arc;

use crate::pose::Pose;
use crate::sensors::Readings;

/// Maximum views of a trail: 1.8 kB. Turns on the spot have many; every other one is dropped.
const VIEWS_MAX: usize = 128;

/// Steps of a view's position and heading: per inch, and per turn.
const PER_IN: f64 = 16.0;
const PER_TURN: f64 = 65_536.0;

/// Readings and the pose from which they were made.
#[derive(Clone, Copy, Debug)]
pub(crate) struct View {
    /// X, Y and heading in steps: replays keep many.
    at: [i16; 2],
    heading: u16,
    pub(crate) readings: Readings,
}

impl View {
    fn new(pose: Pose, readings: Readings) -> Self {
        let heading = libm::round(pose.theta_rad / TAU * PER_TURN);
        Self {
            at: [pose.x_in, pose.y_in].map(|it| libm::round(it * PER_IN) as i16),
            heading: heading.rem_euclid(PER_TURN) as u16,
            readings,
        }
    }

    pub(crate) fn pose(&self) -> Pose {
        let [x_in, y_in] = self.at.map(|it| f64::from(it) / PER_IN);
        Pose {
            x_in,
            y_in,
            theta_rad: f64::from(self.heading) / PER_TURN * TAU,
        }
    }
}

/// Views in the order in which they were made.
#[derive(Clone, Debug, Default)]
pub(crate) struct Trail(Vec<View>);

impl Trail {
    /// Adds a view.
    pub(crate) fn push(&mut self, pose: Pose, readings: Readings) {
        if self.0.len() == VIEWS_MAX {
            let mut keep = false;
            self.0.retain(|_| {
                keep = !keep;
                keep
            });
        }
        self.0.push(View::new(pose, readings));
    }

    /// The views with other poses.
    pub(crate) fn mapped(&self, pose: impl Fn(Pose) -> Pose) -> Arc<[View]> {
        let views = self.0.iter();
        views
            .map(|view| View::new(pose(view.pose()), view.readings))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use groundwave_protocol::telemetry::StateLine;

    #[test]
    fn memory_is_bounded_and_the_newest_view_is_kept() {
        let readings = Readings::of(&StateLine::BLANK);
        let mut trail = Trail::default();
        for at in 0..10_000 {
            let x_in = f64::from(at % 100);
            trail.push(Pose::default().moved((x_in, 0.0)), readings);
            assert!(trail.0.len() <= VIEWS_MAX);
            assert!((trail.0.last().map_or(0.0, |view| view.pose().x_in) - x_in).abs() < 1e-3);
        }
        assert!(size_of::<View>() <= 14);
    }
}
