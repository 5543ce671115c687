//! The configuration file: what the operator does not want to say each time.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::Duration;

use etcetera::BaseStrategy as _;
use serde::Deserialize;

use super::{Exit, Fault};
use crate::capture::Rotation;
use crate::radio::RadioKind;
use crate::runtime::REMEMBERED;

/// Everything that can be configured; what is not said keeps its default.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// The radio link.
    pub link: Link,
    /// What is recorded.
    pub recording: Recording,
    /// The file as it was read; recordings keep it.
    #[serde(skip)]
    pub text: String,
}

/// `[link]`
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Link {
    /// As `--radio`.
    pub radio: Option<RadioKind>,
    /// As `--latency`, in milliseconds.
    pub latency_ms: Option<u32>,
    /// As `--baud`.
    pub baud: Option<u32>,
}

/// `[recording]`
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Recording {
    /// How much of what came before is in a recording that is begun from the dashboard.
    pub keep_minutes: Option<u16>,
    /// As `--rotate`.
    pub rotate: Option<Rotation>,
}

impl Recording {
    /// How much is remembered while nothing is recorded.
    #[must_use]
    pub fn remembered(&self) -> Duration {
        self.keep_minutes.map_or(REMEMBERED, |minutes| {
            Duration::from_secs(u64::from(minutes) * 60)
        })
    }
}

impl Link {
    /// As `--latency`.
    #[must_use]
    pub fn latency(&self) -> Option<Duration> {
        self.latency_ms.map(|ms| Duration::from_millis(ms.into()))
    }
}

/// Reads a configuration.
///
/// # Errors
/// Says where what is wrong.
pub fn parse(text: &str) -> Result<Config, toml::de::Error> {
    toml::from_str(text)
}

/// Reads the file that was named, or the one in the usual place if there is one.
pub(super) fn load(named: Option<&Path>) -> Result<Config, Fault> {
    let Some(path) = named.map(Path::to_path_buf).or_else(usual_place) else {
        return Ok(Config::default());
    };
    let text = match fs::read_to_string(&path) {
        Ok(text) => text,
        Err(error) if named.is_none() && error.kind() == ErrorKind::NotFound => {
            return Ok(Config::default());
        }
        Err(error) => {
            let message = format!("cannot read the configuration {}: {error}", path.display());
            return Err(Fault::new(Exit::Usage, message));
        }
    };
    match parse(&text) {
        Ok(config) => Ok(Config { text, ..config }),
        Err(error) => {
            let message = format!("the configuration {} is wrong: {error}", path.display());
            Err(Fault::new(Exit::Usage, message.trim_end()))
        }
    }
}

/// `~/.config/groundwave/config.toml`, or where the system keeps such files.
fn usual_place() -> Option<PathBuf> {
    let strategy = etcetera::choose_base_strategy().ok()?;
    Some(strategy.config_dir().join("groundwave").join("config.toml"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn everything_can_be_said_and_nothing_has_to() {
        assert_eq!(parse(""), Ok(Config::default()));
        let config = parse("[link]\nradio = \"hc-12\"\nlatency_ms = 350\nbaud = 9600\n");
        let link = config.expect("it is right").link;
        assert_eq!(link.radio, Some(RadioKind::Hc12));
        assert_eq!(link.latency(), Some(Duration::from_millis(350)));
        assert_eq!(link.baud, Some(9600));
        let config = parse("[recording]\nkeep_minutes = 3\nrotate = \"1h,64MB\"\n");
        let recording = config.expect("it is right").recording;
        assert_eq!(recording.remembered(), Duration::from_secs(180));
        assert_eq!(recording.rotate, "1h,64MB".parse().ok());
    }

    #[test]
    fn mistakes_are_named_with_their_line() {
        for (text, named) in [
            ("[link]\nradoi = \"half\"\n", "unknown field `radoi`"),
            ("[link]\nradio = \"hc12\"\n", "`hc-12`"),
            ("[link]\nbaud = -1\n", "line 2"),
            ("[recording]\nrotate = \"1x\"\n", "--rotate"),
            ("[lnik]\n", "unknown field `lnik`"),
            ("link", "line 1"),
        ] {
            let error = parse(text).expect_err(text).to_string();
            assert!(error.contains(named), "{text}: {error}");
        }
    }
}
