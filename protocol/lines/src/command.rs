//! Command strings of the configuration: `[robot.NAME.commands]`.

use serde::{Deserialize, Serialize};

use crate::TEXT_CHARS_MAX;

/// A command as text in the robot's own format. `{x}` and other names in braces stand for the arguments, in the order in which they
/// first appear.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OwnCommand {
    /// The bytes to send.
    pub send: String,
    /// Beginning of the line with which the robot echoes the command.
    pub reply: String,
}

/// Reason why a command string cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CommandError {
    /// A text is empty or too long.
    #[error("{0} needs 1 to {TEXT_CHARS_MAX} characters")]
    Length(&'static str),
    /// A brace has no partner, or encloses no name.
    #[error("{0} has a brace that encloses no name; write {{x}} for an argument")]
    Brace(&'static str),
    /// The reply names an argument that is not sent.
    #[error("reply names {{{0}}}, which send does not")]
    Unsent(String),
    /// The number of arguments is wrong.
    #[error("takes {takes}; got {got}")]
    Arguments {
        /// Description of the expected arguments.
        takes: String,
        /// Number of given arguments.
        got: usize,
    },
    /// An argument contains a character that would end the line.
    #[error("argument {0:?} has a control character")]
    Control(String),
}

impl OwnCommand {
    /// Checks the command.
    ///
    /// # Errors
    /// The first mistake.
    pub fn check(&self) -> Result<(), CommandError> {
        for (what, text) in [("send", &self.send), ("reply", &self.reply)] {
            if text.trim().is_empty() || text.chars().count() > TEXT_CHARS_MAX {
                return Err(CommandError::Length(what));
            }
            parts(text).map_err(|()| CommandError::Brace(what))?;
        }
        let sent = self.arguments();
        let unsent = names(&self.reply)
            .into_iter()
            .find(|name| !sent.contains(name));
        unsent.map_or(Ok(()), |name| Err(CommandError::Unsent(name.to_owned())))
    }

    /// Beginning of the reply, whatever the arguments; empty if it begins with one.
    #[must_use]
    pub fn reply_start(&self) -> &str {
        match self.reply.split_once('{') {
            Some((start, _)) => start.trim_start(),
            None => self.reply.trim(),
        }
    }

    /// Names of the arguments.
    #[must_use]
    pub fn arguments(&self) -> Vec<&str> {
        names(&self.send)
    }

    /// The bytes to send and the beginning of the reply, with these arguments.
    ///
    /// # Errors
    /// If the number of arguments is wrong, or one contains a control character.
    pub fn with(&self, arguments: &[&str]) -> Result<(Vec<u8>, String), CommandError> {
        let names = self.arguments();
        if names.len() != arguments.len() {
            let takes = match &names[..] {
                [] => "nothing".to_owned(),
                names => names.join(" "),
            };
            let got = arguments.len();
            return Err(CommandError::Arguments { takes, got });
        }
        if let Some(bad) = arguments
            .iter()
            .find(|text| text.contains(char::is_control))
        {
            return Err(CommandError::Control((*bad).to_owned()));
        }
        let fill = |text: &str| {
            let parts = parts(text).unwrap_or_default();
            let fill = |(literal, name): &(&str, Option<&str>)| {
                let at = names.iter().position(|known| Some(*known) == *name);
                let argument = at.and_then(|at| arguments.get(at)).copied();
                [literal, argument.unwrap_or_default()].concat()
            };
            parts.iter().map(fill).collect::<String>()
        };
        Ok((
            fill(&self.send).into_bytes(),
            fill(&self.reply).trim().to_owned(),
        ))
    }
}

/// The names in braces, each once.
fn names(text: &str) -> Vec<&str> {
    let mut names = Vec::new();
    for (_, name) in parts(text).unwrap_or_default() {
        names.extend(name.filter(|name| !names.contains(name)));
    }
    names
}

/// Splits a text after each name in braces.
fn parts(mut text: &str) -> Result<Vec<(&str, Option<&str>)>, ()> {
    let mut parts = Vec::new();
    while let Some((literal, rest)) = text.split_once('{') {
        let (name, rest) = rest.split_once('}').ok_or(())?;
        let is_name = !name.is_empty() && name.chars().all(|c| c.is_alphanumeric() || c == '_');
        if literal.contains('}') || !is_name {
            return Err(());
        }
        parts.push((literal, Some(name)));
        text = rest;
    }
    if text.contains('}') {
        return Err(());
    }
    parts.push((text, None));
    Ok(parts)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn command(send: &str, reply: &str) -> OwnCommand {
        OwnCommand {
            send: send.to_owned(),
            reply: reply.to_owned(),
        }
    }

    #[test]
    fn reply_begins_with_what_comes_before_its_arguments() {
        for (reply, start) in [(" OK S\r", "OK S"), ("B {x}", "B "), ("{x} OK", "")] {
            assert_eq!(command("S", reply).reply_start(), start);
        }
    }

    #[test]
    fn arguments_fill_the_braces() {
        let goto = command("G {x} {y} {x}\n", "OK G {y}\r");
        assert_eq!(goto.check(), Ok(()));
        assert_eq!(goto.arguments(), ["x", "y"]);
        assert_eq!(
            goto.with(&["48", "-3"]),
            Ok((b"G 48 -3 48\n".to_vec(), "OK G -3".to_owned()))
        );
        let error = goto.with(&["48"]).map_err(|error| error.to_string());
        assert_eq!(error, Err("takes x y; got 1".to_owned()));
        assert!(goto.with(&["1\n", "2"]).is_err());
        let stop = command("S\n", "OK S");
        assert_eq!(stop.with(&[]), Ok((b"S\n".to_vec(), "OK S".to_owned())));
    }

    #[test]
    fn mistakes_are_named() {
        for (send, reply, expected) in [
            ("", "OK", "send needs 1"),
            ("S", "", "reply needs 1"),
            ("G {x", "OK", "send has a brace"),
            ("G {}", "OK", "send has a brace"),
            ("G x}", "OK", "send has a brace"),
            ("G {x}", "OK {y}", "reply names {y}"),
        ] {
            let error = command(send, reply).check().expect_err(send).to_string();
            assert!(error.contains(expected), "{error}");
        }
    }
}
