//! Commands over the radio: their effect, once, and its time.

use crate::common::{Bench, OWNER, ROBOT_ID, activate, drive, only, running, stop};
use groundwave_protocol::Waypoint;
use groundwave_protocol::command::{Command, Key, Message, Order};
use groundwave_protocol::digest::digest;
use groundwave_protocol::status_codes::{self, Layer, LayerMask, Mode};
use groundwave_protocol::telemetry::{Body, Outcome};
use sr04_firmware::arbiter::Holder;
use sr04_firmware::board::{Outputs, Switches};

#[test]
fn robot_boots_prowling_without_a_ground_station() {
    let mut bench = Bench::new();
    bench.run_ms(5000);
    assert_eq!(bench.robot.mode(), Mode::Prowl);
    assert_eq!(bench.robot.holder(), Some(Holder::Prowl));
    assert!(bench.robot.should_move());
    assert!(bench.robot.pose().y_tenths_in() > 400);
}

#[test]
fn stop_needs_no_session_brakes_at_once_and_switches_the_motors_off() {
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
    assert!(!bench.robot.should_move());
    assert_eq!(bench.latest_state().mode, Mode::Stop);
    assert_eq!(bench.left.take_edges(), 0);
}

#[test]
fn stop_ends_the_session_and_its_frames() {
    let (mut bench, key) = running();
    stop(&mut bench);
    bench.order(key, Order::Mode(Mode::Prowl));
    assert_eq!(bench.robot.mode(), Mode::Stop);
    let message = drive(&bench, 1, 12, 0);
    bench.send(&message, key);
    bench.run_ticks(5);
    assert_eq!(bench.outputs.pwm_left, 0);
    // A session opened afterwards can move it.
    let key = bench.open(OWNER);
    bench.order(key, Order::Mode(Mode::Prowl));
    assert_eq!(bench.robot.mode(), Mode::Prowl);
}

#[test]
fn repeated_frame_executes_its_command_once() {
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
fn mode_change_is_reported_in_lines_a_and_b() {
    let (mut bench, key) = running();
    bench.order(key, Order::Mode(Mode::Reactive));
    bench.lines.clear();
    bench.run_ms(1700);
    assert_eq!(bench.latest_state().mode, Mode::Reactive);
    let tells_status = |(_, line): &(u32, groundwave_protocol::telemetry::Line)| {
        matches!(line.body, Body::Status(_))
    };
    assert!(bench.lines.iter().any(tells_status));
    // No obstacles: the robot stands.
    bench.run_ms(2000);
    assert_eq!((bench.outputs.pwm_left, bench.outputs.pwm_right), (0, 0));
    assert_eq!(bench.robot.holder(), None);
}

#[test]
fn commands_for_unfitted_layers_are_refused() {
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
fn disallowed_layer_never_requests_the_motors() {
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
    assert_eq!(
        state.layers.get(Layer::Bumpers),
        status_codes::LayerState::Off
    );
    // The switch itself is reported nevertheless.
    assert_eq!(state.bump, status_codes::Bump::Left);
}

#[test]
fn disallowing_a_layer_ends_its_manoeuvre() {
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
fn frames_of_an_ended_session_are_refused() {
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
    let status = bench.latest_status();
    assert_eq!((status.list.driven, status.list.count), (0, 300));
    assert_eq!(status.digest, digest(list.iter()));
    assert_eq!(status.target_in, Some((-5000, 9999)));
}

#[test]
fn route_ends_with_a_stop_and_a_song() {
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
    assert_eq!(
        sung.collect::<Vec<_>>(),
        [notes],
        "the song is announced once"
    );
    // At the end of the route mode Prowl prowls freely.
    bench.order(key, Order::Mode(Mode::Prowl));
    bench.run_ticks(1);
    assert_eq!(bench.robot.holder(), Some(Holder::Prowl));
    assert_eq!(bench.outputs.note_hz, 0);
    // Activating the same route starts it again.
    activate(&mut bench, key, 2, &list);
    assert_eq!(bench.robot.target(), Some(list[0]));
}

#[test]
fn go_home_drives_to_the_origin() {
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
fn noise_on_the_uplink_changes_nothing() {
    let (mut bench, _) = running();
    let mut rng = 1_u32;
    for _ in 0..100_000 {
        rng = rng.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        bench.robot.handle_uplink((rng >> 24) as u8);
    }
    assert_eq!(bench.robot.mode(), Mode::Prowl);
    assert_eq!(bench.robot.ack().sequence, 0);
    bench.run_ms(3000);
    assert!(bench.outputs.pwm_left > 0);
}
