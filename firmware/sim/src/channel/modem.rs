//! Radio modules with a serial port: they collect bytes, send them as a packet and hand them out at the other
//! end. One of them on the air at a time; a packet arrives whole or not at all.
//!
//! Where the figures come from:
//!
//! - HC-12, user manual 2.4, mode FU3: at 2400 baud 5000 bit/s on the air, half duplex, a single byte under
//!   way for up to 80 ms. It says nothing of how packets are formed: the gap, the packet's size and overhead
//!   are chosen so that a lone byte takes those 80 ms. Nor of listening first, so overlapping packets are lost.
//! - XBee 802.15.4, user guides by Digi: 250 kbit/s on the air; a packet goes after RO = 3 byte times without
//!   a byte or when 100 bytes are there; CSMA-CA waits for a free channel; the MAC repeats a packet that is
//!   not acknowledged up to three times.

use std::collections::VecDeque;

use super::noise::Noise;
use super::spec::{ChannelSpec, Modem};
use crate::dice::Dice;

/// Bytes that wait in a module whose air is busy; later ones are lost.
const BUFFER_BYTES: usize = 512;

/// What tells one module from another.
struct Preset {
    /// A pause this long ends a packet.
    gap_ms: u64,
    packet_bytes: usize,
    /// Preamble, addresses, checksum: what goes with each packet on the air.
    overhead_bytes: usize,
    air_bits_per_s: usize,
    /// From the end of a packet on the air until its first byte comes out.
    latency_ms: u64,
    /// Whether it waits until the other one is silent.
    senses_carrier: bool,
    /// How often a packet is sent at most.
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

/// Most milliseconds that a module waits before it looks again whether the air is free.
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
    /// Packets that wait for the air.
    ready: VecDeque<Vec<u8>>,
    backoff_ms: u64,
    flight: Option<Flight>,
    /// Received packets and when their first byte may come out.
    arrived: VecDeque<(u64, Vec<u8>)>,
    /// Received bytes that wait for their byte time on the serial port.
    out: VecDeque<u8>,
    /// Errors of what this one sends.
    noise: Noise,
}

impl Module {
    fn new(spec: &ChannelSpec, dice: Dice) -> Self {
        Self {
            collected: Vec::new(),
            collected_ms: 0,
            ready: VecDeque::new(),
            backoff_ms: 0,
            flight: None,
            arrived: VecDeque::new(),
            out: VecDeque::new(),
            noise: Noise::new(spec, dice),
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

    /// Whether a packet of so many bytes has a flipped bit.
    fn is_hit(&mut self, bytes: usize) -> bool {
        (0..bytes).fold(false, |hit, _| {
            if self.noise.skip(8) {
                return hit;
            }
            // Every bit is drawn: an error must not hide the next one.
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

/// A pair of modules and the air between them.
#[derive(Debug)]
pub(super) struct Pair {
    modem: Modem,
    modules: [Module; 2],
    dice: Dice,
}

impl Pair {
    pub(super) fn new(modem: Modem, spec: &ChannelSpec, mut dice: Dice) -> Self {
        Self {
            modem,
            modules: [
                Module::new(spec, dice.split()),
                Module::new(spec, dice.split()),
            ],
            dice,
        }
    }

    pub(super) fn set(&mut self, modem: Modem, spec: &ChannelSpec) {
        self.modem = modem;
        for module in &mut self.modules {
            module.noise.set(spec);
        }
    }

    /// Takes a byte from an end's serial port.
    pub(super) fn push(&mut self, now_ms: u64, end: End, byte: u8) {
        let module = &mut self.modules[end as usize];
        if module.waiting() < BUFFER_BYTES {
            module.collected.push(byte);
            module.collected_ms = now_ms;
        }
    }

    /// The next byte for an end's serial port, once every byte time.
    pub(super) fn pop(&mut self, now_ms: u64, end: End) -> Option<u8> {
        let module = &mut self.modules[end as usize];
        while let Some((_, packet)) = module.arrived.pop_front_if(|(at_ms, _)| *at_ms <= now_ms) {
            module.out.extend(packet);
        }
        module.out.pop_front()
    }

    /// One millisecond; `is_out`: nothing passes at this moment.
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
            module.backoff_ms = now_ms + 1 + u64::from(self.dice.next_u32() % BACKOFF_MAX_MS);
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
            // Two that collide wait differently long.
            let backoff_ms = u64::from(self.dice.next_u32() % BACKOFF_MAX_MS);
            flight.ends_ms = now_ms + backoff_ms + preset.air_ms(bytes);
            flight.is_spoiled = false;
            module.flight = Some(flight);
        }
    }

    /// How many of an end's bytes the other one has not received yet.
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
