//! The robot's songs and the player for its beeper.

/// Frequency of a note in hertz, 0 for a rest, and its length in ticks.
pub type Note = (u16, u8);

/// The songs. Each fits one telemetry line: at most [`NOTES_MAX`] notes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Song {
    /// End of the route: a rising call and its answer, about 4 s.
    Finished,
    /// End of wandering: two alternating tones.
    Alarm,
    /// Hiding: a lullaby.
    Passive,
    /// Low battery: a falling call and a question.
    LowBattery,
    /// The robot has docked.
    Docked,
    /// The robot is back home.
    Home,
}

/// Maximum number of notes of a song.
pub const NOTES_MAX: usize = 21;

/// Maximum length of a note in ticks.
pub const NOTE_TICKS_MAX: u8 = 63;

/// Maximum frequency of a note in hertz.
pub const NOTE_HZ_MAX: u16 = 4095;

impl Song {
    /// All songs.
    pub const ALL: [Self; 6] = [
        Self::Finished,
        Self::Alarm,
        Self::Passive,
        Self::LowBattery,
        Self::Docked,
        Self::Home,
    ];

    /// Notes of the song.
    #[must_use]
    pub const fn notes(self) -> &'static [Note] {
        match self {
            Self::Finished => &[
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
            ],
            Self::Alarm => &[
                (1568, 5),
                (1175, 5),
                (1568, 5),
                (1175, 5),
                (1568, 5),
                (1175, 5),
                (0, 5),
                (1568, 5),
                (1175, 5),
                (1568, 5),
                (1175, 5),
            ],
            Self::Passive => &[
                (659, 6),
                (659, 4),
                (784, 14),
                (0, 2),
                (659, 6),
                (659, 4),
                (784, 14),
                (0, 2),
                (659, 5),
                (784, 5),
                (1047, 10),
                (988, 8),
                (880, 8),
                (880, 5),
                (784, 16),
            ],
            Self::LowBattery => &[
                (880, 8),
                (698, 8),
                (587, 12),
                (0, 6),
                (587, 4),
                (698, 4),
                (880, 10),
            ],
            Self::Docked => &[(523, 4), (784, 4), (1047, 10)],
            Self::Home => &[
                (784, 4),
                (784, 4),
                (1047, 8),
                (988, 4),
                (880, 4),
                (784, 8),
                (659, 4),
                (784, 16),
            ],
        }
    }
}

/// Plays a song on the beeper.
#[derive(Clone, Debug, Default)]
pub struct SongPlayer {
    rest: &'static [Note],
    played_ticks: u8,
}

impl SongPlayer {
    /// Starts a song and ends the current one.
    pub const fn begin(&mut self, song: Song) {
        self.rest = song.notes();
        self.played_ticks = 0;
    }

    /// Ends the current song.
    pub const fn stop(&mut self) {
        self.rest = &[];
    }

    /// Tone for the next tick in hertz; 0 is silence.
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

    /// Line S must announce the song that is played.
    #[test]
    fn songs_fit_into_line_s() {
        for song in Song::ALL {
            let note = |&(hz, ticks): &Note| telemetry::Note { hz, ticks };
            let sung: Vec<_> = song.notes().iter().map(note).collect();
            let said: Vec<_> = SongLine::new(sung.iter().copied()).notes().collect();
            assert_eq!(said, sung);
        }
    }

    #[test]
    fn player_plays_every_note_for_its_length() {
        let mut player = SongPlayer::default();
        assert_eq!(player.tick(), 0);
        for song in Song::ALL {
            player.begin(song);
            for &(hz, length) in song.notes() {
                for _ in 0..length {
                    assert_eq!(player.tick(), hz);
                }
            }
            assert_eq!(player.tick(), 0);
            player.begin(song);
            player.tick();
            player.stop();
            assert_eq!(player.tick(), 0);
        }
    }

    #[test]
    fn songs_keep_the_limits_of_notes_and_are_audible() {
        for song in Song::ALL {
            let notes = song.notes();
            assert!((1..=NOTES_MAX).contains(&notes.len()), "{song:?}");
            for &(hz, ticks) in notes {
                assert!(
                    hz == 0 || (200..=NOTE_HZ_MAX).contains(&hz),
                    "{song:?}: {hz}"
                );
                assert!((1..=NOTE_TICKS_MAX).contains(&ticks), "{song:?}: {ticks}");
            }
            assert_ne!(notes.last().map(|note| note.0), Some(0), "{song:?}");
        }
    }
}
