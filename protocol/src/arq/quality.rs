//! Quality of one direction of the channel, and the length of frames for it.

/// Bytes after which older ones count half, because the channel changes as the robot drives.
const MEMORY_BYTES: u32 = 960;

/// Bytes that arrived intact, of all bytes sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Quality {
    intact: u32,
    all: u32,
}

impl Default for Quality {
    /// Unknown quality, for frames of medium length.
    fn default() -> Self {
        Self {
            intact: 60,
            all: 80,
        }
    }
}

impl Quality {
    /// Takes bytes: `intact` ones, of `all` sent.
    pub(super) fn judge(&mut self, intact: u32, all: u32) {
        self.intact += intact;
        self.all += all.max(intact);
        while self.all > MEMORY_BYTES {
            self.intact /= 2;
            self.all /= 2;
        }
    }

    /// The expected quality of the other direction until it has been judged.
    pub(super) fn as_guess(self) -> Self {
        let mut guess = self;
        while guess.all > 160 {
            guess.intact /= 2;
            guess.all /= 2;
        }
        guess
    }

    /// Blocks to put into a frame. The delivery bench was fastest with these limits; arithmetic puts them at 83 and
    /// 51 % for bytes in long lines, and higher for short lines and single blocks.
    pub(super) fn frame_blocks(self) -> u8 {
        let share_pct = self.intact * 100 / self.all.max(1);
        match share_pct {
            86.. => 4,
            66.. => 2,
            _ => 1,
        }
    }
}
