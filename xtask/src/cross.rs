//! Builds and tests the ground station for other machines: static Linux on x86-64 and ARM, Windows under Wine; lints for macOS.
//!
//! Needs, in addition to Debian's compiler: `musl-tools`, `musl-dev:arm64`, `gcc-aarch64-linux-gnu`, `qemu-user-static`;
//! `gcc-mingw-w64-x86-64-win32`, `wine`; for macOS `rust-web-clippy`.

use std::fs;
use std::path::PathBuf;
use std::process::Command;

use crate::{debian, root, run};

pub(crate) const ARM: &str = "aarch64-unknown-linux-musl";
pub(crate) const X86: &str = "x86_64-unknown-linux-musl";
pub(crate) const WINDOWS: &str = "x86_64-pc-windows-gnu";
const MACOS: &str = "aarch64-apple-darwin";

/// The packages whose tests run on the other machine, with their integration tests.
const CRATES: [&str; 12] = [
    "-p",
    "groundwave-protocol",
    "-p",
    "groundwave-lines",
    "-p",
    "groundwave-captures",
    "-p",
    "groundwave-mapping",
    "-p",
    "sr04-firmware",
    "-p",
    "sr04-sim",
];

/// The station's own tests; tests of the whole system need ptys and a terminal of this machine.
const STATION: [&str; 3] = ["-p", "groundwave", "--lib"];

/// Builds static programs, runs the tests on an emulated ARM, and compares what both machines compute.
pub(crate) fn linux() -> Result<(), String> {
    for target in [X86, ARM] {
        run(cargo(target)?.args([
            "build",
            "--locked",
            "--bin",
            "groundwave",
            "--target",
            target,
        ]))?;
    }
    test(ARM)?;
    run(Command::new("python3")
        .arg("tests/systems/linux.py")
        .args([program(X86, ""), program(ARM, "")]))
}

/// Builds for Windows, runs the tests under Wine, compiles those of the whole system, and drives the program.
pub(crate) fn windows() -> Result<(), String> {
    test(WINDOWS)?;
    run(cargo(WINDOWS)?
        .args(["test", "--no-run", "--locked", "--workspace"])
        .args(["--exclude", "xtask", "--exclude", crate::BENCH])
        .args(["--target", WINDOWS]))?;
    run(cargo(WINDOWS)?.args([
        "build",
        "--locked",
        "--bin",
        "groundwave",
        "--target",
        WINDOWS,
    ]))?;
    super::cargo(&["build", "--locked", "--all-features", "--bin", "groundwave"])?;
    run(Command::new("python3")
        .arg("tests/systems/windows.py")
        .arg(program(WINDOWS, ".exe"))
        .arg(root().join("target/debug/groundwave")))
}

/// Lints every crate including tests for macOS. Nothing is linked, so no C compiler for macOS is needed.
pub(crate) fn macos() -> Result<(), String> {
    run(cargo(MACOS)?
        .args(["clippy", "--workspace", "--all-targets", "--locked"])
        .args(["--exclude", "xtask", "--target", MACOS])
        .args(["--", "-D", "warnings"])
        .env("CC_aarch64_apple_darwin", "true")
        .env("AR_aarch64_apple_darwin", "true"))
}

/// Tests of these packages that depend on no machine and would take longer than all others under emulation: the search of all states of the link, and
/// hours of simulated robots with a compass.
const SKIPPED: [&str; 3] = ["search::", "statement_holds", "unequal_wheels"];

/// Tests that are skipped on the emulated ARM: qemu 7.2 lacks calls for pseudo-terminals and serial devices.
const SKIPPED_ON_ARM: [&str; 2] = [
    "late_reader_receives_current_data",
    "another_terminal_of_the_same_name_is_not_opened",
];

/// Runs tests on the other machine.
fn test(target: &str) -> Result<(), String> {
    let on_arm: &[&str] = if target == ARM { &SKIPPED_ON_ARM } else { &[] };
    for (packages, skipped) in [(&CRATES[..], &SKIPPED[..]), (&STATION, &[])] {
        let skipped = skipped.iter().chain(on_arm);
        run(cargo(target)?
            .args(["test", "--locked", "--target", target])
            .args(packages)
            .arg("--")
            .args(skipped.flat_map(|name| ["--skip", name])))?;
    }
    Ok(())
}

/// Builds the program for users and returns its path.
pub(crate) fn release(target: &str, suffix: &str) -> Result<PathBuf, String> {
    run(cargo(target)?.args([
        "build",
        "--release",
        "--locked",
        "--bin",
        "groundwave",
        "--target",
        target,
    ]))?;
    Ok(folder().join(format!("{target}/release/groundwave{suffix}")))
}

/// Removes the crates of this workspace from the builds for users, so that the next build compiles them again.
pub(crate) fn forget_release(target: &str) -> Result<(), String> {
    run(cargo(target)?
        .args(["clean", "--workspace", "--release", "--locked"])
        .args(["--target", target]))
}

fn program(target: &str, suffix: &str) -> PathBuf {
    folder().join(format!("{target}/debug/groundwave{suffix}"))
}

fn folder() -> PathBuf {
    root().join("target/cross")
}

/// Debian's cargo, with what a target needs to link. Little is optimized: the standard library is built here too, and without any optimization the emulated
/// tests would take hours.
fn cargo(target: &str) -> Result<Command, String> {
    let mut cargo = debian::cargo();
    cargo
        .env("CARGO_TARGET_DIR", folder())
        .env("CARGO_PROFILE_DEV_DEBUG", "0")
        .env("CARGO_PROFILE_DEV_OPT_LEVEL", "1")
        .env("CARGO_PROFILE_RELEASE_STRIP", "true")
        .env("CARGO_UNSTABLE_TRIM_PATHS", "true")
        .env("CARGO_PROFILE_RELEASE_TRIM_PATHS", "all")
        .env(
            "CARGO_UNSTABLE_BUILD_STD",
            "std,panic_abort,proc_macro,test",
        );
    match target {
        ARM => {
            link_static(&mut cargo, "AARCH64", "aarch64")?;
            cargo.env(
                "CARGO_TARGET_AARCH64_UNKNOWN_LINUX_MUSL_RUNNER",
                "qemu-aarch64-static",
            );
        }
        X86 => link_static(&mut cargo, "X86_64", "x86_64")?,
        WINDOWS => {
            // The linker would write the time into the program.
            cargo.env(
                "CARGO_TARGET_X86_64_PC_WINDOWS_GNU_RUSTFLAGS",
                "-C link-arg=-Wl,--no-insert-timestamp",
            );
            cargo.env(
                "CARGO_TARGET_X86_64_PC_WINDOWS_GNU_RUNNER",
                format!("python3 {}/tests/systems/wine.py", root().display()),
            );
        }
        _ => {}
    }
    Ok(cargo)
}

/// Links with musl by the host's compiler driver. The unwinder is gcc's, under the name that the standard library asks for.
fn link_static(cargo: &mut Command, upper: &str, machine: &str) -> Result<(), String> {
    let tools = folder().join("tools").join(machine);
    let gcc = format!("{machine}-linux-gnu-gcc");
    let driver = tools.join("cc");
    let failed = |error| format!("cannot write {}: {error}", tools.display());
    fs::create_dir_all(&tools).map_err(failed)?;
    let specs = format!("/usr/lib/{machine}-linux-musl/musl-gcc.specs");
    let script = format!("#!/bin/sh\nexec {gcc} \"$@\" -specs {specs}\n");
    fs::write(&driver, script).map_err(failed)?;
    run(Command::new("chmod").arg("+x").arg(&driver))?;
    let found = Command::new(&gcc)
        .arg("-print-file-name=libgcc_eh.a")
        .output()
        .map_err(|error| format!("cannot start {gcc}: {error}"))?;
    let archive = tools.join("libunwind.a");
    let (unwinder, object) = (found.stdout.trim_ascii(), tools.join("dl_find_object.o"));
    let unwinder = String::from_utf8_lossy(unwinder).into_owned();
    fs::copy(&unwinder, &archive).map_err(|error| format!("cannot copy {unwinder}: {error}"))?;
    run(Command::new(&driver)
        .args(["-O2", "-c", "xtask/src/cross/dl_find_object.c", "-o"])
        .arg(&object))?;
    run(Command::new(format!("{machine}-linux-gnu-ar"))
        .arg("q")
        .args([&archive, &object]))?;
    cargo
        .env(format!("CC_{machine}_unknown_linux_musl"), &driver)
        .env(
            format!("CARGO_TARGET_{upper}_UNKNOWN_LINUX_MUSL_LINKER"),
            &driver,
        )
        .env(
            format!("CARGO_TARGET_{upper}_UNKNOWN_LINUX_MUSL_RUSTFLAGS"),
            format!(
                "-C link-self-contained=no -C relocation-model=static -L native={}",
                tools.display()
            ),
        );
    Ok(())
}
