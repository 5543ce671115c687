//! Steps that try more than the gate has time for, with seeds that change from day to day.

use std::process::Command;
use std::time::{SystemTime, UNIX_EPOCH};

/// Seeds that a day has to itself.
const SEEDS_A_DAY: u64 = 10_000;

/// How long each fuzz target looks for a failure, milliseconds.
const FUZZ_MS: u64 = 600_000;

/// Runs every test with the seeds of today, ten times as many.
pub(crate) fn seeds() -> Result<(), String> {
    let first = first_seed();
    println!("seeds from {first} on: GROUNDWAVE_SEEDS={first} PROPTEST_RNG_SEED={first}");
    super::run(
        Command::new(super::cargo_path())
            .arg("test")
            .args(super::EVERYTHING)
            .env("GROUNDWAVE_SEEDS", first.to_string())
            .env("PROPTEST_RNG_SEED", first.to_string()),
    )
}

/// Fuzzes each target for ten minutes.
pub(crate) fn fuzz() -> Result<(), String> {
    let first = first_seed();
    println!("BOLERO_RANDOM_SEED={first}");
    super::run(
        Command::new(super::cargo_path())
            .arg("test")
            .args(super::EVERYTHING)
            .arg("fuzz")
            .args(["--", "--nocapture", "--test-threads=1"])
            .env("BOLERO_RANDOM_SEED", first.to_string())
            .env("BOLERO_RANDOM_ITERATIONS", u32::MAX.to_string())
            .env("BOLERO_RANDOM_TEST_TIME_MS", FUZZ_MS.to_string()),
    )
}

/// Tries everything that is claimed of the robot, the short way.
pub(crate) fn trials() -> Result<(), String> {
    super::acceptance(&["--short".to_owned()])
}

/// The first seed of today, by the days since 1970.
fn first_seed() -> u64 {
    let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH);
    let days = since_1970.map_or(0, |time| time.as_secs() / 86_400);
    days * SEEDS_A_DAY
}
