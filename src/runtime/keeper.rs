//! The recording manager: writes the raw text and the recording of a session before bytes are decoded.

mod history;
mod options;

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use groundwave_protocol::telemetry::Line;

use super::driver::{EventSink, SentSink};
use crate::capture::messages::RawBytes;
use crate::capture::session::since_1970_ns;
use crate::capture::topics::StationEvent;
use crate::capture::{
    CaptureError, Existing, Observation, RawWriter, Recorder, Session, files, name, recover,
};
use crate::event::{Event, Level, Moment, Recording};
use crate::io::link::Sink;
use crate::recorded;
use history::History;
pub use options::{KeepOptions, REMEMBERED};

/// Maximum numbered names of recordings begun in one second.
const NAMES_MAX: u32 = 100;

/// Period of the check that the raw text still has its name.
const LOOK_PERIOD: Duration = Duration::from_secs(8);

/// The raw text, and the recorder behind a lock: the reader thread writes received bytes, the event loop sent bytes and
/// events.
#[derive(Clone)]
pub struct Keeper(Arc<Mutex<Inner>>);

struct Inner {
    tee: Option<Arc<RawWriter>>,
    recorder: Option<Recorder>,
    /// Observations that are in no finished recording.
    history: History,
    options: KeepOptions,
    started: Instant,
    started_wall: SystemTime,
    /// When the raw text is checked again.
    look_at: Moment,
    /// Another thread is beginning a recording.
    is_beginning: bool,
    /// The recorder's problem that was reported last.
    told: Option<String>,
    /// Threads that begin, end or recover a recording.
    threads: Vec<JoinHandle<()>>,
    /// Their reports.
    notices: VecDeque<(Level, String)>,
    /// Files that are complete.
    finished: Vec<PathBuf>,
}

impl Keeper {
    /// Creates all files or none. Interrupted recordings in the same folder are recovered meanwhile;
    /// [`Self::poll_notice`] reports them.
    ///
    /// # Errors
    /// When a file exists and may not be overwritten, or cannot be written.
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
        // Last, because it may overwrite a file and cannot be undone.
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
        let keeper = Self(Arc::new(Mutex::new(Inner {
            tee: tee.map(Arc::new),
            recorder,
            history: History::new(options.remembered),
            options: options.clone(),
            started,
            started_wall,
            look_at: LOOK_PERIOD,
            is_beginning: false,
            told: None,
            threads: Vec::new(),
            notices: VecDeque::new(),
            finished: Vec::new(),
        })));
        if let Some(path) = &options.mcap {
            keeper.recover_beside(path);
        }
        Ok(keeper)
    }

    fn lock(&self) -> MutexGuard<'_, Inner> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The sink for received bytes, for the link's reader thread.
    #[must_use]
    pub fn sink(&self) -> Sink {
        let keeper = self.clone();
        let tee = self.lock().tee.clone();
        Box::new(move |at, bytes| {
            keeper.lock().handle_rx(at, bytes);
            // Last and without the lock, because a stalled file may delay it.
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
        Box::new(move |at, event| {
            if let Event::Line { line, .. } = event {
                keeper.lock().handle_line(at, line);
            } else if let Some(event) = recorded::to_recorded(event) {
                keeper.lock().handle_event(at, &event);
            }
        })
    }

    /// The files, their bytes and the first problem.
    #[must_use]
    pub fn status(&self) -> Recording {
        self.lock().status()
    }

    /// Ends the recording under way, or begins one with the remembered observations under an automatic name; a failed
    /// recording is replaced. Never waits for the disk; [`Self::poll_notice`] reports the result.
    pub fn toggle(&self) {
        self.toggle_as(PathBuf::from(name::automatic(SystemTime::now())));
    }

    fn toggle_as(&self, path: PathBuf) {
        let mut inner = self.lock();
        if inner.is_beginning {
            return;
        }
        let ended = inner.recorder.take();
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
        !inner.notices.is_empty() || inner.threads.iter().any(|thread| !thread.is_finished())
    }

    /// Finishes the recording; returns the bytes in the files.
    ///
    /// # Errors
    /// The first problem since the start.
    pub fn finish(&self) -> Result<u64, CaptureError> {
        let (recorder, tee) = {
            let mut inner = self.lock();
            (inner.recorder.take(), inner.tee.take())
        };
        // Each file is finished even if the other fails.
        let teed = tee.map_or(Ok(0), |tee| {
            let path = tee.path().to_owned();
            self.list(path, tee.finish())
        });
        let recorded = recorder.map_or(Ok(0), |recorder| {
            let path = recorder.path().to_owned();
            self.list(path, recorder.finish())
        });
        loop {
            let threads = std::mem::take(&mut self.lock().threads);
            if threads.is_empty() {
                break;
            }
            for thread in threads {
                // A thread that panicked has no report.
                let _ = thread.join();
            }
        }
        let begun = self.lock().recorder.take();
        if let Some(recorder) = begun {
            // A thread began this recording a moment ago.
            let path = recorder.path().to_owned();
            self.list(path, recorder.finish())?;
        }
        Ok(recorded? + teed?)
    }

    /// Adds a file to those finished, unless its end has failed.
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
        let thread = thread::Builder::new()
            .name("keeper".into())
            .spawn(move || work(&keeper));
        match thread {
            Ok(thread) => {
                inner.threads.push(thread);
                true
            }
            Err(error) => {
                let text = format!("cannot start a thread: {error}");
                inner.notices.push_back((Level::Alarm, text));
                false
            }
        }
    }

    /// Finishes a recording and forgets its history; when it failed, keeps the history and returns its path.
    fn end_now(&self, recorder: Recorder, history: History) -> Option<PathBuf> {
        let path = recorder.path().to_owned();
        let ended = self.list(path.clone(), recorder.finish());
        let mut inner = self.lock();
        let told = inner.told.take();
        match ended {
            Ok(bytes) => {
                let text = format!("recorded {}: {bytes} bytes", path.display());
                inner.notices.push_back((Level::Info, text));
                None
            }
            Err(error) => {
                inner.history.put_back(history);
                let text = error.to_string();
                if told.as_ref() != Some(&text) {
                    inner.notices.push_back((Level::Alarm, text));
                }
                Some(path)
            }
        }
    }

    /// Begins a recording, in place of a failed one if there was one. Observations from before the file existed come
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
                let path = recorder.path().to_owned();
                let (now, _) = inner.times(Instant::now());
                recorder.handle_backlog(now, inner.history.observations());
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

    /// Recovers interrupted recordings in the folder of a recording.
    fn recover_beside(&self, path: &Path) {
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        let mut inner = self.lock();
        self.spawn(&mut inner, move |keeper| {
            let mut failed = Vec::new();
            for path in files::find_interrupted(&folder) {
                let notice = match recover::recover(&path) {
                    Ok(recovery) => (recovery.level(), recovery.headline()),
                    // Another program has begun to recover it.
                    Err(CaptureError::UnderWay(_)) => continue,
                    Err(error) => {
                        failed.push((path, error));
                        continue;
                    }
                };
                keeper.lock().notices.push_back(notice);
            }
            if let Some(text) = hopeless(&failed) {
                keeper.lock().notices.push_back((Level::Warning, text));
            }
        });
    }
}

/// One line about the recordings that could not be recovered. Every start reports them; the line says how to prevent
/// that.
fn hopeless(failed: &[(PathBuf, CaptureError)]) -> Option<String> {
    let (path, error) = failed.first()?;
    let name = path.display();
    Some(match failed.len() {
        1 => format!("an interrupted recording cannot be recovered: {error}; move or delete it"),
        count => format!(
            "{count} interrupted recordings cannot be recovered, {name} first: {error}; `groundwave recover FOLDER` says \
             why; move or delete them"
        ),
    })
}

/// Finishes a recording when dropped, even by a panic.
pub struct FinishOnDrop(Keeper);

impl Drop for FinishOnDrop {
    fn drop(&mut self) {
        // A caller that can report a failure has called `finish` before.
        let _ = self.0.finish();
    }
}

/// Begins a recording; an interrupted one with its name is renamed.
fn begin(options: &KeepOptions, path: &Path, start: SystemTime) -> Result<Recorder, CaptureError> {
    // Only raw text can be appended to.
    let existing = match options.existing {
        Existing::Append => Existing::Refuse,
        other => other,
    };
    let session = Session {
        link: options.link.clone(),
        start,
        notes: options.notes.clone(),
        configuration: options.configuration.clone(),
    };
    files::refuse_own_name(path)?;
    files::set_aside(path)?;
    Recorder::start_rotating(path, existing, &session, options.rotation)
}

/// Begins a recording under an automatic name, with a number if another began in the same second.
fn begin_unnamed(
    options: &KeepOptions,
    path: &Path,
    start: SystemTime,
) -> Result<Recorder, CaptureError> {
    for number in 1..NAMES_MAX {
        match begin(options, &name::another(path, number), start) {
            Err(CaptureError::Exists { .. } | CaptureError::InUse(_)) => {}
            begun => return begun,
        }
    }
    begin(options, &name::another(path, NAMES_MAX), start)
}

impl Inner {
    fn times(&self, at: Instant) -> (Moment, SystemTime) {
        let now = at.saturating_duration_since(self.started);
        (now, self.started_wall + now)
    }

    fn handle_rx(&mut self, at: Instant, bytes: &[u8]) {
        let (now, wall) = self.times(at);
        self.history
            .push(since_1970_ns(wall), Observation::Received(raw(bytes)));
        if let Some(recorder) = &mut self.recorder {
            recorder.handle_rx(now, wall, bytes);
        }
    }

    fn handle_tx(&mut self, at: Instant, bytes: &[u8]) {
        let (now, wall) = self.times(at);
        self.history
            .push(since_1970_ns(wall), Observation::Sent(raw(bytes)));
        if let Some(recorder) = &mut self.recorder {
            recorder.handle_tx(now, wall, bytes);
        }
    }

    fn handle_line(&mut self, at: Instant, line: &Line) {
        let (now, _) = self.times(at);
        if let Some(recorder) = &mut self.recorder {
            recorder.handle_line(now, line);
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

    fn status(&mut self) -> Recording {
        // On a silent link, only this call makes the recorder sync.
        let (now, _) = self.times(Instant::now());
        if let Some(recorder) = &mut self.recorder {
            recorder.handle_timeout(now);
        }
        if let Some(tee) = &self.tee
            && now >= self.look_at
        {
            tee.look();
            self.look_at = now + LOOK_PERIOD;
        }
        let name = |path: &Path| path.display().to_string();
        let tee_problem = self
            .tee
            .as_ref()
            .and_then(|tee| tee.problem(Instant::now()));
        let recorder_problem = self.recorder.as_ref().and_then(Recorder::problem);
        self.told.clone_from(&recorder_problem);
        Recording {
            tee: self.tee.as_ref().map(|tee| name(tee.path())),
            mcap: self.recorder.as_ref().map(|recorder| name(recorder.path())),
            bytes: match (&self.recorder, &self.tee) {
                (Some(recorder), _) => recorder.bytes(),
                (None, Some(tee)) => tee.bytes(),
                (None, None) => 0,
            },
            problem: tee_problem.or(recorder_problem),
        }
    }
}

/// Bytes whose offset in the stream is not known yet.
fn raw(bytes: &[u8]) -> RawBytes {
    RawBytes {
        stream_offset: 0,
        data: bytes.to_vec(),
    }
}

#[cfg(test)]
mod tests;
