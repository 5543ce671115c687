//! The robot's telemetry, byte by byte.

use crate::common::{BOOTS, Bench, ROBOT_ID, only};
use groundwave_protocol::status_codes::{Bump, Drive, Infrared, Layer, LayerState, Mode, Power};
use groundwave_protocol::telemetry::Body;
use groundwave_protocol::{LINE_BYTES, telemetry};
use sr04_firmware::board::{Echo, Side, Switches};

const LEFT: Switches = Switches {
    left: true,
    center: false,
    right: false,
};

fn kinds(bench: &Bench) -> String {
    let kind = |body: &Body| match body {
        Body::State(_) => 'A',
        Body::Status(_) => 'B',
        Body::Counters(_) => 'C',
        Body::Text(_) => 'T',
        Body::Parameter(_) => 'P',
        Body::Song(_) => 'S',
        Body::Abilities(_) => 'I',
        Body::Field(_) => 'F',
        Body::Values(_) => 'V',
    };
    bench
        .lines
        .iter()
        .map(|(_, line)| kind(&line.body))
        .collect()
}

#[test]
fn stream_is_complete_lines_at_240_bytes_per_second() {
    let mut bench = Bench::new();
    bench.run_ms(100_000);
    assert_eq!(bench.idle, 1);
    assert_eq!(bench.sent.len(), 24_000 - 1);
    let (lines, rest) = bench.sent.as_chunks::<LINE_BYTES>();
    assert_eq!((lines.len(), rest.len()), (299, 79));
    for (n, line) in lines.iter().enumerate() {
        let parsed = telemetry::Line::parse(line).expect("every field is valid");
        assert_eq!(parsed.encode(), *line);
        assert_eq!(usize::from(parsed.sequence), n % 100);
    }
    assert_eq!(bench.lines.len(), 299);
}

#[test]
fn identity_comes_first_and_then_in_every_sixth_line() {
    let mut bench = Bench::new();
    bench.run_ms(12_000);
    assert_eq!(kinds(&bench), "CBAAAAABAAAAACAAAAABAAAAACAAAAABAAA");
    let Body::Counters(counters) = bench.lines[13].1.body else {
        panic!("expected line C");
    };
    assert_eq!(counters.robot_id, ROBOT_ID);
    assert_eq!(counters.boots, BOOTS);
    assert_eq!(counters.uptime_s, 4);
    let Body::Status(status) = bench.lines[1].1.body else {
        panic!("expected line B");
    };
    assert_eq!(status.robot_id, ROBOT_ID);
    assert_eq!(status.fitted, status.allowed);
    assert!(!status.fitted.contains(Layer::Photo));
}

#[test]
fn bump_of_one_tick_appears_in_exactly_one_line() {
    for tick in 0..7 {
        let mut bench = Bench::new();
        bench.run_ms(3000);
        bench.run_ticks(tick);
        bench.lines.clear();
        bench.inputs.bumper = LEFT;
        bench.run_ticks(1);
        bench.inputs.bumper = Switches::default();
        bench.run_ms(3000);
        let bumps: Vec<Bump> = bench.states().map(|state| state.bump).collect();
        let seen = bumps.iter().filter(|&&bump| bump == Bump::Left).count();
        assert_eq!(seen, 1, "tick {tick}: {bumps:?}");
        assert!(
            bumps
                .iter()
                .all(|bump| matches!(bump, Bump::Left | Bump::None))
        );
        let position = bumps.iter().position(|&bump| bump == Bump::Left);
        assert!(
            position <= Some(2),
            "the bump is not in the next line A: {bumps:?}"
        );
    }
}

#[test]
fn line_a_shows_the_holder_and_the_suppressed_layers() {
    let mut bench = Bench::new();
    bench.run_ms(1000);
    bench.inputs.bumper = LEFT;
    bench.inputs.sonar = Some(Echo {
        side: Side::Left,
        range_in: Some(40),
    });
    bench.run_ticks(1);
    bench.inputs.bumper = Switches::default();
    bench.run_ms(1000);
    let state = bench.latest_state();
    assert_eq!(state.layers.get(Layer::Bumpers), LayerState::Holds);
    assert_eq!(state.layers.get(Layer::Sonar), LayerState::Raised);
    assert_eq!(state.layers.get(Layer::Infrared), LayerState::Quiet);
    assert_eq!(state.layers.get(Layer::Photo), LayerState::Off);
    assert_eq!(state.sonar_left_in, Some(40));
    assert_eq!(state.sonar_right_in, None);
    assert_eq!(state.velocity_in_s, -8);
}

#[test]
fn disallowed_sonar_neither_pings_nor_reports() {
    let mut bench = Bench::new();
    bench.inputs.sonar = Some(Echo {
        side: Side::Right,
        range_in: Some(99),
    });
    bench.run_ms(2000);
    assert_eq!(bench.latest_state().sonar_right_in, Some(99));
    let key = bench.open(1);
    let mask = bench.robot.allowed().without(Layer::Sonar);
    bench.order(key, only(mask));
    for _ in 0..40 {
        bench.run_ticks(1);
        assert_eq!(bench.outputs.ping, None);
    }
    assert_eq!(bench.latest_state().sonar_right_in, None);
}

#[test]
fn photocells_and_battery_are_reported_if_fitted() {
    let mut bench = Bench::new();
    bench.inputs.photo_left = Some(255);
    bench.inputs.battery_dv = 114;
    bench.run_ms(2000);
    let state = bench.latest_state();
    assert_eq!(state.photo_left_pct, Some(99));
    assert_eq!(state.photo_right_pct, None);
    assert_eq!(state.power, Power::Low);
    bench.inputs.battery_dv = 100;
    bench.run_ms(20_000);
    assert_eq!(bench.latest_state().power, Power::Critical);
}

#[test]
fn blocked_wheel_is_reported_as_stalled() {
    let mut bench = Bench::new();
    bench.load = 10.0;
    bench.run_ms(6000);
    assert_eq!(bench.latest_state().drive, Drive::Stalled);
    assert_eq!(bench.latest_state().wheel_left_in_s, 0);
}

#[test]
fn infrared_detections_and_jam_are_reported() {
    let mut bench = Bench::new();
    bench.reflects = (false, true);
    bench.run_ms(3000);
    assert_eq!(bench.latest_state().infrared, Infrared::Right);
    assert!(bench.latest_state().rotation_in_s < 0);
    bench.run_ms(29_000);
    assert_eq!(bench.latest_state().infrared, Infrared::Jammed);
    bench.run_ms(31_000);
    assert_eq!(bench.latest_state().infrared, Infrared::Right);
}

#[test]
fn ticks_won_add_up_to_the_held_ticks() {
    let mut bench = Bench::new();
    bench.run_ms(30_000);
    let counters = bench.latest_counters();
    let total: u32 = counters
        .ticks_won
        .iter()
        .map(|&ticks| u32::from(ticks))
        .sum();
    assert!(total.abs_diff(counters.uptime_s * 20) < 20, "{counters:?}");
    assert_eq!(bench.robot.mode(), Mode::Prowl);
}
