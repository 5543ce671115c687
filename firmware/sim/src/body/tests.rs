use super::floor::GRAVITY;
use super::*;
use crate::rng::Stream;
use crate::testing::{docking, landing, room};
use crate::world::World;

/// Inner face of the north wall of `room(100)`.
const NORTH_IN: f64 = 594.0;

fn ideal(supply_v: f64) -> Conditions {
    Conditions {
        supply_v: Some(supply_v),
        ideal_wheels: true,
        ..Conditions::default()
    }
}

fn body_at(x_in: f64, y_in: f64, theta_deg: f64, conditions: &Conditions) -> Body {
    let mut rng = Rng::new(1, Stream::Build);
    Body::new(
        Vec2::new(x_in, y_in),
        theta_deg.to_radians(),
        conditions,
        &mut rng,
    )
}

fn drive(body: &mut Body, scene: &Scene, pwm_left: i16, pwm_right: i16, time_ms: u32) {
    let outputs = Outputs {
        pwm_left,
        pwm_right,
        ..Outputs::default()
    };
    for _ in 0..time_ms {
        body.step(scene, outputs);
    }
}

#[test]
fn speed_settles_where_force_meets_friction() {
    let scene = room(100, &[]);
    for supply_v in [10.8, 12.0, 13.8] {
        for load_share in [0.05, 0.25] {
            for pwm in [120, 200, 255] {
                let conditions = Conditions {
                    load_share,
                    ..ideal(supply_v)
                };
                let mut body = body_at(300.0, 30.0, 0.0, &conditions);
                drive(&mut body, &scene, pwm, pwm, 3000);
                let expected = motor::steady_speed_in_s(
                    f64::from(pwm) / 255.0,
                    body.battery.terminal_v(),
                    motor::load_friction(load_share),
                );
                let speed = body.speed_in_s();
                assert!(
                    (speed / expected - 1.0).abs() < 0.003,
                    "{speed} for {expected}"
                );
            }
        }
    }
}

#[test]
fn top_speed_is_reached_on_a_low_battery_with_a_heavy_load() {
    let scene = room(100, &[]);
    let conditions = Conditions {
        load_share: 0.25,
        ..ideal(10.8)
    };
    let mut body = body_at(300.0, 30.0, 0.0, &conditions);
    drive(&mut body, &scene, 255, 255, 3000);
    assert!(body.speed_in_s() > 12.2, "{}", body.speed_in_s());
}

#[test]
fn small_pulse_width_does_not_overcome_friction() {
    let scene = room(100, &[]);
    let mut body = body_at(300.0, 300.0, 0.0, &ideal(12.0));
    drive(&mut body, &scene, 15, 15, 1000);
    assert!(body.path_in < 1e-9, "{}", body.path_in);
}

#[test]
fn encoders_count_sixteen_edges_per_inch_both_ways() {
    let scene = room(100, &[]);
    let mut body = body_at(300.0, 30.0, 0.0, &ideal(12.0));
    drive(&mut body, &scene, 200, 200, 4000);
    drive(&mut body, &scene, -200, -200, 2000);
    let (left, right) = body.take_edges();
    let expected = body.path_in * 251.0 / (5.0 * core::f64::consts::PI);
    assert!(
        (f64::from(left) - expected).abs() <= 3.0,
        "{left} {expected}"
    );
    assert_eq!(left, right);
}

#[test]
fn real_wheels_differ_slightly_from_nominal() {
    let scene = room(100, &[]);
    let conditions = Conditions {
        ideal_wheels: false,
        ..ideal(12.0)
    };
    let mut body = body_at(300.0, 30.0, 0.0, &conditions);
    drive(&mut body, &scene, 200, 200, 30_000);
    let (left, right) = body.take_edges();
    assert_ne!(left, right);
    let ratio = f64::from(left) / f64::from(right);
    assert!((ratio - 1.0).abs() < 0.01, "{ratio}");
}

#[test]
fn opposite_wheel_speeds_turn_on_the_spot() {
    let scene = room(100, &[]);
    let mut body = body_at(300.0, 300.0, 0.0, &ideal(12.0));
    drive(&mut body, &scene, 100, -100, 3000);
    assert!(body.center.distance(Vec2::new(300.0, 300.0)) < 0.01);
    let (left, _) = body.take_edges();
    let rolled_in = f64::from(left) * 5.0 * core::f64::consts::PI / 251.0;
    assert!(body.theta_rad > 0.0, "positive is clockwise");
    assert!(
        (body.theta_rad - rolled_in / 5.0).abs() < 0.03,
        "{} {rolled_in}",
        body.theta_rad
    );
}

#[test]
fn wall_presses_the_bumper_and_stops_the_body() {
    let scene = room(100, &[]);
    let mut body = body_at(300.0, NORTH_IN - 20.0, 0.0, &ideal(12.0));
    drive(&mut body, &scene, 120, 120, 4000);
    assert_eq!(
        body.switches(),
        Switches {
            left: false,
            center: true,
            right: false
        }
    );
    let gap = NORTH_IN - RADIUS_IN - body.center.y;
    assert!((-0.26..-0.1).contains(&gap), "{gap}");
    // Backing off by the bumper's travel opens the switch.
    drive(&mut body, &scene, -120, -120, 200);
    assert_eq!(body.switches(), Switches::default());
}

#[test]
fn wheels_at_a_wall_stall_at_low_and_slip_at_full_force() {
    let scene = room(100, &[]);
    let mut body = body_at(300.0, NORTH_IN - 6.0, 0.0, &ideal(12.0));
    drive(&mut body, &scene, 110, 110, 2000);
    body.take_edges();
    let before = body.center;
    drive(&mut body, &scene, 110, 110, 1000);
    assert_eq!(body.take_edges(), (0, 0));
    drive(&mut body, &scene, 255, 255, 1000);
    assert!(body.take_edges().0 > 20, "the wheels spin");
    assert!(body.center.distance(before) < 0.2);
}

#[test]
fn body_slides_along_a_wall_while_the_wheels_keep_pace() {
    let scene = room(100, &[]);
    let mut body = body_at(200.0, NORTH_IN - 8.0, 82.0, &ideal(12.0));
    let mut lead: i16 = 0;
    for _ in 0..160 {
        let correction = (10 * lead).clamp(-70, 70);
        drive(&mut body, &scene, 180 - correction, 180 + correction, 50);
        let (left, right) = body.take_edges();
        lead += left as i16 - right as i16;
    }
    assert!(body.center.x > 260.0, "{}", body.center);
    assert!(body.center.y < NORTH_IN - RADIUS_IN + 0.3);
}

#[test]
fn motor_commands_never_push_the_body_through_a_wall() {
    for name in World::built_in_names() {
        let world = World::built_in(name).unwrap();
        let scene = Scene::new(&world);
        for seed in 0..12 {
            let mut rng = Rng::new(seed, Stream::Robot);
            let start = Vec2::new(world.start.x_in, world.start.y_in);
            let mut body = Body::new(start, rng.spread(3.0), &Conditions::default(), &mut rng);
            for _ in 0..300 {
                let pwm = |rng: &mut Rng| (rng.spread(1.6).clamp(-1.0, 1.0) * 255.0) as i16;
                let (left, right) = (pwm(&mut rng), pwm(&mut rng));
                drive(
                    &mut body,
                    &scene,
                    left,
                    right,
                    1 + (rng.unit() * 400.0) as u32,
                );
                scene.near(body.center, RADIUS_IN, |near| {
                    let overlap = RADIUS_IN - near.distance_in;
                    assert!(
                        overlap < contact::BUMPER_TRAVEL_IN + OVERLAP_MAX_IN + 0.01,
                        "{name}, seed {seed}: {overlap} inches inside an obstacle at {}",
                        body.center
                    );
                });
            }
        }
    }
}

#[test]
fn walkers_never_push() {
    let text = "name = \"crossing\"\ncell_in = 6\nplan = '''\n\
        ############\n#..........#\n#.P...^..Q.#\n#..........#\n#..........#\n############\n'''\n\
        [[walker]]\nkind = \"person\"\npath = [\"P\", \"Q\"]\n";
    let world = World::parse("crossing", text).unwrap();
    let mut scene = Scene::new(&world);
    let mut body = body_at(world.start.x_in, world.start.y_in, 0.0, &ideal(12.0));
    let before = body.center;
    for _ in 0..500 {
        for walker in &mut scene.walkers {
            walker.step(body.center, RADIUS_IN);
        }
        drive(&mut body, &scene, 0, 0, 20);
    }
    assert!(scene.walkers[0].center().x > 16.0, "the person set out");
    assert!(scene.walkers[0].center().x < before.x, "the person waits");
    assert_eq!(body.center, before);
}

#[test]
fn wheel_over_an_edge_ends_the_drive() {
    let scene = landing();
    // Forward, the wheels reach the edge first; backward, the caster.
    for (theta_deg, pwm, reaches_in) in [(0.0, 150, 120.0), (180.0, -150, 115.0)] {
        let mut body = body_at(60.0, 100.0, theta_deg, &ideal(12.0));
        drive(&mut body, &scene, pwm, pwm, 5000);
        assert!(body.has_fallen());
        assert!((body.center.y - reaches_in).abs() < 0.02, "{}", body.center);
        let before = body.center;
        drive(&mut body, &scene, -pwm, -pwm, 1000);
        assert_eq!(body.center, before, "a fallen robot stays in place");
        assert!(body.take_edges().0 > 10, "the wheels turn in the air");
    }
}

#[test]
fn outer_wheel_decides_a_fall_along_an_edge() {
    let scene = landing();
    for (y_in, falls) in [(114.9, false), (115.1, true)] {
        let mut body = body_at(30.0, y_in, 90.0, &ideal(12.0));
        drive(&mut body, &scene, 150, 150, 3000);
        assert_eq!(body.has_fallen(), falls);
    }
}

/// Drives straight at the dock from a foot away; returns whether it holds, and the switches.
fn dock_from(aside_in: f64, turned_deg: f64) -> (bool, Switches) {
    let scene = docking("");
    let dock = scene.dock.expect("there is a dock");
    let ahead = heading((180.0 + turned_deg).to_radians());
    let from = dock.front + Vec2::new(aside_in, 0.0) - ahead * 17.5;
    let mut body = body_at(from.x, from.y, 180.0 + turned_deg, &ideal(12.0));
    drive(&mut body, &scene, 80, 80, 6000);
    (dock.holds(body.center, body.theta_rad), body.switches())
}

#[test]
fn straight_approach_docks_without_a_bump() {
    for (aside_in, turned_deg) in [(0.0, 0.0), (1.5, 0.0), (-1.0, 10.0), (0.0, -15.0)] {
        let (is_held, switches) = dock_from(aside_in, turned_deg);
        assert!(
            is_held && !switches.any(),
            "{aside_in} {turned_deg} {switches:?}"
        );
    }
    assert!(!dock_from(4.0, 0.0).0, "beside the contacts");
    let (is_held, switches) = dock_from(0.0, 40.0);
    assert!(!is_held && switches.any(), "askew");
}

#[test]
fn hour_of_turning_drains_the_charge_of_the_motor_current() {
    let scene = room(100, &[]);
    let conditions = Conditions {
        ideal_wheels: true,
        ..Conditions::default()
    };
    let mut body = body_at(300.0, 300.0, 0.0, &conditions);
    drive(&mut body, &scene, 100, -100, 3_600_000);
    // At a steady speed the motor force equals the friction. The supply delivers the motor current only while the
    // bridge conducts.
    let motor_a = motor::current_for(motor::load_friction(conditions.load_share));
    let expected_ah = battery::ELECTRONICS_A + 2.0 * 100.0 / 255.0 * motor_a;
    let drained_ah = (1.0 - body.battery.charge()) * 2.2;
    assert!(
        (drained_ah / expected_ah - 1.0).abs() < 0.01,
        "{drained_ah} for {expected_ah}"
    );
}

/// A floor with this piece of ground around (120, 120).
fn on(ground: &str) -> Scene {
    docking(&format!("[[ground]]\nat = [120, 120]\n{ground}\n"))
}

/// Drives for `time_ms` and updates the floor's effect every 20 ms.
fn roll(body: &mut Body, scene: &Scene, pwm: i16, time_ms: u32) {
    for _ in 0..time_ms / 20 {
        body.update_floor(scene);
        drive(body, scene, pwm, pwm, 20);
    }
}

#[test]
fn sill_takes_more_force_than_the_floor() {
    let scene = on("kind = \"sill\"\nsize_in = [40, 3]");
    let reached = |pwm| {
        let mut body = body_at(120.0, 90.0, 0.0, &ideal(12.0));
        roll(&mut body, &scene, pwm, 12_000);
        body.center.y
    };
    assert!((118.0..120.0).contains(&reached(60)), "{}", reached(60));
    assert!(reached(100) > 130.0, "{}", reached(100));
}

#[test]
fn incline_costs_speed_by_the_weight_along_it() {
    let scene = on("kind = \"ramp\"\nsize_in = [100, 200]\ngrade_percent = 5");
    let speed = |theta_deg: f64| {
        let mut body = body_at(120.0, 120.0, theta_deg, &ideal(12.0));
        roll(&mut body, &scene, 150, 3000);
        (body.speed_in_s(), body.battery.terminal_v())
    };
    let weight = MASS_KG * GRAVITY * 0.05 / 2.0;
    for (theta_deg, force) in [(0.0, weight), (180.0, -weight)] {
        let (speed_in_s, supply_v) = speed(theta_deg);
        let friction = motor::load_friction(Conditions::default().load_share) + force;
        let expected = motor::steady_speed_in_s(150.0 / 255.0, supply_v, friction);
        assert!(
            (speed_in_s / expected - 1.0).abs() < 0.01,
            "{speed_in_s} for {expected}"
        );
    }
    let mut body = body_at(120.0, 120.0, 0.0, &ideal(12.0));
    roll(&mut body, &scene, 0, 2000);
    assert!(
        body.path_in < 0.04,
        "the gears nearly hold the robot: {}",
        body.path_in
    );
}

#[test]
fn wheels_lose_distance_on_a_carpet() {
    let scene = on("kind = \"carpet\"\nsize_in = [200, 200]");
    let mut body = body_at(120.0, 60.0, 0.0, &ideal(12.0));
    roll(&mut body, &scene, 150, 10_000);
    let rolled_in = f64::from(body.take_edges().0) * 5.0 * core::f64::consts::PI / 251.0;
    assert!(
        (body.path_in / rolled_in - 0.98).abs() < 0.002,
        "{} {rolled_in}",
        body.path_in
    );
}

#[test]
fn step_response_of_the_speed_is_exponential() {
    let scene = room(100, &[]);
    let conditions = Conditions {
        load_share: 0.0,
        ..ideal(12.0)
    };
    let mut body = body_at(300.0, 30.0, 0.0, &conditions);
    // Each motor drives its rotor and half of the robot against back EMF.
    let moved_kg = ROTOR_KG + MASS_KG / 2.0;
    let time_constant_s = moved_kg / motor::damping();
    for step in 1..=1500 {
        drive(&mut body, &scene, 128, 128, 1);
        let final_in_s = motor::steady_speed_in_s(128.0 / 255.0, body.battery.terminal_v(), 0.0);
        let expected = final_in_s * (1.0 - libm::exp(-f64::from(step) * STEP_S / time_constant_s));
        let speed = body.speed_in_s();
        assert!(
            (speed - expected).abs() < 0.12,
            "after {step} ms: {speed} for {expected}"
        );
    }
}
