//! The description of a robot's lines: `[robot.NAME.lines]`.

use regex::{Regex, RegexBuilder};
use serde::{Deserialize, Serialize};

use crate::FIELDS_MAX;
use crate::checksum::Checksum;
use crate::field::Field;

/// Maximum memory of a compiled pattern, bytes.
const PATTERN_BYTES_MAX: usize = 1 << 20;

/// Maximum nesting of a pattern.
const PATTERN_NESTING_MAX: u32 = 50;

/// Description of how to read a robot's lines.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Profile {
    /// The form of each line.
    #[serde(default)]
    pub form: Form,
    /// The checksum at the end of each line.
    #[serde(default)]
    pub checksum: Checksum,
    /// Fields: in the order of the columns for CSV, by name for the other forms. Fields that are not listed have neither
    /// unit nor role.
    #[serde(default)]
    pub fields: Vec<Field>,
    /// Regular expression whose named groups are the fields; only for the form `regex`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pattern: Option<String>,
    /// Beginnings of lines that answer commands: such a line is text, whatever its form.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub replies: Vec<String>,
}

/// The form of a robot's lines.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Form {
    /// Any form recognized without a profile.
    #[default]
    Auto,
    /// Values separated by commas, semicolons, tabs or spaces.
    Csv,
    /// Names and values, `name:value` or `name=value`.
    Pairs,
    /// One object per line.
    Json,
    /// A regular expression.
    Regex,
    /// Sentences of a GPS receiver.
    Nmea,
    /// Lines of Teleplot.
    Teleplot,
    /// Lines of the Arduino Serial Plotter: labelled or plain values.
    ArduinoPlotter,
}

/// Reason why a profile cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct ProfileError {
    /// The setting with the mistake.
    pub setting: &'static str,
    message: String,
}

impl Profile {
    /// Checks the profile.
    ///
    /// # Errors
    /// The first mistake, as text for display.
    pub fn check(&self) -> Result<(), ProfileError> {
        self.compile().map(|_| ())
    }

    /// Checks the profile; returns its pattern.
    pub(crate) fn compile(&self) -> Result<Option<Regex>, ProfileError> {
        let fault = |setting, message: String| Err(ProfileError { setting, message });
        if self.fields.len() > FIELDS_MAX {
            return fault(
                "fields",
                format!(
                    "{} fields are too many; {FIELDS_MAX} are allowed",
                    self.fields.len()
                ),
            );
        }
        for (at, field) in self.fields.iter().enumerate() {
            if let Some(mistake) = field.mistake() {
                return fault("fields", mistake);
            }
            let others = &self.fields[..at];
            if others.iter().any(|other| other.name == field.name) {
                return fault("fields", format!("two fields are called {:?}", field.name));
            }
            let same = others
                .iter()
                .find(|other| other.role.is_some() && other.role == field.role);
            if let Some(other) = same {
                let (one, two) = (&other.name, &field.name);
                return fault(
                    "fields",
                    format!("fields {one:?} and {two:?} have the same role"),
                );
            }
        }
        match (self.form, &self.pattern) {
            (Form::Regex, Some(pattern)) => self.compile_pattern(pattern).map(Some),
            (Form::Regex, None) => fault(
                "form",
                "form \"regex\" needs a pattern with named groups, such as pattern = '^T(?<temp>[0-9.]+)'".to_owned(),
            ),
            (_, Some(_)) => fault("pattern", "pattern goes with form = \"regex\" only".to_owned()),
            (_, None) => Ok(None),
        }
    }

    fn compile_pattern(&self, pattern: &str) -> Result<Regex, ProfileError> {
        let fault = |message| ProfileError {
            setting: "pattern",
            message,
        };
        let built = RegexBuilder::new(pattern)
            .size_limit(PATTERN_BYTES_MAX)
            .dfa_size_limit(PATTERN_BYTES_MAX)
            .nest_limit(PATTERN_NESTING_MAX)
            .build();
        let regex = built.map_err(|error| {
            let text = error.to_string();
            let last = text.lines().last().unwrap_or_default();
            let why = last.strip_prefix("error: ").unwrap_or(last);
            fault(format!("pattern: {why}"))
        })?;
        let groups: Vec<&str> = regex.capture_names().flatten().collect();
        if groups.is_empty() {
            return Err(fault(
                "pattern has no named group; write (?<temp>[0-9.]+) for a field temp".to_owned(),
            ));
        }
        if groups.len() > FIELDS_MAX {
            let message = format!(
                "pattern has {} groups; {FIELDS_MAX} are allowed",
                groups.len()
            );
            return Err(fault(message));
        }
        let lacks = |field: &&Field| !groups.contains(&field.name.as_str());
        if let Some(field) = self.fields.iter().find(lacks) {
            let message = format!(
                "pattern has no group for field {:?}: (?<{0}>...)",
                field.name
            );
            return Err(fault(message));
        }
        Ok(regex)
    }
}
