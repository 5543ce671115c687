//! One radio, several clients: the protocol of a shared link.
//!
//! A client gets the raw bytes from the radio, so that any tool can read them. After a [`ClientLine::Hello`] it speaks
//! JSON lines: commands in, statuses out. Nothing here touches a socket or a clock; [`crate::io::share`] and the
//! runtime do.

mod address;
mod broker;
mod calls;
mod codec;
mod lines;
mod status;

pub use address::{Address, Exposed};
pub use broker::{Asked, Broker, ClientId, Output};
pub use calls::{CallError, CallId, CallOutput, Calls, busy, is_stop, stop_queued};
pub use codec::{Ask, ClientLine, CodecError, Heard, StationLine, Welcome};
pub use lines::{LINE_MAX, Lines, TooLong};
pub use status::StatusJson;
