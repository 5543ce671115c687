//! Groundwave: a ground station for a small robot on a 2400-baud radio.
//!
//! Bytes from the radio become facts ([`event::Event`]) in the sans-IO [`station`], facts become what
//! the screen says in the [`model`], and the [`view`] draws it. Wishes ([`event::Effect`]) go the other
//! way, and come back only as the robot's own acknowledgement. [`io`] talks to the operating system,
//! [`capture`] reads and writes recordings, [`runtime`] is the one event loop.

// They panic when the stream is closed or full, and the exit code is lost. `commands` writes with care.
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]

pub use groundwave_captures as capture;
pub use groundwave_captures::runs::figures as run;
pub use groundwave_captures::{hint, song, statistics};

pub mod calibration;
pub mod commands;
pub mod event;
pub mod io;
pub mod model;
pub mod playback;
pub mod radio;
pub mod recorded;
pub mod request;
pub mod route;
pub mod runtime;
pub mod share;
pub mod station;
pub mod suggest;
pub mod view;
