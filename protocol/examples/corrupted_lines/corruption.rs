//! The ways in which a line is spoiled, and how often each is tried.

use crate::damage::Dice;
use crate::pool::{Pool, Sent};
use groundwave_protocol::LINE_BYTES;

/// What happens to a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// 1 to 24 different bits flipped, every number equally often.
    Flips,
    /// A run of 2 to 64 bits of which each is flipped with probability a half, its ends always.
    Burst,
    /// 1 to 8 bytes in a row become random bytes; half of the time printable ones.
    Replaced,
    /// 1 to 8 bytes in a row are missing.
    Deleted,
    /// 1 to 8 random bytes in a row come in between; half of the time printable ones.
    Inserted,
    /// The line is cut and goes on as another line of the pool, from the same column on.
    Spliced,
}

impl Kind {
    pub const ALL: [Self; 6] = [
        Self::Flips,
        Self::Burst,
        Self::Replaced,
        Self::Deleted,
        Self::Inserted,
        Self::Spliced,
    ];

    /// Half of all blocks of lines are [`Kind::Flips`], a tenth each of the others.
    pub fn of_block(block: u64) -> Self {
        Self::ALL[(block % 10).saturating_sub(4) as usize]
    }

    pub fn spoil(self, sent: &Sent, pool: &Pool, dice: &mut Dice) -> Spoiled {
        let mut line = Spoiled::new(sent.as_bytes());
        let length = line.length;
        let bits = length * 8;
        match self {
            Self::Flips => {
                let mut rest = 1 + dice.below(24);
                let mut flipped = [0_u64; LINE_BYTES.div_ceil(8)];
                while rest > 0 {
                    let bit = dice.below(bits);
                    let fresh = flipped[bit / 64] >> (bit % 64) & 1 == 0;
                    if fresh {
                        flipped[bit / 64] |= 1 << (bit % 64);
                        line.flip(bit);
                        rest -= 1;
                    }
                }
            }
            Self::Burst => {
                let run = 2 + dice.below(63);
                let first = dice.below(bits - run + 1);
                let inner = dice.next();
                line.flip(first);
                for n in 1..run - 1 {
                    if inner >> n & 1 == 1 {
                        line.flip(first + n);
                    }
                }
                line.flip(first + run - 1);
            }
            Self::Replaced => {
                let run = 1 + dice.below(8);
                let first = dice.below(length - run + 1);
                let filling = Filling::new(dice);
                for byte in &mut line.bytes[first..first + run] {
                    *byte = filling.next(dice);
                }
            }
            Self::Deleted => {
                let run = 1 + dice.below(8);
                let first = dice.below(length - run + 1);
                line.bytes.copy_within(first + run..length, first);
                line.length -= run;
            }
            Self::Inserted => {
                let run = 1 + dice.below(8);
                let first = dice.below(length);
                line.bytes.copy_within(first..length, first + run);
                let filling = Filling::new(dice);
                for byte in &mut line.bytes[first..first + run] {
                    *byte = filling.next(dice);
                }
                line.length += run;
            }
            Self::Spliced => {
                // Where both lines begin alike the splice is a good line.
                loop {
                    let column = 1 + dice.below(length - 1);
                    let other = pool.draw(dice).as_bytes();
                    let Some(tail) = other.get(column..) else {
                        continue;
                    };
                    line = Spoiled::new(sent.as_bytes());
                    line.bytes[column..column + tail.len()].copy_from_slice(tail);
                    line.length = column + tail.len();
                    if line.as_bytes() != other {
                        break;
                    }
                }
            }
        }
        line
    }
}

/// Random bytes, all printable or all of any kind.
#[derive(Clone, Copy)]
struct Filling {
    printable: bool,
}

impl Filling {
    fn new(dice: &mut Dice) -> Self {
        Self {
            printable: dice.next() & 1 == 1,
        }
    }

    fn next(self, dice: &mut Dice) -> u8 {
        if self.printable {
            b' ' + dice.below(95) as u8
        } else {
            dice.next() as u8
        }
    }
}

/// A line as it arrived.
pub struct Spoiled {
    bytes: [u8; 2 * LINE_BYTES],
    length: usize,
}

impl Spoiled {
    fn new(sent: &[u8]) -> Self {
        let mut bytes = [0; 2 * LINE_BYTES];
        bytes[..sent.len()].copy_from_slice(sent);
        Self {
            bytes,
            length: sent.len(),
        }
    }

    pub fn as_bytes(&self) -> &[u8] {
        &self.bytes[..self.length]
    }

    fn flip(&mut self, bit: usize) {
        self.bytes[bit / 8] ^= 1 << (bit % 8);
    }
}
