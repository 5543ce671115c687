//! Cost of recording, converting and recovering a day of the simulated robot.
//!
//! `cargo bench --bench recording` prints one line per figure, the minimum of three runs. `-- --month` also records
//! thirty days in parts of a day and prints the memory used. `--day FILE` uses raw text instead of simulating
//! a day. Linux only, because the kernel reports the figures.

use std::cmp::Ordering;
use std::error::Error;
use std::fs;
use std::io::BufWriter;
use std::path::Path;
use std::time::{Duration, Instant, UNIX_EPOCH};

use groundwave::capture::convert::convert_raw;
use groundwave::capture::recover::recover;
use groundwave::capture::topics::Deriver;
use groundwave::capture::{Existing, Recorder, Session};
use sr04_sim::{Simulation, SimulationConfig, World};

const DAY_S: u64 = 86_400;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = tempfile::tempdir()?;
    let mut arguments = std::env::args();
    let day = match arguments.by_ref().skip_while(|it| it != "--day").nth(1) {
        Some(path) => fs::read(path)?,
        None => simulated_day()?,
    };
    let lines = day.len() / 80;
    println!("a day: {} bytes, {lines} lines", day.len());

    let (messages, _) = derive(&day);
    let derived = least(|| Ok(derive(&day).1))?;
    println!("derive every topic: {messages} messages in {derived:.2?}");

    let mcap = folder.path().join("day.mcap");
    let took = least(|| {
        let before = Cpu::so_far();
        let output = BufWriter::with_capacity(1 << 20, fs::File::create(&mcap)?);
        convert_raw(&day[..], None, output)?;
        Ok(before.since().all())
    })?;
    let bytes = fs::metadata(&mcap)?.len();
    println!("convert: {took:.2?} of CPU, {bytes} bytes");

    for (words, way) in [
        ("as it comes, flushed every 8 s and at bumps", Way::Live(40)),
        ("likewise, in clumps of 16 ms", Way::Live(4)),
        ("at one go, flushed at bumps", Way::AtOnce(40)),
    ] {
        let path = folder.path().join("live.mcap");
        let cpu = least(|| {
            let before = Cpu::so_far();
            record(&path, &day, 1, way)?;
            let cpu = before.since();
            fs::remove_file(&path)?;
            Ok(cpu)
        })?;
        let [all, user, system] =
            [cpu.all(), cpu.user, cpu.system].map(|cpu| cpu.as_secs_f64() * 1e6 / way.reads(&day));
        println!(
            "record {words}: {all:.2} us of CPU a read, {user:.2} of the program and {system:.2} of the system"
        );
    }

    let path = folder.path().join("killed.mcap");
    interrupted(&path, &day)?;
    let began = Instant::now();
    let recovery = recover(&path)?;
    println!("finish: {:.2?}: {}", began.elapsed(), recovery.headline());
    println!("memory: {} kB at most", memory_kb("VmHWM"));

    if std::env::args().any(|argument| argument == "--month") {
        record(&folder.path().join("month.mcap"), &day, 30, Way::Live(40))?;
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

/// Pace and size of reads, bytes: half a line, the smallest that a port delivers, or 16 ms of the wire, as an adapter
/// delivers.
#[derive(Clone, Copy)]
enum Way {
    /// Lines with the recorded times, as fast as the disk accepts them.
    Live(usize),
    /// All lines with the same time, so that no sync is due because of age.
    AtOnce(usize),
}

impl Way {
    /// Number of reads of a day; each is one message in the recording.
    fn reads(self, day: &[u8]) -> f64 {
        let (Self::Live(bytes) | Self::AtOnce(bytes)) = self;
        day.len() as f64 / bytes as f64
    }
}

/// Records days, including all threads, waiting for the disk and reading back.
fn record(path: &Path, day: &[u8], days: u64, way: Way) -> Result<(), Box<dyn Error>> {
    let mut recorder = Recorder::start(path, Existing::Refuse, &session())?;
    for n in 0..days {
        feed(&mut recorder, day, n, way);
        if days > 1 {
            let (now, most) = (memory_kb("VmRSS"), memory_kb("VmHWM"));
            println!("day {}: {now} kB now, {most} kB at most", n + 1);
        }
    }
    recorder.finish()?;
    Ok(())
}

fn feed(recorder: &mut Recorder, day: &[u8], days: u64, way: Way) {
    let (bytes, is_live) = match way {
        Way::Live(bytes) => (bytes, true),
        Way::AtOnce(bytes) => (bytes, false),
    };
    let period = Duration::from_secs(1) / 240 * bytes as u32;
    let pace = recorder.pace();
    for (n, read) in (0_u32..).zip(day.chunks(bytes)) {
        let wall = Duration::from_secs(days * DAY_S) + period * n;
        let now = if is_live { wall } else { Duration::ZERO };
        recorder.handle_rx(now, UNIX_EPOCH + wall, read);
        pace.wait();
    }
}

/// Makes an unfinished recording.
fn interrupted(path: &Path, day: &[u8]) -> Result<(), Box<dyn Error>> {
    let mut recorder = Recorder::start(path, Existing::Refuse, &session())?;
    // A moment less than a day, so that the next part does not begin.
    feed(&mut recorder, &day[..day.len() - 800], 0, Way::Live(40));
    recorder.abandon();
    Ok(())
}

/// The minimum of three runs.
fn least<T: Ord>(mut run: impl FnMut() -> Result<T, Box<dyn Error>>) -> Result<T, Box<dyn Error>> {
    let first = run()?;
    Ok(first.min(run()?).min(run()?))
}

/// CPU time of all threads of this process, to a hundredth of a second.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Cpu {
    user: Duration,
    system: Duration,
}

impl Cpu {
    fn so_far() -> Self {
        let stat = fs::read_to_string("/proc/self/stat").unwrap_or_default();
        let after_name = stat.rsplit(") ").next().unwrap_or_default();
        let mut ticks = after_name.split(' ').skip(11).map(str::parse);
        let mut next = || ticks.next().and_then(Result::ok).unwrap_or(0);
        let [user, system] = [next(), next()].map(|ticks: u64| Duration::from_millis(ticks * 10));
        Self { user, system }
    }

    fn since(self) -> Self {
        let now = Self::so_far();
        Self {
            user: now.user.saturating_sub(self.user),
            system: now.system.saturating_sub(self.system),
        }
    }

    fn all(self) -> Duration {
        self.user + self.system
    }
}

impl Ord for Cpu {
    fn cmp(&self, other: &Self) -> Ordering {
        self.all().cmp(&other.all())
    }
}

impl PartialOrd for Cpu {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

fn memory_kb(name: &str) -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find(|line| line.starts_with(name));
    line.and_then(|line| line.split_whitespace().nth(1)?.parse().ok())
        .unwrap_or(0)
}
