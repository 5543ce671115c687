//! A robot on the host that gets exactly what the chip's robot got. The chip tells each call and its result; the host
//! repeats the call and compares the result.

use std::collections::VecDeque;
use std::mem::MaybeUninit;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;

use sr04_firmware::robot::Robot;
use sr04_replay::{BOOT, DOWNLINK, Port, TICK, boot, perform};

use super::at_pins::{AtPins, Watch};

/// A part of what the chip tells.
enum Part {
    /// Bytes of a millisecond, and what is at the pins then.
    Bytes(Vec<u8>, AtPins),
    Reset,
}

/// What the host's robot has found.
#[derive(Debug)]
pub(crate) struct Found {
    /// Calls with equal results.
    pub(crate) calls: usize,
    /// Bytes to the radio, between two resets.
    pub(crate) sent: Vec<Vec<u8>>,
    pub(crate) late_ticks: usize,
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

    /// Takes what the chip has told in a millisecond.
    pub(crate) fn take(&self, bytes: Vec<u8>, at_pins: AtPins) {
        // The thread has ended if it found a difference, which `finish` reports.
        let _ = self.parts.send(Part::Bytes(bytes, at_pins));
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
    at_pins: AtPins,
    /// Bytes of the latest call and of its results, and whether a reset cut it off.
    call: Vec<u8>,
    results: Vec<u8>,
    is_cut: bool,
}

impl Stream {
    /// Whether another byte has come before a reset or the end.
    fn has_byte(&mut self) -> bool {
        while self.bytes.is_empty() && self.state == State::Runs {
            match self.parts.recv() {
                Ok(Part::Bytes(bytes, at_pins)) => {
                    self.bytes.extend(bytes);
                    self.at_pins = at_pins;
                }
                Ok(Part::Reset) => self.state = State::Reset,
                Err(_) => self.state = State::Over,
            }
        }
        !self.bytes.is_empty()
    }

    /// The first byte of the next call.
    fn next_kind(&mut self) -> Option<u8> {
        self.call.clear();
        self.results.clear();
        self.is_cut = false;
        if !self.has_byte() {
            return None;
        }
        self.bytes.front().copied()
    }
}

impl Port for Stream {
    fn read(&mut self) -> u8 {
        let has_byte = self.has_byte();
        self.is_cut |= !has_byte;
        let byte = self.bytes.pop_front().unwrap_or_default();
        self.call.push(byte);
        byte
    }

    fn write(&mut self, byte: u8) {
        self.results.push(byte);
        let has_byte = self.has_byte();
        self.is_cut |= !has_byte;
        if has_byte {
            let chip = self.bytes.pop_front();
            if chip != Some(byte) {
                self.difference.get_or_insert_with(|| {
                    format!(
                        "result {} of a call {:?}: the chip gives {chip:02x?}, the host {byte:#04x}",
                        self.results.len(),
                        char::from(self.call.first().copied().unwrap_or_default())
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
        at_pins: AtPins::default(),
        call: Vec::new(),
        results: Vec::new(),
        is_cut: false,
    };
    let mut found = Found {
        calls: 0,
        sent: vec![Vec::new()],
        late_ticks: 0,
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
        let mut watch = Watch::default();
        while let Some(kind) = stream.next_kind() {
            let begins = stream.at_pins;
            if !perform(robot, &mut stream) {
                return Err("the chip boots without a reset".to_owned());
            }
            if let Some(difference) = stream.difference {
                return Err(format!("call {}: {difference}", found.calls));
            }
            if kind == TICK && !stream.is_cut {
                found.late_ticks += usize::from(watch.is_late(begins.now_ms));
                watch
                    .compare(&begins, &stream.call, &stream.at_pins, &stream.results)
                    .map_err(|difference| format!("at {} ms: {difference}", begins.now_ms))?;
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
