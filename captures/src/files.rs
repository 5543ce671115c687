//! Files of recordings: names, locks and free names.

use std::ffi::OsString;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
#[cfg(unix)]
use std::time::Duration;

use super::error::{CaptureError, Existing};
use super::presence;
use super::rotation::part_name;
use super::runs::label;

/// Limits the numbered variants of a file name.
const VARIANTS_MAX: u32 = 1_000_000;

/// Extension of the finished copy, which replaces the recording when it is complete.
pub(crate) const FINISHING: &str = "finishing";
/// Extension of a damaged file that is kept beside its replacement.
pub(crate) const DAMAGED: &str = "damaged";

/// Extension of a recording while Windows replaces it.
pub(crate) const REPLACED: &str = "replaced";

/// A file that this program has locked.
pub(crate) struct Lock(File);

impl Lock {
    /// Locks a file; `None` when another program records or recovers it, or has just replaced it.
    ///
    /// # Errors
    /// If the file cannot be opened.
    pub(crate) fn take(path: &Path) -> io::Result<Option<Self>> {
        let file = open(path)?;
        if let Err(TryLockError::WouldBlock) = file.try_lock() {
            return Ok(None);
        }
        // On a file system without locks, the file counts as free.
        Ok(presence::check(&file, path).is_ok().then_some(Self(file)))
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        release(&self.0);
    }
}

/// Unlocks a file. Closing it is not enough: a program that another thread is starting has a copy of it for a moment,
/// and the lock with it.
pub(crate) fn release(file: &File) {
    // A lock that cannot be released ends with the last copy of the file.
    let _ = file.unlock();
}

/// Locks a file that is being written. Waits briefly for another program that checks the lock.
pub(crate) fn claim(file: &File) {
    // On a file system without locks, recording continues unprotected.
    let _ = file.lock();
}

/// Opens a file for reading. Refuses a named pipe, because opening one waits for a program that writes into it.
///
/// # Errors
/// The operating system's error.
pub fn open(path: &Path) -> io::Result<File> {
    // The pipes that a shell passes, as `<(...)`, are open already.
    let is_open = path.starts_with("/dev") || path.starts_with("/proc");
    if !is_open && is_named_pipe(path) {
        return Err(io::Error::other(
            "it is a named pipe; read it as standard input: - < PIPE",
        ));
    }
    File::open(path)
}

/// Whether the path is a named pipe.
#[cfg(unix)]
#[must_use]
pub fn is_named_pipe(path: &Path) -> bool {
    use std::os::unix::fs::FileTypeExt as _;
    fs::metadata(path).is_ok_and(|about| about.file_type().is_fifo())
}

/// Whether the path is a named pipe.
#[cfg(not(unix))]
#[must_use]
pub const fn is_named_pipe(_: &Path) -> bool {
    false
}

/// Whether the path is a device that sends bytes one by one, such as a serial port or a terminal.
#[cfg(unix)]
pub(crate) fn is_device(path: &Path) -> bool {
    use std::os::unix::fs::FileTypeExt as _;
    fs::metadata(path).is_ok_and(|about| about.file_type().is_char_device())
}

/// Whether the path is a device that sends bytes one by one, such as a serial port or a terminal.
#[cfg(not(unix))]
pub(crate) const fn is_device(_: &Path) -> bool {
    false
}

/// Opens a file for writing. Refuses a named pipe that no program begins to read within a second, because opening one waits
/// for the reader.
///
/// # Errors
/// The operating system's error.
pub fn open_to_write(options: &mut OpenOptions, path: &Path) -> io::Result<File> {
    #[cfg(unix)]
    if is_named_pipe(path) {
        use rustix::fs::{OFlags, fcntl_getfl, fcntl_setfl};
        use rustix::io::Errno;
        use std::os::unix::fs::OpenOptionsExt as _;

        /// Maximum time for the reader to open the pipe, and the period of the checks.
        const PATIENCE: Duration = Duration::from_secs(1);
        const PERIOD: Duration = Duration::from_millis(50);

        options.custom_flags(OFlags::NONBLOCK.bits().cast_signed());
        let mut patience = PATIENCE;
        let file = loop {
            match options.open(path) {
                Err(error) if error.raw_os_error() == Some(Errno::NXIO.raw_os_error()) => {
                    patience = patience.checked_sub(PERIOD).ok_or_else(|| {
                        io::Error::other("no program reads this named pipe; start its reader first")
                    })?;
                    std::thread::sleep(PERIOD);
                }
                opened => break opened?,
            }
        };
        fcntl_setfl(&file, fcntl_getfl(&file)? - OFlags::NONBLOCK)?;
        return Ok(file);
    }
    options.open(path)
}

/// Opens a file for writing; `existing` decides what happens to an existing one.
pub(crate) fn create(
    path: &Path,
    existing: Existing,
    can_append: bool,
) -> Result<File, CaptureError> {
    let mut options = OpenOptions::new();
    match existing {
        Existing::Refuse => options.write(true).create_new(true),
        Existing::Append => options.append(true).create(true),
        Existing::Overwrite => options.write(true).create(true).truncate(true),
    };
    open_to_write(&mut options, path).map_err(|error| create_error(path, error, can_append))
}

/// The error for a file that could not be created.
pub(crate) fn create_error(path: &Path, error: io::Error, can_append: bool) -> CaptureError {
    let path = path.to_owned();
    if path.is_dir() {
        let error = io::ErrorKind::IsADirectory.into();
        CaptureError::Create { path, error }
    } else if error.kind() == io::ErrorKind::AlreadyExists {
        CaptureError::Exists { path, can_append }
    } else {
        CaptureError::Create { path, error }
    }
}

/// Whether both paths lead to one regular file, directly or by links. `-` is standard input.
#[must_use]
pub fn is_same(one: &Path, other: &Path) -> bool {
    let about = |path: &Path| {
        let path = if path == Path::new("-") {
            Path::new("/dev/stdin")
        } else {
            path
        };
        fs::metadata(path).ok().filter(fs::Metadata::is_file)
    };
    let (Some(about_one), Some(about_other)) = (about(one), about(other)) else {
        return false;
    };
    // Without inode numbers, links are not recognized.
    presence::is_same(&about_one, &about_other)
        && (cfg!(unix) || fs::canonicalize(one).ok() == fs::canonicalize(other).ok())
}

/// Maximum number of links followed for one path.
const LINKS_MAX: usize = 40;

/// The absolute path of a file that need not exist, without links.
#[must_use]
pub fn full_path(path: &Path) -> PathBuf {
    let mut path = path.to_owned();
    for _ in 0..LINKS_MAX {
        let folder = folder_of(&path);
        let folder = fs::canonicalize(folder).unwrap_or_else(|_| folder.to_owned());
        let full = folder.join(path.file_name().unwrap_or_default());
        match fs::read_link(&full) {
            Ok(target) => path = folder.join(target),
            Err(_) => return full,
        }
    }
    path
}

/// The folder of a file.
fn folder_of(path: &Path) -> &Path {
    let folder = path.parent();
    let folder = folder.filter(|folder| !folder.as_os_str().is_empty());
    folder.unwrap_or(Path::new("."))
}

/// Whether a program records or recovers this file now.
#[must_use]
pub fn is_in_use(path: &Path) -> bool {
    matches!(Lock::take(path), Ok(None))
}

/// Whether the name is reserved for recovery.
#[must_use]
pub fn is_own_name(path: &Path) -> bool {
    path.extension().is_some_and(|extension| {
        [FINISHING, DAMAGED, REPLACED]
            .iter()
            .any(|own| extension == *own)
    })
}

/// Refuses a name that is reserved for recovery or for a label.
///
/// # Errors
/// If the name is reserved.
pub fn refuse_own_name(path: &Path) -> Result<(), CaptureError> {
    if is_own_name(path) || label::is_label(path) {
        return Err(CaptureError::OwnName(path.to_owned()));
    }
    Ok(())
}

/// The first unused part number, starting at `from`, and its file name.
#[must_use]
pub fn free_part(path: &Path, from: u32) -> Option<(u32, PathBuf)> {
    (from..=VARIANTS_MAX)
        .map(|part| (part, part_name(path, part)))
        .find(|(_, name)| !name.exists())
}

/// Appends an extension: `run.mcap` becomes `run.mcap.damaged`.
pub(crate) fn with_suffix(path: &Path, suffix: &str) -> PathBuf {
    let mut name = OsString::from(path);
    name.push(".");
    name.push(suffix);
    name.into()
}

/// Waits until the content is on the disk. Returns at once for pipes and devices.
///
/// # Errors
/// The operating system's error.
pub(crate) fn sync(file: &File) -> io::Result<()> {
    let Err(error) = file.sync_data() else {
        return Ok(());
    };
    let has_no_disk = matches!(
        error.kind(),
        io::ErrorKind::InvalidInput
            | io::ErrorKind::Unsupported
            | io::ErrorKind::ReadOnlyFilesystem
    );
    let is_file = file.metadata().is_ok_and(|about| about.is_file());
    if has_no_disk && !is_file {
        return Ok(());
    }
    Err(error)
}

/// Waits until a rename in the folder of this file is on the disk.
pub(crate) fn sync_folder(path: &Path) {
    // Not every system supports syncing a folder.
    if let Ok(folder) = File::open(folder_of(path)) {
        let _ = folder.sync_all();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicBool, Ordering};

    #[test]
    fn only_one_program_locks_a_recording() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.mcap");
        fs::write(&path, "").unwrap();
        let first = Lock::take(&path).unwrap().unwrap();
        assert!(Lock::take(&path).unwrap().is_none());
        assert!(is_in_use(&path));
        // Simulates the copy that a starting program holds.
        let copy = first.0.try_clone().unwrap();
        drop(first);
        assert!(!is_in_use(&path));
        drop(copy);
    }

    /// Opening a named pipe blocks until a reader opens it.
    #[cfg(target_os = "linux")]
    #[test]
    fn a_named_pipe_is_written_only_to_a_reader() {
        use rustix::fs::{CWD, FileType, Mode, OFlags, mknodat, open};
        use std::io::{Read as _, Write as _};
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("pipe");
        mknodat(CWD, &path, FileType::Fifo, Mode::from(0o600), 0).unwrap();
        let mut options = OpenOptions::new();
        let write = options.write(true).create(true).truncate(true);
        let error = open_to_write(write, &path).unwrap_err().to_string();
        assert!(error.contains("start its reader first"), "{error}");
        let flags = OFlags::RDONLY | OFlags::NONBLOCK;
        let mut reader = File::from(open(&path, flags, Mode::empty()).unwrap());
        let mut writer = open_to_write(write, &path).unwrap();
        writer.write_all(b"line").unwrap();
        drop(writer);
        let mut read = String::new();
        reader.read_to_string(&mut read).unwrap();
        assert_eq!(read, "line");
    }

    #[cfg(unix)]
    #[test]
    fn links_to_one_file_that_is_not_there_have_one_path() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        for (target, link) in [("none", "a"), ("a", "b"), ("loop", "loop")] {
            std::os::unix::fs::symlink(target, at(link)).unwrap();
        }
        assert_eq!(full_path(&at("b")), full_path(&at("none")));
        assert_eq!(full_path(&at("a")), full_path(&at("none")));
        assert_ne!(full_path(&at("loop")), full_path(&at("none")));
    }

    #[test]
    fn claim_waits_for_a_program_that_checks() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.mcap");
        for _ in 0..100 {
            let file = File::create(&path).unwrap();
            let (checks, is_claimed) = (AtomicBool::new(false), AtomicBool::new(false));
            std::thread::scope(|scope| {
                scope.spawn(|| {
                    while !is_claimed.load(Ordering::Relaxed) {
                        let _ = is_in_use(&path);
                        checks.store(true, Ordering::Relaxed);
                    }
                });
                while !checks.load(Ordering::Relaxed) {
                    std::thread::yield_now();
                }
                claim(&file);
                is_claimed.store(true, Ordering::Relaxed);
            });
            assert!(is_in_use(&path), "another program could take it");
        }
    }
}
