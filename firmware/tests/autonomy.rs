//! Activities that the robot starts itself: calling the operator, docking, charging, and continuing.

use crate::common::{Bench, only, running, texts};
use groundwave_protocol::command::Order;
use groundwave_protocol::parameter;
use groundwave_protocol::status_codes::{Arm, Layer, Mode, Power};
use groundwave_protocol::telemetry::Body;
use sr04_firmware::board::{Sides, Switches};

#[test]
fn low_battery_calls_the_operator_every_five_minutes() {
    let mut bench = Bench::new();
    bench.run_ms(2000);
    assert!(texts(&bench).is_empty());
    bench.inputs.battery_dv = 114;
    bench.run_ms(290_000);
    let calls = texts(&bench);
    assert_eq!(calls.len(), 1, "{calls:?}");
    assert!(calls[0].contains("battery is low"), "{calls:?}");
    assert_eq!(bench.robot.mode(), Mode::Prowl, "the robot only calls");
    bench.run_ms(60_000);
    assert_eq!(texts(&bench).len(), 2);
}

fn songs(bench: &Bench) -> usize {
    let is_song = |body: &Body| matches!(body, Body::Song(_));
    bench
        .lines
        .iter()
        .filter(|(_, line)| is_song(&line.body))
        .count()
}

#[test]
fn critical_battery_stops_the_robot_until_the_operator_drives_on() {
    for mode in [Mode::Prowl, Mode::User, Mode::Reactive] {
        let (mut bench, key) = running();
        bench.order(key, Order::Mode(mode));
        bench.run_ms(1000);
        bench.inputs.battery_dv = 110;
        bench.run_ms(20_000);
        assert_eq!(bench.robot.mode(), Mode::Stop);
        assert_eq!((bench.outputs.pwm_left, bench.outputs.pwm_right), (0, 0));
        assert_eq!(bench.latest_state().power, Power::Critical);
        let last = texts(&bench).pop().expect("the robot calls");
        assert!(last.contains("nearly empty"), "{last}");
        assert!(songs(&bench) >= 1);
        // The operator may still drive it.
        bench.order(key, Order::Mode(mode));
        bench.run_ms(30_000);
        assert_eq!(bench.robot.mode(), mode);
        // A fresh battery, which becomes empty in time too.
        bench.inputs.battery_dv = 126;
        bench.run_ms(30_000);
        assert_eq!(bench.robot.mode(), mode);
        bench.inputs.battery_dv = 110;
        bench.run_ms(20_000);
        assert_eq!(bench.robot.mode(), Mode::Stop);
    }
}

#[test]
fn critical_battery_is_ignored_on_the_way_to_the_dock_and_with_limit_zero() {
    let (mut bench, key) = running();
    bench.inputs.beacon = Some(Sides::default());
    bench.run_ms(100);
    bench.order(key, Order::Mode(Mode::Forage));
    bench.inputs.battery_dv = 108;
    bench.run_ms(30_000);
    assert_eq!(bench.robot.mode(), Mode::Forage);
    bench.inputs.is_docked = true;
    bench.order(key, Order::Mode(Mode::Prowl));
    bench.run_ms(5000);
    assert_eq!(bench.robot.mode(), Mode::Prowl, "the battery is charging");
    bench.inputs.is_docked = false;
    bench.run_ms(1000);
    assert_eq!(bench.robot.mode(), Mode::Stop);

    let (mut bench, key) = running();
    let never = Order::SetParameter {
        key: parameter::key("battery-critical"),
        value: 0,
    };
    bench.order(key, never);
    bench.inputs.battery_dv = 90;
    bench.run_ms(30_000);
    assert_eq!(bench.robot.mode(), Mode::Prowl);
    assert_eq!(bench.latest_state().power, Power::Low);
}

#[test]
fn robot_forages_docks_charges_and_returns_to_its_mode() {
    let mut bench = Bench::new();
    bench.inputs.beacon = Some(Sides::default());
    let key = bench.open(77);
    bench.order(key, Order::Mode(Mode::Reactive));
    bench.run_ms(1000);
    bench.order(key, Order::Mode(Mode::Forage));
    bench.inputs.beacon = Some(Sides {
        left: true,
        right: true,
    });
    bench.run_ms(3000);
    assert_eq!(bench.robot.mode(), Mode::Forage);
    assert!(
        bench.robot.motion().velocity_cps > 0,
        "the robot follows the beacon"
    );
    bench.inputs.is_docked = true;
    bench.inputs.bumper.center = true;
    bench.inputs.battery_dv = 130;
    bench.run_ms(2000);
    assert_eq!(
        bench.robot.motion().velocity_cps,
        0,
        "dock contact is no bump"
    );
    assert_eq!(bench.latest_state().power, Power::Charging);
    // Three quarters of an hour at the charger's voltage.
    bench.inputs.battery_dv = 138;
    bench.run_ms(2_690_000);
    assert_eq!(bench.robot.mode(), Mode::Forage);
    assert_eq!(bench.robot.motion().velocity_cps, 0);
    bench.run_ms(40_000);
    bench.inputs.is_docked = false;
    bench.inputs.bumper.center = false;
    bench.inputs.beacon = Some(Sides::default());
    bench.run_ms(20_000);
    assert_eq!(bench.robot.mode(), Mode::Reactive);
    assert!(bench.robot.pose().y_tenths_in() < 600);
}

const BUMPED: Switches = Switches {
    left: false,
    center: true,
    right: false,
};

#[test]
fn repeated_mode_command_restarts_the_mode() {
    let (mut bench, key) = running();
    bench.inputs.beacon = Some(Sides::default());
    bench.inputs.motion = Some(Sides::default());

    bench.order(key, Order::Mode(Mode::Wander));
    bench.run_ms(170_000);
    let again = bench.order(key, Order::Mode(Mode::Wander));
    bench.run_ms(100_000);
    // A repeated frame is the same command.
    bench.send(&again, key);
    bench.run_ms(79_000);
    assert_eq!(
        bench.robot.mode(),
        Mode::Wander,
        "three minutes from the repeated command"
    );
    bench.run_ms(2000);
    assert_eq!(bench.robot.mode(), Mode::GoHome);

    let without_7 = bench.robot.allowed().without(Layer::DeadReckoning);
    bench.order(key, only(without_7));
    bench.run_ms(100);
    assert_eq!(bench.robot.target(), None);
    bench.order(key, Order::Mode(Mode::GoHome));
    assert!(bench.robot.target().is_some(), "home needs layer 7");

    bench.order(key, Order::Mode(Mode::Calibrate));
    bench.run_ms(5000);
    assert!(bench.robot.pose().y_tenths_in() > 50);
    bench.order(key, Order::Mode(Mode::Calibrate));
    assert_eq!(bench.robot.pose().y_tenths_in(), 0, "the square restarts");

    bench.order(key, Order::Mode(Mode::Reactive));
    bench.order(key, Order::Mode(Mode::Passive));
    bench.run_ms(4000);
    bench.inputs.bumper = BUMPED;
    bench.order(key, Order::Mode(Mode::Passive));
    bench.inputs.bumper = Switches::default();
    // The robot scans again, completes the sequence, and returns to the mode before both commands.
    bench.run_ms(60_000);
    assert_eq!(bench.latest_state().arm, Arm::Armed);
    bench.inputs.motion = Some(Sides {
        left: true,
        right: true,
    });
    bench.run_ms(500);
    bench.inputs.motion = Some(Sides::default());
    bench.run_ms(10_000);
    assert_eq!(bench.robot.mode(), Mode::Reactive);
}

#[test]
fn repeated_forage_command_still_returns_to_the_previous_mode() {
    let (mut bench, key) = running();
    bench.inputs.beacon = Some(Sides::default());
    bench.order(key, Order::Mode(Mode::Reactive));
    bench.order(key, Order::Mode(Mode::Forage));
    bench.inputs.beacon = Some(Sides {
        left: true,
        right: true,
    });
    bench.run_ms(1000);
    bench.order(key, Order::Mode(Mode::Forage));
    bench.inputs.is_docked = true;
    bench.inputs.battery_dv = 138;
    bench.run_ms(2_740_000);
    bench.inputs.is_docked = false;
    bench.run_ms(20_000);
    assert_eq!(bench.robot.mode(), Mode::Reactive);
}
