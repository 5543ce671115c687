//! Parameter files: one `name = value` per line; `#` begins a comment. The format is a subset of TOML.

use std::collections::BTreeMap;
use std::fmt::{self, Write as _};

use groundwave_protocol::telemetry::{ParameterLine, ParameterName};

use crate::request::{
    Amount, Request, RequestError, Tuning, in_whole_unit, known_parameters, unit_words,
};
use crate::suggest::question;

/// Reason why a text is not a set of parameters, or why this robot cannot take the set.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{file}:{line}: {problem}")]
pub struct FileError {
    file: String,
    /// Line of the text, from 1.
    line: usize,
    problem: String,
}

/// A parameter of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Entry {
    name: ParameterName,
    value: Amount,
    /// Line of the text, from 1.
    line: usize,
}

impl Entry {
    /// The command that sets the robot's parameter to this value.
    #[must_use]
    pub const fn request(&self) -> Request {
        Request::Parameter(Tuning::Set(self.name, self.value))
    }

    /// Line of the entry in the file, from 1.
    #[must_use]
    pub const fn line(&self) -> usize {
        self.line
    }
}

/// A set of parameters from a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ParameterFile {
    name: String,
    entries: Vec<Entry>,
}

/// A parameter with different values in a file and in the robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Difference {
    /// The parameter in the file.
    pub entry: Entry,
    /// Value in the file, in counts of the robot's unit.
    pub wanted: i32,
    /// The robot's parameter.
    pub robot: ParameterLine,
}

/// Writes text such as `top-speed: 8 in the file, 12 in the robot (in/s)`.
impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let unit = self.robot.unit.as_str();
        let (wanted, _) = shown(self.wanted, unit);
        let (value, unit) = shown(self.robot.value, unit);
        let (name, unit) = (self.robot.name.as_str(), in_brackets(&unit));
        write!(
            f,
            "{name}: {wanted} in the file, {value} in the robot{unit}"
        )
    }
}

impl ParameterFile {
    /// Parses a set; errors name the `file`.
    ///
    /// # Errors
    /// The first mistake, with file and line.
    pub fn parse(file: &str, text: &str) -> Result<Self, FileError> {
        let mut lines_of = BTreeMap::new();
        let mut entries = Vec::new();
        for (line, text) in (1..).zip(text.trim_start_matches('\u{feff}').lines()) {
            let wrong = |problem: String| FileError {
                file: file.to_owned(),
                line,
                problem,
            };
            let text = text.split('#').next().unwrap_or_default().trim();
            if text.is_empty() {
                continue;
            }
            let Some((name, value)) = text.split_once('=') else {
                return Err(wrong(format!("`{text}` is not `name = value`")));
            };
            let (name, value) = (name.trim(), value.trim());
            let request = Request::from_words(&["param", "set", name, value]);
            let (name, value) = match request {
                Ok(Request::Parameter(Tuning::Set(name, value))) => (name, value),
                Err(RequestError::ParameterUnknown(name, meant)) => {
                    let problem = format!("unknown parameter `{name}`; did you mean `{meant}`?");
                    return Err(wrong(problem));
                }
                Ok(_) => return Err(wrong(format!("`{text}` is not `name = value`"))),
                Err(error) => return Err(wrong(error.to_string())),
            };
            if let Some(first) = lines_of.insert(name.as_str().to_owned(), line) {
                let name = name.as_str();
                return Err(wrong(format!("`{name}` is already set in line {first}")));
            }
            entries.push(Entry { name, value, line });
        }
        if entries.is_empty() {
            return Err(FileError {
                file: file.to_owned(),
                line: 1,
                problem: "no parameters; write `name = value` lines, or let `param LINK save-to FILE` write them".to_owned(),
            });
        }
        Ok(Self {
            name: file.to_owned(),
            entries,
        })
    }

    /// The parameters in the order of the file.
    #[must_use]
    pub fn entries(&self) -> &[Entry] {
        &self.entries
    }

    /// The name of the file.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The parameters whose values differ from the robot's.
    ///
    /// # Errors
    /// If the robot lacks a parameter or does not accept a value.
    pub fn differences(&self, robot: &[ParameterLine]) -> Result<Vec<Difference>, FileError> {
        let mut found = Vec::new();
        for entry in &self.entries {
            let wrong = |problem| FileError {
                file: self.name.clone(),
                line: entry.line,
                problem,
            };
            let name = entry.name.as_str();
            let Some(line) = robot.iter().find(|line| line.name == entry.name) else {
                let near = question(name, robot.iter().map(|line| line.name.as_str()));
                return Err(wrong(format!("the robot has no parameter `{name}`{near}")));
            };
            let counts = entry.value.counts(line.unit.as_str());
            let accepted = counts.filter(|counts| (line.least..=line.most).contains(counts));
            let Some(wanted) = accepted else {
                let limits = limits(line);
                return Err(wrong(format!("`{name} = {}`: {limits}", entry.value)));
            };
            if wanted != line.value {
                found.push(Difference {
                    entry: *entry,
                    wanted,
                    robot: *line,
                });
            }
        }
        Ok(found)
    }
}

/// The values that a parameter accepts, as text: `it takes 100 to 130 (V/10), or 10.0 to 13.0 V`.
#[must_use]
pub fn limits(line: &ParameterLine) -> String {
    let unit = line.unit.as_str();
    let words = in_brackets(&unit_words(unit));
    let counts = format!("it takes {} to {}{words}", line.least, line.most);
    match (
        in_whole_unit(line.least, unit),
        in_whole_unit(line.most, unit),
    ) {
        (Some((least, _)), Some((most, whole))) => {
            format!("{counts}, or {least} to {most} {whole}")
        }
        _ => counts,
    }
}

/// A value in the largest unit that needs no rounding, and that unit in words: `11.6` and `V`.
fn shown(value: i32, unit: &str) -> (String, String) {
    match in_whole_unit(value, unit) {
        Some((value, whole)) => (value, whole.to_owned()),
        None => (value.to_string(), unit_words(unit)),
    }
}

/// A unit behind a number: ` (in/s)`.
fn in_brackets(unit: &str) -> String {
    if unit.is_empty() {
        String::new()
    } else {
        format!(" ({unit})")
    }
}

/// The text of a file with the robot's parameters, in the robot's order, with meanings, units and limits as comments.
#[must_use]
pub fn write(head: &str, robot: &[ParameterLine]) -> String {
    let mut text = format!(
        "# {head}\n# Edit values, then: groundwave param LINK load FILE\n# `groundwave param LINK save` keeps them over a reset.\n"
    );
    let mut lines: Vec<&ParameterLine> = robot.iter().collect();
    lines.sort_by_key(|line| line.place);
    for line in lines {
        let name = line.name.as_str();
        let about = known_parameters().find(|(known, _)| *known == name);
        text.push('\n');
        if let Some((_, about)) = about {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "# {about}");
        }
        let [(value, unit), (least, _), (most, _)] =
            [line.value, line.least, line.most].map(|value| shown(value, line.unit.as_str()));
        let comma = if unit.is_empty() { "" } else { ", " };
        let _ = writeln!(text, "{name} = {value}  # {unit}{comma}{least} to {most}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use groundwave_protocol::telemetry::Printable;

    fn line(place: u8, name: &str, value: i32, unit: &str, limits: [i32; 2]) -> ParameterLine {
        ParameterLine {
            place,
            count: 2,
            name: ParameterName::new(name),
            value,
            kept: value,
            least: limits[0],
            most: limits[1],
            unit: Printable::new(unit),
        }
    }

    fn robot() -> Vec<ParameterLine> {
        vec![
            line(2, "battery-low", 116, "V/10", [100, 130]),
            line(1, "top-speed", 12, "in/s", [2, 12]),
        ]
    }

    #[test]
    fn written_values_read_back_equal() {
        let text = write("Parameters of robot 4", &robot());
        assert!(
            text.contains("# Maximum prowling speed.\ntop-speed = 12  # in/s, 2 to 12\n"),
            "{text}"
        );
        assert!(
            text.contains("battery-low = 11.6  # V, 10.0 to 13.0\n"),
            "{text}"
        );
        let read = ParameterFile::parse("a.toml", &text).unwrap();
        let names: Vec<&str> = read
            .entries
            .iter()
            .map(|entry| entry.name.as_str())
            .collect();
        assert_eq!(names, ["top-speed", "battery-low"]);
        assert_eq!(read.differences(&robot()), Ok(Vec::new()));
        assert!(toml::from_str::<toml::Table>(&text).is_ok());
    }

    #[test]
    fn differences_are_named_and_only_they_are_sent() {
        let read =
            ParameterFile::parse("a.toml", "battery-low = 11.8\ntop-speed = 12 # as it is\n");
        let differences = read.unwrap().differences(&robot()).unwrap();
        let words: Vec<String> = differences.iter().map(ToString::to_string).collect();
        assert_eq!(
            words,
            ["battery-low: 11.8 in the file, 11.6 in the robot (V)"]
        );
        assert_eq!(
            differences[0].entry.request().to_string(),
            "param set battery-low 11.8"
        );
    }

    #[test]
    fn mistakes_are_named_by_file_and_line() {
        for (text, expected) in [
            ("", "a.toml:1: no parameters"),
            ("\ntop-speed", "a.toml:2: `top-speed` is not `name = value`"),
            (
                "top-sped = 3",
                "a.toml:1: unknown parameter `top-sped`; did you mean `top-speed`?",
            ),
            (
                "top-speed = fast",
                "a.toml:1: `fast` is not a parameter value",
            ),
            (
                "slew = 9\nslew = 9",
                "a.toml:2: `slew` is already set in line 1",
            ),
        ] {
            let error = ParameterFile::parse("a.toml", text)
                .unwrap_err()
                .to_string();
            assert!(error.starts_with(expected), "{error}");
        }
        for (text, expected) in [
            (
                "# a comment\ntop-speed = 13",
                "a.toml:2: `top-speed = 13`: it takes 2 to 12 (in/s)",
            ),
            (
                "battery-low = 11.65",
                "it takes 100 to 130 (V/10), or 10.0 to 13.0 V",
            ),
            ("warp = 9", "a.toml:1: the robot has no parameter `warp`"),
        ] {
            let read = ParameterFile::parse("a.toml", text).unwrap();
            let error = read.differences(&robot()).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        }
    }
}
