//! Writes raw text: the radio's bytes alone.

use std::fs::{self, File};
use std::io::{self, Read as _, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use ::mcap::MAGIC;

use super::event::Moment;
use super::files::{create, create_error};
use super::write_queue::{FileWorker, PATIENCE, WriteQueue};
use super::{CaptureError, Existing, files, presence};

/// Appends the bytes of each read to a file, unbuffered and on its own thread. A stalled disk or pipe stalls
/// nothing else. Dropping it finishes the file.
#[derive(Debug)]
pub struct RawWriter {
    path: PathBuf,
    queue: WriteQueue<Vec<u8>>,
}

impl RawWriter {
    /// Creates the file.
    ///
    /// # Errors
    /// If the file exists and may not be overwritten, or cannot be created.
    pub fn create(path: impl Into<PathBuf>, existing: Existing) -> Result<Self, CaptureError> {
        let path = path.into();
        if existing == Existing::Append && is_mcap(&path) {
            return Err(CaptureError::CannotAppend(path));
        }
        let worker = Worker {
            file: create(&path, existing, true)?,
            path: path.clone(),
            is_empty: true,
        };
        let queue = WriteQueue::start(path.clone(), worker, Arc::default()).map_err(|error| {
            if existing == Existing::Refuse {
                // The file is empty.
                let _ = fs::remove_file(&path);
            }
            create_error(&path, error, false)
        })?;
        Ok(Self { path, queue })
    }

    /// Queues the bytes of one read; call it before parsing them. Waits 100 ms for a file that falls behind, and while 16 MiB
    /// are queued; gives up the file when it accepts no byte for 5 s. After that and after an error nothing more is
    /// written, to keep the file an exact prefix of the stream; [`Self::problem`] and [`Self::finish`] return the
    /// error.
    pub fn write(&self, bytes: &[u8]) {
        self.queue.push(bytes.to_vec(), bytes.len() as u64, None);
        self.queue.pace().wait();
    }

    /// Checks every eight seconds that the file still has its name and accepts bytes; [`Self::problem`] returns the result.
    /// Call this about once a second. Writing continues, because a renamed file keeps the bytes.
    pub fn handle_timeout(&self, now: Moment) {
        self.queue.handle_timeout(now);
    }

    /// Writes the queued bytes and syncs the file; returns the number of bytes written. Waits a few seconds at most for a file
    /// that makes no progress.
    ///
    /// # Errors
    /// The first error since the start, a removed file, a failed sync, or a file that accepts no bytes. Pipes and devices are
    /// not synced.
    pub fn finish(&self) -> Result<u64, CaptureError> {
        self.queue.finish_within(PATIENCE)
    }

    /// Path of the file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Number of bytes written.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.queue.written()
    }

    /// Reason why writing ended or the file is lost; also set when calls of [`Self::handle_timeout`] over 30 s found bytes waiting but none
    /// written.
    #[must_use]
    pub fn problem(&self) -> Option<String> {
        self.queue.problem()
    }

    /// Whether [`Self::problem`] is that the file accepts no bytes.
    #[must_use]
    pub fn is_stalled(&self) -> bool {
        self.queue.is_stalled()
    }
}

/// Whether the path is a file that begins like a recording.
fn is_mcap(path: &Path) -> bool {
    let mut head = [0; MAGIC.len()];
    path.is_file()
        && File::open(path)
            .is_ok_and(|mut file| file.read_exact(&mut head).is_ok() && head == MAGIC)
}

impl Drop for RawWriter {
    fn drop(&mut self) {
        if !self.queue.is_ending() {
            // `problem` has reported the error.
            let _ = self.finish();
        }
    }
}

/// Writes the file, on its own thread.
#[derive(Debug)]
struct Worker {
    file: File,
    path: PathBuf,
    /// Whether nothing was written yet.
    is_empty: bool,
}

impl FileWorker for Worker {
    type Item = Vec<u8>;

    fn write(&mut self, bytes: Vec<u8>) -> Result<(), CaptureError> {
        let mut rest = &bytes[..];
        while !rest.is_empty() {
            match self.file.write(rest) {
                Ok(0) => return Err(self.failed(io::ErrorKind::WriteZero.into())),
                Ok(written) => {
                    self.is_empty = false;
                    rest = &rest[written..];
                }
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(self.failed(error)),
            }
        }
        Ok(())
    }

    fn look(&mut self) -> Result<(), CaptureError> {
        presence::check(&self.file, &self.path)
    }

    fn finish(mut self) -> Result<(), CaptureError> {
        self.look()?;
        files::sync(&self.file).map_err(|error| self.failed(error))
    }

    fn leave(self) {}
}

impl Worker {
    fn failed(&self, error: io::Error) -> CaptureError {
        let path = self.path.clone();
        // The file may be appended to.
        let is_empty = self.is_empty && self.file.metadata().is_ok_and(|about| about.len() == 0);
        if is_empty {
            CaptureError::NothingWritten { path, error }
        } else {
            CaptureError::Write { path, error }
        }
    }
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::super::write_queue::STALL_PERIOD;
    use super::*;
    use std::io::Read;
    use std::os::fd::AsRawFd;
    use std::time::Duration;

    /// A stalled pipe blocks no call, is reported, and its bytes are counted.
    #[test]
    fn a_pipe_without_a_reader_stalls_nothing() {
        let (mut reader, pipe) = io::pipe().unwrap();
        let path = format!("/proc/self/fd/{}", pipe.as_raw_fd());
        let raw = RawWriter::create(path, Existing::Append).unwrap();
        drop(pipe);
        let sent: Vec<u8> = (0..1_000_000u32).map(|i| i.to_le_bytes()[0]).collect();
        for read in sent.chunks(4096) {
            raw.write(read);
        }
        raw.handle_timeout(Duration::ZERO);
        assert_eq!(raw.problem(), None);
        // The pipe takes some bytes first.
        let problem = (1..)
            .find_map(|n| {
                raw.handle_timeout(STALL_PERIOD * n);
                raw.problem()
            })
            .unwrap();
        assert!(problem.contains("nothing for 30 s"), "{problem}");
        let ended = raw.queue.finish_within(Duration::ZERO);
        let error = ended.unwrap_err().to_string();
        assert!(error.contains("bytes are not in it"), "{error}");
        drop(raw);
        // The bytes still come when the pipe is read after all.
        let mut read = Vec::new();
        reader.read_to_end(&mut read).unwrap();
        assert!(read == sent, "{} bytes", read.len());
    }
}
