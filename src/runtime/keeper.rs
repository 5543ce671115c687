//! The recording manager: writes the raw text and the recording of a session before bytes are decoded.

mod begin;
mod history;
mod options;
mod recovery;

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use groundwave_protocol::telemetry::Line;

use super::driver::{EventSink, SentSink};
use crate::capture::messages::RawBytes;
use crate::capture::session::{ending, since_1970_ns};
use crate::capture::topics::StationEvent;
use crate::capture::{CaptureError, Observation, Pace, RawWriter, Recorder, files, name};
use crate::event::{Event, Level, Moment, Recording};
use crate::hint;
use crate::io::link::Sink;
use crate::recorded;
use begin::{begin, begin_unnamed};
use groundwave_captures::words::counted;
use history::History;
pub use options::{KeepOptions, REMEMBERED};

/// Maximum time for which leaving waits for threads that begin, end or recover recordings.
const LEAVE_PATIENCE: Duration = Duration::from_mins(1);

/// The raw text, and the recorder behind a lock: the reader thread writes received bytes, the event loop sent bytes and
/// events. No call under the lock waits for a disk.
#[derive(Clone)]
pub struct Keeper(Arc<Shared>);

struct Shared {
    inner: Mutex<Inner>,
    /// Signals that a thread has ended.
    idle: Condvar,
}

struct Inner {
    tee: Option<Arc<RawWriter>>,
    recorder: Option<Recorder>,
    /// Observations that are not in a finished recording.
    history: History,
    options: KeepOptions,
    started: Instant,
    started_wall: SystemTime,
    /// Whether another thread is beginning a recording.
    is_beginning: bool,
    /// The recorder's problem reported last.
    reported: Option<String>,
    /// Number of threads that begin, end or recover a recording.
    threads: usize,
    /// Reports of these threads.
    notices: VecDeque<(Level, String)>,
    /// Finished files.
    finished: Vec<PathBuf>,
}

impl Keeper {
    /// Creates all files or none. Interrupted recordings in the same folder are recovered meanwhile;
    /// [`Self::poll_notice`] reports them.
    ///
    /// # Errors
    /// If a file exists and may not be overwritten, or cannot be written.
    pub fn open(options: &KeepOptions, started: Instant) -> Result<Self, CaptureError> {
        let started_wall = SystemTime::now();
        if let (Some(tee), Some(mcap)) = (&options.tee, &options.mcap)
            && (files::is_same(tee, mcap) || files::full_path(tee) == files::full_path(mcap))
        {
            return Err(CaptureError::SameFile(tee.clone()));
        }
        for path in options.tee.iter().chain(&options.mcap) {
            files::refuse_own_name(path)?;
        }
        let recorder = options
            .mcap
            .as_ref()
            .map(|path| {
                if options.is_unnamed {
                    begin_unnamed(options, path, started_wall)
                } else {
                    begin(options, path, started_wall)
                }
            })
            .transpose()?;
        // The raw text comes last, because creating it may overwrite a file, which cannot be undone.
        let tee = options
            .tee
            .as_ref()
            .map(|path| RawWriter::create(path, options.existing))
            .transpose();
        let tee = match tee {
            Ok(tee) => tee,
            Err(error) => {
                if let Some(recorder) = recorder {
                    recorder.discard();
                }
                return Err(error);
            }
        };
        let inner = Mutex::new(Inner {
            tee: tee.map(Arc::new),
            recorder,
            history: History::new(options.remembered),
            options: options.clone(),
            started,
            started_wall,
            is_beginning: false,
            reported: None,
            threads: 0,
            notices: VecDeque::new(),
            finished: Vec::new(),
        });
        let idle = Condvar::new();
        let keeper = Self(Arc::new(Shared { inner, idle }));
        if let Some(path) = &options.mcap {
            keeper.recover_beside(path);
        }
        Ok(keeper)
    }

    fn lock(&self) -> MutexGuard<'_, Inner> {
        self.0.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The sink for received bytes, for the link's reader thread.
    #[must_use]
    pub fn sink(&self) -> Sink {
        let keeper = self.clone();
        let tee = self.lock().tee.clone();
        Box::new(move |at, bytes| {
            let pace = keeper.lock().handle_rx(at, bytes);
            // The waits come last and without the lock, because a stalled file may delay them.
            if let Some(pace) = pace {
                pace.wait();
            }
            if let Some(tee) = &tee {
                tee.write(bytes);
            }
        })
    }

    /// The sink for sent bytes, for the driver.
    #[must_use]
    pub fn sent_sink(&self) -> SentSink {
        let keeper = self.clone();
        Box::new(move |at, bytes| keeper.lock().handle_tx(at, bytes))
    }

    /// The sink for events, for the driver.
    #[must_use]
    pub fn event_sink(&self) -> EventSink {
        let keeper = self.clone();
        let started = self.lock().started;
        Box::new(move |at, event| {
            let now = at.saturating_duration_since(started);
            if let Event::Line { line, .. } = event {
                keeper.lock().handle_line(line);
            } else if let Some(event) = recorded::to_recorded(now, event) {
                keeper.lock().handle_event(at, &event);
            }
        })
    }

    /// The files, their bytes and the first problem.
    #[must_use]
    pub fn status(&self) -> Recording {
        self.lock().status()
    }

    /// Ends the current recording, or begins one with the remembered observations under an automatic name; a failed
    /// recording is replaced. Never waits for the disk; [`Self::poll_notice`] reports the result.
    pub fn toggle(&self) {
        self.toggle_as(PathBuf::from(name::automatic(SystemTime::now())));
    }

    fn toggle_as(&self, path: PathBuf) {
        let mut inner = self.lock();
        if inner.is_beginning {
            return;
        }
        let ended = inner.take_recorder();
        let has_failed = ended.as_ref().is_some_and(Recorder::has_failed);
        let begins = ended.is_none() || has_failed;
        let ended = ended.map(|recorder| (recorder, inner.history.take()));
        inner.is_beginning = self.spawn(&mut inner, move |keeper| {
            let failed = ended.and_then(|(recorder, history)| keeper.end_now(recorder, history));
            if begins {
                keeper.begin_now(&path, failed.as_deref());
            }
        }) && begins;
    }

    /// Time since the beginning of the recording with this name; `None` for any other file.
    #[must_use]
    pub fn moment_of(&self, capture: &Path, at: Instant) -> Option<Moment> {
        let inner = self.lock();
        let (_, wall) = inner.times(at);
        let recorder = inner.recorder.as_ref()?;
        (recorder.path() == capture)
            .then(|| recorder.moment_of(wall))
            .flatten()
    }

    /// The next report of a recording begun, ended or recovered.
    #[must_use]
    pub fn poll_notice(&self) -> Option<(Level, String)> {
        self.lock().notices.pop_front()
    }

    /// Whether a recording is being begun, ended or recovered, or a report is waiting.
    #[must_use]
    pub fn is_busy(&self) -> bool {
        let inner = self.lock();
        !inner.notices.is_empty() || inner.threads > 0
    }

    /// Finishes the recording; returns the bytes in the files.
    ///
    /// # Errors
    /// The first problem since the start.
    pub fn finish(&self) -> Result<u64, CaptureError> {
        let (recorder, tee) = {
            let mut inner = self.lock();
            (inner.take_recorder(), inner.tee.take())
        };
        // Each file is finished even if the other fails.
        let teed = tee.map_or(Ok(0), |tee| {
            let path = tee.path().to_owned();
            self.list(path, tee.finish())
        });
        let recorded = recorder.map_or(Ok(0), |recorder| {
            let path = recorder.path();
            self.list(path, recorder.finish())
        });
        let waited = (self.0.idle)
            .wait_timeout_while(self.lock(), LEAVE_PATIENCE, |inner| inner.threads > 0);
        let (mut inner, waited) = waited.unwrap_or_else(PoisonError::into_inner);
        if waited.timed_out() {
            let text =
                "left before an interrupted recording was recovered; the next start tries again";
            inner.notices.push_back((Level::Warning, text.to_owned()));
        }
        let begun = inner.take_recorder();
        drop(inner);
        if let Some(recorder) = begun {
            // A thread began this recording a moment ago.
            let path = recorder.path();
            self.list(path, recorder.finish())?;
        }
        Ok(recorded? + teed?)
    }

    /// Adds a file to the finished ones, unless finishing it failed.
    fn list<T>(&self, path: PathBuf, ended: Result<T, CaptureError>) -> Result<T, CaptureError> {
        if ended.is_ok() {
            self.lock().finished.push(path);
        }
        ended
    }

    /// The files finished in this session.
    #[must_use]
    pub fn finished(&self) -> Vec<PathBuf> {
        self.lock().finished.clone()
    }

    /// A guard that finishes the recording when it is dropped.
    #[must_use]
    pub fn finish_on_drop(&self) -> FinishOnDrop {
        FinishOnDrop(self.clone())
    }

    /// Runs `work` on a new thread; returns whether the thread could be started.
    fn spawn(&self, inner: &mut Inner, work: impl FnOnce(&Self) + Send + 'static) -> bool {
        let keeper = self.clone();
        let thread = thread::Builder::new().name("keeper".into()).spawn(move || {
            let running = Running(keeper);
            work(&running.0);
        });
        match thread {
            Ok(_) => {
                inner.threads += 1;
                true
            }
            Err(error) => {
                let text = format!("cannot start a thread: {}", hint::words(&error));
                inner.notices.push_back((Level::Alarm, text));
                false
            }
        }
    }

    /// Finishes a recording and drops its history; if the recording failed, keeps the history and returns the path.
    fn end_now(&self, recorder: Recorder, history: History) -> Option<PathBuf> {
        let path = recorder.path();
        let ended = self.list(path.clone(), recorder.finish());
        let mut inner = self.lock();
        let reported = inner.reported.take();
        match ended {
            Ok(bytes) => {
                let text = format!("recorded {}: {}", path.display(), counted(bytes, "byte"));
                inner.notices.push_back((Level::Info, text));
                None
            }
            Err(error) => {
                inner.history.put_back(history);
                let text = error.to_string();
                if reported.as_ref() != Some(&text) {
                    inner.notices.push_back((Level::Alarm, text));
                }
                Some(path)
            }
        }
    }

    /// Begins a recording; replaces a failed one if there was one. Earlier observations come
    /// from the history.
    fn begin_now(&self, path: &Path, failed: Option<&Path>) {
        let (options, first_ns) = {
            let inner = self.lock();
            (inner.options.clone(), inner.history.first_ns())
        };
        let start =
            first_ns.map_or_else(SystemTime::now, |ns| UNIX_EPOCH + Duration::from_nanos(ns));
        let begun = begin_unnamed(&options, path, start);
        let mut inner = self.lock();
        inner.is_beginning = false;
        match begun {
            Ok(mut recorder) => {
                let path = recorder.path();
                recorder.handle_backlog(inner.history.observations());
                inner.recorder = Some(recorder);
                let text = format!("recording to {}", path.display());
                inner.notices.push_back((Level::Info, text));
                drop(inner);
                self.recover_beside(&path);
                if let Some(failed) = failed.filter(|failed| failed.parent() != path.parent()) {
                    self.recover_beside(failed);
                }
            }
            Err(error) => inner.notices.push_back((Level::Alarm, error.to_string())),
        }
    }
}

/// Counts a thread as ended when dropped, even by a panic.
struct Running(Keeper);

impl Drop for Running {
    fn drop(&mut self) {
        self.0.lock().threads -= 1;
        self.0.0.idle.notify_all();
    }
}

/// Finishes a recording when dropped, even by a panic.
pub struct FinishOnDrop(Keeper);

impl Drop for FinishOnDrop {
    fn drop(&mut self) {
        // A caller that can report a failure has called `finish` before.
        let _ = self.0.finish();
    }
}

impl Inner {
    fn times(&self, at: Instant) -> (Moment, SystemTime) {
        let now = at.saturating_duration_since(self.started);
        (now, self.started_wall + now)
    }

    /// Takes bytes from the radio; returns the handle with which the reader waits for the file.
    fn handle_rx(&mut self, at: Instant, bytes: &[u8]) -> Option<Pace> {
        let (now, wall) = self.times(at);
        let observation = Observation::Received(RawBytes::unplaced(bytes));
        self.history.push(since_1970_ns(wall), observation);
        let recorder = self.recorder.as_mut()?;
        recorder.handle_rx(now, wall, bytes);
        Some(recorder.pace())
    }

    fn handle_tx(&mut self, at: Instant, bytes: &[u8]) {
        let (now, wall) = self.times(at);
        self.history.push(
            since_1970_ns(wall),
            Observation::Sent(RawBytes::unplaced(bytes)),
        );
        if let Some(recorder) = &mut self.recorder {
            recorder.handle_tx(now, wall, bytes);
        }
    }

    fn handle_line(&mut self, line: &Line) {
        if let Some(recorder) = &mut self.recorder {
            recorder.handle_line(line);
        }
    }

    fn handle_event(&mut self, at: Instant, event: &StationEvent) {
        let (now, wall) = self.times(at);
        self.history.push(
            since_1970_ns(wall),
            Observation::Event(Box::new(event.clone())),
        );
        if let Some(recorder) = &mut self.recorder {
            recorder.handle_event(now, wall, event);
        }
    }

    /// Takes the recorder, with the end of the recording written.
    fn take_recorder(&mut self) -> Option<Recorder> {
        let (now, wall) = self.times(Instant::now());
        let mut recorder = self.recorder.take()?;
        recorder.handle_event(now, wall, &ending());
        Some(recorder)
    }

    fn status(&mut self) -> Recording {
        // On a silent link, only this call makes the recorder sync.
        let (now, _) = self.times(Instant::now());
        if let Some(recorder) = &mut self.recorder {
            recorder.handle_timeout(now);
        }
        if let Some(tee) = &self.tee {
            tee.handle_timeout(now);
        }
        let name = |path: &Path| path.display().to_string();
        let tee_problem = self.tee.as_ref().and_then(|tee| tee.problem());
        let recorder_problem = self.recorder.as_ref().and_then(Recorder::problem);
        let is_disk_silent = match (&tee_problem, &self.tee, &self.recorder) {
            (Some(_), Some(tee), _) => tee.is_stalled(),
            (_, _, Some(recorder)) => recorder.is_stalled(),
            _ => false,
        };
        self.reported.clone_from(&recorder_problem);
        Recording {
            tee: self.tee.as_ref().map(|tee| name(tee.path())),
            mcap: (self.recorder.as_ref()).map(|recorder| name(&recorder.path())),
            bytes: match (&self.recorder, &self.tee) {
                (Some(recorder), _) => recorder.bytes(),
                (None, Some(tee)) => tee.bytes(),
                (None, None) => 0,
            },
            problem: tee_problem.or(recorder_problem),
            is_disk_silent,
        }
    }
}

#[cfg(test)]
mod tests;
