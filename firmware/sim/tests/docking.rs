//! To the dock, charged, and on.

mod common;

use common::{Rig, parameters};
use groundwave_protocol::command::Order;
use groundwave_protocol::letters::Mode;
use sr04_sim::{Conditions, World};

#[test]
fn prowling_it_gets_away_from_the_docks_edge_which_closes_no_switch() {
    // From the west along the wall, into the side of the dock.
    let wall = format!("{}\n", "#".repeat(30));
    let world = World::parse(
        "edge",
        &format!(
            "name = \"edge\"\ncell_in = 6\nplan = '''\n{wall}{}#..>.........................#\n#............................#\n\
             {wall}'''\n[dock]\nat = [63, 9]\nfacing_deg = 0\n",
            "#............................#\n".repeat(20)
        ),
    )
    .unwrap_or_else(|error| panic!("{error}"));
    for seed in 0..8 {
        let mut rig = Rig::new(&world, seed, parameters(&[]));
        let mut held_ticks = 0;
        for _ in 0..60 * 20 {
            rig.tick();
            held_ticks += u32::from(rig.robot.is_saturated());
        }
        assert!(held_ticks < 10 * 20, "seed {seed}: {held_ticks} ticks");
    }
}

#[test]
fn it_docks_by_the_beacon_charges_and_goes_on() {
    let world = World::built_in("flat").expect("it comes with the program");
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
