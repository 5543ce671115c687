//! A robot on the host that gets exactly what the chip's robot got. The chip tells each call and its result; the host
//! repeats the call and compares the result.

use std::collections::VecDeque;
use std::mem::MaybeUninit;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;

use sr04_firmware::robot::Robot;
use sr04_replay::{BOOT, DOWNLINK, Port, boot, perform};

/// A part of what the chip tells.
enum Part {
    Bytes(Vec<u8>),
    Reset,
}

/// What the host's robot has found.
#[derive(Debug)]
pub(crate) struct Found {
    /// Calls with equal results.
    pub(crate) calls: usize,
    /// Bytes to the radio, between two resets.
    pub(crate) sent: Vec<Vec<u8>>,
}

/// The host's robot, in a thread of its own.
pub(crate) struct Mirror {
    parts: Sender<Part>,
    thread: JoinHandle<Result<Found, String>>,
}

impl Mirror {
    pub(crate) fn new() -> Self {
        let (parts, receiver) = channel();
        Self {
            parts,
            thread: std::thread::spawn(|| mirror(receiver)),
        }
    }

    /// Takes what the chip has told.
    pub(crate) fn take(&self, bytes: Vec<u8>) {
        // The thread has ended if it found a difference, which `finish` reports.
        let _ = self.parts.send(Part::Bytes(bytes));
    }

    /// The chip has reset itself, perhaps in the middle of a call.
    pub(crate) fn reset(&self) {
        let _ = self.parts.send(Part::Reset);
    }

    pub(crate) fn finish(self) -> Result<Found, String> {
        drop(self.parts);
        self.thread
            .join()
            .map_err(|_| "the host's robot panicked".to_owned())?
    }
}

/// State of the chip's stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Runs,
    Reset,
    Over,
}

struct Stream {
    parts: Receiver<Part>,
    bytes: VecDeque<u8>,
    state: State,
    difference: Option<String>,
    /// First byte of the latest call, and its results.
    kind: u8,
    results: Vec<u8>,
}

impl Stream {
    /// Whether another byte has come before a reset or the end.
    fn has_byte(&mut self) -> bool {
        while self.bytes.is_empty() && self.state == State::Runs {
            match self.parts.recv() {
                Ok(Part::Bytes(bytes)) => self.bytes.extend(bytes),
                Ok(Part::Reset) => self.state = State::Reset,
                Err(_) => self.state = State::Over,
            }
        }
        !self.bytes.is_empty()
    }

    /// The first byte of the next call.
    fn next_kind(&mut self) -> Option<u8> {
        self.results.clear();
        if !self.has_byte() {
            return None;
        }
        self.kind = self.bytes.front().copied()?;
        Some(self.kind)
    }
}

impl Port for Stream {
    fn read(&mut self) -> u8 {
        if self.has_byte() {
            self.bytes.pop_front().unwrap_or_default()
        } else {
            0
        }
    }

    fn write(&mut self, byte: u8) {
        self.results.push(byte);
        if self.has_byte() {
            let chip = self.bytes.pop_front();
            if chip != Some(byte) {
                self.difference.get_or_insert_with(|| {
                    format!(
                        "result {} of a call {:?}: the chip gives {chip:02x?}, the host {byte:#04x}",
                        self.results.len(),
                        char::from(self.kind)
                    )
                });
            }
        }
    }
}

fn mirror(parts: Receiver<Part>) -> Result<Found, String> {
    let mut stream = Stream {
        parts,
        bytes: VecDeque::new(),
        state: State::Runs,
        difference: None,
        kind: 0,
        results: Vec::new(),
    };
    let mut found = Found {
        calls: 0,
        sent: vec![Vec::new()],
    };
    let mut place: MaybeUninit<Robot> = MaybeUninit::uninit();
    loop {
        match stream.next_kind() {
            Some(BOOT) => {}
            Some(kind) => return Err(format!("the chip begins with {:?}", char::from(kind))),
            None if stream.state == State::Over => return Ok(found),
            None => {
                stream.state = State::Runs;
                found.sent.push(Vec::new());
                continue;
            }
        }
        stream.read();
        let robot = boot(&mut place, &mut stream);
        while let Some(kind) = stream.next_kind() {
            if !perform(robot, &mut stream) {
                return Err("the chip boots without a reset".to_owned());
            }
            if let Some(difference) = stream.difference {
                return Err(format!("call {}: {difference}", found.calls));
            }
            found.calls += 1;
            if kind == DOWNLINK
                && let Some(sent) = found.sent.last_mut()
            {
                sent.extend(stream.results.get(1));
            }
        }
    }
}
