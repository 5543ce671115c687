//! The files of a recording: what they are called, who has them, and what makes room for them.

use std::ffi::OsString;
use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};

use super::{refuse_foreign, write_error};
use crate::CaptureError;
use crate::name::another;
use crate::rotation::part_name;

/// Nobody has so many recordings of one name.
const PARTS_MAX: u32 = 1_000_000;

/// The files of one recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Paths {
    /// The finished recording.
    pub target: PathBuf,
    /// The recording under way.
    pub partial: PathBuf,
    /// Its side-car.
    pub journal: PathBuf,
}

impl Paths {
    /// From the name of the recording, or from that of one of the other files.
    #[must_use]
    pub fn of(path: &Path) -> Self {
        let target = match path.extension().and_then(|extension| extension.to_str()) {
            Some("partial" | "journal") => path.with_extension(""),
            _ => path.to_owned(),
        };
        Self {
            partial: with_suffix(&target, ".partial"),
            journal: with_suffix(&target, ".journal"),
            target,
        }
    }

    /// Whether there is any of them.
    #[must_use]
    pub fn exist(&self) -> bool {
        self.are_interrupted() || self.target.exists()
    }

    /// Whether there is a recording that was never finished.
    #[must_use]
    pub fn are_interrupted(&self) -> bool {
        self.partial.exists() || self.journal.exists()
    }
}

pub(super) fn with_suffix(path: &Path, suffix: &str) -> PathBuf {
    let mut name = OsString::from(path);
    name.push(suffix);
    name.into()
}

/// Whether another program writes this recording now, or makes it whole.
#[must_use]
pub fn is_in_use(paths: &Paths) -> bool {
    Locks::take(paths).is_none()
}

/// `None` when another program has it. A file system that knows no locks has nobody else.
fn lock(file: &File) -> Option<()> {
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => None,
        Ok(()) | Err(TryLockError::Error(_)) => Some(()),
    }
}

/// Whether there is nothing yet but the journal's name: whoever begins the recording has not locked it.
fn is_just_begun(paths: &Paths) -> bool {
    let is_empty = fs::metadata(&paths.journal).is_ok_and(|about| about.len() == 0);
    is_empty && !paths.partial.exists()
}

/// Keeps others from taking a file that is written for one that nobody writes any more. Whoever looks holds the lock for
/// a moment, and that is waited for.
pub fn claim(file: &File) {
    // A file system that knows no locks keeps nobody away; the recording goes on all the same.
    let _ = file.lock();
}

/// Recordings in a folder that were interrupted and that nobody writes now, by the names they are to
/// have.
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
            let name = path.to_string_lossy();
            name.ends_with(".mcap.partial") || name.ends_with(".mcap.journal")
        })
        .map(|path| Paths::of(&path))
        .filter(|paths| !is_just_begun(paths) && !is_in_use(paths))
        .map(|paths| paths.target)
        .collect();
    found.sort();
    found.dedup();
    found
}

/// Whether the files of unfinished and damaged recordings are named like this.
#[must_use]
pub fn is_own_name(path: &Path) -> bool {
    let extension = path.extension().and_then(|extension| extension.to_str());
    matches!(
        extension,
        Some("partial" | "journal" | "recovering" | "damaged")
    )
}

/// Refuses a name that the files of unfinished and damaged recordings have.
///
/// # Errors
/// When it is one.
pub fn refuse_own_name(path: &Path) -> Result<(), CaptureError> {
    if is_own_name(path) {
        return Err(CaptureError::OwnName(path.to_owned()));
    }
    Ok(())
}

/// Makes room for a recording of that name: an interrupted one gets another, which is returned, and can
/// be recovered at leisure.
///
/// # Errors
/// When it is being written now, or cannot be renamed.
pub fn set_aside(path: &Path) -> Result<Option<PathBuf>, CaptureError> {
    let paths = Paths::of(path);
    if !paths.are_interrupted() {
        return Ok(None);
    }
    let Some(_locks) = Locks::take(&paths) else {
        return Err(CaptureError::InUse(path.to_owned()));
    };
    refuse_foreign(&paths)?;
    let aside = free_aside(path);
    rename_both(&paths, &aside)?;
    Ok(Some(aside.target))
}

/// Gives both files of an interrupted recording other names, as far as they are there.
pub(super) fn rename_both(from: &Paths, to: &Paths) -> Result<(), CaptureError> {
    for (from, to) in [(&from.journal, &to.journal), (&from.partial, &to.partial)] {
        match fs::rename(from, to) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => {
                return Err(write_error(from, error));
            }
            _ => {}
        }
    }
    Ok(())
}

/// The files of an interrupted recording that makes room for another of its name: `run.interrupted.mcap`.
#[must_use]
pub(super) fn free_aside(path: &Path) -> Paths {
    let aside = match path.extension() {
        Some(extension) => path
            .with_extension("interrupted")
            .with_added_extension(extension),
        None => path.with_added_extension("interrupted"),
    };
    let mut names = (1..=PARTS_MAX).map(|number| Paths::of(&another(&aside, number)));
    let free = names.find(|paths| !paths.exist());
    free.unwrap_or_else(|| Paths::of(&aside))
}

/// The first part from this one on of which there is no file: its number, and its files.
#[must_use]
pub fn free_part(path: &Path, from: u32) -> Option<(u32, Paths)> {
    (from..=PARTS_MAX)
        .map(|part| (part, Paths::of(&part_name(path, part))))
        .find(|(_, paths)| !paths.exist())
}

/// Keeps other programs away while it lives.
pub(super) struct Locks(#[expect(dead_code, reason = "held, not used")] Vec<File>);

impl Locks {
    /// `None` when another program writes this recording now, or makes it whole.
    pub(super) fn take(paths: &Paths) -> Option<Self> {
        [&paths.partial, &paths.journal]
            .into_iter()
            .filter_map(|path| File::open(path).ok())
            .map(|file| lock(&file).map(|()| file))
            .collect::<Option<_>>()
            .map(Self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicBool, Ordering};

    #[test]
    fn a_recording_that_has_just_begun_is_not_called_interrupted() {
        let folder = tempfile::tempdir().unwrap();
        let paths = Paths::of(&folder.path().join("a.mcap"));
        fs::write(&paths.journal, "").unwrap();
        assert!(find_interrupted(folder.path()).is_empty());
        fs::write(&paths.journal, "something").unwrap();
        assert_eq!(find_interrupted(folder.path()), [paths.target]);
    }

    /// Whoever looked before another took it has no right to it.
    #[test]
    fn two_recoveries_never_have_one_recording() {
        let folder = tempfile::tempdir().unwrap();
        let paths = Paths::of(&folder.path().join("a.mcap"));
        fs::write(&paths.partial, "").unwrap();
        fs::write(&paths.journal, "").unwrap();
        assert!(!is_in_use(&paths), "both see that nobody has it");
        let first = Locks::take(&paths).unwrap();
        assert!(Locks::take(&paths).is_none());
        drop(first);
        let journal = File::open(&paths.journal).unwrap();
        claim(&journal);
        assert!(Locks::take(&paths).is_none(), "one of its files is enough");
        drop(journal);
        assert!(Locks::take(&paths).is_some());
    }

    #[test]
    fn a_file_is_claimed_while_somebody_looks() {
        let folder = tempfile::tempdir().unwrap();
        let paths = Paths::of(&folder.path().join("a.mcap"));
        for _ in 0..100 {
            let file = File::create(&paths.journal).unwrap();
            let (looks, is_claimed) = (AtomicBool::new(false), AtomicBool::new(false));
            std::thread::scope(|scope| {
                scope.spawn(|| {
                    while !is_claimed.load(Ordering::Relaxed) {
                        let _ = is_in_use(&paths);
                        looks.store(true, Ordering::Relaxed);
                    }
                });
                while !looks.load(Ordering::Relaxed) {
                    std::thread::yield_now();
                }
                claim(&file);
                is_claimed.store(true, Ordering::Relaxed);
            });
            assert!(is_in_use(&paths), "anybody could take it");
        }
    }
}
