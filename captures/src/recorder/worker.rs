//! The recorder's thread: everything that a slow disk may hold up.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::Receiver;
use std::sync::{Arc, Mutex, PoisonError};

use super::super::composer::{Composer, Session};
use super::super::error::{CaptureError, Existing, Fate};
use super::super::journal::entries;
use super::super::presence;
use super::super::recover::{self, Paths};
use super::super::topics::Deriver;

/// What the thread is told to do, in order.
pub(super) enum Order {
    /// What is in the journal already, as it stands there.
    Entries(Vec<u8>),
    /// Everything to the system, and onto the disk.
    Flush(Until),
    /// Are the files still where their names say?
    Look,
    /// Finish this part and go on in another.
    Rotate(Box<Part>),
    /// Leave nothing behind.
    Discard,
}

/// What the disk is waited for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Until {
    /// The journal has it, of which the recording can be made; where it does not, the MCAP.
    InJournal,
    /// Both files have it.
    OnDisk,
}

/// A file of a recording.
pub(super) struct Part {
    pub(super) paths: Paths,
    pub(super) session: Session,
    pub(super) existing: Existing,
    /// Its journal, to be kept by the disk with it.
    pub(super) journal: Option<File>,
    pub(super) losses: Arc<Losses>,
}

/// What one of the files of a part lacks.
#[derive(Default)]
pub(super) struct Losses {
    /// The journal takes nothing more, or is gone: the disk has to keep the MCAP.
    pub(super) has_lost_journal: AtomicBool,
    /// Something could not be handed over: it is in the journal only.
    pub(super) has_dropped: AtomicBool,
}

/// What the thread says about itself.
#[derive(Default)]
pub(super) struct Shared {
    /// Bytes in the files.
    pub(super) bytes: AtomicU64,
    /// Bytes in the present part.
    pub(super) part_bytes: AtomicU64,
    pub(super) done: AtomicU64,
    /// Something waits to be flushed.
    pub(super) is_dirty: AtomicBool,
    pub(super) problem: Mutex<Option<String>>,
}

impl Shared {
    pub(super) fn set_problem(&self, problem: String) {
        let mut told = self.problem.lock().unwrap_or_else(PoisonError::into_inner);
        told.get_or_insert(problem);
    }
}

/// The file, without a buffer, counting.
pub(super) struct Output {
    file: Arc<File>,
    shared: Arc<Shared>,
}

impl Write for Output {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = (&*self.file).write(bytes)?;
        let count = written as u64;
        self.shared.bytes.fetch_add(count, Ordering::Relaxed);
        self.shared.part_bytes.fetch_add(count, Ordering::Relaxed);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

pub(super) struct Worker {
    part: Part,
    file: Arc<File>,
    composer: Option<Composer<Output>>,
    shared: Arc<Shared>,
}

impl Worker {
    /// Begins the first part: when this returns, the disk has it.
    pub(super) fn begin(part: Part, file: File, shared: Arc<Shared>) -> Result<Self, CaptureError> {
        let (composer, file) = begin_part(&part, file, &shared, Deriver::new())?;
        Ok(Self {
            part,
            file,
            composer: Some(composer),
            shared,
        })
    }

    /// Carries out orders until there are no more, then finishes the recording.
    pub(super) fn run(mut self, queue: &Receiver<Order>) -> Result<(), CaptureError> {
        let result = self.carry_out_all(queue);
        if let Err(error) = &result {
            self.shared.set_problem(error.to_string());
        }
        result
    }

    fn carry_out_all(&mut self, queue: &Receiver<Order>) -> Result<(), CaptureError> {
        for order in queue {
            match order {
                Order::Discard => {
                    self.composer = None;
                    for path in [&self.part.paths.partial, &self.part.paths.journal] {
                        remove(path)?;
                    }
                    return Ok(());
                }
                Order::Rotate(next) => {
                    let deriver = self.finish_part()?;
                    if let Some(deriver) = deriver {
                        self.go_on(*next, deriver)?;
                    }
                }
                Order::Entries(bytes) => self.take(&bytes)?,
                Order::Flush(until) => self.flush(until)?,
                Order::Look => self.look()?,
            }
            self.shared.done.fetch_add(1, Ordering::Release);
        }
        self.finish_part().map(|_| ())
    }

    fn take(&mut self, bytes: &[u8]) -> Result<(), CaptureError> {
        let Some(composer) = &mut self.composer else {
            return Ok(());
        };
        for entry in entries(bytes) {
            composer
                .handle_entry(&entry)
                .map_err(|error| write_error(&self.part.paths.partial, error))?;
        }
        self.shared.is_dirty.store(true, Ordering::Release);
        if composer.take_urgent() {
            self.flush(Until::InJournal)?;
        }
        Ok(())
    }

    /// Hands everything to the system and waits for the disk.
    fn flush(&mut self, until: Until) -> Result<(), CaptureError> {
        let Some(composer) = &mut self.composer else {
            return Ok(());
        };
        let is_lost = self.part.losses.has_lost_journal.load(Ordering::Acquire);
        let journal = self.part.journal.as_ref().filter(|_| !is_lost);
        let waits = until == Until::OnDisk || journal.is_none();
        self.shared.is_dirty.store(false, Ordering::Release);
        let journal = journal.map_or(Ok(()), File::sync_data);
        let file = || if waits { self.file.sync_data() } else { Ok(()) };
        composer
            .flush()
            .and_then(|()| file())
            .and(journal)
            .map_err(|error| write_error(&self.part.paths.partial, error))
    }

    /// A recording whose file is gone ends; without its journal it goes on, and says so.
    fn look(&mut self) -> Result<(), CaptureError> {
        if self.composer.is_none() {
            return Ok(());
        }
        let paths = &self.part.paths;
        let journal = self.part.journal.as_ref();
        let journal = journal.map(|journal| presence::check(journal, &paths.journal));
        match (presence::check(&self.file, &paths.partial), journal) {
            (Ok(()), None | Some(Ok(()))) => Ok(()),
            (Ok(()), Some(Err(_))) => {
                let gone = CaptureError::Gone {
                    path: paths.journal.clone(),
                    fate: Fate::NoJournal,
                };
                self.shared.set_problem(gone.to_string());
                let losses = &self.part.losses;
                if losses.has_lost_journal.swap(true, Ordering::AcqRel) {
                    return Ok(());
                }
                // The disk has kept the rest in what is gone.
                self.flush(Until::OnDisk)
            }
            (Err(_), Some(Ok(()))) => Err(CaptureError::Gone {
                path: paths.partial.clone(),
                fate: Fate::InJournal(paths.target.clone()),
            }),
            (Err(gone), None | Some(Err(_))) => Err(gone),
        }
    }

    /// Writes the index, waits for the disk, reads everything back, and only then gives the file its
    /// name and lets the journal go.
    fn finish_part(&mut self) -> Result<Option<Deriver>, CaptureError> {
        self.look()?;
        let Some(composer) = self.composer.take() else {
            return Ok(None);
        };
        let paths = &self.part.paths;
        let received = composer.deriver().rx_bytes();
        let (_, deriver) = composer
            .finish_part()
            .and_then(|done| self.file.sync_all().map(|()| done))
            .map_err(|error| write_error(&paths.partial, error))?;
        if self.part.existing == Existing::Refuse && fs::exists(&paths.target).unwrap_or(false) {
            return Err(CaptureError::Appeared {
                path: paths.target.clone(),
                partial: paths.partial.clone(),
            });
        }
        fs::rename(&paths.partial, &paths.target)
            .map_err(|error| write_error(&paths.partial, error))?;
        recover::sync_folder(&paths.target);
        let losses = &self.part.losses;
        let has_dropped = losses.has_dropped.load(Ordering::Acquire);
        let has_lost_journal = losses.has_lost_journal.load(Ordering::Acquire);
        if self.part.journal.is_none() {
            return Ok(Some(deriver));
        }
        if has_dropped && has_lost_journal {
            return Err(CaptureError::Incomplete {
                path: paths.target.clone(),
            });
        }
        if has_dropped {
            // The journal has what the disk was too slow for.
            recover::rebuild(paths)?;
        } else if recover::received_bytes(&paths.target) == Some(received) {
            remove(&paths.journal)?;
        } else {
            return Err(CaptureError::NotProven {
                path: paths.target.clone(),
                journal: paths.journal.clone(),
            });
        }
        Ok(Some(deriver))
    }

    fn go_on(&mut self, next: Part, deriver: Deriver) -> Result<(), CaptureError> {
        let file = super::create_partial(&next.paths.partial, next.existing)?;
        self.shared.part_bytes.store(0, Ordering::Relaxed);
        let (composer, file) = begin_part(&next, file, &self.shared, deriver)?;
        self.part = next;
        self.file = file;
        self.composer = Some(composer);
        Ok(())
    }
}

fn begin_part(
    part: &Part,
    file: File,
    shared: &Arc<Shared>,
    deriver: Deriver,
) -> Result<(Composer<Output>, Arc<File>), CaptureError> {
    let file = Arc::new(file);
    let output = Output {
        file: Arc::clone(&file),
        shared: Arc::clone(shared),
    };
    Composer::go_on(output, &part.session, deriver)
        .and_then(|composer| file.sync_data().map(|()| (composer, file)))
        .map_err(|error| write_error(&part.paths.partial, error))
}

fn remove(path: &Path) -> Result<(), CaptureError> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(write_error(path, error)),
        _ => Ok(()),
    }
}

pub(super) fn write_error(path: &Path, error: io::Error) -> CaptureError {
    CaptureError::Write {
        path: PathBuf::from(path),
        error,
    }
}

#[cfg(target_os = "linux")]
#[cfg(test)]
mod tests {
    use super::super::super::journal::JournalWriter;
    use super::super::super::messages::StationEvent;
    use crate::event::{Level, NoticeCode};

    use super::super::Recorder;
    use super::*;
    use crate::event::Moment;
    use std::collections::BTreeMap;
    use std::sync::mpsc::{SyncSender, sync_channel};
    use std::time::{Duration, UNIX_EPOCH};

    fn session() -> Session {
        Session {
            link: "radio".to_owned(),
            start: UNIX_EPOCH,
            notes: BTreeMap::new(),
            configuration: String::new(),
        }
    }

    /// A worker whose MCAP is one that no disk can be made to keep: a flush that waits for it fails.
    fn worker(folder: &Path, shared: &Arc<Shared>) -> Worker {
        let paths = Paths::of(&folder.join("a.mcap"));
        let journal = JournalWriter::create(&paths.journal).unwrap();
        let part = Part {
            session: session(),
            existing: Existing::Refuse,
            journal: journal.handle().ok(),
            losses: Arc::default(),
            paths: paths.clone(),
        };
        let file = super::super::create_partial(&paths.partial, Existing::Refuse).unwrap();
        let mut worker = Worker::begin(part, file, Arc::clone(shared)).unwrap();
        worker.file = Arc::new(File::options().write(true).open("/dev/null").unwrap());
        worker
    }

    fn note(text: &str) -> StationEvent {
        StationEvent::notice(NoticeCode::Other, Level::Info, text)
    }

    #[test]
    fn without_its_journal_the_disk_keeps_the_mcap_with_every_flush() {
        let folder = tempfile::tempdir().unwrap();
        let shared = Arc::<Shared>::default();
        let mut worker = worker(folder.path(), &shared);
        assert!(
            worker.flush(Until::OnDisk).is_err(),
            "it waits for the MCAP"
        );
        worker.look().unwrap();
        worker.flush(Until::InJournal).unwrap();
        fs::remove_file(folder.path().join("a.mcap.journal")).unwrap();
        assert!(worker.look().is_err(), "what waits is kept at once");
        assert!(shared.problem.lock().unwrap().is_some());
        assert!(worker.flush(Until::InJournal).is_err());
        worker.look().unwrap();
    }

    /// Orders go nowhere until the first sender, which is returned, gets them.
    fn stall(recorder: &mut Recorder, orders_max: usize) -> (SyncSender<Order>, Receiver<Order>) {
        let (orders, queue) = sync_channel(orders_max);
        (recorder.orders.replace(orders).unwrap(), queue)
    }

    fn go_on(recorder: &mut Recorder, (orders, queue): (SyncSender<Order>, Receiver<Order>)) {
        for order in queue.try_iter() {
            orders.send(order).unwrap();
        }
        recorder.orders = Some(orders);
    }

    fn logs(path: &Path) -> usize {
        let bytes = fs::read(path).unwrap();
        let messages = mcap::MessageStream::new(&bytes).unwrap();
        messages
            .filter(|message| message.as_ref().unwrap().channel.topic == "/log")
            .count()
    }

    /// The disk stalls while one part is finished, and the next has begun: each is made anew for what it lacks itself.
    #[test]
    fn what_a_part_lacks_is_not_charged_to_the_one_before() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.mcap");
        let rotation = "1h".parse().unwrap();
        let mut recorder =
            Recorder::start_rotating(&path, Existing::Refuse, &session(), rotation).unwrap();
        recorder.handle_rx(Moment::ZERO, UNIX_EPOCH, b"x\n");
        let later = Duration::from_secs(3601);
        let stalled = stall(&mut recorder, 4);
        recorder.handle_rx(Moment::ZERO + later, UNIX_EPOCH + later, b"y\n");
        assert_ne!(recorder.path(), path, "the second part has begun");
        let event = note("said");
        recorder.handle_event(Moment::ZERO + later, UNIX_EPOCH + later, &event);
        assert_eq!(recorder.dropped(), 1);
        go_on(&mut recorder, stalled);
        let second = recorder.path();
        recorder.finish().unwrap();
        assert_eq!((logs(&path), logs(&second)), (1, 2));
        assert!(!Paths::of(&second).are_interrupted());
    }

    /// Neither file has everything: the one that has more is not written over.
    #[test]
    fn a_journal_that_ends_early_replaces_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.mcap");
        let mut recorder = Recorder::start(&path, Existing::Refuse, &session()).unwrap();
        let stalled = stall(&mut recorder, 0);
        let dropped = note("dropped");
        recorder.handle_event(Moment::ZERO, UNIX_EPOCH, &dropped);
        assert_eq!(recorder.dropped(), 1);
        go_on(&mut recorder, stalled);
        recorder.journal.fail();
        let event = note("said");
        for _ in 0..3 {
            recorder.handle_event(Moment::ZERO, UNIX_EPOCH, &event);
        }
        let error = recorder.finish().unwrap_err();
        assert!(matches!(error, CaptureError::Incomplete { .. }), "{error}");
        assert_eq!(logs(&path), 4);
        let recovery = recover::recover(&path).unwrap();
        assert_eq!(recovery.path, folder.path().join("a.interrupted.mcap"));
        assert_eq!(logs(&recovery.path), 2, "what was dropped is there");
        assert_eq!(logs(&path), 4);
    }

    #[test]
    fn a_journal_that_takes_no_more_is_told_of() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.mcap");
        let mut recorder = Recorder::start(&path, Existing::Refuse, &session()).unwrap();
        recorder.handle_rx(Moment::ZERO, UNIX_EPOCH, b"x\n");
        let has_lost =
            |recorder: &Recorder| recorder.losses.has_lost_journal.load(Ordering::Acquire);
        assert!(!has_lost(&recorder));
        recorder.journal.fail();
        recorder.handle_rx(Moment::ZERO + Duration::from_secs(1), UNIX_EPOCH, b"y\n");
        assert!(has_lost(&recorder));
    }
}
