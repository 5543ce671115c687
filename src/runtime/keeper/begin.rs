//! Begins recordings.

use std::path::Path;
use std::time::SystemTime;

use super::KeepOptions;
use crate::capture::{CaptureError, Existing, Recorder, Session, files, interrupted, name};

/// Maximum number of recordings with automatic names begun in one second.
const NAMES_MAX: u32 = 100;

/// Begins a recording; renames an interrupted recording with the same name.
pub(super) fn begin(
    options: &KeepOptions,
    path: &Path,
    start: SystemTime,
) -> Result<Recorder, CaptureError> {
    // Only raw text can be appended to.
    let existing = match options.existing {
        Existing::Append => Existing::Refuse,
        other => other,
    };
    let session = Session {
        link: options.link.clone(),
        start,
        notes: options.notes.clone(),
        configuration: options.configuration.clone(),
    };
    files::refuse_own_name(path)?;
    interrupted::set_aside(path)?;
    Recorder::start_rotating(path, existing, &session, options.rotation)
}

/// Begins a recording under an automatic name, with a number if another recording began in the same second.
pub(super) fn begin_unnamed(
    options: &KeepOptions,
    path: &Path,
    start: SystemTime,
) -> Result<Recorder, CaptureError> {
    for number in 1..NAMES_MAX {
        match begin(options, &name::another(path, number), start) {
            Err(CaptureError::Exists { .. } | CaptureError::InUse(_)) => {}
            begun => return begun,
        }
    }
    begin(options, &name::another(path, NAMES_MAX), start)
}
