//! Damaged files are kept beside what was made of them.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use super::files::with_suffix;
use super::{BUFFER_BYTES, Paths};
use crate::CaptureError;
use crate::journal::Waste;

/// A damaged file under another name, the first free of `.damaged`, `.damaged-2` and so on behind `name`:
/// it is evidence. One that a recovery kept before it was interrupted is not kept twice.
pub(super) fn keep(paths: &Paths, source: &Path, name: &Path) -> Result<PathBuf, CaptureError> {
    let failed = |error| CaptureError::Recovering {
        path: paths.target.clone(),
        error,
    };
    let mut kept = with_suffix(name, ".damaged");
    for number in 2.. {
        match fs::symlink_metadata(&kept) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => break,
            Err(error) => return Err(failed(error)),
            Ok(_) if is_same(source, &kept).unwrap_or(false) => return Ok(kept),
            Ok(_) => kept = with_suffix(name, &format!(".damaged-{number}")),
        }
    }
    if fs::hard_link(source, &kept).is_err() {
        fs::copy(source, &kept).map_err(|error| {
            let _ = fs::remove_file(&kept);
            failed(error)
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
        one.by_ref()
            .take(BUFFER_BYTES as u64)
            .read_to_end(&mut left)?;
        other
            .by_ref()
            .take(BUFFER_BYTES as u64)
            .read_to_end(&mut right)?;
        if left.is_empty() || left != right {
            return Ok(left == right);
        }
    }
}

/// Keeps a journal of which something cannot be read; one that only ends in the middle of an entry has
/// given all it has.
pub(super) fn keep_journal(paths: &Paths, waste: Waste) -> Result<Option<PathBuf>, CaptureError> {
    waste
        .has_damage()
        .then(|| keep(paths, &paths.journal, &paths.journal))
        .transpose()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_that_is_too_long_to_be_kept_is_told() {
        let folder = tempfile::tempdir().unwrap();
        let paths = Paths::of(&folder.path().join("a".repeat(240)));
        fs::write(&paths.journal, "damaged").unwrap();
        let error = keep(&paths, &paths.journal, &paths.journal).unwrap_err();
        assert!(matches!(error, CaptureError::Recovering { .. }), "{error}");
        assert!(error.to_string().contains("a shorter name"), "{error}");
        assert!(paths.journal.exists());
    }
}
