//! How good a direction of the channel is, and how long frames ought to be on it.

/// Older bytes count half when so many have been judged: the channel changes when the robot drives.
const MEMORY_BYTES: u32 = 960;

/// Bytes that arrived intact among all that were sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Quality {
    intact: u32,
    all: u32,
}

impl Default for Quality {
    /// Nothing is known: neither good nor bad enough for an extreme.
    fn default() -> Self {
        Self {
            intact: 60,
            all: 80,
        }
    }
}

impl Quality {
    /// So many bytes arrived intact while so many were sent.
    pub(super) fn judge(&mut self, intact: u32, all: u32) {
        self.intact += intact;
        self.all += all.max(intact);
        while self.all > MEMORY_BYTES {
            self.intact /= 2;
            self.all /= 2;
        }
    }

    /// What is expected of the other direction: the same, until it has been judged itself.
    pub(super) fn as_guess(self) -> Self {
        let mut guess = self;
        while guess.all > 160 {
            guess.intact /= 2;
            guess.all /= 2;
        }
        guess
    }

    /// Blocks a frame should hold. By arithmetic (ten bits a byte, time for a block the same with the longer
    /// and the shorter frame) the borders lie at 83 and 51 % for bytes in long lines and higher for those in
    /// short ones and single blocks; the delivery bench was fastest at these.
    pub(super) fn frame_blocks(self) -> u8 {
        let share_pct = self.intact * 100 / self.all.max(1);
        match share_pct {
            86.. => 4,
            66.. => 2,
            _ => 1,
        }
    }
}
