//! Writes raw captures: the bytes of the radio, and nothing else.

use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use super::error::create;
use super::{CaptureError, Existing, presence};

/// Appends what is read from the radio to a file, each read in one write and without a buffer, so that
/// a killed program has lost nothing.
#[derive(Debug)]
pub struct RawWriter {
    path: PathBuf,
    file: File,
    bytes: u64,
    problem: Option<CaptureError>,
    /// The file is not where its name says.
    gone: Option<CaptureError>,
}

impl RawWriter {
    /// Creates the file.
    ///
    /// # Errors
    /// When it exists and may not be touched, or cannot be made.
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

    /// Writes what was just read, before anything else sees it. Nothing here fails: after an error
    /// nothing more is written, so that the file is exactly the beginning of the stream;
    /// [`Self::problem`] and [`Self::finish`] tell.
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

    /// Looks whether the file is still where its name says; [`Self::problem`] tells. What comes is written
    /// on even if it is not, for a file that was only moved has it.
    pub fn look(&mut self) {
        if self.gone.is_none() {
            self.gone = presence::check(&self.file, &self.path).err();
        }
    }

    /// Waits until the disk has everything; returns how many bytes that is.
    ///
    /// # Errors
    /// What went wrong since the start, that the file was taken away, or that the disk will not. A pipe or a device that knows nothing
    /// of disks has had its bytes when it took them.
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

    /// Where the bytes go.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Bytes written.
    #[must_use]
    pub const fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Why writing has ended, or why it leads nowhere.
    #[must_use]
    pub fn problem(&self) -> Option<String> {
        let problem = self.problem.as_ref().or(self.gone.as_ref());
        problem.map(ToString::to_string)
    }
}
