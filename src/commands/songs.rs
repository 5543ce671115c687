//! `songs`: lists the robot's songs as notes, and saves them as sound.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::Path;
use std::time::Duration;

use groundwave_protocol::telemetry::SongLine;
use sr04_sim::Sound;

use super::cli::Songs;
use super::output::check_inputs;
use super::{Exit, Fault, out, say};
use crate::capture::files;
use crate::capture::songs::{Notes, for_each_song, length};
use crate::capture::{Capture, CaptureError};
use crate::hint;
use groundwave_captures::words::counted;

/// Reason why the list ended early.
enum End {
    Capture(CaptureError),
    Output(io::Error),
    File(Fault),
}

impl From<CaptureError> for End {
    fn from(error: CaptureError) -> Self {
        Self::Capture(error)
    }
}

pub(super) fn run(options: &Songs) -> Result<(), Fault> {
    let mut capture = Capture::open(&options.file)?;
    let mut count = 0;
    let result = for_each_song(&mut capture, |at, song| {
        count += 1;
        list(count, at, song).map_err(End::Output)?;
        match &options.wav {
            Some(folder) => save(options, folder, count, song).map_err(End::File),
            None => Ok(()),
        }
    });
    match result {
        Ok(seen) if seen.received() == 0 => Err(Fault::no_lines(&options.file, seen.bytes)),
        Ok(seen) => {
            if count == 0 {
                say(format_args!(
                    "{}: no song in {}",
                    options.file.display(),
                    counted(seen.received(), "line")
                ));
            }
            Ok(())
        }
        Err(End::Capture(error)) => Err(Fault::from(error)),
        Err(End::Output(error)) => Fault::output(&error),
        Err(End::File(fault)) => Err(fault),
    }
}

/// Prints a song. Standard output is flushed at each line feed, so that songs of a live stream appear at once.
fn list(number: u32, at: Duration, song: &SongLine) -> io::Result<()> {
    writeln!(
        out(),
        "{number:02}  at {:.1} s, {:.2} s long:  {}",
        at.as_secs_f64(),
        length(song).as_secs_f64(),
        Notes(song)
    )
}

fn save(options: &Songs, folder: &Path, number: u32, song: &SongLine) -> Result<(), Fault> {
    let path = folder.join(format!("song-{number:02}.wav"));
    check_inputs(&path, [&options.file])?;
    write_wav(&path, song, options.force).map_err(|error| match error.kind() {
        io::ErrorKind::AlreadyExists if path.exists() => Fault::new(
            Exit::Usage,
            format!(
                "{} exists; choose another folder, or use --force to overwrite its files",
                path.display()
            ),
        ),
        _ => Fault::new(
            Exit::Failed,
            format!(
                "cannot write {}: {}",
                path.display(),
                hint::of_writing(&error)
            ),
        ),
    })
}

fn write_wav(path: &Path, song: &SongLine, force: bool) -> io::Result<()> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    let file = if force {
        files::open_to_write(
            File::options().write(true).create(true).truncate(true),
            path,
        )
    } else {
        File::create_new(path)
    };
    let mut sound = Sound::new(BufWriter::new(file?))?;
    for note in song.notes() {
        for _ in 0..note.ticks {
            sound.tick(note.hz)?;
        }
    }
    sound.finish()
}
