//! The ground's own estimate of the pose, on the map.

use groundwave_mapping::{CorrectedPose, Ellipse};
use groundwave_protocol::telemetry::Reading;

use super::Screen;
use super::projection::Projection;
use super::raster::{Ink, Raster};
use crate::model::chart::{Pose, ROBOT_RADIUS_IN};
use crate::model::ground::Statement;

/// Minimum long semi-axis of an ellipse that is drawn, inches.
const ELLIPSE_LEAST_IN: f64 = 3.0 * ROBOT_RADIUS_IN;

impl Screen<'_> {
    /// The ground's own estimate of the pose, if its ellipse would not be hidden by the robot.
    pub(super) fn estimate(&self) -> Option<CorrectedPose> {
        match self.facts.ground.statement? {
            Statement::Pose(pose) if pose.ellipse.long_in > ELLIPSE_LEAST_IN => {
                self.facts.robot.measures(Reading::Sonars).then_some(pose)
            }
            Statement::Pose(_) | Statement::HeadingUnknown | Statement::Lifted => None,
        }
    }

    /// Draws the estimate's heading and 95 % ellipse.
    pub(super) fn estimate_lines(&self, projection: &Projection, raster: &mut Raster) {
        if let Some(pose) = self.estimate() {
            let center = (pose.x_in, pose.y_in);
            dashed_ellipse(raster, projection, center, pose.ellipse, Ink::Draft);
            let nose = Pose {
                x_in: pose.x_in,
                y_in: pose.y_in,
                theta_deg: pose.theta_deg.value,
            }
            .ahead(0.0, 2.0 * ROBOT_RADIUS_IN);
            raster.line(projection.dot(center), projection.dot(nose), 1, Ink::Draft);
        }
    }
}

/// Draws a dashed ellipse.
pub(super) fn dashed_ellipse(
    raster: &mut Raster,
    projection: &Projection,
    (x_in, y_in): (f64, f64),
    ellipse: Ellipse,
    ink: Ink,
) {
    const DASHES: u32 = 12;
    const DOTS: u32 = 6;
    let whole = f64::from(DASHES * 2 * DOTS);
    for n in (0..DASHES * 2 * DOTS).filter(|n| (n / DOTS).is_multiple_of(2)) {
        let (east_in, north_in) = edge(ellipse, f64::from(n) / whole * std::f64::consts::TAU);
        let (x, y) = projection.dot((x_in + east_in, y_in + north_in));
        raster.dot(x, y, ink);
    }
}

/// A point of an ellipse's edge from its middle, inches east and north.
fn edge(ellipse: Ellipse, turn_rad: f64) -> (f64, f64) {
    let (sin, cos) = ellipse.bearing_deg.to_radians().sin_cos();
    let (across, along) = turn_rad.sin_cos();
    let (along_in, across_in) = (along * ellipse.long_in, across * ellipse.short_in);
    (
        along_in * sin + across_in * cos,
        along_in * cos - across_in * sin,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edge_of_an_ellipse_is_at_its_semi_axes() {
        let ellipse = Ellipse {
            long_in: 20.0,
            short_in: 5.0,
            bearing_deg: 30.0,
        };
        let quarter = std::f64::consts::FRAC_PI_2;
        for (turns, distance_in, bearing_deg) in [(0.0, 20.0, 30.0), (1.0, 5.0, 120.0)] {
            let (east_in, north_in) = edge(ellipse, turns * quarter);
            assert!((east_in.hypot(north_in) - distance_in).abs() < 1e-9);
            assert!((east_in.atan2(north_in).to_degrees() - bearing_deg).abs() < 1e-9);
        }
    }
}
