//! The robot's inches and degrees as metres, radians and quaternions.

use crate::protobuf::Protobuf;

/// The frame in which the robot reckons: its origin is where the odometer was last reset.
pub const ODOM: &str = "odom";

/// The frame of the robot itself.
pub const BASE: &str = "base_link";

pub(super) const M_PER_IN: f64 = 0.0254;

const S_NS: u64 = 1_000_000_000;

/// The robot's place on the floor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place {
    pub(super) x_m: f64,
    pub(super) y_m: f64,
    /// Counter-clockwise from x.
    pub(super) yaw_rad: f64,
    rotation: Rotation,
}

impl Place {
    /// From the robot's own words: +Y is ahead, +X to the right, degrees clockwise from +Y.
    pub(super) fn of_robot(x_tenths_in: i32, y_tenths_in: i32, theta_deg: u16) -> Self {
        let (x_m, y_m) = odom(f64::from(x_tenths_in) / 10.0, f64::from(y_tenths_in) / 10.0);
        let yaw_rad = -f64::from(theta_deg).to_radians();
        Self {
            x_m,
            y_m,
            yaw_rad,
            rotation: Rotation::of_yaw(yaw_rad),
        }
    }

    /// A `Vector3`.
    pub(super) fn translation(self, to: &mut Vec<u8>) {
        triple(to, [self.x_m, self.y_m, 0.0]);
    }

    /// A `Quaternion`.
    pub(super) fn rotation(self, to: &mut Vec<u8>) {
        self.rotation.encode(to);
    }

    /// A `Pose`.
    pub(super) fn pose(self, to: &mut Vec<u8>) {
        to.message(1, |to| self.translation(to));
        to.message(2, |to| self.rotation(to));
    }

    /// A point so far ahead.
    pub(super) fn ahead(self, distance_m: f64) -> (f64, f64) {
        let (sin, cos) = self.yaw_rad.sin_cos();
        (self.x_m + cos * distance_m, self.y_m + sin * distance_m)
    }
}

/// A rotation around z as a quaternion, whose x and y are zero.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Rotation {
    z: f64,
    w: f64,
}

impl Rotation {
    const NONE: Self = Self { z: 0.0, w: 1.0 };

    fn of_yaw(yaw_rad: f64) -> Self {
        let (z, w) = (yaw_rad / 2.0).sin_cos();
        Self { z, w }
    }

    fn encode(self, to: &mut Vec<u8>) {
        to.nonzero(3, self.z);
        to.nonzero(4, self.w);
    }
}

/// A point of the robot's floor plan, in metres of [`ODOM`].
pub(super) fn odom(x_in: f64, y_in: f64) -> (f64, f64) {
    // Subtracted, because a negated zero would be written as -0.
    (y_in * M_PER_IN, 0.0 - x_in * M_PER_IN)
}

/// A `Vector3` or a `Point3`.
pub(super) fn triple(to: &mut Vec<u8>, [x, y, z]: [f64; 3]) {
    to.nonzero(1, x);
    to.nonzero(2, y);
    to.nonzero(3, z);
}

/// A `Pose` that is upright at a point.
pub(super) fn upright(to: &mut Vec<u8>, at_m: [f64; 3]) {
    to.message(1, |to| triple(to, at_m));
    to.message(2, |to| Rotation::NONE.encode(to));
}

/// Whole seconds, and the nanoseconds that are left.
fn seconds(since_1970_ns: u64) -> [u32; 2] {
    let s = u32::try_from(since_1970_ns / S_NS).unwrap_or(u32::MAX);
    [s, (since_1970_ns % S_NS) as u32]
}

/// The field `timestamp`, which is the first of every message that has it.
pub(super) fn put_timestamp(to: &mut Vec<u8>, since_1970_ns: u64) {
    to.message(1, |to| {
        let [s, ns] = seconds(since_1970_ns);
        if s != 0 {
            to.uint32(1, s);
        }
        if ns != 0 {
            to.uint32(2, ns);
        }
    });
}
