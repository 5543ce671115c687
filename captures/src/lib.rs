//! Captures: the radio's bytes, kept without change.
//!
//! A capture has one of two forms. Raw text is exactly the bytes that were read, noise included: [`raw`] writes it;
//! [`text`] reads it, also in the styles of other programs. A recording is an MCAP file with the same bytes, the time
//! of each read, and all topics derived from them ([`topics`]), indexed and compressed, for other tools. The
//! [`recorder`] writes it.
//!
//! [`source`] reads either form from the beginning, for [`decode`] and [`info`]; [`index`] reads it from any position,
//! for replay. A recording in progress is an MCAP file without chunks that holds only the bytes and the station's events;
//! [`recover`] turns it into a finished recording.

mod backup;
mod bumps;
mod chunk;
pub mod content;
pub mod convert;
pub mod cut;
pub mod decode;
pub mod diagnosis;
mod error;
mod estimate;
pub mod event;
pub mod files;
mod gaps;
pub mod hint;
pub mod index;
pub mod info;
pub mod interrupted;
pub mod layout;
pub mod marks;
pub mod mcap_reader;
pub mod messages;
pub mod name;
pub mod observations;
mod odometer;
pub mod outages;
pub mod own_lines;
pub mod picture;
mod pieces;
mod presence;
pub mod raw;
mod record;
pub mod recorder;
pub mod recover;
mod recovery;
pub mod repair;
mod robot_clock;
pub mod rotation;
pub mod runs;
pub mod schema;
pub mod session;
pub mod session_writer;
pub mod song;
pub mod songs;
pub mod source;
mod station_event;
pub mod statistics;
mod temporary;
pub mod text;
pub mod text_file;
pub mod topics;
pub mod track;
mod unfinished;
mod uplink_event;
mod urgent;
pub mod verify;
pub mod when;
pub mod words;
mod write_queue;

pub use chunk::Chunk;
pub use error::{CaptureError, Existing, Fate};
pub use observations::Observation;
pub use pieces::Piece;
pub use raw::RawWriter;
pub use recorder::{Pace, Recorder};
pub use rotation::Rotation;
pub use session::Session;
pub use session_writer::{SessionWriter, TopicWriter};
pub use source::Capture;

/// Folder of the sample recordings in this crate's package, for tests.
#[must_use]
pub fn samples() -> &'static std::path::Path {
    std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
}
