//! Writes raw text: the radio's bytes alone.

use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use super::error::create;
use super::{CaptureError, Existing, presence};

/// Appends each read of the radio to a file in one unbuffered write, so that a kill loses nothing.
#[derive(Debug)]
pub struct RawWriter {
    path: PathBuf,
    file: File,
    bytes: u64,
    problem: Option<CaptureError>,
    /// The file was removed or renamed.
    gone: Option<CaptureError>,
}

impl RawWriter {
    /// Creates the file.
    ///
    /// # Errors
    /// When it exists and may not be overwritten, or cannot be created.
    pub fn create(path: impl Into<PathBuf>, existing: Existing) -> Result<Self, CaptureError> {
        let path = path.into();
        Ok(Self {
            file: create(&path, existing, true)?,
            path,
            bytes: 0,
            problem: None,
            gone: None,
        })
    }

    /// Writes the bytes of one read; call it before parsing them. After an error nothing more is written, so that the
    /// file stays an exact beginning of the stream; [`Self::problem`] and [`Self::finish`] return the error.
    pub fn write(&mut self, bytes: &[u8]) {
        if self.problem.is_some() {
            return;
        }
        if let Err(error) = self.write_all(bytes) {
            self.problem = Some(CaptureError::Write {
                path: self.path.clone(),
                error,
            });
        }
    }

    fn write_all(&mut self, mut bytes: &[u8]) -> io::Result<()> {
        while !bytes.is_empty() {
            match self.file.write(bytes) {
                Ok(0) => return Err(io::ErrorKind::WriteZero.into()),
                Ok(written) => {
                    self.bytes += written as u64;
                    bytes = &bytes[written..];
                }
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }

    /// Checks that the file still has its name; [`Self::problem`] returns the result. Writing goes on, because a renamed file
    /// keeps the bytes.
    pub fn look(&mut self) {
        if self.gone.is_none() {
            self.gone = presence::check(&self.file, &self.path).err();
        }
    }

    /// Syncs the file; returns the number of bytes written.
    ///
    /// # Errors
    /// The first error since the start, a removed file, or a failed sync. Pipes and devices are not synced.
    pub fn finish(mut self) -> Result<u64, CaptureError> {
        self.look();
        if let Some(problem) = self.problem.or(self.gone) {
            return Err(problem);
        }
        let Err(error) = self.file.sync_data() else {
            return Ok(self.bytes);
        };
        let has_no_disk = matches!(
            error.kind(),
            io::ErrorKind::InvalidInput
                | io::ErrorKind::Unsupported
                | io::ErrorKind::ReadOnlyFilesystem
        );
        let is_file = self.file.metadata().is_ok_and(|about| about.is_file());
        if has_no_disk && !is_file {
            return Ok(self.bytes);
        }
        Err(CaptureError::Write {
            path: self.path,
            error,
        })
    }

    /// Path of the file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Bytes written.
    #[must_use]
    pub const fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Reason why writing ended or the file is lost.
    #[must_use]
    pub fn problem(&self) -> Option<String> {
        let problem = self.problem.as_ref().or(self.gone.as_ref());
        problem.map(ToString::to_string)
    }
}
