//! A waypoint list being sent: the state of each block (to send, sent, or arrived).

use core::ops::Range;

use super::quality::Quality;
use crate::command::{BLOCK_WAYPOINTS, Slots};
use crate::digest::digest;
use crate::telemetry::{Detail, WINDOW_BLOCKS};
use crate::{WAYPOINTS_MAX, Waypoint};

const BLOCKS: usize = WAYPOINTS_MAX.div_ceil(BLOCK_WAYPOINTS);

/// Length of a block on the wire, bytes.
const BLOCK_BYTES: u32 = 5 * BLOCK_WAYPOINTS as u32;

/// Length of a frame without its blocks, bytes.
const FRAME_OVERHEAD_BYTES: u64 = 9;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Block {
    ToSend,
    /// The block's last byte was sent at this time.
    Sent(u64),
    Arrived,
}

/// A list being sent.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct Transfer {
    waypoints: [Waypoint; WAYPOINTS_MAX],
    count: usize,
    digest: u32,
    tag: u8,
    blocks: [Block; BLOCKS],
    /// Quality of the uplink, which determines the length of frames.
    quality: Quality,
}

impl Transfer {
    pub(super) fn new(waypoints: &[Waypoint], tag: u8, quality: Quality) -> Self {
        let mut list = [Waypoint::default(); WAYPOINTS_MAX];
        let count = waypoints.len().min(WAYPOINTS_MAX);
        list[..count].copy_from_slice(&waypoints[..count]);
        Self {
            digest: digest(list[..count].iter()),
            waypoints: list,
            count,
            tag,
            blocks: [Block::ToSend; BLOCKS],
            quality,
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

    /// Begins again with a new tag.
    pub(super) fn restart(&mut self, tag: u8) {
        self.tag = tag;
        self.blocks = [Block::ToSend; BLOCKS];
    }

    fn block_count(&self) -> usize {
        self.count.div_ceil(BLOCK_WAYPOINTS)
    }

    /// Number of waypoints that the robot has acknowledged.
    pub(super) fn acknowledged(&self) -> u16 {
        let arrived = |block: &Block| *block == Block::Arrived;
        let blocks = self.blocks().iter().filter(|b| arrived(b)).count();
        (blocks * BLOCK_WAYPOINTS).min(self.count) as u16
    }

    /// The content of the next frame, of at most `room` bytes; `None` when every block is sent or has arrived.
    pub(super) fn next(&self, room: u64) -> Option<Slots> {
        let first = self.blocks().iter().position(|b| *b == Block::ToSend)?;
        let fitting = room.saturating_sub(FRAME_OVERHEAD_BYTES) / u64::from(BLOCK_BYTES);
        Some(self.frame(first, fitting, |block| block == Block::ToSend))
    }

    /// Whether the channel allows only the shortest frames.
    pub(super) fn is_lossy(&self) -> bool {
        self.quality.frame_blocks() == 1
    }

    /// Time at which the block was sent that has waited longest for its acknowledgement, microseconds; `None` if no block waits.
    pub(super) fn oldest_us(&self) -> Option<u64> {
        self.sent_us().map(|(ends_us, _)| ends_us).min()
    }

    /// A frame with the blocks that have waited longest.
    pub(super) fn repeat(&self) -> Option<Slots> {
        let (_, first) = self.sent_us().min()?;
        Some(self.frame(first, u64::MAX, |block| matches!(block, Block::Sent(_))))
    }

    fn sent_us(&self) -> impl Iterator<Item = (u64, usize)> {
        let blocks = self.blocks().iter().zip(0..);
        blocks.filter_map(|(block, n)| match block {
            Block::Sent(ends_us) => Some((*ends_us, n)),
            _ => None,
        })
    }

    fn blocks(&self) -> &[Block] {
        &self.blocks[..self.block_count()]
    }

    /// A frame of consecutive blocks that `belongs` accepts, beginning with block `first`.
    fn frame(&self, first: usize, fitting: u64, belongs: impl Fn(Block) -> bool) -> Slots {
        let most = u64::from(self.quality.frame_blocks()).min(fitting);
        let run = self.blocks()[first..]
            .iter()
            .take(most as usize)
            .take_while(|block| belongs(**block))
            .count();
        let waypoints = first * BLOCK_WAYPOINTS..((first + run) * BLOCK_WAYPOINTS).min(self.count);
        Slots::new(self.tag, first as u8, &self.waypoints[waypoints])
    }

    pub(super) fn sent(&mut self, blocks: Range<usize>, ends_us: u64) {
        self.blocks[blocks].fill(Block::Sent(ends_us));
    }

    /// Takes an acknowledgement latched at `latched_us`; returns whether it acknowledged further blocks.
    pub(super) fn handle_detail(&mut self, detail: Detail, latched_us: u64) -> bool {
        let (first_missing, window) = match detail {
            Detail::Staging {
                first_missing,
                tag,
                window,
            } if tag == self.tag & 3 => (usize::from(first_missing), window),
            // No block of this list has arrived.
            _ => (0, 0),
        };
        let mut news = false;
        let count = self.block_count();
        for (n, block) in self.blocks[..count].iter_mut().enumerate() {
            let arrived = match n.checked_sub(first_missing + 1) {
                None => n < first_missing,
                Some(ahead) if ahead < usize::from(WINDOW_BLOCKS) => window >> ahead & 1 == 1,
                // The acknowledgement does not cover further blocks.
                Some(_) => break,
            };
            match *block {
                Block::Arrived => {}
                _ if arrived => {
                    *block = Block::Arrived;
                    self.quality.judge(BLOCK_BYTES, BLOCK_BYTES);
                    news = true;
                }
                Block::Sent(ends_us) if ends_us <= latched_us => {
                    *block = Block::ToSend;
                    self.quality.judge(0, BLOCK_BYTES);
                }
                Block::Sent(_) | Block::ToSend => {}
            }
        }
        news
    }

    /// Marks all unacknowledged blocks to be sent again, after a long silence.
    pub(super) fn resend(&mut self) {
        for block in &mut self.blocks {
            if matches!(block, Block::Sent(_)) {
                *block = Block::ToSend;
            }
        }
    }
}
