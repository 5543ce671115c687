//! The marks of a capture: those that the operator set and did not remove, and those with a text in the label.

use serde::Serialize;

use crate::event::{Mark, Moment};
use crate::runs::Label;

/// Maximum number of marks.
pub const MARKS_MAX: usize = 32;

/// Maximum distance of two marks that count as one.
pub const MARK_REACH: Moment = Moment::from_millis(250);

/// Marks set during a recording, in order.
#[derive(Clone, Debug, Default)]
pub struct Marks(Vec<Moment>);

impl Marks {
    /// Takes a mark recorded at a moment. A mark before the beginning belongs to another file.
    pub fn take(&mut self, now: Moment, mark: Mark) {
        let Some(at) = now.checked_sub(mark.ago) else {
            return;
        };
        if mark.is_set && self.0.len() < MARKS_MAX {
            let place = self.0.partition_point(|marked| *marked < at);
            self.0.insert(place, at);
        } else if !mark.is_set {
            self.0.retain(|marked| marked.abs_diff(at) >= MARK_REACH);
        }
    }

    /// The marked moments.
    #[must_use]
    pub fn moments(&self) -> &[Moment] {
        &self.0
    }
}

/// A mark and its text.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MarkWithText {
    /// Time since the capture began, seconds.
    pub at_s: f64,
    /// Text of the mark, if it has one.
    pub text: Option<String>,
}

impl From<Moment> for MarkWithText {
    fn from(at: Moment) -> Self {
        Self {
            at_s: at.as_secs_f64(),
            text: None,
        }
    }
}

/// The marks of a recording and those of its label, in order.
pub(crate) fn with_texts(mut marks: Vec<MarkWithText>, label: &Label) -> Vec<MarkWithText> {
    let texts = label.notes.iter().filter_map(|note| {
        Some(MarkWithText {
            at_s: note.at_s?,
            text: Some(note.text.clone()),
        })
    });
    let texts: Vec<_> = texts.collect();
    let reach_s = MARK_REACH.as_secs_f64();
    marks.retain(|mark| (texts.iter()).all(|known| (known.at_s - mark.at_s).abs() >= reach_s));
    marks.extend(texts);
    marks.sort_by(|a, b| a.at_s.total_cmp(&b.at_s));
    marks
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::runs::label::Note;

    fn set(ago_ms: u64) -> Mark {
        Mark {
            ago: Moment::from_millis(ago_ms),
            is_set: true,
        }
    }

    #[test]
    fn marks_are_set_and_removed() {
        let s = Moment::from_secs;
        let mut marks = Marks::default();
        marks.take(s(30), set(0));
        marks.take(s(40), set(20_000));
        assert_eq!(marks.moments(), [s(20), s(30)]);
        marks.take(s(1), set(2000));
        assert_eq!(marks.moments(), [s(20), s(30)], "before the beginning");
        let cleared = Mark {
            is_set: false,
            ..set(10_200)
        };
        marks.take(s(40), cleared);
        assert_eq!(marks.moments(), [s(20)], "within reach");
        for second in 0..100 {
            marks.take(s(100 + second), set(0));
        }
        assert_eq!(marks.moments().len(), MARKS_MAX);
    }

    #[test]
    fn a_mark_and_its_text_are_one() {
        let marks = [20, 40].map(|s| MarkWithText::from(Moment::from_secs(s)));
        let note = |at_s, text: &str| Note {
            at_s,
            text: text.to_owned(),
        };
        let label = Label {
            notes: vec![
                note(Some(60.0), "stairs"),
                note(None, "new tyres"),
                note(Some(20.1), "lamp fell"),
            ],
            ..Label::default()
        };
        let mark = |at_s, text: Option<&str>| MarkWithText {
            at_s,
            text: text.map(str::to_owned),
        };
        assert_eq!(
            with_texts(marks.to_vec(), &label),
            [
                mark(20.1, Some("lamp fell")),
                mark(40.0, None),
                mark(60.0, Some("stairs")),
            ]
        );
    }
}
