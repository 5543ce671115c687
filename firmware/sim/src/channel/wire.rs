//! One direction of the radio: from a transmitter's byte times to a receiver's bytes.

use std::collections::VecDeque;

use super::noise::Noise;
use super::spec::{ChannelSpec, Squelch};
use crate::rng::Rng;

/// Number of bits per byte: start bit, eight data bits, stop bit.
const BITS_PER_BYTE: u64 = 10;

/// Maximum number of received bytes that wait to be polled; the oldest are dropped first.
const ARRIVING_MAX: usize = 1 << 16;

/// The receiving half of a UART, with one sample per bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Receiver {
    /// Waits for a start bit.
    Idle,
    /// Has received `count` data bits, the least significant first.
    Data { count: u8, bits: u8 },
    /// Wrong stop bit: the byte is lost, and the line must be idle before the next start bit.
    Broken,
}

impl Receiver {
    /// Takes a bit; returns the byte that it completes.
    const fn sample(&mut self, bit: bool) -> Option<u8> {
        match *self {
            Self::Idle => {
                if !bit {
                    *self = Self::Data { count: 0, bits: 0 };
                }
            }
            Self::Data { count: 8, bits } => {
                if bit {
                    *self = Self::Idle;
                    return Some(bits);
                }
                *self = Self::Broken;
            }
            Self::Data { count, bits } => {
                let bits = bits >> 1 | (bit as u8) << 7;
                *self = Self::Data {
                    count: count + 1,
                    bits,
                };
            }
            Self::Broken => {
                if bit {
                    *self = Self::Idle;
                }
            }
        }
        None
    }
}

/// Input of a receiver from the transmitter during a byte time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Hearing {
    /// The complete signal.
    Line,
    /// Nothing, because it transmits itself.
    Deaf,
    /// Nothing, because of an outage.
    Out,
}

/// One direction of the radio.
#[derive(Debug)]
pub(super) struct Wire {
    noise: Noise,
    squelch: Squelch,
    /// With open squelch, the byte being sent and the previous one. The carrier rises a byte time before the first byte
    /// and falls a byte time after the last, so every byte is one byte time late.
    keyed: [Option<u8>; 2],
    rng: Rng,
    drop: f64,
    dup: f64,
    delay_ms: u64,
    receiver: Receiver,
    /// Received bytes, each with the time at which it can be polled.
    arriving: VecDeque<(u64, u8)>,
}

impl Wire {
    pub(super) fn new(spec: &ChannelSpec, mut rng: Rng) -> Self {
        Self {
            noise: Noise::new(spec, rng.split()),
            squelch: spec.squelch,
            keyed: [None; 2],
            rng,
            drop: spec.drop,
            dup: spec.dup,
            delay_ms: spec.delay_ms,
            receiver: Receiver::Idle,
            arriving: VecDeque::new(),
        }
    }

    pub(super) fn set(&mut self, spec: &ChannelSpec) {
        self.noise.set(spec);
        self.squelch = spec.squelch;
        (self.drop, self.dup, self.delay_ms) = (spec.drop, spec.dup, spec.delay_ms);
    }

    /// Passes one byte time: the transmitter's byte or an idle line, as far as the receiver hears it.
    pub(super) fn pass(&mut self, now_ms: u64, sent: Option<u8>, hearing: Hearing) {
        let mut line = sent;
        let mut has_carrier = true;
        if self.squelch != Squelch::Closed {
            let [current, previous] = self.keyed;
            self.keyed = [sent, current];
            line = current;
            has_carrier = [sent, current, previous].iter().any(Option::is_some);
        }
        match hearing {
            Hearing::Line if has_carrier => self.pass_line(now_ms, line),
            Hearing::Line => self.pass_hiss(now_ms),
            Hearing::Out if self.squelch == Squelch::OpenInOutages => self.pass_hiss(now_ms),
            // The receiver sees an idle line.
            Hearing::Deaf | Hearing::Out => {
                for _ in 0..BITS_PER_BYTE {
                    self.sample(now_ms, true);
                }
            }
        }
    }

    fn pass_line(&mut self, now_ms: u64, line: Option<u8>) {
        if self.receiver == Receiver::Idle && self.noise.skip(BITS_PER_BYTE) {
            if let Some(byte) = line {
                self.receive(now_ms, byte);
            }
        } else {
            for index in 0..BITS_PER_BYTE {
                let bit = line.is_none_or(|byte| bit_of(byte, index)) ^ self.noise.flip();
                self.sample(now_ms, bit);
            }
        }
    }

    /// Passes a byte time of random bits.
    fn pass_hiss(&mut self, now_ms: u64) {
        let bits = self.rng.next_u32();
        for index in 0..BITS_PER_BYTE {
            self.sample(now_ms, bits >> index & 1 == 1);
        }
    }

    fn sample(&mut self, now_ms: u64, bit: bool) {
        if let Some(byte) = self.receiver.sample(bit) {
            self.receive(now_ms, byte);
        }
    }

    fn receive(&mut self, now_ms: u64, byte: u8) {
        if self.rng.chance(self.drop) {
            return;
        }
        self.deliver(now_ms, byte);
        if self.rng.chance(self.dup) {
            self.deliver(now_ms, byte);
        }
    }

    fn deliver(&mut self, now_ms: u64, byte: u8) {
        if self.arriving.len() == ARRIVING_MAX {
            self.arriving.pop_front();
        }
        self.arriving.push_back((now_ms + self.delay_ms, byte));
    }

    /// The next byte that has arrived by now.
    pub(super) fn poll(&mut self, now_ms: u64) -> Option<u8> {
        let (due_ms, byte) = *self.arriving.front()?;
        if due_ms > now_ms {
            return None;
        }
        self.arriving.pop_front();
        Some(byte)
    }

    /// Number of bytes that have not been polled, including delayed ones.
    pub(super) fn in_flight(&self) -> usize {
        self.arriving.len()
    }
}

/// Level of the line at a bit of a byte.
const fn bit_of(byte: u8, index: u64) -> bool {
    match index {
        0 => false,
        1..=8 => byte >> (index - 1) & 1 == 1,
        _ => true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Stream;

    fn received(text: &str, sent: &[u8]) -> Vec<u8> {
        let mut wire = Wire::new(&text.parse().unwrap(), Rng::new(2, Stream::Downlink));
        let mut received = Vec::new();
        for (slot, byte) in (0..).zip(sent) {
            wire.pass(slot * 4, Some(*byte), Hearing::Line);
            received.extend(std::iter::from_fn(|| wire.poll(u64::MAX)));
        }
        received
    }

    fn count_of(bytes: &[u8], wanted: u8) -> usize {
        bytes
            .iter()
            .fold(0, |count, byte| count + usize::from(*byte == wanted))
    }

    /// Decodes the levels of a line, one per bit.
    fn decode(bits: &[u8]) -> Vec<u8> {
        let mut receiver = Receiver::Idle;
        bits.iter()
            .filter_map(|bit| receiver.sample(*bit == 1))
            .collect()
    }

    fn bits(bytes: &[u8]) -> Vec<u8> {
        bytes
            .iter()
            .flat_map(|byte| (0..10).map(|index| u8::from(bit_of(*byte, index))))
            .collect()
    }

    #[test]
    fn clean_wire_carries_every_byte() {
        let all: Vec<u8> = (0..=255).collect();
        assert_eq!(received("", &all), all);
        assert_eq!(decode(&bits(&all)), all);
    }

    #[test]
    fn flipped_data_bit_damages_one_byte() {
        let mut line = bits(b"ABC");
        line[12] ^= 1;
        assert_eq!(decode(&line), [b'A', b'B' ^ 0b10, b'C']);
    }

    #[test]
    fn flipped_stop_bit_loses_the_byte() {
        let mut line = bits(b"ABC");
        line[9] ^= 1;
        line.extend([1; 10]);
        let bytes = decode(&line);
        assert!(!bytes.contains(&b'A'), "{bytes:?}");
    }

    #[test]
    fn flipped_start_bit_shifts_the_byte() {
        let mut line = bits(b"A");
        line[0] ^= 1;
        line.extend([1; 10]);
        // On the line 'A' is 0 1000 0010 1: its second 0 is taken for the start bit.
        assert_eq!(decode(&line), [0b1101_0000]);
    }

    #[test]
    fn noise_on_an_idle_line_makes_bytes_of_ones() {
        let mut wire = Wire::new(&"ber=0.001".parse().unwrap(), Rng::new(3, Stream::Downlink));
        for slot in 0..20_000 {
            wire.pass(slot, None, Hearing::Line);
        }
        let bytes: Vec<u8> = std::iter::from_fn(|| wire.poll(u64::MAX)).collect();
        assert!((120..280).contains(&bytes.len()), "{}", bytes.len());
        assert!(count_of(&bytes, 0xFF) > bytes.len() * 9 / 10);
    }

    #[test]
    fn lost_and_duplicated_bytes_have_the_specified_rates() {
        let sent = vec![b'U'; 50_000];
        let dropped = received("drop=0.1", &sent).len();
        assert!((44_500..45_500).contains(&dropped), "{dropped}");
        let doubled = received("dup=0.1", &sent).len();
        assert!((54_500..55_500).contains(&doubled), "{doubled}");
    }

    #[test]
    fn bit_errors_damage_about_ten_times_as_many_bytes() {
        let sent = vec![b'U'; 50_000];
        let intact = count_of(&received("ber=1e-3", &sent), b'U');
        let lost = 1.0 - intact as f64 / 50_000.0;
        assert!((0.008..0.02).contains(&lost), "{lost}");
    }

    #[test]
    fn delay_postpones_bytes() {
        let mut wire = Wire::new(&"delay=0.5s".parse().unwrap(), Rng::new(1, Stream::Uplink));
        wire.pass(100, Some(b'x'), Hearing::Line);
        assert_eq!(wire.poll(599), None);
        assert_eq!(wire.in_flight(), 1);
        assert_eq!(wire.poll(600), Some(b'x'));
    }

    #[test]
    fn unheard_bytes_are_silence() {
        let mut wire = Wire::new(&ChannelSpec::default(), Rng::new(1, Stream::Uplink));
        wire.pass(0, Some(b'x'), Hearing::Deaf);
        wire.pass(0, Some(b'x'), Hearing::Out);
        wire.pass(4, Some(b'y'), Hearing::Line);
        assert_eq!(wire.poll(4), Some(b'y'));
        assert_eq!(wire.poll(4), None);
    }

    /// Number of bytes received in 10,000 byte times of silence.
    fn hiss(text: &str, hearing: Hearing) -> usize {
        let mut wire = Wire::new(&text.parse().unwrap(), Rng::new(1, Stream::Uplink));
        for slot in 0..10_000 {
            wire.pass(slot, None, hearing);
        }
        std::iter::from_fn(|| wire.poll(u64::MAX)).count()
    }

    #[test]
    fn squelch_options_select_when_silence_is_noise() {
        // Every other bit is a start bit, and half of the bytes have a wrong stop bit.
        assert!((2_000..5_000).contains(&hiss("squelch", Hearing::Line)));
        assert!((2_000..5_000).contains(&hiss("squelch=out", Hearing::Out)));
        for (text, hearing) in [
            ("", Hearing::Line),
            ("squelch", Hearing::Out),
            ("squelch", Hearing::Deaf),
            ("squelch=out", Hearing::Deaf),
        ] {
            assert_eq!(hiss(text, hearing), 0, "{text}, {hearing:?}");
        }
    }

    #[test]
    fn bytes_after_a_rising_carrier_are_received() {
        let mut wire = Wire::new(&"squelch".parse().unwrap(), Rng::new(1, Stream::Uplink));
        for round in 0..200 {
            let bytes = [None, None, None, Some(b'o'), Some(b'k'), None, None, None];
            for byte in bytes {
                wire.pass(round, byte, Hearing::Line);
            }
            let heard: Vec<u8> = std::iter::from_fn(|| wire.poll(u64::MAX)).collect();
            assert!(
                heard.windows(2).any(|pair| pair == b"ok"),
                "{round}: {heard:?}"
            );
        }
    }
}
