//! Opens, finishes and names recordings according to the options.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
#[cfg(unix)]
use std::time::Duration;
use std::time::{Instant, SystemTime};

use super::cli::RecordingArgs;
use super::config::Config;
use super::output::check_inputs;
use super::{Exit, Fault};
use crate::capture::{Existing, Rotation, Session, name};
use crate::hint::shell_word;
#[cfg(unix)]
use crate::io::signals::is_terminated;
use crate::runtime::{KeepOptions, Keeper};

/// Metadata for a recording: the baud rate of the link, if it is known.
pub(super) fn baud_note(baud: Option<u32>) -> Option<(String, String)> {
    baud.map(|baud| (Session::BAUD.to_owned(), baud.to_string()))
}

/// Opens the recordings that the options name.
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

/// Time after which a second SIGTERM is meant as one. `timeout` sends it to the program and to its group, which is one signal or two.
#[cfg(unix)]
const SECOND_AFTER: Duration = Duration::from_millis(500);

/// Finishes the recording; returns the number of bytes in the files. Ctrl-C or a second SIGTERM ends the wait and leaves the rest to `recover`. A
/// hangup does not, because it also follows the end of a closed terminal.
pub(super) async fn finish(keeper: &Keeper) -> Result<u64, Fault> {
    let status = keeper.status();
    let finishing = keeper.clone();
    let finished = tokio::task::spawn_blocking(move || finishing.finish());
    tokio::select! {
        biased;
        finished = finished => {
            let finished = finished.map_err(|error| Fault::new(Exit::Failed, error))?;
            finished.map_err(Fault::from)
        }
        () = another_signal() => {
            let recovery = status.mcap.map(|path| {
                let path = shell_word(Path::new(&path));
                format!("; everything received is kept, and `groundwave recover {path}` finishes it")
            });
            let recovery = recovery.unwrap_or_default();
            Err(Fault::new(
                Exit::Failed,
                format!("left before the recording was finished{recovery}"),
            ))
        }
    }
}

/// Waits for Ctrl-C, or for a second SIGTERM from [`SECOND_AFTER`] on.
async fn another_signal() {
    let interrupt = async {
        if tokio::signal::ctrl_c().await.is_err() {
            std::future::pending::<()>().await;
        }
    };
    #[cfg(unix)]
    let terminate = async {
        use tokio::signal::unix::{SignalKind, signal};
        if !is_terminated() {
            std::future::pending::<()>().await;
        }
        tokio::time::sleep(SECOND_AFTER).await;
        match signal(SignalKind::terminate()) {
            Ok(mut terminate) => drop(terminate.recv().await),
            Err(_) => std::future::pending().await,
        }
    };
    #[cfg(not(unix))]
    let terminate = std::future::pending::<()>();
    tokio::select! {
        () = interrupt => {}
        () = terminate => {}
    }
}

/// Refuses `-`, which means standard output elsewhere, and the configuration.
pub(super) fn check_name(path: &Path) -> Result<(), Fault> {
    if path != Path::new("-") {
        return check_inputs(path, ["-"]);
    }
    Err(Fault::new(
        Exit::Usage,
        "cannot record to standard output; write to a file, or use `groundwave watch LINK --headless` for events (a file \
         named - is ./-)",
    ))
}

/// Time or size after which another file is started: from the command line, else from the configuration.
pub(super) fn rotation(option: Option<Rotation>, config: &Config) -> Rotation {
    option.or(config.recording.rotate).unwrap_or_default()
}

/// The default name of a recording.
pub(super) fn automatic_name() -> PathBuf {
    PathBuf::from(name::automatic(SystemTime::now()))
}

/// Treatment of an existing file, according to the options.
pub(super) const fn existing(append: bool, force: bool) -> Existing {
    match (append, force) {
        (true, _) => Existing::Append,
        (_, true) => Existing::Overwrite,
        _ => Existing::Refuse,
    }
}
