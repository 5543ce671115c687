//! The mistakes in a configuration, each with its place in the text.

use std::fmt;
use std::ops::Range;

use crate::suggest;

/// Maximum bytes of text that are read to find the mistakes, each of which takes another pass.
const PASSED_BYTES_MAX: usize = 4 << 20;

/// A mistake in a configuration.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mistake {
    /// Line of the text, from 1.
    pub line: usize,
    /// Column of the text in characters, from 1.
    pub column: usize,
    /// The mistake and how to correct it.
    pub message: String,
}

impl fmt::Display for Mistake {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}: {}", self.line, self.column, self.message)
    }
}

/// Collects the mistakes in a text.
pub(super) struct Mistakes<'a> {
    text: &'a str,
    found: Vec<(usize, String)>,
    /// Paths of the wrong entries.
    paths: Vec<Vec<String>>,
}

impl<'a> Mistakes<'a> {
    pub(super) const fn new(text: &'a str) -> Self {
        Self {
            text,
            found: Vec::new(),
            paths: Vec::new(),
        }
    }

    /// Adds a mistake at a range of bytes in the text.
    pub(super) fn add(&mut self, at: &Range<usize>, message: impl Into<String>) {
        self.found.push((at.start, message.into()));
    }

    /// Adds serde's `message` about the entry at a path.
    pub(super) fn add_value(
        &mut self,
        at: &Range<usize>,
        path: Option<&Vec<String>>,
        message: &str,
    ) {
        match path.and_then(|path| path.split_last()) {
            Some((key, section)) => self.add(at, reword(key, section, message)),
            None => self.add(at, message),
        }
        self.paths.extend(path.cloned());
    }

    /// Whether an entry of a section was wrong.
    pub(super) fn are_in(&self, section: &[&str]) -> bool {
        let is_in = |path: &Vec<String>| {
            path.len() > section.len() && path.iter().zip(section).all(|(name, of)| name == of)
        };
        self.paths.iter().any(is_in)
    }

    /// Number of mistakes so far.
    pub(super) const fn count(&self) -> usize {
        self.found.len()
    }

    /// The mistakes, in the order of the text.
    pub(super) fn into_sorted(mut self) -> Vec<Mistake> {
        self.found.sort();
        self.found.dedup();
        let (mut scanned, mut line, mut line_start) = (0, 1, 0);
        let placed = self.found.into_iter().map(|(at, message)| {
            let at = at.min(self.text.len());
            let passed = self.text.get(scanned..at).unwrap_or_default();
            line += passed.matches('\n').count();
            line_start = passed
                .rfind('\n')
                .map_or(line_start, |end| scanned + end + 1);
            scanned = at;
            let before = self.text.get(line_start..at).unwrap_or_default();
            Mistake {
                line,
                column: before.chars().count() + 1,
                message,
            }
        });
        placed.collect()
    }

    /// Whether another pass over the text would take too long.
    pub(super) const fn are_too_many(&self) -> bool {
        self.found.len().saturating_mul(self.text.len()) > PASSED_BYTES_MAX
    }
}

/// Serde's message with the name of the key, plain types and a suggestion.
fn reword(key: &str, section: &[String], message: &str) -> String {
    // Serde quotes the wrong word and then the known ones.
    let known = message.split('`').skip(3).step_by(2);
    if message.starts_with("unknown field") {
        let place = match section {
            [] => "at the top of the file".to_owned(),
            _ => format!("in [{}]", section.join(".")),
        };
        let all = known.clone().collect::<Vec<_>>().join(", ");
        let hint = suggest::question_or(key, known, format_args!("known: {all}"));
        return format!("unknown key `{key}` {place}{hint}");
    }
    if message.starts_with("unknown variant") {
        let wrong = message.split('`').nth(1).unwrap_or_default();
        let hint = suggest::question(wrong, known);
        return format!("`{key}`: {message}{hint}");
    }
    let plain = [
        ("expected struct ", "expected a section"),
        ("expected a map", "expected a section"),
        ("expected u8", "expected a whole number from 0 to 255"),
        ("expected u16", "expected a whole number from 0 to 65535"),
        ("expected u32", "expected a whole number, 0 or more"),
    ];
    let message = plain
        .into_iter()
        .find_map(|(from, to)| {
            let (before, after) = message.split_once(from)?;
            let is_whole = after.is_empty() || from.ends_with(' ');
            is_whole.then(|| format!("{before}{to}"))
        })
        .unwrap_or_else(|| message.to_owned());
    format!("`{key}`: {message}")
}
