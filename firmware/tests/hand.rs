//! The operator's hand, and what the robot does when it is gone: the dead man and the failsafe.

use crate::common::{Bench, ROBOT_ID, drive, live, only, running};
use groundwave_protocol::command::{Keepalive, Key, Message, Order};
use groundwave_protocol::failsafe::Failsafe;
use groundwave_protocol::letters::{self, Layer, LayerMask, Mode};
use groundwave_protocol::telemetry::{Body, Outcome};
use sr04_firmware::arbiter::Holder;

#[test]
fn the_hand_overrides_everything_for_a_second_and_a_tick_later_it_is_free() {
    let (mut bench, key) = running();
    bench.inputs.bumper.center = true;
    let message = drive(&bench, 1, -6, 8);
    bench.send(&message, key);
    for tick in 0..20 {
        bench.run_ticks(1);
        assert_eq!(
            bench.robot.holder(),
            Some(Holder::Layer(Layer::User)),
            "tick {tick}"
        );
        assert_eq!(bench.robot.motion().velocity_cps, -96);
    }
    bench.run_ticks(1);
    assert_eq!(bench.robot.holder(), Some(Holder::Layer(Layer::Bumpers)));
}

#[test]
fn in_mode_user_a_silent_ground_stops_it_within_a_second() {
    let (mut bench, key) = running();
    bench.order(key, Order::Mode(Mode::User));
    bench.run_ms(2000);
    assert_eq!((bench.outputs.pwm_left, bench.outputs.pwm_right), (0, 0));
    live(&mut bench, key);
    let message = drive(&bench, 1, 10, 0);
    bench.send(&message, key);
    bench.run_ticks(20);
    assert_eq!(bench.robot.motion().velocity_cps, 160);
    bench.run_ticks(1);
    assert_eq!(bench.robot.motion().velocity_cps, 0);
    assert_eq!(bench.robot.holder(), Some(Holder::Layer(Layer::User)));
}

#[test]
fn a_drive_frame_that_is_late_repeated_or_comes_while_stopped_moves_nothing() {
    let (mut bench, key) = running();
    let late = drive(&bench, 1, 10, 0);
    let holder = |bench: &mut Bench| {
        bench.run_ticks(1);
        bench.robot.holder()
    };
    bench.run_ms(3000);
    bench.send(&late, key);
    assert_eq!(holder(&mut bench), Some(Holder::Prowl));
    let fresh = drive(&bench, 2, 10, 0);
    bench.send(&fresh, key);
    assert_eq!(
        holder(&mut bench),
        Some(Holder::Prowl),
        "no sign of the ground"
    );
    live(&mut bench, key);
    let fresh = drive(&bench, 2, 10, 0);
    bench.send(&fresh, key);
    assert_eq!(holder(&mut bench), Some(Holder::Layer(Layer::User)));
    bench.run_ticks(20);
    bench.send(&fresh, key);
    assert_eq!(holder(&mut bench), Some(Holder::Prowl));
    bench.order(key, Order::Mode(Mode::Stop));
    let fresh = drive(&bench, 3, 10, 0);
    bench.send(&fresh, key);
    assert_eq!(holder(&mut bench), None);
    bench.run_ticks(4);
    assert_eq!(bench.outputs.pwm_left, 0);
}

/// A bridge lets go, after a hundred lines, what it held back: every line it names looks new.
#[test]
fn hand_drive_that_was_held_back_for_a_hundred_lines_moves_nothing() {
    let (mut bench, key) = running();
    live(&mut bench, key);
    let mut held = Vec::new();
    for count in 1..=10 {
        bench.run_ms(200);
        held.push(drive(&bench, count, 10, 0));
    }
    let from = bench.latest_sequence();
    bench.run_ms(20_000);
    while bench.latest_sequence() != from {
        bench.run_ms(10);
    }
    for message in &held {
        bench.send(message, key);
        bench.run_ticks(1);
        assert_eq!(bench.robot.holder(), Some(Holder::Prowl));
    }
    live(&mut bench, key);
    let fresh = drive(&bench, 5, 10, 0);
    bench.send(&fresh, key);
    bench.run_ticks(1);
    assert_eq!(bench.robot.holder(), Some(Holder::Layer(Layer::User)));
}

#[test]
fn nobody_drives_by_hand_while_a_failsafe_acts() {
    let (mut bench, key) = running();
    let home = Order::Failsafe(Some(Failsafe {
        silence_s: 10,
        mode: Mode::GoHome,
    }));
    bench.order(key, home);
    bench.run_ms(11_000);
    assert_eq!(bench.robot.mode(), Mode::GoHome);
    live(&mut bench, key);
    let message = drive(&bench, 1, 10, 0);
    bench.send(&message, key);
    bench.run_ticks(1);
    assert_ne!(bench.robot.holder(), Some(Holder::Layer(Layer::User)));
}

#[test]
fn a_robot_told_to_goes_home_when_the_ground_falls_silent_and_says_so() {
    let (mut bench, key) = running();
    let failsafe = Failsafe {
        silence_s: 10,
        mode: Mode::GoHome,
    };
    bench.order(key, Order::Failsafe(Some(failsafe)));
    assert_eq!(bench.robot.ack().outcome, Outcome::Done);
    bench.run_ms(9_900);
    assert_eq!(bench.robot.mode(), Mode::Prowl);
    assert_eq!(bench.latest_state().link, letters::Link::Armed);
    bench.run_ms(200);
    assert_eq!(bench.robot.mode(), Mode::GoHome);
    bench.run_ms(2000);
    assert_eq!(bench.latest_state().link, letters::Link::Failsafe);
    assert!(has_said(&bench, "failsafe: the ground is silent"));
    // Being heard again changes nothing until the operator says what is next.
    let heard = bench.lines.last().expect("a line").1.sequence;
    bench.send(&Message::Keepalive(Keepalive { heard }), key);
    bench.run_ms(2000);
    assert_eq!(bench.latest_state().link, letters::Link::Failsafe);
    bench.order(key, Order::Mode(Mode::Prowl));
    bench.run_ms(2000);
    assert_eq!(bench.latest_state().link, letters::Link::Armed);
    assert!(has_said(&bench, "failsafe is over"));
    let counters = bench
        .lines
        .iter()
        .rev()
        .find_map(|(_, line)| match &line.body {
            Body::Counters(counters) => Some(counters.failsafe),
            _ => None,
        });
    assert_eq!(counters, Some(Some(failsafe)));
}

fn has_said(bench: &Bench, words: &str) -> bool {
    bench
        .lines
        .iter()
        .any(|(_, line)| matches!(&line.body, Body::Text(text) if text.as_str() == words))
}

/// Presets switch layers off that going home is made of.
#[test]
fn going_home_allows_what_it_takes_to_get_there() {
    let (mut bench, key) = running();
    bench.order(
        key,
        only(LayerMask::NONE.with(Layer::Bumpers).with(Layer::Photo)),
    );
    let failsafe = Failsafe {
        silence_s: 10,
        mode: Mode::GoHome,
    };
    bench.order(key, Order::Failsafe(Some(failsafe)));
    bench.run_ms(12_000);
    assert_eq!(bench.robot.mode(), Mode::GoHome);
    assert!(bench.robot.target().is_some());
    assert_eq!(
        bench.robot.holder(),
        Some(Holder::Layer(Layer::DeadReckoning))
    );
}

#[test]
fn a_stopped_robot_stays_where_it_is_however_silent_the_ground() {
    let (mut bench, key) = running();
    let home = Order::Failsafe(Some(Failsafe {
        silence_s: 10,
        mode: Mode::GoHome,
    }));
    bench.order(key, home);
    bench.send(&Message::Stop, Key::robot(ROBOT_ID));
    bench.run_ms(30_000);
    assert_eq!(bench.robot.mode(), Mode::Stop);
    // A session alone is no reason to move either.
    bench.open(1);
    bench.run_ms(30_000);
    assert_eq!(bench.robot.mode(), Mode::Stop);
}

#[test]
fn a_failsafe_that_no_robot_should_follow_is_refused() {
    let (mut bench, key) = running();
    for (silence_s, mode, outcome) in [
        (9, Mode::Stop, Outcome::BadValue),
        (60, Mode::User, Outcome::BadValue),
        (60, Mode::Passive, Outcome::NotFitted),
    ] {
        let failsafe = Failsafe { silence_s, mode };
        bench.order(key, Order::Failsafe(Some(failsafe)));
        assert_eq!(bench.robot.ack().outcome, outcome, "{failsafe:?}");
    }
}
