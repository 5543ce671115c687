//! Commands about the robot's parameters.

use std::fmt;

use groundwave_protocol::parameter::{self, VALUE_MAX};
use groundwave_protocol::telemetry::ParameterName;

use super::commands::wrong;
use super::parameters::meant;
use super::{Amount, RequestError};
use crate::suggest::nearest;

/// A command about parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tuning {
    /// Report all parameters.
    List,
    /// Report one parameter.
    Get(ParameterName),
    /// Change one parameter, until the next reset.
    Set(ParameterName, Amount),
    /// Save all parameters permanently.
    Save,
}

impl Tuning {
    /// Subcommands of `param`; no parameter has these names.
    pub const VERBS: [&str; 4] = ["list", "get", "set", "save"];

    /// Subcommands with a parameter file.
    pub const FILE_VERBS: [&str; 3] = ["save-to", "load", "diff"];

    /// All subcommands.
    pub fn verbs() -> impl Iterator<Item = &'static str> {
        Self::VERBS.into_iter().chain(Self::FILE_VERBS)
    }

    /// Parses the words after `param`.
    pub(super) fn from_words(words: &[&str]) -> Result<Self, RequestError> {
        match *words {
            ["list"] => Ok(Self::List),
            ["save"] => Ok(Self::Save),
            ["get"] => Err(RequestError::ParameterMissing("get", "top-speed")),
            ["set"] => Err(RequestError::ParameterMissing("set", "top-speed 8")),
            ["get", name] => Ok(Self::Get(read_name(name)?)),
            ["set", name] => {
                read_name(name)?;
                Err(RequestError::ValueMissing(name.to_owned()))
            }
            ["set", name, value] => Ok(Self::Set(read_name(name)?, read_value(value)?)),
            // A word similar to a subcommand may still be the name of a parameter.
            [name, value]
                if verb_meant(name).is_none()
                    || (!Self::VERBS.contains(&name) && Amount::read(value).is_some()) =>
            {
                Ok(Self::Set(read_name(name)?, read_value(value)?))
            }
            [name] if verb_meant(name).is_none() => {
                read_name(name)?;
                Err(RequestError::ParameterAlone(name.to_owned()))
            }
            _ => Err(Self::wrong_words(words)),
        }
    }

    fn wrong_words(words: &[&str]) -> RequestError {
        let first = words.first().copied().unwrap_or_default();
        match verb_meant(first) {
            Some(verb) if verb != first => RequestError::ParameterVerb(first.to_owned(), verb),
            _ => wrong("param", words),
        }
    }
}

/// The subcommand equal or similar to a word.
fn verb_meant(word: &str) -> Option<&'static str> {
    nearest(word, Tuning::VERBS)
}

impl fmt::Display for Tuning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::List => f.write_str("param list"),
            Self::Get(name) => write!(f, "param get {}", Named(name)),
            Self::Set(name, value) => write!(f, "param set {} {value}", Named(name)),
            Self::Save => f.write_str("param save"),
        }
    }
}

/// Displays a parameter name in a form that parses to the same name.
struct Named<'a>(&'a ParameterName);

impl fmt::Display for Named<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = self.0.as_str();
        let insists = if meant(name).is_some() { "=" } else { "" };
        write!(f, "{insists}{name}")
    }
}

/// Parses a parameter name. `=` before the name passes on an unknown name, because the robot may know more parameters.
fn read_name(word: &str) -> Result<ParameterName, RequestError> {
    let name = word.strip_prefix('=').unwrap_or(word);
    if !parameter::is_name(name) {
        return Err(RequestError::ParameterName(name.to_owned()));
    }
    match meant(word) {
        Some(known) if word == name => Err(RequestError::ParameterUnknown(name.to_owned(), known)),
        _ => Ok(ParameterName::new(name)),
    }
}

fn read_value(word: &str) -> Result<Amount, RequestError> {
    let fits = |amount: &Amount| match amount {
        Amount::Counts(value) => value.abs() <= VALUE_MAX,
        // The limits depend on the unit, which the robot reports.
        Amount::Decimal { .. } => true,
    };
    Amount::read(word)
        .filter(fits)
        .ok_or_else(|| RequestError::ParameterValue(word.to_owned()))
}
