//! Where the robot was lately, in a message of bounded size that is sent now and then.

use super::geometry::{ODOM, Place, put_timestamp};
use super::newest::Newest;
use crate::protobuf::Protobuf;

/// Points remembered: the newest 250 ft or so.
const POINTS_MAX: usize = 512;

/// Distance between two of them, metres (6 in).
const SPACING_M: f64 = 0.1524;

/// The path goes out again when it has so many new points,
const FRESH_MAX: usize = 32;

/// or when it is so old and has any.
const AGE_MAX_NS: u64 = 30_000_000_000;

/// The newest part of the robot's way.
#[derive(Debug, Default)]
pub(super) struct Path {
    poses: Newest,
    last: Option<Place>,
    /// Points that are not in the message sent last.
    fresh: usize,
    sent_ns: Option<u64>,
}

impl Path {
    /// Takes where the robot is; returns whether the path is due.
    pub(super) fn handle_place(&mut self, now_ns: u64, place: Place) -> bool {
        let is_new = self
            .last
            .is_none_or(|last| (place.x_m - last.x_m).hypot(place.y_m - last.y_m) >= SPACING_M);
        if is_new {
            self.poses.push(POINTS_MAX, 3, |to| place.pose(to));
            self.last = Some(place);
            self.fresh += 1;
        }
        let is_old = |sent_ns| now_ns.saturating_sub(sent_ns) >= AGE_MAX_NS;
        let is_due = self.fresh >= FRESH_MAX || self.fresh > 0 && self.sent_ns.is_none_or(is_old);
        if is_due {
            self.fresh = 0;
            self.sent_ns = Some(now_ns);
        }
        is_due
    }

    /// A `PosesInFrame`.
    pub(super) fn encode(&self, now_ns: u64, to: &mut Vec<u8>) {
        put_timestamp(to, now_ns);
        to.string(2, ODOM);
        self.poses.encode(to);
    }

    /// The next place is followed by the whole path.
    pub(super) fn tell_anew(&mut self) {
        self.sent_ns = None;
        self.fresh = self.poses.count();
    }

    /// The robot reckons from elsewhere now: the old points mean nothing there.
    pub(super) fn forget(&mut self) {
        self.poses.clear();
        self.last = None;
        self.fresh = 0;
    }
}
