//! The text of a prompt, and its history.

use std::collections::VecDeque;

use crate::request::completion::Candidate;

/// Maximum length of a line that is typed or pasted, bytes.
pub(super) const TEXT_MAX: usize = 512;

/// Maximum number of lines in the history.
const TYPED_MAX: usize = 64;

/// The purpose of a prompt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Purpose {
    Command,
    RouteFile,
    SaveRoute,
    /// A position in time.
    Moment,
    /// A text in the log.
    Search,
    /// A text for a new mark.
    Mark,
}

/// A prompt.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct TextEntry {
    pub(crate) purpose: Purpose,
    pub(crate) text: String,
    /// Number of characters after the caret.
    pub(super) behind: usize,
    /// Reason why the submitted text was refused.
    pub(crate) error: Option<String>,
    /// Candidates found by completion.
    pub(crate) candidates: Vec<Candidate>,
    /// Whether the named file is being read or written.
    pub(crate) waits: bool,
    /// Position in the history; 0 for a new line.
    pub(super) ago: usize,
    /// The new line, while a line of the history is shown.
    pub(super) unsent: String,
}

/// A movement of the caret.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Caret {
    Left,
    Right,
    Start,
    End,
}

impl TextEntry {
    pub(super) const fn new(purpose: Purpose) -> Self {
        Self {
            purpose,
            text: String::new(),
            behind: 0,
            error: None,
            candidates: Vec::new(),
            waits: false,
            ago: 0,
            unsent: String::new(),
        }
    }
    /// Clears error and candidates of the previous text.
    fn changed(&mut self) {
        self.error = None;
        self.candidates.clear();
        self.waits = false;
    }

    /// Position of the caret, bytes.
    fn at(&self) -> usize {
        let mut ends = self.text.char_indices().rev().map(|(at, _)| at);
        match self.behind.checked_sub(1) {
            Some(behind) => ends.nth(behind).unwrap_or(0),
            None => self.text.len(),
        }
    }

    /// The text before and after the caret.
    pub(crate) fn parts(&self) -> (&str, &str) {
        self.text.split_at(self.at())
    }

    pub(super) fn insert(&mut self, text: &str) {
        let room = TEXT_MAX.saturating_sub(self.text.len());
        // A pasted tab separates words.
        let text = text.replace('\t', " ");
        let printable = text.chars().filter(|c| !c.is_control());
        let printable: String = printable.take(room).collect();
        self.text.insert_str(self.at(), &printable);
        self.changed();
    }

    /// Erases the character before the caret.
    pub(super) fn erase(&mut self) {
        let (before, _) = self.parts();
        if let Some((at, _)) = before.char_indices().next_back() {
            self.text.remove(at);
        }
        self.changed();
    }

    pub(super) fn clear(&mut self) {
        self.text.clear();
        self.behind = 0;
        self.changed();
    }

    pub(super) fn move_caret(&mut self, to: Caret) {
        let length = self.text.chars().count();
        self.behind = match to {
            Caret::Left => (self.behind + 1).min(length),
            Caret::Right => self.behind.saturating_sub(1),
            Caret::Start => length,
            Caret::End => 0,
        };
    }

    /// Shows an earlier or later line of the history; after the latest, the new line.
    pub(super) fn recall(&mut self, typed: &Typed, steps: i8) {
        let ago = self.ago.saturating_add_signed((-steps).into());
        let text = match ago.checked_sub(1) {
            None => Some(std::mem::take(&mut self.unsent)),
            Some(place) => typed.latest(self.purpose, place).map(str::to_owned),
        };
        let Some(text) = text.filter(|_| ago != self.ago) else {
            return;
        };
        let shown = std::mem::replace(&mut self.text, text);
        if self.ago == 0 {
            self.unsent = shown;
        }
        self.ago = ago;
        self.behind = 0;
        self.changed();
    }
}

/// Submitted lines, latest last.
#[derive(Clone, Debug, Default)]
pub(crate) struct Typed(VecDeque<(Purpose, String)>);

impl Typed {
    pub(super) fn keep(&mut self, purpose: Purpose, text: &str) {
        let line = (purpose, text.to_owned());
        self.0.retain(|known| *known != line);
        if self.0.len() == TYPED_MAX {
            self.0.pop_front();
        }
        self.0.push_back(line);
    }

    fn latest(&self, purpose: Purpose, place: usize) -> Option<&str> {
        let lines = self.0.iter().rev().filter(|(known, _)| *known == purpose);
        lines.map(|(_, text)| text.as_str()).nth(place)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn text_is_inserted_at_the_caret() {
        let mut entry = TextEntry::new(Purpose::Command);
        entry.insert("goto 48");
        entry.move_caret(Caret::Left);
        entry.insert("–");
        entry.move_caret(Caret::Start);
        entry.insert("x");
        entry.move_caret(Caret::Right);
        assert_eq!(entry.parts(), ("xg", "oto 4–8"));
        entry.erase();
        entry.erase();
        entry.erase();
        assert_eq!(entry.parts(), ("", "oto 4–8"));
        entry.move_caret(Caret::End);
        entry.erase();
        assert_eq!(entry.parts(), ("oto 4–", ""));
    }

    #[test]
    fn history_is_recalled_and_the_new_line_kept() {
        let mut typed = Typed::default();
        for (purpose, text) in [
            (Purpose::Command, "scan"),
            (Purpose::Moment, "12:30"),
            (Purpose::Command, "goto 48 0"),
            (Purpose::Command, "scan"),
        ] {
            typed.keep(purpose, text);
        }
        let mut entry = TextEntry::new(Purpose::Command);
        entry.insert("mo");
        let mut after = |steps| {
            entry.recall(&typed, steps);
            entry.text.clone()
        };
        assert_eq!(after(-1), "scan");
        assert_eq!(after(-1), "goto 48 0");
        assert_eq!(after(-1), "goto 48 0", "no line before");
        assert_eq!(after(1), "scan");
        assert_eq!(after(1), "mo");
        assert_eq!(after(1), "mo");
    }

    proptest! {
        #[test]
        fn the_caret_stays_in_the_text(steps in proptest::collection::vec(0..8, 0..200)) {
            let mut typed = Typed::default();
            typed.keep(Purpose::Command, "ä");
            let mut entry = TextEntry::new(Purpose::Command);
            for step in steps {
                match step {
                    0 => entry.insert("aß☃"),
                    1 => entry.erase(),
                    2 => entry.move_caret(Caret::Left),
                    3 => entry.move_caret(Caret::Right),
                    4 => entry.move_caret(Caret::Start),
                    5 => entry.recall(&typed, -1),
                    6 => entry.recall(&typed, 1),
                    _ => entry.clear(),
                }
                let (before, behind) = entry.parts();
                prop_assert_eq!(format!("{before}{behind}"), entry.text.clone());
            }
        }
    }
}
