//! What waits for one client, in bounded memory.

use std::sync::{Mutex, MutexGuard, PoisonError};

use tokio::sync::Notify;

/// Bytes that wait for a client that does not read: four and a half minutes of the radio.
pub(super) const UNREAD_MAX: usize = 64 * 1024;

#[derive(Debug, Default)]
pub(super) struct Outbox {
    state: Mutex<State>,
    /// Something is to be taken.
    filled: Notify,
    /// Nothing more is written.
    cut: Notify,
}

/// Why nothing more is written to a client, whatever waits for it.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Cut {
    /// It did not read.
    TooSlow { unread_bytes: usize },
    /// Others need its place.
    GaveWay,
}

#[derive(Debug, Default)]
struct State {
    waiting: Vec<u8>,
    converses: bool,
    closes: bool,
    too_slow: bool,
}

/// What a client's writer does next.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Next {
    Write(Vec<u8>),
    Close,
}

impl Outbox {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Bytes from the radio, unless the client converses.
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
        if state.closes || state.too_slow {
            return;
        }
        if state.waiting.len() + bytes.len() > UNREAD_MAX {
            state.too_slow = true;
            self.cut.notify_one();
        } else {
            state.waiting.extend_from_slice(bytes);
            self.filled.notify_one();
        }
    }

    /// Only lines from here on. The line that the radio was in the middle of ends here.
    pub(super) fn end_raw(&self) {
        let mut state = self.lock();
        self.add(&mut state, b"\n");
        state.converses = true;
    }

    pub(super) fn close(&self) {
        self.lock().closes = true;
        self.filled.notify_one();
    }

    /// At once, whatever waits and whether or not anybody reads.
    pub(super) fn cut_off(&self) {
        let mut state = self.lock();
        state.waiting.clear();
        state.closes = true;
        self.cut.notify_one();
    }

    pub(super) fn converses(&self) -> bool {
        self.lock().converses
    }

    /// Waits until something is to be done.
    pub(super) async fn next(&self) -> Next {
        loop {
            {
                let mut state = self.lock();
                if !state.waiting.is_empty() {
                    return Next::Write(std::mem::take(&mut state.waiting));
                }
                if state.closes {
                    return Next::Close;
                }
            }
            self.filled.notified().await;
        }
    }

    /// Waits until nothing more is to be written.
    pub(super) async fn cut(&self) -> Cut {
        self.cut.notified().await;
        let state = self.lock();
        if state.too_slow {
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
        let outbox = Outbox::default();
        outbox.add_raw(b"A12");
        outbox.end_raw();
        outbox.add_raw(b"3456");
        outbox.add_line(b"{}\n");
        outbox.close();
        outbox.add_line(b"too late");
        assert_eq!(outbox.next().await, Next::Write(b"A12\n{}\n".to_vec()));
        assert_eq!(outbox.next().await, Next::Close);
    }

    #[tokio::test]
    async fn what_waits_is_bounded() {
        let outbox = Outbox::default();
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
