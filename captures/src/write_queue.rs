//! Writes a file on its own thread. A stalled disk or pipe stalls no other thread.

use std::io;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;

use super::CaptureError;
use super::event::Moment;

/// Maximum memory of the queue, bytes. A queue without a paced reader may take twice as much.
const WAITING_MAX: u64 = 1 << 24;

/// Memory of a queued item without its content, bytes.
const ITEM_BYTES: u64 = 128;

/// Maximum time for which a reader waits for the file.
const WRITE_PATIENCE: Duration = Duration::from_millis(100);

/// Maximum time without progress of the file for which a reader with a full queue, or the end of a session, waits.
pub(super) const PATIENCE: Duration = Duration::from_secs(5);

/// Time without progress after which a file is reported as stalled.
pub(super) const STALL_PERIOD: Duration = Duration::from_secs(30);

/// Number of written bytes after which threads that wait for a full queue are notified.
const NOTIFY_BYTES: u64 = 1 << 16;

/// Period of the checks. With a slow disk, a power cut costs at most the last 10 s.
const LOOK_PERIOD: Duration = Duration::from_secs(8);

/// Writes the queued items.
pub(super) trait FileWorker: Send + 'static {
    /// A part of the file's content.
    type Item: Send + 'static;

    /// Passes an item to the operating system.
    fn write(&mut self, item: Self::Item) -> Result<(), CaptureError>;

    /// Checks that the file still has its name. Called every eight seconds and on request.
    fn look(&mut self) -> Result<(), CaptureError>;

    /// Finishes the file.
    fn finish(self) -> Result<(), CaptureError>;

    /// Closes the file unfinished, as after a failed write.
    fn leave(self);
}

/// The queue of a file and its thread.
#[derive(Debug)]
pub(super) struct WriteQueue<T> {
    /// File name in error messages.
    path: PathBuf,
    shared: Arc<Shared<T>>,
    progress: Arc<AtomicU64>,
}

impl<T: Send + 'static> WriteQueue<T> {
    /// Starts the thread. `progress` counts the worker's steps of finishing; the end of a session therefore waits for a
    /// slow disk but not for a disk that hangs.
    ///
    /// # Errors
    /// If no thread can be started.
    pub(super) fn start(
        path: PathBuf,
        worker: impl FileWorker<Item = T>,
        progress: Arc<AtomicU64>,
    ) -> io::Result<Self> {
        let shared = Arc::new(Shared::default());
        let of_thread = Arc::clone(&shared);
        thread::Builder::new()
            .name("file writer".into())
            .spawn(move || run(worker, &of_thread))?;
        Ok(Self {
            path,
            shared,
            progress,
        })
    }

    /// Queues an item of `bytes` bytes, and calls [`Self::handle_timeout`] if `now` is given. Never waits. When the queue is full,
    /// the file is given up. After that, and after an error, items are only counted: the file stays an exact prefix of
    /// the stream.
    pub(super) fn push(&self, item: T, bytes: u64, now: Option<Moment>) {
        let mut state = self.shared.lock();
        if state.phase != Phase::Writing {
            return;
        }
        let is_over = self.shared.memory(&state) > 2 * WAITING_MAX;
        state.is_given_up |= is_over && state.is_open();
        self.shared.queue(&mut state, Queued::Item(item, bytes));
        state.taken += bytes;
        if let Some(now) = now {
            self.shared.handle_timeout(&mut state, now);
        }
    }

    /// A handle for [`Pace::wait`].
    pub(super) fn pace(&self) -> Pace<T> {
        Pace(Arc::clone(&self.shared))
    }

    /// Requests a check if the last one was eight seconds ago, and notes a file that makes no progress.
    pub(super) fn handle_timeout(&self, now: Moment) {
        self.shared.handle_timeout(&mut self.shared.lock(), now);
    }

    /// Requests a check after the items queued so far.
    pub(super) fn look(&self) {
        let mut state = self.shared.lock();
        self.shared.queue(&mut state, Queued::Look);
    }

    /// Number of bytes not written, including those of items that were only counted.
    pub(super) fn unwritten(&self) -> u64 {
        self.shared.unwritten(&self.shared.lock())
    }

    /// Number of bytes written.
    pub(super) fn written(&self) -> u64 {
        self.shared.written.load(Ordering::SeqCst)
    }

    /// Whether the file is given up, cannot be written or has lost its name.
    pub(super) fn has_failed(&self) -> bool {
        let state = self.shared.lock();
        state.is_given_up || state.problem.is_some()
    }

    /// Whether the file is given up or was found without progress for 30 s.
    pub(super) fn is_stalled(&self) -> bool {
        let state = self.shared.lock();
        state.problem.is_none() && (state.is_given_up || state.is_stalled())
    }

    /// Reason why writing ended or the file is lost; also set when [`Self::handle_timeout`] found no progress for 30 s.
    pub(super) fn problem(&self) -> Option<String> {
        let state = self.shared.lock();
        if let Some(problem) = &state.problem {
            Some(problem.to_string())
        } else if state.is_given_up {
            Some(self.timed_out("the file accepts no bytes").to_string())
        } else {
            let stalled = || CaptureError::Stalled(self.path.clone()).to_string();
            state.is_stalled().then(stalled)
        }
    }

    /// Writes the queued items and finishes the file; returns the number of bytes written. Waits while there is progress, and
    /// `patience` without progress; three times as long once every byte is written.
    ///
    /// # Errors
    /// The first error since the start, or a file that makes no progress; its thread continues.
    pub(super) fn finish_within(&self, patience: Duration) -> Result<u64, CaptureError> {
        self.end(Phase::Finishing);
        let mut state = self.shared.lock();
        let mut seen = None;
        while state.phase != Phase::Ended && seen != Some(self.progress()) {
            seen = Some(self.progress());
            // A sync of a slow disk has no steps.
            let patience = match self.shared.unwritten(&state) {
                0 => patience * 3,
                _ => patience,
            };
            state = self.shared.wait_while(state, patience, |state| {
                state.phase != Phase::Ended && seen == Some(self.progress())
            });
        }
        if let Some(problem) = state.problem.take() {
            return Err(problem);
        }
        match self.shared.unwritten(&state) {
            0 if state.phase != Phase::Ended => {
                Err(self.timed_out("the disk does not confirm the last bytes"))
            }
            0 => Ok(self.written()),
            bytes => Err(self.timed_out(&format!(
                "the file accepts no bytes, and {bytes} bytes are not in it"
            ))),
        }
    }

    fn progress(&self) -> (u64, u64) {
        (self.written(), self.progress.load(Ordering::Relaxed))
    }

    /// Closes the file unfinished and waits for the thread, unless it hangs.
    pub(super) fn leave(&self) {
        self.end(Phase::Leaving);
        let state = self.shared.lock();
        let ended = (self.shared).wait_while(state, PATIENCE, |state| state.phase != Phase::Ended);
        drop(ended);
    }

    /// Whether the file was finished or left.
    pub(super) fn is_ending(&self) -> bool {
        self.shared.lock().phase != Phase::Writing
    }

    fn end(&self, phase: Phase) {
        let mut state = self.shared.lock();
        if state.phase == Phase::Writing {
            state.phase = phase;
            self.shared.changed.notify_all();
        }
    }

    fn timed_out(&self, text: &str) -> CaptureError {
        CaptureError::Write {
            path: self.path.clone(),
            error: io::Error::new(io::ErrorKind::TimedOut, text),
        }
    }
}

/// Paces the reader that fills a queue.
pub(super) struct Pace<T>(Arc<Shared<T>>);

impl<T> Pace<T> {
    /// Waits until the file contains every item, so that a killed program loses none. A file that takes longer than 100 ms is
    /// waited for again only after it has caught up. With a full queue, waits for room, and gives up the file after 5 s without progress.
    pub(super) fn wait(&self) {
        let shared = &*self.0;
        let mut state = shared.lock();
        let is_ahead = |state: &State<T>| state.is_live() && shared.unwritten(state) > 0;
        state.is_late &= is_ahead(&state);
        if !state.is_late {
            state = shared.wait_while(state, WRITE_PATIENCE, is_ahead);
            state.is_late = is_ahead(&state);
        }
        let is_full = |state: &State<T>| state.is_live() && shared.memory(state) > WAITING_MAX;
        if is_full(&state) {
            state = shared.wait_while(state, PATIENCE, is_full);
            state.is_given_up |= is_full(&state);
        }
    }
}

/// The state, and the condition variable for its changes.
#[derive(Debug)]
struct Shared<T> {
    /// Number of bytes written. Not in the state, because taking the lock for each item costs more than writing it.
    written: AtomicU64,
    /// Number of threads that wait for the writing thread.
    waiters: AtomicU64,
    state: Mutex<State<T>>,
    changed: Condvar,
}

impl<T> Default for Shared<T> {
    fn default() -> Self {
        Self {
            written: AtomicU64::default(),
            waiters: AtomicU64::default(),
            state: Mutex::new(State {
                waiting: Vec::new(),
                taken: 0,
                look_at: None,
                seen: 0,
                seen_since: None,
                seen_at: Moment::ZERO,
                phase: Phase::Writing,
                is_late: false,
                is_idle: false,
                is_given_up: false,
                problem: None,
            }),
            changed: Condvar::new(),
        }
    }
}

impl<T> Shared<T> {
    fn lock(&self) -> MutexGuard<'_, State<T>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn queue(&self, state: &mut State<T>, queued: Queued<T>) {
        if state.is_open() {
            state.waiting.push(queued);
        }
        // Each notification is a system call.
        if state.is_idle {
            self.changed.notify_all();
        }
    }

    fn notify_waiters(&self) {
        if self.waiters.load(Ordering::SeqCst) > 0 {
            // Taken so that no thread is between its check and its sleep.
            drop(self.lock());
            self.changed.notify_all();
        }
    }

    fn handle_timeout(&self, state: &mut State<T>, now: Moment) {
        if now >= *state.look_at.get_or_insert(now + LOOK_PERIOD) {
            state.look_at = Some(now + LOOK_PERIOD);
            self.queue(state, Queued::Look);
        }
        let written = self.written.load(Ordering::SeqCst);
        state.seen_at = now;
        if written != state.seen || written == state.taken {
            state.seen = written;
            state.seen_since = None;
        } else {
            state.seen_since.get_or_insert(now);
        }
    }

    /// Number of bytes of all items that are not written.
    fn unwritten(&self, state: &State<T>) -> u64 {
        state.taken - self.written.load(Ordering::SeqCst)
    }

    fn memory(&self, state: &State<T>) -> u64 {
        self.unwritten(state) + state.waiting.len() as u64 * ITEM_BYTES
    }

    fn wait_while<'a>(
        &'a self,
        state: MutexGuard<'a, State<T>>,
        patience: Duration,
        mut waits: impl FnMut(&State<T>) -> bool,
    ) -> MutexGuard<'a, State<T>> {
        self.waiters.fetch_add(1, Ordering::SeqCst);
        let waited = (self.changed).wait_timeout_while(state, patience, |state| waits(state));
        let (state, _) = waited.unwrap_or_else(PoisonError::into_inner);
        self.waiters.fetch_sub(1, Ordering::SeqCst);
        state
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    Writing,
    /// No more items are accepted, and the file is finished.
    Finishing,
    /// No more items are accepted, and the file is closed unfinished.
    Leaving,
    /// The thread has ended.
    Ended,
}

#[derive(Debug)]
enum Queued<T> {
    /// An item and its length, bytes.
    Item(T, u64),
    /// A request for a check after the earlier items.
    Look,
}

#[derive(Debug)]
struct State<T> {
    waiting: Vec<Queued<T>>,
    /// Number of bytes of all items, including those after the end of writing.
    taken: u64,
    look_at: Option<Moment>,
    /// Number of bytes written at the last timeout.
    seen: u64,
    /// Timeout since which no byte was written, although items wait.
    seen_since: Option<Moment>,
    /// The last timeout.
    seen_at: Moment,
    phase: Phase,
    /// Whether the file kept a reader waiting and has not caught up since.
    is_late: bool,
    /// Whether the thread sleeps.
    is_idle: bool,
    /// Whether the file was given up because it accepted no bytes.
    is_given_up: bool,
    /// Writing failed, or the file was removed or renamed.
    problem: Option<CaptureError>,
}

impl<T> State<T> {
    /// Whether items still go to the file.
    const fn is_open(&self) -> bool {
        !self.has_write_error() && !self.is_given_up
    }

    const fn has_write_error(&self) -> bool {
        matches!(
            self.problem,
            Some(CaptureError::Write { .. } | CaptureError::NothingWritten { .. })
        )
    }

    /// Sets the problem. The first one is kept, but a failed write replaces it.
    fn set_problem(&mut self, problem: CaptureError) {
        if !self.has_write_error() {
            self.problem = Some(problem);
        }
    }

    fn is_stalled(&self) -> bool {
        let since = self.seen_since;
        since.is_some_and(|since| self.seen_at.saturating_sub(since) >= STALL_PERIOD)
    }

    fn is_live(&self) -> bool {
        self.is_open() && self.phase == Phase::Writing
    }
}

/// Body of the thread: writes until the file ends. Holds the lock only between system calls.
fn run<W: FileWorker>(mut worker: W, shared: &Shared<W::Item>) {
    let mut has_failed = false;
    let phase = loop {
        let mut state = shared.lock();
        state.is_idle = true;
        let waited = shared.changed.wait_while(state, |state| {
            state.waiting.is_empty() && state.phase == Phase::Writing
        });
        let mut state = waited.unwrap_or_else(PoisonError::into_inner);
        state.is_idle = false;
        let waiting = std::mem::take(&mut state.waiting);
        let phase = state.phase;
        drop(state);
        let mut silent = 0;
        for queued in waiting {
            if has_failed {
                break;
            }
            let (result, bytes) = match queued {
                Queued::Item(item, bytes) => (worker.write(item), bytes),
                Queued::Look => (worker.look(), 0),
            };
            match result {
                Ok(()) => {
                    shared.written.fetch_add(bytes, Ordering::SeqCst);
                    silent += bytes;
                    if silent >= NOTIFY_BYTES {
                        shared.notify_waiters();
                        silent = 0;
                    }
                }
                Err(error) => {
                    let mut state = shared.lock();
                    state.set_problem(error);
                    has_failed = state.has_write_error();
                }
            }
        }
        shared.notify_waiters();
        if phase != Phase::Writing {
            break phase;
        }
    };
    if has_failed || phase == Phase::Leaving {
        worker.leave();
    } else if let Err(error) = worker.finish() {
        shared.lock().set_problem(error);
    }
    shared.lock().phase = Phase::Ended;
    shared.changed.notify_all();
}

#[cfg(test)]
mod tests;
