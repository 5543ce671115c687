//! Where the robot was lately, in a message of bounded size that is sent now and then.

use std::collections::VecDeque;

use foxglove::messages::PosesInFrame;

use super::geometry::{ODOM, Place, timestamp};

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
    places: VecDeque<Place>,
    /// Points that are not in the message sent last.
    fresh: usize,
    sent_ns: Option<u64>,
    message: PosesInFrame,
}

impl Path {
    /// Takes where the robot is; returns the path when it is due.
    pub(super) fn handle_place(&mut self, now_ns: u64, place: Place) -> Option<&PosesInFrame> {
        let is_new = self
            .places
            .back()
            .is_none_or(|last| (place.x_m - last.x_m).hypot(place.y_m - last.y_m) >= SPACING_M);
        if is_new {
            if self.places.len() == POINTS_MAX {
                self.places.pop_front();
            }
            self.places.push_back(place);
            self.fresh += 1;
        }
        let is_old = |sent_ns| now_ns.saturating_sub(sent_ns) >= AGE_MAX_NS;
        let is_due = self.fresh >= FRESH_MAX || self.fresh > 0 && self.sent_ns.is_none_or(is_old);
        if !is_due {
            return None;
        }
        self.fresh = 0;
        self.sent_ns = Some(now_ns);
        self.message.timestamp = Some(timestamp(now_ns));
        if self.message.frame_id.is_empty() {
            ODOM.clone_into(&mut self.message.frame_id);
        }
        self.message.poses.clear();
        self.message
            .poses
            .extend(self.places.iter().map(|place| place.pose()));
        Some(&self.message)
    }

    /// The next place is followed by the whole path.
    pub(super) fn tell_anew(&mut self) {
        self.sent_ns = None;
        self.fresh = self.places.len();
    }

    /// The robot reckons from elsewhere now: the old points mean nothing there.
    pub(super) fn forget(&mut self) {
        self.places.clear();
        self.fresh = 0;
    }
}
