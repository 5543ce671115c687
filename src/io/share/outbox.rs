//! Unsent bytes for one client, in bounded memory.

use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use tokio::sync::Notify;

use super::{GRACE, STOP_GRACE};
use crate::share::{RawBytes, StationLine};

/// Maximum number of unsent bytes of a client: four and a half minutes of the radio.
pub(super) const UNREAD_MAX: usize = 64 * 1024;

/// Maximum number of raw bytes in a line; even escaped, they fit into the longest line that a client accepts.
const RAW_MAX: usize = 1024;

#[derive(Debug)]
pub(super) struct Outbox {
    state: Mutex<State>,
    /// Signals that there are bytes to write, or that the connection is closing.
    filled: Notify,
    /// Signals that the client is cut off.
    cut: Notify,
}

/// Reason why a client is cut off; its unsent bytes are dropped.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Cut {
    /// The client did not read.
    TooSlow { unread_bytes: usize },
    /// Another client needs its place.
    GaveWay,
}

#[derive(Debug)]
struct State {
    waiting: Vec<u8>,
    gets: Gets,
    stage: Stage,
    /// End of the time for which the client keeps its place.
    keeps_until: Instant,
    /// Whether the client waits for a command.
    is_busy: bool,
    /// Time of the client's latest line, or of the latest raw bytes that it took.
    active_at: Instant,
}

/// Form in which a client gets data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Gets {
    /// Unchanged bytes from the radio.
    Raw,
    /// Lines.
    Lines,
    /// Lines, including lines with the bytes from the radio.
    LinesAndRaw,
}

#[derive(Debug, PartialEq, Eq)]
enum Stage {
    Open,
    /// The connection ends after the waiting bytes.
    Closing,
    TooSlow,
}

/// The next action of a client's writer.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Next {
    Write(Vec<u8>),
    Close,
}

impl Outbox {
    pub(super) fn new(now: Instant) -> Self {
        Self {
            state: Mutex::new(State {
                waiting: Vec::new(),
                gets: Gets::Raw,
                stage: Stage::Open,
                keeps_until: now + GRACE,
                is_busy: false,
                active_at: now,
            }),
            filled: Notify::new(),
            cut: Notify::new(),
        }
    }

    /// Lets the client keep its place while the robot confirms its STOP.
    pub(super) fn start_stop(&self, now: Instant) {
        self.lock().keeps_until = now + STOP_GRACE;
    }

    /// End of the time for which the client keeps its place.
    pub(super) fn keeps_until(&self) -> Instant {
        self.lock().keeps_until
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds bytes from the radio, in the client's form.
    pub(super) fn add_raw(&self, bytes: &[u8]) {
        let mut state = self.lock();
        match state.gets {
            Gets::Raw => self.add(&mut state, bytes),
            Gets::Lines => {}
            Gets::LinesAndRaw => {
                for part in bytes.chunks(RAW_MAX) {
                    let rx = RawBytes(part.to_vec());
                    let line = StationLine::Received { rx }.to_line();
                    self.add(&mut state, &line);
                }
            }
        }
    }

    pub(super) fn add_line(&self, line: &[u8]) {
        self.add(&mut self.lock(), line);
    }

    fn add(&self, state: &mut State, bytes: &[u8]) {
        if state.stage != Stage::Open {
            return;
        }
        if state.waiting.len() + bytes.len() > UNREAD_MAX {
            state.stage = Stage::TooSlow;
            self.cut.notify_one();
        } else {
            state.waiting.extend_from_slice(bytes);
            self.filled.notify_one();
        }
    }

    /// Sends only lines from now on; ends a partial line of raw bytes.
    pub(super) fn converse(&self, with_raw: bool, now: Instant) {
        let mut state = self.lock();
        self.add(&mut state, b"\n");
        if state.gets == Gets::Raw {
            state.keeps_until = now + GRACE;
        }
        state.gets = if with_raw {
            Gets::LinesAndRaw
        } else {
            Gets::Lines
        };
    }

    pub(super) fn close(&self) {
        self.lock().stage = Stage::Closing;
        self.filled.notify_one();
    }

    /// Cuts the client off at once.
    pub(super) fn cut_off(&self) {
        let mut state = self.lock();
        state.waiting.clear();
        state.stage = Stage::Closing;
        self.cut.notify_one();
    }

    pub(super) fn converses(&self) -> bool {
        self.lock().gets != Gets::Raw
    }

    /// Sets whether the client waits for a command.
    pub(super) fn set_busy(&self, is_busy: bool, now: Instant) {
        let mut state = self.lock();
        if state.is_busy && !is_busy {
            state.keeps_until = now + GRACE;
        }
        state.is_busy = is_busy;
    }

    /// Marks the client as active.
    pub(super) fn touch(&self, now: Instant) {
        self.lock().active_at = now;
    }

    /// Records that the client took its bytes. Only raw bytes count as activity, because other lines are mostly answers.
    pub(super) fn taken(&self, now: Instant) {
        if self.lock().gets != Gets::Lines {
            self.touch(now);
        }
    }

    /// Time of the client's latest activity; `None` if it must keep its place.
    pub(super) fn idle_since(&self) -> Option<Instant> {
        let state = self.lock();
        (!state.is_busy).then_some(state.active_at)
    }

    /// Waits for the next action.
    pub(super) async fn next(&self) -> Next {
        loop {
            {
                let mut state = self.lock();
                if !state.waiting.is_empty() {
                    return Next::Write(std::mem::take(&mut state.waiting));
                }
                if state.stage == Stage::Closing {
                    return Next::Close;
                }
            }
            self.filled.notified().await;
        }
    }

    /// Waits until the client is cut off.
    pub(super) async fn cut(&self) -> Cut {
        self.cut.notified().await;
        let state = self.lock();
        if state.stage == Stage::TooSlow {
            Cut::TooSlow {
                unread_bytes: state.waiting.len(),
            }
        } else {
            Cut::GaveWay
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn raw_bytes_end_where_lines_begin() {
        let outbox = Outbox::new(Instant::now());
        outbox.add_raw(b"A12");
        outbox.converse(false, Instant::now());
        outbox.add_raw(b"3456");
        outbox.add_line(b"{}\n");
        outbox.close();
        outbox.add_line(b"too late");
        assert_eq!(outbox.next().await, Next::Write(b"A12\n{}\n".to_vec()));
        assert_eq!(outbox.next().await, Next::Close);
    }

    #[tokio::test]
    async fn a_client_that_wants_both_gets_raw_bytes_in_lines() {
        let outbox = Outbox::new(Instant::now());
        outbox.converse(true, Instant::now());
        outbox.add_raw(&[b'A', b'"', b'\r', b'\n', 0, 0x7F, 0x80, 0xFF]);
        let long = vec![1; RAW_MAX + 1];
        outbox.add_raw(&long);
        let Next::Write(bytes) = outbox.next().await else {
            panic!("it is open");
        };
        let mut received = Vec::new();
        for line in bytes
            .split(|byte| *byte == b'\n')
            .filter(|line| !line.is_empty())
        {
            assert!(line.len() < crate::share::LINE_MAX, "{}", line.len());
            let Some(StationLine::Received { rx }) = StationLine::parse(line) else {
                panic!("{line:?}");
            };
            received.extend(rx.0);
        }
        let sent = [&[b'A', b'"', b'\r', b'\n', 0, 0x7F, 0x80, 0xFF], &long[..]];
        assert_eq!(received, sent.concat());
    }

    #[tokio::test]
    async fn waiting_bytes_are_bounded() {
        let outbox = Outbox::new(Instant::now());
        for _ in 0..2 * UNREAD_MAX / 80 {
            outbox.add_raw(&[b'x'; 80]);
        }
        let cut = outbox.cut().await;
        let Cut::TooSlow { unread_bytes } = cut else {
            panic!("{cut:?}");
        };
        assert!(
            unread_bytes <= UNREAD_MAX && unread_bytes > UNREAD_MAX - 80,
            "{unread_bytes}"
        );
    }
}
