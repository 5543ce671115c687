//! The rotation, photo and motion layers and the modes that use them. Seeds from 10,000 belong to the trials.

use crate::common::{Rig, parameters};
use groundwave_protocol::command::Order;
use groundwave_protocol::status_codes::{Layer, LayerMask, Mode};
use sr04_firmware::arbiter::Holder;
use sr04_firmware::parameters::Parameter;
use sr04_sim::World;

/// A room of `width` by `depth` 6-inch cells; the robot starts in the middle of the south side and faces north.
fn room(width: usize, depth: usize, rest: &str) -> World {
    let wall = "#".repeat(width);
    let floor = format!("#{}#\n", ".".repeat(width - 2));
    let side = ".".repeat(width / 2 - 2);
    let start = format!("#{side}^{}#\n", ".".repeat(width - 3 - side.len()));
    let plan = [
        format!("{wall}\n"),
        floor.repeat(depth - 6),
        start,
        floor.repeat(3),
        wall,
    ]
    .concat();
    let text = format!(
        "name = \"room\"\ndaylight_lux = 3\ncell_in = 6\nplan = '''\n{plan}\n'''\n{rest}\n"
    );
    World::parse("room", &text).unwrap_or_else(|error| panic!("{error}"))
}

/// A dark room of 25 by 25 feet with a lamp in its middle, 10 feet ahead of the start.
fn lit_room(height_in: u32) -> World {
    room(
        50,
        50,
        &format!(
            "[[lamp]]\nname = \"lamp\"\nat = [150, 150]\ncandela = 100\nheight_in = {height_in}\n"
        ),
    )
}

#[test]
fn scan_is_a_full_turn_of_the_true_pose() {
    let world = World::built_in("open-room").expect("the world is built in");
    for seed in 0..20 {
        let mut rig = Rig::new(&world, seed, parameters(&[]));
        rig.run_s(3);
        rig.order(Order::Scan);
        let mut turned_deg = 0.0;
        let mut before_deg = rig.plant.truth().pose.theta_deg;
        let mut ticks = 0;
        loop {
            rig.tick();
            let theta_deg = rig.plant.truth().pose.theta_deg;
            turned_deg += (theta_deg - before_deg + 540.0).rem_euclid(360.0) - 180.0;
            before_deg = theta_deg;
            ticks += 1;
            if rig.robot.holder() != Some(Holder::Layer(Layer::Rotation)) {
                break;
            }
        }
        assert!(
            (turned_deg - 360.0).abs() <= 5.0,
            "seed {seed}: {turned_deg}"
        );
        assert!((170..210).contains(&ticks), "seed {seed}: {ticks} ticks");
    }
}

/// Layers allowed for following light: motion and sonar would override the photo layer everywhere.
const LIGHT_LAYERS: LayerMask = LayerMask::ALL.without(Layer::Motion).without(Layer::Sonar);

fn allow(rig: &mut Rig, allowed: LayerMask) {
    rig.order(Order::Layers {
        which: LayerMask::ALL,
        allowed,
    });
}

/// Turns around a point within `seconds`, and the mean distance from it in the second half of the time.
fn circles(rig: &mut Rig, x_in: f64, y_in: f64, seconds: u32) -> (f64, f64) {
    let bearing = |rig: &Rig| {
        let pose = rig.plant.truth().pose;
        (pose.x_in - x_in).atan2(pose.y_in - y_in).to_degrees()
    };
    let (mut before_deg, mut turned_deg, mut far_in) = (bearing(rig), 0.0, 0.0);
    for tick in 0..seconds * 20 {
        rig.tick();
        let now_deg = bearing(rig);
        turned_deg += (now_deg - before_deg + 540.0).rem_euclid(360.0) - 180.0;
        before_deg = now_deg;
        if tick >= seconds * 10 {
            far_in += rig.distance_in(x_in, y_in) / f64::from(seconds * 10);
        }
    }
    (turned_deg / 360.0, far_in)
}

#[test]
fn robot_finds_a_lamp_and_circles_it() {
    let world = lit_room(30);
    let mut circling = 0;
    for seed in 0..20 {
        let mut rig = Rig::new(&world, seed, parameters(&[]));
        rig.tick();
        allow(&mut rig, LIGHT_LAYERS);
        let (turns, far_in) = circles(&mut rig, 3.0, 123.0, 120);
        circling += u32::from(turns.abs() >= 2.0 && far_in < 72.0);
    }
    assert!(circling >= 18, "{circling} of 20");
}

#[test]
fn light_avoidance_keeps_the_robot_in_the_dark() {
    // 50 by 12 feet: the lamp is in the west, the start in the middle.
    let world = room(
        100,
        25,
        "[[lamp]]\nname = \"lamp\"\nat = [40, 75]\ncandela = 150\nheight_in = 30\n",
    );
    // With this seed the robot drives straight at the lamp, both cells read the same, and it turns around only when the
    // light has become brighter.
    let head_on = 3;
    for seed in 0..20 {
        let share = |avoid| {
            let mut rig = Rig::new(&world, seed, parameters(&[(Parameter::PhotoAvoid, avoid)]));
            rig.tick();
            allow(&mut rig, LIGHT_LAYERS);
            rig.run_s(120);
            let mut dark = 0;
            for _ in 0..60 * 20 {
                rig.tick();
                dark += u32::from(rig.plant.truth().pose.x_in > 100.0);
            }
            f64::from(dark) / 1200.0
        };
        // Within the last third of the room.
        let (avoiding, attracted) = (share(1), share(0));
        let least = if seed == head_on { 0.4 } else { 0.75 };
        assert!(avoiding > least, "seed {seed}: {avoiding}");
        assert!(attracted < 0.2, "seed {seed}: {attracted}");
    }
}

/// A robot after `seconds` in reactive mode, and the number of ticks for which it has stood still.
fn reactive(world: &World, seed: u64, allowed: LayerMask, seconds: u32) -> (Rig, u32) {
    let mut rig = Rig::new(world, seed, parameters(&[]));
    rig.tick();
    allow(&mut rig, allowed);
    rig.run_s(20);
    rig.order(Order::Mode(Mode::Reactive));
    let mut still = 0;
    for _ in 0..seconds * 20 {
        rig.tick();
        let stands = rig.outputs.pwm_left == 0 && rig.outputs.pwm_right == 0;
        still = if stands { still + 1 } else { 0 };
    }
    (rig, still)
}

#[test]
fn reactive_robot_comes_to_rest_within_five_minutes() {
    for name in ["house", "living-room", "open-room", "corridor"] {
        let world = World::built_in(name).expect("the world is built in");
        let without_photo = LayerMask::ALL.without(Layer::Photo);
        for allowed in [LayerMask::ALL, without_photo] {
            let rests = |&seed: &u64| reactive(&world, seed, allowed, 300).1 >= 5 * 20;
            let resting = (0..6).filter(rests).count();
            assert!(resting >= 5, "{name}, {allowed:?}: {resting} of 6");
        }
    }
}

#[test]
fn new_lamp_moves_a_resting_robot_within_two_seconds() {
    let lamps = "[[lamp]]\nname = \"lamp\"\nat = [150, 150]\ncandela = 100\nheight_in = 30\n\
                 [[lamp]]\nname = \"new\"\nat = [80, 220]\ncandela = 300\nheight_in = 30\non = false\n";
    let world = room(50, 50, lamps);
    for seed in 0..20 {
        let (mut rig, still) = reactive(&world, seed, LayerMask::ALL, 200);
        assert!(still > 20, "seed {seed}: the robot does not rest");
        assert!(rig.outputs.arm_up, "seed {seed}");
        let before = rig.plant.truth().path_in;
        rig.plant.set_lamp("new", true);
        rig.run_s(2);
        let pose = rig.plant.truth();
        assert!(pose.path_in > before + 0.5, "seed {seed}: {pose:?}");
    }
}

#[test]
fn hiding_robot_leaps_out_at_a_passing_person() {
    // The path surrounds the robot, which may hide facing any direction.
    let world = room(
        40,
        40,
        "[[walker]]\nkind = \"person\"\npath = [[30, 60], [30, 180], [210, 180], [210, 60]]\n\
         speed_in_s = 30\npause_s = 8\n",
    );
    for seed in 0..10 {
        let mut rig = Rig::new(&world, seed, parameters(&[]));
        rig.run_s(2);
        rig.order(Order::Mode(Mode::Passive));
        let (mut sang, mut was_up) = (false, false);
        for _ in 0..120 * 20 {
            rig.tick();
            sang |= rig.outputs.note_hz > 0;
            was_up |= rig.outputs.arm_up;
            let driven = rig.outputs.pwm_left != 0 || rig.outputs.pwm_right != 0;
            let raised = rig.plant.truth().arm_raised;
            assert!(!driven || raised < 1e-9, "seed {seed}: {raised}");
            if rig.robot.mode() == Mode::Prowl {
                break;
            }
        }
        assert_eq!(
            rig.robot.mode(),
            Mode::Prowl,
            "seed {seed}: the person did not move the robot"
        );
        assert!(sang && was_up, "seed {seed}");
    }
}
