//! The options that say where received bytes are kept.

use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::PathBuf;
use std::time::{Instant, SystemTime};

use super::cli::Keeping;
use super::{Exit, Fault};
use crate::capture::{CaptureError, Existing, name};
use crate::runtime::{KeepOptions, Keeper};

/// Opens what the options name.
pub(super) fn open(
    options: &Keeping,
    link: &str,
    notes: BTreeMap<String, String>,
    started: Instant,
) -> Result<Keeper, Fault> {
    let mcap = options.record.as_ref().map(|file| {
        file.clone()
            .unwrap_or_else(|| PathBuf::from(name::automatic(SystemTime::now())))
    });
    let keep = KeepOptions {
        tee: options.tee.clone(),
        mcap,
        existing: existing(options.append, options.force),
        link: link.to_owned(),
        notes,
        ..KeepOptions::default()
    };
    Keeper::open(&keep, started).map_err(fault)
}

pub(super) const fn existing(append: bool, force: bool) -> Existing {
    match (append, force) {
        (true, _) => Existing::Append,
        (_, true) => Existing::Overwrite,
        _ => Existing::Refuse,
    }
}

/// A file that may not be touched or read is bad input; a disk that fails is a failure.
pub(super) fn fault(error: CaptureError) -> Fault {
    let exit = match error {
        CaptureError::Exists { .. }
        | CaptureError::SameFile(_)
        | CaptureError::InUse(_)
        | CaptureError::CannotAppend(_)
        | CaptureError::Open { .. } => Exit::Usage,
        CaptureError::Read { ref error, .. } if error.kind() == ErrorKind::IsADirectory => {
            Exit::Usage
        }
        _ => Exit::Failed,
    };
    Fault::new(exit, error)
}
