//! The operating system: ports, sockets, signals, the terminal, and files that are named while the
//! dashboard runs. Recordings are [`crate::capture`]'s.

pub mod files;
pub mod foxglove;
pub mod link;
mod mouse;
pub mod ports;
pub mod share;
pub mod signals;
pub mod terminal;
pub mod via;
