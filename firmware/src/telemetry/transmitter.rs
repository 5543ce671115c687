//! One line on its way out, byte by byte, and whose turn it is to talk.

use crate::board::Duplex;
use groundwave_protocol::telemetry::{
    ACK_LINE_BYTES, Ack, AckLine, Body, HEAD_BYTES, SEQUENCE_MODULUS,
};
use groundwave_protocol::{LINE_BYTES, crc};

/// So many long lines are followed by acknowledgement lines after the last line feed heard.
const ECHO_LINES: u8 = 4;

/// Acknowledgement lines after a long one while the ground talks in full duplex.
const ACK_LINES: u8 = 3;

/// A half-duplex robot listens no longer than this at a time, byte times.
const TURN_BYTES: u8 = 240;

/// So many line feeds in a row say that the ground has no more to say: two stand between frames.
const OVER_LINE_FEEDS: u8 = 3;

/// While the ground has much to say, a long line comes after so many turns to listen.
const TURNS_A_LINE: u8 = 3;

/// The columns of an acknowledgement.
const ACK_BYTES: usize = 5;

/// Lines whose beginning is remembered.
const LINES_REMEMBERED: usize = 16;

/// What the transmitter does next.
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
    /// The next byte to go.
    position: u8,
    /// Where the acknowledgement goes: that and the trailer are written when they are due.
    head: u8,
    length: u8,
    /// Of the line being sent.
    sequence: u8,
    next: Next,
    /// Long lines that acknowledgement lines still follow.
    echoes_due: u8,
    ack_lines_due: u8,
    /// The robot listens, in half duplex.
    turn: Option<Turn>,
    /// Turns to listen since the latest long line.
    turns: u8,
    /// Noise just before a line mis-frames a receiver: an idle byte time before the first one cures it.
    has_rested: bool,
    /// The low bits of the tick each of the latest lines began in, by sequence.
    begun_ticks: [u8; LINES_REMEMBERED],
}

/// What was heard in a turn.
#[derive(Clone, Copy, Debug, Default)]
struct Turn {
    /// Byte times since it began or since the latest byte heard.
    silent_bytes: u8,
    /// Byte times since the first byte heard.
    heard_bytes: u8,
    has_heard: bool,
    has_heard_line_feed: bool,
    /// The latest so many bytes were line feeds.
    line_feeds: u8,
}

impl Transmitter {
    /// A transmitter that has sent nothing yet.
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

    /// A byte came in. Whoever sent a line feed would like to see acknowledgements; whoever talks in the
    /// robot's turn to listen is heard out.
    pub const fn hear(&mut self, byte: u8) {
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

    /// Ticks since the line of this sequence began; `None` when that is too long ago to be known.
    #[must_use]
    pub fn age_ticks(&self, sequence: u8, now_ticks: u32) -> Option<u8> {
        let behind =
            (self.sequence + SEQUENCE_MODULUS - sequence % SEQUENCE_MODULUS) % SEQUENCE_MODULUS;
        let begun = self
            .begun_ticks
            .get(usize::from(sequence) % LINES_REMEMBERED)?;
        (usize::from(behind) < LINES_REMEMBERED).then(|| (now_ticks as u8).wrapping_sub(*begun))
    }

    /// Whether the next byte is the first of a long line, which [`Self::begin`] must be given.
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

    /// The next byte; `acknowledge` is asked when the acknowledgement's first column is due.
    pub fn next_byte(&mut self, now_ticks: u32, acknowledge: impl FnOnce() -> Ack) -> Option<u8> {
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
            self.finish(acknowledge());
        }
        let byte = self.line.get(usize::from(self.position)).copied();
        self.position += 1;
        byte
    }

    fn begin_short(&mut self, listens: bool, now_ticks: u32) {
        self.count(now_ticks);
        self.load(&AckLine::head(self.sequence, listens), ACK_LINE_BYTES);
    }

    /// A byte time of listening. While the ground has much to say, most turns follow acknowledgements alone:
    /// the list arrives sooner and telemetry goes on.
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
        // The carrier comes back: a receiver has to find its feet.
        self.has_rested = false;
    }

    /// What comes before listening: go ahead, and while the ground talks an acknowledgement that may get
    /// through where the other does not.
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

    /// Acknowledgement, checksum and line end.
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
