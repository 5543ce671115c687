//! Streams as received by a UART: noise, and a robot at another baud rate.

use proptest::prelude::Rng;
use proptest::test_runner::{RngAlgorithm, TestRng};

use super::*;
use crate::capture::content::{BYTES_MIN, Looks};
use crate::event::LineRate;

const SECONDS: usize = 20;

/// The robot's bytes: 80-byte lines, three per second.
fn robot() -> Vec<u8> {
    let path = groundwave_captures::samples().join("house-clean.txt");
    let mut bytes = std::fs::read(path).expect("the capture");
    bytes.truncate(80 * 3 * SECONDS);
    bytes
}

fn rng(seed: u8) -> TestRng {
    TestRng::from_seed(RngAlgorithm::ChaCha, &[seed; 32])
}

fn chance(rng: &mut TestRng) -> f64 {
    f64::from(rng.next_u32()) / f64::from(u32::MAX)
}

/// The level of a wire over time, one value per bit of the sender.
struct Wire {
    levels: Vec<bool>,
    baud: f64,
}

impl Wire {
    /// The wire of a robot that sends three lines per second, at any rate of the port.
    fn robot(baud: u32, ber: f64, rng: &mut TestRng) -> Self {
        let mut levels = Vec::new();
        for (n, line) in robot().chunks(80).enumerate() {
            for byte in line {
                levels.push(false);
                levels.extend((0..8).map(|bit| byte >> bit & 1 == 1));
                levels.push(true);
            }
            let next = (n + 1) * baud as usize / 3;
            levels.resize(levels.len().max(next), true);
        }
        for level in &mut levels {
            *level ^= chance(rng) < ber;
        }
        Self {
            levels,
            baud: f64::from(baud),
        }
    }

    /// Noise of an open squelch: the level changes at random, `changes_a_bit` times per bit of 2400 baud.
    fn noise(changes_a_bit: f64, rng: &mut TestRng) -> Self {
        const STEPS: usize = 8;
        let mut level = true;
        let levels = (0..2400 * SECONDS * STEPS)
            .map(|_| {
                let change = (1.0 - (-2.0 * changes_a_bit / STEPS as f64).exp()) / 2.0;
                level ^= chance(rng) < change;
                level
            })
            .collect();
        Self {
            levels,
            baud: 2400.0 * STEPS as f64,
        }
    }

    fn level(&self, time_s: f64) -> bool {
        let bit = (time_s * self.baud) as usize;
        self.levels.get(bit).copied().unwrap_or(true)
    }

    /// The bytes that a UART receives. Receivers treat a broken stop bit differently: they keep or drop the byte, and
    /// wait for the idle level or take the bit for a start bit.
    fn heard_at(&self, baud: u32, keeps: bool, waits: bool) -> Vec<u8> {
        // No two clocks are alike.
        let bit_s = 1.003 / f64::from(baud);
        let end_s = self.levels.len() as f64 / self.baud;
        let step_s = bit_s / 16.0;
        let mut bytes = Vec::new();
        let mut time_s = 0.0;
        while time_s < end_s {
            if self.level(time_s) || self.level(time_s + bit_s / 2.0) {
                time_s += step_s;
                continue;
            }
            let middle_s = time_s + bit_s / 2.0;
            let byte = (0..8).fold(0, |byte, bit| {
                let level = self.level(middle_s + bit_s * f64::from(bit + 1));
                byte | u8::from(level) << bit
            });
            time_s = middle_s + bit_s * 9.0;
            let is_whole = self.level(time_s);
            if is_whole || keeps {
                bytes.push(byte);
            }
            while waits && !is_whole && time_s < end_s && !self.level(time_s) {
                time_s += step_s;
            }
        }
        bytes
    }
}

const RECEIVERS: [(bool, bool); 4] = [(false, true), (true, true), (false, false), (true, false)];

/// Judges a stream window by window.
fn verdicts(bytes: &[u8]) -> Vec<Reception> {
    bytes.chunks(WINDOW).filter_map(judge).collect()
}

#[test]
fn a_robot_at_another_rate_is_recognised_from_either_side() {
    let rng = &mut rng(1);
    let wire = Wire::robot(2400, 0.0, rng);
    for (keeps, waits) in RECEIVERS {
        for (baud, rate) in [
            (600, LineRate::Faster),
            (1200, LineRate::Faster),
            (4800, LineRate::Slower),
            (9600, LineRate::Slower),
            (19200, LineRate::Slower),
        ] {
            let found = verdicts(&wire.heard_at(baud, keeps, waits));
            assert!(!found.is_empty(), "{baud}");
            let wanted = Reception::WrongRate(rate);
            assert!(
                found.iter().all(|reception| *reception == wanted),
                "heard at {baud}, {keeps} {waits}: {found:?}"
            );
        }
    }
}

#[test]
fn a_radio_that_is_faster_than_the_port_is_recognised() {
    let rng = &mut rng(2);
    for baud in [4800, 9600, 19200] {
        let wire = Wire::robot(baud, 0.0, rng);
        for (keeps, waits) in RECEIVERS {
            let found = verdicts(&wire.heard_at(2400, keeps, waits));
            let wanted = Reception::WrongRate(LineRate::Faster);
            assert!(
                !found.is_empty() && found.iter().all(|reception| *reception == wanted),
                "{baud} heard at 2400, {keeps} {waits}: {found:?}"
            );
        }
    }
}

#[test]
fn a_wrong_rate_is_recognised_through_bit_errors() {
    let rng = &mut rng(3);
    let wire = Wire::robot(2400, 3e-3, rng);
    for baud in [1200, 4800, 9600] {
        let found = verdicts(&wire.heard_at(baud, true, true));
        let wrong = |reception: &Reception| matches!(reception, Reception::WrongRate(_));
        assert!(found.iter().all(wrong), "{baud}: {found:?}");
    }
}

#[test]
fn noise_is_called_noise() {
    let rng = &mut rng(4);
    for changes_a_bit in [10.0, 3.0, 1.0, 0.5, 0.25] {
        let wire = Wire::noise(changes_a_bit, rng);
        for (keeps, waits) in RECEIVERS {
            let found = verdicts(&wire.heard_at(2400, keeps, waits));
            assert!(
                !found.is_empty() && found.iter().all(|reception| *reception == Reception::Noise),
                "{changes_a_bit} changes a bit, {keeps} {waits}: {found:?}"
            );
        }
    }
    let mut white = vec![0; 100 * WINDOW];
    rng.fill_bytes(&mut white);
    assert!(verdicts(&white).iter().all(|r| *r == Reception::Noise));
}

#[test]
fn damaged_lines_are_no_wrong_rate() {
    let rng = &mut rng(5);
    for ber in [0.0, 3e-3, 1e-2, 3e-2] {
        let wire = Wire::robot(2400, ber, rng);
        let found = verdicts(&wire.heard_at(2400, false, true));
        assert!(
            found
                .iter()
                .all(|reception| *reception == Reception::Damaged),
            "{ber}: {found:?}"
        );
    }
}

/// Passes bytes in groups, and the time; returns the reports.
fn listen(
    listener: &mut Listener,
    from_s: u64,
    until_s: u64,
    mut bytes: impl FnMut() -> Vec<u8>,
) -> Vec<(u64, Reception)> {
    let mut told = Vec::new();
    for second in from_s..until_s {
        let now = Moment::from_secs(second);
        let news = [
            listener.take(now, &bytes(), false),
            listener.handle_timeout(now),
        ];
        told.extend(news.into_iter().flatten().map(|(what, _)| (second, what)));
        assert!(
            listener.poll_timeout().is_none_or(|at| at > now),
            "asks for the past at {second}"
        );
        assert!(listener.window.len() <= WINDOW);
    }
    told
}

fn open() -> Listener {
    let mut listener = Listener::default();
    listener.open(true);
    listener
}

#[test]
fn hours_of_silence_are_reported_once_with_their_beginning() {
    let mut listener = open();
    assert_eq!(
        listener.take(Moment::from_secs(7), b"\n", true),
        Some((Reception::Lines, Moment::from_secs(7)))
    );
    assert_eq!(listener.handle_timeout(Moment::from_secs(11)), None);
    assert_eq!(
        listener.handle_timeout(Moment::from_secs(12)),
        Some((Reception::Nothing, Moment::from_secs(7)))
    );
    assert_eq!(listen(&mut listener, 13, 4 * 3600, Vec::new), []);
    assert_eq!(listener.poll_timeout(), None, "nothing to wake up for");
}

#[test]
fn hours_of_noise_are_reported_once_and_memory_stays() {
    let mut listener = open();
    let mut rng = rng(6);
    let noise = || {
        let mut bytes = vec![0; 220];
        rng.fill_bytes(&mut bytes);
        bytes
    };
    assert_eq!(
        listen(&mut listener, 0, 3 * 3600, noise),
        [(5, Reception::Noise)]
    );
}

#[test]
fn a_closed_link_is_not_judged_and_an_opened_one_afresh() {
    let mut listener = open();
    listener.take(Moment::from_secs(1), &[0x55; 2000], false);
    listener.open(false);
    assert_eq!(listen(&mut listener, 2, 100, || vec![0x55; 100]), []);
    assert_eq!(listener.poll_timeout(), None);
    listener.open(true);
    assert_eq!(
        listen(&mut listener, 100, 120, Vec::new),
        [(105, Reception::Nothing)]
    );
}

#[test]
fn a_line_in_five_seconds_is_reception() {
    let mut listener = open();
    for second in 0..1000 {
        let now = Moment::from_secs(second);
        listener.take(now, &[0xA5; 200], second % 4 == 0);
        listener.handle_timeout(now);
        assert_eq!(listener.reported, Some(Reception::Lines), "at {second} s");
    }
}

/// Damaged text may look like a wrong rate. Therefore a rate that was right counts as right for a minute.
#[test]
fn a_rate_that_was_right_is_trusted_for_a_minute() {
    let mut listener = open();
    listener.take(Moment::ZERO, b"\n", true);
    let slow = || vec![0xF0; 200];
    let told = listen(&mut listener, 1, 200, slow);
    let wrong = Reception::WrongRate(LineRate::Slower);
    assert_eq!(told, [(5, Reception::Damaged), (60, wrong)]);
}

/// Prints the table from which the thresholds were chosen: `cargo test --lib looks -- --ignored --nocapture`.
#[test]
#[ignore = "prints a table"]
fn looks_of_everything() {
    let print = |what: &str, heard: &dyn Fn(bool, bool) -> Vec<u8>| {
        let looks: Vec<Looks> = RECEIVERS
            .iter()
            .flat_map(|&(keeps, waits)| {
                let bytes = heard(keeps, waits);
                let windows = bytes
                    .chunks(WINDOW)
                    .filter(|window| window.len() >= BYTES_MIN);
                windows.map(Looks::of).collect::<Vec<_>>()
            })
            .collect();
        let range = |of: fn(&Looks) -> f64| {
            let low = looks.iter().map(of).fold(1.0, f64::min);
            let high = looks.iter().map(of).fold(0.0, f64::max);
            format!("{:5.1} to {:5.1} %", low * 100.0, high * 100.0)
        };
        println!(
            "{what:34} {:3} windows: printable {}, repeats {}, alone {}",
            looks.len(),
            range(|l| l.printable),
            range(|l| l.repeats),
            range(|l| l.alone)
        );
    };
    let rng = &mut rng(9);
    let wire = Wire::robot(2400, 0.0, rng);
    for baud in [300, 600, 1200, 4800, 9600, 19200, 57600, 115_200] {
        print(&format!("2400 heard at {baud}"), &|k, w| {
            wire.heard_at(baud, k, w)
        });
    }
    for baud in [4800, 9600, 19200, 57600, 115_200] {
        let wire = Wire::robot(baud, 0.0, rng);
        print(&format!("{baud} heard at 2400"), &|k, w| {
            wire.heard_at(2400, k, w)
        });
    }
    for ber in [0.0, 1e-2, 5e-2] {
        let wire = Wire::robot(2400, ber, rng);
        print(&format!("bit error rate {ber}"), &|k, w| {
            wire.heard_at(2400, k, w)
        });
    }
    for changes_a_bit in [10.0, 1.0, 0.5, 0.25, 0.1] {
        let wire = Wire::noise(changes_a_bit, rng);
        print(&format!("noise, {changes_a_bit} changes a bit"), &|k, w| {
            wire.heard_at(2400, k, w)
        });
    }
}

/// What was not read while this station was suspended says nothing about the robot.
#[test]
fn a_suspension_is_no_silence_of_the_robot() {
    let at = Moment::from_secs;
    for is_suspended in [false, true] {
        let mut listener = Listener::default();
        listener.open(true);
        listener.take(at(1), &robot()[..80], true);
        if is_suspended {
            listener.resume(at(8));
        }
        let reported = listener.handle_timeout(at(8)).map(|(it, _)| it);
        assert_eq!(reported, (!is_suspended).then_some(Reception::Nothing));
    }
}
