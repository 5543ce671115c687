//! Groundwave: a ground station for a small robot on a 2400-baud radio.
//!
//! The sans-IO [`station`] turns bytes from the radio into events ([`event::Event`]), the [`model`] turns events into
//! facts, and the [`view`] draws them. The operator's requests ([`event::Effect`]) take the opposite way; their result is
//! known only from the robot's lines. [`io`] accesses the operating system, [`capture`] reads and writes recordings,
//! and [`runtime`] is the only event loop.

// These macros panic when the stream is closed or full, and the exit code is lost. `commands` writes with its own functions.
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]

pub use groundwave_captures as capture;
pub use groundwave_captures::runs::figures;
pub use groundwave_captures::{content, diagnosis, hint, outages, song, statistics};

pub mod calibration;
pub mod commands;
pub mod conformance;
pub mod event;
pub mod io;
pub mod model;
pub mod parameter_file;
pub mod playback;
pub mod radio;
pub mod recorded;
pub mod request;
pub mod route;
pub mod runtime;
pub mod safe_text;
pub mod share;
pub mod station;
pub mod suggest;
pub mod view;
pub mod wait;
