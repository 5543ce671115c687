//! Records a session: the journal at once, MCAP on a thread of its own.

mod lookout;
mod worker;

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::sync::mpsc::{SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, SystemTime};

pub use super::composer::Session;

use super::composer::since_1970_ns;
use super::error::create;
use super::journal::{Entry, JournalWriter, Kind};
use super::presence;
use super::recover::{self, Paths};
use super::rotation::{Rotation, part_name};
use super::topics::StationEvent;
use super::{CaptureError, Existing};
use crate::event::Moment;
use lookout::Lookout;
use worker::{Losses, Order, Part, Shared, Until, Worker, write_error};

/// So that a power cut takes no more than the last 10 s, with a disk that needs its time.
const FLUSH_PERIOD: Duration = Duration::from_secs(8);

/// The journal is enough for that. The disk is made to keep the MCAP too only so often: waiting for a disk is most of
/// what a recording costs.
const SYNC_PERIOD: Duration = Duration::from_mins(1);

/// A disk may stall for minutes at 3 lines a second before the MCAP has to be made anew from the journal.
const QUEUE_LENGTH: usize = 1024;

/// What is in the journal waits so long for more before the thread is woken, and then until a line begins: at its end
/// the station has something to do, and no thread shall be in its way.
const HELD_PERIOD: Duration = Duration::from_secs(1);

/// Clumps of bytes that wait at most.
const HELD_MAX: usize = 64;

/// A recording under way.
///
/// What comes in is in the journal, `NAME.journal`, when a call returns. Nothing here fails, and nothing but
/// that one write blocks: what else the disk does happens on the recorder's thread, and what went wrong is
/// told by [`Self::problem`]. The file is called `NAME.partial` until [`Self::finish`], or until the recorder
/// is dropped; then it has been read back, and the journal is gone.
pub struct Recorder {
    /// The name of the first part.
    path: PathBuf,
    existing: Existing,
    session: Session,
    rotation: Rotation,
    part: u32,
    part_since: Option<Moment>,
    journal: JournalWriter,
    /// In the journal, and not yet with the thread: waking it costs more than what it does with a few bytes.
    held: Held,
    lookout: Lookout,
    orders: Option<SyncSender<Order>>,
    thread: Option<JoinHandle<Result<(), CaptureError>>>,
    shared: Arc<Shared>,
    /// Of the present part.
    losses: Arc<Losses>,
    queued: u64,
    dropped: u64,
    flush_at: Option<Moment>,
    look_at: Option<Moment>,
    sync_at: Option<Moment>,
    /// Time of the newest entry, or of the beginning; nanoseconds since 1970.
    last_ns: u64,
    /// Time of the first entry of the part, from which a reader counts.
    first_ns: Option<u64>,
}

/// Entries as they stand in the journal.
#[derive(Default)]
struct Held {
    entries: Vec<u8>,
    count: usize,
    /// When the first of them came.
    since: Option<Moment>,
}

impl Recorder {
    /// Creates the files, writes what a reader needs first and waits until the disk has it.
    ///
    /// An interrupted recording of that name must have been moved away: [`recover::set_aside`].
    ///
    /// # Errors
    /// When the file or its `.partial` or `.journal` exists and may not be touched, or cannot be written.
    pub fn start(
        path: impl Into<PathBuf>,
        existing: Existing,
        session: &Session,
    ) -> Result<Self, CaptureError> {
        Self::start_rotating(path, existing, session, Rotation::default())
    }

    /// Likewise, with parts of another length than a day.
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
        if existing == Existing::Append {
            return Err(CaptureError::CannotAppend(path));
        }
        if existing == Existing::Refuse && fs::exists(&path).unwrap_or(false) {
            return Err(CaptureError::Exists {
                path,
                can_append: false,
            });
        }
        let paths = Paths::of(&path);
        if recover::is_in_use(&paths) {
            return Err(CaptureError::InUse(path));
        }
        let shared = Arc::<Shared>::default();
        let losses = Arc::<Losses>::default();
        let journal = new_journal(&paths, session)?;
        let worker = create_partial(&paths.partial, existing).and_then(|file| {
            let part = Part {
                paths: paths.clone(),
                session: session.clone(),
                existing,
                journal: journal.handle().ok(),
                losses: Arc::clone(&losses),
            };
            Worker::begin(part, file, Arc::clone(&shared)).inspect_err(|_| {
                // It has nothing in it yet that could be lost.
                let _ = fs::remove_file(&paths.partial);
            })
        });
        let (orders, queue) = sync_channel(QUEUE_LENGTH);
        let thread = worker.and_then(|worker| {
            thread::Builder::new()
                .name("recorder".into())
                .spawn(move || worker.run(&queue))
                .map_err(|error| CaptureError::Create {
                    path: path.clone(),
                    error,
                })
        });
        let thread = thread.inspect_err(|_| {
            let _ = fs::remove_file(&paths.journal);
        })?;
        Ok(Self {
            path,
            existing,
            session: session.clone(),
            rotation,
            part: 1,
            part_since: None,
            journal,
            held: Held::default(),
            lookout: Lookout::default(),
            orders: Some(orders),
            thread: Some(thread),
            shared,
            losses,
            queued: 0,
            dropped: 0,
            flush_at: None,
            look_at: None,
            sync_at: None,
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
        self.journal.rx(at_ns, bytes);
        self.hold(now);
        let is_mid_line = !bytes.contains(&b'\n');
        if self.lookout.sees_bump(bytes)
            || self.held.count >= HELD_MAX
            || is_mid_line && self.has_held_for(now, HELD_PERIOD)
        {
            self.hand_over();
        }
        self.handle_timeout(now);
        self.part_since.get_or_insert(now);
        if bytes.ends_with(b"\n") {
            self.rotate_if_due(now, wall);
        }
    }

    /// Records bytes to the radio, sent at `wall`.
    pub fn handle_tx(&mut self, now: Moment, wall: SystemTime, bytes: &[u8]) {
        if bytes.is_empty() {
            return;
        }
        let at_ns = self.time_ns(since_1970_ns(wall));
        self.journal.tx(at_ns, bytes);
        self.hold(now);
        self.hand_over();
        self.handle_timeout(now);
    }

    /// Records an event of the station's. The beginning and the end of a command and an alarm go to the disk
    /// at once, as a bump does.
    pub fn handle_event(&mut self, now: Moment, wall: SystemTime, event: &StationEvent) {
        let entry = Entry::of_event(self.time_ns(since_1970_ns(wall)), event);
        self.journal.entry(&entry);
        self.hold(now);
        self.hand_over();
        self.handle_timeout(now);
    }

    /// Records what was remembered from before it began, oldest first, with its times since 1970. To be
    /// called before anything else; offsets are set here.
    pub fn handle_backlog(&mut self, now: Moment, entries: Vec<Entry>) {
        for mut entry in entries {
            entry.at_ns = self.time_ns(entry.at_ns);
            match entry.kind {
                Kind::Rx => self.journal.rx(entry.at_ns, &entry.data),
                Kind::Tx => self.journal.tx(entry.at_ns, &entry.data),
                Kind::Session | Kind::Event => self.journal.entry(&entry),
            }
            self.hold(now);
        }
        self.hand_over();
        self.handle_timeout(now);
    }

    /// Time of an entry: never before the one before it. Recovery knows an event again by its time, and a recording's
    /// messages have theirs in order.
    fn time_ns(&mut self, at_ns: u64) -> u64 {
        self.last_ns = self.last_ns.max(at_ns);
        self.first_ns.get_or_insert(self.last_ns);
        self.last_ns
    }

    /// When [`Self::handle_timeout`] wants to be called; `None` when the disk has everything.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Moment> {
        let is_dirty = self.held.count > 0
            || self.backlog() > 0
            || self.shared.is_dirty.load(Ordering::Acquire);
        self.flush_at.filter(|_| is_dirty)
    }

    /// Flushes what has waited long enough, and looks now and then whether the files are still there. To be
    /// called every second or so, also while nothing comes in.
    pub fn handle_timeout(&mut self, now: Moment) {
        let is_flush_due = self.flush_at.is_some_and(|at| now >= at);
        if is_flush_due || self.has_held_for(now, 2 * HELD_PERIOD) {
            self.hand_over();
        }
        let look_at = *self.look_at.get_or_insert(now + FLUSH_PERIOD);
        if now >= look_at && self.try_push(Order::Look) {
            self.look_at = Some(now + FLUSH_PERIOD);
        }
        if is_flush_due {
            let is_due = now >= *self.sync_at.get_or_insert(now + SYNC_PERIOD);
            let until = if is_due {
                Until::OnDisk
            } else {
                Until::InJournal
            };
            if self.try_push(Order::Flush(until)) {
                self.flush_at = None;
                self.sync_at = self.sync_at.filter(|_| until == Until::InJournal);
            }
        }
    }

    /// How far into the file under way, as its reader counts, a time of day is; `None` while nothing is in it.
    #[must_use]
    pub fn moment_of(&self, wall: SystemTime) -> Option<Moment> {
        let since_ns = since_1970_ns(wall).saturating_sub(self.first_ns?);
        Some(Moment::from_nanos(since_ns))
    }

    /// The name that the present part will have.
    #[must_use]
    pub fn path(&self) -> PathBuf {
        part_name(&self.path, self.part)
    }

    /// Bytes in the files.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.shared.bytes.load(Ordering::Relaxed)
    }

    /// Orders that wait for the disk.
    #[must_use]
    pub fn backlog(&self) -> u64 {
        self.queued - self.shared.done.load(Ordering::Acquire)
    }

    /// What the disk was too slow for. It is in the journal, and the MCAP is made anew from that in the end.
    #[must_use]
    pub const fn dropped(&self) -> u64 {
        self.dropped
    }

    /// What went wrong, if anything did.
    #[must_use]
    pub fn problem(&self) -> Option<String> {
        let told = self
            .shared
            .problem
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        told.clone().or_else(|| self.journal.problem())
    }

    /// Whether one of its files takes no more: the MCAP, or the journal where it was not taken away.
    #[must_use]
    pub fn has_failed(&self) -> bool {
        self.thread.as_ref().is_some_and(JoinHandle::is_finished) || self.journal.has_failed()
    }

    /// Writes the index, waits until the disk has everything, reads it back and gives the recording its
    /// name; returns the bytes in the files.
    ///
    /// # Errors
    /// Whatever went wrong since the start.
    pub fn finish(mut self) -> Result<u64, CaptureError> {
        self.stop()?;
        Ok(self.bytes())
    }

    /// Leaves nothing behind: for a session that does not begin after all.
    pub fn discard(mut self) {
        if let Some(orders) = &self.orders {
            // A recorder that has failed has said so and reads no more orders.
            let _ = orders.send(Order::Discard);
        }
        let _ = self.stop();
    }

    fn stop(&mut self) -> Result<(), CaptureError> {
        self.hand_over();
        self.orders = None;
        self.thread.take().map_or(Ok(()), |thread| {
            thread.join().unwrap_or_else(|_| {
                Err(write_error(
                    &self.path,
                    io::Error::other("the recorder stopped unexpectedly"),
                ))
            })
        })
    }

    /// At the end of a line, so that no line is torn in two.
    fn rotate_if_due(&mut self, now: Moment, wall: SystemTime) {
        let since = self.part_since.unwrap_or(now);
        let bytes = self.shared.part_bytes.load(Ordering::Relaxed);
        if !self.rotation.is_due(now.saturating_sub(since), bytes) || self.problem().is_some() {
            return;
        }
        let Some((part, paths)) = recover::free_part(&self.path, self.part + 1) else {
            return;
        };
        let mut session = self.session.clone();
        session.start = wall;
        session.notes.insert("part".into(), part.to_string());
        let journal = match new_journal(&paths, &session) {
            Ok(journal) => journal,
            Err(error) => return self.shared.set_problem(error.to_string()),
        };
        let losses = Arc::<Losses>::default();
        let order = Order::Rotate(Box::new(Part {
            paths: paths.clone(),
            session,
            existing: self.existing,
            journal: journal.handle().ok(),
            losses: Arc::clone(&losses),
        }));
        // What belongs to the part under way comes first. It goes on for a while when the disk is behind.
        self.hand_over();
        if self.try_push(order) {
            self.journal = journal;
            self.losses = losses;
            self.part = part;
            self.part_since = Some(now);
            self.first_ns = None;
        } else {
            let _ = fs::remove_file(&paths.journal);
        }
    }

    /// Keeps the entry that has just been written for the thread. The disk has it in good time, whether more comes or not.
    fn hold(&mut self, now: Moment) {
        if self.journal.has_failed() {
            self.losses.has_lost_journal.store(true, Ordering::Release);
        }
        self.held.entries.extend_from_slice(self.journal.latest());
        self.held.count += 1;
        self.held.since.get_or_insert(now);
        self.flush_at.get_or_insert(now + FLUSH_PERIOD);
    }

    fn has_held_for(&self, now: Moment, period: Duration) -> bool {
        self.held
            .since
            .is_some_and(|since| now.saturating_sub(since) >= period)
    }

    fn hand_over(&mut self) {
        if self.held.count == 0 {
            return;
        }
        // The next ones have as many bytes as these.
        let next = Held {
            entries: Vec::with_capacity(self.held.entries.len()),
            ..Held::default()
        };
        let Held { entries, count, .. } = std::mem::replace(&mut self.held, next);
        if !self.try_push(Order::Entries(entries)) {
            self.dropped += count as u64;
            self.losses.has_dropped.store(true, Ordering::Release);
        }
    }

    fn try_push(&mut self, order: Order) -> bool {
        let Some(orders) = &self.orders else {
            return false;
        };
        match orders.try_send(order) {
            Ok(()) => {
                self.queued += 1;
                true
            }
            Err(TrySendError::Full(_)) => false,
            Err(TrySendError::Disconnected(_)) => {
                self.flush_at = None;
                false
            }
        }
    }
}

impl Drop for Recorder {
    fn drop(&mut self) {
        // The problem, if any, has been there for all to see.
        let _ = self.stop();
    }
}

fn new_journal(paths: &Paths, session: &Session) -> Result<JournalWriter, CaptureError> {
    let mut journal = JournalWriter::create(&paths.journal)?;
    let is_gone = |file: File| presence::check(&file, &paths.journal).is_err();
    if journal.handle().is_ok_and(is_gone) {
        // Somebody who took it for an interrupted one was faster.
        return Err(CaptureError::InUse(paths.target.clone()));
    }
    // A table of words is always JSON.
    let about = serde_json::to_vec(session).unwrap_or_default();
    journal.session(since_1970_ns(session.start), &about);
    match journal.take_problem() {
        Some(problem) => {
            let _ = fs::remove_file(&paths.journal);
            Err(problem)
        }
        None => Ok(journal),
    }
}

/// Creates the file that is written, and keeps others from taking it for an interrupted one.
fn create_partial(path: &Path, existing: Existing) -> Result<File, CaptureError> {
    let file = create(path, existing, false)?;
    recover::claim(&file);
    Ok(file)
}
