//! The configuration file.

mod mistakes;
mod profile;
mod read;
#[cfg(test)]
mod tests;

use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::ValueEnum;
use etcetera::BaseStrategy as _;
use groundwave_lines::{OwnCommand, Profile, Recognizer};
use serde::Deserialize;

use super::output::protect_configuration;
use super::{Exit, Fault};
use crate::capture::{Rotation, Session, files, text_file};
use crate::hint;
use crate::io::alarm_hook::AlarmHook;
use crate::model::keys::Keymap;
use crate::model::{AlarmSetting, Limits};
use crate::radio::RadioKind;
use crate::runtime::REMEMBERED;
use crate::share::Address;
pub use mistakes::Mistake;
pub use read::parse;
use read::parse_lenient;

/// The default configuration file with every setting commented out, without the keys.
pub(super) const DEFAULT: &str = include_str!("config/default.toml");

/// The configuration; settings that are not given keep their defaults.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Config {
    /// Settings for every link.
    pub link: Link,
    /// Settings of the dashboard.
    pub dashboard: Dashboard,
    /// Limits of the alarms.
    pub limits: Limits,
    /// Alarms, and changes to the built-in alarms.
    pub alarms: Vec<AlarmSetting>,
    /// Shell command that gets each alarm event.
    pub alarm_hook: Option<String>,
    /// The actions of the keys.
    pub keys: Keymap,
    /// Links by name.
    pub links: BTreeMap<String, Link>,
    /// Robots by name.
    pub robots: BTreeMap<String, Robot>,
    /// The chosen robot's own lines and commands.
    pub own: OwnRobot,
    /// Settings of recordings.
    pub recording: Recording,
    /// Path of the file.
    pub path: Option<PathBuf>,
    /// Text of the file; recordings include it.
    pub text: String,
    /// Entries that are right for some robots only.
    pub notes: Vec<Mistake>,
}

/// Settings of a link: `[link]` and `[link.NAME]`.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Link {
    /// Port, like `LINK` on the command line; only in `[link.NAME]`.
    pub port: Option<String>,
    /// Kind of radio, like `--radio`.
    pub radio: Option<RadioKind>,
    /// Latency of the radio, like `--latency`, milliseconds.
    pub latency_ms: Option<u32>,
    /// Baud rate, like `--baud`.
    pub baud: Option<u32>,
    /// Address to share on, like `--share`.
    #[serde(deserialize_with = "read::address")]
    pub share: Option<Address>,
}

/// Settings of the dashboard: `[dashboard]`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Dashboard {
    /// Colours.
    pub theme: Option<Theme>,
    /// Whether the screen uses only ASCII.
    pub ascii: Option<bool>,
    /// Characters of maps and plots.
    pub map: Option<MapSigns>,
    /// Whether the bell rings for songs and alarms.
    pub bell: Option<bool>,
    /// Whether the mouse selects and zooms.
    pub mouse: Option<bool>,
    /// Clock of the status line and of replays.
    pub clock: Option<Clock>,
}

/// Settings of a robot: `[robot.NAME]`.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Robot {
    /// The name of a `[link.NAME]`, or a link as on the command line.
    pub link: Option<String>,
    /// Overrides the baud rate in `[link.NAME]` or `[link]`.
    pub baud: Option<u32>,
    /// Overrides the setting in `[dashboard]`.
    pub theme: Option<Theme>,
    /// Overrides the setting in `[dashboard]`.
    pub ascii: Option<bool>,
    /// Overrides the setting in `[dashboard]`.
    pub map: Option<MapSigns>,
    /// Overrides the setting in `[dashboard]`.
    pub bell: Option<bool>,
    /// Overrides the setting in `[dashboard]`.
    pub mouse: Option<bool>,
    /// Form of the robot's own lines: `[robot.NAME.lines]`.
    pub lines: Option<Profile>,
    /// Command strings of the robot: `[robot.NAME.commands]`.
    pub commands: BTreeMap<String, OwnCommand>,
    /// Limits of the robot's alarms: `[robot.NAME.limits]`, with missing ones from `[limits]`.
    pub limits: Limits,
}

impl Robot {
    /// The alarms for the limits of its fields.
    fn field_alarms(&self) -> impl Iterator<Item = AlarmSetting> {
        let fields = self.lines.iter().flat_map(|lines| &lines.fields);
        fields.flat_map(|field| {
            let alarm = |side: &str, limit: f64| AlarmSetting {
                name: format!("{} {side} {limit}", field.name),
                field: Some(field.name.clone()),
                ..AlarmSetting::default()
            };
            let low = field.limits.low.map(|low| AlarmSetting {
                below: Some(low),
                ..alarm("below", low)
            });
            let high = field.limits.high.map(|high| AlarmSetting {
                above: Some(high),
                ..alarm("above", high)
            });
            low.into_iter().chain(high)
        })
    }
}

/// Lines and command strings of a robot that does not use Groundwave's protocol.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OwnRobot {
    /// Form of the robot's lines; recognized automatically if not given.
    pub lines: Option<Profile>,
    /// Commands of the robot, by name.
    pub commands: BTreeMap<String, OwnCommand>,
}

/// The time of day on the screen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Clock {
    /// Only the time in UTC.
    Utc,
    /// UTC and local time.
    Local,
}

/// Colours of the screen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Theme {
    /// The theme that `NO_COLOR`, `TERM` and `COLORFGBG` select.
    Auto,
    /// Colours for a dark background.
    Dark,
    /// Colours for a light background.
    Light,
    /// Black, white and yellow.
    HighContrast,
    /// No colours.
    Mono,
}

/// Characters of maps and plots.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MapSigns {
    /// Octants in terminals that are known to draw them, else Braille.
    Auto,
    /// Block eighths of a cell (octants, Unicode 16).
    Octant,
    /// Braille dots.
    Braille,
    /// Block quarters of a cell.
    Quadrant,
    /// The map as a picture if the terminal shows pictures, else as `Auto`.
    Pixels,
}

/// Settings of recordings: `[recording]`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Recording {
    /// Number of minutes before its start that a recording begun in the dashboard includes.
    pub keep_minutes: Option<u16>,
    /// Time or size after which another file is started, like `--rotate`.
    pub rotate: Option<Rotation>,
}

impl Config {
    /// Names of the command strings of all configured robots, because a station reached by its address may serve any of them.
    pub(super) fn all_own_commands(&self) -> Vec<String> {
        let robots = self.robots.values();
        let names: BTreeSet<_> = robots.flat_map(|robot| robot.commands.keys()).collect();
        names.into_iter().cloned().collect()
    }

    /// Starts the operator's command for alarms, if there is one.
    pub(super) fn start_alarm_hook(&self) -> Result<Option<AlarmHook>, Fault> {
        let hook = self.alarm_hook.as_deref().map(AlarmHook::start);
        hook.transpose().map_err(|error| {
            let reason = hint::words(&error);
            Fault::new(
                Exit::Failed,
                format!("cannot start the alarm hook: {reason}"),
            )
        })
    }
}

impl OwnRobot {
    fn of(robot: &Robot) -> Self {
        let mut lines = robot.lines.clone();
        if let Some(lines) = &mut lines {
            let replies = robot.commands.values().map(OwnCommand::reply_start);
            let replies = replies.filter(|reply| !reply.is_empty());
            lines.replies.extend(replies.map(str::to_owned));
        }
        Self {
            lines,
            commands: robot.commands.clone(),
        }
    }

    /// Metadata for a recording: the form of the robot's own lines.
    pub(super) fn note(&self) -> Option<(String, String)> {
        let profile = serde_json::to_string(self.lines.as_ref()?).ok()?;
        Some((Session::LINES.to_owned(), profile))
    }

    /// Recognizer for the robot's own lines; recognizes the form itself if none is configured.
    pub(super) fn recognizer(&self) -> Result<Recognizer, Fault> {
        let usage = |error| Fault::new(Exit::Usage, error);
        let configured = self.lines.as_ref().map(Recognizer::new);
        configured
            .unwrap_or_else(|| Ok(Recognizer::default()))
            .map_err(usage)
    }
}

impl Recording {
    /// Length of the history kept in memory while nothing is recorded.
    #[must_use]
    pub fn remembered(&self) -> Duration {
        self.keep_minutes.map_or(REMEMBERED, |minutes| {
            Duration::from_secs(u64::from(minutes) * 60)
        })
    }
}

impl Link {
    /// Configured latency of the radio.
    #[must_use]
    pub fn latency(&self) -> Option<Duration> {
        self.latency_ms.map(|ms| Duration::from_millis(ms.into()))
    }
}

/// Reads the named file, or the file at the default path if it exists.
pub(super) fn load(named: Option<&Path>) -> Result<Config, Fault> {
    let (config, fault) = load_lenient(named);
    fault.map_or(Ok(config), Err)
}

fn read_configuration(path: &Path) -> io::Result<String> {
    text_file::read_to_end(files::open(path)?, text_file::TOML_BYTES_MAX)
}

/// Reads the configuration without its wrong settings, and reports those as a fault.
pub(super) fn load_lenient(named: Option<&Path>) -> (Config, Option<Fault>) {
    let Some(path) = named.map(Path::to_path_buf).or_else(usual_place) else {
        return (Config::default(), None);
    };
    match read_configuration(&path) {
        Ok(text) => {
            protect_configuration(&path);
            let (config, mistakes) = parse_lenient(&text);
            let fault = (!mistakes.is_empty()).then(|| blame(&path, &mistakes));
            let path = Some(path);
            (
                Config {
                    path,
                    text,
                    ..config
                },
                fault,
            )
        }
        Err(error) if named.is_none() && error.kind() == ErrorKind::NotFound => {
            (Config::default(), None)
        }
        Err(error) => {
            let why = match error.kind() {
                ErrorKind::NotFound => format!(
                    "file not found; `groundwave config > {}` makes a file to start from",
                    hint::shell_word(&path)
                ),
                _ if files::is_named_pipe(&path) => format!(
                    "it is a named pipe; copy it to a file first: cat {} > FILE",
                    hint::shell_word(&path)
                ),
                _ => hint::of_reading(&error),
            };
            let message = format!("cannot read the configuration {}: {why}", path.display());
            (Config::default(), Some(Fault::new(Exit::Usage, message)))
        }
    }
}

/// Maximum mistakes that are listed: the first ones.
const LISTED_MAX: usize = 100;

/// The fault for mistakes in the configuration: one per line, in the format that editors recognize.
fn blame(path: &Path, mistakes: &[Mistake]) -> Fault {
    let path = path.display();
    let mut lines = Vec::new();
    if mistakes.len() > 1 {
        lines.push(format!("{} mistakes in the configuration:", mistakes.len()));
    }
    let listed = mistakes.iter().take(LISTED_MAX);
    lines.extend(listed.map(|mistake| format!("{path}:{mistake}")));
    if mistakes.len() > LISTED_MAX {
        lines.push(format!("and {} more", mistakes.len() - LISTED_MAX));
    }
    lines.push("`groundwave config` prints every setting with its values".to_owned());
    Fault::of_lines(Exit::Usage, &lines)
}

/// Default path: `~/.config/groundwave/config.toml`, or the system's equivalent.
pub(super) fn usual_place() -> Option<PathBuf> {
    let strategy = etcetera::choose_base_strategy().ok()?;
    Some(strategy.config_dir().join("groundwave").join("config.toml"))
}
