//! Files written while the robot is served: the trace and the sound.

use std::fs::File;
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};

use super::error::ServeError;
use super::options::ServeOptions;
use crate::simulation::Simulation;
use crate::sound::Sound;
use crate::time::TICK_MS;
use crate::trace::Trace;

/// The files. A write error ends the file but not the robot.
pub(super) struct Recordings {
    trace: Option<Recording<Trace<BufWriter<File>>>>,
    sound: Option<Recording<Sound<BufWriter<File>>>>,
}

impl Recordings {
    /// Opens the files that the options name.
    pub(super) fn begin(options: &ServeOptions) -> Result<Self, ServeError> {
        Ok(Self {
            trace: Recording::begin(options.trace.as_deref(), "trace", Trace::new)?,
            sound: Recording::begin(options.wav.as_deref(), "sound", Sound::new)?,
        })
    }

    /// Writes the current tick; call it after every step. Returns the errors of files that end here.
    pub(super) fn observe(
        &mut self,
        simulation: &Simulation,
    ) -> impl Iterator<Item = ServeError> + use<> {
        let trace = self.trace.as_mut();
        let trace = trace.and_then(|trace| trace.write(|trace| trace.observe(simulation)));
        let is_tick = simulation.now_ms().is_multiple_of(TICK_MS);
        let sound = self.sound.as_mut().filter(|_| is_tick);
        let note_hz = simulation.outputs().note_hz;
        let sound = sound.and_then(|sound| sound.write(|sound| sound.tick(note_hz)));
        trace.into_iter().chain(sound)
    }

    /// Completes the files; returns the errors of those that are incomplete now.
    pub(super) fn finish(self) -> impl Iterator<Item = ServeError> {
        let trace = self.trace;
        let trace = trace.and_then(|trace| trace.finish(|trace| trace.finish().map(drop)));
        let sound = self.sound.and_then(|sound| sound.finish(Sound::finish));
        trace.into_iter().chain(sound)
    }
}

/// A file; without its writer after an error.
struct Recording<T> {
    writer: Option<T>,
    kind: &'static str,
    path: PathBuf,
}

impl<T> Recording<T> {
    fn begin(
        path: Option<&Path>,
        kind: &'static str,
        start: impl FnOnce(BufWriter<File>) -> io::Result<T>,
    ) -> Result<Option<Self>, ServeError> {
        let Some(path) = path else {
            return Ok(None);
        };
        let path = path.to_owned();
        let started = File::create(&path).and_then(|file| start(BufWriter::new(file)));
        match started {
            Ok(writer) => Ok(Some(Self {
                writer: Some(writer),
                kind,
                path,
            })),
            Err(source) => Err(ServeError::Recording { kind, path, source }),
        }
    }

    fn write(&mut self, write: impl FnOnce(&mut T) -> io::Result<()>) -> Option<ServeError> {
        let source = write(self.writer.as_mut()?).err()?;
        self.writer = None;
        Some(self.incomplete(source))
    }

    fn finish(mut self, finish: impl FnOnce(T) -> io::Result<()>) -> Option<ServeError> {
        let source = finish(self.writer.take()?).err()?;
        Some(self.incomplete(source))
    }

    fn incomplete(&self, source: io::Error) -> ServeError {
        ServeError::Incomplete {
            kind: self.kind,
            path: self.path.clone(),
            source,
        }
    }
}
