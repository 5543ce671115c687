//! Converts the robot's inches and degrees to metres, radians and quaternions.

use foxglove::messages::{Pose, Quaternion, Timestamp, Vector3};

/// Frame of the robot's odometry; its origin is the pose at the last odometer reset.
pub const ODOM: &str = "odom";

/// Frame of the floor, as the ground knows it. It is [`ODOM`] without the odometer's error since the robot's pose was last set.
pub const MAP: &str = "map";

/// Frame that moves with the robot.
pub const BASE: &str = "base_link";

/// Metres per inch.
pub(super) const M_PER_IN: f64 = 0.0254;

const S_NS: u64 = 1_000_000_000;

/// The robot's pose on the floor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place {
    pub(super) x_m: f64,
    pub(super) y_m: f64,
    /// Angle counter-clockwise from x, radians.
    pub(super) yaw_rad: f64,
}

impl Place {
    /// Converts the robot's coordinates: +Y ahead, +X right, degrees clockwise from +Y.
    pub(super) fn of_robot(x_tenths_in: i32, y_tenths_in: i32, theta_deg: u16) -> Self {
        Self::of_inches(
            f64::from(x_tenths_in) / 10.0,
            f64::from(y_tenths_in) / 10.0,
            f64::from(theta_deg),
        )
    }

    /// Converts inches and degrees of the robot's axes.
    pub(super) fn of_inches(x_in: f64, y_in: f64, theta_deg: f64) -> Self {
        let (x_m, y_m) = odom(x_in, y_in);
        Self {
            x_m,
            y_m,
            yaw_rad: -theta_deg.to_radians(),
        }
    }

    /// The origin of the frame in which this place is `there`.
    pub(super) fn origin_of_frame_with(self, there: Self) -> Self {
        let yaw_rad = self.yaw_rad - there.yaw_rad;
        let (sin, cos) = yaw_rad.sin_cos();
        Self {
            x_m: self.x_m - (cos * there.x_m - sin * there.y_m),
            y_m: self.y_m - (sin * there.x_m + cos * there.y_m),
            yaw_rad,
        }
    }

    pub(super) const fn translation(self) -> Vector3 {
        vector([self.x_m, self.y_m, 0.0])
    }

    pub(super) fn rotation(self) -> Quaternion {
        let (z, w) = (self.yaw_rad / 2.0).sin_cos();
        Quaternion {
            x: 0.0,
            y: 0.0,
            z,
            w,
        }
    }

    pub(super) fn pose(self) -> Pose {
        Pose {
            position: Some(self.translation()),
            orientation: Some(self.rotation()),
        }
    }

    /// The point at a distance straight ahead.
    pub(super) fn ahead(self, distance_m: f64) -> (f64, f64) {
        let (sin, cos) = self.yaw_rad.sin_cos();
        (self.x_m + cos * distance_m, self.y_m + sin * distance_m)
    }
}

/// Converts a point in the robot's inches to metres in [`ODOM`].
pub(super) fn odom(x_in: f64, y_in: f64) -> (f64, f64) {
    // Subtracted from zero, because negating zero would write -0.
    (y_in * M_PER_IN, 0.0 - x_in * M_PER_IN)
}

pub(super) const fn vector([x, y, z]: [f64; 3]) -> Vector3 {
    Vector3 { x, y, z }
}

/// An upright pose at a point.
pub(super) const fn upright(at_m: [f64; 3]) -> Pose {
    Pose {
        position: Some(vector(at_m)),
        orientation: Some(Quaternion {
            x: 0.0,
            y: 0.0,
            z: 0.0,
            w: 1.0,
        }),
    }
}

pub(super) fn timestamp(since_1970_ns: u64) -> Timestamp {
    let s = u32::try_from(since_1970_ns / S_NS).unwrap_or(u32::MAX);
    Timestamp::new(s, (since_1970_ns % S_NS) as u32)
}
