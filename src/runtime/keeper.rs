//! Keeps what the radio delivers, before anybody looks at it.

mod history;

use std::collections::{BTreeMap, VecDeque};
use std::path::{self, Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use super::driver::{EventSink, SentSink};
use crate::capture::composer::since_1970_ns;
use crate::capture::journal::{Entry, Kind};
use crate::capture::topics::StationEvent;
use crate::capture::{
    CaptureError, Existing, RawWriter, Recorder, Rotation, Session, name, recover,
};
use crate::event::{Level, Moment, Recording};
use crate::io::link::Sink;
use history::History;

/// How much of what came before is in a recording that is begun from the dashboard.
pub const REMEMBERED: Duration = Duration::from_mins(10);

/// Nobody begins so many recordings in a second.
const NAMES_MAX: u32 = 100;

/// How soon somebody is told that the file of the tee was taken away.
const LOOK_PERIOD: Duration = Duration::from_secs(8);

/// What to keep, and where.
#[derive(Clone, Debug)]
pub struct KeepOptions {
    /// Raw bytes go here.
    pub tee: Option<PathBuf>,
    /// MCAP goes here.
    pub mcap: Option<PathBuf>,
    /// Nobody named the MCAP: where another has its name it gets one like it.
    pub is_unnamed: bool,
    /// What to do with files that exist.
    pub existing: Existing,
    /// The link as the operator named it.
    pub link: String,
    /// What else the recording shall say about itself.
    pub notes: BTreeMap<String, String>,
    /// The configuration in force, as text.
    pub configuration: String,
    /// When a recording goes on in another file.
    pub rotation: Rotation,
    /// How much is remembered while nothing is recorded.
    pub remembered: Duration,
}

impl Default for KeepOptions {
    fn default() -> Self {
        Self {
            tee: None,
            mcap: None,
            is_unnamed: false,
            existing: Existing::Refuse,
            link: String::new(),
            notes: BTreeMap::new(),
            configuration: String::new(),
            rotation: Rotation::default(),
            remembered: REMEMBERED,
        }
    }
}

/// The raw tee and the MCAP recorder behind one lock: the reader thread writes received bytes, the
/// event loop what is sent and what happens.
#[derive(Clone)]
pub struct Keeper(Arc<Mutex<Inner>>);

struct Inner {
    tee: Option<RawWriter>,
    recorder: Option<Recorder>,
    /// What came in while nothing was recorded.
    history: History,
    options: KeepOptions,
    started: Instant,
    started_wall: SystemTime,
    /// When the tee is looked for again.
    look_at: Moment,
    /// A recording is being begun on another thread.
    is_beginning: bool,
    /// Threads that begin, end or recover a recording.
    threads: Vec<JoinHandle<()>>,
    /// What they have to say.
    notices: VecDeque<(Level, String)>,
}

impl Keeper {
    /// Creates the files: all of them or none. Recordings in the same folder that were interrupted are
    /// recovered meanwhile; [`Self::poll_notice`] tells.
    ///
    /// # Errors
    /// When one of them exists and may not be touched, or cannot be written.
    pub fn open(options: &KeepOptions, started: Instant) -> Result<Self, CaptureError> {
        let started_wall = SystemTime::now();
        if let (Some(tee), Some(mcap)) = (&options.tee, &options.mcap)
            && path::absolute(tee).ok() == path::absolute(mcap).ok()
        {
            return Err(CaptureError::SameFile(tee.clone()));
        }
        for path in options.tee.iter().chain(&options.mcap) {
            recover::refuse_own_name(path)?;
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
        // Last, for this one cannot be taken back: it may write over what was there.
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
            tee,
            recorder,
            history: History::new(options.remembered),
            options: options.clone(),
            started,
            started_wall,
            look_at: LOOK_PERIOD,
            is_beginning: false,
            threads: Vec::new(),
            notices: VecDeque::new(),
        })));
        if let Some(path) = &options.mcap {
            keeper.recover_beside(path);
        }
        Ok(keeper)
    }

    fn lock(&self) -> MutexGuard<'_, Inner> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// For the link's reader thread.
    #[must_use]
    pub fn sink(&self) -> Sink {
        let keeper = self.clone();
        Box::new(move |at, bytes| keeper.lock().handle_rx(at, bytes))
    }

    /// For the driver, which sends.
    #[must_use]
    pub fn sent_sink(&self) -> SentSink {
        let keeper = self.clone();
        Box::new(move |at, bytes| keeper.lock().handle_tx(at, bytes))
    }

    /// For the driver, which knows what happens.
    #[must_use]
    pub fn event_sink(&self) -> EventSink {
        let keeper = self.clone();
        Box::new(move |at, event| {
            if let Some(event) = StationEvent::from_event(event) {
                keeper.lock().handle_event(at, &event);
            }
        })
    }

    /// What has been kept so far, and what went wrong.
    #[must_use]
    pub fn status(&self) -> Recording {
        self.lock().status()
    }

    /// Begins a recording with what is remembered, under a name of its own making, or ends the one under
    /// way. Waits for no disk: [`Self::poll_notice`] tells what became of it.
    pub fn toggle(&self) {
        let mut inner = self.lock();
        if let Some(recorder) = inner.recorder.take() {
            let path = recorder.path();
            self.spawn(&mut inner, move |keeper| {
                let notice = match recorder.finish() {
                    Ok(bytes) => (
                        Level::Info,
                        format!("recorded {}: {bytes} bytes", path.display()),
                    ),
                    Err(error) => (Level::Alarm, error.to_string()),
                };
                keeper.lock().notices.push_back(notice);
            });
        } else if !inner.is_beginning {
            inner.is_beginning = true;
            self.spawn(&mut inner, Self::begin_now);
        }
    }

    /// How far into the recording of this name a moment is; a raw one knows no times.
    #[must_use]
    pub fn moment_of(&self, capture: &Path, at: Instant) -> Option<Moment> {
        let inner = self.lock();
        let (_, wall) = inner.times(at);
        let recorder = inner.recorder.as_ref()?;
        (recorder.path() == capture)
            .then(|| recorder.moment_of(wall))
            .flatten()
    }

    /// What has become of recordings begun, ended or recovered, once.
    #[must_use]
    pub fn poll_notice(&self) -> Option<(Level, String)> {
        self.lock().notices.pop_front()
    }

    /// Whether a recording is being begun, ended or recovered, or there is something to tell of one.
    #[must_use]
    pub fn is_busy(&self) -> bool {
        let inner = self.lock();
        !inner.notices.is_empty() || inner.threads.iter().any(|thread| !thread.is_finished())
    }

    /// Ends the recording in good order; returns the bytes that are in the files.
    ///
    /// # Errors
    /// Whatever went wrong since the start.
    pub fn finish(&self) -> Result<u64, CaptureError> {
        let (recorder, tee) = {
            let mut inner = self.lock();
            (inner.recorder.take(), inner.tee.take())
        };
        // Each is finished whatever became of the other.
        let teed = tee.map_or(Ok(0), RawWriter::finish);
        let recorded = recorder.map_or(Ok(0), Recorder::finish);
        loop {
            let threads = std::mem::take(&mut self.lock().threads);
            if threads.is_empty() {
                break;
            }
            for thread in threads {
                // One that has panicked has nothing more to say.
                let _ = thread.join();
            }
        }
        if let Some(recorder) = self.lock().recorder.take() {
            // It was being begun just now.
            recorder.finish()?;
        }
        Ok(recorded? + teed?)
    }

    /// Ends the recording when the guard goes, however its scope is left.
    #[must_use]
    pub fn finish_on_drop(&self) -> FinishOnDrop {
        FinishOnDrop(self.clone())
    }

    fn spawn(&self, inner: &mut Inner, work: impl FnOnce(&Self) + Send + 'static) {
        let keeper = self.clone();
        let thread = thread::Builder::new()
            .name("keeper".into())
            .spawn(move || work(&keeper));
        match thread {
            Ok(thread) => inner.threads.push(thread),
            Err(error) => inner
                .notices
                .push_back((Level::Alarm, format!("cannot start a thread: {error}"))),
        }
    }

    /// On a thread of its own. What comes in until the files are there is remembered with the rest.
    fn begin_now(&self) {
        let (options, first_ns) = {
            let inner = self.lock();
            (inner.options.clone(), inner.history.first_ns())
        };
        let start =
            first_ns.map_or_else(SystemTime::now, |ns| UNIX_EPOCH + Duration::from_nanos(ns));
        let path = PathBuf::from(name::automatic(SystemTime::now()));
        let begun = begin_unnamed(&options, &path, start);
        let mut inner = self.lock();
        inner.is_beginning = false;
        match begun {
            Ok(mut recorder) => {
                let path = recorder.path();
                let (now, _) = inner.times(Instant::now());
                recorder.handle_backlog(now, inner.history.take());
                inner.recorder = Some(recorder);
                let text = format!("recording to {}", path.display());
                inner.notices.push_back((Level::Info, text));
                drop(inner);
                self.recover_beside(&path);
            }
            Err(error) => inner.notices.push_back((Level::Alarm, error.to_string())),
        }
    }

    /// Recovers what was interrupted in the folder of a recording.
    fn recover_beside(&self, path: &Path) {
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        let mut inner = self.lock();
        self.spawn(&mut inner, move |keeper| {
            let mut failed = Vec::new();
            for path in recover::find_interrupted(&folder) {
                let notice = match recover::recover(&path) {
                    Ok(recovery) => (recovery.level(), recovery.headline()),
                    // Somebody else was faster.
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

/// Recordings that could not be saved, in one line: each start tells of them again, so with what ends that.
fn hopeless(failed: &[(PathBuf, CaptureError)]) -> Option<String> {
    let (path, error) = failed.first()?;
    let name = path.display();
    let files = format!("{name}.partial and {name}.journal");
    Some(match failed.len() {
        1 => format!(
            "an interrupted recording cannot be recovered: {error}; move or delete {files} if they are of no use to you"
        ),
        count => format!(
            "{count} interrupted recordings cannot be recovered, {name} first: {error}; `groundwave recover FOLDER` says why \
             of each; move or delete {files} and those of the others if they are of no use to you"
        ),
    })
}

/// Ends a recording in good order even when the program panics.
pub struct FinishOnDrop(Keeper);

impl Drop for FinishOnDrop {
    fn drop(&mut self) {
        // Who can report a failure has called `finish` before.
        let _ = self.0.finish();
    }
}

/// Begins a recording; an interrupted one of its name makes room.
fn begin(options: &KeepOptions, path: &Path, start: SystemTime) -> Result<Recorder, CaptureError> {
    // Only raw captures can be written on.
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
    recover::refuse_own_name(path)?;
    recover::set_aside(path)?;
    Recorder::start_rotating(path, existing, &session, options.rotation)
}

/// Begins a recording that nobody named: somebody may have begun one in the same second.
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
        if let Some(tee) = &mut self.tee {
            tee.write(bytes);
        }
        let (now, wall) = self.times(at);
        match &mut self.recorder {
            Some(recorder) => recorder.handle_rx(now, wall, bytes),
            None => self.history.push(entry(Kind::Rx, wall, bytes)),
        }
    }

    fn handle_tx(&mut self, at: Instant, bytes: &[u8]) {
        let (now, wall) = self.times(at);
        match &mut self.recorder {
            Some(recorder) => recorder.handle_tx(now, wall, bytes),
            None => self.history.push(entry(Kind::Tx, wall, bytes)),
        }
    }

    fn handle_event(&mut self, at: Instant, event: &StationEvent) {
        let (now, wall) = self.times(at);
        match &mut self.recorder {
            Some(recorder) => recorder.handle_event(now, wall, event),
            None => self
                .history
                .push(Entry::of_event(since_1970_ns(wall), event)),
        }
    }

    fn status(&mut self) -> Recording {
        // On a silent link nothing else reminds the recorder of what waits to be flushed.
        let (now, _) = self.times(Instant::now());
        if let Some(recorder) = &mut self.recorder {
            recorder.handle_timeout(now);
        }
        if let Some(tee) = &mut self.tee
            && now >= self.look_at
        {
            tee.look();
            self.look_at = now + LOOK_PERIOD;
        }
        let name = |path: &Path| path.display().to_string();
        let tee_problem = self.tee.as_ref().and_then(RawWriter::problem);
        let recorder_problem = self.recorder.as_ref().and_then(Recorder::problem);
        Recording {
            tee: self.tee.as_ref().map(|tee| name(tee.path())),
            mcap: self
                .recorder
                .as_ref()
                .map(|recorder| name(&recorder.path())),
            bytes: match (&self.recorder, &self.tee) {
                (Some(recorder), _) => recorder.bytes(),
                (None, Some(tee)) => tee.bytes(),
                (None, None) => 0,
            },
            problem: tee_problem.or(recorder_problem),
        }
    }
}

fn entry(kind: Kind, wall: SystemTime, bytes: &[u8]) -> Entry {
    Entry {
        kind,
        at_ns: since_1970_ns(wall),
        offset: 0,
        data: bytes.to_vec(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    /// A note finds its moment again: counted as whoever plays the recording counts.
    #[test]
    fn a_moment_of_a_recording_counts_from_the_first_that_is_in_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.mcap");
        let options = KeepOptions {
            mcap: Some(path.clone()),
            ..KeepOptions::default()
        };
        let started = Instant::now();
        let after = |s| started + Duration::from_secs(s);
        let keeper = Keeper::open(&options, started).unwrap();
        assert_eq!(keeper.moment_of(&path, after(1)), None);
        keeper.sink()(after(2), b"something\r\n");
        let ten = Some(Duration::from_secs(10));
        assert_eq!(keeper.moment_of(&path, after(12)), ten);
        let other = folder.path().join("b.mcap");
        assert_eq!(keeper.moment_of(&other, after(12)), None);
        keeper.finish().unwrap();
    }

    #[test]
    fn two_recordings_that_nobody_named_begin_in_one_second() {
        let folder = tempfile::tempdir().unwrap();
        let options = KeepOptions {
            mcap: Some(folder.path().join("groundwave-20250314T092653Z.mcap")),
            is_unnamed: true,
            ..KeepOptions::default()
        };
        let keepers = [(); 3].map(|()| Keeper::open(&options, Instant::now()).unwrap());
        for keeper in keepers {
            keeper.finish().unwrap();
        }
        let mut names: Vec<String> = fs::read_dir(folder.path())
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        let name = |number| format!("groundwave-20250314T092653Z{number}.mcap");
        assert_eq!(names, [".2", ".3", ""].map(name));
    }

    #[test]
    fn a_panic_leaves_a_finished_recording() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.mcap");
        let options = KeepOptions {
            mcap: Some(path.clone()),
            link: "sim".to_owned(),
            ..KeepOptions::default()
        };
        let keeper = Keeper::open(&options, Instant::now()).unwrap();
        // The reader thread of the link holds on to this.
        let _sink = keeper.sink();
        let panicked = std::panic::catch_unwind(|| {
            let _finish = keeper.finish_on_drop();
            panic!("this is the panic that was asked for");
        });
        assert!(panicked.is_err());
        assert!(path.exists());
    }
}
