//! The marks of a recording and those that the operator sets and removes during a replay.

use crate::event::{Level, Moment};
use crate::playback::control::{MARK_REACH, MARKS_MAX, clock_words};

/// Marks in order, and their texts.
#[derive(Clone, Debug, Default)]
pub(super) struct Marks {
    /// Marks that are shown, in order.
    shown: Vec<Moment>,
    /// Marks of the capture.
    recorded: Vec<Moment>,
    /// Marks that the operator removed; those of the capture may be read later.
    removed: Vec<Moment>,
    /// Texts of marks.
    texts: Vec<(Moment, String)>,
    /// Time of the mark last set (`true`) or removed (`false`).
    changed: Option<(Moment, bool)>,
}

/// Whether two moments are one mark.
fn is_same(one: Moment, other: Moment) -> bool {
    one.abs_diff(other) < MARK_REACH
}

impl Marks {
    /// Marks that are shown, in order.
    pub(super) fn shown(&self) -> &[Moment] {
        &self.shown
    }

    /// Forgets the marks before a moment.
    pub(super) fn begin_at(&mut self, from: Moment) {
        self.shown.retain(|mark| *mark >= from);
    }

    /// Sets the marks of the recording; the operator's marks are kept.
    pub(super) fn set_recorded(&mut self, marks: Vec<Moment>) {
        let before = std::mem::replace(&mut self.recorded, marks);
        let recorded = &self.recorded;
        self.shown
            .retain(|mark| !before.contains(mark) || recorded.contains(mark));
        let known = || self.shown.iter().chain(&self.removed);
        let is_new = |mark: &&Moment| {
            !before.contains(mark) && !known().any(|known| is_same(*known, **mark))
        };
        let fresh: Vec<Moment> = recorded.iter().filter(is_new).copied().collect();
        self.shown.extend(fresh);
        self.shown.sort_unstable();
        self.shown.dedup();
    }

    /// Adds the text of a mark, and the mark if there is none yet.
    pub(super) fn add_text(&mut self, at: Moment, text: String) {
        if !self.shown.iter().any(|mark| is_same(*mark, at)) && self.shown.len() < MARKS_MAX {
            self.insert(at);
        }
        self.texts.push((at, text));
    }

    /// Whether the capture itself has a mark at a moment.
    pub(super) fn is_recorded(&self, at: Moment) -> bool {
        self.recorded.iter().any(|mark| is_same(*mark, at))
    }

    /// The mark set (`true`) or removed (`false`) since the last call.
    pub(super) const fn take_changed(&mut self) -> Option<(Moment, bool)> {
        self.changed.take()
    }

    /// The nearest mark after or before a moment.
    pub(super) fn beside(&self, from: Moment, forward: bool) -> Option<Moment> {
        let mut marks = self.shown.iter().copied();
        if forward {
            marks.find(|mark| *mark > from)
        } else {
            marks.rfind(|mark| *mark < from)
        }
    }

    /// Texts of the mark at a moment; empty if it has none.
    pub(super) fn text_at(&self, at: Moment) -> String {
        let here = self.texts.iter().filter(|(mark, _)| is_same(*mark, at));
        let texts: Vec<&str> = here.map(|(_, text)| &**text).collect();
        texts.join("; ")
    }

    /// Removes the mark at a moment, or sets one; returns what happened.
    pub(super) fn toggle(&mut self, at: Moment) -> (Level, String) {
        let marked = clock_words(at);
        if let Some(place) = self.shown.iter().position(|mark| is_same(*mark, at)) {
            self.changed = Some((self.shown.remove(place), false));
            self.removed.push(at);
            let texts = self.text_at(at);
            self.texts.retain(|(mark, _)| !is_same(*mark, at));
            let text = match (self.is_recorded(at), &*texts) {
                (true, "") => format!(
                    "mark at {marked} hidden: the recording keeps it, a new replay shows it"
                ),
                (true, texts) => {
                    format!("text removed: {texts}; the recording keeps its mark at {marked}")
                }
                (false, "") => format!("mark at {marked} removed"),
                (false, texts) => format!("mark at {marked} removed: {texts}"),
            };
            return (Level::Info, text);
        }
        if self.shown.len() == MARKS_MAX {
            let text = format!(
                "there are {MARKS_MAX} marks already; <mark> and Enter on a mark removes it"
            );
            return (Level::Warning, text);
        }
        self.insert(at);
        self.removed.retain(|removed| !is_same(*removed, at));
        self.changed = Some((at, true));
        let (next, last) = ("<ask-jump-forward>", "<ask-jump-back>");
        let mark = "<jump/jump-to-marker>";
        let text = format!("marked {marked}; {next} {mark} and {last} {mark} go to marks");
        (Level::Info, text)
    }

    fn insert(&mut self, at: Moment) {
        let place = self.shown.partition_point(|mark| *mark < at);
        self.shown.insert(place, at);
    }
}
