//! To the dock, charged, and on.

mod common;

use common::{Rig, parameters};
use groundwave_protocol::command::Order;
use groundwave_protocol::letters::Mode;
use sr04_sim::{Conditions, World};

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
