//! Manual driving, the dead man's handle and the failsafe.

use crate::common::{Bench, ROBOT_ID, drive, live, only, running};
use groundwave_protocol::command::{Keepalive, Key, Message, Order};
use groundwave_protocol::failsafe::Failsafe;
use groundwave_protocol::status_codes::{self, Layer, LayerMask, Mode};
use groundwave_protocol::telemetry::{Body, Outcome};
use sr04_firmware::arbiter::Holder;

#[test]
fn drive_frame_overrides_all_layers_for_one_second() {
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
fn mode_user_stops_after_a_second_without_drive_frames() {
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
fn late_repeated_and_stopped_drive_frames_move_nothing() {
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
        "no proof that the ground station is present"
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

/// A bridge releases delayed frames after a hundred lines, so every line they name looks current.
#[test]
fn drive_frames_delayed_by_a_hundred_lines_move_nothing() {
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
fn drive_frames_are_refused_while_a_failsafe_acts() {
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
fn failsafe_goes_home_after_silence_and_reports_it() {
    let (mut bench, key) = running();
    let failsafe = Failsafe {
        silence_s: 10,
        mode: Mode::GoHome,
    };
    bench.order(key, Order::Failsafe(Some(failsafe)));
    assert_eq!(bench.robot.ack().outcome, Outcome::Done);
    bench.run_ms(9_900);
    assert_eq!(bench.robot.mode(), Mode::Prowl);
    assert_eq!(bench.latest_state().link, status_codes::Link::Armed);
    bench.run_ms(200);
    assert_eq!(bench.robot.mode(), Mode::GoHome);
    bench.run_ms(2000);
    assert_eq!(bench.latest_state().link, status_codes::Link::Failsafe);
    assert!(has_said(&bench, "failsafe: the ground is silent"));
    // A frame alone changes nothing until the operator commands.
    let heard = bench.lines.last().expect("a line was received").1.sequence;
    bench.send(&Message::Keepalive(Keepalive { heard }), key);
    bench.run_ms(2000);
    assert_eq!(bench.latest_state().link, status_codes::Link::Failsafe);
    bench.order(key, Order::Mode(Mode::Prowl));
    bench.run_ms(2000);
    assert_eq!(bench.latest_state().link, status_codes::Link::Armed);
    assert!(has_said(&bench, "failsafe is over"));
    assert_eq!(bench.latest_counters().failsafe, Some(failsafe));
}

fn has_said(bench: &Bench, words: &str) -> bool {
    bench
        .lines
        .iter()
        .any(|(_, line)| matches!(&line.body, Body::Text(text) if text.as_str() == words))
}

/// Presets can switch off layers that going home needs.
#[test]
fn going_home_allows_the_layers_it_needs() {
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
fn stopped_robot_ignores_the_silence() {
    let (mut bench, key) = running();
    let home = Order::Failsafe(Some(Failsafe {
        silence_s: 10,
        mode: Mode::GoHome,
    }));
    bench.order(key, home);
    bench.send(&Message::Stop(None), Key::robot(ROBOT_ID));
    bench.run_ms(30_000);
    assert_eq!(bench.robot.mode(), Mode::Stop);
    // A session alone does not move it either.
    bench.open(1);
    bench.run_ms(30_000);
    assert_eq!(bench.robot.mode(), Mode::Stop);
}

#[test]
fn invalid_failsafe_is_refused() {
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
