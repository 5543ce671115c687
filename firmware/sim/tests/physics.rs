//! The simulated physics agrees with results computed by hand.

use sr04_sim::{Conditions, Plant, Simulation, SimulationConfig, World};

fn ideal() -> Conditions {
    Conditions {
        ideal_wheels: true,
        noise: false,
        ..Conditions::default()
    }
}

#[test]
fn odometry_without_noise_is_exact() {
    let world = World::built_in("open-room").expect("the world is built in");
    for seed in 1..=5 {
        let mut config = SimulationConfig::new(world.clone(), seed);
        config.conditions = ideal();
        let mut simulation = Simulation::new(&config);
        // Until the first contact, after which the wheels slip.
        while !simulation.truth().is_touching && simulation.now_ms() < 60_000 {
            simulation.run_for_ms(50);
            let truth = simulation.truth().pose;
            let believed = simulation.robot().pose();
            let (x_in, y_in) = (
                f64::from(believed.x_tenths_in()) / 10.0,
                f64::from(believed.y_tenths_in()) / 10.0,
            );
            let off_in = (truth.x_in - x_in).hypot(truth.y_in - y_in);
            assert!(
                off_in < 0.5,
                "seed {seed}: {off_in} inches off at {truth:?}"
            );
        }
        assert!(simulation.truth().path_in > 60.0, "seed {seed}");
    }
}

#[test]
fn inputs_without_noise_do_not_depend_on_the_seed() {
    let world = World::built_in("living-room").expect("the world is built in");
    let sense = |seed| {
        let mut plant = Plant::new(&world, &ideal(), seed);
        let mut seen = Vec::new();
        for _ in 0..40 {
            for _ in 0..50 {
                plant.step();
            }
            seen.push((plant.inputs(), plant.infrared(true)));
        }
        seen
    };
    assert_eq!(sense(1), sense(2));
}
