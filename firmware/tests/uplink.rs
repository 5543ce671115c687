//! Orders over bytes: what the robot does about them, once, and when.

mod common;

use common::{Bench, ROBOT_ID, only};
use groundwave_protocol::Waypoint;
use groundwave_protocol::command::{Command, Drive, Keepalive, Key, Message, Order, Slots};
use groundwave_protocol::digest::digest;
use groundwave_protocol::failsafe::Failsafe;
use groundwave_protocol::letters::{self, Layer, LayerMask, Mode};
use groundwave_protocol::telemetry::{Body, Outcome};
use std::fmt::Write;

use groundwave_protocol::parameter::key as key_of;
use groundwave_protocol::telemetry::ParameterLine;
use sr04_firmware::arbiter::Holder;
use sr04_firmware::board::{Duplex, Outputs, Switches};
use sr04_firmware::parameters::Parameter;

const OWNER: u16 = 345;

fn running() -> (Bench, Key) {
    let mut bench = Bench::new();
    bench.run_ms(2000);
    let key = bench.open(OWNER);
    (bench, key)
}

fn stop(bench: &mut Bench) {
    bench.send(&Message::Stop, Key::robot(ROBOT_ID));
}

/// Sends a whole list and the command that activates it.
fn activate(bench: &mut Bench, key: Key, tag: u8, list: &[Waypoint]) {
    for (n, chunk) in list.chunks(16).enumerate() {
        let slots = Slots::new(tag, n as u8 * 4, chunk);
        bench.send(&Message::Waypoints(slots), key);
    }
    let order = Order::Activate {
        tag,
        count: list.len() as u16,
        digest: digest(list.iter()),
    };
    bench.order(key, order);
}

fn drive(bench: &Bench, count: u8, velocity_in_s: i8, rotation_in_s: i8) -> Message {
    Message::Drive(Drive {
        velocity_in_s,
        rotation_in_s,
        heard: bench.lines.last().expect("a line").1.sequence,
        count,
    })
}

#[test]
fn it_boots_prowling_and_needs_no_ground() {
    let mut bench = Bench::new();
    bench.run_ms(5000);
    assert_eq!(bench.robot.mode(), Mode::Prowl);
    assert_eq!(bench.robot.holder(), Some(Holder::Prowl));
    assert!(bench.robot.is_told_to_move());
    assert!(bench.robot.pose().y_tenths_in() > 400);
}

#[test]
fn stop_works_without_a_session_brakes_at_the_next_tick_and_then_has_the_motors_off() {
    let mut bench = Bench::new();
    bench.run_ms(2000);
    assert!(bench.outputs.pwm_left > 0);
    stop(&mut bench);
    assert_eq!(bench.robot.mode(), Mode::Stop);
    bench.run_ticks(1);
    assert!(bench.outputs.pwm_left < 0 && bench.outputs.pwm_right < 0);
    bench.run_ticks(4);
    assert_eq!((bench.outputs.pwm_left, bench.outputs.pwm_right), (0, 0));
    bench.run_ms(20_000);
    assert_eq!(
        bench.outputs,
        Outputs {
            ping: bench.outputs.ping,
            ..Outputs::default()
        }
    );
    assert!(!bench.robot.is_told_to_move());
    assert_eq!(bench.latest_state().mode, Mode::Stop);
    assert_eq!(bench.left.take_edges(), 0);
}

#[test]
fn stop_ends_the_session_so_that_nothing_sent_before_moves_it_again() {
    let (mut bench, key) = running();
    stop(&mut bench);
    bench.order(key, Order::Mode(Mode::Prowl));
    assert_eq!(bench.robot.mode(), Mode::Stop);
    let message = drive(&bench, 1, 12, 0);
    bench.send(&message, key);
    bench.run_ticks(5);
    assert_eq!(bench.outputs.pwm_left, 0);
    // A session opened after it does.
    let key = bench.open(OWNER);
    bench.order(key, Order::Mode(Mode::Prowl));
    assert_eq!(bench.robot.mode(), Mode::Prowl);
}

#[test]
fn a_command_is_carried_out_once_however_often_its_frame_arrives() {
    let (mut bench, key) = running();
    let set = Order::Pose {
        position: Waypoint {
            x_in: 100,
            y_in: -50,
        },
        theta_deg: 90,
    };
    let frame = bench.order(key, set);
    assert_eq!(bench.robot.pose().x_tenths_in(), 1000);
    bench.run_ms(3000);
    let driven_to = bench.robot.pose();
    assert!(driven_to.x_tenths_in() > 1200);
    for _ in 0..5 {
        bench.send(&frame, key);
    }
    assert_eq!(bench.robot.pose(), driven_to);
    assert_eq!(bench.robot.ack().sequence, 1);
    assert_eq!(bench.robot.ack().outcome, Outcome::Done);
}

#[test]
fn a_mode_arrives_in_the_line_and_in_line_b() {
    let (mut bench, key) = running();
    bench.order(key, Order::Mode(Mode::Reactive));
    bench.lines.clear();
    bench.run_ms(1700);
    assert_eq!(bench.latest_state().mode, Mode::Reactive);
    let tells_status = |(_, line): &(u32, groundwave_protocol::telemetry::Line)| {
        matches!(line.body, Body::Status(_))
    };
    assert!(bench.lines.iter().any(tells_status));
    // Nothing near: it stands.
    bench.run_ms(2000);
    assert_eq!((bench.outputs.pwm_left, bench.outputs.pwm_right), (0, 0));
    assert_eq!(bench.robot.holder(), None);
}

#[test]
fn what_is_not_fitted_is_refused_and_changes_nothing() {
    let (mut bench, key) = running();
    let all = bench.robot.allowed();
    let mut refuse = |order, outcome| {
        bench.order(key, order);
        assert_eq!(bench.robot.ack().outcome, outcome, "{order:?}");
        assert_eq!(bench.robot.mode(), Mode::Prowl);
        assert_eq!(bench.robot.allowed(), all);
    };
    refuse(Order::Mode(Mode::Passive), Outcome::NotFitted);
    refuse(only(LayerMask::ALL), Outcome::NotFitted);
    refuse(only(all.with(Layer::Photo)), Outcome::NotFitted);
    refuse(only(all.with(Layer::Motion)), Outcome::NotFitted);
    refuse(Order::Unknown, Outcome::Unknown);
}

#[test]
fn a_layer_that_is_not_allowed_never_raises() {
    let (mut bench, key) = running();
    let mask = bench.robot.allowed().without(Layer::Bumpers);
    bench.order(key, only(mask));
    assert_eq!(bench.robot.ack().outcome, Outcome::Done);
    assert_eq!(bench.robot.allowed(), mask);
    bench.inputs.bumper = Switches {
        left: true,
        center: false,
        right: false,
    };
    for _ in 0..100 {
        bench.run_ticks(1);
        assert_eq!(bench.robot.holder(), Some(Holder::Prowl));
    }
    let state = bench.latest_state();
    assert_eq!(state.layers.get(Layer::Bumpers), letters::LayerState::Off);
    // The switch itself is told all the same.
    assert_eq!(state.bump, letters::Bump::Left);
}

#[test]
fn a_manoeuvre_ends_when_its_layer_is_no_longer_allowed_and_does_not_come_back() {
    let (mut bench, key) = running();
    let all = bench.robot.allowed();
    bench.inputs.bumper.left = true;
    bench.run_ticks(1);
    bench.inputs.bumper.left = false;
    bench.run_ticks(3);
    assert_eq!(bench.robot.holder(), Some(Holder::Layer(Layer::Bumpers)));
    bench.order(key, only(all.without(Layer::Bumpers)));
    bench.run_ticks(1);
    assert_eq!(bench.robot.holder(), Some(Holder::Prowl));
    bench.order(key, only(all));
    bench.run_ticks(1);
    assert_eq!(bench.robot.holder(), Some(Holder::Prowl));
}

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

/// The ground shows that it is there.
fn live(bench: &mut Bench, key: Key) {
    let heard = bench.lines.last().expect("a line").1.sequence;
    bench.send(&Message::Keepalive(Keepalive { heard }), key);
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
fn frames_of_a_session_that_has_passed_are_refused() {
    let (mut bench, stale) = running();
    let key = bench.open(OWNER + 1);
    let order = Message::Command(Command {
        sequence: 1,
        order: Order::Mode(Mode::GoHome),
    });
    bench.send(&order, stale);
    bench.send(&order, Key::session(ROBOT_ID, 0, 1, OWNER));
    bench.send(&order, Key::session(ROBOT_ID + 1, 5, 2, OWNER + 1));
    assert_eq!(bench.robot.mode(), Mode::Prowl);
    bench.send(&order, key);
    assert_eq!(bench.robot.mode(), Mode::GoHome);
}

#[test]
fn three_hundred_waypoints_are_staged_activated_and_reported() {
    let (mut bench, key) = running();
    let list: Vec<Waypoint> = (0..300)
        .map(|n| Waypoint {
            x_in: n * 33 - 5000,
            y_in: 9999 - n * 66,
        })
        .collect();
    activate(&mut bench, key, 1, &list);
    assert_eq!(bench.robot.ack().outcome, Outcome::Done);
    assert_eq!(bench.robot.lists().active(), list);
    assert_eq!(bench.robot.target(), Some(list[0]));
    assert_eq!(bench.robot.mode(), Mode::Prowl);
    bench.run_ms(2000);
    let status = bench
        .lines
        .iter()
        .rev()
        .find_map(|(_, line)| match line.body {
            Body::Status(status) => Some(status),
            _ => None,
        });
    let status = status.expect("an extra line B");
    assert_eq!((status.list.driven, status.list.count), (0, 300));
    assert_eq!(status.digest, digest(list.iter()));
    assert_eq!(status.target_in, Some((-5000, 9999)));
}

#[test]
fn a_route_is_driven_to_its_end_where_it_stops_and_sings() {
    let (mut bench, key) = running();
    let list = [(60, 60), (60, 0), (-20, -20)].map(|(x_in, y_in)| Waypoint { x_in, y_in });
    activate(&mut bench, key, 1, &list);
    let mut seconds = 0;
    while bench.robot.mode() == Mode::Prowl {
        let holder = bench.robot.holder();
        assert!(seconds < 60, "{:?}", bench.robot.pose());
        bench.run_ms(1000);
        seconds += 1;
        assert!(
            holder == Some(Holder::Prowl) || holder == Some(Holder::Layer(Layer::DeadReckoning))
        );
    }
    assert_eq!(bench.robot.mode(), Mode::Stop);
    assert_eq!(bench.robot.driven(), 3);
    let pose = bench.robot.pose();
    let (x, y) = (pose.x_tenths_in() + 200, pose.y_tenths_in() + 200);
    assert!(x * x + y * y <= 75 * 75, "{pose:?}");
    let mut sang = false;
    for _ in 0..60 {
        bench.run_ticks(1);
        sang |= bench.outputs.note_hz > 0;
        assert_eq!(bench.outputs.pwm_left, 0);
    }
    assert!(sang);
    let text = |bench: &Bench| {
        bench.lines.iter().any(|(_, line)| match &line.body {
            Body::Text(text) => text.as_str() == "I'm finished with the co-ordinate list",
            _ => false,
        })
    };
    assert!(text(&bench));
    let sung = bench.lines.iter().filter_map(|(_, line)| match &line.body {
        Body::Song(song) => Some(song.notes().count()),
        _ => None,
    });
    let notes = sr04_firmware::song::Song::Finished.notes().len();
    assert_eq!(sung.collect::<Vec<_>>(), [notes], "the song is told once");
    // Prowling on with the list at its end is prowling freely.
    bench.order(key, Order::Mode(Mode::Prowl));
    bench.run_ticks(1);
    assert_eq!(bench.robot.holder(), Some(Holder::Prowl));
    assert_eq!(bench.outputs.note_hz, 0);
    // The same list again starts it over.
    activate(&mut bench, key, 2, &list);
    assert_eq!(bench.robot.target(), Some(list[0]));
}

#[test]
fn home_is_the_origin_wherever_it_is() {
    let (mut bench, key) = running();
    bench.run_ms(8000);
    bench.order(key, Order::Mode(Mode::GoHome));
    assert_eq!(bench.robot.target(), Waypoint::new(0, 0));
    bench.run_ms(40_000);
    assert_eq!(bench.robot.mode(), Mode::Stop);
    let pose = bench.robot.pose();
    assert!(
        pose.x_tenths_in().abs() < 70 && pose.y_tenths_in().abs() < 70,
        "{pose:?}"
    );
}

#[test]
fn while_the_ground_talks_and_for_four_lines_after_acknowledgement_lines_follow() {
    let (mut bench, key) = running();
    bench.run_ms(5000);
    let before = bench.ack_lines;
    bench.run_ms(5000);
    assert_eq!(bench.ack_lines, before);
    let heard = bench.lines.last().expect("a line").1.sequence;
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

/// What a half-duplex robot sends and when it is silent: a letter a line, a number of idle byte times.
fn conversation(bench: &Bench, from: usize) -> String {
    let mut told = String::new();
    let mut silent = 0;
    let mut position = 0;
    for byte in &bench.air[from..] {
        match byte {
            None => silent += 1,
            Some(byte) => {
                if silent > 0 {
                    write!(told, "{silent} ").expect("a string takes it");
                    silent = 0;
                }
                if position == 0 {
                    told.push(char::from(*byte));
                    told.push(' ');
                }
                position = if *byte == b'\n' { 0 } else { position + 1 };
            }
        }
    }
    told
}

#[test]
fn a_half_duplex_robot_listens_after_each_line() {
    let mut bench = Bench::with_duplex(Duplex::Half { patience_bytes: 16 });
    bench.run_ms(5000);
    assert!(
        conversation(&bench, 0).starts_with("1 C G 17 B G 17 A G 17 A G 17 A G 17 "),
        "{}",
        conversation(&bench, 0)
    );
}

#[test]
fn a_half_duplex_robot_hears_the_ground_out_and_acknowledges_at_once() {
    let mut bench = Bench::with_duplex(Duplex::Half { patience_bytes: 16 });
    bench.run_ms(5000);
    while bench.air.last() != Some(&None) {
        bench.run_ms(1);
    }
    let begun = bench.air.len();
    // Noise of a hundred bytes: the turn ends sixteen byte times after the last one.
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
    let told = conversation(&bench, begun);
    assert!(told.starts_with("117 K G 17 A K G 17 "), "{told}");
}

#[test]
fn three_line_feeds_in_a_row_end_a_turn_and_two_do_not() {
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
    let told = conversation(&bench, begun);
    assert!(told.starts_with("14 K G 17 "), "{told}");
}

#[test]
fn a_half_duplex_robot_listens_to_noise_for_three_lines_and_no_longer() {
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
    let told = conversation(&bench, begun);
    assert!(told.contains(" 242 A G 242 "), "{told}");
}

#[test]
fn noise_on_a_silent_channel_brings_no_acknowledgement_lines() {
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
fn the_acknowledgement_is_latched_just_before_its_columns() {
    // From the first columns of a line on, until its acknowledgement begins, news still gets into it.
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
        let line = bench.lines.last().expect("a line").1;
        assert_eq!(line.ack.session == session, taken, "after {sent} bytes");
    }
}

#[test]
fn garbage_on_the_uplink_changes_nothing() {
    let (mut bench, _) = running();
    let mut dice = 1_u32;
    for _ in 0..100_000 {
        dice = dice.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        bench.robot.handle_uplink((dice >> 24) as u8);
    }
    assert_eq!(bench.robot.mode(), Mode::Prowl);
    assert_eq!(bench.robot.ack().sequence, 0);
    bench.run_ms(3000);
    assert!(bench.outputs.pwm_left > 0);
}

fn told(bench: &Bench) -> Vec<ParameterLine> {
    let lines = bench.lines.iter();
    lines
        .filter_map(|(_, line)| match line.body {
            Body::Parameter(parameter) => Some(parameter),
            _ => None,
        })
        .collect()
}

#[test]
fn a_parameter_is_set_told_and_kept() {
    let (mut bench, key) = running();
    let speed = Parameter::TopSpeed;
    let named = key_of(speed.definition().name);
    bench.order(
        key,
        Order::SetParameter {
            key: named,
            value: 8,
        },
    );
    assert_eq!(bench.robot.ack().outcome, Outcome::Done);
    assert_eq!(bench.robot.parameters().get(speed), 8);
    bench.run_ms(2000);
    let [line] = told(&bench)[..] else {
        panic!("one line P");
    };
    assert_eq!(
        (line.name.as_str(), line.unit.as_str()),
        ("top-speed", "in/s")
    );
    assert_eq!(
        (line.value, line.kept, line.least, line.most),
        (8, 12, 2, 12)
    );
    assert_eq!(usize::from(line.count), Parameter::ALL.len());

    bench.order(key, Order::KeepParameters);
    assert!(!bench.outputs.keep_parameters);
    bench.run_ticks(1);
    assert!(bench.outputs.keep_parameters, "for one tick");
    bench.run_ticks(1);
    assert!(!bench.outputs.keep_parameters, "and no longer");
    bench.run_ms(2000);
    let kept = told(&bench).last().map(|line| (line.value, line.kept));
    assert_eq!(kept, Some((8, 8)));
    assert_eq!(told(&bench).len(), 2, "only what changed is told");
}

#[test]
fn what_no_parameter_takes_is_refused_and_its_limits_are_told() {
    let (mut bench, key) = running();
    let before = bench.robot.parameters().clone();
    let set = |value| Order::SetParameter {
        key: key_of("top-speed"),
        value,
    };
    let nobody = key_of("warp-speed");
    for (order, outcome, lines) in [
        (set(13), Outcome::BadValue, 1),
        (set(70_000), Outcome::BadValue, 1),
        (
            Order::SetParameter {
                key: nobody,
                value: 1,
            },
            Outcome::Unknown,
            0,
        ),
        (Order::ReadParameter { key: nobody }, Outcome::Unknown, 0),
        (Order::ReadParameters { place: 4095 }, Outcome::BadValue, 0),
    ] {
        bench.lines.clear();
        bench.order(key, order);
        assert_eq!(bench.robot.ack().outcome, outcome, "{order:?}");
        bench.run_ms(2000);
        assert_eq!(told(&bench).len(), lines, "{order:?}");
        assert_eq!(bench.robot.parameters(), &before);
    }
}

#[test]
fn every_parameter_is_told_when_all_are_asked_for() {
    let (mut bench, key) = running();
    bench.order(key, Order::ReadParameters { place: 0 });
    bench.run_ms(40_000);
    let places: Vec<_> = told(&bench)
        .iter()
        .map(|line| usize::from(line.place))
        .collect();
    let all: Vec<_> = (1..=Parameter::ALL.len()).collect();
    assert_eq!(places, all);
    bench.lines.clear();
    bench.order(key, Order::ReadParameters { place: 3 });
    bench.run_ms(2000);
    let [line] = told(&bench)[..] else {
        panic!("one line P");
    };
    assert_eq!(line.name.as_str(), Parameter::ALL[2].definition().name);
}
