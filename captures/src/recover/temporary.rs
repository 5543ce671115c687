//! A recording that is being made whole.

use std::fs::{self, File};
use std::io;
use std::path::PathBuf;

use super::files::with_suffix;
use super::{Paths, sync_folder};
use crate::CaptureError;

/// What is being written, until it takes the place of what was there.
pub(super) struct Temporary {
    pub(super) path: PathBuf,
    pub(super) file: File,
    target: PathBuf,
}

impl Temporary {
    pub(super) fn create(paths: &Paths) -> Result<Self, CaptureError> {
        let path = with_suffix(&paths.target, ".recovering");
        // One that is there was left by a recovery that was interrupted.
        let file = File::create(&path).map_err(|error| CaptureError::Recovering {
            path: paths.target.clone(),
            error,
        })?;
        Ok(Self {
            path,
            file,
            target: paths.target.clone(),
        })
    }

    pub(super) fn put_in_place(self, paths: &Paths) -> Result<(), CaptureError> {
        self.file
            .sync_all()
            .and_then(|()| fs::rename(&self.path, &paths.target))
            .map_err(|error| self.failed(error))?;
        sync_folder(&paths.target);
        Ok(())
    }
    /// It could not be written; what it was to replace is as it was.
    pub(super) fn failed(&self, error: io::Error) -> CaptureError {
        CaptureError::Recovering {
            path: self.target.clone(),
            error,
        }
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        // After the rename there is none of that name.
        let _ = fs::remove_file(&self.path);
    }
}
