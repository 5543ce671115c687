//! The holder of the motors, its share, and too many changes.

use super::*;
use groundwave_protocol::status_codes::Infrared;

#[test]
fn shares_come_from_the_robots_count_of_ticks_across_its_wrap() {
    let mut scene = scene();
    for _ in 0..10 {
        scene.hear();
    }
    assert_eq!(
        scene.model.facts.motors.share(Holder::Prowl),
        Some(1.0),
        "by the lines while there is no count"
    );
    scene.hear_ticks(10, [0, 4090, 0, 0, 0, 0, 0, 0, 100]);
    scene.hear_ticks(20, [0, 44, 0, 0, 0, 0, 0, 0, 250]);
    let share = |layer| scene.model.facts.motors.share(Holder::Layer(layer));
    assert_eq!(share(Layer::Bumpers), Some(0.25));
    assert_eq!(share(Layer::Sonar), Some(0.0));
    assert_eq!(scene.model.facts.motors.share(Holder::Prowl), Some(0.75));
    scene.hear_ticks(3, [0; 9]);
    assert_eq!(
        scene
            .model
            .facts
            .motors
            .share(Holder::Layer(Layer::Bumpers)),
        Some(0.0),
        "after a restart the lines speak again"
    );
}

#[test]
fn motors_that_change_hands_with_every_line_thrash() {
    let mut scene = scene();
    for n in 0..12 {
        let thrashes = scene.model.facts.motors.thrashes(scene.now);
        assert_eq!(thrashes, n > 6, "{n} holders");
        let (quiet, holds) = [
            (Layer::Infrared, Layer::Bumpers),
            (Layer::Bumpers, Layer::Infrared),
        ][n % 2];
        scene.layers(&[(quiet, LayerState::Quiet), (holds, LayerState::Holds)]);
        scene.hear();
    }
    for _ in 0..30 {
        scene.hear();
    }
    assert!(!scene.model.facts.motors.thrashes(scene.now));
}

#[test]
fn steering_is_not_thrashing() {
    for reckoning in [LayerState::Quiet, LayerState::Holds] {
        let mut scene = scene();
        for n in 0..40 {
            let sonar = [LayerState::Holds, LayerState::Quiet][n % 2];
            let below = if n % 2 == 0 {
                LayerState::Quiet
            } else {
                reckoning
            };
            scene.layers(&[(Layer::Sonar, sonar), (Layer::DeadReckoning, below)]);
            scene.hear();
            assert!(!scene.model.facts.motors.thrashes(scene.now));
        }
    }
}

#[test]
fn a_state_is_no_older_than_what_was_seen_of_it() {
    let mut scene = scene();
    scene.hear();
    let since = |scene: &Scene| {
        let motors = &scene.model.facts.motors;
        let holder = motors.holder().expect("a line A came");
        assert_eq!(motors.since(Layer::Sonar), Some(holder.at));
        holder.at
    };
    let begun = since(&scene);
    scene.now += Moment::from_secs(4);
    scene.hear();
    assert_eq!(since(&scene), begun, "few lost lines");
    scene.now += Moment::from_mins(1);
    scene.hear();
    let after_outage = since(&scene);
    assert!(after_outage > begun + Moment::from_mins(1), "an outage");
    scene.ack.boot += 1;
    scene.hear();
    assert!(since(&scene) > after_outage, "a restart");
}

#[test]
fn only_what_is_below_the_holder_is_suppressed() {
    let mut line = state();
    line.layers.set(Layer::Infrared, LayerState::Raised);
    let by_holder = |line: &_| suppressed(Holder::of(line), line);
    assert_eq!(by_holder(&line), [], "prowl suppresses no layer");
    line.layers.set(Layer::Sonar, LayerState::Holds);
    line.layers.set(Layer::DeadReckoning, LayerState::Raised);
    let below = [Holder::Layer(Layer::DeadReckoning), Holder::Prowl];
    assert_eq!(by_holder(&line), below);
}

#[test]
fn the_holder_follows_from_layers_and_mode() {
    let mut line = state();
    assert_eq!(Holder::of(&line), Holder::Prowl);
    line.mode = Mode::Reactive;
    assert_eq!(Holder::of(&line), Holder::NoLayer);
    line.mode = Mode::User;
    assert_eq!(Holder::of(&line), Holder::Layer(Layer::User));
    line.layers.set(Layer::Bumpers, LayerState::Holds);
    assert_eq!(Holder::of(&line), Holder::Layer(Layer::Bumpers));
}

#[test]
fn a_guard_that_took_the_motors_is_named_and_not_who_won_them() {
    let mut scene = scene();
    let sentence = |scene: &Scene| {
        let holder = scene
            .model
            .facts
            .motors
            .holder()
            .expect("a line A came")
            .value;
        crate::model::why::why(holder, &scene.state, &scene.model.facts.robot, scene.now)
    };
    scene.state.cliff = Cliff::Center;
    scene.layers(&[(Layer::Bumpers, LayerState::Raised)]);
    scene.hear();
    assert_eq!(Holder::of(&scene.state), Holder::CliffGuard);
    assert!(sentence(&scene).starts_with("no floor ahead; "));
    let both = [Holder::Layer(Layer::Bumpers), Holder::Prowl];
    assert_eq!(suppressed(Holder::CliffGuard, &scene.state), both);

    // With the guard off, prowl drove the robot there.
    scene.hear_parameter("cliff-guard", 0);
    scene.state.cliff = Cliff::Several;
    scene.hear();
    let holder = scene.model.facts.motors.holder().map(|held| held.value);
    assert_eq!(holder, Some(Holder::Prowl));
    assert_eq!(
        sentence(&scene),
        "no floor on several sides, and nothing guards"
    );
    scene.hear_parameter("cliff-guard", 1);
    scene.state.cliff = Cliff::None;
    scene.hear();
    assert_eq!(sentence(&scene), "nothing in the way");

    scene.state.arm = Arm::Up;
    scene.hear();
    assert_eq!(sentence(&scene), "stands until the arm is down");
    scene.layers(&[(Layer::Bumpers, LayerState::Holds)]);
    assert_eq!(Holder::of(&scene.state), Holder::Layer(Layer::Bumpers));
}

#[test]
fn nothing_in_the_way_needs_free_switches_turning_wheels_and_every_layer() {
    let mut scene = scene();
    scene.hear_status();
    scene.hear();
    let sentence = |scene: &Scene| {
        let facts = &scene.model.facts;
        crate::model::why::why(Holder::Prowl, &scene.state, &facts.robot, scene.now)
    };
    assert_eq!(sentence(&scene), "nothing in the way");
    for (infrared, expected) in [
        (Infrared::Left, "something near on the left"),
        (Infrared::Right, "something near on the right"),
        (Infrared::Both, "something near ahead"),
        (Infrared::Jammed, "drives without infrared"),
        (Infrared::NotFitted, "nothing in the way"),
        (Infrared::None, "nothing in the way"),
    ] {
        scene.state.infrared = infrared;
        scene.hear();
        assert_eq!(sentence(&scene), expected);
    }
    let off = [Layer::Bumpers, Layer::Infrared, Layer::Sonar];
    scene.status.allowed = off
        .into_iter()
        .fold(scene.status.allowed, LayerMask::without);
    scene.hear_status();
    let blind = "drives without bumpers, infrared, sonar";
    assert_eq!(sentence(&scene), blind, "by line B");
    scene.status.allowed = scene.status.fitted;
    scene.hear_status();
    scene.layers(&off.map(|layer| (layer, LayerState::Off)));
    assert_eq!(sentence(&scene), blind, "by line A");
    scene.state.velocity_in_s = 12;
    scene.state.drive = Drive::Saturated;
    (scene.state.wheel_left_in_s, scene.state.wheel_right_in_s) = (5, 5);
    let wheels = "wheels at 5 of 12, 5 of 12 in/s";
    assert_eq!(sentence(&scene), format!("held back; {wheels}"));
    scene.state.bump = Bump::Center;
    assert_eq!(sentence(&scene), format!("centre bumper pressed; {wheels}"));
    for _ in 0..18 {
        scene.hear();
    }
    let facts = &scene.model.facts;
    let calling = facts.alarms.calling(&scene.model.ui.attended);
    let calling: Vec<_> = calling.iter().map(|(rule, ..)| &*rule.name).collect();
    assert_eq!(calling, ["stalled", "bumper jammed"]);
}

#[test]
fn a_target_without_a_route_has_no_count_of_waypoints() {
    let mut scene = scene();
    let sentence = |scene: &mut Scene| {
        scene.hear_status();
        let layer = Holder::Layer(Layer::DeadReckoning);
        let robot = &scene.model.facts.robot;
        crate::model::why::why(layer, &scene.state, robot, scene.now)
    };
    scene.status.target_in = Some((0, 0));
    assert_eq!(sentence(&mut scene), "heads for (0, 0)");
    (scene.status.list.count, scene.status.list.driven) = (3, 1);
    assert_eq!(sentence(&mut scene), "heads for (0, 0), 1 of 3 reached");
}

#[test]
fn shares_expire_while_no_holder_drives() {
    let mut scene = scene();
    for _ in 0..30 {
        scene.hear();
    }
    assert_eq!(scene.model.facts.motors.share(Holder::Prowl), Some(1.0));
    scene.state.mode = Mode::Stop;
    for _ in 0..300 {
        scene.hear();
    }
    assert_eq!(scene.model.facts.motors.share(Holder::Prowl), None);
    scene.state.mode = Mode::User;
    scene.hear();
    assert_eq!(scene.model.facts.motors.since(Layer::User), Some(scene.now));
}
