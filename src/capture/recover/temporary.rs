//! A recording that is being made whole.

use std::fs::{self, File};
use std::path::PathBuf;

use super::files::with_suffix;
use super::{Paths, sync_folder, write_error};
use crate::capture::CaptureError;

/// What is being written, until it takes the place of what was there.
pub(super) struct Temporary {
    pub(super) path: PathBuf,
    pub(super) file: File,
}

impl Temporary {
    pub(super) fn create(paths: &Paths) -> Result<Self, CaptureError> {
        let path = with_suffix(&paths.target, ".recovering");
        // One that is there was left by a recovery that was interrupted.
        let file = File::create(&path).map_err(|error| CaptureError::Create {
            path: path.clone(),
            error,
        })?;
        Ok(Self { path, file })
    }

    pub(super) fn put_in_place(self, paths: &Paths) -> Result<(), CaptureError> {
        self.file
            .sync_all()
            .and_then(|()| fs::rename(&self.path, &paths.target))
            .map_err(|error| write_error(&self.path, error))?;
        sync_folder(&paths.target);
        Ok(())
    }
}
