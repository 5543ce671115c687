//! Builds with Debian's compiler, which includes the sources of the standard library, for machines without a compiled standard library.
//!
//! Needs rustc-web, cargo-web and rust-web-src, or `RUSTC` and `CARGO_DEBIAN` set to another compiler with its sources for
//! `-Zbuild-std` (a nightly).

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::{env, iter};

/// Set in the environment when cargo starts this program in place of the compiler: see [`rustc`].
pub(crate) const AS_RUSTC: &str = "XTASK_AS_RUSTC";

/// The user's choice in the environment, or the default.
fn variable(name: &str, default: &str) -> String {
    env::var(name).unwrap_or_else(|_| default.to_owned())
}

/// Debian's cargo with Debian's rustc.
pub(crate) fn cargo() -> Command {
    let mut cargo = Command::new(variable("CARGO_DEBIAN", "/usr/bin/cargo"));
    // Settings of the outer cargo and its user for the host do not apply to another machine.
    for name in [
        "CARGO",
        "CARGO_BUILD_TARGET",
        "CARGO_ENCODED_RUSTFLAGS",
        // LLVM's assembler refuses `movw` in an incremental build for AVR.
        "CARGO_INCREMENTAL",
        "CARGO_TARGET_DIR",
        "RUSTC_WORKSPACE_WRAPPER",
        "RUSTC_WRAPPER",
        "RUSTFLAGS",
        "RUSTUP_TOOLCHAIN",
    ] {
        cargo.env_remove(name);
    }
    cargo
        .env("RUSTC", variable("RUSTC", "/usr/bin/rustc"))
        .env("RUSTC_BOOTSTRAP", "1")
        .env("PATH", path());
    cargo
}

/// Debian's compilers before all others.
fn path() -> OsString {
    let path = env::var_os("PATH").unwrap_or_default();
    let first = iter::once(PathBuf::from("/usr/bin"));
    env::join_paths(first.chain(env::split_paths(&path))).unwrap_or(path)
}

/// The folder of all boards' programs: those for one chip share the compiled standard library.
pub(crate) fn boards() -> PathBuf {
    crate::root().join("target/boards")
}

/// Builds a board's program, which is a separate workspace.
pub(crate) fn build(board: &Path) -> Result<(), String> {
    build_with(board, &[], &boards())
}

/// Likewise, with further options, in another folder; a relative one is the board's.
pub(crate) fn build_with(board: &Path, options: &[&str], target: &Path) -> Result<(), String> {
    let wrapper = env::current_exe().map_err(|error| format!("no path of xtask: {error}"))?;
    // Cargo reads the configuration of the folder where it runs.
    crate::run(
        cargo()
            .current_dir(board)
            .env(AS_RUSTC, "1")
            .env("RUSTC_WRAPPER", wrapper)
            .args(["build", "--release", "--locked", "--target-dir"])
            .arg(target)
            .args(options),
    )
}

/// Runs the compiler as cargo wants it, but identifies a crate by its name and version alone. Cargo's identifiers contain the
/// folder, from them come the names of symbols, and from those the order of functions: the program would depend on the
/// folder where it is built.
pub(crate) fn rustc(arguments: &[String]) -> ExitCode {
    let name = arguments
        .iter()
        .skip_while(|word| *word != "--crate-name")
        .nth(1);
    let version = env::var("CARGO_PKG_VERSION").unwrap_or_default();
    let mut words = arguments.iter().map(|word| match name {
        Some(name) if word.starts_with("metadata=") => format!("metadata={name}-{version}"),
        _ => word.clone(),
    });
    let status = Command::new(words.next().unwrap_or_default())
        .args(words)
        .status();
    match status {
        Ok(status) if status.success() => ExitCode::SUCCESS,
        Ok(_) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("xtask: cannot start {arguments:?}: {error}");
            ExitCode::FAILURE
        }
    }
}
