//! The unlink check: whether an open file still has its name.
//!
//! Writing to a removed file succeeds on every system, and the bytes are lost when it is closed.

use std::fs::{self, File, Metadata};
use std::io;
use std::path::Path;

use super::CaptureError;
use super::error::Fate;

/// Checks that the path still leads to the open file. Pipes, devices and files that cannot be examined are accepted.
///
/// # Errors
/// [`CaptureError::Gone`].
pub(super) fn check(file: &File, path: &Path) -> Result<(), CaptureError> {
    let Some(open) = file.metadata().ok().filter(Metadata::is_file) else {
        return Ok(());
    };
    let is_there = match fs::metadata(path) {
        Ok(named) => is_same(&open, &named),
        Err(error) => !matches!(
            error.kind(),
            io::ErrorKind::NotFound | io::ErrorKind::NotADirectory
        ),
    };
    if is_there {
        return Ok(());
    }
    Err(CaptureError::Gone {
        path: path.to_owned(),
        fate: fate(&open),
    })
}

#[cfg(unix)]
pub(super) fn is_same(a: &Metadata, b: &Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    (a.dev(), a.ino()) == (b.dev(), b.ino())
}

/// On other systems an existing name is enough.
#[cfg(not(unix))]
pub(super) fn is_same(_: &Metadata, _: &Metadata) -> bool {
    true
}

#[cfg(unix)]
fn fate(open: &Metadata) -> Fate {
    use std::os::unix::fs::MetadataExt;
    if open.nlink() > 0 {
        Fate::Moved
    } else {
        Fate::Removed
    }
}

#[cfg(not(unix))]
fn fate(_: &Metadata) -> Fate {
    Fate::Unknown
}
