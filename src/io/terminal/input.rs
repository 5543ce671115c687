//! The input of the terminal: keys, clicks, pastes and sizes as events.

use std::io;
#[cfg(unix)]
use std::io::{IsTerminal, Read};
#[cfg(unix)]
use std::sync::atomic::{AtomicUsize, Ordering};
#[cfg(unix)]
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
#[cfg(unix)]
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
#[cfg(unix)]
use std::time::Instant;

use crossterm::event::Event;
#[cfg(unix)]
use crossterm::event::{KeyCode, KeyEvent, KeyModifiers, MouseEventKind};
#[cfg(unix)]
use crossterm::terminal;
#[cfg(unix)]
use tokio::signal::unix::{SignalKind, signal};

#[cfg(unix)]
use super::escape::Reader;
use super::events::{EVENTS_MAX, Events};

/// Maximum number of bytes that wait to become events. Beyond it each read keeps one of each of [`FLOOD_KEYS`] and nothing else.
#[cfg(unix)]
const WAITING_MAX: usize = 16 << 10;

/// Number of waiting events from which moves of the mouse are dropped.
#[cfg(unix)]
const LATE: usize = 64;

/// Keys that a flood of others must not hide, with their bytes: Ctrl-C, and STOP as Ctrl-S and Space.
#[cfg(unix)]
const FLOOD_KEYS: [(u8, char, KeyModifiers); 3] = [
    (0x03, 'c', KeyModifiers::CONTROL),
    (0x13, 's', KeyModifiers::CONTROL),
    (b' ', ' ', KeyModifiers::NONE),
];

/// Keys, clicks, pastes and sizes; must be called within the runtime.
///
/// # Errors
/// If the system refuses.
pub fn events() -> io::Result<Events> {
    let (sender, receiver) = tokio::sync::mpsc::channel(EVENTS_MAX);
    #[cfg(unix)]
    {
        let mut resized = signal(SignalKind::window_change())?;
        let sizes = sender.clone();
        tokio::spawn(async move {
            while resized.recv().await.is_some() {
                if let Ok((width, height)) = terminal::size()
                    && sizes.send(Event::Resize(width, height)).await.is_err()
                {
                    return;
                }
            }
        });
        let (sending, bytes) = channel();
        let waiting = Arc::new(AtomicUsize::new(0));
        let chunks = Chunks {
            sending,
            waiting: Arc::clone(&waiting),
            reader: Reader::new(Instant::now()),
        };
        if taker().replace(chunks).is_none() {
            let input = open()?;
            thread::spawn(move || read_chunks(input));
        }
        thread::spawn(move || read_events(&bytes, &waiting, &sender));
    }
    #[cfg(not(unix))]
    thread::spawn(move || {
        while let Ok(event) = crossterm::event::read() {
            if sender.blocking_send(event).is_err() {
                return;
            }
        }
    });
    Ok(Events::new(receiver))
}

/// Standard input if it is a terminal, otherwise the terminal of the process.
#[cfg(unix)]
fn open() -> io::Result<Box<dyn Read + Send>> {
    Ok(if io::stdin().is_terminal() {
        Box::new(io::stdin())
    } else {
        Box::new(std::fs::File::open("/dev/tty")?)
    })
}

/// Sender to the dashboard shown last, which gets the terminal's bytes. A waiting read cannot be ended, so one thread reads for all
/// dashboards of the process; two threads would each get a part of the keys.
#[cfg(unix)]
static TAKER: Mutex<Option<Chunks>> = Mutex::new(None);

#[cfg(unix)]
fn taker() -> MutexGuard<'static, Option<Chunks>> {
    TAKER.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Bytes on their way to become events.
#[cfg(unix)]
struct Chunks {
    sending: Sender<Vec<u8>>,
    /// Number of bytes that wait.
    waiting: Arc<AtomicUsize>,
    /// Reads all bytes, to find the sequences of the kitty keyboard protocol for [`FLOOD_KEYS`] in a flood.
    reader: Reader,
}

#[cfg(unix)]
impl Chunks {
    fn take(&mut self, now: Instant, bytes: &[u8]) {
        let events = self.reader.handle_bytes(now, bytes);
        let is_flooded = self.waiting.load(Ordering::Relaxed) >= WAITING_MAX;
        let chunk: Vec<u8> = if is_flooded {
            let keys = FLOOD_KEYS.into_iter();
            let is_pressed = |&(byte, c, modifiers): &(u8, char, KeyModifiers)| {
                let key = KeyEvent::new(KeyCode::Char(c), modifiers);
                bytes.contains(&byte) || events.contains(&Event::Key(key))
            };
            keys.filter(is_pressed).map(|(byte, ..)| byte).collect()
        } else {
            bytes.to_vec()
        };
        if chunk.is_empty() {
            return;
        }
        self.waiting.fetch_add(chunk.len(), Ordering::Relaxed);
        // The dashboard may be gone.
        let _ = self.sending.send(chunk);
    }
}

/// Reads the terminal until it is closed.
#[cfg(unix)]
fn read_chunks(mut input: impl Read) {
    let mut buffer = [0; 1024];
    loop {
        match input.read(&mut buffer) {
            Ok(count @ 1..) => {
                // Keys between two dashboards are dropped.
                if let Some(taker) = &mut *taker() {
                    taker.take(Instant::now(), buffer.get(..count).unwrap_or_default());
                }
            }
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Ok(0) | Err(_) => {
                *taker() = None;
                return;
            }
        }
    }
}

/// Converts bytes, and silences after unfinished sequences, to events.
#[cfg(unix)]
fn read_events(
    bytes: &Receiver<Vec<u8>>,
    waiting: &AtomicUsize,
    sender: &tokio::sync::mpsc::Sender<Event>,
) {
    let mut reader = Reader::new(Instant::now());
    loop {
        let read = match reader.poll_timeout() {
            Some(at) => bytes.recv_timeout(at.saturating_duration_since(Instant::now())),
            None => bytes.recv().map_err(RecvTimeoutError::from),
        };
        let mut length = 0;
        let events = match read {
            Ok(chunk) => {
                length = chunk.len();
                reader.handle_bytes(Instant::now(), &chunk)
            }
            Err(RecvTimeoutError::Timeout) => reader.end(Instant::now()),
            Err(RecvTimeoutError::Disconnected) => return,
        };
        for event in events {
            let is_late =
                sender.max_capacity() - sender.capacity() >= LATE.min(sender.max_capacity());
            if !(is_late && is_motion(&event)) && sender.blocking_send(event).is_err() {
                return;
            }
        }
        waiting.fetch_sub(length, Ordering::Relaxed);
    }
}

/// Whether it is a move of the mouse or a turn of its wheel, which are of no use later.
#[cfg(unix)]
const fn is_motion(event: &Event) -> bool {
    let Event::Mouse(mouse) = event else {
        return false;
    };
    !matches!(mouse.kind, MouseEventKind::Down(_) | MouseEventKind::Up(_))
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::time::Duration;

    /// Timeout of a test that hangs.
    const PATIENCE: Duration = Duration::from_secs(30);

    #[test]
    fn stop_is_taken_in_a_flood_of_keys_that_nobody_handles() {
        let (sending, bytes) = channel();
        let waiting = Arc::default();
        let now = Instant::now();
        let reader = Reader::new(now);
        let mut chunks = Chunks {
            sending,
            waiting,
            reader,
        };
        for _ in 0..1000 {
            chunks.take(now, &[b'+'; 1024]);
        }
        let waiting: usize = bytes.try_iter().map(|chunk| chunk.len()).sum();
        assert!(waiting <= WAITING_MAX + 1024, "{waiting} bytes");
        for stop in [b' ', 0x13] {
            chunks.take(now, &[b'+', stop, b'-']);
            let last = bytes.try_iter().last().unwrap_or_default();
            assert_eq!(last, [stop], "STOP is taken, other keys are not");
            chunks.take(now, &[stop; 1024]);
            let count: usize = bytes.try_iter().map(|chunk| chunk.len()).sum();
            assert_eq!(count, 1, "once for each read");
        }
        for (parts, stop) in [
            (&["+\x1b[115;5u+"][..], 0x13),
            (&["+\x1b[115:83;197:1u"], 0x13),
            (&["+\x1b[11", "5;5u+"], 0x13),
            (&["+\x1b[32u"], b' '),
        ] {
            for part in parts {
                chunks.take(now, part.as_bytes());
            }
            let taken: Vec<u8> = bytes.try_iter().flatten().collect();
            assert_eq!(taken, [stop], "{parts:?}");
        }
        chunks.take(now, b"\x1b[115;5:3u");
        assert_eq!(bytes.try_iter().count(), 0, "a release is not STOP");
    }

    #[test]
    fn turns_of_the_wheel_do_not_wait() {
        let (chunks, bytes) = channel();
        let (sender, mut events) = tokio::sync::mpsc::channel(8);
        let waiting = AtomicUsize::new(usize::MAX);
        let (done, is_done) = channel();
        thread::spawn(move || {
            read_events(&bytes, &waiting, &sender);
            done.send(()).expect("the test waits");
        });
        for _ in 0..1000 {
            chunks
                .send(b"\x1b[<64;50;10M".to_vec())
                .expect("they are read");
        }
        drop(chunks);
        is_done
            .recv_timeout(PATIENCE)
            .expect("no event of the mouse waits");
        let mut count = 0;
        while let Some(event) = events.blocking_recv() {
            assert!(matches!(event, Event::Mouse(_)), "{event:?}");
            count += 1;
        }
        assert_eq!(count, 8);
    }

    #[test]
    fn keys_wait_behind_the_wheel() {
        let (chunks, bytes) = channel();
        let (sender, mut events) = tokio::sync::mpsc::channel(8);
        let waiting = AtomicUsize::new(usize::MAX);
        thread::spawn(move || read_events(&bytes, &waiting, &sender));
        for _ in 0..1000 {
            chunks
                .send(b"\x1b[<64;50;10M".to_vec())
                .expect("they are read");
        }
        chunks.send(b"\x13".to_vec()).expect("it is read");
        drop(chunks);
        let stop = Event::Key(KeyEvent::new(KeyCode::Char('s'), KeyModifiers::CONTROL));
        let mut last = None;
        while let Some(event) = events.blocking_recv() {
            last = Some(event);
        }
        assert_eq!(last, Some(stop));
    }
}
