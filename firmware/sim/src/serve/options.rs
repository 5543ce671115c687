//! Options of a served robot.

use std::path::PathBuf;
use std::time::Duration;

/// Endpoint at which clients connect to the robot's radio.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Endpoint {
    /// A pseudo-terminal in raw mode; only on Unix.
    Pty {
        /// Path of a symbolic link to create to the pseudo-terminal.
        link: Option<PathBuf>,
        /// Whether the endpoint only outputs the robot's bytes and ignores input.
        copy_only: bool,
    },
    /// A TCP port. Every client receives everything; input from all clients is merged.
    Tcp {
        /// Address to listen on, as `HOST:PORT`; port 0 selects a free one.
        address: String,
        /// Whether the endpoint only outputs the robot's bytes and ignores input.
        copy_only: bool,
    },
}

/// Options of [`super::serve`].
#[derive(Clone, Debug)]
pub struct ServeOptions {
    /// Connections to the radio; each receives a copy of the downlink.
    pub endpoints: Vec<Endpoint>,
    /// Virtual seconds per second, 0.01 to 1000.
    pub time_factor: f64,
    /// Virtual time after which the robot is switched off.
    pub duration: Option<Duration>,
    /// File for the robot's EEPROM: boot counter and parameters.
    pub eeprom: Option<PathBuf>,
    /// File for a [`crate::Trace`].
    pub trace: Option<PathBuf>,
    /// File for the sound of the beeper, in virtual time.
    pub wav: Option<PathBuf>,
}

impl Default for ServeOptions {
    /// A pseudo-terminal at normal speed.
    fn default() -> Self {
        Self {
            endpoints: vec![Endpoint::Pty {
                link: None,
                copy_only: false,
            }],
            time_factor: 1.0,
            duration: None,
            eeprom: None,
            trace: None,
            wav: None,
        }
    }
}
