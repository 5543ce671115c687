//! The latest part of the path, in a message of bounded size.

use std::collections::VecDeque;

use foxglove::messages::{Pose, PosesInFrame};

use super::geometry::{ODOM, Place, timestamp};

/// Maximum number of points: about 250 ft of path.
const POINTS_MAX: usize = 512;

/// Distance between two points, metres (6 in).
const SPACING_M: f64 = 0.1524;

/// Number of new points after which a message is due.
const FRESH_MAX: usize = 32;

/// Maximum age of the last message while there are new points, nanoseconds.
const AGE_MAX_NS: u64 = 30_000_000_000;

/// The newest part of the path.
#[derive(Debug, Default)]
pub(super) struct Path {
    poses: VecDeque<Pose>,
    last: Option<Place>,
    /// Number of points that are not in the latest message.
    fresh: usize,
    sent_ns: Option<u64>,
}

impl Path {
    /// Takes the robot's pose; returns whether the path is due.
    pub(super) fn handle_place(&mut self, now_ns: u64, place: Place) -> bool {
        let is_new = self
            .last
            .is_none_or(|last| (place.x_m - last.x_m).hypot(place.y_m - last.y_m) >= SPACING_M);
        if is_new {
            if self.poses.len() == POINTS_MAX {
                self.poses.pop_front();
            }
            self.poses.push_back(place.pose());
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

    pub(super) fn message(&self, now_ns: u64) -> PosesInFrame {
        PosesInFrame {
            timestamp: Some(timestamp(now_ns)),
            frame_id: ODOM.to_owned(),
            poses: self.poses.iter().copied().collect(),
        }
    }

    /// Removes all points after an odometer reset, because their frame is no longer valid.
    pub(super) fn forget(&mut self) {
        self.poses.clear();
        self.last = None;
        self.fresh = 0;
    }
}
