//! The work of a recording's file writer, which a second thread syncs and finishes.

use std::io;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Sender, channel};
use std::thread::{self, JoinHandle};
use std::time::{Duration, UNIX_EPOCH};

use super::part::{self, Job, Part, Syncer};
use super::{Place, Shared};
use crate::event::Moment;
use crate::observations::Observation;
use crate::rotation::Rotation;
use crate::session::Session;
use crate::unfinished::UnfinishedWriter;
use crate::write_queue::FileWorker;
use crate::{CaptureError, Existing, files};

/// An observation to be recorded.
pub(super) struct Entry {
    /// Time of the observation; `None` if it was made before the recording began.
    pub(super) now: Option<Moment>,
    /// Time since 1970, nanoseconds.
    pub(super) at_ns: u64,
    pub(super) observation: Observation,
}

/// Writes the parts of a recording.
pub(super) struct PartWriter {
    session: Session,
    /// The name of the first part; the names of later parts are derived from it.
    first: PathBuf,
    rotation: Rotation,
    existing: Existing,
    part: u32,
    part_since: Option<Moment>,
    file: UnfinishedWriter,
    /// Number of bytes of the current part before its first message.
    begun_bytes: u64,
    /// Whether the current part has an observation.
    has_begun: bool,
    jobs: Sender<Job>,
    syncer: JoinHandle<Result<(), CaptureError>>,
    shared: Arc<Shared>,
}

impl PartWriter {
    /// Starts the thread that syncs.
    ///
    /// # Errors
    /// If no thread can be started.
    pub(super) fn new(
        part: Part,
        file: UnfinishedWriter,
        shared: Arc<Shared>,
        session: &Session,
        rotation: Rotation,
        existing: Existing,
    ) -> io::Result<Self> {
        let (jobs, queue) = channel();
        let syncer = Syncer {
            part,
            shared: Arc::clone(&shared),
        };
        let syncer = thread::Builder::new()
            .name("recording sync".into())
            .spawn(move || syncer.run(&queue))?;
        shared.part_bytes.store(file.bytes(), Ordering::Release);
        Ok(Self {
            session: session.clone(),
            first: file.path().to_owned(),
            rotation,
            existing,
            part: 1,
            part_since: None,
            begun_bytes: file.bytes(),
            file,
            has_begun: false,
            jobs,
            syncer,
            shared,
        })
    }

    /// Starts the next part if it is due.
    fn rotate_if_due(&mut self, now: Moment, at_ns: u64) {
        let age = now.saturating_sub(self.part_since.unwrap_or(now));
        let bytes = self.file.bytes().saturating_sub(self.begun_bytes);
        if !self.rotation.is_due(age, bytes) || self.shared.problem().is_some() {
            return;
        }
        let Some((number, path)) = files::free_part(&self.first, self.part + 1) else {
            return;
        };
        let mut session = self.session.clone();
        session.start = UNIX_EPOCH + Duration::from_nanos(at_ns);
        session.notes.insert("part".into(), number.to_string());
        let begun =
            part::create(&path, self.existing).and_then(|file| Part::begin(file, &path, &session));
        match begun {
            Ok((part, file)) => {
                *self.shared.place() = Place {
                    path,
                    first_ns: None,
                };
                self.begun_bytes = file.bytes();
                self.file = file;
                self.hand_over(Job::Next(part));
                self.part = number;
                // The disk may have been slow; the next bytes begin the part.
                self.part_since = None;
                self.has_begun = false;
            }
            Err(error) => self.shared.set_problem(&error),
        }
    }

    fn hand_over(&self, job: Job) {
        // A thread that has ended has reported its error.
        let _ = self.jobs.send(job);
    }

    fn join(self) -> Result<(), CaptureError> {
        drop(self.jobs);
        self.syncer.join().unwrap_or_else(|_| {
            let error = io::Error::other("the recorder stopped unexpectedly");
            Err(CaptureError::Write {
                path: self.file.path().to_owned(),
                error,
            })
        })
    }
}

impl FileWorker for PartWriter {
    type Item = Entry;

    fn write(&mut self, entry: Entry) -> Result<(), CaptureError> {
        let Entry {
            now,
            at_ns,
            observation,
        } = entry;
        // A part ends with a whole line.
        let (is_received, ends_line) = match &observation {
            Observation::Received(raw) => (true, raw.data.ends_with(b"\n")),
            _ => (false, false),
        };
        if !self.has_begun {
            self.has_begun = true;
            self.shared.place().first_ns = Some(at_ns);
        }
        let written = self.file.observation(at_ns, observation);
        written.map_err(|error| CaptureError::Write {
            path: self.file.path().to_owned(),
            error,
        })?;
        if let Some(now) = now.filter(|_| is_received) {
            self.part_since.get_or_insert(now);
            if ends_line {
                self.rotate_if_due(now, at_ns);
            }
        }
        let bytes = self.file.bytes();
        self.shared.part_bytes.store(bytes, Ordering::Release);
        Ok(())
    }

    fn look(&mut self) -> Result<(), CaptureError> {
        if !self.shared.is_sync_due.swap(true, Ordering::AcqRel) {
            self.hand_over(Job::Sync);
        }
        Ok(())
    }

    fn finish(self) -> Result<(), CaptureError> {
        self.join()
    }

    fn leave(self) {
        self.hand_over(Job::Leave);
        // The error that ended the part is reported.
        let _ = self.join();
    }
}
