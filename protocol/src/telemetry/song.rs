//! Line S: the notes of a song, sent when the song begins.
//!
//! ```text
//! 1-3  5-67                                                            70-74 75-78
//! S49  (+$*3$,0$07(``"                                                 BH5*' ^*"+
//! seq  notes: frequency in Hz (2 characters), length in ticks (1)      ack   CRC
//! ```

use super::columns::Columns;
use super::fields::{Fields, Parsed, Read, bytes, sixbits, spaces};
use crate::sixbit;
use nom::Parser;
use nom::combinator::verify;

/// Maximum number of notes in a song.
pub const SONG_NOTES: usize = 21;

/// Number of characters of a note.
const NOTE_BYTES: usize = 3;

/// Maximum frequency in two characters, hertz.
const HZ_MAX: u16 = 4095;

/// Maximum length of a note in one character, ticks.
const TICKS_MAX: u8 = 63;

/// One note.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Note {
    /// Frequency in hertz, up to 4095; 0 is a rest.
    pub hz: u16,
    /// Length in ticks of a twentieth of a second, 1 to 63.
    pub ticks: u8,
}

/// Line S.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SongLine {
    /// The notes as on the wire, because a line's body must stay small on the robot.
    characters: [u8; SONG_NOTES * NOTE_BYTES],
}

impl SongLine {
    /// A song of the first [`SONG_NOTES`] notes, each clamped to the range of its fields.
    #[must_use]
    pub fn new(notes: impl IntoIterator<Item = Note>) -> Self {
        let mut characters = [b' '; SONG_NOTES * NOTE_BYTES];
        for (to, note) in characters.chunks_exact_mut(NOTE_BYTES).zip(notes) {
            let ticks = note.ticks.clamp(1, TICKS_MAX);
            sixbit::encode_into(u32::from(note.hz.min(HZ_MAX)) << 6 | u32::from(ticks), to);
        }
        Self { characters }
    }

    /// The notes in order.
    pub fn notes(&self) -> impl Iterator<Item = Note> + '_ {
        let written = self.characters.chunks_exact(NOTE_BYTES);
        written.map_while(|note| {
            let bits = sixbit::decode_from(note)?;
            Some(Note {
                hz: (bits >> 6) as u16,
                ticks: bits as u8 & TICKS_MAX,
            })
        })
    }

    pub(super) fn write(&self, columns: &mut Columns) {
        columns.bytes(5, &self.characters);
    }

    pub(super) fn read(line: &mut Fields) -> Read<Self> {
        line.next(spaces::<1>)?;
        let (end, characters) = bytes(line.rest())?;
        while line.rest().len() > end.len() && !line.rest().starts_with(b"   ") {
            line.next(note)?;
        }
        while line.rest().len() > end.len() {
            line.next(spaces::<1>)?;
        }
        line.next(spaces::<1>)?;
        Ok(Self { characters })
    }
}

/// Parses a note: frequency and length; a length of 0 is an error.
fn note(input: &[u8]) -> Parsed<'_, u32> {
    verify(sixbits::<NOTE_BYTES, u32>, |bits| bits % 64 > 0).parse(input)
}

#[cfg(test)]
mod tests {
    use super::super::Body;
    use super::super::testing::{blamed, edits, has_one_form, read_back};
    use super::*;
    use proptest::prelude::*;
    use std::vec::Vec;

    fn notes(wild: bool) -> impl Strategy<Value = Vec<Note>> {
        let hz = 0..=if wild { u16::MAX } else { HZ_MAX };
        let ticks = if wild { 0..=u8::MAX } else { 1..=TICKS_MAX };
        let most = if wild { 40 } else { SONG_NOTES };
        let note = (hz, ticks).prop_map(|(hz, ticks)| Note { hz, ticks });
        prop::collection::vec(note, 0..=most)
    }

    proptest! {
        #[test]
        fn notes_in_range_survive_a_round_trip(notes in notes(false)) {
            let line = SongLine::new(notes.iter().copied());
            prop_assert_eq!(read_back(Body::Song(line)), Body::Song(line));
            prop_assert_eq!(line.notes().collect::<Vec<_>>(), notes);
        }

        #[test]
        fn any_notes_make_a_readable_line(notes in notes(true)) {
            read_back(Body::Song(SongLine::new(notes)));
        }

        #[test]
        fn readable_lines_have_one_form(notes in notes(false), edits in edits()) {
            has_one_form(Body::Song(SongLine::new(notes)), &edits);
        }
    }

    #[test]
    fn notes_are_clamped_and_limited_to_21() {
        let loud = Note { hz: 5000, ticks: 0 };
        let line = SongLine::new([loud; 30]);
        let said: Vec<_> = line.notes().collect();
        assert_eq!(said, [Note { hz: 4095, ticks: 1 }; SONG_NOTES]);
    }

    #[test]
    fn bad_notes_are_blamed_by_their_first_column() {
        let song = SongLine::new([Note { hz: 523, ticks: 4 }, Note { hz: 0, ticks: 2 }]);
        let bad: &[(usize, &[u8], u8)] = &[
            (4, b"x", 4),
            (5, b"a", 5),
            (6, b" ", 5),
            (7, b"`", 5),
            (10, b" ", 8),
            (8, b"   !!!", 11),
            (11, b" !", 11),
            (14, b"!!!", 14),
            (16, b"x", 16),
            (68, b"!", 68),
            (69, b"x", 69),
        ];
        for &(column, characters, column_blamed) in bad {
            let said = blamed(Body::Song(song), column, characters);
            let shown = characters.escape_ascii();
            assert_eq!(said, Some(column_blamed), "{shown} at {column}");
        }
    }
}
