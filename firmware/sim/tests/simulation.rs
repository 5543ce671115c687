//! The robot's real program between world and radio.

use sr04_sim::{ChannelSpec, Simulation, SimulationConfig, World};

fn simulation(world: &str, seed: u64, channel: &str) -> Simulation {
    let world = World::built_in(world).expect("the world is built in");
    let mut config = SimulationConfig::new(world, seed);
    config.channel = channel.parse().expect("the channel is valid");
    Simulation::new(&config)
}

/// Number of bytes that the ground station receives in `seconds`.
fn received(simulation: &mut Simulation, seconds: u64) -> usize {
    simulation.run_for_ms(seconds * 1000);
    std::iter::from_fn(|| simulation.poll_downlink()).count()
}

#[test]
fn downlink_never_exceeds_240_bytes_per_second() {
    let mut simulation = simulation("house", 1, "");
    for second in 0..60 {
        let count = received(&mut simulation, 1);
        assert!(
            (100..=240).contains(&count),
            "second {second}: {count} bytes"
        );
    }
}

#[test]
fn uplink_drains_at_240_bytes_per_second() {
    let mut simulation = simulation("house", 1, "");
    simulation.handle_uplink(&[b'\n'; 480]);
    simulation.run_for_ms(1000);
    assert_eq!(simulation.uplink_pending(), 240);
    simulation.run_for_ms(995);
    assert!(simulation.uplink_pending() > 0);
    simulation.run_for_ms(5);
    assert_eq!(simulation.uplink_pending(), 0);
}

#[test]
fn outage_is_silence() {
    let mut simulation = simulation("house", 1, "out=2s..4s");
    assert!(received(&mut simulation, 2) > 300);
    assert!(received(&mut simulation, 2) <= 1);
    assert!(received(&mut simulation, 2) > 300);
}

#[test]
fn half_duplex_ground_station_receives_nothing_while_sending() {
    let mut simulation = simulation("house", 1, "half-duplex");
    let quiet = received(&mut simulation, 2);
    simulation.handle_uplink(&[b'\n'; 480]);
    let busy = received(&mut simulation, 2);
    assert!(quiet > 300 && busy == 0, "{quiet} {busy}");
}

#[test]
fn channel_can_be_replaced_in_flight() {
    let mut simulation = simulation("house", 1, "");
    received(&mut simulation, 2);
    simulation.set_channel(&"drop=1".parse().expect("the channel is valid"));
    assert_eq!(received(&mut simulation, 2), 0);
    simulation.set_channel(&ChannelSpec::default());
    assert!(received(&mut simulation, 2) > 300);
}

#[test]
fn reboot_resets_the_robot_and_keeps_the_world() {
    let mut simulation = simulation("house", 1, "");
    simulation.run_for_ms(20_000);
    let before = simulation.truth();
    assert!(before.path_in > 12.0, "the robot drives");
    simulation.reboot();
    assert_eq!(simulation.boots(), 2);
    assert_eq!(simulation.truth(), before);
    simulation.run_for_ms(10_000);
    assert!(
        simulation.truth().path_in > before.path_in,
        "the robot drives again"
    );
}

/// Stops from top speed at every phase of the robot's tick: within 150 ms the speed is the lowest that an encoder can
/// measure, within 300 ms the robot stands, and the brake does not drive it backward.
#[test]
fn stop_command_stops_the_robot_within_300_ms() {
    for phase_ms in 0..50 {
        let mut simulation = simulation("open-room", 1, "");
        simulation.run_for_ms(3000 + phase_ms);
        assert!(simulation.truth().speed_in_s > 11.0);
        simulation.handle_uplink(b"\nXH6MS\n");
        while simulation.uplink_pending() > 0 {
            simulation.step();
        }
        let heard_ms = simulation.now_ms();
        let mut least_in_s: f64 = 0.0;
        for (slower_than_in_s, within_ms) in [(1.25, 150), (0.05, 300)] {
            while simulation.truth().speed_in_s.abs() > slower_than_in_s {
                simulation.step();
                least_in_s = least_in_s.min(simulation.truth().speed_in_s);
                let passed_ms = simulation.now_ms() - heard_ms;
                assert!(
                    passed_ms <= within_ms,
                    "phase {phase_ms}: not slower than {slower_than_in_s} in/s"
                );
            }
        }
        simulation.run_for_ms(1000);
        assert!(
            simulation.truth().speed_in_s.abs() < 0.05,
            "phase {phase_ms}"
        );
        assert!(least_in_s > -1.0, "phase {phase_ms}: {least_in_s} in/s");
    }
}
