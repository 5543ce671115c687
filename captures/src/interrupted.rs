//! Unfinished recordings: recognizes them by their header, finds them in a folder, renames them.

use std::fs;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use ::mcap::MAGIC;
use ::mcap::records::{Record, op};

use super::CaptureError;
use super::files::{self, Lock, is_in_use};
use super::name::another;
use super::record::{HEAD_BYTES, parse};

/// Maximum number of names tried for a renamed recording.
const NAMES_MAX: u32 = 1_000_000;

/// Library name in the header of an unfinished recording.
pub(crate) const LIBRARY: &str = concat!("groundwave ", env!("CARGO_PKG_VERSION"), ", unfinished");

/// Maximum length of the header that [`is_unfinished`] reads, bytes.
const HEADER_BYTES_MAX: u64 = 256;

/// Whether the header of a file marks an unfinished recording.
pub(crate) fn is_unfinished(path: &Path) -> bool {
    let mut begin = Vec::new();
    files::open(path)
        .and_then(|file| file.take(HEADER_BYTES_MAX).read_to_end(&mut begin))
        .is_ok_and(|_| library(&begin).is_some_and(|library| is_library(&library)))
}

/// Whether the library name in a header marks an unfinished recording, of any version.
pub(crate) fn is_library(library: &str) -> bool {
    library.starts_with("groundwave ") && library.ends_with(", unfinished")
}

/// Library name in the header at the beginning of an MCAP file.
fn library(begin: &[u8]) -> Option<String> {
    let (head, rest) = begin
        .strip_prefix(MAGIC)?
        .split_first_chunk::<HEAD_BYTES>()?;
    let [op::HEADER, length @ ..] = *head else {
        return None;
    };
    let body = rest.get(..usize::try_from(u64::from_le_bytes(length)).ok()?)?;
    match parse(op::HEADER, body) {
        Some(Record::Header(header)) => Some(header.library),
        _ => None,
    }
}

/// The unfinished recordings in a folder that no program is writing, sorted by name.
#[must_use]
pub fn find_interrupted(folder: &Path) -> Vec<PathBuf> {
    let folder = if folder.as_os_str().is_empty() {
        Path::new(".")
    } else {
        folder
    };
    let Ok(entries) = fs::read_dir(folder) else {
        return Vec::new();
    };
    let mut found: Vec<PathBuf> = entries
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| {
            path.extension()
                .is_some_and(|extension| extension == "mcap")
        })
        .filter(|path| path.is_file() && is_unfinished(path) && !is_in_use(path))
        .collect();
    found.sort();
    found
}

/// Renames an unfinished recording with this name, to free the name; returns its new name.
///
/// # Errors
/// If the recording is being written now, or cannot be renamed.
pub fn set_aside(path: &Path) -> Result<Option<PathBuf>, CaptureError> {
    if !is_unfinished(path) {
        return Ok(None);
    }
    let opened = |error| CaptureError::Open {
        path: path.to_owned(),
        error,
    };
    let Some(_lock) = Lock::take(path).map_err(opened)? else {
        return Err(CaptureError::InUse(path.to_owned()));
    };
    let aside = match path.extension() {
        Some(extension) => path
            .with_extension("interrupted")
            .with_added_extension(extension),
        None => path.with_added_extension("interrupted"),
    };
    let mut names = (1..=NAMES_MAX).map(|number| another(&aside, number));
    let aside = names.find(|name| !name.exists()).unwrap_or(aside);
    fs::rename(path, &aside).map_err(|error| CaptureError::SetAside {
        path: path.to_owned(),
        error,
    })?;
    Ok(Some(aside))
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use crate::session::Session;
    use crate::unfinished::UnfinishedWriter;
    use std::fs::File;

    /// The recording's name with `.interrupted` would be too long.
    #[test]
    fn an_interrupted_recording_that_cannot_be_renamed_is_reported() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(format!("{}.mcap", "a".repeat(250)));
        let file = File::create(&path).unwrap();
        let session = Session {
            link: String::new(),
            start: std::time::UNIX_EPOCH,
            notes: std::collections::BTreeMap::new(),
            configuration: String::new(),
        };
        UnfinishedWriter::begin(file, &path, &session).unwrap();
        let words = set_aside(&path).unwrap_err().to_string();
        assert!(
            words.starts_with("cannot rename the interrupted recording"),
            "{words}"
        );
        assert!(words.ends_with("choose another name"), "{words}");
        assert!(path.exists());
    }
}
