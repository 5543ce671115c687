//! The file of a Unix socket: private to its owner, and removed when the station ends.
//!
//! A socket without a listener is a leftover of a killed station and is replaced. A socket with a listener, or any
//! other file, is kept.

use std::ffi::OsString;
use std::fs::{self, File, Metadata, OpenOptions, TryLockError};
use std::io;
use std::os::unix::fs::{FileTypeExt, MetadataExt, OpenOptionsExt};
use std::os::unix::net::UnixListener;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use rustix::fs::{Mode, OFlags};
use rustix::process::{geteuid, umask};
use socket2::{Domain, SockAddr, Socket, Type};

use super::ShareError;
use crate::io::unix_socket;

/// Time to wait for another station that opens or removes the socket.
const LOCK_TIMEOUT: Duration = Duration::from_secs(1);

/// Time for another program's socket to take a connection.
const PROBE_TIMEOUT: Duration = Duration::from_millis(100);

/// Maximum number of connections that wait to be accepted; with the system's default, clients would wait long.
const QUEUE: i32 = 16;

const LISTENS: &str = "another program listens there already";

/// Pause between two attempts to lock.
const LOCK_PAUSE: Duration = Duration::from_millis(1);

/// A socket's file; removed when dropped, unless another file has replaced it.
#[derive(Debug)]
pub(super) struct SocketFile {
    path: PathBuf,
    /// Device and inode number of the file.
    identity: (u64, u64),
}

impl SocketFile {
    pub(super) fn bind(path: &Path) -> Result<(Self, UnixListener), ShareError> {
        let name = || path.display().to_string();
        let refused = |error| ShareError::Listen(name(), error);
        let taken = |why| ShareError::Taken(name(), why);
        // Without the lock, if two stations found a stale socket, the second would remove the first one's new socket.
        let _alone = LockFile::take(path, LOCK_TIMEOUT).map_err(refused)?;
        match fs::symlink_metadata(path) {
            Ok(found) if !found.file_type().is_socket() => {
                return Err(taken("a file of that name exists and is not a socket"));
            }
            Ok(_) => match unix_socket::connect(path, PROBE_TIMEOUT) {
                Ok(_) => return Err(taken(LISTENS)),
                // The queue of a stopped program is full.
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => {
                    return Err(taken(LISTENS));
                }
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
            identity: fs::symlink_metadata(path)
                .map(|found| identity(&found))
                .map_err(refused)?,
        };
        Ok((file, listener))
    }
}

impl Drop for SocketFile {
    fn drop(&mut self) {
        // The next station replaces a leftover file.
        if let Ok(_alone) = LockFile::take(&self.path, Duration::ZERO)
            && is_at(&self.path, self.identity)
        {
            let _ = fs::remove_file(&self.path);
        }
    }
}

/// Binds a socket that is never open to other users, not even briefly.
fn bind_private(path: &Path) -> io::Result<UnixListener> {
    /// The mask belongs to the process.
    static MASK: Mutex<()> = Mutex::new(());
    let _alone = MASK.lock().unwrap_or_else(PoisonError::into_inner);
    let before = umask(Mode::RWXG | Mode::RWXO | Mode::XUSR);
    let bound = Socket::new(Domain::UNIX, Type::STREAM, None).and_then(|socket| {
        socket.bind(&SockAddr::unix(path)?)?;
        socket.listen(QUEUE)?;
        Ok(socket.into())
    });
    umask(before);
    bound
}

/// Lock that keeps other stations from opening and removing a socket; dropping it removes its file. Other users can lock any file that they
/// can open, so the lock file is private.
struct LockFile {
    path: PathBuf,
    _locked: File,
}

impl LockFile {
    fn take(socket: &Path, timeout: Duration) -> io::Result<Self> {
        let path = lock_path(socket);
        let deadline = Instant::now() + timeout;
        loop {
            let file = OpenOptions::new()
                .write(true)
                .create(true)
                .truncate(false)
                .mode(0o600)
                .custom_flags((OFlags::NOFOLLOW | OFlags::NONBLOCK).bits() as i32)
                .open(&path)?;
            let found = file.metadata()?;
            if !found.is_file() || found.len() > 0 || found.uid() != geteuid().as_raw() {
                let name = path.display();
                return Err(io::Error::other(format!(
                    "{name} is not one of your lock files; move it away"
                )));
            }
            match file.try_lock() {
                // The station that had the lock may have removed the file.
                Ok(()) if is_at(&path, identity(&found)) => {
                    return Ok(Self {
                        path,
                        _locked: file,
                    });
                }
                Err(TryLockError::Error(error)) => return Err(error),
                _ if Instant::now() >= deadline => {
                    return Err(io::Error::other(
                        "another program is opening or closing it; try again",
                    ));
                }
                _ => thread::sleep(LOCK_PAUSE),
            }
        }
    }
}

impl Drop for LockFile {
    fn drop(&mut self) {
        // A leftover file is used again.
        let _ = fs::remove_file(&self.path);
    }
}

fn lock_path(socket: &Path) -> PathBuf {
    let mut name = OsString::from(socket);
    name.push(".lock");
    name.into()
}

/// Device and inode number of the file.
fn identity(found: &Metadata) -> (u64, u64) {
    (found.dev(), found.ino())
}

fn is_at(path: &Path, file: (u64, u64)) -> bool {
    fs::symlink_metadata(path).is_ok_and(|found| identity(&found) == file)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::PermissionsExt;
    use std::os::unix::net::UnixStream;
    use std::sync::Barrier;
    use std::thread::ScopedJoinHandle;

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
            let (won, failed): (Vec<_>, Vec<_>) = bound.into_iter().partition(Result::is_ok);
            assert_eq!(won.len(), 1, "round {round}");
            for error in failed.into_iter().filter_map(Result::err) {
                assert!(
                    error.to_string().contains("another program listens"),
                    "{error}"
                );
            }
            UnixStream::connect(&path).expect("the winner listens");
        }
    }

    #[test]
    fn a_lock_on_the_folder_holds_up_no_station() {
        let folder = tempfile::tempdir().expect("a folder");
        let strange = File::open(folder.path()).expect("any user can open it");
        strange.lock().expect("any user can lock it");
        let path = folder.path().join("x.sock");
        let (at_end, ended) = std::sync::mpsc::channel();
        thread::spawn(move || at_end.send(SocketFile::bind(&path).map(drop)));
        let ended = ended.recv_timeout(Duration::from_secs(30));
        ended.expect("it does not wait").expect("a socket");
        let left = fs::read_dir(folder.path()).expect("a folder").count();
        assert_eq!(left, 0, "socket and lock file are removed");
    }

    #[test]
    fn a_foreign_lock_file_is_refused_and_kept() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("x.sock");
        let notes = folder.path().join("notes.txt");
        fs::write(&notes, "mine").expect("a file");
        std::os::unix::fs::symlink(&notes, lock_path(&path)).expect("a link");
        SocketFile::bind(&path).expect_err("links are not followed");
        fs::remove_file(lock_path(&path)).expect("it is kept");
        fs::rename(&notes, lock_path(&path)).expect("a file with text");
        let error = SocketFile::bind(&path).expect_err("it may be of use");
        assert!(
            error.to_string().contains("is not one of your lock files"),
            "{error}"
        );
        assert_eq!(fs::read(lock_path(&path)).expect("it is kept"), b"mine");
    }

    /// Other systems immediately refuse a connection to a full queue.
    #[cfg(target_os = "linux")]
    #[test]
    fn a_stopped_station_holds_up_no_other_program() {
        use crate::io::share_client::{ShareClient, ShareClientError};
        use crate::share::Address;

        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("x.sock");
        let address = SockAddr::unix(&path).expect("an address");
        let new = || Socket::new(Domain::UNIX, Type::STREAM, None);
        let stopped = new().expect("a socket");
        stopped.bind(&address).expect("a new file");
        stopped.listen(0).expect("a listener");
        let send = || {
            let client = ShareClient::connect(&Address::Unix(path.clone()), PROBE_TIMEOUT, false);
            let error = client.err().expect("nobody answers");
            assert!(matches!(error, ShareClientError::Silent(_)), "{error}");
        };
        send();
        let waiting: Vec<_> = (0..4)
            .map(|_| {
                let client = new().expect("a socket");
                client.set_nonblocking(true).expect("not to wait");
                let connected = client.connect(&address);
                (client, connected)
            })
            .collect();
        let full = waiting.iter().filter(|(_, connected)| connected.is_err());
        assert_ne!(full.count(), 0, "the queue is full");
        send();
        let error = SocketFile::bind(&path).expect_err("it may go on");
        assert!(error.to_string().contains(LISTENS), "{error}");
    }

    #[test]
    fn another_kind_of_file_is_left_alone() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("notes.txt");
        fs::write(&path, "mine").expect("a file");
        let error = SocketFile::bind(&path).expect_err("refused");
        assert!(error.to_string().contains("is not a socket"), "{error}");
        assert_eq!(fs::read(&path).expect("it is there"), b"mine");
    }
}
