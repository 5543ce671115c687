//! The songs in a capture.

use std::fmt;
use std::time::Duration;

use groundwave_protocol::decoder::{Counters, Decoder, Received};
use groundwave_protocol::telemetry::{Body, Note, SongLine};

use super::{Capture, CaptureError};
use crate::song::note_name;

/// Calls `take` with each song and the time of its line; returns the decoder's totals. Times count from the capture's beginning.
///
/// # Errors
/// The errors of the capture and of `take`.
pub fn for_each_song<E: From<CaptureError>>(
    capture: &mut Capture,
    mut take: impl FnMut(Duration, &SongLine) -> Result<(), E>,
) -> Result<Counters, E> {
    let mut decoder = Decoder::default();
    capture.for_each_line(&mut decoder, |at, received| match received {
        Received::Line(line, _) => match &line.body {
            Body::Song(song) => take(at, song),
            _ => Ok(()),
        },
        Received::Ack(_) => Ok(()),
    })?;
    Ok(*decoder.counters())
}

/// Duration of a song.
#[must_use]
pub fn length(song: &SongLine) -> Duration {
    song.notes().map(note_length).sum()
}

/// Duration of a note.
fn note_length(note: Note) -> Duration {
    Duration::from_millis(50) * u32::from(note.ticks)
}

/// Displays the notes with their durations in seconds: `C5 0.20  - 0.10  E5 0.40`.
pub struct Notes<'a>(pub &'a SongLine);

impl fmt::Display for Notes<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (place, note) in self.0.notes().enumerate() {
            let gap = if place > 0 { "  " } else { "" };
            let length_s = note_length(note).as_secs_f64();
            write!(f, "{gap}{} {length_s:.2}", note_name(note.hz))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_song_reads_as_its_notes() {
        let note = |hz, ticks| Note { hz, ticks };
        let song = SongLine::new([note(523, 4), note(0, 2), note(659, 8)]);
        assert_eq!(Notes(&song).to_string(), "C5 0.20  - 0.10  E5 0.40");
        assert_eq!(length(&song), Duration::from_millis(700));
        assert_eq!(Notes(&SongLine::new([])).to_string(), "");
    }
}
