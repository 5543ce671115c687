//! Writes raw text: the radio's bytes alone.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use super::error::{create, create_error};
use super::{CaptureError, Existing, presence};

/// Maximum bytes that wait for the file.
const WAITING_MAX: u64 = 1 << 24;

/// Maximum bytes of one write.
const PIECE: usize = 1 << 16;

/// How long a writer or the end of a session waits for a file that accepts nothing.
const PATIENCE: Duration = Duration::from_secs(5);

/// How long a file may accept nothing before it is reported.
const STALL_PERIOD: Duration = Duration::from_secs(30);

/// Appends each read of the radio to a file, unbuffered and on a thread of its own, so that a stalled disk or pipe stalls
/// nothing else. Dropping it finishes the file.
#[derive(Debug)]
pub struct RawWriter {
    path: PathBuf,
    shared: Arc<Shared>,
}

impl RawWriter {
    /// Creates the file.
    ///
    /// # Errors
    /// When it exists and may not be overwritten, or cannot be created.
    pub fn create(path: impl Into<PathBuf>, existing: Existing) -> Result<Self, CaptureError> {
        let path = path.into();
        let shared = Arc::<Shared>::default();
        let worker = Worker {
            file: create(&path, existing, true)?,
            path: path.clone(),
            shared: Arc::clone(&shared),
        };
        thread::Builder::new()
            .name("raw text".into())
            .spawn(move || worker.run())
            .map_err(|error| {
                if existing == Existing::Refuse {
                    // The file is empty.
                    let _ = fs::remove_file(&path);
                }
                create_error(&path, error, false)
            })?;
        Ok(Self { path, shared })
    }

    /// Queues the bytes of one read; call it before parsing them. Waits only while 16 MiB are queued, and gives the file up
    /// when it accepts none of them for 5 s. After that and after an error nothing more is written, so that the file stays an
    /// exact beginning of the stream; [`Self::problem`] and [`Self::finish`] return the error.
    pub fn write(&self, bytes: &[u8]) {
        let (mut queue, waited) = self.wait(PATIENCE, |queue| {
            queue.is_open() && queue.phase == Phase::Writing && queue.unwritten() > WAITING_MAX
        });
        if queue.phase != Phase::Writing {
            return;
        }
        queue.is_given_up |= waited;
        if queue.is_open() {
            queue.waiting.extend_from_slice(bytes);
        }
        queue.taken += bytes.len() as u64;
        self.shared.changed.notify_all();
    }

    /// Requests a check that the file still has its name; [`Self::problem`] returns the result. Writing goes on, because a
    /// renamed file keeps the bytes.
    pub fn look(&self) {
        self.shared.lock().is_look_due = true;
        self.shared.changed.notify_all();
    }

    /// Writes what is queued and syncs the file; returns the number of bytes written. Waits 5 s at most.
    ///
    /// # Errors
    /// The first error since the start, a removed file, a failed sync, or a file that accepts no bytes. Pipes and devices are
    /// not synced.
    pub fn finish(&self) -> Result<u64, CaptureError> {
        self.finish_within(PATIENCE)
    }

    fn finish_within(&self, patience: Duration) -> Result<u64, CaptureError> {
        let mut queue = self.shared.lock();
        if queue.phase == Phase::Writing {
            queue.phase = Phase::Finishing;
        }
        drop(queue);
        self.shared.changed.notify_all();
        let (mut queue, waited) = self.wait(patience, |queue| queue.phase != Phase::Ended);
        if let Some(problem) = queue.problem.take() {
            return Err(problem);
        }
        match queue.unwritten() {
            0 if waited => Err(self.timed_out("the disk does not confirm the last bytes")),
            0 => Ok(queue.written),
            bytes => Err(self.timed_out(&format!(
                "the file accepts no bytes, and {bytes} bytes are not in it"
            ))),
        }
    }

    /// Waits while `waits` holds; returns whether it still did in the end.
    fn wait(
        &self,
        patience: Duration,
        waits: impl Fn(&Queue) -> bool,
    ) -> (MutexGuard<'_, Queue>, bool) {
        let queue = self.shared.lock();
        let waited =
            (self.shared.changed).wait_timeout_while(queue, patience, |queue| waits(queue));
        let (queue, waited) = waited.unwrap_or_else(PoisonError::into_inner);
        (queue, waited.timed_out())
    }

    fn timed_out(&self, text: &str) -> CaptureError {
        CaptureError::Write {
            path: self.path.clone(),
            error: io::Error::new(io::ErrorKind::TimedOut, text),
        }
    }

    /// Path of the file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Bytes written.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.shared.lock().written
    }

    /// Reason why writing ended, the file is lost, or calls over 30 s found bytes waiting and none written.
    #[must_use]
    pub fn problem(&self, now: Instant) -> Option<String> {
        let mut queue = self.shared.lock();
        let written = queue.written;
        let since = match queue.seen {
            Some((seen, at)) if seen == written && queue.unwritten() > 0 => at,
            _ => now,
        };
        queue.seen = Some((written, since));
        let is_stalled = now.saturating_duration_since(since) >= STALL_PERIOD;
        if let Some(problem) = &queue.problem {
            Some(problem.to_string())
        } else if queue.is_given_up {
            Some(self.timed_out("the file accepts no bytes").to_string())
        } else {
            is_stalled.then(|| CaptureError::Stalled(self.path.clone()).to_string())
        }
    }
}

impl Drop for RawWriter {
    fn drop(&mut self) {
        if self.shared.lock().phase == Phase::Writing {
            // `problem` has reported the error.
            let _ = self.finish();
        }
    }
}

/// The queue and the condition that it changed.
#[derive(Debug, Default)]
struct Shared {
    queue: Mutex<Queue>,
    changed: Condvar,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Queue> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Phase {
    #[default]
    Writing,
    /// No more bytes are queued.
    Finishing,
    /// The thread has finished the file.
    Ended,
}

/// Bytes for the file, and its state.
#[derive(Debug, Default)]
struct Queue {
    waiting: Vec<u8>,
    /// Bytes of all reads, also of those that came after the end of writing.
    taken: u64,
    written: u64,
    /// Bytes written when [`RawWriter::problem`] was last called, and since when they are no more.
    seen: Option<(u64, Instant)>,
    is_look_due: bool,
    phase: Phase,
    /// The file accepted no bytes for too long.
    is_given_up: bool,
    /// Writing failed, or the file was removed or renamed.
    problem: Option<CaptureError>,
}

impl Queue {
    /// Whether bytes still go to the file.
    const fn is_open(&self) -> bool {
        let has_failed = matches!(self.problem, Some(CaptureError::Write { .. }));
        !has_failed && !self.is_given_up
    }

    const fn unwritten(&self) -> u64 {
        self.taken - self.written
    }
}

/// The thread of a writer.
struct Worker {
    file: File,
    path: PathBuf,
    shared: Arc<Shared>,
}

impl Worker {
    /// Writes until the file is to be finished, then finishes it. Holds the lock only between calls of the system.
    fn run(mut self) {
        loop {
            let waited = self.shared.changed.wait_while(self.shared.lock(), |queue| {
                queue.waiting.is_empty() && !queue.is_look_due && queue.phase == Phase::Writing
            });
            let mut queue = waited.unwrap_or_else(PoisonError::into_inner);
            let bytes = std::mem::take(&mut queue.waiting);
            let is_finishing = queue.phase != Phase::Writing;
            let looks = std::mem::take(&mut queue.is_look_due) || is_finishing;
            drop(queue);
            let mut result = self.write(&bytes).map_err(|error| self.failed(error));
            if result.is_ok() && looks {
                result = presence::check(&self.file, &self.path);
            }
            if result.is_ok() && is_finishing {
                result = self.sync().map_err(|error| self.failed(error));
            }
            let mut queue = self.shared.lock();
            if let Err(error) = result {
                let has_failed = matches!(queue.problem, Some(CaptureError::Write { .. }));
                if !has_failed {
                    queue.problem = Some(error);
                }
            }
            if is_finishing {
                queue.phase = Phase::Ended;
                self.shared.changed.notify_all();
                return;
            }
            self.shared.changed.notify_all();
        }
    }

    fn write(&mut self, mut bytes: &[u8]) -> io::Result<()> {
        while !bytes.is_empty() {
            match self.file.write(&bytes[..bytes.len().min(PIECE)]) {
                Ok(0) => return Err(io::ErrorKind::WriteZero.into()),
                Ok(written) => {
                    bytes = &bytes[written..];
                    let mut queue = self.shared.lock();
                    queue.written += written as u64;
                    self.shared.changed.notify_all();
                }
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }

    fn sync(&self) -> io::Result<()> {
        let Err(error) = self.file.sync_data() else {
            return Ok(());
        };
        let has_no_disk = matches!(
            error.kind(),
            io::ErrorKind::InvalidInput
                | io::ErrorKind::Unsupported
                | io::ErrorKind::ReadOnlyFilesystem
        );
        let is_file = self.file.metadata().is_ok_and(|about| about.is_file());
        if has_no_disk && !is_file {
            return Ok(());
        }
        Err(error)
    }

    fn failed(&self, error: io::Error) -> CaptureError {
        CaptureError::Write {
            path: self.path.clone(),
            error,
        }
    }
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;
    use std::io::Read;
    use std::os::fd::AsRawFd;

    /// A stalled pipe blocks no call, is reported, and its bytes are counted.
    #[test]
    fn a_pipe_that_nobody_reads_stalls_nothing() {
        let (mut reader, pipe) = io::pipe().unwrap();
        let path = format!("/proc/self/fd/{}", pipe.as_raw_fd());
        let raw = RawWriter::create(path, Existing::Append).unwrap();
        drop(pipe);
        let sent: Vec<u8> = (0..1_000_000u32).map(|i| i.to_le_bytes()[0]).collect();
        raw.write(&sent);
        let now = Instant::now();
        assert_eq!(raw.problem(now), None);
        // The pipe takes some bytes first.
        let problem = (1..)
            .find_map(|n| raw.problem(now + STALL_PERIOD * n))
            .unwrap();
        assert!(problem.contains("nothing for 30 s"), "{problem}");
        let error = raw.finish_within(Duration::ZERO).unwrap_err().to_string();
        assert!(error.contains("bytes are not in it"), "{error}");
        drop(raw);
        // The bytes still come when the pipe is read after all.
        let mut read = Vec::new();
        reader.read_to_end(&mut read).unwrap();
        assert!(read == sent, "{} bytes", read.len());
    }

    /// A file is given up with a full queue; the bytes after that are counted and not written.
    #[test]
    fn a_full_queue_ends_the_file_at_an_exact_place() {
        let (mut reader, pipe) = io::pipe().unwrap();
        let path = format!("/proc/self/fd/{}", pipe.as_raw_fd());
        let raw = RawWriter::create(path, Existing::Append).unwrap();
        drop(pipe);
        raw.write(b"first");
        raw.shared.lock().is_given_up = true;
        raw.write(b"second");
        let problem = raw.problem(Instant::now()).unwrap();
        assert!(problem.contains("accepts no bytes"), "{problem}");
        let error = raw.finish().unwrap_err().to_string();
        assert!(error.contains("6 bytes are not in it"), "{error}");
        drop(raw);
        let mut read = String::new();
        reader.read_to_string(&mut read).unwrap();
        assert_eq!(read, "first");
    }
}
