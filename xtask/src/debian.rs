//! Builds with Debian's compiler, which includes the sources of the standard library, for machines without a compiled standard library.
//!
//! Needs rustc-web, cargo-web and rust-web-src, or `RUSTC` and `CARGO_DEBIAN` set to another compiler with its sources for
//! `-Zbuild-std` (a nightly).

use std::env;
use std::path::Path;
use std::process::Command;

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
        .env("PATH", format!("/usr/bin:{}", variable("PATH", "")));
    cargo
}

/// Builds a board's program, which is a separate workspace.
pub(crate) fn build(board: &Path) -> Result<(), String> {
    build_with(board, &[], "target")
}

/// Likewise, with further options, in this folder of the board's.
pub(crate) fn build_with(board: &Path, options: &[&str], target: &str) -> Result<(), String> {
    // Cargo reads the configuration of the folder where it runs.
    crate::run(
        cargo()
            .current_dir(board)
            .args(["build", "--release", "--locked", "--target-dir", target])
            .args(options),
    )
}
