//! The way to the radio. A device that takes no bytes holds up its own thread and nobody else.

use std::io::{ErrorKind, Write};
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::mpsc::{SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;

use super::connection::Writing;

/// Frames that wait for a slow device.
const QUEUE: usize = 8;

/// Where bytes for the radio go; another connection takes the place of one that is lost.
#[derive(Clone, Default)]
pub(super) struct Outlet {
    current: Arc<Mutex<Option<Writer>>>,
    not_taken: Arc<AtomicU64>,
}

/// The ways into one connection, and its thread, which ends by itself, with the device it holds, when this is dropped.
struct Writer {
    /// Spares a key the time in which a thread wakes up.
    at_once: Option<Box<dyn Write + Send>>,
    /// What the device did not take at once.
    frames: SyncSender<Vec<u8>>,
    /// Frames that the thread has not done with: others queue up behind them.
    waiting: Arc<AtomicUsize>,
    is_lost: Arc<AtomicBool>,
}

impl Writer {
    /// Hands over what the device takes without being waited for; returns the rest.
    fn write_at_once<'b>(&mut self, mut bytes: &'b [u8]) -> &'b [u8] {
        let is_free = self.waiting.load(Ordering::Acquire) == 0;
        let Some(device) = self.at_once.as_mut().filter(|_| is_free) else {
            return bytes;
        };
        while !bytes.is_empty() {
            match device.write(bytes) {
                Ok(count @ 1..) => bytes = &bytes[count..],
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                // The thread waits for it, or finds out what is wrong.
                Ok(0) | Err(_) => break,
            }
        }
        bytes
    }
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
        let mut current = self.lock();
        let Some(writer) = &mut *current else {
            return;
        };
        let rest = writer.write_at_once(bytes);
        if rest.len() < bytes.len() {
            // Linux hands over what was written to a pseudo-terminal on a thread of its own, which would wait on this core
            // until the next frame is drawn.
            thread::yield_now();
        }
        if rest.is_empty() {
            return;
        }
        writer.waiting.fetch_add(1, Ordering::Relaxed);
        if let Err(TrySendError::Full(_)) = writer.frames.try_send(rest.to_vec()) {
            writer.waiting.fetch_sub(1, Ordering::Relaxed);
            self.count(rest);
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

    fn start(&self, writing: Writing) -> Writer {
        let Writing {
            at_once,
            mut patient,
        } = writing;
        let (frames, from_station) = sync_channel::<Vec<u8>>(QUEUE);
        let waiting = Arc::<AtomicUsize>::default();
        let is_lost = Arc::<AtomicBool>::default();
        let writer = Writer {
            at_once,
            frames,
            waiting: Arc::clone(&waiting),
            is_lost: Arc::clone(&is_lost),
        };
        let outlet = self.clone();
        thread::spawn(move || {
            for bytes in from_station {
                if is_lost.load(Ordering::Relaxed) {
                    return;
                }
                // Why it fails is the reader's to find out; the next frame may well be taken.
                if patient.write_all(&bytes).is_err() {
                    outlet.count(&bytes);
                }
                waiting.fetch_sub(1, Ordering::Release);
            }
        });
        writer
    }
}

#[cfg(test)]
mod tests {
    use std::io;
    use std::sync::mpsc::{Receiver, Sender, channel};
    use std::time::Duration;

    use proptest::prelude::*;

    use super::*;

    /// Nothing here takes this long unless it hangs.
    const PATIENCE: Duration = Duration::from_secs(20);

    /// A device that has so much room at each write, and takes everything of whoever waits.
    struct Device {
        rooms: Vec<usize>,
        takes: Sender<Vec<u8>>,
    }

    impl Write for Device {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            let room = match self.rooms.pop() {
                Some(0) => return Err(ErrorKind::WouldBlock.into()),
                Some(1) => return Err(ErrorKind::Interrupted.into()),
                Some(room) => room,
                None => bytes.len(),
            };
            let count = room.min(bytes.len());
            let _ = self.takes.send(bytes[..count].to_vec());
            Ok(count)
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    fn taken(of: &Receiver<Vec<u8>>, count: usize) -> Vec<u8> {
        let mut bytes = Vec::new();
        while bytes.len() < count {
            bytes.extend(of.recv_timeout(PATIENCE).expect("the rest"));
        }
        bytes
    }

    proptest! {
        /// Whatever the device takes at once: all frames arrive, in order.
        #[test]
        fn frames_keep_their_order_on_both_ways(
            frames in prop::collection::vec(prop::collection::vec(any::<u8>(), 1..20), 1..QUEUE),
            rooms in prop::collection::vec(0_usize..12, 0..20),
        ) {
            let (takes, from_device) = channel();
            let device = |rooms| Device { rooms, takes: takes.clone() };
            let outlet = Outlet::default();
            outlet.connect(Some(Writing {
                at_once: Some(Box::new(device(rooms))),
                patient: Box::new(device(Vec::new())),
            }));
            for frame in &frames {
                outlet.send(frame);
            }
            let all = frames.concat();
            prop_assert_eq!(taken(&from_device, all.len()), all);
            prop_assert_eq!(outlet.not_taken(), 0);
        }
    }

    #[test]
    fn a_device_with_room_has_a_frame_before_sending_returns() {
        let (takes, from_device) = channel();
        let (never, patient_takes) = channel();
        let outlet = Outlet::default();
        outlet.connect(Some(Writing {
            at_once: Some(Box::new(Device {
                rooms: Vec::new(),
                takes,
            })),
            patient: Box::new(Device {
                rooms: Vec::new(),
                takes: never,
            }),
        }));
        outlet.send(b"STOP");
        assert_eq!(from_device.try_recv().as_deref(), Ok(&b"STOP"[..]));
        assert!(patient_takes.try_recv().is_err());
    }
}
