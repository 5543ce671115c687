//! A file that is written beside a recording and replaces it when it is complete.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use super::CaptureError;
use super::files::{FINISHING, REPLACED, sync_folder, with_suffix};

/// A file under a temporary name, removed unless it replaces its target.
pub(super) struct Temporary {
    pub(super) path: PathBuf,
    pub(super) file: File,
    target: PathBuf,
}

impl Temporary {
    /// Creates the file; a leftover of an interrupted attempt is replaced.
    ///
    /// # Errors
    /// If the file cannot be created.
    pub(super) fn create(target: &Path) -> Result<Self, CaptureError> {
        let path = with_suffix(target, FINISHING);
        let _ = fs::remove_file(&path);
        let file = File::create_new(&path).map_err(|error| CaptureError::Recovering {
            path: target.to_owned(),
            error,
        })?;
        Ok(Self {
            path,
            file,
            target: target.to_owned(),
        })
    }

    /// Syncs the file and renames it over its target.
    ///
    /// # Errors
    /// If the disk fails; the target is then unchanged.
    pub(super) fn put_in_place(self) -> Result<(), CaptureError> {
        self.file
            .sync_all()
            .and_then(|()| replace(&self.path, &self.target))
            .map_err(|error| self.failed(error))?;
        sync_folder(&self.target);
        Ok(())
    }

    /// The error for a file that could not be written.
    pub(super) fn failed(&self, error: io::Error) -> CaptureError {
        CaptureError::Recovering {
            path: self.target.clone(),
            error,
        }
    }
}

/// Renames a file over another one.
fn replace(path: &Path, target: &Path) -> io::Result<()> {
    match fs::rename(path, target) {
        // Windows replaces an open file on NTFS only. Elsewhere it can still be renamed, and removed when it is closed.
        Err(error) if cfg!(windows) && error.kind() == io::ErrorKind::PermissionDenied => {
            let replaced = with_suffix(target, REPLACED);
            fs::rename(target, &replaced)?;
            fs::rename(path, target).inspect_err(|_| {
                let _ = fs::rename(&replaced, target);
            })?;
            let _ = fs::remove_file(&replaced);
            Ok(())
        }
        result => result,
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        // After the rename no file has this name.
        let _ = fs::remove_file(&self.path);
    }
}
