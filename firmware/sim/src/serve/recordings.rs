//! Files written while the robot is served: the trace and the sound.

use std::fs::File;
use std::io::{self, BufWriter};
use std::path::Path;

use super::error::ServeError;
use super::options::ServeOptions;
use crate::simulation::Simulation;
use crate::sound::Sound;
use crate::time::TICK_MS;
use crate::trace::Trace;

/// The open files. A write error ends the file but not the robot.
pub(super) struct Recordings {
    trace: Option<Trace<BufWriter<File>>>,
    sound: Option<Sound<BufWriter<File>>>,
}

impl Recordings {
    /// Opens the files that the options name.
    pub(super) fn begin(options: &ServeOptions) -> Result<Self, ServeError> {
        Ok(Self {
            trace: begin(options.trace.as_deref(), "trace", Trace::new)?,
            sound: begin(options.wav.as_deref(), "sound", Sound::new)?,
        })
    }

    /// Writes the current tick; call it after every step.
    pub(super) fn observe(&mut self, simulation: &Simulation) {
        if let Some(trace) = &mut self.trace
            && let Err(error) = trace.observe(simulation)
        {
            eprintln!("writing the trace failed: {error}; the file ends here");
            self.trace = None;
        }
        if simulation.now_ms().is_multiple_of(TICK_MS)
            && let Some(sound) = &mut self.sound
            && let Err(error) = sound.tick(simulation.outputs().note_hz)
        {
            eprintln!("writing the sound failed: {error}; the file ends here");
            self.sound = None;
        }
    }

    /// Completes the open files.
    pub(super) fn finish(self) {
        if let Some(Err(error)) = self.trace.map(Trace::finish) {
            eprintln!("completing the trace failed: {error}; its end is missing");
        }
        if let Some(Err(error)) = self.sound.map(Sound::finish) {
            eprintln!("completing the sound failed: {error}; its end is missing");
        }
    }
}

fn begin<T>(
    path: Option<&Path>,
    kind: &'static str,
    start: impl FnOnce(BufWriter<File>) -> io::Result<T>,
) -> Result<Option<T>, ServeError> {
    let Some(path) = path else {
        return Ok(None);
    };
    File::create(path)
        .and_then(|file| start(BufWriter::new(file)))
        .map(Some)
        .map_err(|source| ServeError::Recording {
            kind,
            path: path.to_owned(),
            source,
        })
}
