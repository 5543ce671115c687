//! Radio modules with a serial port: they collect bytes, send them as a packet and output them at the other end. Only
//! one module can use the channel at a time; a packet arrives complete or not at all.
//!
//! Sources of the figures:
//!
//! - HC-12, user manual 2.4, mode FU3: at 2400 baud 5000 bit/s on the air, half duplex, up to 80 ms for a single
//!   byte. The manual does not describe packets: gap, packet size and overhead are chosen so that a single byte takes
//!   80 ms. It does not mention carrier sensing, so overlapping packets are lost.
//! - XBee 802.15.4, user guides by Digi: 250 kbit/s on the air; a packet is sent after RO = 3 byte times without a
//!   byte or at 100 bytes; CSMA-CA waits for a free channel; the MAC repeats an unacknowledged packet up to three
//!   times.

use std::collections::VecDeque;

use super::noise::Noise;
use super::spec::{ChannelSpec, Modem};
use crate::rng::Rng;

/// Capacity of a module's transmit buffer; further bytes are lost.
const BUFFER_BYTES: usize = 512;

/// Properties of a type of module.
struct Preset {
    /// Pause that ends a packet, milliseconds.
    gap_ms: u64,
    packet_bytes: usize,
    /// Preamble, addresses and checksum of each packet on the air.
    overhead_bytes: usize,
    air_bits_per_s: usize,
    /// Time from the end of a packet on the air to its first byte at the output.
    latency_ms: u64,
    /// Whether the module waits for a free channel.
    senses_carrier: bool,
    /// Maximum number of transmissions of a packet.
    tries: u8,
}

const fn preset(modem: Modem) -> Preset {
    match modem {
        Modem::Hc12 => Preset {
            gap_ms: 10,
            packet_bytes: 60,
            overhead_bytes: 16,
            air_bits_per_s: 5000,
            latency_ms: 34,
            senses_carrier: false,
            tries: 1,
        },
        Modem::Xbee => Preset {
            gap_ms: 13,
            packet_bytes: 100,
            overhead_bytes: 20,
            air_bits_per_s: 250_000,
            latency_ms: 1,
            senses_carrier: true,
            tries: 4,
        },
    }
}

/// Maximum wait before a module checks the channel again, milliseconds.
const BACKOFF_MAX_MS: u32 = 3;

#[derive(Debug)]
struct Flight {
    packet: Vec<u8>,
    tries_left: u8,
    ends_ms: u64,
    is_spoiled: bool,
}

/// One module.
#[derive(Debug)]
struct Module {
    collected: Vec<u8>,
    collected_ms: u64,
    /// Packets waiting for the channel.
    ready: VecDeque<Vec<u8>>,
    backoff_ms: u64,
    flight: Option<Flight>,
    /// Received packets, each with the time at which its first byte may be output.
    arrived: VecDeque<(u64, Vec<u8>)>,
    /// Received bytes waiting for their byte time on the serial port.
    out: VecDeque<u8>,
    /// Bit errors of the packets that this module sends.
    noise: Noise,
}

impl Module {
    fn new(spec: &ChannelSpec, rng: Rng) -> Self {
        Self {
            collected: Vec::new(),
            collected_ms: 0,
            ready: VecDeque::new(),
            backoff_ms: 0,
            flight: None,
            arrived: VecDeque::new(),
            out: VecDeque::new(),
            noise: Noise::new(spec, rng),
        }
    }

    fn waiting(&self) -> usize {
        self.collected.len() + self.ready.iter().map(Vec::len).sum::<usize>()
    }

    fn in_flight(&self) -> usize {
        self.waiting() + self.flight.as_ref().map_or(0, |flight| flight.packet.len())
    }

    fn undelivered(&self) -> usize {
        self.out.len() + self.arrived.iter().map(|(_, p)| p.len()).sum::<usize>()
    }

    /// Whether a packet of this many bytes has a flipped bit.
    fn is_hit(&mut self, bytes: usize) -> bool {
        (0..bytes).fold(false, |hit, _| {
            if self.noise.skip(8) {
                return hit;
            }
            // Every bit is drawn: one error must not hide the next.
            (0..8).fold(hit, |hit, _| self.noise.flip() | hit)
        })
    }
}

/// The two ends of a pair of modules.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum End {
    Robot,
    Ground,
}

/// A pair of modules and the channel between them.
#[derive(Debug)]
pub(super) struct Pair {
    modem: Modem,
    modules: [Module; 2],
    rng: Rng,
}

impl Pair {
    pub(super) fn new(modem: Modem, spec: &ChannelSpec, mut rng: Rng) -> Self {
        Self {
            modem,
            modules: [
                Module::new(spec, rng.split()),
                Module::new(spec, rng.split()),
            ],
            rng,
        }
    }

    pub(super) fn set(&mut self, modem: Modem, spec: &ChannelSpec) {
        self.modem = modem;
        for module in &mut self.modules {
            module.noise.set(spec);
        }
    }

    /// Takes a byte from the serial port of one end.
    pub(super) fn push(&mut self, now_ms: u64, end: End, byte: u8) {
        let module = &mut self.modules[end as usize];
        if module.waiting() < BUFFER_BYTES {
            module.collected.push(byte);
            module.collected_ms = now_ms;
        }
    }

    /// The next byte for the serial port of one end; call it once per byte time.
    pub(super) fn pop(&mut self, now_ms: u64, end: End) -> Option<u8> {
        let module = &mut self.modules[end as usize];
        while let Some((_, packet)) = module.arrived.pop_front_if(|(at_ms, _)| *at_ms <= now_ms) {
            module.out.extend(packet);
        }
        module.out.pop_front()
    }

    /// Advances one millisecond; during an outage (`is_out`) packets on the air are lost.
    pub(super) fn step(&mut self, now_ms: u64, is_out: bool) {
        let preset = preset(self.modem);
        for end in 0..2 {
            self.close_packet(now_ms, end, &preset);
            self.begin(now_ms, end, &preset);
        }
        let both = self.modules.iter().all(|module| module.flight.is_some());
        for flight in self.modules.iter_mut().filter_map(|m| m.flight.as_mut()) {
            flight.is_spoiled |= is_out || both;
        }
        for end in 0..2 {
            self.finish(now_ms, end, &preset);
        }
    }

    fn close_packet(&mut self, now_ms: u64, end: usize, preset: &Preset) {
        let module = &mut self.modules[end];
        let is_full = module.collected.len() >= preset.packet_bytes;
        let is_over = !module.collected.is_empty() && now_ms >= module.collected_ms + preset.gap_ms;
        if is_full || is_over {
            module
                .ready
                .push_back(std::mem::take(&mut module.collected));
        }
    }

    fn begin(&mut self, now_ms: u64, end: usize, preset: &Preset) {
        let is_busy = self.modules[1 - end].flight.is_some();
        let module = &mut self.modules[end];
        if module.flight.is_some() || module.ready.is_empty() || now_ms < module.backoff_ms {
            return;
        }
        if preset.senses_carrier && is_busy {
            module.backoff_ms = now_ms + 1 + u64::from(self.rng.next_u32() % BACKOFF_MAX_MS);
            return;
        }
        if let Some(packet) = module.ready.pop_front() {
            module.flight = Some(Flight {
                ends_ms: now_ms + preset.air_ms(packet.len()),
                packet,
                tries_left: preset.tries,
                is_spoiled: false,
            });
        }
    }

    fn finish(&mut self, now_ms: u64, end: usize, preset: &Preset) {
        let module = &mut self.modules[end];
        let Some(mut flight) = module.flight.take_if(|flight| now_ms >= flight.ends_ms) else {
            return;
        };
        let bytes = flight.packet.len();
        if !(module.is_hit(bytes + preset.overhead_bytes) | flight.is_spoiled) {
            let at_ms = now_ms + preset.latency_ms;
            self.modules[1 - end]
                .arrived
                .push_back((at_ms, flight.packet));
            return;
        }
        flight.tries_left -= 1;
        if flight.tries_left > 0 {
            // Random waits keep two modules from colliding again.
            let backoff_ms = u64::from(self.rng.next_u32() % BACKOFF_MAX_MS);
            flight.ends_ms = now_ms + backoff_ms + preset.air_ms(bytes);
            flight.is_spoiled = false;
            module.flight = Some(flight);
        }
    }

    /// Number of bytes of one end that the other end has not received.
    pub(super) fn in_flight(&self, from: End) -> usize {
        let to = 1 - from as usize;
        self.modules[from as usize].in_flight() + self.modules[to].undelivered()
    }
}

impl Preset {
    const fn air_ms(&self, bytes: usize) -> u64 {
        let bits = (bytes + self.overhead_bytes) * 8;
        (bits * 1000).div_ceil(self.air_bits_per_s) as u64
    }
}
