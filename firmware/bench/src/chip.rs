//! Emulated chips that repeat the calls of a recording.

use std::fs;
use std::io::{BufReader, BufWriter, Read, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::thread;

use sr04_replay::{DOWNLINK, TICK};

use crate::recorder::{Frames, Recording};

/// Cycle count that marks the end of the results.
const END: u32 = u32::MAX;

/// Number of cycles from one tick to the next at 16 MHz.
pub(crate) const TICK_CYCLES: u64 = 800_000;

/// Figures of a run whose results equal the host's.
#[derive(Clone, Debug, Default)]
pub(crate) struct Figures {
    pub(crate) calls: usize,
    /// The chip's bytes to the radio.
    pub(crate) downlink: Vec<u8>,
    /// Mean number of cycles of all calls between two ticks; zero if the emulator does not count.
    pub(crate) mean_tick_cycles: u64,
    pub(crate) worst_tick_cycles: u64,
    /// Number of ticks delayed by a longer tick before.
    pub(crate) late_ticks: usize,
    pub(crate) stack_bytes: usize,
    pub(crate) spare_bytes: usize,
}

/// Number of cycles of each tick, including the other calls until the next one.
#[derive(Default)]
struct Ticks {
    count: u64,
    all: u64,
    current: u64,
    worst: u64,
    late: usize,
}

impl Ticks {
    fn add(&mut self, call: &[u8], cycles: u32) {
        if call.first() == Some(&TICK) {
            self.end();
        }
        self.current += u64::from(cycles);
    }

    fn end(&mut self) {
        self.count += 1;
        self.all += self.current;
        self.worst = self.worst.max(self.current);
        self.late += usize::from(self.current > TICK_CYCLES);
        self.current = 0;
    }
}

/// Starts an emulator with a chip's program; the pipes lead to its standard input and output.
pub(crate) fn start(
    emulator: &Path,
    program: &Path,
) -> Result<(Child, ChildStdin, ChildStdout), String> {
    let mut process = Command::new(emulator)
        .arg(program)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .map_err(|error| format!("cannot start {}: {error}", emulator.display()))?;
    match (process.stdin.take(), process.stdout.take()) {
        (Some(to), Some(from)) => Ok((process, to, from)),
        _ => Err("the emulator has no pipes".to_owned()),
    }
}

/// Repeats a recording on an emulated `ATmega2560` and compares every result.
pub(crate) fn mega(
    emulator: &Path,
    program: &Path,
    recording: &Recording,
) -> Result<Figures, String> {
    let (mut process, calls, results) = start(emulator, program)?;
    let figures = thread::scope(|scope| {
        // A broken pipe appears as missing results.
        scope.spawn(|| write_calls(BufWriter::new(calls), &recording.calls));
        compare(BufReader::new(results), recording)
    });
    // Reading may have ended before the emulator does.
    let _ = process.kill();
    let _ = process.wait();
    figures
}

fn write_calls(mut out: impl Write, calls: &Frames) -> std::io::Result<()> {
    for call in calls.iter() {
        out.write_all(&[call.len() as u8])?;
        out.write_all(call)?;
    }
    out.flush()
}

fn compare(mut results: impl Read, recording: &Recording) -> Result<Figures, String> {
    let mut ticks = Ticks::default();
    let mut downlink = Vec::new();
    let calls = recording.calls.iter().zip(recording.results.iter());
    for (number, (call, expected)) in calls.enumerate() {
        let (cycles, result) = read_result(&mut results)
            .map_err(|error| format!("no result of call {number}: {error}"))?;
        if result != expected {
            return Err(difference(recording, number, &result));
        }
        ticks.add(call, cycles);
        if call == [DOWNLINK] {
            downlink.extend(result.get(1));
        }
    }
    ticks.end();
    match read_result(&mut results) {
        Ok((END, figures)) if figures.len() == 4 => {
            let word = |place: usize| {
                usize::from(u16::from_le_bytes([figures[place], figures[place + 1]]))
            };
            Ok(Figures {
                calls: recording.calls.len(),
                downlink,
                mean_tick_cycles: ticks.all / ticks.count,
                worst_tick_cycles: ticks.worst,
                late_ticks: ticks.late,
                stack_bytes: word(0),
                spare_bytes: word(2),
            })
        }
        Ok(_) => Err("the emulator gave one result too many".to_owned()),
        Err(error) => Err(format!("the emulator did not end: {error}")),
    }
}

fn read_result(results: &mut impl Read) -> std::io::Result<(u32, Vec<u8>)> {
    let (mut cycles, mut length) = ([0; 4], [0]);
    results.read_exact(&mut cycles)?;
    results.read_exact(&mut length)?;
    let mut bytes = vec![0; usize::from(length[0])];
    results.read_exact(&mut bytes)?;
    Ok((u32::from_le_bytes(cycles), bytes))
}

/// Describes the first result that differs.
fn difference(recording: &Recording, number: usize, result: &[u8]) -> String {
    let call = recording.calls.iter().nth(number).unwrap_or_default();
    let expected = recording.results.iter().nth(number).unwrap_or_default();
    format!("call {number} ({call:02x?}): the chip gives {result:02x?}, the host {expected:02x?}")
}

/// Repeats a recording on a micro:bit in QEMU and compares every result.
pub(crate) fn microbit(program: &Path, recording: &Recording) -> Result<Figures, String> {
    let folder = tempfile::tempdir().map_err(|error| format!("no temporary folder: {error}"))?;
    let (calls, results) = (folder.path().join("calls"), folder.path().join("results"));
    fs::write(&calls, recording.calls.bytes()).map_err(|error| error.to_string())?;
    let program = program
        .canonicalize()
        .map_err(|error| format!("{}: {error}", program.display()))?;
    let output = Command::new("qemu-system-arm")
        .args([
            "-M", "microbit", "-display", "none", "-serial", "null", "-monitor", "none",
        ])
        .args(["-semihosting-config", "enable=on,target=native", "-kernel"])
        .arg(&program)
        .current_dir(folder.path())
        .output()
        .map_err(|error| format!("cannot start qemu-system-arm: {error}"))?;
    let printed = String::from_utf8_lossy(&output.stderr).into_owned()
        + &String::from_utf8_lossy(&output.stdout);
    let results = fs::read(&results).map_err(|error| format!("no results: {error}: {printed}"))?;
    let expected = recording.results.bytes();
    if results != expected {
        let place = results
            .iter()
            .zip(expected)
            .take_while(|(result, expected)| result == expected)
            .count();
        let number = recording.results.containing(place);
        let call = recording.calls.iter().nth(number).unwrap_or_default();
        return Err(format!(
            "result byte {place} of {} (of {}), call {number} ({call:02x?}): the chip gives {:02x?}, the host {:02x?}; {printed}",
            expected.len(),
            results.len(),
            results.get(place),
            expected.get(place)
        ));
    }
    let mut words = printed
        .split_whitespace()
        .skip_while(|&word| word != "stack")
        .skip(1);
    let mut number = || words.next()?.parse().ok();
    let (Some(stack_bytes), Some(spare_bytes)) = (number(), number()) else {
        return Err(format!("the program did not end: {printed}"));
    };
    Ok(Figures {
        calls: recording.calls.len(),
        downlink: recording.downlink.clone(),
        stack_bytes,
        spare_bytes,
        ..Figures::default()
    })
}
