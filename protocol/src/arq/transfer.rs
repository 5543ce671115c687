//! The ground's view of a waypoint list on its way: which blocks have to go, have gone, have arrived.

use crate::command::{BLOCK_WAYPOINTS, FRAME_WAYPOINTS_MAX, Slots};
use crate::digest::digest;
use crate::telemetry::{Detail, WINDOW_BLOCKS};
use crate::{WAYPOINTS_MAX, Waypoint};

const BLOCKS: usize = WAYPOINTS_MAX.div_ceil(BLOCK_WAYPOINTS);
const FRAME_BLOCKS_MAX: u8 = (FRAME_WAYPOINTS_MAX / BLOCK_WAYPOINTS) as u8;

/// Frames that arrive in a row before the next ones are made twice as long.
const GROW_AFTER: u8 = 6;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Block {
    ToSend,
    /// Last byte off at this instant.
    Sent(u64),
    Arrived,
}

/// A list under way.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Transfer {
    waypoints: [Waypoint; WAYPOINTS_MAX],
    count: usize,
    digest: u32,
    tag: u8,
    blocks: [Block; BLOCKS],
    /// Blocks in a frame: short frames survive a bad channel, long ones carry more on a good one.
    frame_blocks: u8,
    arrivals_in_a_row: u8,
}

impl Transfer {
    pub(super) fn new(waypoints: &[Waypoint], tag: u8) -> Self {
        let mut list = [Waypoint::default(); WAYPOINTS_MAX];
        let count = waypoints.len().min(WAYPOINTS_MAX);
        list[..count].copy_from_slice(&waypoints[..count]);
        Self {
            digest: digest(list[..count].iter()),
            waypoints: list,
            count,
            tag,
            blocks: [Block::ToSend; BLOCKS],
            frame_blocks: FRAME_BLOCKS_MAX,
            arrivals_in_a_row: 0,
        }
    }

    pub(super) fn digest(&self) -> u32 {
        self.digest
    }

    pub(super) fn tag(&self) -> u8 {
        self.tag
    }

    pub(super) fn count(&self) -> u16 {
        self.count as u16
    }

    /// Begins again under a new tag: what the robot has staged is not what was sent.
    pub(super) fn restart(&mut self, tag: u8) {
        self.tag = tag;
        self.blocks = [Block::ToSend; BLOCKS];
    }

    fn block_count(&self) -> usize {
        self.count.div_ceil(BLOCK_WAYPOINTS)
    }

    /// Waypoints that the robot has acknowledged.
    pub(super) fn acknowledged(&self) -> u16 {
        let arrived = |block: &Block| *block == Block::Arrived;
        let blocks = self.blocks[..self.block_count()]
            .iter()
            .filter(|b| arrived(b))
            .count();
        (blocks * BLOCK_WAYPOINTS).min(self.count) as u16
    }

    /// The next frame's content and its blocks; `None` when every block is out or has arrived.
    pub(super) fn next(&self) -> Option<(Slots, core::ops::Range<usize>)> {
        let all = &self.blocks[..self.block_count()];
        let first = all.iter().position(|b| *b == Block::ToSend)?;
        let run = all[first..]
            .iter()
            .take(usize::from(self.frame_blocks))
            .take_while(|b| **b == Block::ToSend)
            .count();
        let waypoints = first * BLOCK_WAYPOINTS..((first + run) * BLOCK_WAYPOINTS).min(self.count);
        let slots = Slots::new(self.tag, first as u8, &self.waypoints[waypoints]);
        Some((slots, first..first + run))
    }

    pub(super) fn sent(&mut self, blocks: core::ops::Range<usize>, ends_us: u64) {
        self.blocks[blocks].fill(Block::Sent(ends_us));
    }

    /// Takes a snapshot of the robot's receiving end, latched at `latched_us`. Returns whether it told
    /// of anything new.
    pub(super) fn handle_detail(&mut self, detail: Detail, latched_us: u64) -> bool {
        let (first_missing, window) = match detail {
            Detail::Staging {
                first_missing,
                tag,
                window,
            } if tag == self.tag & 3 => (usize::from(first_missing), window),
            // Not a block of this list has arrived.
            _ => (0, 0),
        };
        let mut news = false;
        let mut lost = false;
        let count = self.block_count();
        for (n, block) in self.blocks[..count].iter_mut().enumerate() {
            let arrived = match n.checked_sub(first_missing + 1) {
                None => n < first_missing,
                Some(ahead) if ahead < usize::from(WINDOW_BLOCKS) => window >> ahead & 1 == 1,
                // The snapshot says nothing of blocks so far ahead.
                Some(_) => break,
            };
            match *block {
                Block::Arrived => {}
                _ if arrived => {
                    *block = Block::Arrived;
                    news = true;
                }
                Block::Sent(ends_us) if ends_us <= latched_us => {
                    *block = Block::ToSend;
                    lost = true;
                }
                Block::Sent(_) | Block::ToSend => {}
            }
        }
        if lost {
            self.frame_blocks = (self.frame_blocks / 2).max(1);
            self.arrivals_in_a_row = 0;
        } else if news {
            self.arrivals_in_a_row += 1;
            if self.arrivals_in_a_row >= GROW_AFTER {
                self.arrivals_in_a_row = 0;
                self.frame_blocks = (self.frame_blocks * 2).min(FRAME_BLOCKS_MAX);
            }
        }
        news
    }

    /// After a long silence: everything not known to have arrived goes again.
    pub(super) fn resend(&mut self) {
        for block in &mut self.blocks {
            if matches!(block, Block::Sent(_)) {
                *block = Block::ToSend;
            }
        }
    }
}
