//! The input of the terminal: keys, clicks, pastes and sizes as events.

use std::io;
#[cfg(unix)]
use std::io::{IsTerminal, Read};
#[cfg(unix)]
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
#[cfg(unix)]
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread;
#[cfg(unix)]
use std::time::Instant;

use crossterm::event::Event;
#[cfg(unix)]
use crossterm::terminal;
#[cfg(unix)]
use tokio::signal::unix::{SignalKind, signal};

#[cfg(unix)]
use super::escape::Reader;

/// Receiver of keys, clicks, pastes and sizes; must be called within the runtime.
///
/// # Errors
/// If the system refuses.
pub fn events() -> io::Result<tokio::sync::mpsc::Receiver<Event>> {
    let (sender, receiver) = tokio::sync::mpsc::channel(64);
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
        let (chunks, bytes) = channel();
        if taker().replace(chunks).is_none() {
            let input = open()?;
            thread::spawn(move || read_chunks(input));
        }
        thread::spawn(move || read_events(&bytes, &sender));
    }
    #[cfg(not(unix))]
    thread::spawn(move || {
        while let Ok(event) = crossterm::event::read() {
            if sender.blocking_send(event).is_err() {
                return;
            }
        }
    });
    Ok(receiver)
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
static TAKER: Mutex<Option<Sender<Vec<u8>>>> = Mutex::new(None);

#[cfg(unix)]
fn taker() -> MutexGuard<'static, Option<Sender<Vec<u8>>>> {
    TAKER.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Reads the terminal until it is closed.
#[cfg(unix)]
fn read_chunks(mut input: impl Read) {
    let mut buffer = [0; 1024];
    loop {
        match input.read(&mut buffer) {
            Ok(count @ 1..) => {
                let chunk = buffer.get(..count).unwrap_or_default().to_vec();
                // Keys between two dashboards are dropped.
                let _ = taker().as_ref().map(|taker| taker.send(chunk));
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
fn read_events(bytes: &Receiver<Vec<u8>>, sender: &tokio::sync::mpsc::Sender<Event>) {
    let mut reader = Reader::new(Instant::now());
    loop {
        let read = match reader.poll_timeout() {
            Some(at) => bytes.recv_timeout(at.saturating_duration_since(Instant::now())),
            None => bytes.recv().map_err(RecvTimeoutError::from),
        };
        let events = match read {
            Ok(chunk) => reader.handle_bytes(Instant::now(), &chunk),
            Err(RecvTimeoutError::Timeout) => reader.end(Instant::now()),
            Err(RecvTimeoutError::Disconnected) => return,
        };
        for event in events {
            if sender.blocking_send(event).is_err() {
                return;
            }
        }
    }
}
