//! MAVLink's mission upload over the same radio, for comparison.
//!
//! Follows the developer guide at mavlink.io, *Packet Serialization* and *Mission Protocol*:
//!
//! - MAVLink 2 frames: ten bytes of header, the payload without the zeros at its end, two bytes of CRC-16 (MCRF4XX,
//!   seeded with the message's `CRC_EXTRA` at its end). The receiver waits for the start byte and relies on the length
//!   after it.
//! - `MISSION_COUNT`, then for each waypoint in turn `MISSION_REQUEST_INT` from the vehicle and
//!   `MISSION_ITEM_INT` from the ground, then `MISSION_ACK`. Items out of sequence are dropped.
//! - The recommended timeouts: 250 ms for a requested item, 1500 ms for everything else.
//!
//! Open choices favour MAVLink. Retries are unlimited instead of five, because five would seldom suffice on the worse
//! channels. Timers run from the last byte on the wire, not from the moment it was queued. The vehicle answers at once,
//! sends mission messages before waiting telemetry, and repeats a lost `MISSION_ACK` when the last item is repeated.
//! After an item out of sequence it waits for its timer, as PX4 does; a request at once, as in the guide, would double
//! all further items after a doubled one, until the wire is full. The receiver searches the bytes kept because of a
//! wrong length for another start byte. The vehicle does not repeat a request while bytes arrive, and the ground does not
//! queue a message that is still being sent. There are no heartbeats and no signatures. The telemetry, if any, is that
//! of our robot: 80 bytes three times per second if there is room; a line is never cut off.

use std::collections::VecDeque;

use sr04_sim::{ChannelSpec, Radio};

use crate::ours::route;

const START: u8 = 0xFD;
const HEADER_BYTES: usize = 10;
const CRC_BYTES: usize = 2;

const ITEM_TIMEOUT_MS: u64 = 250;
const DEFAULT_TIMEOUT_MS: u64 = 1500;

/// Time after which an upload is abandoned, milliseconds.
const LIMIT_MS: u64 = 4 * 3600 * 1000;

/// Pause after the latest byte before the vehicle repeats its request, milliseconds.
const QUIET_MS: u64 = 10;

const LINE_BYTES: usize = 80;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Message {
    Count(u16),
    RequestInt(u16),
    ItemInt { seq: u16, x: i32, y: i32 },
    Ack,
}

/// Target system and component: the vehicle in messages of the ground, the ground in those of the vehicle.
const ADDRESS: [u8; 2] = [1, 1];

impl Message {
    /// Message id and `CRC_EXTRA`.
    const fn id(self) -> (u8, u8) {
        match self {
            Self::Count(_) => (44, 221),
            Self::RequestInt(_) => (51, 196),
            Self::ItemInt { .. } => (73, 38),
            Self::Ack => (47, 153),
        }
    }

    fn payload(self) -> Vec<u8> {
        let mut payload = Vec::new();
        match self {
            Self::Count(number) | Self::RequestInt(number) => {
                payload.extend(number.to_le_bytes());
                payload.extend(ADDRESS);
            }
            Self::ItemInt { seq, x, y } => {
                payload.extend([0; 16]); // four parameters
                payload.extend(x.to_le_bytes());
                payload.extend(y.to_le_bytes());
                payload.extend([0; 4]); // altitude
                payload.extend(seq.to_le_bytes());
                payload.extend(16_u16.to_le_bytes()); // a waypoint
                payload.extend(ADDRESS);
                payload.extend([1, 0, 1]); // local frame, not the current one, go on by itself
            }
            // `MAV_MISSION_ACCEPTED` is zero.
            Self::Ack => payload.extend(ADDRESS),
        }
        // The mission type, the last byte, is zero and is cut off with the other zeros at the end.
        while payload.len() > 1 && payload.last() == Some(&0) {
            payload.pop();
        }
        payload
    }

    /// The encoded frame; `number` counts the frames of one sender.
    fn frame(self, number: &mut u8) -> Vec<u8> {
        *number = number.wrapping_add(1);
        let payload = self.payload();
        let (id, extra) = self.id();
        let mut frame = vec![START, payload.len() as u8, 0, 0, *number, 1, 1, id, 0, 0];
        frame.extend(payload);
        frame.extend(crc16(&frame[1..], extra).to_le_bytes());
        frame
    }

    /// Reads a whole frame.
    fn parse(frame: &[u8]) -> Option<Self> {
        let (body, crc) = frame.split_at_checked(frame.len() - CRC_BYTES)?;
        let mut padded = body.get(HEADER_BYTES..)?.to_vec();
        padded.resize(64, 0);
        let u16_at = |at: usize| u16::from_le_bytes([padded[at], padded[at + 1]]);
        let i32_at = |at: usize| {
            i32::from_le_bytes([padded[at], padded[at + 1], padded[at + 2], padded[at + 3]])
        };
        let message = match body.get(7)? {
            44 => Self::Count(u16_at(0)),
            51 => Self::RequestInt(u16_at(0)),
            73 => Self::ItemInt {
                seq: u16_at(28),
                x: i32_at(16),
                y: i32_at(20),
            },
            47 => Self::Ack,
            _ => return None,
        };
        (crc == crc16(&body[1..], message.id().1).to_le_bytes()).then_some(message)
    }
}

/// CRC-16/MCRF4XX of the bytes and then of the message's `CRC_EXTRA`.
fn crc16(bytes: &[u8], extra: u8) -> u16 {
    bytes.iter().chain([&extra]).fold(0xFFFF, |crc, byte| {
        (0..8).fold(crc ^ u16::from(*byte), |crc, _| {
            if crc & 1 == 1 {
                crc >> 1 ^ 0x8408
            } else {
                crc >> 1
            }
        })
    })
}

/// Waits for a start byte and relies on the length after it; if the frame is wrong, searches the kept bytes for the next
/// start byte.
#[derive(Default)]
struct Parser(VecDeque<u8>);

impl Parser {
    fn push(&mut self, byte: u8) -> Option<Message> {
        self.0.push_back(byte);
        loop {
            while self.0.front().is_some_and(|first| *first != START) {
                self.0.pop_front();
            }
            let length = HEADER_BYTES + usize::from(*self.0.get(1)?) + CRC_BYTES;
            if self.0.len() < length {
                return None;
            }
            if let Some(message) = Message::parse(&self.0.make_contiguous()[..length]) {
                self.0.drain(..length);
                return Some(message);
            }
            self.0.pop_front();
        }
    }
}

/// A message to be repeated, and the time of its last byte.
struct Asked {
    message: Message,
    timeout_ms: u64,
    due_ms: Option<u64>,
}

impl Asked {
    fn new(message: Message, timeout_ms: u64) -> Self {
        Self {
            message,
            timeout_ms,
            due_ms: None,
        }
    }
}

/// The vehicle.
struct Vehicle {
    sends_telemetry: bool,
    parser: Parser,
    count: u16,
    items: Vec<(i32, i32)>,
    asked: Option<Asked>,
    out: VecDeque<u8>,
    queue: VecDeque<Message>,
    is_asking: bool,
    heard_ms: u64,
    /// Number of the latest frame.
    number: u8,
}

impl Vehicle {
    fn handle(&mut self, message: Message) {
        let expected = self.items.len() as u16;
        match message {
            Message::Count(count) => {
                self.count = count;
                self.items.clear();
            }
            Message::ItemInt { seq, x, y } if seq == expected && seq < self.count => {
                self.items.push((x, y));
            }
            // The last item is repeated: its acknowledgement was lost.
            Message::ItemInt { .. } if expected == self.count => {}
            Message::ItemInt { .. } | Message::RequestInt(_) | Message::Ack => return,
        }
        self.asked = None;
        self.queue.clear();
        if self.count > 0 && self.items.len() < usize::from(self.count) {
            self.ask(Message::RequestInt(self.items.len() as u16));
        } else {
            self.queue.push_back(Message::Ack);
        }
    }

    fn ask(&mut self, message: Message) {
        self.queue.push_back(message);
        self.asked = Some(Asked::new(message, ITEM_TIMEOUT_MS));
    }

    fn next_byte(&mut self, now_ms: u64) -> Option<u8> {
        if let Some(asked) = &mut self.asked
            && asked.due_ms.is_some_and(|due_ms| due_ms <= now_ms)
            && now_ms > self.heard_ms + QUIET_MS
        {
            asked.due_ms = None;
            self.queue.push_back(asked.message);
        }
        if self.out.is_empty() {
            if let Some(message) = self.queue.pop_front() {
                self.out.extend(message.frame(&mut self.number));
                self.is_asking = true;
            } else if self.sends_telemetry {
                self.out.extend([b'0'; LINE_BYTES]);
            }
        }
        let byte = self.out.pop_front();
        if self.is_asking && self.out.is_empty() {
            self.is_asking = false;
            if let Some(asked) = &mut self.asked {
                asked.due_ms = Some(now_ms + asked.timeout_ms);
            }
        }
        byte
    }
}

/// Time until the ground has the acknowledgement of `count` waypoints, seconds, from the end of a line of telemetry.
pub fn upload_s(spec: &str, seed: u64, count: usize, sends_telemetry: bool) -> Option<f64> {
    let spec: ChannelSpec = spec.parse().expect("the bench's own words");
    let mut radio = Radio::new(&spec, seed);
    let waypoints: Vec<(i32, i32)> = route(seed, count)
        .iter()
        .map(|point| (i32::from(point.x_in) * 254, i32::from(point.y_in) * 254))
        .collect();
    let mut vehicle = Vehicle {
        sends_telemetry,
        parser: Parser::default(),
        count: 0,
        items: Vec::new(),
        asked: None,
        out: VecDeque::new(),
        queue: VecDeque::new(),
        is_asking: false,
        heard_ms: 0,
        number: 0,
    };
    let mut number = 0;
    let mut ground = Parser::default();
    let announce = Message::Count(count as u16);
    let mut asked = Some(Asked::new(announce, DEFAULT_TIMEOUT_MS));
    radio.transmit(&announce.frame(&mut number));
    for now_ms in 1..LIMIT_MS {
        radio.step(now_ms, || vehicle.next_byte(now_ms));
        while let Some(byte) = radio.poll_uplink(now_ms) {
            vehicle.heard_ms = now_ms;
            if let Some(message) = vehicle.parser.push(byte) {
                vehicle.handle(message);
            }
        }
        while let Some(byte) = radio.poll_downlink(now_ms) {
            match ground.push(byte) {
                Some(Message::RequestInt(_)) if radio.uplink_pending() > 0 => {}
                Some(Message::RequestInt(seq)) => {
                    let Some(&(x, y)) = waypoints.get(usize::from(seq)) else {
                        continue;
                    };
                    let item = Message::ItemInt { seq, x, y };
                    // After the last item the ground waits for the acknowledgement; the vehicle requests the others.
                    let is_last = usize::from(seq) + 1 == count;
                    asked = is_last.then(|| Asked::new(item, DEFAULT_TIMEOUT_MS));
                    radio.transmit(&item.frame(&mut number));
                }
                Some(Message::Ack) if vehicle.items == waypoints => {
                    return Some(now_ms as f64 / 1000.0);
                }
                _ => {}
            }
        }
        if let Some(asked) = &mut asked
            && radio.uplink_pending() == 0
        {
            let due_ms = *asked.due_ms.get_or_insert(now_ms + asked.timeout_ms);
            if due_ms <= now_ms {
                asked.due_ms = None;
                radio.transmit(&asked.message.frame(&mut number));
            }
        }
    }
    None
}
