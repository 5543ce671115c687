//! Rotation: a long recording is split into several files.

use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::time::Duration;

/// Limits of one part of a recording. Each part is a complete recording and is finished while the next one is written,
/// which bounds the memory for its index.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize)]
#[serde(try_from = "String")]
pub struct Rotation {
    /// Maximum duration of a part.
    pub period: Option<Duration>,
    /// Maximum length of the unfinished file without its header, bytes. The part ends with the line that exceeds it; the finished file is
    /// smaller.
    pub bytes: Option<u64>,
}

/// Default duration of a part: a day.
pub const PERIOD: Duration = Duration::from_hours(24);

impl Default for Rotation {
    fn default() -> Self {
        Self {
            period: Some(PERIOD),
            bytes: None,
        }
    }
}

/// The text is not a rotation.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "`{0}` is neither a time such as 1h nor a size such as 64MB; examples: `--rotate 24h`, `--rotate 1h,64MB`, `--rotate never`"
)]
pub struct RotationError(String);

impl TryFrom<String> for Rotation {
    type Error = RotationError;

    fn try_from(words: String) -> Result<Self, RotationError> {
        words.parse()
    }
}

impl FromStr for Rotation {
    type Err = RotationError;

    /// Parses `1h`, `64MB`, both separated by a comma, or `never`.
    fn from_str(words: &str) -> Result<Self, RotationError> {
        let mut rotation = Self {
            period: None,
            bytes: None,
        };
        if words == "never" {
            return Ok(rotation);
        }
        for word in words.split(',') {
            let wrong = || RotationError(word.to_owned());
            let unit_at = word.find(|c: char| !c.is_ascii_digit()).ok_or_else(wrong)?;
            let (number, unit) = word.split_at(unit_at);
            let number: u64 = number.parse().map_err(|_| wrong())?;
            let scale = match unit {
                "s" | "kB" | "KB" | "k" => 1,
                "min" | "m" => 60,
                "h" => 3600,
                "d" => 86_400,
                "MB" | "M" => 1000,
                "GB" | "G" => 1_000_000,
                _ => return Err(wrong()),
            };
            let value = number
                .checked_mul(scale)
                .filter(|value| *value > 0)
                .ok_or_else(wrong)?;
            match unit {
                "s" | "min" | "m" | "h" | "d" => rotation.period = Some(Duration::from_secs(value)),
                _ => rotation.bytes = Some(value.checked_mul(1000).ok_or_else(wrong)?),
            }
        }
        Ok(rotation)
    }
}

impl Rotation {
    /// Whether a part of this age and size ends.
    #[must_use]
    pub fn is_due(&self, age: Duration, bytes: u64) -> bool {
        self.period.is_some_and(|period| age >= period)
            || self.bytes.is_some_and(|most| bytes >= most)
    }
}

/// File name of a part: `run.mcap` becomes `run-2.mcap` for part 2.
#[must_use]
pub fn part_name(path: &Path, part: u32) -> PathBuf {
    if part == 1 {
        return path.to_owned();
    }
    let mut name = path.file_stem().unwrap_or_default().to_owned();
    name.push(format!("-{part}"));
    if let Some(extension) = path.extension() {
        name.push(".");
        name.push(extension);
    }
    path.with_file_name(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_for_rotation() {
        let hour = Some(Duration::from_hours(1));
        let rotation = |period, bytes| Ok(Rotation { period, bytes });
        assert_eq!("1h".parse(), rotation(hour, None));
        assert_eq!("64MB".parse(), rotation(None, Some(64_000_000)));
        assert_eq!("1h,100kB".parse(), rotation(hour, Some(100_000)));
        assert_eq!("never".parse(), rotation(None, None));
        for wrong in [
            "",
            "1",
            "h",
            "0s",
            "-1h",
            "1h,",
            "1 h",
            "99999999999999GB",
            "1x",
        ] {
            let error = wrong.parse::<Rotation>().unwrap_err();
            assert!(error.to_string().contains("--rotate"), "{wrong}");
        }
    }

    #[test]
    fn parts_are_numbered_before_the_extension() {
        let name = |path: &str, part| part_name(Path::new(path), part);
        assert_eq!(name("a/run.mcap", 1), Path::new("a/run.mcap"));
        assert_eq!(name("a/run.mcap", 12), Path::new("a/run-12.mcap"));
        assert_eq!(name("run", 2), Path::new("run-2"));
        assert_eq!(name("v1.2/run.x.mcap", 2), Path::new("v1.2/run.x-2.mcap"));
    }
}
