//! Quality of one direction of the channel, and the length of frames for it.

/// Number of bytes after which older bytes count half, because the channel changes as the robot drives.
const MEMORY_BYTES: u32 = 960;

/// Share of sent bytes that arrived intact.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Quality {
    intact: u32,
    all: u32,
}

impl Default for Quality {
    /// Unknown quality, which gives frames of medium length.
    fn default() -> Self {
        Self {
            intact: 60,
            all: 80,
        }
    }
}

impl Quality {
    /// Takes `all` sent bytes, of which `intact` arrived.
    pub(super) fn judge(&mut self, intact: u32, all: u32) {
        self.intact += intact;
        self.all += all.max(intact);
        while self.all > MEMORY_BYTES {
            self.intact /= 2;
            self.all /= 2;
        }
    }

    /// The expected quality of the other direction, until that has been judged.
    pub(super) fn as_guess(self) -> Self {
        let mut guess = self;
        while guess.all > 160 {
            guess.intact /= 2;
            guess.all /= 2;
        }
        guess
    }

    /// Number of blocks to put into a frame. The delivery bench was fastest with these limits; calculation gives 83 and
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
