//! `param save-to`, `load` and `diff`: a file with a set of parameters, and the robot's list.

use std::path::Path;

use groundwave_protocol::telemetry::ParameterLine;
use serde_json::json;

use super::super::cli::Send;
use super::super::{Exit, Fault, show_line};
use super::step::{Line, read_text, usage};
use crate::event::SaveProblem;
use crate::io::files;
use crate::parameter_file::{self, ParameterFile};
use crate::request::Tuning;
use groundwave_captures::words::counted;

/// A task that needs the robot's list of parameters.
pub(super) enum ParameterTask {
    /// Write the robot's parameters to a file.
    SaveTo(String),
    /// Set the parameters that differ from a file.
    Load(ParameterFile),
    /// Show the parameters that differ from a file.
    Diff(ParameterFile),
}

impl ParameterTask {
    /// The task that the words of a command describe; `None` for other commands.
    pub(super) fn from_words(words: &[&str]) -> Result<Option<Self>, Fault> {
        match *words {
            ["param", "save-to", file] => Ok(Some(Self::SaveTo(file.to_owned()))),
            ["param", "load", file] => Ok(Some(Self::Load(read(file)?))),
            ["param", "diff", file] => Ok(Some(Self::Diff(read(file)?))),
            ["param", verb, ..] if Tuning::FILE_VERBS.contains(&verb) => Err(usage(format!(
                "`param {verb}` takes one file; quote a name with spaces"
            ))),
            _ => Ok(None),
        }
    }

    /// The commands that the task may send.
    pub(super) fn lines(&self) -> Vec<Line> {
        let entries = match self {
            Self::Load(file) => file.entries(),
            Self::SaveTo(_) | Self::Diff(_) => &[],
        };
        let line = |entry: &parameter_file::Entry| Line {
            request: entry.request(),
            number: Some(entry.line()),
        };
        entries.iter().map(line).collect()
    }

    /// The name of the file with commands.
    pub(super) fn name(&self) -> Option<&str> {
        match self {
            Self::Load(file) => Some(file.name()),
            Self::SaveTo(_) | Self::Diff(_) => None,
        }
    }

    /// Carries out the task with the robot's parameters; returns the commands to send.
    pub(super) fn follow(
        &self,
        options: &Send,
        robot: &[ParameterLine],
    ) -> Result<Vec<Line>, Fault> {
        let say = |text: String| {
            if options.quiet || options.json {
                Ok(())
            } else {
                show_line(text)
            }
        };
        match self {
            Self::SaveTo(path) => {
                let text = parameter_file::write("The robot's parameters.", robot);
                files::write_text(path, &text, options.force).map_err(|problem| match problem {
                    SaveProblem::Exists => usage(format!(
                        "{path} exists; choose another name, or use --force to overwrite it"
                    )),
                    SaveProblem::Failed(error) => Fault::new(Exit::Failed, error),
                })?;
                say(format!(
                    "saved {} to {path}",
                    counted(robot.len() as u64, "parameter")
                ))?;
                Ok(Vec::new())
            }
            Self::Load(file) => {
                let differences = file.differences(robot).map_err(usage)?;
                let count = file.entries().len();
                say(format!(
                    "{} of {count} parameters differ",
                    differences.len()
                ))?;
                let line = |difference: &parameter_file::Difference| Line {
                    request: difference.entry.request(),
                    number: Some(difference.entry.line()),
                };
                Ok(differences.iter().map(line).collect())
            }
            Self::Diff(file) => {
                let differences = file.differences(robot).map_err(usage)?;
                for difference in &differences {
                    if options.json {
                        show_line(json!({
                            "name": difference.robot.name.as_str(),
                            "file": difference.wanted,
                            "robot": difference.robot.value,
                            "unit": difference.robot.unit.as_str(),
                        }))?;
                    } else {
                        show_line(difference)?;
                    }
                }
                let differ = match differences.len() {
                    0 => {
                        say(format!("the robot has the values of {}", file.name()))?;
                        return Ok(Vec::new());
                    }
                    1 => "1 parameter differs".to_owned(),
                    many => format!("{many} parameters differ"),
                };
                Err(Fault::new(
                    Exit::Failed,
                    format!("{differ} from {}", file.name()),
                ))
            }
        }
    }
}

fn read(file: &str) -> Result<ParameterFile, Fault> {
    let text = read_text(Path::new(file))?;
    ParameterFile::parse(file, &text).map_err(usage)
}
