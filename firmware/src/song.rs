//! What the robot sings, and the singer.

/// A note's frequency in hertz, 0 for a rest, and its length in ticks.
pub type Note = (u16, u8);

/// At the end of a list: a rising call and its answer, about 4 s.
pub const FINISHED: &[Note] = &[
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

/// The singer: silent until told.
#[derive(Clone, Debug, Default)]
pub struct Singer {
    rest: &'static [Note],
    played_ticks: u8,
}

impl Singer {
    /// Begins a song.
    pub const fn begin(&mut self, song: &'static [Note]) {
        self.rest = song;
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
    use groundwave_protocol::telemetry::{self, SongLine};
    use std::vec::Vec;

    /// Otherwise line S would say another song than is sung.
    #[test]
    fn every_song_fits_into_line_s() {
        for &song in &[FINISHED] {
            let note = |&(hz, ticks): &Note| telemetry::Note { hz, ticks };
            let sung: Vec<_> = song.iter().map(note).collect();
            let said: Vec<_> = SongLine::new(sung.iter().copied()).notes().collect();
            assert_eq!(said, sung);
        }
    }

    #[test]
    fn it_sings_every_note_for_its_length_and_then_no_more() {
        let mut singer = Singer::default();
        assert_eq!(singer.tick(), 0);
        singer.begin(FINISHED);
        for &(hz, length) in FINISHED {
            for _ in 0..length {
                assert_eq!(singer.tick(), hz);
            }
        }
        assert_eq!(singer.tick(), 0);
        singer.begin(FINISHED);
        singer.tick();
        singer.hush();
        assert_eq!(singer.tick(), 0);
    }
}
