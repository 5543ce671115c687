//! Records a session: one thread writes each message at once, another syncs and finishes.

mod part;
mod writer;

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, SystemTime};

use groundwave_protocol::telemetry::Line;
use prost::Message as _;

use super::event::Moment;
use super::files::create_error;
use super::messages::RawBytes;
use super::observations::Observation;
use super::rotation::Rotation;
use super::session::{Session, since_1970_ns};
use super::topics::StationEvent;
use super::urgent::UrgentLines;
use super::write_queue::{self, PATIENCE, STALL_PERIOD, WriteQueue};
use super::{CaptureError, Existing};
use part::Part;
use writer::{Entry, PartWriter};

/// A recording in progress.
///
/// Calls never wait for the disk and do not fail; [`Self::problem`] reports errors. The reader calls [`Pace::wait`] after
/// each read, so that a killed program loses nothing that it passed on, while the disk accepts it.
/// [`Self::finish`] makes the finished recording; so does dropping the recorder.
pub struct Recorder {
    queue: WriteQueue<Entry>,
    shared: Arc<Shared>,
    urgent_lines: UrgentLines,
    /// Time at which a sync was requested that has not begun.
    stalled_since: Option<Moment>,
    /// Whether a requested sync has not begun for [`STALL_PERIOD`].
    is_stalled: bool,
    /// Time of the newest message, nanoseconds since 1970.
    last_ns: u64,
    has_begun: bool,
}

/// Paces the reader of a recording.
pub struct Pace(write_queue::Pace<Entry>);

impl Pace {
    /// Waits until the file contains everything recorded: at most 100 ms for a disk that falls behind, and 5 s with a full queue,
    /// after that, the recording is given up.
    pub fn wait(&self) {
        self.0.wait();
    }
}

impl Recorder {
    /// Creates the file and waits until its beginning is on the disk.
    ///
    /// The caller must first rename an interrupted recording with that name ([`super::interrupted::set_aside`]).
    ///
    /// # Errors
    /// If the file exists and may not be overwritten, is in use, or cannot be written.
    pub fn start(
        path: impl Into<PathBuf>,
        existing: Existing,
        session: &Session,
    ) -> Result<Self, CaptureError> {
        Self::start_rotating(path, existing, session, Rotation::default())
    }

    /// Creates the file as [`Self::start`] does, with the given rotation instead of daily parts.
    ///
    /// # Errors
    /// The errors of [`Self::start`].
    pub fn start_rotating(
        path: impl Into<PathBuf>,
        existing: Existing,
        session: &Session,
        rotation: Rotation,
    ) -> Result<Self, CaptureError> {
        let path = path.into();
        let file = part::create(&path, existing)?;
        Self::on(file, &path, existing, session, rotation)
    }

    /// Records as [`Self::start_rotating`] does, to a new file that is already open; `existing` applies to later parts. The file is
    /// removed when it cannot be written.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn on(
        file: File,
        path: &Path,
        existing: Existing,
        session: &Session,
        rotation: Rotation,
    ) -> Result<Self, CaptureError> {
        let (part, unfinished) = Part::begin(file, path, session)?;
        let shared = Arc::new(Shared::new(path.to_owned()));
        let writer = PartWriter::new(
            part,
            unfinished,
            Arc::clone(&shared),
            session,
            rotation,
            existing,
        );
        let progress = Arc::clone(&shared.progress);
        let queue = writer
            .and_then(|writer| WriteQueue::start(path.to_owned(), writer, progress))
            .map_err(|error| {
                // The file is empty.
                let _ = fs::remove_file(path);
                create_error(path, error, false)
            })?;
        Ok(Self {
            queue,
            shared,
            urgent_lines: UrgentLines::default(),
            stalled_since: None,
            is_stalled: false,
            last_ns: since_1970_ns(session.start),
            has_begun: false,
        })
    }

    /// Records bytes from the radio, read at `wall`.
    pub fn handle_rx(&mut self, now: Moment, wall: SystemTime, bytes: &[u8]) {
        if !bytes.is_empty() {
            let observation = Observation::Received(RawBytes::unplaced(bytes));
            self.push(Some(now), since_1970_ns(wall), observation);
        }
    }

    /// Takes a line decoded from recorded bytes. A bump or an alarm is synced at once.
    pub fn handle_line(&mut self, line: &Line) {
        if self.urgent_lines.take_line(line) {
            self.queue.look();
        }
    }

    /// Records bytes to the radio, sent at `wall`.
    pub fn handle_tx(&mut self, now: Moment, wall: SystemTime, bytes: &[u8]) {
        if !bytes.is_empty() {
            let observation = Observation::Sent(RawBytes::unplaced(bytes));
            self.push(Some(now), since_1970_ns(wall), observation);
        }
    }

    /// Records an event of the station. Beginnings and ends of commands and alarms are synced at once.
    pub fn handle_event(&mut self, now: Moment, wall: SystemTime, event: &StationEvent) {
        let observation = Observation::Event(Box::new(event.clone()));
        self.push(Some(now), since_1970_ns(wall), observation);
        if event.is_urgent() {
            self.queue.look();
        }
    }

    /// Records observations from before the recording began, oldest first, with their times in nanoseconds since 1970. Must be
    /// called before anything else.
    pub fn handle_backlog(&mut self, observations: &[(u64, Observation)]) {
        for (at_ns, observation) in observations {
            self.push(None, *at_ns, observation.clone());
        }
        self.queue.look();
    }

    /// Queues an observation; a time before the previous observation's counts as the previous one.
    fn push(&mut self, now: Option<Moment>, at_ns: u64, observation: Observation) {
        self.last_ns = self.last_ns.max(at_ns);
        if !self.has_begun {
            self.has_begun = true;
            self.shared.place().first_ns = Some(self.last_ns);
        }
        let bytes = match &observation {
            Observation::Received(raw) | Observation::Sent(raw) => raw.data.len(),
            Observation::Event(event) => event.encoded_len(),
        };
        let entry = Entry {
            now,
            at_ns: self.last_ns,
            observation,
        };
        self.queue.push(entry, bytes as u64, now);
        if let Some(now) = now {
            self.note_stall(now);
        }
    }

    /// Syncs if the last sync was eight seconds ago, checks that the file still has its name, and notes a disk that writes
    /// nothing. Call this about once a second, also while nothing is received.
    pub fn handle_timeout(&mut self, now: Moment) {
        self.queue.handle_timeout(now);
        self.note_stall(now);
    }

    fn note_stall(&mut self, now: Moment) {
        if self.shared.is_sync_due.load(Ordering::Acquire) {
            let since = *self.stalled_since.get_or_insert(now);
            self.is_stalled = now.saturating_sub(since) >= STALL_PERIOD;
        } else {
            self.stalled_since = None;
            self.is_stalled = false;
        }
    }

    /// A handle that paces the reader. Do not hold a lock while using it.
    #[must_use]
    pub fn pace(&self) -> Pace {
        Pace(self.queue.pace())
    }

    /// Converts a wall-clock time to time since the current part began; `None` while the part is empty.
    #[must_use]
    pub fn moment_of(&self, wall: SystemTime) -> Option<Moment> {
        let since_ns = since_1970_ns(wall).saturating_sub(self.shared.place().first_ns?);
        Some(Moment::from_nanos(since_ns))
    }

    /// The name of the current part.
    #[must_use]
    pub fn path(&self) -> PathBuf {
        self.shared.place().path.clone()
    }

    /// Number of bytes in all parts.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        let shared = &self.shared;
        shared.finished_bytes.load(Ordering::Acquire) + shared.part_bytes.load(Ordering::Acquire)
    }

    /// Number of recorded bytes not yet written to a file, without the MCAP framing.
    #[must_use]
    pub fn unwritten_bytes(&self) -> u64 {
        self.queue.unwritten()
    }

    /// Whether the whole current part is on the disk.
    #[must_use]
    pub fn is_synced(&self) -> bool {
        let synced = self.shared.synced_bytes.load(Ordering::Acquire);
        self.queue.unwritten() == 0 && synced == self.shared.part_bytes.load(Ordering::Acquire)
    }

    /// The first error, if any.
    #[must_use]
    pub fn problem(&self) -> Option<String> {
        let problem = self.shared.problem().clone();
        let stalled = || CaptureError::Stalled(self.path()).to_string();
        problem
            .or_else(|| self.queue.problem())
            .or_else(|| self.is_stalled.then(stalled))
    }

    /// Whether [`Self::problem`] is that the disk accepts no bytes.
    #[must_use]
    pub fn is_stalled(&self) -> bool {
        self.shared.problem().is_none() && (self.is_stalled || self.queue.is_stalled())
    }

    /// Whether the current part cannot be written or no longer exists.
    #[must_use]
    pub fn has_failed(&self) -> bool {
        self.queue.has_failed() || self.shared.is_lost.load(Ordering::Acquire)
    }

    /// Finishes the recording; returns the number of bytes in all parts. Waits at most a few seconds for a disk that
    /// makes no progress.
    ///
    /// # Errors
    /// The first error since the start, or a disk that makes no progress.
    pub fn finish(self) -> Result<u64, CaptureError> {
        self.finish_within(PATIENCE)
    }

    fn finish_within(&self, patience: Duration) -> Result<u64, CaptureError> {
        self.queue.finish_within(patience)?;
        Ok(self.shared.finished_bytes.load(Ordering::Acquire))
    }

    /// Leaves the current part unfinished, as killing the program would.
    pub fn abandon(self) {
        self.queue.leave();
    }

    /// Removes the current part, for a session that fails to start.
    pub fn discard(self) {
        let path = self.path();
        self.abandon();
        let _ = fs::remove_file(path);
    }
}

impl Drop for Recorder {
    fn drop(&mut self) {
        if !self.queue.is_ending() {
            // `problem` has reported the error.
            let _ = self.finish_within(PATIENCE);
        }
    }
}

/// State shared with the threads.
struct Shared {
    problem: Mutex<Option<String>>,
    place: Mutex<Place>,
    /// Whether the current part has lost its name or cannot be synced.
    is_lost: AtomicBool,
    /// Whether a sync was requested that has not begun.
    is_sync_due: AtomicBool,
    /// Length of the current part, bytes.
    part_bytes: AtomicU64,
    /// Number of bytes of the current part on the disk.
    synced_bytes: AtomicU64,
    /// Total length of the finished parts, bytes.
    finished_bytes: AtomicU64,
    /// Number of steps of syncing and finishing done.
    progress: Arc<AtomicU64>,
}

/// The current part.
struct Place {
    path: PathBuf,
    /// Time of the first observation, nanoseconds since 1970; readers count from this time.
    first_ns: Option<u64>,
}

impl Shared {
    fn new(path: PathBuf) -> Self {
        Self {
            problem: Mutex::default(),
            place: Mutex::new(Place {
                path,
                first_ns: None,
            }),
            is_lost: AtomicBool::default(),
            is_sync_due: AtomicBool::default(),
            part_bytes: AtomicU64::default(),
            synced_bytes: AtomicU64::default(),
            finished_bytes: AtomicU64::default(),
            progress: Arc::default(),
        }
    }

    fn problem(&self) -> MutexGuard<'_, Option<String>> {
        self.problem.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn place(&self) -> MutexGuard<'_, Place> {
        self.place.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Sets the problem unless there is one already.
    fn set_problem(&self, problem: &CaptureError) {
        self.problem().get_or_insert_with(|| problem.to_string());
    }
}

#[cfg(all(test, target_os = "linux"))]
mod tests;
