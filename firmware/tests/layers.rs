//! Interaction of layers: priorities, modes and telemetry.

use crate::common::{BOOTS, Bench, ROBOT_ID, only, texts};
use groundwave_protocol::command::{Drive, Key, Message, Order};
use groundwave_protocol::status_codes::{Arm, Layer, LayerMask, LayerState, Mode};
use groundwave_protocol::telemetry::Outcome;
use proptest::prelude::*;
use sr04_firmware::arbiter::Holder;
use sr04_firmware::arm::SWING_TICKS;
use sr04_firmware::board::{Duplex, Echo, Identity, Inputs, Side, Sides, Switches};
use sr04_firmware::parameters::{Parameter, Parameters};
use sr04_firmware::robot::Robot;

const BUMPED: Switches = Switches {
    left: true,
    center: false,
    right: false,
};

const NOTHING_MOVES: Option<Sides> = Some(Sides {
    left: false,
    right: false,
});

const LEFT_MOVES: Option<Sides> = Some(Sides {
    left: true,
    right: false,
});

/// The bench's robot with other parameters.
fn robot(parameters: Parameters) -> Robot {
    let identity = Identity::new(ROBOT_ID, BOOTS, 1, Duplex::Full);
    Robot::restored(identity, parameters)
}

/// A robot with every sensor, one second after its start, and an open session.
fn fitted() -> (Bench, Key) {
    let mut bench = Bench::new();
    bench.inputs.photo_left = Some(120);
    bench.inputs.photo_right = Some(120);
    bench.inputs.motion = NOTHING_MOVES;
    bench.run_ms(1000);
    let key = bench.open(5);
    bench.run_ms(500);
    (bench, key)
}

fn drive(bench: &mut Bench, key: Key, velocity_in_s: i8) {
    let drive = Drive {
        velocity_in_s,
        rotation_in_s: 0,
        heard: bench.latest_sequence(),
        count: bench.now_ms as u8 & 63,
    };
    bench.send(&Message::Drive(drive), key);
}

/// Angle that the robot has actually turned since the last call, degrees.
fn turned_deg(bench: &mut Bench) -> f64 {
    (bench.left.take_way() - bench.right.take_way()) / 1004.0 * 360.0
}

#[test]
fn robot_with_every_sensor_starts_without_photo_and_motion() {
    let (mut bench, key) = fitted();
    let quiet = LayerMask::ALL.without(Layer::Photo).without(Layer::Motion);
    assert_eq!(
        (bench.latest_status().fitted, bench.latest_status().allowed),
        (LayerMask::ALL, quiet)
    );
    assert_eq!(bench.latest_state().arm, Arm::Stowed);
    bench.order(key, only(LayerMask::ALL));
    bench.run_ms(2000);
    assert_eq!(bench.latest_status().allowed, LayerMask::ALL);
}

#[test]
fn scan_is_a_full_turn_and_reports_its_findings() {
    let (mut bench, key) = fitted();
    bench.run_ms(2000);
    turned_deg(&mut bench);
    bench.order(key, Order::Scan);
    assert_eq!(bench.robot.ack().outcome, Outcome::Done);
    bench.run_ms(2000);
    assert_eq!(bench.robot.holder(), Some(Holder::Layer(Layer::Rotation)));
    assert_eq!(
        bench.latest_state().layers.get(Layer::Rotation),
        LayerState::Holds
    );
    bench.run_ms(12_000);
    let turned = turned_deg(&mut bench);
    assert!((turned - 360.0).abs() <= 5.0, "{turned}");
    assert_eq!(bench.robot.holder(), Some(Holder::Prowl));
    let said = texts(&bench);
    assert_eq!(
        said,
        ["scan: longest view ---, brightest light ---, clearest --- deg"]
    );
}

#[test]
fn bump_ends_a_scan_within_the_tick() {
    let (mut bench, key) = fitted();
    bench.order(key, Order::Scan);
    bench.run_ms(2500);
    bench.inputs.bumper = BUMPED;
    bench.run_ticks(1);
    assert_eq!(bench.robot.holder(), Some(Holder::Layer(Layer::Bumpers)));
    assert!(bench.robot.motion().velocity_cps < 0);
    bench.inputs.bumper = Switches::default();
    for _ in 0..200 {
        bench.run_ticks(1);
        assert_ne!(bench.robot.holder(), Some(Holder::Layer(Layer::Rotation)));
    }
    assert_eq!(texts(&bench), ["scan: broken off"]);
}

#[test]
fn manual_driving_ends_a_scan() {
    let (mut bench, key) = fitted();
    bench.order(key, Order::Scan);
    bench.run_ms(1000);
    drive(&mut bench, key, 4);
    bench.run_ticks(1);
    assert_eq!(bench.robot.holder(), Some(Holder::Layer(Layer::User)));
    bench.run_ms(3000);
    assert_eq!(bench.robot.holder(), Some(Holder::Prowl));
}

#[test]
fn scan_is_refused_in_stop_in_user_and_without_its_layer() {
    let (mut bench, key) = fitted();
    for mode in [Mode::Stop, Mode::User] {
        bench.order(key, Order::Mode(mode));
        bench.order(key, Order::Scan);
        assert_eq!(bench.robot.ack().outcome, Outcome::NotNow, "{mode:?}");
    }
    bench.order(key, Order::Mode(Mode::Prowl));
    bench.order(key, only(LayerMask::ALL.without(Layer::Rotation)));
    bench.order(key, Order::Scan);
    assert_eq!(bench.robot.ack().outcome, Outcome::NotNow);
}

#[test]
fn photo_runs_only_with_the_bumpers() {
    let (mut bench, key) = fitted();
    bench.inputs.photo_right = Some(60);
    bench.order(key, only(LayerMask::ALL));
    bench.run_ticks(1);
    assert_eq!(bench.robot.holder(), Some(Holder::Layer(Layer::Photo)));
    assert!(bench.robot.motion().rotation_cps > 0);
    bench.order(key, only(LayerMask::ALL.without(Layer::Bumpers)));
    bench.run_ticks(1);
    assert_eq!(bench.robot.holder(), Some(Holder::Prowl));
    bench.run_ms(2000);
    assert_eq!(
        bench.latest_state().layers.get(Layer::Photo),
        LayerState::Off
    );
}

/// A robot in mode Passive with its detectors armed.
fn armed() -> (Bench, Key) {
    let (mut bench, key) = fitted();
    bench.order(key, Order::Mode(Mode::Passive));
    bench.run_ms(40_000);
    assert_eq!(bench.latest_state().arm, Arm::Armed);
    assert!(bench.outputs.arm_up);
    bench.lines.clear();
    (bench, key)
}

#[test]
fn passive_mode_scans_faces_sings_waits_charges_and_ends() {
    let (mut bench, key) = fitted();
    bench.order(key, Order::Mode(Mode::Passive));
    assert_eq!(bench.robot.mode(), Mode::Passive);
    assert!(bench.robot.allowed().contains(Layer::Motion));
    let mut sang = 0;
    for _ in 0..400 {
        bench.run_ticks(1);
        sang += u32::from(bench.outputs.note_hz > 0);
    }
    assert!(sang > 80, "{sang}");
    assert_eq!(texts(&bench).len(), 1);
    bench.run_ms(20_000);
    assert_eq!(bench.latest_state().arm, Arm::Armed);
    bench.lines.clear();
    bench.inputs.motion = LEFT_MOVES;
    bench.run_ticks(3);
    assert!(!bench.outputs.arm_up);
    bench.inputs.motion = NOTHING_MOVES;
    turned_deg(&mut bench);
    let mut fastest = 0.0_f64;
    while bench.robot.mode() == Mode::Passive {
        bench.run_ticks(1);
        fastest = fastest.max(bench.right.speed_cps);
        assert!(bench.now_ms < 100_000, "mode Passive does not end");
    }
    assert!(fastest > 12.0 * 16.0 * 0.9, "full speed: {fastest}");
    assert!(turned_deg(&mut bench) < -30.0, "the robot turns left");
    assert_eq!(bench.robot.mode(), Mode::Prowl);
    bench.run_ms(1000);
    let arms: Vec<Arm> = bench.states().map(|state| state.arm).collect();
    assert_eq!(
        arms.iter().filter(|&&arm| arm == Arm::MotionLeft).count(),
        1,
        "{arms:?}"
    );
    assert_eq!(arms.last(), Some(&Arm::Stowed));
}

#[test]
fn drive_frame_and_bump_stow_the_arm_before_moving() {
    for by_hand in [true, false] {
        let (mut bench, _) = armed();
        bench.run_ms(1000);
        if by_hand {
            // Drive frames are accepted for a while after a session was opened.
            let key = bench.open(6);
            drive(&mut bench, key, 6);
        } else {
            bench.inputs.bumper = BUMPED;
        }
        let mut held = 0;
        loop {
            bench.run_ticks(1);
            bench.inputs.bumper = Switches::default();
            assert!(!bench.outputs.arm_up, "by hand: {by_hand}");
            if bench.outputs.pwm_left != 0 {
                break;
            }
            held += 1;
            assert!(held < 20, "by hand: {by_hand}");
        }
        assert_eq!(held, u32::from(SWING_TICKS), "by hand: {by_hand}");
    }
}

#[test]
fn top_switch_is_reported_and_stows_the_arm() {
    let (mut bench, _) = armed();
    bench.inputs.top_hat = true;
    bench.run_ticks(1);
    bench.inputs.top_hat = false;
    assert!(!bench.outputs.arm_up);
    bench.run_ms(2000);
    let arms: Vec<Arm> = bench.states().map(|state| state.arm).collect();
    assert!(
        arms.contains(&Arm::TopHat) && arms.last() == Some(&Arm::Stowed),
        "{arms:?}"
    );
}

#[test]
fn bumps_start_hiding_only_while_prowling_with_its_layers() {
    // Random contacts until one completes the sequence.
    let hides = |set_up: &dyn Fn(&mut Bench, Key)| {
        let (mut bench, key) = fitted();
        bench.order(key, only(LayerMask::ALL));
        set_up(&mut bench, key);
        for contact in 0..200_u32 {
            let side = contact.wrapping_mul(2_654_435_761) >> 16;
            bench.inputs.bumper = Switches {
                left: side % 3 == 0,
                center: side % 3 == 1,
                right: side % 3 == 2,
            };
            bench.run_ticks(2);
            bench.inputs.bumper = Switches::default();
            bench.run_ticks(100);
            if bench.robot.mode() == Mode::Passive {
                return true;
            }
        }
        false
    };
    assert!(hides(&|_, _| {}));
    assert!(!hides(&|bench, key| {
        bench.order(key, Order::Mode(Mode::Reactive));
    }));
    assert!(!hides(&|bench, key| {
        bench.order(key, only(LayerMask::ALL.without(Layer::Motion)));
    }));
}

/// An echo of the right sonar.
fn echo(range_in: Option<u16>) -> Echo {
    Echo {
        side: Side::Right,
        range_in,
    }
}

/// Makes the longer sonar range the one on the side of an infrared detection.
fn contradict(bench: &mut Bench) {
    bench.reflects = (true, false);
    bench.inputs.sonar = Some(echo(Some(35)));
}

#[test]
fn sonar_switched_off_by_the_robot_is_off_but_allowed() {
    let (mut bench, _) = fitted();
    contradict(&mut bench);
    bench.run_ms(6000);
    assert_eq!(
        bench.latest_state().layers.get(Layer::Sonar),
        LayerState::Off
    );
    assert!(bench.robot.allowed().contains(Layer::Sonar));
    bench.inputs.sonar = Some(echo(Some(200)));
    bench.run_ms(8000);
    assert_eq!(
        bench.latest_state().layers.get(Layer::Sonar),
        LayerState::Quiet
    );
}

#[test]
fn behaviour_parameter_off_keeps_all_sensors_on() {
    let mut parameters = Parameters::default();
    parameters.set(Parameter::Behaviour, 0);
    let mut bench = Bench::new();
    bench.robot = robot(parameters);
    contradict(&mut bench);
    bench.run_ms(6000);
    assert_ne!(
        bench.latest_state().layers.get(Layer::Sonar),
        LayerState::Off
    );
}

/// Random events.
#[derive(Clone, Copy, Debug)]
enum Event {
    Bump(u8),
    Infrared(bool, bool),
    Motion(bool, bool),
    TopHat(bool),
    Light(u8, u8),
    Mode(Mode),
    Scan,
    Drive(i8),
    Rest(u8),
}

fn event() -> impl Strategy<Value = Event> {
    let modes = [
        Mode::Prowl,
        Mode::Reactive,
        Mode::Passive,
        Mode::Stop,
        Mode::User,
    ];
    prop_oneof![
        (0_u8..8).prop_map(Event::Bump),
        any::<(bool, bool)>().prop_map(|(left, right)| Event::Infrared(left, right)),
        any::<(bool, bool)>().prop_map(|(left, right)| Event::Motion(left, right)),
        any::<bool>().prop_map(Event::TopHat),
        (80_u8..160, 80_u8..160).prop_map(|(left, right)| Event::Light(left, right)),
        proptest::sample::select(modes.to_vec()).prop_map(Event::Mode),
        Just(Event::Scan),
        (-12_i8..12).prop_map(Event::Drive),
        (0_u8..30).prop_map(Event::Rest),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// The motors run only after the arm has had time to stow.
    #[test]
    fn motors_never_run_with_the_arm_raised(
        events in proptest::collection::vec((event(), 1_u32..80), 1..40)
    ) {
        let mut parameters = Parameters::default();
        parameters.set(Parameter::Settle, 1);
        let (mut bench, _) = fitted();
        let (mut since_up, mut ups) = (u32::MAX, 0);
        bench.robot = robot(parameters);
        bench.run_ms(1500);
        for (event, ticks) in std::iter::once((Event::Rest(3), 1)).chain(events) {
            let key = bench.open(5);
            bench.order(key, only(LayerMask::ALL));
            let mut ticks = ticks;
            match event {
                Event::Bump(switches) => bench.inputs.bumper = Switches {
                    left: switches & 1 != 0,
                    center: switches & 2 != 0,
                    right: switches & 4 != 0,
                },
                Event::Infrared(left, right) => bench.reflects = (left, right),
                Event::Motion(left, right) => bench.inputs.motion = Some(Sides { left, right }),
                Event::TopHat(closed) => bench.inputs.top_hat = closed,
                Event::Light(left, right) => {
                    bench.inputs.photo_left = Some(left);
                    bench.inputs.photo_right = Some(right);
                }
                Event::Mode(mode) => { bench.order(key, Order::Mode(mode)); }
                Event::Scan => { bench.order(key, Order::Scan); }
                Event::Drive(speed) => drive(&mut bench, key, speed),
                // No detections for a long time: the arm goes up.
                Event::Rest(s) => {
                    bench.inputs = Inputs {
                        battery_dv: 124,
                        photo_left: Some(120),
                        photo_right: Some(120),
                        motion: NOTHING_MOVES,
                        ..Inputs::default()
                    };
                    bench.reflects = (false, false);
                    bench.order(key, Order::Mode(Mode::Reactive));
                    ticks += u32::from(s) * 20;
                }
            }
            for _ in 0..ticks {
                bench.run_ticks(1);
                let outputs = bench.outputs;
                since_up = if outputs.arm_up { 0 } else { since_up.saturating_add(1) };
                ups += u32::from(outputs.arm_up);
                let is_driven = outputs.pwm_left != 0 || outputs.pwm_right != 0;
                prop_assert!(!is_driven || since_up > u32::from(SWING_TICKS), "{since_up} ticks after the arm was raised");
            }
        }
        prop_assert!(ups > 0, "the arm was never raised");
    }
}
