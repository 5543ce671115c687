//! The readings on a path.

use std::sync::Arc;

use crate::pose::Pose;
use crate::sensors::Readings;

/// Maximum views of a trail: 6 KiB. Turns on the spot have many; every other one is dropped.
const VIEWS_MAX: usize = 256;

/// Readings and the pose from which they were made.
#[derive(Clone, Copy, Debug)]
pub(crate) struct View {
    /// X, Y and heading, in inches and radians: half the memory of a pose.
    at: [f32; 3],
    pub(crate) readings: Readings,
}

impl View {
    fn new(pose: Pose, readings: Readings) -> Self {
        Self {
            at: [pose.x_in as f32, pose.y_in as f32, pose.theta_rad as f32],
            readings,
        }
    }

    pub(crate) fn pose(&self) -> Pose {
        let [x_in, y_in, theta_rad] = self.at.map(f64::from);
        Pose {
            x_in,
            y_in,
            theta_rad,
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
            let x_in = f64::from(at);
            trail.push(Pose::default().moved((x_in, 0.0)), readings);
            assert!(trail.0.len() <= VIEWS_MAX);
            assert!((trail.0.last().map_or(0.0, |view| view.pose().x_in) - x_in).abs() < 1e-3);
        }
        assert!(size_of::<View>() <= 24);
    }
}
