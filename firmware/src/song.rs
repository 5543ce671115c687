//! What the robot sings at the end of its list.

/// A note's frequency, 0 for a rest, and its length in ticks.
type Note = (u16, u8);

/// A rising call and its answer, about 4 s.
const FINISHED: &[Note] = &[
    (523, 4),
    (659, 4),
    (784, 4),
    (1047, 8),
    (0, 2),
    (784, 4),
    (1047, 4),
    (1319, 4),
    (1047, 12),
    (0, 2),
    (659, 4),
    (587, 4),
    (523, 16),
];

/// A lullaby to hide by, about 6 s.
const HIDING: &[Note] = &[
    (784, 6),
    (659, 6),
    (784, 12),
    (0, 2),
    (880, 6),
    (784, 6),
    (659, 12),
    (0, 2),
    (587, 6),
    (659, 6),
    (698, 6),
    (587, 6),
    (523, 24),
];

/// The singer: silent until told.
#[derive(Clone, Debug, Default)]
pub struct Singer {
    rest: &'static [Note],
    played_ticks: u8,
}

impl Singer {
    /// Begins the song.
    pub const fn begin(&mut self) {
        self.rest = FINISHED;
        self.played_ticks = 0;
    }

    /// Begins the song of a robot that hides.
    pub const fn begin_hiding(&mut self) {
        self.rest = HIDING;
        self.played_ticks = 0;
    }

    /// Silence.
    pub const fn hush(&mut self) {
        self.rest = &[];
    }

    /// What to sound for the coming tick, in hertz; 0 is silence.
    pub fn tick(&mut self) -> u16 {
        let Some((&(hz, length), rest)) = self.rest.split_first() else {
            return 0;
        };
        self.played_ticks += 1;
        if self.played_ticks >= length {
            self.played_ticks = 0;
            self.rest = rest;
        }
        hz
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_sings_every_note_for_its_length_and_then_no_more() {
        let mut singer = Singer::default();
        assert_eq!(singer.tick(), 0);
        singer.begin();
        for &(hz, length) in FINISHED {
            for _ in 0..length {
                assert_eq!(singer.tick(), hz);
            }
        }
        assert_eq!(singer.tick(), 0);
        singer.begin();
        singer.tick();
        singer.hush();
        assert_eq!(singer.tick(), 0);
    }
}
