//! The reader thread: passes every chunk to the sink first, and reopens a lost link.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use groundwave_protocol::LINE_BYTES;
use tokio::sync::mpsc::Sender;

use super::backoff::Backoff;
use super::connection::{Connection, Reading, Reopener};
use super::error::OpenError;
use super::tx_queue::TxQueue;
use super::{LinkInput, Sink};
use crate::event::LinkEvent;
use crate::hint;
use crate::share::{Lines, StationLine, is_announced};

/// Interval between attempts to reopen a lost link.
const RETRY_EVERY: Duration = Duration::from_millis(400);

/// Reopens a lost link; tests have their own implementation.
pub(super) trait Reopen: Send {
    fn open(&mut self) -> Result<Connection, OpenError>;
    /// Whether the end of the link's bytes ends the session.
    fn is_final(&self) -> bool;
    /// Reason shown for an end of file.
    fn end_of_file(&self) -> &'static str;
    /// Waits before the link is opened again.
    fn rest(&mut self, pause: Duration) {
        thread::sleep(pause);
    }
}

impl Reopen for Reopener {
    fn open(&mut self) -> Result<Connection, OpenError> {
        self.open()
    }

    fn is_final(&self) -> bool {
        self.is_final()
    }

    fn end_of_file(&self) -> &'static str {
        self.end_of_file()
    }
}

/// The end of a connection's bytes.
enum End {
    /// The receiver of the link's inputs is closed.
    Closed,
    /// End of file: a closed pty, an unplugged device or the end of standard input.
    Finished,
    Failed(io::Error),
}

pub(super) struct Reader<R> {
    pub(super) reopener: R,
    pub(super) sink: Sink,
    pub(super) inputs: Sender<LinkInput>,
    pub(super) tx_queue: TxQueue,
    /// Whether to deliver every byte at once, for a station that sends in the robot's pauses.
    pub(super) is_eager: Arc<AtomicBool>,
    pub(super) backoff: Backoff,
}

/// The beginning of a connection.
struct Beginning {
    /// The report that the link is open, until it is sent.
    opened: Option<LinkInput>,
    first_byte_at: Option<Instant>,
}

impl<R: Reopen> Reader<R> {
    /// Runs until the station has ended, or a link whose end is final has ended.
    pub(super) fn run(mut self, connection: Connection) {
        let Connection {
            mut reading,
            mut renamed,
            mut share,
            ..
        } = connection;
        let (mut empty, mut is_doubtful) = (0, false);
        loop {
            let mut shared = share.is_some().then(Shared::default);
            let mut beginning = Beginning {
                opened: Some(LinkInput::Opened {
                    renamed,
                    empty,
                    share,
                }),
                first_byte_at: None,
            };
            // After a connection without a byte, the next connection counts as open only with a byte or after a while.
            if !is_doubtful && self.tell_opened(&mut beginning).is_none() {
                return;
            }
            let end = self.read_until_lost(&mut reading, &mut beginning, shared.as_mut());
            // Both halves are closed at once: while a device is open, a returning device cannot get its name.
            self.tx_queue.connect(None);
            drop(reading);
            let reason = match end {
                End::Closed => return,
                End::Finished if self.reopener.is_final() => {
                    // The station may have ended already.
                    self.tell(LinkInput::Ended);
                    return;
                }
                End::Finished if shared.is_some() => LinkEvent::STATION_CLOSED.to_owned(),
                End::Finished => self.reopener.end_of_file().to_owned(),
                End::Failed(error) => describe(&error),
            };
            if beginning.opened.is_none() {
                empty = 0;
                if self.tell(LinkInput::Lost(reason)).is_none() {
                    return;
                }
            }
            is_doubtful = beginning.first_byte_at.is_none();
            empty += u32::from(is_doubtful);
            let brought_for = beginning.first_byte_at.map(|at| at.elapsed());
            self.reopener.rest(self.backoff.handle_end(brought_for));
            let Some(again) = self.reopen(&mut empty) else {
                return;
            };
            self.tx_queue.connect(again.writing);
            (reading, renamed, share) = (again.reading, again.renamed, again.share);
        }
    }

    /// Reports an input; `None` when the station has ended.
    fn tell(&self, input: LinkInput) -> Option<()> {
        self.inputs.blocking_send(input).ok()
    }

    fn tell_opened(&self, beginning: &mut Beginning) -> Option<()> {
        beginning
            .opened
            .take()
            .map_or(Some(()), |opened| self.tell(opened))
    }

    /// Opens the link again, and adds connections to a station that did not welcome this program to `empty`.
    fn reopen(&mut self, empty: &mut u32) -> Option<Connection> {
        let (mut latest, mut reported) = (String::new(), String::new());
        while !self.inputs.is_closed() {
            let mut pause = RETRY_EVERY;
            match self.reopener.open() {
                Ok(connection) => return Some(connection),
                Err(error) if error.is_absence() => {}
                Err(error) => {
                    if matches!(error, OpenError::Share(_)) {
                        *empty += 1;
                        pause = self.backoff.handle_end(None);
                    }
                    // A device that exists but cannot be opened is reported once, at the second attempt: a device that
                    // has just come back has the wrong permissions for a moment.
                    let reason = error.to_string();
                    if reason == latest && reason != reported {
                        reported.clone_from(&reason);
                        self.tell(LinkInput::Lost(reason.clone()))?;
                    }
                    latest = reason;
                }
            }
            self.reopener.rest(pause);
        }
        None
    }

    /// Reads until the connection ends. The sink gets every chunk at once; the station is woken only when a line may be complete,
    /// three times per second instead of sixty.
    fn read_until_lost(
        &mut self,
        reading: &mut Reading,
        beginning: &mut Beginning,
        mut shared: Option<&mut Shared>,
    ) -> End {
        let mut buffer = [0; 4096];
        let mut held = Held::default();
        let end = loop {
            match reading.read(&mut buffer) {
                Ok(0) => break End::Finished,
                Ok(count) => {
                    let (now, bytes) = (Instant::now(), &buffer[..count]);
                    let is_first = beginning.first_byte_at.is_none();
                    beginning.first_byte_at.get_or_insert(now);
                    if is_first && shared.is_none() && self.is_shared_after_all(bytes) {
                        break End::Failed(io::Error::other("it is a shared link"));
                    }
                    let taken = match shared.as_deref_mut() {
                        None => {
                            (self.sink)(now, bytes);
                            held.add(now, bytes);
                            self.tell_opened(beginning)
                        }
                        Some(shared) => self
                            .tell_opened(beginning)
                            .and_then(|()| self.take_lines(shared, now, bytes, &mut held)),
                    };
                    if taken.is_none() {
                        return End::Closed;
                    }
                    let is_eager = self.is_eager.load(Ordering::Relaxed);
                    if (is_eager || held.may_be_whole) && self.hand_over(&mut held).is_none() {
                        return End::Closed;
                    }
                }
                Err(error) => match error.kind() {
                    io::ErrorKind::Interrupted => {}
                    io::ErrorKind::TimedOut | io::ErrorKind::WouldBlock => {
                        let handed = self.tell_opened(beginning);
                        let handed = handed.and_then(|()| self.hand_over(&mut held));
                        if self.inputs.is_closed() || handed.is_none() {
                            return End::Closed;
                        }
                    }
                    _ => break End::Failed(error),
                },
            }
        };
        match self.hand_over(&mut held) {
            Some(()) => end,
            None => End::Closed,
        }
    }

    /// Whether a link opened as a radio is a shared link whose station announced itself late.
    fn is_shared_after_all(&self, bytes: &[u8]) -> bool {
        !self.reopener.is_final() && is_announced(bytes) == Some(true)
    }

    /// Takes lines from a station that shares its link: bytes from the radio, and answers.
    fn take_lines(
        &mut self,
        shared: &mut Shared,
        now: Instant,
        mut bytes: &[u8],
        held: &mut Held,
    ) -> Option<()> {
        while !bytes.is_empty() {
            let (taken, line) = shared.lines.take(bytes);
            bytes = &bytes[taken..];
            let Ok(Some(line)) = line else { continue };
            match StationLine::parse(&line) {
                Some(StationLine::Received { rx }) => {
                    let whole = shared.whole(&rx.0);
                    if !whole.is_empty() {
                        (self.sink)(now, whole);
                        held.add(now, whole);
                    }
                }
                Some(line) => {
                    self.hand_over(held)?;
                    self.tell(LinkInput::Said(line))?;
                }
                None => {}
            }
        }
        Some(())
    }

    fn hand_over(&self, held: &mut Held) -> Option<()> {
        let Held {
            newest_at, bytes, ..
        } = std::mem::take(held);
        match newest_at {
            Some(at) => self.tell(LinkInput::Bytes(at, bytes)),
            None => Some(()),
        }
    }
}

/// A connection to a station that shares its link.
#[derive(Default)]
struct Shared {
    lines: Lines,
    /// Whether the remainder of the first, partial line has passed.
    is_aligned: bool,
}

impl Shared {
    /// The bytes from the radio without the remainder of the first line, which would count as damaged.
    fn whole<'b>(&mut self, bytes: &'b [u8]) -> &'b [u8] {
        if self.is_aligned {
            return bytes;
        }
        let Some(end) = bytes.iter().position(|&byte| byte == b'\n') else {
            return &[];
        };
        self.is_aligned = true;
        &bytes[end + 1..]
    }
}

/// Bytes passed to the sink but not yet to the station.
#[derive(Default)]
struct Held {
    newest_at: Option<Instant>,
    bytes: Vec<u8>,
    may_be_whole: bool,
}

impl Held {
    fn add(&mut self, at: Instant, bytes: &[u8]) {
        self.newest_at = Some(at);
        self.bytes.extend_from_slice(bytes);
        self.may_be_whole |= bytes.contains(&b'\n') || self.bytes.len() >= LINE_BYTES;
    }
}

fn describe(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::BrokenPipe => "unplugged".to_owned(),
        _ => hint::words(error),
    }
}

#[cfg(test)]
mod tests;
