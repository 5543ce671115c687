//! Both directions of the radio between a robot and its ground station.

use std::collections::VecDeque;

use groundwave_protocol::BYTES_PER_S;

use super::spec::ChannelSpec;
use super::wire::Wire;
use crate::dice::{Dice, Stream};

/// The radio: the ground's bytes wait for their byte time, the robot is asked for its byte when one is due.
#[derive(Debug)]
pub struct Radio {
    spec: ChannelSpec,
    uplink: Wire,
    downlink: Wire,
    /// The ground's bytes that wait for their byte time.
    queue: VecDeque<u8>,
    /// Thousandths of a byte time gone since the last one.
    byte_time: u32,
}

impl Radio {
    /// A radio at rest. Everything that happens to its bytes by chance follows from the seed.
    #[must_use]
    pub fn new(spec: &ChannelSpec, seed: u64) -> Self {
        let wire = |stream| Wire::new(spec, Dice::new(seed, stream));
        Self {
            spec: spec.clone(),
            uplink: wire(Stream::Uplink),
            downlink: wire(Stream::Downlink),
            queue: VecDeque::new(),
            byte_time: 0,
        }
    }

    /// Exchanges the faults from now on; bytes on their way keep their time.
    pub fn set(&mut self, spec: &ChannelSpec) {
        self.uplink.set(spec);
        self.downlink.set(spec);
        self.spec = spec.clone();
    }

    /// One millisecond, which ends at `now_ms`. When a byte time is due, `robot` says which byte the robot
    /// sends, or `None` for an idle line.
    pub fn step(&mut self, now_ms: u64, robot: impl FnOnce() -> Option<u8>) {
        self.byte_time += BYTES_PER_S;
        if self.byte_time < 1000 {
            return;
        }
        self.byte_time -= 1000;
        let down = robot();
        let up = self.queue.pop_front();
        let is_out = self.spec.is_out(now_ms);
        let is_deaf = |own: Option<u8>| is_out || self.spec.half_duplex && own.is_some();
        let (ground_deaf, robot_deaf) = (is_deaf(up), is_deaf(down));
        self.downlink.pass(now_ms, down, !ground_deaf);
        self.uplink.pass(now_ms, up, !robot_deaf);
    }

    /// Queues what the ground sends; it leaves at 240 bytes a second.
    pub fn transmit(&mut self, bytes: &[u8]) {
        self.queue.extend(bytes);
    }

    /// How many of the ground's bytes the robot cannot have received yet: those that wait for their
    /// byte time, and those in a modem.
    #[must_use]
    pub fn uplink_pending(&self) -> usize {
        self.queue.len() + self.uplink.in_flight()
    }

    /// The next byte that the robot has received by now.
    pub fn poll_uplink(&mut self, now_ms: u64) -> Option<u8> {
        self.uplink.poll(now_ms)
    }

    /// The next byte that the ground has received by now.
    pub fn poll_downlink(&mut self, now_ms: u64) -> Option<u8> {
        self.downlink.poll(now_ms)
    }
}
