//! Both directions of the radio between a robot and its ground station.

use std::collections::VecDeque;

use groundwave_protocol::BYTES_PER_S;

use super::modem::{End, Pair};
use super::spec::ChannelSpec;
use super::wire::{Hearing, Wire};
use crate::rng::{Rng, Stream};

/// The radio. It queues the ground station's bytes and asks the robot for each byte when it is due.
#[derive(Debug)]
pub struct Radio {
    spec: ChannelSpec,
    uplink: Wire,
    downlink: Wire,
    modems: Option<Pair>,
    modem_rng: Rng,
    /// The ground station's bytes waiting for their byte time.
    queue: VecDeque<u8>,
    /// Time since the last byte, in 1/1000 of a byte time.
    byte_time: u32,
}

impl Radio {
    /// An idle radio; every random event follows from the seed.
    #[must_use]
    pub fn new(spec: &ChannelSpec, seed: u64) -> Self {
        let wire = |stream| Wire::new(&cable(spec), Rng::new(seed, stream));
        let mut modem_rng = Rng::new(seed, Stream::Modem);
        Self {
            spec: spec.clone(),
            uplink: wire(Stream::Uplink),
            downlink: wire(Stream::Downlink),
            modems: spec
                .modem
                .map(|modem| Pair::new(modem, spec, modem_rng.split())),
            modem_rng,
            queue: VecDeque::new(),
            byte_time: 0,
        }
    }

    /// Replaces the faults; bytes on their way keep their arrival time. Removing a modem loses the bytes in it.
    pub fn set(&mut self, spec: &ChannelSpec) {
        self.uplink.set(&cable(spec));
        self.downlink.set(&cable(spec));
        match (&mut self.modems, spec.modem) {
            (Some(pair), Some(modem)) => pair.set(modem, spec),
            (modems, modem) => {
                *modems = modem.map(|modem| Pair::new(modem, spec, self.modem_rng.split()));
            }
        }
        self.spec = spec.clone();
    }

    /// Advances one millisecond, which ends at `now_ms`. When a byte is due, `robot` returns the robot's next byte or
    /// `None` for an idle line.
    pub fn step(&mut self, now_ms: u64, robot: impl FnOnce() -> Option<u8>) {
        let is_out = self.spec.is_out(now_ms);
        if let Some(modems) = &mut self.modems {
            modems.step(now_ms, is_out);
        }
        self.byte_time += BYTES_PER_S;
        if self.byte_time < 1000 {
            return;
        }
        self.byte_time -= 1000;
        let down = robot();
        let up = self.queue.pop_front();
        if let Some(modems) = &mut self.modems {
            if let Some(byte) = down {
                modems.push(now_ms, End::Robot, byte);
            }
            if let Some(byte) = up {
                modems.push(now_ms, End::Ground, byte);
            }
            self.downlink
                .pass(now_ms, modems.pop(now_ms, End::Ground), Hearing::Line);
            self.uplink
                .pass(now_ms, modems.pop(now_ms, End::Robot), Hearing::Line);
            return;
        }
        let hearing = |own: Option<u8>| match own {
            _ if is_out => Hearing::Out,
            Some(_) if self.spec.half_duplex => Hearing::Deaf,
            _ => Hearing::Line,
        };
        let (at_ground, at_robot) = (hearing(up), hearing(down));
        self.downlink.pass(now_ms, down, at_ground);
        self.uplink.pass(now_ms, up, at_robot);
    }

    /// Queues bytes from the ground station; the radio sends 240 bytes per second.
    pub fn transmit(&mut self, bytes: &[u8]) {
        self.queue.extend(bytes);
    }

    /// Number of uplink bytes that the robot cannot have received yet: queued bytes and bytes in a modem.
    #[must_use]
    pub fn uplink_pending(&self) -> usize {
        let in_modems = self
            .modems
            .as_ref()
            .map_or(0, |pair| pair.in_flight(End::Ground));
        self.queue.len() + in_modems + self.uplink.in_flight()
    }

    /// The next byte that the robot has received by now.
    pub fn poll_uplink(&mut self, now_ms: u64) -> Option<u8> {
        self.uplink.poll(now_ms)
    }

    /// The next byte that the ground station has received by now.
    pub fn poll_downlink(&mut self, now_ms: u64) -> Option<u8> {
        self.downlink.poll(now_ms)
    }
}

/// Faults of the cables to the modems, without bit errors and noise; without a modem the faults of the radio.
fn cable(spec: &ChannelSpec) -> ChannelSpec {
    if spec.modem.is_none() {
        return spec.clone();
    }
    ChannelSpec {
        drop: spec.drop,
        dup: spec.dup,
        delay_ms: spec.delay_ms,
        ..ChannelSpec::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bytes received by the robot and by the ground station, each with its time.
    struct Heard {
        robot: Vec<(u64, u8)>,
        ground: Vec<(u64, u8)>,
    }

    fn run(channel: &str, down: &[u8], up: &[u8], time_ms: u64) -> Heard {
        let mut radio = Radio::new(&channel.parse().unwrap(), 1);
        radio.transmit(up);
        let mut down = down.iter().copied();
        let (mut robot, mut ground) = (Vec::new(), Vec::new());
        for now_ms in 1..=time_ms {
            radio.step(now_ms, || down.next());
            robot.extend(std::iter::from_fn(|| radio.poll_uplink(now_ms)).map(|b| (now_ms, b)));
            ground.extend(std::iter::from_fn(|| radio.poll_downlink(now_ms)).map(|b| (now_ms, b)));
        }
        Heard { robot, ground }
    }

    fn bytes(heard: &[(u64, u8)]) -> Vec<u8> {
        heard.iter().map(|(_, byte)| *byte).collect()
    }

    #[test]
    fn single_byte_takes_the_modems_specified_time() {
        let heard = run("modem=hc-12", b"", b"x", 500);
        let [(at_ms, b'x')] = heard.robot[..] else {
            panic!("{:?}", heard.robot)
        };
        assert!((76..=84).contains(&at_ms), "{at_ms}");
        let heard = run("modem=xbee", b"", b"x", 500);
        assert!(heard.robot[0].0 < 35, "{:?}", heard.robot);
    }

    #[test]
    fn modems_carry_a_long_stream_intact() {
        let line: Vec<u8> = (0..240).collect();
        for channel in ["modem=hc-12", "modem=xbee"] {
            assert_eq!(
                bytes(&run(channel, &line, b"", 3000).ground),
                line,
                "{channel}"
            );
            assert_eq!(
                bytes(&run(channel, b"", &line, 3000).robot),
                line,
                "{channel}"
            );
        }
    }

    #[test]
    fn overlapping_packets_are_lost_without_carrier_sensing() {
        let heard = run("modem=hc-12", b"from the robot", b"from the ground", 1000);
        assert!(heard.robot.is_empty() && heard.ground.is_empty());
        let heard = run("modem=xbee", b"from the robot", b"from the ground", 1000);
        assert_eq!(bytes(&heard.ground), b"from the robot");
        assert_eq!(bytes(&heard.robot), b"from the ground");
    }

    #[test]
    fn one_bit_error_loses_the_whole_packet() {
        let sent = vec![b'x'; 60 * 400];
        let heard = run("modem=hc-12,ber=1e-3", b"", &sent, 110_000);
        assert!(heard.robot.len().is_multiple_of(60));
        // 76 bytes of 8 bits: 54 % survive.
        let share = heard.robot.len() as f64 / sent.len() as f64;
        assert!((0.45..0.63).contains(&share), "{share}");
    }

    #[test]
    fn bytes_in_a_modem_count_as_pending() {
        let mut radio = Radio::new(&"modem=hc-12".parse().unwrap(), 1);
        radio.transmit(b"ten bytes.");
        for now_ms in 1..=60 {
            radio.step(now_ms, || None);
        }
        assert_eq!(radio.uplink_pending(), 10);
        let mut robot = Vec::new();
        for now_ms in 61..=400 {
            radio.step(now_ms, || None);
            robot.extend(std::iter::from_fn(|| radio.poll_uplink(now_ms)));
        }
        assert_eq!(robot, b"ten bytes.");
        assert_eq!(radio.uplink_pending(), 0);
    }

    #[test]
    fn open_squelch_receives_noise_during_silence() {
        assert!(run("squelch", b"", b"", 2000).robot.len() > 50);
        assert!(run("", b"", b"", 2000).robot.is_empty());
        assert!(run("squelch,out=0s..2s", b"", b"", 2000).robot.is_empty());
        assert!(run("squelch=out,out=0s..2s", b"", b"", 2000).robot.len() > 50);
    }
}
