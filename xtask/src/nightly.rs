//! Longer steps than in CI, with seeds that change daily.

use std::process::Command;
use std::time::{SystemTime, UNIX_EPOCH};

/// Number of seeds per day.
const SEEDS_A_DAY: u64 = 10_000;

/// Duration of each fuzz target, milliseconds.
const FUZZ_MS: u64 = 600_000;

/// Runs every test with today's seeds, 25 times as many as usual.
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

/// Fuzzes each target for ten minutes, with new inputs at each run.
pub(crate) fn fuzz() -> Result<(), String> {
    super::run(
        Command::new(super::cargo_path())
            .arg("test")
            .args(super::EVERYTHING)
            .arg("fuzz")
            .args(["--", "--nocapture", "--test-threads=1"])
            .env("BOLERO_RANDOM_ITERATIONS", u32::MAX.to_string())
            .env("BOLERO_RANDOM_TEST_TIME_MS", FUZZ_MS.to_string()),
    )
}

/// Runs a short version of all trials of the robot.
pub(crate) fn trials() -> Result<(), String> {
    super::acceptance(&["--short".to_owned()])
}

/// Today's first seed, from the days since 1970.
pub(crate) fn first_seed() -> u64 {
    let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH);
    let days = since_1970.map_or(0, |time| time.as_secs() / 86_400);
    days * SEEDS_A_DAY
}
