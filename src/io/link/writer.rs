//! The way to the radio. A device that takes no bytes holds up its own thread and nobody else.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;

use super::connection::Writing;

/// Frames that wait for a slow device.
const QUEUE: usize = 8;

/// Where bytes for the radio go; another connection takes the place of one that is lost.
#[derive(Clone, Debug, Default)]
pub(super) struct Outlet {
    current: Arc<Mutex<Option<Writer>>>,
    not_taken: Arc<AtomicU64>,
}

/// The thread of one connection. It ends by itself, with the device it holds, when it is dropped.
#[derive(Debug)]
struct Writer {
    frames: SyncSender<Vec<u8>>,
    is_lost: Arc<AtomicBool>,
}

impl Drop for Writer {
    fn drop(&mut self) {
        self.is_lost.store(true, Ordering::Relaxed);
    }
}

impl Outlet {
    fn lock(&self) -> MutexGuard<'_, Option<Writer>> {
        self.current.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Sends through this from now on.
    pub(super) fn connect(&self, writing: Option<Writing>) {
        *self.lock() = writing.map(|writing| self.start(writing));
    }

    /// Lets the connection go. Bytes sent until the next one are lost, as on a radio.
    pub(super) fn disconnect(&self) {
        *self.lock() = None;
    }

    /// Never waits.
    pub(super) fn send(&self, bytes: &[u8]) {
        if let Some(writer) = &*self.lock()
            && let Err(TrySendError::Full(_)) = writer.frames.try_send(bytes.to_vec())
        {
            self.count(bytes);
        }
    }

    /// Bytes that a device which was there did not take.
    pub(super) fn not_taken(&self) -> u64 {
        self.not_taken.load(Ordering::Relaxed)
    }

    fn count(&self, bytes: &[u8]) {
        self.not_taken
            .fetch_add(bytes.len() as u64, Ordering::Relaxed);
    }

    fn start(&self, mut writing: Writing) -> Writer {
        let (frames, from_station) = sync_channel::<Vec<u8>>(QUEUE);
        let is_lost = Arc::new(AtomicBool::new(false));
        let writer = Writer {
            frames,
            is_lost: Arc::clone(&is_lost),
        };
        let outlet = self.clone();
        thread::spawn(move || {
            for bytes in from_station {
                if is_lost.load(Ordering::Relaxed) {
                    return;
                }
                // Why it fails is the reader's to find out; the next frame may well be taken.
                if writing.write_all(&bytes).is_err() {
                    outlet.count(&bytes);
                }
            }
        });
        writer
    }
}
