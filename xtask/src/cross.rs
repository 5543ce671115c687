//! The ground station on other machines than this one: static Linux on x86-64 and ARM, Windows under Wine, macOS checked.
//!
//! Needs, beside Debian's compiler: `musl-tools`, `musl-dev:arm64`, `gcc-aarch64-linux-gnu`, `qemu-user-static`;
//! `gcc-mingw-w64-x86-64-win32`, `wine`; for macOS only the compiler.

use std::fs;
use std::path::PathBuf;
use std::process::Command;

use crate::{debian, root, run};

pub(crate) const ARM: &str = "aarch64-unknown-linux-musl";
pub(crate) const X86: &str = "x86_64-unknown-linux-musl";
pub(crate) const WINDOWS: &str = "x86_64-pc-windows-gnu";
const MACOS: &str = "aarch64-apple-darwin";

/// The packages whose tests run on the other machine; whole-system tests need ptys and a terminal of this one.
const TESTED: [&str; 9] = [
    "-p",
    "groundwave-protocol",
    "-p",
    "sr04-firmware",
    "-p",
    "groundwave-captures",
    "-p",
    "groundwave",
    "--lib",
];

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
    run(cargo(ARM)?
        .args(["test", "--locked", "--target", ARM])
        .args(TESTED))?;
    run(Command::new("python3")
        .arg("tests/systems/linux.py")
        .args([program(X86, ""), program(ARM, "")]))
}

/// Builds for Windows and drives the program under Wine.
pub(crate) fn windows() -> Result<(), String> {
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

/// Checks every crate for macOS. Nothing is linked, so no C compiler for macOS is needed.
pub(crate) fn macos() -> Result<(), String> {
    run(cargo(MACOS)?
        .args([
            "check",
            "--workspace",
            "--locked",
            "--exclude",
            "xtask",
            "--target",
            MACOS,
        ])
        .env("CC_aarch64_apple_darwin", "true")
        .env("AR_aarch64_apple_darwin", "true"))
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

fn program(target: &str, suffix: &str) -> PathBuf {
    folder().join(format!("{target}/debug/groundwave{suffix}"))
}

fn folder() -> PathBuf {
    root().join("target/cross")
}

/// Debian's cargo, with what a target needs to link. Dependencies are not optimized: they are built for a few runs.
fn cargo(target: &str) -> Result<Command, String> {
    let mut cargo = debian::cargo();
    cargo
        .env("CARGO_TARGET_DIR", folder())
        .env("CARGO_PROFILE_DEV_DEBUG", "0")
        .env("CARGO_PROFILE_RELEASE_STRIP", "true")
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
