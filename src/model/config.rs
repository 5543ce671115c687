//! How the dashboard looks and when it raises alarms.

use std::time::Duration;

use super::Limits;
use super::keys::Keymap;

/// How the dashboard is to look, fixed for a session.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Config {
    /// Colours.
    pub colors: Colors,
    /// Nothing but ASCII on the screen.
    pub ascii: bool,
    /// How to see the raw line from another terminal, told above the keys; `None` where there is no way.
    pub raw_copy: Option<String>,
    /// The capture on show; `None` in a live session.
    pub capture: Option<String>,
    /// Ring the bell for alarms and songs.
    pub bell: bool,
    /// Ask the terminal for the mouse.
    pub mouse: bool,
    /// What every key does.
    pub keys: Keymap,
    /// When there is an alarm.
    pub limits: Limits,
    /// Since 1970 at the beginning of the session; `None` shows no clock.
    pub unix: Option<Duration>,
}

/// Colours of the screen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Colors {
    /// For a dark background.
    #[default]
    Dark,
    /// For a light background.
    Light,
    /// Black, white and yellow.
    HighContrast,
    /// None: `NO_COLOR`.
    Mono,
}
