//! Records a session: writes each message at once and syncs on a thread.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, SystemTime};

use groundwave_protocol::telemetry::Line;

use super::alarm_detector::AlarmDetector;
use super::error::create_error;
use super::event::Moment;
use super::files;
use super::observations::Observation;
use super::presence;
use super::recover::{self, Outcome};
use super::rotation::Rotation;
use super::session::{Session, since_1970_ns};
use super::topics::StationEvent;
use super::unfinished::UnfinishedWriter;
use super::{CaptureError, Existing};

/// Period of syncs. With a slow disk, a power cut costs the last 10 s at most.
const SYNC_PERIOD: Duration = Duration::from_secs(8);

/// Limits how long a disk may take before it is reported.
const STALL_PERIOD: Duration = Duration::from_secs(30);

/// A recording under way.
///
/// Each message is with the operating system when a call returns. Only that write can block: syncing and finishing
/// happen on a thread. Calls do not fail; [`Self::problem`] reports errors. [`Self::finish`] makes the finished
/// recording; so does dropping the recorder.
pub struct Recorder {
    /// The name of the first part.
    path: PathBuf,
    existing: Existing,
    session: Session,
    rotation: Rotation,
    part: u32,
    part_since: Option<Moment>,
    file: UnfinishedWriter,
    /// Bytes of the present part before its first message.
    begun_bytes: u64,
    /// Error after which nothing is written to the present part.
    write_error: Option<CaptureError>,
    alarms: AlarmDetector,
    jobs: Option<Sender<Job>>,
    thread: Option<JoinHandle<Result<(), CaptureError>>>,
    shared: Arc<Shared>,
    sync_at: Option<Moment>,
    /// When a sync was requested that has not begun.
    stalled_since: Option<Moment>,
    /// A sync has not begun for [`STALL_PERIOD`].
    is_stalled: bool,
    /// Time of the newest message, nanoseconds since 1970.
    last_ns: u64,
    /// Time of the part's first observation, nanoseconds since 1970; readers count from it.
    first_ns: Option<u64>,
}

impl Recorder {
    /// Creates the file and waits until its beginning is on the disk.
    ///
    /// The caller must have renamed an interrupted recording with that name: [`files::set_aside`].
    ///
    /// # Errors
    /// When the file exists and may not be overwritten, is in use, or cannot be written.
    pub fn start(
        path: impl Into<PathBuf>,
        existing: Existing,
        session: &Session,
    ) -> Result<Self, CaptureError> {
        Self::start_rotating(path, existing, session, Rotation::default())
    }

    /// As [`Self::start`], with the given rotation instead of daily parts.
    ///
    /// # Errors
    /// As [`Self::start`].
    pub fn start_rotating(
        path: impl Into<PathBuf>,
        existing: Existing,
        session: &Session,
        rotation: Rotation,
    ) -> Result<Self, CaptureError> {
        let path = path.into();
        let (part, file) = Part::begin(&path, existing, session)?;
        let shared = Arc::<Shared>::default();
        let (jobs, queue) = channel();
        let worker = Worker {
            part,
            shared: Arc::clone(&shared),
        };
        let thread = thread::Builder::new()
            .name("recorder".into())
            .spawn(move || worker.run(&queue))
            .map_err(|error| {
                // The file is empty.
                let _ = fs::remove_file(&path);
                create_error(&path, error, false)
            })?;
        Ok(Self {
            path,
            existing,
            session: session.clone(),
            rotation,
            part: 1,
            part_since: None,
            begun_bytes: file.bytes(),
            file,
            write_error: None,
            alarms: AlarmDetector::default(),
            jobs: Some(jobs),
            thread: Some(thread),
            shared,
            sync_at: None,
            stalled_since: None,
            is_stalled: false,
            last_ns: since_1970_ns(session.start),
            first_ns: None,
        })
    }

    /// Records bytes from the radio, read at `wall`.
    pub fn handle_rx(&mut self, now: Moment, wall: SystemTime, bytes: &[u8]) {
        if bytes.is_empty() {
            return;
        }
        let at_ns = self.time_ns(since_1970_ns(wall));
        self.write(|file| file.received(at_ns, bytes));
        self.handle_timeout(now);
        self.part_since.get_or_insert(now);
        if bytes.ends_with(b"\n") {
            self.rotate_if_due(now, wall);
        }
    }

    /// Takes a line decoded from recorded bytes. A bump or an alarm is synced at once.
    pub fn handle_line(&mut self, now: Moment, line: &Line) {
        if self.alarms.take_line(line) {
            self.sync(now);
        }
    }

    /// Records bytes to the radio, sent at `wall`.
    pub fn handle_tx(&mut self, now: Moment, wall: SystemTime, bytes: &[u8]) {
        if bytes.is_empty() {
            return;
        }
        let at_ns = self.time_ns(since_1970_ns(wall));
        self.write(|file| file.sent(at_ns, bytes));
        self.handle_timeout(now);
    }

    /// Records an event of the station. Beginnings and ends of commands and alarms are synced at once.
    pub fn handle_event(&mut self, now: Moment, wall: SystemTime, event: &StationEvent) {
        let at_ns = self.time_ns(since_1970_ns(wall));
        self.write(|file| file.event(at_ns, event));
        if event.is_urgent() {
            self.sync(now);
        }
        self.handle_timeout(now);
    }

    /// Records observations from before the recording began, oldest first, with their times in nanoseconds since 1970. To be
    /// called before anything else.
    pub fn handle_backlog(&mut self, now: Moment, observations: &[(u64, Observation)]) {
        for (at_ns, observation) in observations {
            let at_ns = self.time_ns(*at_ns);
            self.write(|file| match observation {
                Observation::Received(raw) => file.received(at_ns, &raw.data),
                Observation::Sent(raw) => file.sent(at_ns, &raw.data),
                Observation::Event(event) => file.event(at_ns, event),
            });
        }
        self.sync(now);
    }

    /// Time of a message, never before that of the previous message.
    fn time_ns(&mut self, at_ns: u64) -> u64 {
        self.last_ns = self.last_ns.max(at_ns);
        self.first_ns.get_or_insert(self.last_ns);
        self.last_ns
    }

    fn write(&mut self, write: impl FnOnce(&mut UnfinishedWriter) -> io::Result<()>) {
        if let Err(error) = write(&mut self.file) {
            let error = CaptureError::Write {
                path: self.file.path().to_owned(),
                error,
            };
            self.shared.set_problem(&error);
            self.write_error = Some(error);
        }
    }

    /// Syncs if the last sync was eight seconds ago, and checks that the file still has its name. Call it about once a
    /// second, also while nothing is received.
    pub fn handle_timeout(&mut self, now: Moment) {
        if now >= *self.sync_at.get_or_insert(now + SYNC_PERIOD) {
            self.sync(now);
        }
    }

    fn sync(&mut self, now: Moment) {
        self.sync_at = Some(now + SYNC_PERIOD);
        if self.shared.is_sync_due.swap(true, Ordering::AcqRel) {
            let since = *self.stalled_since.get_or_insert(now);
            self.is_stalled = now.saturating_sub(since) >= STALL_PERIOD;
        } else {
            self.stalled_since = None;
            self.is_stalled = false;
            self.hand_over(Job::Sync);
        }
    }

    fn hand_over(&self, job: Job) {
        if let Some(jobs) = &self.jobs {
            // A thread that has ended has reported its error.
            let _ = jobs.send(job);
        }
    }

    /// Time since the beginning of the present part at a wall-clock time; `None` while the part is empty.
    #[must_use]
    pub fn moment_of(&self, wall: SystemTime) -> Option<Moment> {
        let since_ns = since_1970_ns(wall).saturating_sub(self.first_ns?);
        Some(Moment::from_nanos(since_ns))
    }

    /// The name of the present part.
    #[must_use]
    pub fn path(&self) -> &Path {
        self.file.path()
    }

    /// Number of bytes in all parts.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.shared.finished_bytes.load(Ordering::Acquire) + self.file.bytes()
    }

    /// Whether the disk has all of the present part.
    #[must_use]
    pub fn is_synced(&self) -> bool {
        self.shared.synced_bytes.load(Ordering::Acquire) == self.file.bytes()
    }

    /// The first error, if any.
    #[must_use]
    pub fn problem(&self) -> Option<String> {
        let problem = self.shared.problem().clone();
        let stalled = || CaptureError::Stalled(self.path().to_owned()).to_string();
        problem.or_else(|| self.is_stalled.then(stalled))
    }

    /// Whether the present part cannot be written or is gone.
    #[must_use]
    pub fn has_failed(&self) -> bool {
        self.write_error.is_some() || self.thread.as_ref().is_some_and(JoinHandle::is_finished)
    }

    /// Makes the finished recording; returns the number of bytes in all parts.
    ///
    /// # Errors
    /// The first error since the start.
    pub fn finish(mut self) -> Result<u64, CaptureError> {
        self.stop()?;
        Ok(self.shared.finished_bytes.load(Ordering::Acquire))
    }

    /// Leaves the present part unfinished, as a kill does.
    pub fn abandon(mut self) {
        self.hand_over(Job::Leave);
        let _ = self.stop();
    }

    /// Removes the present part, for a session that fails to start.
    pub fn discard(self) {
        let path = self.path().to_owned();
        self.abandon();
        let _ = fs::remove_file(path);
    }

    fn stop(&mut self) -> Result<(), CaptureError> {
        let write_error = self.write_error.take();
        if write_error.is_some() {
            self.hand_over(Job::Leave);
        }
        self.jobs = None;
        let ended = self.thread.take().map_or(Ok(()), |thread| {
            thread.join().unwrap_or_else(|_| {
                let error = io::Error::other("the recorder stopped unexpectedly");
                Err(CaptureError::Write {
                    path: self.path().to_owned(),
                    error,
                })
            })
        });
        write_error.map_or(ended, Err)
    }

    /// Starts the next part if it is due, at the end of a line so that no line is torn.
    fn rotate_if_due(&mut self, now: Moment, wall: SystemTime) {
        let age = now.saturating_sub(self.part_since.unwrap_or(now));
        let bytes = self.file.bytes().saturating_sub(self.begun_bytes);
        if !self.rotation.is_due(age, bytes) || self.shared.problem().is_some() {
            return;
        }
        let Some((number, path)) = files::free_part(&self.path, self.part + 1) else {
            return;
        };
        let mut session = self.session.clone();
        session.start = wall;
        session.notes.insert("part".into(), number.to_string());
        match Part::begin(&path, self.existing, &session) {
            Ok((part, file)) => {
                self.begun_bytes = file.bytes();
                self.file = file;
                self.hand_over(Job::Next(part));
                self.part = number;
                // The disk may have taken a while; the next bytes begin the part.
                self.part_since = None;
                self.first_ns = None;
            }
            Err(error) => self.shared.set_problem(&error),
        }
    }
}

impl Drop for Recorder {
    fn drop(&mut self) {
        // `problem` has reported the error.
        let _ = self.stop();
    }
}

/// A job for the thread.
enum Job {
    /// Sync, and check that the file still has its name.
    Sync,
    /// Finish the present part and continue with this one.
    Next(Part),
    /// End, and leave the present part unfinished.
    Leave,
}

/// State shared with the thread.
#[derive(Default)]
struct Shared {
    problem: Mutex<Option<String>>,
    /// A sync was requested and has not begun.
    is_sync_due: AtomicBool,
    /// Bytes of the present part on the disk.
    synced_bytes: AtomicU64,
    /// Bytes in the finished parts.
    finished_bytes: AtomicU64,
}

impl Shared {
    fn problem(&self) -> MutexGuard<'_, Option<String>> {
        self.problem.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Keeps the first problem.
    fn set_problem(&self, problem: &CaptureError) {
        self.problem().get_or_insert_with(|| problem.to_string());
    }
}

/// A file of the recording, locked until this is dropped.
struct Part {
    path: PathBuf,
    file: File,
    /// Bytes written.
    bytes: Arc<AtomicU64>,
}

impl Part {
    /// Creates a part; its beginning is on the disk when this returns.
    fn begin(
        path: &Path,
        existing: Existing,
        session: &Session,
    ) -> Result<(Self, UnfinishedWriter), CaptureError> {
        let file = create(path, existing)?;
        let begun = file.try_clone().and_then(|clone| {
            let writer = UnfinishedWriter::begin(clone, path, session)?;
            file.sync_data().map(|()| writer)
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

/// Creates a file and locks it.
fn create(path: &Path, existing: Existing) -> Result<File, CaptureError> {
    let mut options = OpenOptions::new();
    match existing {
        Existing::Append => return Err(CaptureError::CannotAppend(path.to_owned())),
        Existing::Refuse => options.write(true).create_new(true),
        // Truncated after the check that no other program records it.
        Existing::Overwrite => options.write(true).create(true).truncate(false),
    };
    if files::is_in_use(path) {
        return Err(CaptureError::InUse(path.to_owned()));
    }
    let file = options
        .open(path)
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

/// The thread of a recorder.
struct Worker {
    part: Part,
    shared: Arc<Shared>,
}

impl Worker {
    /// Does the jobs until there are no more, then finishes the recording.
    fn run(mut self, queue: &Receiver<Job>) -> Result<(), CaptureError> {
        let result = self.carry_out_all(queue);
        if let Err(error) = &result {
            self.shared.set_problem(error);
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
                    file.sync_data().map_err(|error| CaptureError::Write {
                        path: path.clone(),
                        error,
                    })?;
                    self.shared.synced_bytes.store(bytes, Ordering::Release);
                }
                Job::Next(part) => {
                    // A part that cannot be finished stays complete and unfinished.
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
        let recovery = recover::finish(path)?;
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
