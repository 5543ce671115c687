//! The ground's estimate of the robot's pose and of the floor, as protobuf messages.
//!
//! The station makes the estimate ([`/station`](crate::topics::Topic::Station)); `/pose_corrected`, `/tf_map` and `/map` are derived from it.

use prost::Message as _;
use serde::Serialize;

use crate::station_event::EVENT_BYTES_MAX;

/// Maximum number of cells of a floor: a square of 128 ft.
const CELLS_MAX: usize = 1 << 18;

/// Maximum number of cells for each run of equal ones; a hostile message of a few bytes makes no large map. Floors that robots saw
/// had 9 to 38.
const CELLS_A_RUN_MAX: usize = 128;

/// Maximum length of a floor, bytes; an event has some bytes more.
const FLOOR_BYTES_MAX: usize = EVENT_BYTES_MAX - 64;

/// The ground's estimate of the robot's pose: inches, and degrees clockwise from +Y.
#[derive(Clone, Copy, PartialEq, prost::Message, Serialize)]
pub struct EstimateMessage {
    /// X of the robot's own pose, inches.
    #[prost(double, tag = 1)]
    pub odometer_x_in: f64,
    /// Y of the robot's own pose, inches.
    #[prost(double, tag = 2)]
    pub odometer_y_in: f64,
    /// Heading of the robot's own pose, degrees.
    #[prost(double, tag = 3)]
    pub odometer_theta_deg: f64,
    /// The estimate; `None` while the heading may be wrong by a quarter turn.
    #[prost(message, optional, tag = 4)]
    pub corrected: Option<CorrectedMessage>,
}

/// A pose with its 95 % intervals, in the frame in which the robot's pose was last set.
#[derive(Clone, Copy, PartialEq, prost::Message, Serialize)]
pub struct CorrectedMessage {
    /// X, inches.
    #[prost(double, tag = 1)]
    pub x_in: f64,
    /// Y, inches.
    #[prost(double, tag = 2)]
    pub y_in: f64,
    /// Heading, degrees.
    #[prost(double, tag = 3)]
    pub theta_deg: f64,
    /// Half of the heading's interval, degrees.
    #[prost(double, tag = 4)]
    pub theta_half_deg: f64,
    /// Longer half axis of the position's ellipse, inches.
    #[prost(double, tag = 5)]
    pub long_in: f64,
    /// Shorter half axis, inches.
    #[prost(double, tag = 6)]
    pub short_in: f64,
    /// Bearing of the longer axis, degrees.
    #[prost(double, tag = 7)]
    pub bearing_deg: f64,
}

/// The floor that the robot has seen, in the frame of [`CorrectedMessage`].
#[derive(Clone, PartialEq, prost::Message)]
pub struct FloorMessage {
    /// X of the lower left corner, inches.
    #[prost(double, tag = 1)]
    pub corner_x_in: f64,
    /// Y of the lower left corner, inches.
    #[prost(double, tag = 2)]
    pub corner_y_in: f64,
    /// Side of a cell, inches.
    #[prost(double, tag = 3)]
    pub cell_in: f64,
    /// Number of cells along X.
    #[prost(uint32, tag = 4)]
    pub columns: u32,
    /// Runs of equal cells, row by row from the corner on: four times their number, plus 0 for unknown, 1 for free, 2 for an
    /// obstacle and 3 for a drop.
    #[prost(uint32, repeated, tag = 5)]
    pub runs: Vec<u32>,
}

/// What is known of a cell of the floor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FloorKind {
    /// Nothing, or not enough.
    Unknown,
    /// The robot drove over it, or saw nothing in it.
    Free,
    /// Something stands there.
    Obstacle,
    /// The floor ends there.
    Drop,
}

impl FloorMessage {
    /// A floor of cells with this side, row by row; `None` if it is too large for a recording.
    #[must_use]
    pub fn new(
        corner_in: (f64, f64),
        cell_in: f64,
        columns: usize,
        cells: impl IntoIterator<Item = FloorKind>,
    ) -> Option<Self> {
        let mut runs: Vec<u32> = Vec::new();
        for kind in cells {
            match runs.last_mut() {
                Some(run) if *run % 4 == kind as u32 => *run += 4,
                _ => runs.push(4 + kind as u32),
            }
        }
        let floor = Self {
            corner_x_in: corner_in.0,
            corner_y_in: corner_in.1,
            cell_in,
            columns: u32::try_from(columns).ok()?,
            runs,
        };
        let is_readable = floor.cells().is_some() && floor.encoded_len() <= FLOOR_BYTES_MAX;
        is_readable.then_some(floor)
    }

    /// The cells, row by row; `None` if they make no rectangle, or one that is too large.
    #[must_use]
    pub fn cells(&self) -> Option<Vec<FloorKind>> {
        const KINDS: [FloorKind; 4] = [
            FloorKind::Unknown,
            FloorKind::Free,
            FloorKind::Obstacle,
            FloorKind::Drop,
        ];
        let columns = usize::try_from(self.columns).ok()?;
        let most = CELLS_MAX.min(self.runs.len().saturating_mul(CELLS_A_RUN_MAX));
        let count: u64 = self.runs.iter().map(|run| u64::from(run / 4)).sum();
        let count = usize::try_from(count).ok().filter(|it| *it <= most)?;
        if count == 0 || columns == 0 || !count.is_multiple_of(columns) {
            return None;
        }
        let cells = self.runs.iter().flat_map(|run| {
            let kind = KINDS[(run % 4) as usize];
            std::iter::repeat_n(kind, (run / 4) as usize)
        });
        Some(cells.collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::station_event::{StationEvent, StationEventKind};
    use proptest::prelude::*;

    /// A run of a cell takes a byte, and the other fields 15; a reader takes no longer event.
    #[test]
    fn floor_is_short_enough_to_be_read() {
        let floor = |runs: usize| {
            let kinds = [FloorKind::Free, FloorKind::Obstacle].into_iter().cycle();
            FloorMessage::new((0.0, 0.0), 3.0, 1, kinds.take(runs))
        };
        let runs = FLOOR_BYTES_MAX - 15;
        let most = StationEvent::from(StationEventKind::Floor(floor(runs).unwrap()));
        assert!((EVENT_BYTES_MAX - 64..=EVENT_BYTES_MAX).contains(&most.encoded_len()));
        assert_eq!(floor(FLOOR_BYTES_MAX), None);
    }

    fn kind() -> impl Strategy<Value = FloorKind> {
        prop::sample::select(vec![
            FloorKind::Unknown,
            FloorKind::Free,
            FloorKind::Obstacle,
            FloorKind::Drop,
        ])
    }

    proptest! {
        #[test]
        fn cells_come_back(columns in 1..9_usize, rows in prop::collection::vec(kind(), 1..9)) {
            let cells: Vec<_> = rows.iter().flat_map(|kind| vec![*kind; columns]).collect();
            let floor = FloorMessage::new((3.0, -6.0), 3.0, columns, cells.clone()).unwrap();
            prop_assert_eq!(floor.cells(), Some(cells));
        }
    }

    #[test]
    fn damaged_floors_are_refused() {
        let floor = |columns, runs: &[u32]| FloorMessage {
            columns,
            runs: runs.to_vec(),
            ..FloorMessage::default()
        };
        assert_eq!(
            floor(2, &[4 * 4 + 1]).cells(),
            Some(vec![FloorKind::Free; 4])
        );
        for damaged in [
            floor(0, &[4]),
            floor(1, &[]),
            floor(1, &[3]),
            floor(3, &[16]),
            floor(1, &[4 * 129]),
            floor(1, &[u32::MAX; 4096]),
        ] {
            assert_eq!(damaged.cells(), None, "{damaged:?}");
        }
    }
}
