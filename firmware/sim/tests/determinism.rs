//! The same seed gives the same run on every platform.

use sr04_firmware::board::{Inputs, Outputs, Side};
use sr04_sim::{Conditions, Plant, SAMPLE_MS, Simulation, SimulationConfig, TICK_MS, World};

/// FNV-1a hash, 64 bits.
struct Hash(u64);

impl Hash {
    const fn new() -> Self {
        Self(0xCBF2_9CE4_8422_2325)
    }

    fn add(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01B3);
        }
    }

    fn add_inputs(&mut self, inputs: &Inputs) {
        self.add(format!("{inputs:?}").as_bytes());
    }
}

/// Motor commands that lead to walls, corners and open space.
fn script(tick: u64) -> Outputs {
    let leg = tick / 37;
    let turn = [0, 60, -40, 150, -180][(leg % 5) as usize];
    let ahead = if leg % 7 == 6 { -140 } else { 170 };
    Outputs {
        pwm_left: ahead + turn / 2,
        pwm_right: ahead - turn / 2,
        ping: match tick % 4 {
            0 => Some(Side::Left),
            2 => Some(Side::Right),
            _ => None,
        },
        note_hz: 0,
        ..Outputs::default()
    }
}

/// Hash of a scripted robot's inputs over ten minutes.
fn senses(world: &str, seed: u64) -> u64 {
    let world = World::built_in(world).expect("the world is built in");
    let mut plant = Plant::new(&world, &Conditions::default(), seed);
    let mut hash = Hash::new();
    let mut leds_on = false;
    for now_ms in 1..=600_000_u64 {
        plant.step();
        if now_ms % SAMPLE_MS == 0 {
            let (left, right) = plant.infrared(leds_on);
            hash.add(&[u8::from(left), u8::from(right)]);
            leds_on = !leds_on;
        }
        if now_ms % TICK_MS == 0 {
            hash.add_inputs(&plant.inputs());
            plant.apply(script(now_ms / TICK_MS));
        }
    }
    let pose = plant.truth().pose;
    hash.add(&pose.x_in.to_bits().to_le_bytes());
    hash.add(&pose.y_in.to_bits().to_le_bytes());
    hash.0
}

/// Hash of the robot's inputs and the downlink over a noisy radio.
fn run(seed: u64) -> u64 {
    let world = World::built_in("living-room").expect("the world is built in");
    let mut config = SimulationConfig::new(world, seed);
    config.channel = "ber=1e-3,burst=20,dup=0.01,drop=0.01"
        .parse()
        .expect("the channel is valid");
    let mut simulation = Simulation::new(&config);
    let mut hash = Hash::new();
    for second in 0..120 {
        simulation.handle_uplink(&[second; 30]);
        for _ in 0..1000 / TICK_MS {
            simulation.run_for_ms(TICK_MS);
            hash.add_inputs(simulation.inputs());
        }
        while let Some(byte) = simulation.poll_downlink() {
            hash.add(&[byte]);
        }
    }
    hash.0
}

#[test]
fn scripted_inputs_are_the_same_on_every_platform() {
    // A difference without a change to a world, the physics or a sensor means that this platform computes differently.
    // After such a change, put the new values here.
    let hashes = ["living-room", "corridor"].map(|world| senses(world, 1));
    assert_eq!(
        hashes.map(|hash| format!("{hash:016x}")),
        ["9457685c0a18f262", "8bcff7a3e7c81e14"]
    );
}

#[test]
fn runs_are_equal_only_for_the_same_seed() {
    assert_eq!(run(7), run(7));
    assert_ne!(run(7), run(8));
}

#[test]
fn noise_of_one_sensor_does_not_change_another() {
    // Infrared samples and photocells must be the same with and without pings.
    let observe = |pings: bool| {
        let world = World::built_in("house").expect("the world is built in");
        let mut plant = Plant::new(&world, &Conditions::default(), 3);
        let mut seen = Vec::new();
        for now_ms in 1..=60_000_u64 {
            plant.step();
            if now_ms % SAMPLE_MS == 0 {
                seen.push(plant.infrared(true));
            }
            if now_ms % TICK_MS == 0 {
                let inputs = plant.inputs();
                seen.push((inputs.photo_left == Some(0), inputs.photo_right == Some(0)));
                let mut outputs = script(now_ms / TICK_MS);
                outputs.ping = outputs.ping.filter(|_| pings);
                plant.apply(outputs);
            }
        }
        seen
    };
    assert_eq!(observe(true), observe(false));
}
