//! Records a session to MCAP on a thread of its own.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use ::mcap::{McapError, McapResult};
use groundwave_protocol::decoder::Received;
use groundwave_protocol::letters::Bump;
use groundwave_protocol::telemetry::Body;

use super::error::create;
use super::mcap::{McapWriter, Topic};
use super::messages::{RawBytes, Telemetry};
use super::robot_clock::RobotClock;
use super::{CaptureError, Existing, name};
use crate::event::Moment;

/// The most that a power cut takes from a recording.
const FLUSH_PERIOD: Duration = Duration::from_secs(10);

/// A disk may stall for minutes at 3 lines a second before anything is dropped.
const QUEUE_LENGTH: usize = 1024;

/// What a recording says about itself from the start.
#[derive(Clone, Debug)]
pub struct Session {
    /// The link as the operator named it.
    pub link: String,
    /// When recording began.
    pub start: SystemTime,
    /// Anything else worth keeping: world, seed, command line.
    pub notes: BTreeMap<String, String>,
}

impl Session {
    fn metadata(&self) -> BTreeMap<String, String> {
        let mut metadata = self.notes.clone();
        metadata.insert("link".into(), self.link.clone());
        metadata.insert("start".into(), name::utc(self.start));
        metadata.insert("software".into(), "groundwave".into());
        metadata.insert("software_version".into(), env!("CARGO_PKG_VERSION").into());
        metadata
    }
}

enum Order {
    Bytes {
        topic: Topic,
        log_time_ns: u64,
        bytes: RawBytes,
    },
    Line {
        log_time_ns: u64,
        received: Box<Received>,
    },
    Flush,
    Discard,
}

#[derive(Default)]
struct Shared {
    bytes: AtomicU64,
    done: AtomicU64,
    problem: Mutex<Option<String>>,
}

/// A recording under way.
///
/// Nothing here blocks or fails: what the disk does happens on the recorder's thread, and what went
/// wrong is told by [`Self::problem`]. The file is called `NAME.partial` until [`Self::finish`], or
/// until the recorder is dropped.
pub struct Recorder {
    path: PathBuf,
    orders: Option<SyncSender<Order>>,
    thread: Option<JoinHandle<Result<(), CaptureError>>>,
    shared: Arc<Shared>,
    rx_bytes: u64,
    tx_bytes: u64,
    queued: u64,
    dropped: u64,
    flush_at: Option<Moment>,
    was_bumped: bool,
}

impl Recorder {
    /// Creates the file, writes what a reader needs first and waits until the disk has it.
    ///
    /// # Errors
    /// When the file or its `.partial` exists and may not be touched, or cannot be written.
    pub fn start(
        path: impl Into<PathBuf>,
        existing: Existing,
        session: &Session,
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
        let partial = partial(&path);
        let shared = Arc::<Shared>::default();
        let output = Output {
            file: Arc::new(create(&partial, existing, false)?),
            shared: Arc::clone(&shared),
        };
        let file = Arc::clone(&output.file);
        let writer = begin(output, session)
            .and_then(|writer| Ok(file.sync_data().map(|()| writer)?))
            .map_err(|error| write_error(&partial, error))?;
        let (orders, queue) = sync_channel(QUEUE_LENGTH);
        let worker = Worker {
            writer,
            file,
            clock: RobotClock::default(),
            robot: BTreeMap::new(),
        };
        let thread = {
            let (path, shared) = (path.clone(), Arc::clone(&shared));
            thread::Builder::new()
                .name("recorder".into())
                .spawn(move || {
                    let result = worker.run(&queue, &shared, &path, &partial, existing);
                    if let Err(error) = &result {
                        *shared
                            .problem
                            .lock()
                            .unwrap_or_else(PoisonError::into_inner) = Some(error.to_string());
                    }
                    result
                })
        };
        let thread = thread.map_err(|error| CaptureError::Create {
            path: path.clone(),
            error,
        })?;
        Ok(Self {
            path,
            orders: Some(orders),
            thread: Some(thread),
            shared,
            rx_bytes: 0,
            tx_bytes: 0,
            queued: 0,
            dropped: 0,
            flush_at: None,
            was_bumped: false,
        })
    }

    /// Records bytes from the radio, read at `wall`.
    pub fn handle_rx(&mut self, now: Moment, wall: SystemTime, bytes: &[u8]) {
        let stream_offset = self.rx_bytes;
        self.rx_bytes += bytes.len() as u64;
        self.record_bytes(now, wall, Topic::RawRx, stream_offset, bytes);
    }

    /// Records bytes to the radio, sent at `wall`.
    pub fn handle_tx(&mut self, now: Moment, wall: SystemTime, bytes: &[u8]) {
        let stream_offset = self.tx_bytes;
        self.tx_bytes += bytes.len() as u64;
        self.record_bytes(now, wall, Topic::RawTx, stream_offset, bytes);
    }

    /// Records what an intact line says. A bump goes to the disk at once.
    pub fn handle_line(&mut self, now: Moment, wall: SystemTime, received: &Received) {
        self.push(
            now,
            Order::Line {
                log_time_ns: since_1970_ns(wall),
                received: Box::new(*received),
            },
        );
        if let Received::Line(line, _) = received
            && let Body::State(state) = &line.body
        {
            let bumped = !matches!(state.bump, Bump::None | Bump::NotFitted);
            if bumped && !self.was_bumped {
                self.flush();
            }
            self.was_bumped = bumped;
        }
    }

    /// When [`Self::handle_timeout`] wants to be called; `None` when the disk has everything.
    #[must_use]
    pub const fn poll_timeout(&self) -> Option<Moment> {
        self.flush_at
    }

    /// Flushes what has waited long enough.
    pub fn handle_timeout(&mut self, now: Moment) {
        if self.flush_at.is_some_and(|at| now >= at) {
            self.flush();
        }
    }

    /// The name the recording will have.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Bytes in the file.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.shared.bytes.load(Ordering::Relaxed)
    }

    /// Messages that wait for the disk.
    #[must_use]
    pub fn backlog(&self) -> u64 {
        self.queued - self.shared.done.load(Ordering::Acquire)
    }

    /// Messages that the disk was too slow for. Dropped bytes leave a step in `stream_offset`.
    #[must_use]
    pub const fn dropped(&self) -> u64 {
        self.dropped
    }

    /// Why recording has ended, if it has.
    #[must_use]
    pub fn problem(&self) -> Option<String> {
        self.shared
            .problem
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .clone()
    }

    /// Writes the index, waits until the disk has everything and gives the recording its name; returns
    /// the bytes in the file.
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
        self.orders = None;
        self.thread.take().map_or(Ok(()), |thread| {
            thread.join().unwrap_or_else(|_| {
                Err(write_error(
                    &self.path,
                    McapError::Io(io::Error::other("the recorder stopped unexpectedly")),
                ))
            })
        })
    }

    fn record_bytes(
        &mut self,
        now: Moment,
        wall: SystemTime,
        topic: Topic,
        stream_offset: u64,
        bytes: &[u8],
    ) {
        if bytes.is_empty() {
            return;
        }
        self.push(
            now,
            Order::Bytes {
                topic,
                log_time_ns: since_1970_ns(wall),
                bytes: RawBytes {
                    stream_offset,
                    data: bytes.to_vec(),
                },
            },
        );
    }

    fn push(&mut self, now: Moment, order: Order) {
        self.handle_timeout(now);
        if self.try_push(order) {
            self.flush_at.get_or_insert(now + FLUSH_PERIOD);
        } else {
            self.dropped += 1;
        }
    }

    fn flush(&mut self) {
        // A full queue is flushed when it has become shorter.
        if self.try_push(Order::Flush) {
            self.flush_at = None;
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

struct Worker {
    writer: McapWriter<Output>,
    file: Arc<File>,
    clock: RobotClock,
    robot: BTreeMap<String, String>,
}

impl Worker {
    fn run(
        mut self,
        queue: &Receiver<Order>,
        shared: &Shared,
        path: &Path,
        partial: &Path,
        existing: Existing,
    ) -> Result<(), CaptureError> {
        for order in queue {
            if matches!(order, Order::Discard) {
                return fs::remove_file(partial)
                    .map_err(|error| write_error(partial, error.into()));
            }
            self.carry_out(order)
                .map_err(|error| write_error(partial, error))?;
            shared.done.fetch_add(1, Ordering::Release);
        }
        self.writer
            .finish()
            .and_then(|_| Ok(self.file.sync_all()?))
            .map_err(|error| write_error(partial, error))?;
        if existing == Existing::Refuse && fs::exists(path).unwrap_or(false) {
            return Err(CaptureError::Appeared {
                path: path.to_owned(),
                partial: partial.to_owned(),
            });
        }
        fs::rename(partial, path).map_err(|error| write_error(partial, error.into()))
    }

    fn carry_out(&mut self, order: Order) -> McapResult<()> {
        match order {
            Order::Bytes {
                topic,
                log_time_ns,
                bytes,
            } => self.writer.write(topic, log_time_ns, None, &bytes),
            Order::Line {
                log_time_ns,
                received,
            } => {
                self.introduce_robot(&received)?;
                let robot_ns = self.clock.handle_line(log_time_ns, &received);
                let message = Telemetry::from(&*received);
                self.writer
                    .write(Topic::Telemetry, log_time_ns, robot_ns, &message)
            }
            Order::Flush => {
                self.writer.flush()?;
                Ok(self.file.sync_data()?)
            }
            Order::Discard => Ok(()),
        }
    }

    /// Says who the robot is, when a line first does and whenever that changes.
    fn introduce_robot(&mut self, received: &Received) -> McapResult<()> {
        let Received::Line(line, _) = received else {
            return Ok(());
        };
        let Body::Counters(counters) = &line.body else {
            return Ok(());
        };
        let version = counters.version;
        let robot = BTreeMap::from([
            ("robot_id".to_owned(), counters.robot_id.to_string()),
            (
                "firmware_version".to_owned(),
                format!("{}.{:02}", version.major, version.minor),
            ),
        ]);
        if robot == self.robot {
            return Ok(());
        }
        self.robot.clone_from(&robot);
        self.writer.write_metadata("robot", robot)
    }
}

fn begin(output: Output, session: &Session) -> McapResult<McapWriter<Output>> {
    let mut writer = McapWriter::new(output)?;
    writer.write_metadata("session", session.metadata())?;
    Ok(writer)
}

fn partial(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".partial");
    name.into()
}

fn since_1970_ns(wall: SystemTime) -> u64 {
    let since_1970 = wall.duration_since(UNIX_EPOCH).unwrap_or_default();
    u64::try_from(since_1970.as_nanos()).unwrap_or(u64::MAX)
}

fn write_error(path: &Path, error: McapError) -> CaptureError {
    CaptureError::Write {
        path: path.to_owned(),
        error: match error {
            McapError::Io(error) => error,
            error => io::Error::other(error),
        },
    }
}

/// The file, without a buffer, counting.
struct Output {
    file: Arc<File>,
    shared: Arc<Shared>,
}

impl Write for Output {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = (&*self.file).write(bytes)?;
        self.shared
            .bytes
            .fetch_add(written as u64, Ordering::Relaxed);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
