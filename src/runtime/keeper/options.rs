//! The options of a session's files.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Duration;

use crate::capture::{Existing, Rotation};

/// Length of the history that a recording begun from the dashboard includes.
pub const REMEMBERED: Duration = Duration::from_mins(10);

/// The files to write, and the metadata of a recording.
#[derive(Clone, Debug)]
pub struct KeepOptions {
    /// File of the raw bytes.
    pub tee: Option<PathBuf>,
    /// MCAP file.
    pub mcap: Option<PathBuf>,
    /// Whether the MCAP file has an automatic name, which gets a number if it is taken.
    pub is_unnamed: bool,
    /// Treatment of existing files.
    pub existing: Existing,
    /// The link as the operator named it.
    pub link: String,
    /// Notes for the session's table in the recording.
    pub notes: BTreeMap<String, String>,
    /// The active configuration, as text.
    pub configuration: String,
    /// Limits of one file; beyond them the recording continues in another file.
    pub rotation: Rotation,
    /// Length of the history.
    pub remembered: Duration,
}

impl Default for KeepOptions {
    fn default() -> Self {
        Self {
            tee: None,
            mcap: None,
            is_unnamed: false,
            existing: Existing::Refuse,
            link: String::new(),
            notes: BTreeMap::new(),
            configuration: String::new(),
            rotation: Rotation::default(),
            remembered: REMEMBERED,
        }
    }
}
