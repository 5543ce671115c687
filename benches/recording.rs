//! What recording, converting and recovering cost, on a day of the simulated robot.
//!
//! `cargo bench --bench recording` prints a line a figure; with `-- --month` it records thirty days too, in parts of a
//! day, and prints what that takes of memory. Linux only: it asks the kernel.

use std::error::Error;
use std::fs;
use std::io::BufWriter;
use std::path::Path;
use std::time::{Duration, Instant, UNIX_EPOCH};

use groundwave::capture::convert::convert_raw;
use groundwave::capture::recover::{Paths, recover};
use groundwave::capture::topics::Deriver;
use groundwave::capture::{Existing, Recorder, Session};
use sr04_sim::{Simulation, SimulationConfig, World};

const DAY_S: u64 = 86_400;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = tempfile::tempdir()?;
    let day = simulated_day()?;
    let lines = day.len() / 80;
    println!("a day: {} bytes, {lines} lines", day.len());

    let (messages, derived) = derive(&day);
    println!("derive every topic: {messages} messages in {derived:.2?}");

    let mcap = folder.path().join("day.mcap");
    let began = Instant::now();
    let output = BufWriter::with_capacity(1 << 20, fs::File::create(&mcap)?);
    convert_raw(&day[..], None, output)?;
    let took = began.elapsed();
    println!("convert: {took:.2?}, {} bytes", fs::metadata(&mcap)?.len());

    let before = cpu();
    record(&folder.path().join("live.mcap"), &day, 1, messages)?;
    let per_message = cpu().saturating_sub(before) / u32::try_from(messages)?;
    println!("record: {per_message:.2?} of CPU a message, all threads, reading back included");

    let paths = Paths::of(&folder.path().join("killed.mcap"));
    interrupted(&paths, &day)?;
    let began = Instant::now();
    let recovery = recover(&paths.target)?;
    println!(
        "recover from the journal: {:.2?}: {}",
        began.elapsed(),
        recovery.headline()
    );
    println!("memory: {} kB at most", memory_kb("VmHWM"));

    if std::env::args().any(|argument| argument == "--month") {
        record(&folder.path().join("month.mcap"), &day, 30, messages)?;
    }
    Ok(())
}

fn simulated_day() -> Result<Vec<u8>, Box<dyn Error>> {
    let mut simulation = Simulation::new(&SimulationConfig::new(World::open("house")?, 1));
    let mut day = Vec::new();
    for _ in 0..DAY_S {
        simulation.run_for_ms(1000);
        day.extend(std::iter::from_fn(|| simulation.poll_downlink()));
    }
    Ok(day)
}

fn derive(day: &[u8]) -> (u64, Duration) {
    let began = Instant::now();
    let mut messages = 0;
    let mut deriver = Deriver::new();
    for (n, line) in (0..).zip(day.chunks(80)) {
        let counted = deriver.handle_rx(n * 333_333_333, line, |_| {
            messages += 1;
            Ok::<(), ()>(())
        });
        debug_assert!(counted.is_ok());
    }
    (messages, began.elapsed())
}

fn session() -> Session {
    Session {
        link: "bench".to_owned(),
        start: UNIX_EPOCH,
        notes: std::collections::BTreeMap::new(),
        configuration: String::new(),
    }
}

/// Reads of half a line, as a port delivers them at best, as fast as the disk takes them.
fn record(path: &Path, day: &[u8], days: u64, messages: u64) -> Result<(), Box<dyn Error>> {
    let mut recorder = Recorder::start(path, Existing::Refuse, &session())?;
    let began = Instant::now();
    for n in 0..days {
        feed(&mut recorder, day, n);
        if days > 1 {
            let (now, most) = (memory_kb("VmRSS"), memory_kb("VmHWM"));
            println!("day {}: {now} kB now, {most} kB at most", n + 1);
        }
    }
    recorder.finish()?;
    let rate = (messages * days) as f64 / began.elapsed().as_secs_f64();
    println!("recorded {days} days, {rate:.0} messages/s");
    Ok(())
}

fn feed(recorder: &mut Recorder, day: &[u8], days: u64) {
    for (n, read) in (0_u32..).zip(day.chunks(40)) {
        let now = Duration::from_secs(days * DAY_S) + Duration::from_secs(1) / 6 * n;
        recorder.handle_rx(now, UNIX_EPOCH + now, read);
        while recorder.backlog() > 500 {
            // Whoever waits takes no CPU that would be counted.
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}

/// A recording that is not finished when its files are copied.
fn interrupted(paths: &Paths, day: &[u8]) -> Result<(), Box<dyn Error>> {
    let live = paths.target.with_file_name("interrupted.mcap");
    let mut recorder = Recorder::start(&live, Existing::Refuse, &session())?;
    // A moment less than a day: the next part has not begun.
    feed(&mut recorder, &day[..day.len() - 800], 0);
    while recorder.backlog() > 0 {
        std::thread::yield_now();
    }
    let live = Paths::of(&live);
    fs::copy(&live.partial, &paths.partial)?;
    fs::copy(&live.journal, &paths.journal)?;
    recorder.discard();
    Ok(())
}

/// CPU time of this process, to a hundredth of a second.
fn cpu() -> Duration {
    let stat = fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let ticks: u64 = stat
        .rsplit(") ")
        .next()
        .into_iter()
        .flat_map(|rest| rest.split(' ').skip(11).take(2))
        .filter_map(|ticks| ticks.parse::<u64>().ok())
        .sum();
    Duration::from_millis(ticks * 10)
}

fn memory_kb(name: &str) -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find(|line| line.starts_with(name));
    line.and_then(|line| line.split_whitespace().nth(1)?.parse().ok())
        .unwrap_or(0)
}
