//! One line on its way out, byte by byte.

use groundwave_protocol::telemetry::{
    ACK_LINE_BYTES, Ack, AckLine, Body, HEAD_BYTES, SEQUENCE_MODULUS,
};
use groundwave_protocol::{LINE_BYTES, crc};

/// So many lines are followed by an acknowledgement line after the last byte heard.
const ECHO_LINES: u8 = 4;

/// The columns of an acknowledgement.
const ACK_BYTES: usize = 5;

/// The transmitter.
#[derive(Clone, Debug)]
pub struct Transmitter {
    line: [u8; LINE_BYTES],
    /// The next byte to go.
    position: u8,
    /// Where the acknowledgement goes: that and the trailer are written when they are due.
    head: u8,
    length: u8,
    /// Of the line being sent.
    sequence: u8,
    ack_lines_due: u8,
    /// Noise just before a line mis-frames a receiver: an idle byte time before the first one cures it.
    has_rested: bool,
}

impl Default for Transmitter {
    fn default() -> Self {
        Self {
            line: [0; LINE_BYTES],
            position: 0,
            head: 0,
            length: 0,
            sequence: SEQUENCE_MODULUS - 1,
            ack_lines_due: 0,
            has_rested: false,
        }
    }
}

impl Transmitter {
    /// A line feed came in: whoever sent it would like to see acknowledgements.
    pub const fn hear(&mut self) {
        self.ack_lines_due = ECHO_LINES;
    }

    /// Sequence of the line being sent.
    #[must_use]
    pub const fn sequence(&self) -> u8 {
        self.sequence
    }

    /// Whether the next byte is the first of a long line, which [`Self::begin`] must be given.
    #[must_use]
    pub const fn wants_line(&self) -> bool {
        self.has_rested
            && self.position == self.length
            && (self.ack_lines_due == 0 || self.length as usize != LINE_BYTES)
    }

    /// Begins a long line.
    pub fn begin(&mut self, body: &Body) {
        self.count();
        let head = body.head(self.sequence);
        self.load(&head, LINE_BYTES);
    }

    /// The next byte; `acknowledge` is asked when the acknowledgement's first column is due.
    pub fn next_byte(&mut self, acknowledge: impl FnOnce() -> Ack) -> Option<u8> {
        if !self.has_rested {
            self.has_rested = true;
            return None;
        }
        if self.position == self.length {
            self.ack_lines_due = self.ack_lines_due.saturating_sub(1);
            self.count();
            self.load(&AckLine::head(self.sequence), ACK_LINE_BYTES);
        }
        if self.position == self.head {
            self.finish(acknowledge());
        }
        let byte = self.line.get(usize::from(self.position)).copied();
        self.position += 1;
        byte
    }

    fn count(&mut self) {
        self.sequence = (self.sequence + 1) % SEQUENCE_MODULUS;
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
