//! The search of the log.

use super::log::Entry;
use super::{Facts, Large, Overlay, Panel, TextEntry, Ui};
use crate::event::Moment;

/// A search of the log: the text, and the entry found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Search {
    pub(crate) text: String,
    /// Number of the entry.
    pub(crate) at: u64,
}

impl Ui {
    /// The numbers of the entries with a text up to the moment shown, newest first.
    fn found(&self, facts: &Facts, text: &str) -> Vec<u64> {
        let until = self.playback.as_ref().filter(|playback| playback.is_live);
        let until = until.map_or(Moment::MAX, |playback| playback.at);
        let entries = facts.log.numbered();
        let found = entries.filter(|(_, entry)| entry.at <= until && entry.contains(text));
        found.map(|(number, _)| number).collect()
    }

    /// Selects the newest entry with the typed text.
    pub(super) fn submit_search(&mut self, facts: &Facts, entry: TextEntry) {
        let text = entry.text.trim().to_owned();
        self.overlay = match self.found(facts, &text).first() {
            Some(&at) => {
                self.panel = Panel::Log;
                self.enlarged = self.enlarged.map(|_| Large::Panel);
                Overlay::Search(Search { text, at })
            }
            None => Overlay::Text(TextEntry {
                error: Some(format!("no line of the log has `{text}`")),
                ..entry
            }),
        };
    }

    /// Selects an older or newer entry with the text; after the last comes the first.
    pub(super) fn find(&mut self, facts: &Facts, steps: i8) {
        let Overlay::Search(search) = &self.overlay else {
            return;
        };
        let found = self.found(facts, &search.text);
        let place = found.iter().position(|at| *at == search.at).unwrap_or(0);
        let next = (place as isize + isize::from(steps)).rem_euclid(found.len().max(1) as isize);
        let next = found.get(next as usize).copied();
        if let (Overlay::Search(search), Some(at)) = (&mut self.overlay, next) {
            search.at = at;
        }
    }
}

impl Entry {
    /// Whether the entry contains a text; ASCII letters match in either case.
    pub(crate) fn contains(&self, text: &str) -> bool {
        let text = text.to_ascii_lowercase();
        self.text.to_ascii_lowercase().contains(&text)
    }
}

#[cfg(test)]
mod tests {
    use crossterm::event::KeyCode;

    use super::*;
    use crate::event::Effect;
    use crate::model::Config;
    use crate::model::testing::{Scene, playback};

    fn scene() -> Scene {
        let mut scene = Scene::new(Config::default());
        for text in ["Lamp on", "door", "lamp off", "song"] {
            scene.hear_text(text);
        }
        scene
    }

    fn found(scene: &Scene) -> Option<String> {
        let Overlay::Search(search) = &scene.model.ui.overlay else {
            return None;
        };
        let mut entries = scene.model.facts.log.numbered();
        let (_, entry) = entries.find(|(number, _)| *number == search.at)?;
        Some(entry.text.clone())
    }

    fn search(scene: &mut Scene, text: &str) {
        scene.type_text("/");
        scene.type_text(text);
        scene.press(&[KeyCode::Enter]);
    }

    #[test]
    fn the_newest_match_comes_first_and_the_search_goes_round() {
        let mut scene = scene();
        search(&mut scene, "LAMP");
        let ends_with = |scene: &Scene, end: &str| {
            let text = found(scene);
            assert!(
                text.as_ref().is_some_and(|text| text.ends_with(end)),
                "{text:?}"
            );
        };
        assert_eq!(scene.model.ui.panel, Panel::Log);
        ends_with(&scene, "lamp off");
        scene.type_text("n");
        ends_with(&scene, "Lamp on");
        scene.type_text("n");
        ends_with(&scene, "lamp off");
        scene.type_text("N");
        ends_with(&scene, "Lamp on");
        scene.hear_text("another lamp");
        ends_with(&scene, "Lamp on");
        assert_eq!(scene.type_text("c"), [Effect::Copy("Lamp on".to_owned())]);
        scene.press(&[KeyCode::Esc]);
        assert_eq!(scene.model.ui.overlay, Overlay::None);
    }

    #[test]
    fn a_text_that_is_nowhere_can_be_mended() {
        let mut scene = scene();
        search(&mut scene, "lamb");
        let Overlay::Text(entry) = &scene.model.ui.overlay else {
            panic!("the prompt stays");
        };
        assert_eq!(
            entry.error.as_deref(),
            Some("no line of the log has `lamb`")
        );
        scene.press(&[KeyCode::Backspace]);
        scene.type_text("p");
        scene.press(&[KeyCode::Enter]);
        assert!(found(&scene).is_some());
    }

    #[test]
    fn the_past_is_searched_up_to_its_moment() {
        let mut scene = scene();
        scene.now = Moment::from_mins(2);
        scene.hear_text("lamp later");
        scene.show_moment(Some(playback(true)));
        search(&mut scene, "lamp");
        assert!(found(&scene).is_some_and(|text| text.ends_with("lamp off")));
    }
}
