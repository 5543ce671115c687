//! Cost of replay: opening a capture, seeking in it, reading it completely, and memory.
//!
//! `cargo bench --bench replay` simulates a day in the house, as raw text and as MCAP, in a temporary folder; `cargo
//! bench --bench replay -- 1 24 240` makes captures of 1, 24 and 240 hours. Peak memory is that of the whole process up to
//! that measurement.

use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use groundwave::capture::convert::convert_raw;
use groundwave::capture::index;
use groundwave::playback::Landmark;
use groundwave::playback::capture::timeline;
use groundwave::playback::{CaptureState, Finding, read_through};
use sr04_sim::{Simulation, SimulationConfig, World};

const SEEKS: u32 = 500;

/// Number of lines per second of the robot.
const LINES_PER_S: f64 = 3.0;

fn main() {
    let hours: Vec<u64> = std::env::args()
        .filter_map(|word| word.parse().ok())
        .collect();
    let hours = if hours.is_empty() { vec![24] } else { hours };
    let folder = tempfile::tempdir().expect("a temporary folder");
    println!(
        "{:>5} {:>5} {:>8} {:>8} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>8}",
        "hours",
        "form",
        "MB",
        "open ms",
        "first ms",
        "packet ms",
        "rare ms",
        "read s",
        "seek ms",
        "worst ms",
        "back ms",
        "jump ms",
        "peak MB"
    );
    for hours in hours {
        let raw = folder.path().join(format!("{hours}.txt"));
        let mcap = raw.with_extension("mcap");
        make(&raw, hours);
        let output = BufWriter::new(File::create(&mcap).expect("room for a capture"));
        let source = File::open(&raw).expect("it was just made");
        convert_raw(source, Some(1_742_000_000_000_000_000), output).expect("a day converts");
        for (form, path) in [("raw", &raw), ("mcap", &mcap)] {
            measure(hours, form, path);
        }
    }
}

/// Makes a capture of a repeated hour in the house, which costs a reader as much as different hours.
fn make(path: &Path, hours: u64) {
    let world = World::built_in("house").expect("it comes with the simulator");
    let mut simulation = Simulation::new(&SimulationConfig::new(world, 1));
    let mut hour = Vec::new();
    // The simulated radio keeps only a few minutes of unread bytes.
    for _ in 0..3600 {
        simulation.run_for_ms(1000);
        hour.extend(std::iter::from_fn(|| simulation.poll_downlink()));
    }
    let mut file = File::create(path).expect("room for a capture");
    for _ in 0..hours {
        file.write_all(&hour).expect("room for a capture");
    }
}

fn ms(time: Duration) -> f64 {
    time.as_secs_f64() * 1000.0
}

fn measure(hours: u64, form: &str, path: &Path) {
    let begun = Instant::now();
    let tape = index::open(path).expect("a capture");
    let opened = begun.elapsed();
    let length = tape.length();
    let first = CaptureState::new("bench", Arc::default(), &*tape);
    let mut again = tape.reopen();
    let mut timeline = timeline(tape, first.clone());
    let begun = Instant::now();
    timeline.seek(length.mul_f64(0.9));
    let unread = begun.elapsed();
    let begun = Instant::now();
    let nine_tenths = length.mul_f64(0.9 * LINES_PER_S).as_secs();
    timeline.seek_about_line(nine_tenths).expect("it is there");
    let packet = begun.elapsed();
    // There is none: the whole second half is searched, except for parts that the index rules out.
    let begun = Instant::now();
    timeline.find_next(Landmark::Command, length / 2, 1);
    while timeline.is_searching() {
        timeline.search(usize::MAX);
    }
    let rare = begun.elapsed();
    let begun = Instant::now();
    read_through(
        first,
        &mut again,
        || true,
        |finding| {
            if let Finding::State(scene) = finding {
                timeline.keep(*scene);
            }
            true
        },
    );
    timeline.complete();
    let read = begun.elapsed();
    let (mut all, mut worst, mut back) = (Duration::ZERO, Duration::ZERO, Duration::ZERO);
    let mut place = 0.5;
    for _ in 0..SEEKS {
        // Steps of the golden section spread evenly and never repeat.
        place = (place + 0.618_033_988_749_895_f64).fract();
        let begun = Instant::now();
        timeline.seek(length.mul_f64(place));
        let took = begun.elapsed();
        all += took;
        worst = worst.max(took);
        let begun = Instant::now();
        timeline.step_back();
        back = back.max(begun.elapsed());
    }
    let mut jump = Duration::ZERO;
    for n in 0..50 {
        let begun = Instant::now();
        timeline.find_next(
            Landmark::Bump,
            length.mul_f64(f64::from(n) / 50.0),
            usize::MAX,
        );
        jump = jump.max(begun.elapsed());
    }
    println!(
        "{hours:>5} {form:>5} {:>8.1} {:>8.2} {:>9.2} {:>9.2} {:>9.2} {:>9.2} {:>9.2} {:>9.2} {:>9.2} {:>9.2} {:>8.1}",
        fs::metadata(path).map_or(0.0, |about| about.len() as f64 / 1e6),
        ms(opened),
        ms(unread),
        ms(packet),
        ms(rare),
        read.as_secs_f64(),
        ms(all / SEEKS),
        ms(worst),
        ms(back),
        ms(jump),
        peak_mb()
    );
}

/// Peak memory of this process, MB; `None` if the system does not report it.
fn peak_mb() -> f64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kib = peak.and_then(|rest| rest.split_whitespace().next()?.parse::<f64>().ok());
    kib.map_or(f64::NAN, |kib| kib * 1024.0 / 1e6)
}
