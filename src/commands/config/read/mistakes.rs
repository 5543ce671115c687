//! What is wrong with a configuration: all of it at once, each where it stands.

use std::fmt;
use std::ops::Range;

use toml::Spanned;

use super::entries::{Entry, Takes};
use crate::suggest;

/// What is wrong with a configuration, and where.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mistake {
    /// From 1.
    pub line: usize,
    /// From 1, in characters.
    pub column: usize,
    /// What is wrong, and what would be right.
    pub message: String,
}

impl fmt::Display for Mistake {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}: {}", self.line, self.column, self.message)
    }
}

/// What was found so far in a text.
pub(super) struct Found<'a> {
    text: &'a str,
    mistakes: Vec<(usize, String)>,
}

impl<'a> Found<'a> {
    pub(super) const fn in_text(text: &'a str) -> Self {
        Self {
            text,
            mistakes: Vec::new(),
        }
    }

    /// A mistake at bytes of the text.
    pub(super) fn say(&mut self, at: &Range<usize>, message: impl Into<String>) {
        self.mistakes.push((at.start, message.into()));
    }

    /// How many there are so far.
    pub(super) const fn count(&self) -> usize {
        self.mistakes.len()
    }

    /// What the text is not even TOML for.
    pub(super) fn say_syntax(&mut self, error: &toml::de::Error) {
        let at = error.span().unwrap_or_default();
        self.say(&at, error.message());
    }

    /// A value that does not do for its key.
    pub(super) fn say_value(&mut self, entry: &Entry, at: &Range<usize>, error: &toml::de::Error) {
        let (key, takes) = entry;
        let got = self.text.get(at.clone()).unwrap_or_default();
        let own_words = error.message();
        let message = match takes {
            Takes::OneOf(words) => {
                let near = suggest::nearest(got.trim_matches('"'), words.iter().copied());
                let near = near.map_or(String::new(), |near| format!("; did you mean \"{near}\"?"));
                format!("`{key}` takes one of {}, not {got}{near}", quoted(words))
            }
            Takes::Value(what) if own_words.starts_with("invalid ") => {
                format!("`{key}` takes {what}, not {got}")
            }
            // A value of ours says itself what is wrong with it.
            Takes::Value(what) => format!("{own_words}; `{key}` takes {what}"),
        };
        self.say(at, message);
    }

    /// A key that is one of these.
    pub(super) fn known<'k>(
        &mut self,
        key: &'k Spanned<impl AsRef<str>>,
        all: &[&'static str],
        place: &str,
    ) -> Option<&'k str> {
        let word = key.get_ref().as_ref();
        if all.contains(&word) {
            return Some(word);
        }
        let near = suggest::question_or(
            word,
            all.iter().copied(),
            format_args!("there are {}", all.join(", ")),
        );
        self.say(&key.span(), format!("unknown key `{word}` {place}{near}"));
        None
    }

    /// What was found, in the order of the text.
    pub(super) fn mistakes(mut self) -> Vec<Mistake> {
        self.mistakes.sort();
        self.mistakes.dedup();
        let text = self.text;
        let placed = self.mistakes.into_iter().map(|(at, message)| {
            let before = text.get(..at.min(text.len())).unwrap_or_default();
            let line_start = before.rfind('\n').map_or(0, |end| end + 1);
            Mistake {
                line: before.matches('\n').count() + 1,
                column: before[line_start..].chars().count() + 1,
                message,
            }
        });
        placed.collect()
    }
}

fn quoted(words: &[&str]) -> String {
    let words: Vec<String> = words.iter().map(|word| format!("\"{word}\"")).collect();
    words.join(", ")
}
