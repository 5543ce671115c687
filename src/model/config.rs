//! Appearance of the dashboard and limits of its alarms.

use std::time::Duration;

use super::alarms::{AlarmSetting, Limits};
use super::keys::Keymap;

/// Settings of the dashboard, fixed for a session.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Config {
    /// Colours.
    pub colors: Colors,
    /// Draw with ASCII only.
    pub ascii: bool,
    /// The signs of maps and plots, unless only ASCII is drawn.
    pub marker: Marker,
    /// What the lines of the map are drawn with.
    pub lines: MapLines,
    /// How to see raw lines in another terminal, shown above the keys.
    pub raw_copy: Option<String>,
    /// The capture shown; `None` in a live session.
    pub capture: Option<String>,
    /// Ring the bell for alarms and songs.
    pub bell: bool,
    /// Use the mouse.
    pub mouse: bool,
    /// What every key does.
    pub keys: Keymap,
    /// Names of the robot's command strings.
    pub own_commands: Vec<String>,
    /// Limits of the alarms.
    pub limits: Limits,
    /// Alarms of the configuration, and changes to the built-in ones.
    pub alarms: Vec<AlarmSetting>,
    /// Time since 1970 at the start of the session; `None` shows no clock.
    pub unix: Option<Duration>,
    /// Seconds by which local time is ahead of UTC; `None` shows UTC alone.
    pub local_offset_s: Option<i32>,
}

/// Characters of 2 by 4 dots, or fewer, for maps and plots.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Marker {
    /// Round dots, which nearly every font has.
    #[default]
    Braille,
    /// Block eighths of a cell (octants, Unicode 16).
    Octant,
    /// Block quarters of a cell.
    Quadrant,
}

/// What the lines of the map are drawn with.
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
    /// For a dark background.
    #[default]
    Dark,
    /// For a light background.
    Light,
    /// Black, white and yellow.
    HighContrast,
    /// No colours: `NO_COLOR`.
    Mono,
}

impl Colors {
    /// Its name in the configuration.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Dark => "dark",
            Self::Light => "light",
            Self::HighContrast => "high-contrast",
            Self::Mono => "mono",
        }
    }

    /// The one after this; after the last comes the first.
    pub(crate) const fn next(self) -> Self {
        match self {
            Self::Dark => Self::Light,
            Self::Light => Self::HighContrast,
            Self::HighContrast => Self::Mono,
            Self::Mono => Self::Dark,
        }
    }
}
