//! How long a reader may sleep because the line under way cannot be whole yet. Every wake-up costs the computer far more
//! than the four bytes that a USB adapter hands over at a time.

use std::time::{Duration, Instant};

use groundwave_protocol::LINE_BYTES;
use groundwave_protocol::telemetry::ACK_LINE_BYTES;

/// Start bit, eight data bits, stop bit.
const BITS_PER_BYTE: u32 = 10;

/// The longest rest while nothing is recorded.
pub(super) const LONGEST: Duration = Duration::from_millis(250);

/// The longest while something is: a kill or a pulled plug takes what waits in the system with it, at 2400 baud 24 bytes of a
/// line under way. An adapter has four of them in any case.
pub(super) const LONGEST_RECORDED: Duration = Duration::from_millis(100);

/// A USB adapter keeps bytes so long before it hands them over: what was read may be as old.
const ADAPTER: Duration = Duration::from_millis(17);

/// Sleeping and waking costs more than a shorter one saves.
const SHORTEST: Duration = Duration::from_millis(10);

/// The line under way on a wire of known speed.
#[derive(Debug)]
pub(super) struct Rest {
    /// `None` where bytes may come at any speed.
    byte_time: Option<Duration>,
    /// Bytes since the latest line feed, and the first of them.
    filled: usize,
    first: u8,
    /// Before this no wire has carried the rest of the line.
    whole_at: Option<Instant>,
}

impl Rest {
    /// For a port opened at this rate in bit/s; `None` for a link without one.
    pub(super) fn new(baud: Option<u32>) -> Self {
        let byte_time = baud.filter(|&baud| baud > 0);
        Self {
            byte_time: byte_time.map(|baud| Duration::from_secs(1) * BITS_PER_BYTE / baud),
            filled: 0,
            first: 0,
            whole_at: None,
        }
    }

    /// Takes what a read brought.
    pub(super) fn take(&mut self, now: Instant, bytes: &[u8]) {
        if let Some(end) = bytes.iter().position(|&byte| byte == b'\n') {
            self.doubt(now, end + 1);
        }
        let fresh = match bytes.iter().rposition(|&byte| byte == b'\n') {
            Some(end) => {
                self.filled = 0;
                &bytes[end + 1..]
            }
            None => bytes,
        };
        if self.filled == 0
            && let Some(&first) = fresh.first()
        {
            self.first = first;
        }
        self.filled += fresh.len();
        self.whole_at = self.carried_in(31, 32).map(|time| now + time);
    }

    /// A pseudo-terminal keeps to no rate: a line that is whole before a wire can have carried it is proof, and whoever
    /// sleeps there is late.
    fn doubt(&mut self, now: Instant, end: usize) {
        let is_line = self.filled + end == self.line_bytes() as usize;
        if is_line && self.whole_at.is_some_and(|at| now < at) {
            self.byte_time = None;
        }
    }

    /// For how long the line cannot be whole, were the other end's clock faster by a sixteenth, and no longer than this; `None`
    /// when the next byte may matter.
    pub(super) fn duration(&self, longest: Duration) -> Option<Duration> {
        let rest = self.carried_in(15, 16)?;
        (rest >= SHORTEST).then_some(rest.min(longest))
    }

    /// This part of the time in which the wire carries what is missing, if what was read is as old as it can be; `None` where
    /// no line is under way.
    fn carried_in(&self, part: u32, of: u32) -> Option<Duration> {
        let filled = u32::try_from(self.filled)
            .ok()
            .filter(|&filled| filled > 0)?;
        let missing = self.line_bytes().checked_sub(filled)?;
        Some((self.byte_time? * missing * part / of).saturating_sub(ADAPTER))
    }

    /// Length of the line under way, if its first byte is what was sent.
    const fn line_bytes(&self) -> u32 {
        match self.first {
            b'K' | b'G' => ACK_LINE_BYTES as u32,
            _ => LINE_BYTES as u32,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CLUMP: Duration = Duration::from_micros(16_667);

    fn line(letter: u8, length: usize) -> Vec<u8> {
        let mut line = vec![b'.'; length];
        line[0] = letter;
        line[length - 1] = b'\n';
        line
    }

    /// A wire at 2400 baud behind an adapter that hands over every 16 ms: when each line was whole, when it was read,
    /// and how many reads that took.
    fn read(longest: Duration, lines: &[Vec<u8>]) -> (Vec<(Duration, Duration)>, usize) {
        let mut rest = Rest::new(Some(2400));
        let begin = Instant::now();
        let bytes = lines.concat();
        // In clumps of four bytes: what has come at a moment.
        let come = |at: Duration| {
            let clumps = usize::try_from(at.as_nanos() / CLUMP.as_nanos()).expect("few");
            (clumps * 4).min(bytes.len())
        };
        let (mut at, mut taken, mut reads, mut whole) = (Duration::ZERO, 0, 0, Vec::new());
        while taken < bytes.len() {
            while come(at) == taken {
                at += Duration::from_micros(100);
            }
            let fresh = &bytes[taken..come(at)];
            for place in (0..fresh.len()).filter(|&place| fresh[place] == b'\n') {
                let clump = u32::try_from((taken + place) / 4 + 1).expect("few");
                whole.push((CLUMP * clump, at));
            }
            rest.take(begin + at, fresh);
            taken += fresh.len();
            reads += 1;
            at += rest.duration(longest).unwrap_or_default();
        }
        (whole, reads)
    }

    #[test]
    fn lines_of_either_length_are_read_when_they_are_whole_in_fewer_reads() {
        let mut lines = vec![
            line(b'A', 80),
            line(b'K', 14),
            line(b'K', 14),
            line(b'G', 14),
        ];
        for letter in *b"BACASAP" {
            lines.push(line(letter, 80));
        }
        let clumps = lines.concat().len() / 4;
        for longest in [LONGEST, LONGEST_RECORDED] {
            let (whole, reads) = read(longest, &lines);
            assert_eq!(whole.len(), lines.len());
            for (come, had) in whole {
                assert!(had < come + Duration::from_millis(1), "{come:?} {had:?}");
            }
            assert!(
                reads * 3 < clumps,
                "{reads} reads of {clumps} clumps, {longest:?}"
            );
        }
    }

    #[test]
    fn nobody_sleeps_before_a_line_begins_nor_where_one_should_have_ended() {
        let mut rest = Rest::new(Some(2400));
        assert_eq!(rest.duration(LONGEST), None);
        let now = Instant::now();
        rest.take(now, b"A...");
        assert_eq!(rest.duration(LONGEST), Some(LONGEST));
        rest.take(now + Duration::from_millis(250), &[b'.'; 56]);
        assert_eq!(
            rest.duration(LONGEST).map(|rest| rest.as_millis()),
            Some(61),
            "20 bytes are missing"
        );
        rest.take(now + Duration::from_millis(320), &[b'.'; 19]);
        assert_eq!(rest.duration(LONGEST), None, "one byte is missing");
        // The line feed was spoilt: where the next one is nobody knows.
        rest.take(now + Duration::from_millis(333), b"??..");
        assert_eq!(rest.duration(LONGEST), None);
        rest.take(now + Duration::from_millis(340), b"...\nB");
        assert_eq!(rest.duration(LONGEST), Some(LONGEST));
    }

    /// Whether the line is there when the sleeper wakes up, or comes while nobody sleeps.
    #[test]
    fn a_line_that_comes_faster_than_the_wire_ends_all_sleep() {
        let now = Instant::now();
        for filled in [1, 4, 40] {
            let mut rest = Rest::new(Some(2400));
            let line = line(b'A', 80);
            rest.take(now, &line[..filled]);
            let slept = rest.duration(LONGEST).expect("a rest");
            let woken = now + slept + Duration::from_millis(3);
            rest.take(woken, &line[filled..]);
            rest.take(woken, b"B...");
            assert_eq!(
                rest.duration(LONGEST),
                None,
                "{filled} bytes were there before"
            );
        }
        assert_eq!(Rest::new(None).duration(LONGEST), None);
    }

    /// A flipped bit makes a line feed of any byte, and of a short line another.
    #[test]
    fn a_line_feed_where_none_belongs_is_no_proof() {
        for noise in [&b"..\n"[..], b"..........\n", b"...\n...\n"] {
            let mut rest = Rest::new(Some(2400));
            let now = Instant::now();
            rest.take(now, b"A..");
            rest.take(now + Duration::from_millis(30), noise);
            rest.take(now + Duration::from_millis(40), b"B...");
            assert_eq!(rest.duration(LONGEST), Some(LONGEST));
        }
    }

    /// At the port's rate it is the port that is slow; a radio behind it is slower still.
    #[test]
    fn a_fast_port_sleeps_less() {
        let mut rest = Rest::new(Some(9600));
        rest.take(Instant::now(), b"A...");
        let whole = Duration::from_micros(76 * 10_000_000 / 9600);
        let duration = rest.duration(LONGEST).expect("a rest");
        assert!(duration + ADAPTER < whole, "{duration:?} {whole:?}");
        let mut rest = Rest::new(Some(115_200));
        rest.take(Instant::now(), b"A...");
        assert_eq!(rest.duration(LONGEST), None);
    }
}
