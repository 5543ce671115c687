//! Note names, and the meanings of the robot's songs.

use groundwave_protocol::telemetry::SongLine;

/// First three notes (hertz) and meaning of each song of the SR04 firmware.
const MEANINGS: [([u16; 3], &str); 6] = [
    ([523, 659, 784], "finished its route"),
    ([1568, 1175, 1568], "wandered long enough, goes home"),
    ([659, 659, 784], "hidden, waits for a person"),
    ([880, 698, 587], "battery low"),
    ([523, 784, 1047], "on the dock"),
    ([784, 784, 1047], "home again"),
];

/// Meaning of a song; `None` for an unknown one.
#[must_use]
pub fn meaning(song: &SongLine) -> Option<&'static str> {
    let begins = |beginning: &[u16; 3]| {
        let mut notes = song.notes();
        beginning
            .iter()
            .all(|hz| notes.next().is_some_and(|note| note.hz == *hz))
    };
    MEANINGS
        .iter()
        .find(|(beginning, _)| begins(beginning))
        .map(|(_, meaning)| *meaning)
}

/// Name of the nearest semitone, A4 = 440 Hz; a dash for a rest.
#[must_use]
pub fn note_name(hz: u16) -> String {
    const NAMES: [&str; 12] = [
        "C", "C#", "D", "D#", "E", "F", "F#", "G", "G#", "A", "A#", "B",
    ];
    /// A4 above C0, in semitones.
    const A4: i32 = 4 * 12 + 9;
    if hz == 0 {
        return "-".to_owned();
    }
    let above_a4 = (f64::from(hz) / 440.0).log2() * 12.0;
    let key = A4 + above_a4.round() as i32;
    let name = NAMES[key.rem_euclid(12) as usize];
    format!("{name}{}", key.div_euclid(12))
}

#[cfg(test)]
mod tests {
    use groundwave_protocol::telemetry::Note;
    use sr04_firmware::song::Song;

    use super::*;

    #[test]
    fn notes_have_the_names_that_musicians_give_them() {
        let named = [
            (440, "A4"),
            (262, "C4"),
            (523, "C5"),
            (466, "A#4"),
            (494, "B4"),
            (1568, "G6"),
            (28, "A0"),
            (1, "C-4"),
            (4095, "C8"),
            (0, "-"),
        ];
        for (hz, expected) in named {
            assert_eq!(note_name(hz), expected, "{hz} Hz");
        }
    }

    #[test]
    fn every_song_of_the_firmware_has_a_different_meaning() {
        let words: Vec<_> = Song::ALL
            .into_iter()
            .map(|song| {
                let note = |&(hz, ticks): &(u16, u8)| Note { hz, ticks };
                meaning(&SongLine::new(song.notes().iter().map(note)))
            })
            .collect();
        for (song, said) in Song::ALL.into_iter().zip(&words) {
            let alike = words.iter().filter(|other| *other == said);
            assert!(said.is_some() && alike.count() == 1, "{song:?}: {said:?}");
        }
        assert_eq!(meaning(&SongLine::new([])), None);
    }
}
