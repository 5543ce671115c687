//! The files of a recording, and the thread that syncs and finishes them.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::Receiver;

use super::Shared;
use crate::files::create_error;
use crate::recover::{self, Outcome};
use crate::session::Session;
use crate::unfinished::UnfinishedWriter;
use crate::{CaptureError, Existing, files, presence};

/// A job for the thread.
pub(super) enum Job {
    /// Sync, and check that the file still has its name.
    Sync,
    /// Finish the current part and continue with this one.
    Next(Part),
    /// End; leave the current part unfinished.
    Leave,
}

/// A file of the recording, locked until the part is dropped.
pub(super) struct Part {
    path: PathBuf,
    file: File,
    /// Number of bytes written.
    bytes: Arc<AtomicU64>,
}

impl Part {
    /// Begins a part and waits until its beginning is on the disk.
    pub(super) fn begin(
        file: File,
        path: &Path,
        session: &Session,
    ) -> Result<(Self, UnfinishedWriter), CaptureError> {
        let begun = file.try_clone().and_then(|clone| {
            let writer = UnfinishedWriter::begin(clone, path, session)?;
            files::sync(&file).map(|()| writer)
        });
        let writer = begun.map_err(|error| {
            // The file is empty.
            let _ = fs::remove_file(path);
            create_error(path, error, false)
        })?;
        files::sync_folder(path);
        let part = Self {
            path: path.to_owned(),
            file,
            bytes: writer.counter(),
        };
        Ok((part, writer))
    }
}

impl Drop for Part {
    fn drop(&mut self) {
        files::release(&self.file);
    }
}

/// Creates a file and locks it.
pub(super) fn create(path: &Path, existing: Existing) -> Result<File, CaptureError> {
    let mut options = OpenOptions::new();
    match existing {
        Existing::Append => return Err(CaptureError::CannotAppend(path.to_owned())),
        Existing::Refuse => options.write(true).create_new(true),
        // Truncated only after the check that no other program records to the file.
        Existing::Overwrite => options.write(true).create(true).truncate(false),
    };
    if files::is_in_use(path) {
        return Err(CaptureError::InUse(path.to_owned()));
    }
    let file = files::open_to_write(&mut options, path)
        .map_err(|error| create_error(path, error, false))?;
    if existing == Existing::Overwrite {
        let is_file = file.metadata().is_ok_and(|about| about.is_file());
        let emptied = match file.try_lock() {
            Err(TryLockError::WouldBlock) => return Err(CaptureError::InUse(path.to_owned())),
            _ if is_file => file.set_len(0),
            _ => Err(io::Error::other("a recording needs a file")),
        };
        emptied.map_err(|error| create_error(path, error, false))?;
    } else {
        files::claim(&file);
    }
    Ok(file)
}

/// The thread that syncs and finishes.
pub(super) struct Syncer {
    pub(super) part: Part,
    pub(super) shared: Arc<Shared>,
}

impl Syncer {
    /// Does the jobs until there are no more, then finishes the recording.
    pub(super) fn run(mut self, queue: &Receiver<Job>) -> Result<(), CaptureError> {
        let result = self.carry_out_all(queue);
        if let Err(error) = &result {
            self.shared.set_problem(error);
            self.shared.is_lost.store(true, Ordering::Release);
        }
        result
    }

    fn carry_out_all(&mut self, queue: &Receiver<Job>) -> Result<(), CaptureError> {
        let mut finished = Ok(());
        for job in queue {
            match job {
                Job::Sync => {
                    self.shared.is_sync_due.store(false, Ordering::Release);
                    let Part { path, file, bytes } = &self.part;
                    let bytes = bytes.load(Ordering::Acquire);
                    presence::check(file, path)?;
                    files::sync(file).map_err(|error| CaptureError::Write {
                        path: path.clone(),
                        error,
                    })?;
                    self.shared.synced_bytes.store(bytes, Ordering::Release);
                    self.shared.progress.fetch_add(1, Ordering::Relaxed);
                }
                Job::Next(part) => {
                    // A part that cannot be finished stays unfinished, without loss.
                    let result = self.finish();
                    if let Err(error) = &result {
                        self.shared.set_problem(error);
                    }
                    finished = finished.and(result);
                    self.part = part;
                }
                Job::Leave => return finished,
            }
        }
        finished.and(self.finish())
    }

    fn finish(&self) -> Result<(), CaptureError> {
        let Part { path, file, .. } = &self.part;
        presence::check(file, path)?;
        let recovery = recover::finish(path, &self.shared.progress)?;
        let bytes = fs::metadata(path).map_or(0, |about| about.len());
        self.shared
            .finished_bytes
            .fetch_add(bytes, Ordering::AcqRel);
        if recovery.outcome == Outcome::Partly {
            return Err(CaptureError::Damaged {
                path: path.clone(),
                problem: recovery.headline(),
            });
        }
        Ok(())
    }
}
