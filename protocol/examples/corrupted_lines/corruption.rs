//! The kinds of damage to a line, and their shares.

use crate::damage::Rng;
use crate::pool::{Pool, Sent};
use groundwave_protocol::LINE_BYTES;

/// A kind of damage to a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// 1 to 24 distinct bits flipped, each number equally often.
    Flips,
    /// In a run of 2 to 64 bits, both ends are flipped, and each other bit with probability 1/2.
    Burst,
    /// 1 to 8 consecutive bytes become random bytes, printable in half of the cases.
    Replaced,
    /// 1 to 8 consecutive bytes are missing.
    Deleted,
    /// 1 to 8 consecutive random bytes are inserted, printable in half of the cases.
    Inserted,
    /// From some column on, the line continues as another line of the pool.
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

    /// [`Kind::Flips`] for half of all blocks of lines, each other kind for a tenth.
    pub fn of_block(block: u64) -> Self {
        Self::ALL[(block % 10).saturating_sub(4) as usize]
    }

    pub fn damage(self, sent: &Sent, pool: &Pool, rng: &mut Rng) -> Spoiled {
        let mut line = Spoiled::new(sent.as_bytes());
        let length = line.length;
        let bits = length * 8;
        match self {
            Self::Flips => {
                let mut rest = 1 + rng.below(24);
                let mut flipped = [0_u64; LINE_BYTES.div_ceil(8)];
                while rest > 0 {
                    let bit = rng.below(bits);
                    let fresh = flipped[bit / 64] >> (bit % 64) & 1 == 0;
                    if fresh {
                        flipped[bit / 64] |= 1 << (bit % 64);
                        line.flip(bit);
                        rest -= 1;
                    }
                }
            }
            Self::Burst => {
                let run = 2 + rng.below(63);
                let first = rng.below(bits - run + 1);
                let inner = rng.next();
                line.flip(first);
                for n in 1..run - 1 {
                    if inner >> n & 1 == 1 {
                        line.flip(first + n);
                    }
                }
                line.flip(first + run - 1);
            }
            Self::Replaced => {
                let run = 1 + rng.below(8);
                let first = rng.below(length - run + 1);
                let filling = Filling::new(rng);
                for byte in &mut line.bytes[first..first + run] {
                    *byte = filling.next(rng);
                }
            }
            Self::Deleted => {
                let run = 1 + rng.below(8);
                let first = rng.below(length - run + 1);
                line.bytes.copy_within(first + run..length, first);
                line.length -= run;
            }
            Self::Inserted => {
                let run = 1 + rng.below(8);
                let first = rng.below(length);
                line.bytes.copy_within(first..length, first + run);
                let filling = Filling::new(rng);
                for byte in &mut line.bytes[first..first + run] {
                    *byte = filling.next(rng);
                }
                line.length += run;
            }
            Self::Spliced => {
                // If both lines begin alike, the splice is a good line.
                loop {
                    let column = 1 + rng.below(length - 1);
                    let other = pool.draw(rng).as_bytes();
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

/// Random bytes, all printable or all arbitrary.
#[derive(Clone, Copy)]
struct Filling {
    printable: bool,
}

impl Filling {
    fn new(rng: &mut Rng) -> Self {
        Self {
            printable: rng.next() & 1 == 1,
        }
    }

    fn next(self, rng: &mut Rng) -> u8 {
        if self.printable {
            b' ' + rng.below(95) as u8
        } else {
            rng.next() as u8
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
