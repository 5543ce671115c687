//! Programs that talk to each other in real time. A binary of its own, because cargo runs one binary after another: those of
//! `tests/main.rs` use every core for minutes, and a robot ten times as fast does not wait that long for its ground station.
#![cfg(unix)]
#![expect(clippy::unwrap_used, reason = "a test stops where something is wrong")]

mod edges;
mod examples;
#[path = "../common/programs.rs"]
#[allow(dead_code, reason = "each binary uses its own part")]
mod programs;
#[path = "../common/pty.rs"]
#[allow(dead_code, reason = "each binary uses its own part")]
mod pty;
