//! Transmission of lines byte by byte, and turn-taking in half duplex.

use crate::board::Duplex;
use groundwave_protocol::telemetry::{
    ACK_LINE_BYTES, Ack, AckLine, Body, HEAD_BYTES, SEQUENCE_MODULUS,
};
use groundwave_protocol::{LINE_BYTES, crc};

/// Number of long lines followed by acknowledgement lines after the last received line feed.
const ECHO_LINES: u8 = 4;

/// Number of acknowledgement lines after a long line while the ground station sends in full duplex.
const ACK_LINES: u8 = 3;

/// Maximum length of a half-duplex turn, in byte times.
const TURN_BYTES: u8 = 240;

/// Consecutive line feeds that end the ground station's turn: two separate frames.
const OVER_LINE_FEEDS: u8 = 3;

/// Number of turns after which a long line is sent while the ground station sends much.
const TURNS_A_LINE: u8 = 3;

/// Number of columns of an acknowledgement.
const ACK_BYTES: usize = 5;

/// Number of lines whose start time is kept.
const LINES_REMEMBERED: usize = 16;

/// Next activity of the transmitter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Next {
    LongLine,
    AckLine,
    /// An acknowledgement line after which the robot listens.
    GoAhead,
    Listen,
}

/// The transmitter.
#[derive(Clone, Debug)]
pub struct Transmitter {
    duplex: Duplex,
    line: [u8; LINE_BYTES],
    /// Index of the next byte.
    position: u8,
    /// Index at which the acknowledgement begins; it is written with the trailer when due.
    head: u8,
    length: u8,
    /// Sequence of the current line.
    sequence: u8,
    next: Next,
    /// Number of long lines to be followed by acknowledgement lines.
    echoes_due: u8,
    ack_lines_due: u8,
    /// The current turn of the ground station in half duplex.
    turn: Option<Turn>,
    /// Number of turns since the latest long line.
    turns: u8,
    /// Whether an idle byte time has preceded the line: it realigns a receiver after noise.
    has_rested: bool,
    /// Low bits of the start tick of the latest lines, by sequence.
    begun_ticks: [u8; LINES_REMEMBERED],
}

/// A turn of the ground station.
#[derive(Clone, Copy, Debug, Default)]
struct Turn {
    /// Byte times since its start or since the latest received byte.
    silent_bytes: u8,
    /// Byte times since the first received byte.
    heard_bytes: u8,
    has_heard: bool,
    has_heard_line_feed: bool,
    /// Number of consecutive line feeds received.
    line_feeds: u8,
}

impl Transmitter {
    /// A transmitter that has sent nothing.
    #[must_use]
    pub const fn new(duplex: Duplex) -> Self {
        Self {
            duplex,
            line: [0; LINE_BYTES],
            position: 0,
            head: 0,
            length: 0,
            sequence: SEQUENCE_MODULUS - 1,
            next: Next::LongLine,
            echoes_due: 0,
            ack_lines_due: 0,
            turn: None,
            turns: 0,
            has_rested: false,
            begun_ticks: [0; LINES_REMEMBERED],
        }
    }

    /// Handles a received byte: a line feed requests acknowledgement lines, and any byte extends the ground station's turn.
    pub const fn handle_byte(&mut self, byte: u8) {
        if byte == b'\n' {
            self.echoes_due = ECHO_LINES;
        }
        if let Some(turn) = &mut self.turn {
            turn.has_heard = true;
            let is_line_feed = byte == b'\n';
            turn.has_heard_line_feed |= is_line_feed;
            turn.line_feeds = if is_line_feed {
                turn.line_feeds.saturating_add(1)
            } else {
                0
            };
            turn.silent_bytes = 0;
        }
    }

    /// Ticks since the line of this sequence began; `None` if it is too old.
    #[must_use]
    pub fn age_ticks(&self, sequence: u8, now_ticks: u32) -> Option<u8> {
        let behind =
            (self.sequence + SEQUENCE_MODULUS - sequence % SEQUENCE_MODULUS) % SEQUENCE_MODULUS;
        let begun = self
            .begun_ticks
            .get(usize::from(sequence) % LINES_REMEMBERED)?;
        (usize::from(behind) < LINES_REMEMBERED).then(|| (now_ticks as u8).wrapping_sub(*begun))
    }

    /// Whether the next byte is the first of a long line, which [`Self::begin`] must provide.
    #[must_use]
    pub const fn wants_line(&self) -> bool {
        self.has_rested && self.position == self.length && matches!(self.next, Next::LongLine)
    }

    /// Begins a long line.
    pub fn begin(&mut self, body: &Body, now_ticks: u32) {
        self.count(now_ticks);
        let head = body.head(self.sequence);
        self.load(&head, LINE_BYTES);
        self.turns = 0;
        let is_talked_to = self.echoes_due > 0;
        self.echoes_due = self.echoes_due.saturating_sub(1);
        self.next = match self.duplex {
            Duplex::Half { .. } => self.end_of_turn(is_talked_to),
            Duplex::Full if is_talked_to => {
                self.ack_lines_due = ACK_LINES;
                Next::AckLine
            }
            Duplex::Full => Next::LongLine,
        };
    }

    /// The next byte; `acknowledge` is called when the first column of the acknowledgement is due.
    pub fn next_byte(&mut self, now_ticks: u32, acknowledge: impl FnOnce(u8) -> Ack) -> Option<u8> {
        if !self.has_rested {
            self.has_rested = true;
            return None;
        }
        if self.position == self.length {
            match self.next {
                Next::Listen => {
                    self.listen();
                    return None;
                }
                Next::LongLine => return None,
                Next::AckLine => {
                    self.begin_short(false, now_ticks);
                    self.ack_lines_due = self.ack_lines_due.saturating_sub(1);
                    if self.ack_lines_due == 0 {
                        self.next = match self.duplex {
                            Duplex::Full => Next::LongLine,
                            Duplex::Half { .. } => Next::GoAhead,
                        };
                    }
                }
                Next::GoAhead => {
                    self.begin_short(true, now_ticks);
                    self.next = Next::Listen;
                }
            }
        }
        if self.position == self.head {
            self.finish(acknowledge(self.sequence));
        }
        let byte = self.line.get(usize::from(self.position)).copied();
        self.position += 1;
        byte
    }

    fn begin_short(&mut self, listens: bool, now_ticks: u32) {
        self.count(now_ticks);
        self.load(&AckLine::head(self.sequence, listens), ACK_LINE_BYTES);
    }

    /// Listens for a byte time. While the ground station sends much, most turns follow an acknowledgement line alone, so
    /// that its frames arrive sooner and telemetry continues.
    fn listen(&mut self) {
        let Duplex::Half { patience_bytes } = self.duplex else {
            self.next = Next::LongLine;
            return;
        };
        let turn = self.turn.get_or_insert_default();
        turn.silent_bytes = turn.silent_bytes.saturating_add(1);
        turn.heard_bytes = turn.heard_bytes.saturating_add(u8::from(turn.has_heard));
        let is_over = turn.line_feeds >= OVER_LINE_FEEDS
            || turn.silent_bytes >= patience_bytes
            || turn.heard_bytes >= TURN_BYTES;
        if !is_over {
            return;
        }
        self.turns += 1;
        self.next = if turn.has_heard_line_feed && self.turns < TURNS_A_LINE {
            self.end_of_turn(true)
        } else {
            Next::LongLine
        };
        self.turn = None;
        // A receiver has to synchronize again after the carrier returns.
        self.has_rested = false;
    }

    /// Selects the lines before a turn of the ground station: a go-ahead, and while the station sends, an acknowledgement
    /// line before it, because one of the two may be lost.
    const fn end_of_turn(&mut self, is_talked_to: bool) -> Next {
        if is_talked_to {
            self.ack_lines_due = 1;
            Next::AckLine
        } else {
            Next::GoAhead
        }
    }

    fn count(&mut self, now_ticks: u32) {
        self.sequence = (self.sequence + 1) % SEQUENCE_MODULUS;
        let place = usize::from(self.sequence) % LINES_REMEMBERED;
        if let Some(begun) = self.begun_ticks.get_mut(place) {
            *begun = now_ticks as u8;
        }
    }

    fn load(&mut self, head: &[u8], length: usize) {
        self.position = 0;
        self.head = head.len() as u8;
        self.length = length as u8;
        self.write(0, head);
    }

    /// Writes acknowledgement, checksum and line end.
    fn finish(&mut self, ack: Ack) {
        let head = usize::from(self.head);
        self.write(head, &ack.encode());
        let covered = self.line.get(..head + ACK_BYTES).unwrap_or_default();
        let remainder = crc::update(crc::DOWNLINK_INIT, covered);
        self.write(head + ACK_BYTES, &crc::characters(remainder));
        self.write(head + ACK_BYTES + crc::CHARACTERS, b"\r\n");
    }

    fn write(&mut self, at: usize, bytes: &[u8]) {
        for (to, from) in self.line.iter_mut().skip(at).zip(bytes) {
            *to = *from;
        }
    }
}

const _: () = assert!(HEAD_BYTES + ACK_BYTES + crc::CHARACTERS + 2 == LINE_BYTES);
