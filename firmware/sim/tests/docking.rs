//! Docking, charging and undocking.

use crate::common::{Rig, parameters};
use groundwave_protocol::command::Order;
use groundwave_protocol::status_codes::{Layer, LayerMask, Mode};
use sr04_sim::{Conditions, Pose, World};

#[test]
fn robot_held_by_the_docks_edge_gets_free() {
    let wall = "#".repeat(30);
    let floor = format!("#{}#\n", ".".repeat(28)).repeat(10);
    let start = format!("#..>{}#\n", ".".repeat(25));
    let text = format!(
        "name = \"edge\"\ncell_in = 6\nplan = '''\n{wall}\n{floor}{start}{floor}{wall}\n'''\n\
         [dock]\nat = [63, 9]\nfacing_deg = 0\n"
    );
    // At an angle to the wall with the dock, whose edge is 16 degrees off the nose.
    let world = World::parse("edge", &text)
        .unwrap_or_else(|error| panic!("{error}"))
        .started_at(Pose {
            x_in: 34.2,
            y_in: 17.8,
            theta_deg: 106.8,
        })
        .expect("the robot fits there");
    for seed in 0..8 {
        let mut rig = Rig::new(&world, seed, parameters(&[]));
        rig.order(Order::Layers {
            which: LayerMask::ALL,
            allowed: LayerMask::NONE.with(Layer::Bumpers),
        });
        let was_held = (0..5 * 20).any(|_| {
            rig.tick();
            rig.robot.is_saturated() && !rig.inputs.bumper.any()
        });
        assert!(was_held, "seed {seed}: the robot missed the edge");
        let goes = (0..20 * 20).any(|_| {
            rig.tick();
            rig.distance_in(0.0, 20.0) > 12.0
        });
        assert!(goes, "seed {seed}: {:?}", rig.plant.truth().pose);
    }
}

#[test]
fn robot_docks_by_the_beacon_charges_and_leaves() {
    let world = World::built_in("flat").expect("the world is built in");
    for seed in 1..=4 {
        let conditions = Conditions {
            charge: 0.9,
            ..Conditions::default()
        };
        let mut rig = Rig::with(&world, seed, parameters(&[]), &conditions);
        rig.run_s(15);
        rig.order(Order::Mode(Mode::Forage));
        let docks = (0..20 * 600).any(|_| {
            rig.tick();
            rig.inputs.is_docked
        });
        assert!(docks, "seed {seed}");
        assert!(rig.run_to(Mode::Prowl, 2 * 3600).is_some(), "seed {seed}");
        assert!(rig.plant.truth().charge > 0.93, "seed {seed}");
    }
}
