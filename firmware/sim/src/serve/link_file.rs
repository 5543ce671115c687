//! A symbolic link with a fixed name to a pseudo-terminal whose name varies.

use std::fs::{self, File, OpenOptions};
use std::io;
use std::os::unix::fs::{MetadataExt as _, symlink};
use std::path::{Path, PathBuf};

use rustix::fs::FlockOperation;
use rustix::io::Errno;

use super::error::ServeError;

/// The link, removed when dropped. A lock file beside it shows whether its owner still runs.
#[derive(Debug)]
pub(super) struct LinkFile {
    link: PathBuf,
    target: PathBuf,
    lock: PathBuf,
    _locked: File,
}

impl LinkFile {
    /// Points `link` at `target`. Replaces only a link to a terminal whose owner has ended.
    pub(super) fn make(link: &Path, target: &Path) -> Result<Self, ServeError> {
        let fail = |problem: String| ServeError::Link {
            path: link.to_owned(),
            problem,
        };
        let explain =
            |error: io::Error| fail(format!("{error}: choose a path in a writable folder"));
        let Some(name) = link.file_name() else {
            return Err(fail(
                "the path has no file name: choose one like ./robot".to_owned(),
            ));
        };
        let lock = link.with_file_name(format!(".{}.lock", name.to_string_lossy()));
        let Some(locked) = lock_file(&lock).map_err(explain)? else {
            return Err(fail(
                "another simulated robot uses it: stop that robot or choose another path"
                    .to_owned(),
            ));
        };
        // Owns the lock file from here on, so that it is removed on every return.
        let made = Self {
            link: link.to_owned(),
            target: target.to_owned(),
            lock,
            _locked: locked,
        };
        match fs::read_link(link) {
            Ok(old) if is_terminal(&old) => fs::remove_file(link).map_err(explain)?,
            Ok(old) => {
                return Err(fail(format!(
                    "it is a link to {}: remove it or choose another path",
                    old.display()
                )));
            }
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            Err(error) if error.kind() == io::ErrorKind::InvalidInput => {
                return Err(fail(
                    "the file already exists: remove it or choose another path".to_owned(),
                ));
            }
            Err(error) => return Err(explain(error)),
        }
        symlink(target, link).map_err(explain)?;
        Ok(made)
    }
}

impl Drop for LinkFile {
    fn drop(&mut self) {
        if fs::read_link(&self.link).is_ok_and(|target| target == self.target) {
            let _ = fs::remove_file(&self.link);
        }
        let _ = fs::remove_file(&self.lock);
    }
}

fn is_terminal(target: &Path) -> bool {
    target.starts_with("/dev/pts")
        || target.parent() == Some(Path::new("/dev"))
            && target
                .file_name()
                .is_some_and(|name| name.to_string_lossy().starts_with("tty"))
}

/// Creates and locks a file; `None` while another process holds it.
fn lock_file(path: &Path) -> io::Result<Option<File>> {
    loop {
        let file = OpenOptions::new().create(true).append(true).open(path)?;
        match rustix::fs::flock(&file, FlockOperation::NonBlockingLockExclusive) {
            Ok(()) => {}
            Err(Errno::AGAIN) => return Ok(None),
            Err(errno) => return Err(errno.into()),
        }
        // The previous owner may have removed the file between opening and locking.
        match fs::metadata(path) {
            Ok(current) if current.ino() == file.metadata()?.ino() => return Ok(Some(file)),
            Ok(_) => {}
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            Err(error) => return Err(error),
        }
    }
}
