//! The guards behind the arbiter, and their telemetry.

use crate::common::{Bench, OWNER, only, running, texts};
use groundwave_protocol::command::Order;
use groundwave_protocol::parameter;
use groundwave_protocol::status_codes::{Arm, Cliff, Layer, LayerState, Mode};
use groundwave_protocol::telemetry::{Body, StateLine};
use sr04_firmware::arbiter::{Holder, MotorGuard};
use sr04_firmware::board::{Edges, Sides, Switches};

const FLOOR: Edges = Edges::NONE;
const ON_THE_LEFT: Edges = Edges::AHEAD_LEFT;
const NOWHERE: Edges = Edges::ALL;

fn on_floor() -> Bench {
    let mut bench = Bench::new();
    bench.inputs.cliff = Some(FLOOR);
    bench.run_ms(3000);
    bench
}

/// Whether line A shows that the cliff guard controls the motors.
fn cliff_guard_holds(state: &StateLine) -> bool {
    state.layers.holder().is_none() && !matches!(state.cliff, Cliff::None | Cliff::NotFitted)
}

#[test]
fn line_a_alone_shows_the_cliff_guard_holding_the_motors() {
    let mut bench = on_floor();
    assert_eq!(bench.latest_state().cliff, Cliff::None);
    bench.inputs.cliff = Some(ON_THE_LEFT);
    // A bump at the edge: bumpers win, and the guard takes the motors from them.
    bench.inputs.bumper = Switches {
        center: true,
        ..Switches::default()
    };
    bench.run_ms(50);
    assert!(
        bench.outputs.pwm_left < 0 && bench.outputs.pwm_right < 0,
        "the guard brakes"
    );
    bench.inputs.bumper = Switches::default();
    let (mut held, at_edge) = (0, bench.robot.pose().y_tenths_in());
    for _ in 0..200 {
        let guarded = bench.robot.guarded();
        let count = bench.lines.len();
        bench.run_ticks(1);
        if bench.robot.pose().y_tenths_in() < at_edge - 30 {
            bench.inputs.cliff = Some(FLOOR);
        }
        let Some((_, line)) = bench.lines.get(count..).and_then(<[_]>::last) else {
            continue;
        };
        // The line was composed up to a third of a second ago: check only after the guard has held that long.
        if let Body::State(state) = line.body
            && guarded == Some(MotorGuard::Cliff)
            && held > 8
        {
            assert!(cliff_guard_holds(&state), "{state:?}");
            assert_eq!(state.cliff, Cliff::Left);
        }
        held = if guarded.is_some() { held + 1 } else { 0 };
    }
    assert!(held == 0 && bench.robot.guarded().is_none());
    bench.run_ms(5000);
    assert_eq!(bench.latest_state().cliff, Cliff::None);
    assert_eq!(texts(&bench), ["cliff guard: there is no floor ahead"]);
}

#[test]
fn guarded_ticks_count_for_no_layer() {
    let mut bench = on_floor();
    let won = |bench: &mut Bench| {
        bench.run_ms(10_000);
        bench.latest_counters().ticks_won[8]
    };
    bench.inputs.cliff = Some(NOWHERE);
    bench.run_ms(10_000);
    let before = won(&mut bench);
    assert_eq!(won(&mut bench), before);
    assert_eq!(bench.robot.holder(), Some(Holder::Prowl));
}

#[test]
fn lowering_arm_holds_the_motors_and_line_a_shows_it() {
    let (mut bench, key) = running();
    bench.inputs.motion = Some(Sides::default());
    bench.run_ms(100);
    let all = bench.robot.allowed().with(Layer::Motion);
    bench.order(key, only(all));
    bench.order(key, Order::Mode(Mode::Reactive));
    bench.run_ms(20_000);
    assert_eq!(bench.latest_state().arm, Arm::Armed);
    // For the duration of a line, from just before it is composed.
    bench.run_to_line_end();
    bench.run_ms(50);
    bench.inputs.bumper.left = true;
    let mut reported = false;
    for _ in 0..11 {
        bench.run_ticks(1);
        assert_eq!(bench.robot.guarded(), Some(MotorGuard::Arm));
    }
    for _ in 0..20 {
        bench.run_ticks(1);
        let state = bench.latest_state();
        reported |= state.arm == Arm::Up && state.layers.get(Layer::Bumpers) == LayerState::Raised;
        assert!(
            state.arm != Arm::Up || state.layers.get(Layer::Bumpers) != LayerState::Holds,
            "{state:?}"
        );
    }
    assert!(reported);
    assert_eq!(bench.robot.guarded(), None);
    bench.run_ms(700);
    assert_eq!(
        bench.latest_state().layers.get(Layer::Bumpers),
        LayerState::Holds
    );
}

#[test]
fn lifted_robot_stops_its_wheels_and_continues_when_put_down() {
    let (mut bench, key) = running();
    bench.inputs.cliff = Some(FLOOR);
    bench.run_ms(2000);
    for mode in [Mode::Prowl, Mode::Wander] {
        bench.order(key, Order::Mode(mode));
        bench.run_ms(2000);
        bench.inputs.cliff = Some(NOWHERE);
        bench.run_ms(500);
        for _ in 0..400 {
            bench.run_ticks(1);
            assert_eq!((bench.outputs.pwm_left, bench.outputs.pwm_right), (0, 0));
        }
        let state = bench.latest_state();
        assert!(cliff_guard_holds(&state) && state.cliff == Cliff::Several);
        assert_eq!((state.velocity_in_s, state.rotation_in_s), (0, 0));
        bench.inputs.cliff = Some(FLOOR);
        bench.run_ms(400);
        assert_eq!(
            bench.outputs.pwm_left, 0,
            "the robot has just been put down"
        );
        bench.run_ms(2000);
        assert_eq!(bench.robot.mode(), mode);
        assert_eq!(bench.robot.motion().velocity_cps, 192);
    }
    let reports = texts(&bench);
    assert_eq!(reports, ["cliff guard: there is no floor under me"; 2]);
}

/// A station that opens the link later hears it, too.
#[test]
fn critical_battery_that_is_off_is_reported_at_once_and_every_minute() {
    let (mut bench, _) = running();
    let key = bench.open(OWNER);
    let set = |value| Order::SetParameter {
        key: parameter::key("battery-critical"),
        value,
    };
    let reports = |bench: &Bench| {
        let is_off = |line: &&groundwave_protocol::telemetry::Line| match line.body {
            Body::Parameter(parameter) => {
                parameter.name.as_str() == "battery-critical" && parameter.value == 0
            }
            _ => false,
        };
        let lines = bench.lines.iter().map(|(_, line)| line);
        lines.filter(is_off).count()
    };
    bench.order(key, set(0));
    bench.lines.clear();
    bench.run_ms(150_000);
    let parameters = reports(&bench);
    assert!((3..=4).contains(&parameters), "{parameters}");
    bench.order(key, set(112));
    bench.run_ms(1000);
    bench.lines.clear();
    bench.run_ms(150_000);
    assert_eq!(reports(&bench), 0);
}

#[test]
fn switched_off_guard_is_reported_at_once_and_every_minute() {
    let (mut bench, _) = running();
    bench.inputs.cliff = Some(FLOOR);
    let key = bench.open(OWNER);
    let set = |value| Order::SetParameter {
        key: parameter::key("cliff-guard"),
        value,
    };
    bench.order(key, set(0));
    bench.lines.clear();
    bench.run_ms(150_000);
    let reports = |bench: &Bench| {
        let is_off = |line: &&groundwave_protocol::telemetry::Line| match line.body {
            Body::Parameter(parameter) => {
                parameter.name.as_str() == "cliff-guard" && parameter.value == 0
            }
            _ => false,
        };
        let lines = bench.lines.iter().map(|(_, line)| line);
        (lines.filter(is_off).count(), texts(bench).len())
    };
    let (parameters, reported) = reports(&bench);
    // The command is answered too.
    assert!(
        reported == 3 && (3..=4).contains(&parameters),
        "{parameters}, {reported}"
    );
    assert!(texts(&bench)[0].contains("guard is switched off"));
    bench.inputs.cliff = Some(ON_THE_LEFT);
    bench.run_ms(2000);
    assert_eq!(
        bench.latest_state().cliff,
        Cliff::Left,
        "line A shows the sensors"
    );
    assert_eq!(bench.robot.guarded(), None);
    bench.order(key, set(1));
    bench.run_ms(1000);
    bench.lines.clear();
    bench.run_ms(150_000);
    assert_eq!(reports(&bench).0, 0);
}
