//! The robot's EEPROM as a file of `NAME=VALUE` lines: the boot counter and the parameters that differ from their
//! defaults.

use std::fmt::Write as _;
use std::fs;
use std::io;
use std::path::PathBuf;

use sr04_firmware::parameters::{Parameter, Parameters};

use super::error::ServeError;
use crate::library::read_text;

/// The file and its contents.
#[derive(Debug)]
pub(super) struct Eeprom {
    path: PathBuf,
    boots: u16,
    parameters: Parameters,
}

impl Eeprom {
    /// Reads the file; without one the robot has never booted and has default parameters.
    pub(super) fn open(path: PathBuf) -> Result<Self, ServeError> {
        let (boots, parameters) = match read_text(&path) {
            Ok(text) => parse(&text).map_err(|problem| fail(&path, problem))?,
            Err(error) if error.kind() == io::ErrorKind::NotFound => (0, Parameters::DEFAULT),
            Err(error) => return Err(fail(&path, error.to_string())),
        };
        Ok(Self {
            path,
            boots,
            parameters,
        })
    }

    /// The kept parameters.
    pub(super) const fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// Increments, stores and returns the boot counter.
    pub(super) fn count_boot(&mut self) -> Result<u16, ServeError> {
        self.boots = self.boots.wrapping_add(1);
        self.store()
            .map_err(|error| fail(&self.path, error.to_string()))?;
        Ok(self.boots)
    }

    /// Stores the parameters if they have changed. Returns an error of the file, because the robot cannot detect a failed
    /// memory.
    pub(super) fn keep(&mut self, parameters: &Parameters) -> Option<ServeError> {
        if self.parameters == *parameters {
            return None;
        }
        self.parameters.clone_from(parameters);
        let source = self.store().err()?;
        Some(ServeError::Incomplete {
            kind: "copy of the parameters",
            path: self.path.clone(),
            source,
        })
    }

    /// Writes the file and renames it into place, so that a crash leaves the old or the new contents.
    fn store(&self) -> io::Result<()> {
        let mut partial = self.path.as_os_str().to_owned();
        partial.push(".partial");
        fs::write(&partial, self.to_text())?;
        fs::rename(&partial, &self.path)
    }

    fn to_text(&self) -> String {
        let mut text = format!("boots={}\n", self.boots);
        for &parameter in Parameter::ALL {
            let (definition, value) = (parameter.definition(), self.parameters.get(parameter));
            if value != definition.default {
                let _ = writeln!(text, "{}={value}", definition.name);
            }
        }
        text
    }
}

fn fail(path: &std::path::Path, problem: String) -> ServeError {
    ServeError::Eeprom {
        path: path.to_owned(),
        problem,
    }
}

/// The boot counter and the parameters; parameters missing from the text keep their defaults.
fn parse(text: &str) -> Result<(u16, Parameters), String> {
    let mut boots = None;
    let mut parameters = Parameters::DEFAULT;
    for (n, line) in (1..).zip(text.lines()) {
        let (name, value) = line.split_once('=').unwrap_or((line, ""));
        let is_taken = match (name, Parameter::with_name(name)) {
            ("boots", _) => {
                boots = value.parse().ok();
                boots.is_some()
            }
            (_, Some(parameter)) => value
                .parse()
                .is_ok_and(|value| parameters.set(parameter, value)),
            (_, None) => false,
        };
        if !is_taken {
            return Err(format!(
                "line {n} is neither `boots=NUMBER` nor a parameter with a valid value: correct it, or delete the \
                 file to start from 1"
            ));
        }
    }
    let boots = boots
        .ok_or("the line `boots=NUMBER` is missing: add it, or delete the file to start from 1")?;
    Ok((boots, parameters))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_with_boots_only_has_default_parameters() {
        assert_eq!(parse("boots=41\n"), Ok((41, Parameters::DEFAULT)));
    }

    #[test]
    fn invalid_lines_are_refused_by_number() {
        for (text, says) in [
            ("", "is missing"),
            ("top-speed=8\n", "is missing"),
            ("boots=x\n", "line 1"),
            ("boots=65536\n", "line 1"),
            ("boots=1\ntop-speed=13\n", "line 2"),
            ("boots=1\n\n", "line 2"),
            ("boots=1\nwarp-speed=9\n", "line 2"),
            ("dear diary", "line 1"),
        ] {
            let problem = parse(text).expect_err(text);
            assert!(problem.contains(says), "{text:?}: {problem}");
        }
    }

    /// Contents that are read, stored and read again are equal.
    #[test]
    fn fuzz_eeprom() {
        bolero::check!()
            .with_type::<(u16, Vec<(u8, i8)>, Vec<u8>)>()
            .for_each(|(boots, values, other)| {
                let mut text = format!("boots={boots}\n");
                for &(n, value) in values {
                    let parameter = Parameter::ALL[usize::from(n) % Parameter::ALL.len()];
                    let _ = writeln!(text, "{}={value}", parameter.definition().name);
                }
                for text in [text.clone(), text + &String::from_utf8_lossy(other)] {
                    let Ok((boots, parameters)) = parse(&text) else {
                        continue;
                    };
                    let eeprom = Eeprom {
                        path: PathBuf::new(),
                        boots,
                        parameters,
                    };
                    assert_eq!(parse(&eeprom.to_text()), Ok((boots, eeprom.parameters)));
                }
            });
    }
}
