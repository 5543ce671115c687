//! Unsent bytes for one client, in bounded memory.

use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use tokio::sync::Notify;

use super::{GRACE, STOP_GRACE};

/// Maximum unsent bytes of a client: four and a half minutes of the radio.
pub(super) const UNREAD_MAX: usize = 64 * 1024;

#[derive(Debug)]
pub(super) struct Outbox {
    state: Mutex<State>,
    /// Signals bytes to write, or the close.
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
    converses: bool,
    stage: Stage,
    /// End of the time for which the client keeps its place.
    keeps_until: Instant,
    /// The client waits for a command.
    is_busy: bool,
    /// Time of the client's latest line, or of the latest raw bytes that it took.
    active_at: Instant,
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
                converses: false,
                stage: Stage::Open,
                keeps_until: now + GRACE,
                is_busy: false,
                active_at: now,
            }),
            filled: Notify::new(),
            cut: Notify::new(),
        }
    }

    /// Lets the client keep its place for the time of a STOP.
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

    /// Adds bytes from the radio, unless the client gets lines only.
    pub(super) fn add_raw(&self, bytes: &[u8]) {
        let mut state = self.lock();
        if !state.converses {
            self.add(&mut state, bytes);
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

    /// Sends lines only from here on; ends a partial line of raw bytes.
    pub(super) fn end_raw(&self, now: Instant) {
        let mut state = self.lock();
        self.add(&mut state, b"\n");
        if !state.converses {
            state.keeps_until = now + GRACE;
        }
        state.converses = true;
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
        self.lock().converses
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

    /// The client took the bytes written to it. Only raw bytes count as activity: few JSON lines come unasked.
    pub(super) fn taken(&self, now: Instant) {
        if !self.converses() {
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
        outbox.end_raw(Instant::now());
        outbox.add_raw(b"3456");
        outbox.add_line(b"{}\n");
        outbox.close();
        outbox.add_line(b"too late");
        assert_eq!(outbox.next().await, Next::Write(b"A12\n{}\n".to_vec()));
        assert_eq!(outbox.next().await, Next::Close);
    }

    #[tokio::test]
    async fn what_waits_is_bounded() {
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
