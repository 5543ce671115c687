//! Completion of commands, for shells and for the dashboard's prompt.

use groundwave_protocol::status_codes::{Layer, Mode};

use super::{Request, Tuning, known_parameters, layer_word, mode_word, preset_names};

/// Extensions of route files.
pub const ROUTES: &[&str] = &["csv", "txt"];

/// Extensions of captures.
pub const CAPTURES: &[&str] = &["mcap", "txt", "raw", "log"];

/// A candidate of a completion.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Candidate {
    /// The whole word.
    pub text: String,
    /// Meaning of the word; may be empty.
    pub about: &'static str,
}

/// Possible completions of the beginning of a word.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Completion {
    /// One of these words.
    Words(Vec<Candidate>),
    /// The name of a file with one of these extensions.
    File(&'static [&'static str]),
}

impl Completion {
    /// No candidates.
    pub const NONE: Self = Self::Words(Vec::new());

    /// The `words` that begin with `current`.
    pub fn among<'a>(current: &str, words: impl IntoIterator<Item = &'a str>) -> Self {
        let words = words.into_iter().filter(|word| word.starts_with(current));
        let candidate = |word: &str| Candidate {
            text: word.to_owned(),
            about: "",
        };
        Self::Words(words.map(candidate).collect())
    }
}

/// Completes `current` after the words of a command to the robot. A robot with `own` command strings takes no other commands.
#[must_use]
pub fn of_command(before: &[&str], current: &str, own: &[String]) -> Completion {
    let modes = || Mode::ALL.iter().map(|mode| mode_word(*mode));
    let layers = || Layer::ALL.into_iter().map(layer_word);
    match before {
        [] if own.is_empty() => Completion::among(current, Request::commands()),
        [] => Completion::among(current, own.iter().map(String::as_str)),
        ["mode"] => Completion::among(current, modes()),
        ["enable" | "disable"] => after_comma(current, layers()),
        ["only"] => after_comma(current, layers().chain(["none"])),
        ["preset"] => Completion::among(current, preset_names()),
        ["failsafe"] => Completion::among(current, modes().chain(["off"])),
        ["route"] => Completion::File(ROUTES),
        ["param", rest @ ..] => of_param(rest, current),
        _ => Completion::NONE,
    }
}

/// Completes `current` after the words of a command about parameters.
#[must_use]
pub fn of_param(before: &[&str], current: &str) -> Completion {
    let names = || {
        let known = known_parameters().filter(|(name, _)| name.starts_with(current));
        known.map(|(name, about)| Candidate {
            text: name.to_owned(),
            about,
        })
    };
    match before {
        [] => {
            let Completion::Words(mut words) = Completion::among(current, Tuning::verbs()) else {
                return Completion::NONE;
            };
            words.extend(names());
            Completion::Words(words)
        }
        ["get" | "set"] => Completion::Words(names().collect()),
        [verb] if Tuning::FILE_VERBS.contains(verb) => Completion::File(&["toml"]),
        _ => Completion::NONE,
    }
}

/// Completes the last word of a list separated by commas.
pub fn after_comma<'a>(current: &str, words: impl IntoIterator<Item = &'a str>) -> Completion {
    let start = current.rfind(',').map_or(0, |comma| comma + 1);
    let (given, rest) = current.split_at(start);
    let is_new = |word: &str| !given.split(',').any(|known| known == word);
    let words = words
        .into_iter()
        .filter(|word| word.starts_with(rest) && is_new(word));
    let candidate = |word: &str| Candidate {
        text: format!("{given}{word}"),
        about: "",
    };
    Completion::Words(words.map(candidate).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn completed(words: &str) -> String {
        let mut words: Vec<&str> = words.split(' ').collect();
        let current = words.pop().unwrap();
        match of_command(&words, current, &[]) {
            Completion::Words(words) => {
                let words = words.iter().map(|word| &*word.text);
                words.collect::<Vec<_>>().join(" ")
            }
            Completion::File(_) => "FILE".to_owned(),
        }
    }

    #[test]
    fn words_complete_by_their_place() {
        for (typed, completed_to) in [
            ("pr", "prowl preset"),
            ("mode h", "home"),
            ("enable bu", "bumpers"),
            ("enable bumpers,so", "bumpers,sonar"),
            ("enable sonar,so", ""),
            ("only n", "none"),
            ("param get top", "top-speed"),
            ("param top", "top-speed"),
            ("param sa", "save save-to"),
            ("param load x", "FILE"),
            ("route a", "FILE"),
            ("goto 4", ""),
        ] {
            assert_eq!(completed(typed), completed_to, "{typed}");
        }
    }
}
