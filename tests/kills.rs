//! The program is killed while it records: all bytes that it read are in the file and in the recovered recording.
//!
//! By default, the tests kill the program a few times at full speed; `GROUNDWAVE_KILLS=200 cargo test --test kills -- --nocapture` runs 200 kills
//! each at 3 and at 200 lines per second, in parallel, and prints the results.
#![cfg(unix)]

use crate::streams;
use std::fs;
use std::io::{PipeReader, Read, Write, pipe};
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use crate::programs::{GROUNDWAVE, Running, scratch};
use crate::streams::Rng;
use groundwave::capture::Capture;
use groundwave::capture::messages::RawBytes;
use groundwave::capture::recover::{Outcome, recover};
use prost::Message as _;

/// Maximum size of a read of the program, bytes.
const READ_BYTES: usize = 4096;

/// Result of one kill.
#[derive(Clone, Copy, Debug, Default)]
struct Kill {
    /// Number of bytes that the program had read.
    read: usize,
    /// Number of these bytes that are not in the file.
    lost: usize,
}

/// Records a stream at a number of lines per second, or at full speed, and kills the program after `lines`.
fn kill_after(folder: &Path, seed: u64, lines: usize, lines_per_s: Option<u32>) -> Kill {
    // A separate folder, because a new recording recovers interrupted ones in the same folder.
    let folder = folder.join(seed.to_string());
    fs::create_dir_all(&folder).unwrap();
    let path = folder.join("run.mcap");
    let (reader, mut writer) = pipe().unwrap();
    let mut left_over = reader.try_clone().unwrap();
    let child = Command::new(GROUNDWAVE)
        .args(["record", "-", "--quiet", "-o"])
        .arg(&path)
        .stdin(reader)
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut child = Running(child);
    let stream = streams::noisy(lines as u32 + 1, seed);
    let stream = &stream[..(lines * 80).min(stream.len())];
    // At full speed, the stream could end before the file exists.
    let deadline = Instant::now() + Duration::from_mins(1);
    while !path.exists() {
        assert!(Instant::now() < deadline, "it never began to record");
        thread::yield_now();
    }
    let mut radio = lines_per_s.map(Radio::new);
    for line in stream.chunks(80) {
        if let Some(radio) = &mut radio {
            radio.tick();
        }
        writer.write_all(line).unwrap();
    }
    if let Some(radio) = &radio {
        // At any moment between two lines; a program killed during a read has not received its bytes.
        radio.wait(Rng(seed ^ 1).below(1000));
    }
    child.0.kill().unwrap();
    child.0.wait().unwrap();
    drop(writer);
    let read = stream.len() - rest_of(&mut left_over);
    check(&path, &stream[..read])
}

/// A radio that sends lines at a fixed rate.
struct Radio {
    period: Duration,
    runtime: tokio::runtime::Runtime,
    interval: tokio::time::Interval,
}

impl Radio {
    fn new(lines_per_s: u32) -> Self {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_time()
            .build()
            .unwrap();
        let period = Duration::from_secs(1) / lines_per_s;
        let interval = runtime.block_on(async { tokio::time::interval(period) });
        Self {
            period,
            runtime,
            interval,
        }
    }

    /// Waits for `thousandths` of the time between two lines.
    fn wait(&self, thousandths: usize) {
        let time = self.period * thousandths as u32 / 1000;
        self.runtime
            .block_on(async { tokio::time::sleep(time).await });
    }

    fn tick(&mut self) {
        self.runtime.block_on(self.interval.tick());
    }
}

/// Number of unread bytes.
fn rest_of(pipe: &mut PipeReader) -> usize {
    let mut rest = Vec::new();
    pipe.read_to_end(&mut rest).unwrap();
    rest.len()
}

fn check(path: &Path, read: &[u8]) -> Kill {
    // The plain `mcap` reader finds as much as ours.
    let recorded = received(path);
    assert_eq!(recorded, received_by_others(path), "{}", path.display());
    assert!(read.starts_with(&recorded), "the file has something else");
    let lost = read.len() - recorded.len();
    // The kill may fall into a read, before its bytes are written.
    assert!(lost <= READ_BYTES, "{lost} bytes are not in the file");
    let is_begun = fs::read(path).unwrap().len() > mcap::MAGIC.len();
    assert!(is_begun || lost == read.len());
    if recorded.is_empty() {
        // Killed before the file's header was written.
        return Kill {
            read: read.len(),
            lost,
        };
    }
    let recovery = recover(path).unwrap();
    assert_eq!(recovery.outcome, Outcome::Recovered);
    assert_eq!(received(path), recorded, "recovery lost something");
    assert_eq!(recover(path).unwrap().outcome, Outcome::Whole);
    Kill {
        read: read.len(),
        lost,
    }
}

/// The received bytes, read by the `mcap` crate alone.
fn received_by_others(path: &Path) -> Vec<u8> {
    let bytes = fs::read(path).unwrap();
    let options = mcap::read::Options::IgnoreEndMagic;
    let Ok(messages) = mcap::MessageStream::new_with_options(&bytes, options.into()) else {
        return Vec::new();
    };
    messages
        .map_while(Result::ok)
        .filter(|message| message.channel.topic == "/raw/rx")
        .flat_map(|message| RawBytes::decode(&*message.data).unwrap().data)
        .collect()
}

/// All readable received bytes; an interrupted recording has no end.
fn received(path: &Path) -> Vec<u8> {
    let mut bytes = Vec::new();
    let Ok(mut capture) = Capture::open(path) else {
        return bytes;
    };
    while let Ok(Some(chunk)) = capture.next_chunk() {
        bytes.extend(chunk.bytes);
    }
    bytes
}

#[test]
fn a_kill_at_any_moment_costs_nothing_that_was_read() {
    let folder = scratch("kills");
    let Some(kills) = std::env::var("GROUNDWAVE_KILLS")
        .ok()
        .and_then(|kills| kills.parse::<u64>().ok())
    else {
        let mut rng = Rng(12);
        for seed in 0..12 {
            let kill = kill_after(&folder, seed, rng.below(400), None);
            println!("seed {seed}: {kill:?}");
        }
        return;
    };
    for lines_per_s in [3, 200] {
        let all = at_a_rate(&folder, kills, lines_per_s);
        let sum = |of: fn(&Kill) -> usize| all.iter().map(of).sum::<usize>();
        let with_loss = all.iter().filter(|kill| kill.lost > 0).count();
        println!(
            "{} kills at {lines_per_s} lines/s: {} bytes read, {} not in the file ({with_loss} kills)",
            all.len(),
            sum(|kill| kill.read),
            sum(|kill| kill.lost),
        );
    }
}

/// Runs forty kills in parallel, because each mostly waits for its radio.
fn at_a_rate(folder: &Path, kills: u64, lines_per_s: u32) -> Vec<Kill> {
    let folder = folder.join(lines_per_s.to_string());
    fs::create_dir_all(&folder).unwrap();
    let mut done = Vec::new();
    for first in (0..kills).step_by(40) {
        thread::scope(|scope| {
            let seeds = first..kills.min(first + 40);
            let running: Vec<_> = seeds
                .map(|seed| {
                    let folder = &folder;
                    let lines = 1 + Rng(seed).below(13 * lines_per_s as usize);
                    scope.spawn(move || kill_after(folder, seed, lines, Some(lines_per_s)))
                })
                .collect();
            for thread in running {
                done.push(thread.join().unwrap());
            }
        });
    }
    done
}
