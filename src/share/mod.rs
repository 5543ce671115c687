//! One radio, several clients: the protocol of a shared link.
//!
//! A client gets an announcement and the raw bytes from the radio, which any tool can read. After a [`ClientLine::Hello`], client and station exchange JSON
//! lines: the client sends commands and gets statuses, and the raw bytes if it wants them. This module is sans-IO; [`crate::io::share`] and the runtime own sockets
//! and clock.

mod address;
mod answers;
mod broker;
mod calls;
mod codec;
mod lines;
mod status;

pub use address::{Address, Exposed};
pub use answers::Answers;
pub use broker::{Asked, Broker, CLIENTS_MAX, ClientId, OPERATOR, Output, ToClient, ToStation};
pub use calls::{CallError, CallId, CallOutput, Calls, busy, is_stop, stop_queued};
pub use codec::{
    ANNOUNCEMENT, Ask, ClientLine, CodecError, Heard, RawBytes, StationLine, Welcome, is_announced,
};
pub use lines::{LINE_MAX, Lines, TooLong};
pub use status::StatusJson;
