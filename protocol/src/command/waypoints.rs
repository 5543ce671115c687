//! Frame `W`: waypoints of a list being staged.
//!
//! ```text
//! W  tb                           xxxxx xxxxx ...
//!    tag (5 bits), first block (7)  waypoints of one or more blocks of four; only the list's last may be shorter
//! ```
//!
//! A waypoint is 30 bits: X and Y, 15 bits each, with 16384 added.

use super::{Frame, Parsed, number};
use crate::{WAYPOINTS_MAX, Waypoint};
use nom::{Parser, combinator::map_opt, multi::fold_many1};

/// Number of waypoints in a block, the unit of the acknowledgement.
pub const BLOCK_WAYPOINTS: usize = 4;

/// Maximum number of waypoints in a frame: four blocks.
pub const FRAME_WAYPOINTS_MAX: usize = 4 * BLOCK_WAYPOINTS;

const BLOCKS_MAX: usize = WAYPOINTS_MAX.div_ceil(BLOCK_WAYPOINTS);
const OFFSET: i32 = 1 << 14;
const TAG_MAX: u8 = 31;
const BLOCK_BITS: u32 = 7;
const BLOCK_MASK: u32 = (1 << BLOCK_BITS) - 1;

/// Consecutive waypoints of a list.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Slots {
    /// Number of the list in its session, 1 to 31 in turn.
    pub tag: u8,
    /// Number of the first waypoint's block.
    pub first_block: u8,
    waypoints: [Waypoint; FRAME_WAYPOINTS_MAX],
    count: u8,
}

impl core::fmt::Debug for Slots {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Slots")
            .field("tag", &self.tag)
            .field("first_block", &self.first_block)
            .field("waypoints", &self.waypoints())
            .finish_non_exhaustive()
    }
}

impl Slots {
    /// The content of a frame, with the first [`FRAME_WAYPOINTS_MAX`] of `waypoints`.
    #[must_use]
    pub fn new(tag: u8, first_block: u8, waypoints: &[Waypoint]) -> Self {
        let mut slots = Self {
            tag,
            first_block,
            waypoints: [Waypoint::default(); FRAME_WAYPOINTS_MAX],
            count: 0,
        };
        for &waypoint in waypoints {
            slots.push(waypoint);
        }
        slots
    }

    /// The waypoints, in order.
    #[must_use]
    pub fn waypoints(&self) -> &[Waypoint] {
        self.waypoints
            .get(..usize::from(self.count))
            .unwrap_or_default()
    }

    fn push(&mut self, waypoint: Waypoint) -> bool {
        let slot = self.waypoints.get_mut(usize::from(self.count));
        let fits = slot.is_some();
        if let Some(slot) = slot {
            *slot = waypoint;
            self.count += 1;
        }
        fits
    }

    pub(super) fn write(&self, frame: &mut Frame) {
        // An invalid tag or block is sent as a value that every robot refuses.
        let tag = u32::from(self.tag) * u32::from(self.tag <= TAG_MAX);
        let first_block = u32::from(self.first_block).min(BLOCK_MASK);
        frame.push_sixbit(2, tag << BLOCK_BITS | first_block);
        for &waypoint in self.waypoints() {
            push_point(frame, waypoint);
        }
    }

    pub(super) fn parse(input: &[u8]) -> Parsed<'_, Self> {
        let (input, (tag, first_block)) = map_opt(number(2), |bits| {
            let (tag, first_block) = (bits >> BLOCK_BITS, bits & BLOCK_MASK);
            (tag > 0 && (first_block as usize) < BLOCKS_MAX)
                .then_some((tag as u8, first_block as u8))
        })
        .parse(input)?;
        let empty = || Some(Self::new(tag, first_block, &[]));
        map_opt(
            fold_many1(point, empty, |slots, waypoint| {
                slots.and_then(|mut slots| slots.push(waypoint).then_some(slots))
            }),
            |slots| slots,
        )
        .parse(input)
    }
}

/// Writes a point. A coordinate beyond 15 bits is clamped to a value that every robot refuses.
pub(super) fn push_point(frame: &mut Frame, point: Waypoint) {
    let part = |value: i16| (i32::from(value).clamp(-OFFSET, OFFSET - 1) + OFFSET) as u32;
    frame.push_sixbit(5, part(point.x_in) << 15 | part(point.y_in));
}

pub(super) fn point(input: &[u8]) -> Parsed<'_, Waypoint> {
    let part = |bits: u32| ((bits & 0x7FFF) as i32 - OFFSET) as i16;
    map_opt(number(5), |bits| {
        Waypoint::new(part(bits >> 15), part(bits))
    })
    .parse(input)
}

#[cfg(test)]
mod tests {
    use super::super::Message;
    use super::super::testing::{read_back, sixbit_text};
    use super::*;
    use crate::WAYPOINT_LIMIT_IN;
    use proptest::prelude::*;

    fn waypoints() -> impl Strategy<Value = std::vec::Vec<Waypoint>> {
        let coordinate = || -WAYPOINT_LIMIT_IN..=WAYPOINT_LIMIT_IN;
        let waypoint =
            (coordinate(), coordinate()).prop_map(|(x_in, y_in)| Waypoint { x_in, y_in });
        prop::collection::vec(waypoint, 1..=FRAME_WAYPOINTS_MAX)
    }

    proptest! {
        #[test]
        fn waypoints_survive_a_round_trip(tag in 1..32_u8, first_block in 0..75_u8, list in waypoints()) {
            let slots = Message::Waypoints(Slots::new(tag, first_block, &list));
            prop_assert_eq!(read_back(slots), Some(slots));
        }

        #[test]
        fn waypoints_out_of_range_are_refused(x_in: i16, y_in: i16) {
            let slots = Message::Waypoints(Slots::new(1, 0, &[Waypoint { x_in, y_in }]));
            let fits = Waypoint::new(x_in, y_in).is_some();
            prop_assert_eq!(read_back(slots), fits.then_some(slots));
        }

        #[test]
        fn seventeen_waypoints_are_refused(points in sixbit_text(17 * 5)) {
            let mut content = std::vec::Vec::from(*b"W\"`");
            content.extend(points);
            prop_assert_eq!(Message::parse(&content), None);
        }
    }

    #[test]
    fn invalid_tags_and_blocks_are_refused() {
        let home = [Waypoint { x_in: 0, y_in: 0 }];
        for (tag, first_block, exists) in [
            (0, 0, false),
            (1, 0, true),
            (31, 74, true),
            (32, 0, false),
            (63, 0, false),
            (1, 75, false),
            (1, 255, false),
        ] {
            let slots = Message::Waypoints(Slots::new(tag, first_block, &home));
            assert_eq!(read_back(slots).is_some(), exists, "{tag}, {first_block}");
        }
    }
}
