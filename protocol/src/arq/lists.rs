//! Two banks for waypoint lists: one is active, the other is staged; activation swaps them.

use crate::command::{BLOCK_WAYPOINTS, Slots};
use crate::digest::digest;
use crate::telemetry::{Detail, Outcome, WINDOW_BLOCKS};
use crate::{WAYPOINTS_MAX, Waypoint};

const BLOCKS: usize = WAYPOINTS_MAX.div_ceil(BLOCK_WAYPOINTS);

/// Modulus of tag differences; tags run from 1 to 31.
const TAG_MODULUS: u8 = 32;

/// The active list and the one being staged.
///
/// At every moment, the active list is exactly the old list or exactly the new list.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Lists {
    banks: [[Waypoint; WAYPOINTS_MAX]; 2],
    active_bank: u8,
    active_count: u16,
    active_digest: u32,
    /// Maximum number of waypoints in a list.
    capacity: u16,
    staged: Staged,
}

/// The list being staged, block by block.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Staged {
    open: bool,
    /// Tag of the current or latest staged list; 0 before the first list of a session.
    tag: u8,
    arrived: [u8; BLOCKS.div_ceil(8)],
}

impl Staged {
    const fn none(tag: u8) -> Self {
        Self {
            open: false,
            tag,
            arrived: [0; BLOCKS.div_ceil(8)],
        }
    }

    fn has(&self, block: usize) -> bool {
        self.arrived
            .get(block / 8)
            .is_some_and(|byte| byte & 1 << (block % 8) != 0)
    }

    fn mark(&mut self, block: usize) {
        if let Some(byte) = self.arrived.get_mut(block / 8) {
            *byte |= 1 << (block % 8);
        }
    }

    fn first_missing(&self) -> usize {
        (0..BLOCKS)
            .find(|&block| !self.has(block))
            .unwrap_or(BLOCKS)
    }
}

impl Default for Lists {
    fn default() -> Self {
        Self {
            banks: [[Waypoint::default(); WAYPOINTS_MAX]; 2],
            active_bank: 0,
            active_count: 0,
            active_digest: digest([].iter()),
            capacity: WAYPOINTS_MAX as u16,
            staged: Staged::none(0),
        }
    }
}

impl Lists {
    /// The list being driven.
    #[must_use]
    pub fn active(&self) -> &[Waypoint] {
        self.bank(self.active_bank, self.active_count)
    }

    /// [`digest`] of the active list.
    #[must_use]
    pub const fn active_digest(&self) -> u32 {
        self.active_digest
    }

    fn bank(&self, bank: u8, count: u16) -> &[Waypoint] {
        self.banks
            .get(usize::from(bank))
            .and_then(|bank| bank.get(..usize::from(count)))
            .unwrap_or_default()
    }

    pub(super) const fn limit(&mut self, capacity: u16) {
        self.capacity = capacity;
    }

    /// Drops the staged list and its tag, at the end of a session.
    pub(super) fn abandon(&mut self) {
        self.staged = Staged::none(0);
    }

    /// Stores waypoints of a staged list. A newer tag begins a new list; an older tag, or the tag of a list already
    /// activated, is ignored.
    pub(super) fn stage(&mut self, slots: &Slots) {
        let ahead = slots.tag.wrapping_sub(self.staged.tag) % TAG_MODULUS;
        match ahead {
            0 if self.staged.open => {}
            1..16 => {
                self.staged = Staged {
                    open: true,
                    ..Staged::none(slots.tag)
                };
            }
            _ => return,
        }
        let first = usize::from(slots.first_block) * BLOCK_WAYPOINTS;
        let waypoints = slots.waypoints();
        if first + waypoints.len() > usize::from(self.capacity) {
            return;
        }
        let bank = self.banks.get_mut(usize::from(1 - self.active_bank));
        let Some(room) = bank.and_then(|bank| bank.get_mut(first..first + waypoints.len())) else {
            return;
        };
        room.copy_from_slice(waypoints);
        for block in 0..waypoints.len().div_ceil(BLOCK_WAYPOINTS) {
            self.staged.mark(usize::from(slots.first_block) + block);
        }
    }

    /// Makes the staged list the active one if it is complete and matches. A count of 0 clears both lists, with any
    /// tag.
    pub(super) fn activate(&mut self, tag: u8, count: u16, wanted: u32) -> Outcome {
        if count > self.capacity.min(WAYPOINTS_MAX as u16) {
            return Outcome::BadValue;
        }
        if count > 0 {
            let blocks = usize::from(count).div_ceil(BLOCK_WAYPOINTS);
            let whole =
                self.staged.open && self.staged.tag == tag && self.staged.first_missing() >= blocks;
            if !whole {
                return Outcome::ListIncomplete;
            }
        }
        let bank = 1 - self.active_bank;
        if digest(self.bank(bank, count).iter()) != wanted {
            return Outcome::DigestMismatch;
        }
        self.active_bank = bank;
        self.active_count = count;
        self.active_digest = wanted;
        self.staged = Staged::none(self.staged.tag);
        Outcome::Done
    }

    /// Progress of the staged list for the acknowledgement; `None` if there is none.
    pub(super) fn detail(&self) -> Option<Detail> {
        if !self.staged.open {
            return None;
        }
        let first_missing = self.staged.first_missing();
        let window = (0..WINDOW_BLOCKS)
            .filter(|&n| self.staged.has(first_missing + 1 + usize::from(n)))
            .fold(0, |window, n| window | 1 << n);
        Some(Detail::Staging {
            first_missing: first_missing as u8,
            tag: self.staged.tag & 3,
            window,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn list(seed: i16, count: usize) -> std::vec::Vec<Waypoint> {
        (0..count as i16)
            .map(|i| Waypoint {
                x_in: seed + i,
                y_in: seed - i,
            })
            .collect()
    }

    fn stage(lists: &mut Lists, tag: u8, waypoints: &[Waypoint]) {
        for (block, part) in waypoints.chunks(BLOCK_WAYPOINTS).enumerate() {
            lists.stage(&Slots::new(tag, block as u8, part));
        }
    }

    fn activate(lists: &mut Lists, tag: u8, waypoints: &[Waypoint]) -> Outcome {
        lists.activate(tag, waypoints.len() as u16, digest(waypoints.iter()))
    }

    #[test]
    fn the_active_list_is_the_old_one_until_activation() {
        let mut lists = Lists::default();
        let (old, new) = (list(100, 10), list(200, 300));
        stage(&mut lists, 1, &old);
        assert_eq!(lists.active(), []);
        assert_eq!(activate(&mut lists, 1, &old), Outcome::Done);
        assert_eq!(lists.active(), old);
        stage(&mut lists, 2, &new);
        assert_eq!(lists.active(), old);
        assert_eq!(
            lists.activate(2, 300, digest(old.iter())),
            Outcome::DigestMismatch
        );
        assert_eq!(activate(&mut lists, 3, &new), Outcome::ListIncomplete);
        assert_eq!(lists.active(), old);
        assert_eq!(activate(&mut lists, 2, &new), Outcome::Done);
        assert_eq!(lists.active(), new);
        assert_eq!(lists.active_digest(), digest(new.iter()));
    }

    #[test]
    fn a_list_with_a_missing_block_is_not_activated() {
        let new = list(5, 17);
        for missing in 0..5 {
            let mut lists = Lists::default();
            for (block, part) in new.chunks(BLOCK_WAYPOINTS).enumerate() {
                if block != missing {
                    lists.stage(&Slots::new(1, block as u8, part));
                }
            }
            assert_eq!(activate(&mut lists, 1, &new), Outcome::ListIncomplete);
            let part = new
                .chunks(BLOCK_WAYPOINTS)
                .nth(missing)
                .expect("five blocks");
            lists.stage(&Slots::new(1, missing as u8, part));
            assert_eq!(activate(&mut lists, 1, &new), Outcome::Done);
        }
    }

    #[test]
    fn late_waypoints_of_an_activated_or_older_list_stage_nothing() {
        let mut lists = Lists::default();
        let new = list(1, 8);
        stage(&mut lists, 5, &new);
        assert_eq!(activate(&mut lists, 5, &new), Outcome::Done);
        for late in [5, 4, 1, 31, 21] {
            stage(&mut lists, late, &list(9, 8));
            assert_eq!(lists.detail(), None, "tag {late}");
        }
        stage(&mut lists, 20, &new);
        assert!(lists.detail().is_some());
        assert_eq!(lists.active(), new);
    }

    #[test]
    fn clearing_needs_no_staged_list_and_keeps_the_tag() {
        let mut lists = Lists::default();
        let old = list(1, 8);
        stage(&mut lists, 20, &old);
        lists.abandon();
        stage(&mut lists, 15, &old);
        assert_eq!(activate(&mut lists, 15, &old), Outcome::Done);
        assert_eq!(lists.activate(0, 0, 1), Outcome::DigestMismatch);
        assert_eq!(activate(&mut lists, 0, &[]), Outcome::Done);
        assert_eq!(lists.active(), []);
        stage(&mut lists, 16, &old);
        assert_eq!(activate(&mut lists, 16, &old), Outcome::Done);
    }

    #[test]
    fn waypoints_beyond_the_banks_are_refused() {
        let mut lists = Lists::default();
        assert_eq!(lists.activate(1, 301, 0), Outcome::BadValue);
        lists.stage(&Slots::new(1, 74, &list(0, 5)));
        assert_eq!(
            lists.detail(),
            Some(Detail::Staging {
                first_missing: 0,
                tag: 1,
                window: 0
            })
        );
    }

    #[test]
    fn the_snapshot_names_the_first_missing_block_and_the_eight_after_it() {
        let mut lists = Lists::default();
        let part = list(0, 4);
        let mut expect = |block, first_missing, window| {
            lists.stage(&Slots::new(6, block, &part));
            let detail = Detail::Staging {
                first_missing,
                tag: 2,
                window,
            };
            assert_eq!(lists.detail(), Some(detail), "after block {block}");
        };
        expect(1, 0, 0b1);
        expect(8, 0, 0b1000_0001);
        expect(9, 0, 0b1000_0001);
        expect(0, 2, 0b0110_0000);
        expect(2, 3, 0b0011_0000);
    }
}
