//! The robot's program on emulated chips, compared with the host's byte for byte.
//!
//! Needs Debian's libsimavr-dev, libelf-dev, pkg-config and a C compiler for the `ATmega2560`, and qemu-system-arm and
//! binutils-arm-none-eabi for the micro:bit.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::{avr, capture, cargo, debian, nightly, root, run};

/// Number of seeds of each run in a night.
const NIGHT_SEEDS: &str = "20";

/// Repeats recorded runs on an `ATmega2560`.
pub(crate) fn emulator() -> Result<(), String> {
    mega(&[])
}

/// Repeats recorded runs on a micro:bit.
pub(crate) fn microbit() -> Result<(), String> {
    micro(&[])
}

/// Repeats runs with the seeds of today on both chips.
pub(crate) fn night() -> Result<(), String> {
    let first = nightly::first_seed().to_string();
    let options = ["--seed", &first, "--seeds", NIGHT_SEEDS];
    mega(&options)?;
    micro(&options)
}

fn mega(options: &[&str]) -> Result<(), String> {
    let board = root().join("firmware/boards/replay");
    debian::build(&board)?;
    let program = board.join("target/avr-none/release/replay.elf");
    avr::check_program(&program)?;
    let emulator = compile("replay")?;
    run(bench()?
        .arg("mega")
        .arg("--emulator")
        .arg(emulator)
        .args(options)
        .arg(program))
}

fn micro(options: &[&str]) -> Result<(), String> {
    let board = root().join("firmware/boards/microbit");
    debian::build(&board)?;
    let program = board.join("target/thumbv6m-none-eabi/release/microbit");
    print!(
        "{}",
        capture(Command::new("arm-none-eabi-size").arg(&program))?
    );
    run(bench()?.arg("microbit").args(options).arg(program))
}

/// Compiles a program of the emulator. Because of simavr's licence, it is a separate process.
fn compile(name: &str) -> Result<PathBuf, String> {
    let folder = root().join("target/emulator");
    fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let source: &Path = &root().join(format!("firmware/boards/emulator/{name}.c"));
    let flags =
        capture(Command::new("pkg-config").args(["--cflags", "--libs", "simavr", "libelf"]))?;
    let program = folder.join(name);
    run(Command::new("cc")
        .args(["-O2", "-Wall", "-Wextra", "-Werror", "-o"])
        .arg(&program)
        .arg(source)
        .args(flags.split_whitespace()))?;
    Ok(program)
}

/// The program that compares a chip with the host.
fn bench() -> Result<Command, String> {
    cargo(&[&["build", "--bin", "sr04-bench"], &super::EVERYTHING[..]].concat())?;
    Ok(Command::new(root().join("target/debug/sr04-bench")))
}
