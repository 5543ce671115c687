//! Errors of serving a robot.

use std::io;
use std::path::PathBuf;

/// Reason why a robot cannot be served.
#[derive(Debug, thiserror::Error)]
pub enum ServeError {
    /// The system provides no pseudo-terminal.
    #[error("cannot open a pseudo-terminal: {0}; serve over TCP instead (--listen 127.0.0.1:0)")]
    Pty(io::Error),
    /// The link to the pseudo-terminal cannot be made.
    #[error("cannot make {} point to the pseudo-terminal: {problem}", path.display())]
    Link {
        /// Path of the link.
        path: PathBuf,
        /// Cause and hint.
        problem: String,
    },
    /// The address cannot be listened on.
    #[error(
        "cannot listen on {address}: {source}; choose another address, or port 0 for a free one"
    )]
    Listen {
        /// Address to listen on.
        address: String,
        /// Cause.
        source: io::Error,
    },
    /// The boot counter and the parameters cannot be stored.
    #[error("cannot store the boot counter and the parameters in {}: {problem}", path.display())]
    Eeprom {
        /// Path of the file.
        path: PathBuf,
        /// Cause and hint.
        problem: String,
    },
    /// A file cannot be created. The message does not include the cause.
    #[error("cannot write the {kind} to {}", path.display())]
    Recording {
        /// `trace` or `sound`.
        kind: &'static str,
        /// Path of the file.
        path: PathBuf,
        /// Cause.
        source: io::Error,
    },
    /// A file could not be written completely; the robot continues. The message does not include the cause.
    #[error("the {kind} in {} is incomplete", path.display())]
    Incomplete {
        /// `trace`, `sound` or `copy of the parameters`.
        kind: &'static str,
        /// Path of the file.
        path: PathBuf,
        /// Cause.
        source: io::Error,
    },
    /// The time factor is out of range.
    #[error("time factor {0} is out of range: choose one from 0.01 to 1000")]
    TimeFactor(f64),
    /// The system cannot start a thread.
    #[error("cannot start the simulation's thread: {0}")]
    Thread(io::Error),
}
