//! Captures: what the radio delivered, kept byte for byte.
//!
//! Two forms. The raw text ([`raw`] writes it, [`text`] reads it, also as others store it) is the evidence: exactly the bytes that
//! were read, noise included.
//! MCAP (written by the [`recorder`]) holds the same bytes with the time each was read, and all
//! that follows from them ([`topics`]), indexed and compressed, for other people's tools. A [`source`] reads
//! either, for [`decode`] and [`info`]; the [`index`] reads it from anywhere, for replay. What was interrupted is
//! made whole by [`recover`], from the [`journal`] that every recording has while it is written.

mod bumps;
pub mod composer;
pub mod convert;
pub mod cut;
pub mod decode;
mod error;
pub mod event;
pub mod hint;
pub mod index;
pub mod info;
pub mod journal;
pub mod layout;
pub mod mcap_reader;
pub mod messages;
pub mod name;
mod odometer;
pub mod picture;
mod pieces;
mod presence;
mod protobuf;
pub mod raw;
mod record;
pub mod recorder;
pub mod recover;
pub mod repair;
mod robot_clock;
pub mod rotation;
pub mod runs;
pub mod schema;
pub mod song;
pub mod songs;
pub mod source;
mod station_event;
pub mod statistics;
pub mod text;
pub mod topics;
pub mod track;
mod unpacker;
mod uplink_event;
pub mod verify;
pub mod walk;
pub mod when;
pub mod words;
pub mod writer;

pub use error::{CaptureError, Existing, Fate};
pub use pieces::Piece;
pub use raw::RawWriter;
pub use recorder::{Recorder, Session};
pub use rotation::Rotation;
pub use source::{Capture, Chunk};
