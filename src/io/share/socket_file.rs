//! The file of a Unix socket: private to its owner, and removed with the station.
//!
//! A socket without a listener is a leftover of a killed station and is replaced. A socket with a listener, or any
//! other file, is kept.

use std::fs::{self, File};
use std::io;
use std::os::unix::fs::{FileTypeExt, MetadataExt};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use rustix::fs::Mode;
use rustix::process::umask;

use super::ShareError;

/// Removes its file when dropped, unless the file was replaced.
#[derive(Debug)]
pub(super) struct SocketFile {
    path: PathBuf,
    /// Device and inode.
    identity: (u64, u64),
}

impl SocketFile {
    pub(super) fn bind(path: &Path) -> Result<(Self, UnixListener), ShareError> {
        let name = || path.display().to_string();
        let refused = |error| ShareError::Listen(name(), error);
        let taken = |why| ShareError::Taken(name(), why);
        // Of two stations that find a stale socket the second would remove the first one's.
        let _alone = lock_folder(path).map_err(refused)?;
        match fs::symlink_metadata(path) {
            Ok(found) if !found.file_type().is_socket() => {
                return Err(taken("a file of that name exists and is no socket"));
            }
            Ok(_) => match UnixStream::connect(path) {
                Ok(_) => return Err(taken("another program listens there already")),
                Err(error) if error.kind() == io::ErrorKind::ConnectionRefused => {
                    fs::remove_file(path).map_err(refused)?;
                }
                Err(error) => return Err(refused(error)),
            },
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            Err(error) => return Err(refused(error)),
        }
        let listener = bind_private(path).map_err(refused)?;
        listener.set_nonblocking(true).map_err(refused)?;
        let file = Self {
            path: path.to_owned(),
            identity: identity(path).map_err(refused)?,
        };
        Ok((file, listener))
    }
}

impl Drop for SocketFile {
    fn drop(&mut self) {
        let _alone = lock_folder(&self.path);
        if identity(&self.path).is_ok_and(|now| now == self.identity) {
            // A file that cannot be removed is replaced by the next station.
            let _ = fs::remove_file(&self.path);
        }
    }
}

/// Binds a socket that is never open to other users, not even for a moment.
fn bind_private(path: &Path) -> io::Result<UnixListener> {
    /// The mask belongs to the process.
    static MASK: Mutex<()> = Mutex::new(());
    let _alone = MASK.lock().unwrap_or_else(PoisonError::into_inner);
    let before = umask(Mode::RWXG | Mode::RWXO | Mode::XUSR);
    let bound = UnixListener::bind(path);
    umask(before);
    bound
}

/// Keeps other stations from opening and removing sockets in the folder of a path.
fn lock_folder(path: &Path) -> io::Result<File> {
    let folder = path.parent().filter(|folder| *folder != Path::new(""));
    let folder = File::open(folder.unwrap_or(Path::new(".")))?;
    folder.lock()?;
    Ok(folder)
}

fn identity(path: &Path) -> io::Result<(u64, u64)> {
    fs::symlink_metadata(path).map(|found| (found.dev(), found.ino()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::PermissionsExt;
    use std::sync::Barrier;
    use std::thread::{self, ScopedJoinHandle};

    #[test]
    fn it_is_private_and_goes_with_the_station() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("x.sock");
        let (file, _listener) = SocketFile::bind(&path).expect("a socket");
        let mode = fs::metadata(&path).expect("it exists").permissions().mode();
        assert_eq!(mode & 0o777, 0o600);
        drop(file);
        assert!(!path.exists());
    }

    #[test]
    fn a_stale_one_is_replaced_and_a_live_one_is_not() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("x.sock");
        drop(UnixListener::bind(&path).expect("a socket that is left behind"));
        let (first, _listener) = SocketFile::bind(&path).expect("the stale one is replaced");
        let error = SocketFile::bind(&path).expect_err("the live one is kept");
        assert!(
            error.to_string().contains("another program listens"),
            "{error}"
        );
        fs::remove_file(&path).expect("it exists");
        let (_second, _listener) = SocketFile::bind(&path).expect("a new one");
        drop(first);
        assert!(path.exists(), "only its own file is removed");
    }

    #[test]
    fn of_stations_that_race_for_a_stale_one_a_single_one_wins() {
        const STATIONS: usize = 8;
        let folder = tempfile::tempdir().expect("a folder");
        for round in 0..50 {
            let path = folder.path().join(format!("{round}.sock"));
            drop(UnixListener::bind(&path).expect("a socket that is left behind"));
            let start = Barrier::new(STATIONS);
            let bound: Vec<_> = thread::scope(|scope| {
                let begin = || {
                    start.wait();
                    SocketFile::bind(&path)
                };
                let stations: Vec<_> = (0..STATIONS).map(|_| scope.spawn(begin)).collect();
                let bound = stations.into_iter().map(ScopedJoinHandle::join);
                bound.map(|bound| bound.expect("no panic")).collect()
            });
            let (won, told): (Vec<_>, Vec<_>) = bound.into_iter().partition(Result::is_ok);
            assert_eq!(won.len(), 1, "round {round}");
            for error in told.into_iter().filter_map(Result::err) {
                assert!(
                    error.to_string().contains("another program listens"),
                    "{error}"
                );
            }
            UnixStream::connect(&path).expect("the winner listens");
        }
    }

    #[test]
    fn another_kind_of_file_is_left_alone() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("notes.txt");
        fs::write(&path, "mine").expect("a file");
        let error = SocketFile::bind(&path).expect_err("refused");
        assert!(error.to_string().contains("is no socket"), "{error}");
        assert_eq!(fs::read(&path).expect("it is there"), b"mine");
    }
}
