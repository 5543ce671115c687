//! Recognizes the text lines of any robot, sans-IO.
//!
//! A [`Recognizer`] takes received bytes and returns an [`OwnLine`] for each line that is not Groundwave's. Without a
//! [`Profile`] it recognizes these forms:
//!
//! | form | example |
//! |---|---|
//! | pairs | `temp:21.5,volt:11.9` or `temp=21.5 C volt=11.9 V` |
//! | Arduino Serial Plotter | `left:3` TAB `right:4`, or plain numbers, with or without a line of labels |
//! | Teleplot | `>temp:1627551892437:21.5§C` |
//! | CSV | `t,temp` then `1,21.5`; without a header the columns are `c1`, `c2` and so on |
//! | JSON objects | `{"imu":{"yaw":1.5}}`, whose field is `imu.yaw` |
//! | NMEA 0183 | `$GPGGA,...*76` |
//!
//! A profile fixes the form and names fields, units, roles and limits. Memory is bounded: at most [`LINE_BYTES_MAX`] bytes
//! of a line and [`FIELDS_MAX`] fields. No input panics, and the time for a line grows linearly with its length.

mod checksum;
mod command;
mod field;
mod forms;
mod profile;
mod recognizer;
mod runs;

pub use checksum::Checksum;
pub use command::{CommandError, OwnCommand};
pub use field::{Field, Limits, Role};
pub use profile::{Form, Profile, ProfileError};
pub use recognizer::{Content, OwnLine, Recognizer, Sample, Value};
pub use runs::runs;

/// Maximum length of a line, bytes; longer lines count as damaged.
pub const LINE_BYTES_MAX: usize = 4096;

/// Maximum number of fields of a robot; further fields are left out.
pub const FIELDS_MAX: usize = 64;

/// Maximum length of a field's name or unit, characters; longer pairs are not recognized.
pub const NAME_CHARS_MAX: usize = 32;

/// Maximum length of a text, characters; longer texts are cut.
pub const TEXT_CHARS_MAX: usize = 240;
