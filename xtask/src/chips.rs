//! The robot's program on emulated chips, compared with the host's byte for byte.
//!
//! Needs Debian's libsimavr-dev, libelf-dev, pkg-config and a C compiler for the `ATmega2560`, and qemu-system-arm and
//! binutils-arm-none-eabi for the micro:bit.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::{BENCH, avr, build, capture, debian, mega, nightly, root, run};

/// Number of seeds of each run in a night, and its duration.
const NIGHT_SEEDS: &str = "20";
const NIGHT_S: &str = "600";

/// Seeds of the board's checks in a night, and seconds of each drive in the house.
const BOARD_SEEDS: &str = "5";
const BOARD_S: &str = "3600";

/// Repeats recorded runs on an `ATmega2560`.
pub(crate) fn emulator() -> Result<(), String> {
    mega(&[])
}

/// Repeats recorded runs on a micro:bit.
pub(crate) fn microbit() -> Result<(), String> {
    micro(&[])
}

/// Repeats runs with the seeds of today on both chips, and drives the board for hours.
pub(crate) fn night() -> Result<(), String> {
    let first = nightly::first_seed().to_string();
    let options = [
        "--seed",
        &first,
        "--seeds",
        NIGHT_SEEDS,
        "--seconds",
        NIGHT_S,
    ];
    mega(&options)?;
    micro(&options)?;
    board_with(&[
        "--seed",
        &first,
        "--seeds",
        BOARD_SEEDS,
        "--seconds",
        BOARD_S,
    ])
}

/// Runs the Mega's whole board in a simulated house.
pub(crate) fn board() -> Result<(), String> {
    board_with(&[])
}

fn board_with(options: &[&str]) -> Result<(), String> {
    let full = mega::build("full", &[])?;
    let bare = mega::build("bare", &["--no-default-features"])?;
    let half = mega::build("half", &["--features", "lcd,half-duplex"])?;
    let emulator = compile("board")?;
    let groundwave = build("groundwave")?;
    run(bench()?
        .arg("board")
        .args(["--panic-at", &mega::panic_address(&full)?])
        .args([Path::new("--emulator"), &emulator])
        .args([Path::new("--bare"), &bare])
        .args([Path::new("--half"), &half])
        .args([Path::new("--groundwave"), &groundwave])
        .args(options)
        .arg(full))
}

fn mega(options: &[&str]) -> Result<(), String> {
    debian::build(&root().join("firmware/boards/replay"))?;
    let program = debian::boards().join("avr-none/release/replay.elf");
    avr::check_program(&program)?;
    let emulator = compile("replay")?;
    run(bench()?
        .arg("mega")
        .arg("--emulator")
        .arg(emulator)
        .args(options)
        .arg(program))
}

/// Builds the board of a Raspberry Pi Pico.
pub(crate) fn pico() -> Result<(), String> {
    debian::build(&root().join("firmware/boards/pico"))?;
    let program = debian::boards().join("thumbv6m-none-eabi/release/pico");
    print!(
        "{}",
        capture(Command::new("arm-none-eabi-size").arg(program))?
    );
    Ok(())
}

fn micro(options: &[&str]) -> Result<(), String> {
    debian::build(&root().join("firmware/boards/microbit"))?;
    let program = debian::boards().join("thumbv6m-none-eabi/release/microbit");
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
    build(BENCH).map(Command::new)
}
