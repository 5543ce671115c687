//! Keeps a damaged file beside its replacement.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use super::CaptureError;
use super::files::{DAMAGED, with_suffix};

/// Buffer size for comparing two files, bytes.
const BUFFER_BYTES: u64 = 1024 * 1024;

/// Keeps a damaged file under the first free name of `.damaged`, `.damaged-2` and so on; returns that name. A file that an
/// interrupted recovery kept is not kept twice.
///
/// # Errors
/// If the file cannot be renamed.
pub(super) fn keep(path: &Path) -> Result<PathBuf, CaptureError> {
    let failed = |error| CaptureError::Recovering {
        path: path.to_owned(),
        error,
    };
    let mut kept = with_suffix(path, DAMAGED);
    for number in 2.. {
        match fs::symlink_metadata(&kept) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => break,
            Err(error) => return Err(failed(error)),
            Ok(_) if is_same(path, &kept).unwrap_or(false) => return Ok(kept),
            Ok(_) => kept = with_suffix(path, &format!("{DAMAGED}-{number}")),
        }
    }
    if fs::hard_link(path, &kept).is_err() {
        fs::copy(path, &kept).map_err(|error| {
            let _ = fs::remove_file(&kept);
            // Windows does not find the folder of a path that is too long.
            let is_too_long = error.kind() == io::ErrorKind::NotFound && path.exists();
            failed(if is_too_long {
                io::ErrorKind::InvalidFilename.into()
            } else {
                error
            })
        })?;
    }
    Ok(kept)
}

fn is_same(one: &Path, other: &Path) -> io::Result<bool> {
    let (mut one, mut other) = (File::open(one)?, File::open(other)?);
    if one.metadata()?.len() != other.metadata()?.len() {
        return Ok(false);
    }
    let (mut left, mut right) = (Vec::new(), Vec::new());
    loop {
        left.clear();
        right.clear();
        one.by_ref().take(BUFFER_BYTES).read_to_end(&mut left)?;
        other.by_ref().take(BUFFER_BYTES).read_to_end(&mut right)?;
        if left.is_empty() || left != right {
            return Ok(left == right);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_that_is_too_long_to_be_kept_is_reported() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a".repeat(250));
        fs::write(&path, "damaged").unwrap();
        let error = keep(&path).unwrap_err();
        assert!(matches!(error, CaptureError::Recovering { .. }), "{error}");
        assert!(error.to_string().contains("a shorter name"), "{error}");
        assert!(path.exists());
    }
}
