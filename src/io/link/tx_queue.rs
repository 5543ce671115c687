//! The transmit queue. A device that accepts no bytes delays only the thread that writes to it.

use std::collections::VecDeque;
use std::io::Write;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;

use super::connection::Writing;

/// Maximum number of frames queued for a slow device.
const QUEUE: usize = 8;

/// Frames for the radio, written in order by a thread for each connection.
#[derive(Clone, Default)]
pub(super) struct TxQueue(Arc<Shared>);

#[derive(Default)]
struct Shared {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Default)]
struct State {
    frames: VecDeque<Vec<u8>>,
    /// Number of the connection; the threads of earlier connections end.
    connection: u64,
    is_connected: bool,
    not_taken_bytes: u64,
}

impl TxQueue {
    /// Sets the device to write to, or none. Frames queued for the earlier device are lost, as on a radio.
    pub(super) fn connect(&self, device: Option<Writing>) {
        let mut state = self.0.lock();
        state.frames.clear();
        state.connection += 1;
        state.is_connected = device.is_some();
        let connection = state.connection;
        drop(state);
        self.0.changed.notify_all();
        if let Some(device) = device {
            let shared = Arc::clone(&self.0);
            thread::spawn(move || write(&shared, connection, device));
        }
    }

    /// Queues a frame, without waiting. If the queue is full, the frame is lost, which the protocol repairs.
    pub(super) fn send(&self, frame: &[u8]) {
        let mut state = self.0.lock();
        if !state.is_connected {
            return;
        }
        if state.frames.len() < QUEUE {
            state.frames.push_back(frame.to_vec());
            drop(state);
            self.0.changed.notify_all();
        } else {
            state.not_taken_bytes += frame.len() as u64;
        }
    }

    /// Drops the queued frames, so that the next frame directly follows the current one.
    pub(super) fn clear(&self) {
        let mut state = self.0.lock();
        let bytes: usize = state.frames.drain(..).map(|frame| frame.len()).sum();
        state.not_taken_bytes += bytes as u64;
    }

    /// Number of bytes that a connected device did not accept.
    pub(super) fn not_taken_bytes(&self) -> u64 {
        self.0.lock().not_taken_bytes
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits for the next frame; `None` when the connection is lost.
    fn next(&self, connection: u64) -> Option<Vec<u8>> {
        let is_idle = |state: &mut State| state.connection == connection && state.frames.is_empty();
        let waited = self.changed.wait_while(self.lock(), is_idle);
        let mut state = waited.unwrap_or_else(PoisonError::into_inner);
        if state.connection != connection {
            return None;
        }
        state.frames.pop_front()
    }
}

/// Body of a connection's thread: writes queued frames.
fn write(shared: &Shared, connection: u64, mut device: Writing) {
    while let Some(frame) = shared.next(connection) {
        // The reader reports why the device fails; the next frame may succeed.
        if device.write_all(&frame).is_err() {
            shared.lock().not_taken_bytes += frame.len() as u64;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io;
    use std::sync::mpsc::{Receiver, Sender, channel};
    use std::time::Duration;

    use super::*;

    /// Timeout after which a test counts as hanging.
    const PATIENCE: Duration = Duration::from_secs(20);

    /// A device that reports each frame, and accepts it on command.
    struct Gated {
        asks: Sender<Vec<u8>>,
        permits: Receiver<()>,
    }

    impl Write for Gated {
        fn write(&mut self, frame: &[u8]) -> io::Result<usize> {
            let _ = self.asks.send(frame.to_vec());
            let permit = self.permits.recv();
            permit.map_err(|_| io::Error::from(io::ErrorKind::TimedOut))?;
            Ok(frame.len())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    fn gated() -> (TxQueue, Receiver<Vec<u8>>, Sender<()>) {
        let (asks, asked) = channel();
        let (permit, permits) = channel();
        let queue = TxQueue::default();
        queue.connect(Some(Box::new(Gated { asks, permits })));
        (queue, asked, permit)
    }

    fn next(asked: &Receiver<Vec<u8>>) -> Vec<u8> {
        asked.recv_timeout(PATIENCE).expect("a frame")
    }

    #[test]
    fn frames_are_written_in_order() {
        let (queue, asked, permit) = gated();
        for n in 0..QUEUE as u8 {
            queue.send(&[n]);
            permit.send(()).expect("a device");
        }
        let written: Vec<_> = (0..QUEUE as u8).map(|_| next(&asked)).collect();
        let all: Vec<u8> = (0..QUEUE as u8).collect();
        assert_eq!(written.concat(), all);
        assert_eq!(queue.not_taken_bytes(), 0);
    }

    #[test]
    fn after_clearing_a_frame_waits_only_for_the_one_under_way() {
        let (queue, asked, permit) = gated();
        queue.send(b"under way");
        assert_eq!(next(&asked), b"under way");
        for _ in 0..QUEUE {
            queue.send(b"waits");
        }
        queue.clear();
        queue.send(b"STOP");
        permit.send(()).expect("a device");
        assert_eq!(next(&asked), b"STOP");
        assert_eq!(queue.not_taken_bytes(), (QUEUE * b"waits".len()) as u64);
    }

    #[test]
    fn frames_for_a_lost_device_do_not_reach_the_next() {
        let (queue, asked, _permit) = gated();
        queue.send(b"under way");
        assert_eq!(next(&asked), b"under way");
        queue.send(b"waits");
        queue.connect(None);
        queue.send(b"to nobody");
        let (asks, asked_again) = channel();
        let (_permit, permits) = channel();
        queue.connect(Some(Box::new(Gated { asks, permits })));
        queue.send(b"again");
        assert_eq!(next(&asked_again), b"again");
        assert_eq!(queue.not_taken_bytes(), 0);
    }
}
