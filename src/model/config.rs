//! Appearance of the dashboard and limits of its alarms.

use std::time::Duration;

use clap::ValueEnum;

use super::alarms::{AlarmSetting, Limits};
use super::keys::Keymap;

/// Settings of the dashboard, fixed for a session.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Config {
    /// Colours.
    pub colors: Colors,
    /// Whether to draw with ASCII only.
    pub ascii: bool,
    /// Characters of maps and plots, unless only ASCII is drawn.
    pub marker: Marker,
    /// Style of the lines on the map.
    pub lines: MapLines,
    /// Command that shows raw lines in another terminal; displayed above the keys.
    pub raw_copy: Option<String>,
    /// Name of the replayed capture; `None` in a live session.
    pub capture: Option<String>,
    /// Whether to ring the bell for alarms and songs.
    pub bell: bool,
    /// Whether to use the mouse.
    pub mouse: bool,
    /// Actions of the keys.
    pub keys: Keymap,
    /// Names of the robot's command strings.
    pub own_commands: Vec<String>,
    /// Limits of the alarms.
    pub limits: Limits,
    /// Alarms of the configuration, and changes to the built-in alarms.
    pub alarms: Vec<AlarmSetting>,
    /// Time since 1970 at the start of the session; `None` shows no clock.
    pub unix: Option<Duration>,
    /// Offset of local time from UTC, seconds; `None` shows only UTC.
    pub local_offset_s: Option<i32>,
    /// Use of the station's suggestions.
    pub advise: Advise,
}

/// Use of the station's suggestions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Advise {
    /// No suggestions
    Off,
    /// Suggestions are sent when the operator accepts them
    #[default]
    Suggest,
    /// The station sets suggested poses, sends scans and routes to the dock and out of a place, and plans routes again while the robot drives them
    Auto,
}

/// Characters for maps and plots, of up to 2 by 4 dots.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Marker {
    /// Braille dots, which almost every font has.
    #[default]
    Braille,
    /// Block eighths of a cell (octants, Unicode 16).
    Octant,
    /// Block quarters of a cell.
    Quadrant,
}

/// Style of the lines on the map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MapLines {
    /// Characters: the markers, or ASCII.
    #[default]
    Characters,
    /// A picture, by the kitty graphics protocol.
    Pixels,
}

/// Colours of the screen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Colors {
    /// Colours for a dark background.
    #[default]
    Dark,
    /// Colours for a light background.
    Light,
    /// Black, white and yellow.
    HighContrast,
    /// No colours: `NO_COLOR`.
    Mono,
}

impl Colors {
    /// Name in the configuration.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Dark => "dark",
            Self::Light => "light",
            Self::HighContrast => "high-contrast",
            Self::Mono => "mono",
        }
    }

    /// The next colours; after the last come the first.
    pub(crate) const fn next(self) -> Self {
        match self {
            Self::Dark => Self::Light,
            Self::Light => Self::HighContrast,
            Self::HighContrast => Self::Mono,
            Self::Mono => Self::Dark,
        }
    }
}
