//! What a keeper is asked to keep.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Duration;

use crate::capture::{Existing, Rotation};

/// How much of what came before is in a recording that is begun from the dashboard.
pub const REMEMBERED: Duration = Duration::from_mins(10);

/// What to keep, and where.
#[derive(Clone, Debug)]
pub struct KeepOptions {
    /// Raw bytes go here.
    pub tee: Option<PathBuf>,
    /// MCAP goes here.
    pub mcap: Option<PathBuf>,
    /// Nobody named the MCAP: where another has its name it gets one like it.
    pub is_unnamed: bool,
    /// What to do with files that exist.
    pub existing: Existing,
    /// The link as the operator named it.
    pub link: String,
    /// What else the recording shall say about itself.
    pub notes: BTreeMap<String, String>,
    /// The configuration in force, as text.
    pub configuration: String,
    /// When a recording goes on in another file.
    pub rotation: Rotation,
    /// How much is remembered while nothing is recorded.
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
