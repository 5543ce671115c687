//! The operating system: ports, sockets, signals, the terminal, and text files. Recordings belong to [`crate::capture`].

pub mod alarm_hook;
pub mod files;
pub mod foxglove;
pub mod link;
mod mouse;
pub mod open_files;
pub mod ports;
pub mod share;
pub mod share_client;
pub mod signals;
pub mod terminal;
#[cfg(unix)]
mod unix_socket;
pub mod usb;
