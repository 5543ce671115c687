//! The only code that touches the operating system: ports, sockets, files' ends, the clock, signals
//! and the terminal.

pub mod files;
pub mod link;
pub mod ports;
pub mod signals;
pub mod terminal;
