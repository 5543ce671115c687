//! Corrupts good lines in six ways, decodes them, and prints the wrong lines accepted beside the expected number.
//!
//! `cargo run --release -p groundwave-protocol --example corrupted_lines -- 1000000000 [SEED]`
//!
//! The same number of lines and the same seed give the same result on any number of cores.

#[path = "../../tests/damage/mod.rs"]
mod damage;

mod corruption;
mod pool;
mod tally;

use std::env;
use std::process::ExitCode;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;
use std::time::Instant;

use corruption::Kind;
use damage::Rng;
use groundwave_protocol::decoder::Decoder;
use pool::{Pool, Sent};
use tally::{Tally, Totals};

/// Number of lines decoded by one decoder, with a separate random generator.
const BLOCK_LINES: u64 = 250_000;

/// One in this number of lines gets a new checksum, to test the checks of its fields alone.
const SEALED_ONE_IN: u64 = 64;

fn main() -> ExitCode {
    let mut arguments = env::args().skip(1);
    let lines = arguments.next().map_or(Ok(10_000_000), |a| a.parse());
    let seed = arguments.next().map_or(Ok(damage::seed()), |a| a.parse());
    let (Ok(lines), Ok(seed), None) = (lines, seed, arguments.next()) else {
        eprintln!("usage: corrupted_lines [LINES [SEED]], both whole numbers");
        return ExitCode::from(2);
    };
    println!("{lines} corrupted lines, seed {seed}");
    let totals = run(lines, seed);
    print!("{totals}");
    if totals.guarantee_holds() {
        ExitCode::SUCCESS
    } else {
        eprintln!("a line with at most five wrong bits was accepted, which the checksum excludes");
        ExitCode::FAILURE
    }
}

fn run(lines: u64, seed: u64) -> Totals {
    let pool = Pool::new(&mut Rng(seed));
    let began = Instant::now();
    let blocks = lines.div_ceil(BLOCK_LINES);
    let (next, done) = (AtomicU64::new(0), AtomicU64::new(0));
    let totals = Mutex::new(Totals::default());
    thread::scope(|scope| {
        for _ in 0..thread::available_parallelism().map_or(1, Into::into) {
            scope.spawn(|| {
                loop {
                    let block = next.fetch_add(1, Ordering::Relaxed);
                    if block >= blocks {
                        return;
                    }
                    let count = BLOCK_LINES.min(lines - block * BLOCK_LINES);
                    let kind = Kind::of_block(block);
                    let tally = corrupt(&pool, kind, count, Rng(seed ^ block << 20));
                    if let Ok(mut totals) = totals.lock() {
                        totals.add(kind, &tally);
                    }
                    report_progress(done.fetch_add(1, Ordering::Relaxed) + 1, blocks, began);
                }
            });
        }
    });
    totals.into_inner().unwrap_or_default()
}

fn report_progress(done: u64, blocks: u64, began: Instant) {
    if done.is_multiple_of((blocks / 50).max(1)) {
        let seconds = began.elapsed().as_secs_f64();
        let rate = (done * BLOCK_LINES) as f64 / seconds / 1e6;
        let percent = done * 100 / blocks;
        eprintln!("{percent:>3} %, {seconds:.0} s, {rate:.2} million lines/s");
    }
}

/// Decodes one stream of corrupted lines.
fn corrupt(pool: &Pool, kind: Kind, count: u64, mut rng: Rng) -> Tally {
    let mut tally = Tally::default();
    let mut decoder = Decoder::default();
    for n in 0..count {
        let sent = pool.draw(&mut rng);
        let damaged = kind.damage(sent, pool, &mut rng);
        let flips = sent.flips_to(damaged.as_bytes());
        let guaranteed = flips.is_some_and(|flips| flips <= 5);
        tally.lines += 1;
        tally.guaranteed += u64::from(guaranteed);
        for line in decoder.lines(damaged.as_bytes()) {
            if sent.is(&line) {
                tally.intact += 1;
            } else if guaranteed {
                tally.accept_against_the_guarantee(&line);
            } else {
                tally.accept(&line);
            }
        }
        if !guaranteed && n.is_multiple_of(SEALED_ONE_IN) {
            tally.sealed += 1;
            tally.sealed_readable += u64::from(Sent::is_readable_when_sealed(damaged.as_bytes()));
        }
    }
    tally.take_counters(decoder.counters());
    tally
}
