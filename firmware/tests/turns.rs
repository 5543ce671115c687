//! Acknowledgement lines and turn-taking.

use crate::common::{Bench, OWNER, running};
use groundwave_protocol::command::{Keepalive, Message};
use sr04_firmware::board::Duplex;
use std::fmt::Write;

/// A half-duplex robot's transmission: a letter per line, a number per run of idle byte times.
fn conversation(bench: &Bench, from: usize) -> String {
    let mut text = String::new();
    let mut silent = 0;
    let mut position = 0;
    for byte in &bench.air[from..] {
        match byte {
            None => silent += 1,
            Some(byte) => {
                if silent > 0 {
                    write!(text, "{silent} ").expect("writing to a string cannot fail");
                    silent = 0;
                }
                if position == 0 {
                    text.push(char::from(*byte));
                    text.push(' ');
                }
                position = if *byte == b'\n' { 0 } else { position + 1 };
            }
        }
    }
    text
}

#[test]
fn half_duplex_robot_listens_after_each_line() {
    let mut bench = Bench::with_duplex(Duplex::Half { patience_bytes: 16 });
    bench.run_ms(5000);
    assert!(
        conversation(&bench, 0).starts_with("1 C G 17 B G 17 A G 17 A G 17 A G 17 "),
        "{}",
        conversation(&bench, 0)
    );
}

#[test]
fn half_duplex_robot_waits_for_the_end_of_the_ground_stations_turn() {
    let mut bench = Bench::with_duplex(Duplex::Half { patience_bytes: 16 });
    bench.run_ms(5000);
    while bench.air.last() != Some(&None) {
        bench.run_ms(1);
    }
    let begun = bench.air.len();
    // A hundred bytes of noise: the turn ends sixteen byte times after the last.
    let mut heard = 0;
    while heard < 100 {
        let before = bench.air.len();
        bench.run_ms(1);
        if bench.air.len() > before {
            bench
                .robot
                .handle_uplink(if heard == 99 { b'\n' } else { b'~' });
            heard += 1;
        }
    }
    bench.run_ms(1000);
    let text = conversation(&bench, begun);
    assert!(text.starts_with("117 K G 17 A K G 17 "), "{text}");
}

#[test]
fn three_line_feeds_end_a_turn_and_two_do_not() {
    let mut bench = Bench::with_duplex(Duplex::Half { patience_bytes: 16 });
    bench.run_ms(5000);
    while bench.air.last() != Some(&None) {
        bench.run_ms(1);
    }
    let begun = bench.air.len();
    for byte in *b"\n~~~\n\n~~~\n\n\n" {
        let count = bench.air.len();
        while bench.air.len() == count {
            bench.run_ms(1);
        }
        bench.robot.handle_uplink(byte);
    }
    bench.run_ms(1000);
    let text = conversation(&bench, begun);
    assert!(text.starts_with("14 K G 17 "), "{text}");
}

#[test]
fn half_duplex_robot_listens_to_noise_for_three_lines_at_most() {
    let mut bench = Bench::with_duplex(Duplex::Half { patience_bytes: 16 });
    bench.run_ms(5000);
    let begun = bench.air.len();
    for _ in 0..10_000 {
        let before = bench.air.len();
        bench.run_ms(1);
        if bench.air.len() > before {
            bench.robot.handle_uplink(b'~');
        }
    }
    let text = conversation(&bench, begun);
    assert!(text.contains(" 242 A G 242 "), "{text}");
}

#[test]
fn acknowledgement_lines_follow_line_feeds_for_four_lines() {
    let (mut bench, key) = running();
    bench.run_ms(5000);
    let before = bench.ack_lines;
    bench.run_ms(5000);
    assert_eq!(bench.ack_lines, before);
    let heard = bench.lines.last().expect("a line was received").1.sequence;
    bench.send(&Message::Keepalive(Keepalive { heard }), key);
    bench.run_ms(5000);
    assert_eq!(bench.ack_lines - before, 12);
    for _ in 0..10 {
        bench.robot.handle_uplink(b'\n');
        bench.run_ms(510);
    }
    let during = bench.ack_lines - before - 12;
    assert!((27..=33).contains(&during), "{during}");
}

#[test]
fn noise_without_line_feeds_brings_no_acknowledgement_lines() {
    let (mut bench, _) = running();
    bench.run_ms(5000);
    let before = bench.ack_lines;
    for byte in (0..=255).filter(|byte| *byte != b'\n') {
        bench.robot.handle_uplink(byte);
        bench.run_ms(20);
    }
    assert_eq!(bench.ack_lines, before);
}

#[test]
fn acknowledgement_is_latched_just_before_its_columns() {
    // A change is included until the acknowledgement of the line begins.
    for (sent, taken) in [(5, true), (68, true), (69, true), (70, false)] {
        let (mut bench, _) = running();
        bench.run_ms(5000);
        bench.run_to_line_end();
        let begun = bench.sent.len();
        while bench.sent.len() < begun + sent {
            bench.run_ms(1);
        }
        bench.open(OWNER + 1);
        let session = bench.robot.ack().session;
        bench.run_to_line_end();
        let line = bench.lines.last().expect("a line was received").1;
        assert_eq!(line.ack.session == session, taken, "after {sent} bytes");
    }
}
