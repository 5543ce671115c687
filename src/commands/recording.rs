//! The options that say where received bytes are kept.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::{Instant, SystemTime};

use super::cli::RecordingArgs;
use super::config::Config;
use super::{Exit, Fault};
use crate::capture::{Existing, Rotation, name};
use crate::runtime::{KeepOptions, Keeper};

/// Opens what the options name.
pub(super) fn open(
    options: &RecordingArgs,
    link: &str,
    notes: BTreeMap<String, String>,
    config: &Config,
    started: Instant,
) -> Result<Keeper, Fault> {
    let mcap = options
        .record
        .as_ref()
        .map(|file| file.clone().unwrap_or_else(automatic_name));
    for path in [&options.tee, &mcap].into_iter().flatten() {
        check_name(path)?;
    }
    let keep = KeepOptions {
        tee: options.tee.clone(),
        mcap,
        is_unnamed: options.record == Some(None),
        existing: existing(options.append, options.force),
        link: link.to_owned(),
        notes,
        configuration: config.text.clone(),
        rotation: rotation(options.rotate, config),
        remembered: config.recording.remembered(),
    };
    Keeper::open(&keep, started).map_err(Fault::from)
}

/// A recording is a file; elsewhere `-` is standard output, and a file of that name would surprise.
pub(super) fn check_name(path: &Path) -> Result<(), Fault> {
    if path != Path::new("-") {
        return Ok(());
    }
    Err(Fault::new(
        Exit::Usage,
        "nothing is recorded to standard output: what arrives there is shown by `groundwave watch - --headless` \
         or passed on by `cat`; a file of that name is ./-",
    ))
}

/// When a recording goes on in another file: as it was said, or as it is configured.
pub(super) fn rotation(said: Option<Rotation>, config: &Config) -> Rotation {
    said.or(config.recording.rotate).unwrap_or_default()
}

/// For a recording that nobody named.
pub(super) fn automatic_name() -> PathBuf {
    PathBuf::from(name::automatic(SystemTime::now()))
}

pub(super) const fn existing(append: bool, force: bool) -> Existing {
    match (append, force) {
        (true, _) => Existing::Append,
        (_, true) => Existing::Overwrite,
        _ => Existing::Refuse,
    }
}
