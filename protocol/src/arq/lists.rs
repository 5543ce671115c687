//! Two banks for waypoint lists: one is driven, the other is staged, and a pointer swaps them.

use crate::command::{BLOCK_WAYPOINTS, Slots};
use crate::digest::digest;
use crate::telemetry::{Detail, Outcome, WINDOW_BLOCKS};
use crate::{WAYPOINTS_MAX, Waypoint};

const BLOCKS: usize = WAYPOINTS_MAX.div_ceil(BLOCK_WAYPOINTS);

/// Tags run from 1 to 31; how far one is ahead of another is counted modulo 32.
const TAG_MODULUS: u8 = 32;

/// The active list and the one being staged.
///
/// At every moment the active list is exactly the old one or exactly the new one.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Lists {
    banks: [[Waypoint; WAYPOINTS_MAX]; 2],
    active_bank: u8,
    active_count: u16,
    active_digest: u32,
    staged: Staged,
}

/// What has arrived of the list being staged.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Staged {
    open: bool,
    /// Of the list being staged, or of the latest that was; 0 before the first of a session.
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
            staged: Staged::none(0),
        }
    }
}

impl Lists {
    /// The list the robot drives.
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

    /// Forgets what is staged and every tag: a session ended.
    pub(super) fn abandon(&mut self) {
        self.staged = Staged::none(0);
    }

    /// Stores waypoints of a staged list. A newer tag begins a new list; an older one is late and is
    /// ignored, as is the tag of a list that has already been activated.
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
        let bank = self.banks.get_mut(usize::from(1 - self.active_bank));
        let Some(room) = bank.and_then(|bank| bank.get_mut(first..first + waypoints.len())) else {
            return;
        };
        room.copy_from_slice(waypoints);
        for block in 0..waypoints.len().div_ceil(BLOCK_WAYPOINTS) {
            self.staged.mark(usize::from(slots.first_block) + block);
        }
    }

    /// Swaps the staged list in when it is whole and is the one described. A count of 0 clears the
    /// active list and whatever is staged; its tag says nothing.
    pub(super) fn activate(&mut self, tag: u8, count: u16, wanted: u32) -> Outcome {
        if usize::from(count) > WAYPOINTS_MAX {
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

    /// What the acknowledgement says of the staged list; `None` when there is none.
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
