//! The palette: finds keys and commands by a few letters.

use nucleo_matcher::pattern::{AtomKind, CaseMatching, Normalization, Pattern};
use nucleo_matcher::{Config, Matcher};

use super::keys::RouteAction;
use super::keys::{Action, Context, Group};
use super::text_entry::TEXT_MAX;
use super::{Facts, Overlay, Panel, Purpose, TextEntry, Ui};
use crate::event::{Effect, Moment};
use crate::request::{
    Request, command_description, dashboard_commands, known_parameters, preset_names,
};

/// The search text and the choice.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Palette {
    pub(crate) text: String,
    /// Index of the chosen entry; `None` before the operator chooses.
    chosen: Option<usize>,
}

/// An action or command.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Entry {
    pub(crate) title: String,
    /// Key of the action.
    pub(crate) key: String,
    searched: String,
    pick: Pick,
}

#[derive(Clone, Debug, PartialEq)]
enum Pick {
    Action(Action),
    /// The words of a command, complete or not.
    Words(String),
}

impl AsRef<str> for Entry {
    fn as_ref(&self) -> &str {
        &self.searched
    }
}

impl Palette {
    /// The matching entries, best first; matches at word starts come before all others. An empty text matches every entry.
    pub(crate) fn found(&self, ui: &Ui, facts: &Facts) -> Vec<Entry> {
        let mut matcher = Matcher::new(Config::DEFAULT);
        let mut matching = |kind| {
            let (case, marks) = (CaseMatching::Ignore, Normalization::Smart);
            Pattern::new(&self.text, case, marks, kind).match_list(entries(ui, facts), &mut matcher)
        };
        // Scattered letters match almost everything, so they count only if no entry contains the typed words.
        let mut found = matching(AtomKind::Substring);
        if found.is_empty() {
            found = matching(AtomKind::Fuzzy);
        }
        let mut found: Vec<Entry> = found.into_iter().map(|(entry, _)| entry).collect();
        // Its own name tells more than its description.
        let name = |entry: &Entry| {
            entry
                .title
                .split(": ")
                .next()
                .unwrap_or_default()
                .to_owned()
        };
        found.sort_by_cached_key(|entry| {
            let is_of = |text: &str| !self.begins(text);
            (is_of(&entry.searched), is_of(&name(entry)))
        });
        found
    }

    /// Whether each typed word begins a word of a text.
    fn begins(&self, text: &str) -> bool {
        let searched = text.to_lowercase();
        let is_begun = |typed: &str| {
            let mut places = searched.match_indices(typed);
            places.any(|(at, _)| !searched[..at].ends_with(char::is_alphanumeric))
        };
        self.text.to_lowercase().split_whitespace().all(is_begun)
    }

    /// Index of the chosen match; by default the best one, unless only scattered letters match.
    pub(crate) fn chosen(&self, found: &[Entry]) -> Option<usize> {
        let best = found
            .first()
            .filter(|entry| self.begins(&entry.searched))
            .map(|_| 0);
        let last = found.len().checked_sub(1)?;
        self.chosen.map(|place| place.min(last)).or(best)
    }

    pub(super) fn choose(&mut self, found: &[Entry], steps: i8) {
        let place = self.chosen(found);
        let place = place.map_or(0, |place| place.saturating_add_signed(steps.into()));
        self.chosen = found.len().checked_sub(1).map(|last| place.min(last));
    }

    /// Appends text, and chooses the best match again.
    pub(super) fn append(&mut self, text: &str) {
        let room = TEXT_MAX.saturating_sub(self.text.len());
        let printable = text.chars().filter(|c| !c.is_control());
        self.text.extend(printable.take(room));
        self.chosen = None;
    }

    /// Erases characters at the end.
    pub(super) fn erase(&mut self, characters: usize) {
        let count = self.text.chars().count().saturating_sub(characters);
        self.text = self.text.chars().take(count).collect();
        self.chosen = None;
    }
}

/// The robot's command strings, keys of the dashboard and the route editor, then commands: those that work on this link.
fn entries(ui: &Ui, facts: &Facts) -> Vec<Entry> {
    let keymap = &ui.config.keys;
    let own = ui.config.own_commands.iter().map(|name| Entry {
        title: format!(":{name}"),
        key: String::new(),
        searched: name.clone(),
        pick: Pick::Words(name.clone()),
    });
    let keys = keymap.rows().filter(|row| ui.offers(facts, row.action));
    let keys = keys.filter(|row| match row.action {
        Action::AskPalette | Action::Route(RouteAction::Leave) => false,
        Action::Route(_) => true,
        _ => {
            matches!(row.context, Context::Dashboard | Context::Modes)
        }
    });
    let keys = keys.map(|row| {
        let does = keymap.with_keys(&row.does());
        let title = match (row.context, row.action.group()) {
            (Context::Dashboard, Group::Route) => format!("draft: {does}"),
            (_, group @ (Group::Route | Group::Map | Group::Time)) => {
                format!("{}: {does}", group.name())
            }
            (_, Group::Robot | Group::Panels | Group::Program) => does,
        };
        Entry {
            searched: format!(
                "{title} {} {}",
                row.name.replace('-', " "),
                search_words(row.action)
            ),
            key: row.key_names(),
            pick: Pick::Action(row.action),
            title,
        }
    });
    let presets = preset_names().map(|name| format!("preset {name}"));
    let sends = !facts.link.is_receive_only();
    let commands = Request::commands().map(str::to_owned).chain(presets);
    let commands = commands
        .filter(|_| sends)
        .chain(dashboard_commands().map(str::to_owned));
    let commands = commands.map(|words| {
        let does = command_description(&words).map(|does| keymap.with_keys(does));
        let title = does.map_or_else(|| format!(":{words}"), |does| format!(":{words}: {does}"));
        Entry {
            key: String::new(),
            searched: title.clone(),
            pick: Pick::Words(words),
            title,
        }
    });
    let parameters = known_parameters()
        .filter(|_| sends)
        .map(|(name, about)| Entry {
            title: format!(":param {name}: {}", in_passing(about)),
            key: String::new(),
            searched: format!("param {} {about}", name.replace('-', " ")),
            pick: Pick::Words(format!("param {name}")),
        });
    own.chain(keys).chain(commands).chain(parameters).collect()
}

/// A sentence in the form used after a colon.
fn in_passing(sentence: &str) -> String {
    let mut letters = sentence.trim_end_matches('.').chars();
    let first = letters.next().map(|first| first.to_ascii_lowercase());
    first.into_iter().chain(letters).collect()
}

/// Search words for a panel besides its name.
const fn search_words(action: Action) -> &'static str {
    match action {
        Action::Show(Panel::Alarms) => "limits battery silence loss",
        Action::Show(Panel::Plots) => "battery voltage signal",
        Action::Show(Panel::Fields) => "values numbers csv json arduino",
        Action::Show(Panel::Link) => "loss statistics",
        _ => "",
    }
}

impl Ui {
    /// Carries out the choice; an incomplete command opens the prompt.
    pub(super) fn pick(&mut self, facts: &Facts, now: Moment, palette: &Palette) -> Vec<Effect> {
        let mut found = palette.found(self, facts);
        let chosen = palette.chosen(&found);
        // Without a choice the palette stays open; without matches it closes.
        if chosen.is_some() || found.is_empty() {
            self.overlay = Overlay::None;
        }
        let Some(chosen) = chosen else {
            return Vec::new();
        };
        match found.swap_remove(chosen).pick {
            Pick::Action(action) => {
                if matches!(action, Action::Route(_)) && self.editor.is_none() {
                    self.open_editor();
                }
                let effects = self.act(facts, now, action, false);
                self.ask_from_the_past(action, effects)
            }
            Pick::Words(words) => {
                let split: Vec<&str> = words.split(' ').collect();
                if let Ok(requests) = Request::all_from_words(&split) {
                    return requests
                        .into_iter()
                        .flat_map(|request| self.ask_or_send(request))
                        .collect();
                }
                // The operator types the missing words in the prompt.
                if let Ok(Some(effects)) = self.ask_for_runs(facts, &words) {
                    return effects;
                }
                self.overlay = Overlay::Text(TextEntry {
                    text: format!("{words} "),
                    ..TextEntry::new(Purpose::Command)
                });
                Vec::new()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::keys::Keymap;
    use crate::model::{Config as Configured, Model};

    fn found(palette: &Palette) -> Vec<Entry> {
        let model = Model::new(Configured::default());
        palette.found(&model.ui, &model.facts)
    }

    fn best(text: &str) -> Option<String> {
        let palette = Palette {
            text: text.to_owned(),
            chosen: None,
        };
        let mut found = found(&palette);
        (!found.is_empty()).then(|| found.swap_remove(0).title)
    }

    #[test]
    fn a_few_letters_are_enough() {
        for (text, title) in [
            ("go home", "home: back to the origin"),
            ("lysonar", "allow or forbid layer sonar"),
            ("moth", ":preset moth"),
            (
                "failsafe",
                ":failsafe: enter mode M after 30 s of silence; or off",
            ),
            ("runs", ":runs: list runs; Enter replays one"),
            ("replay", ":runs: list runs; Enter replays one"),
            ("truth", "map: the simulator's truth"),
            ("diameter", ":param wheel-left: diameter of the left wheel"),
        ] {
            assert_eq!(best(text).as_deref(), Some(title), "{text}");
        }
        assert_eq!(best("zzzz"), None);
    }

    #[test]
    fn scattered_letters_do_not_hide_better_matches() {
        let titles = |text: &str| {
            let palette = Palette {
                text: text.to_owned(),
                chosen: None,
            };
            let found = found(&palette);
            found
                .into_iter()
                .map(|entry| entry.title)
                .collect::<Vec<_>>()
        };
        let batt = titles("batt");
        let holds = |word: &str| batt.iter().any(|title| title.contains(word));
        assert!(
            holds("dock") && holds("alarms") && holds("plots"),
            "{batt:?}"
        );
        assert!(!holds("back to"), "{batt:?}");
        let route = titles("rout");
        assert!(
            !route.iter().any(|title| title.contains("leave")),
            "{route:?}"
        );
    }

    /// The operator could not distinguish two equal rows.
    #[test]
    fn palette_entries_have_distinct_titles() {
        let all = found(&Palette::default());
        for (n, entry) in all.iter().enumerate() {
            assert!(!entry.title.trim().is_empty(), "{entry:?}");
            let twin = all[n + 1..].iter().find(|other| other.title == entry.title);
            assert_eq!(twin, None);
        }
    }

    #[test]
    fn empty_search_lists_every_key_and_command() {
        let all = found(&Palette::default());
        let rows = Keymap::default();
        let of = |context| rows.rows().filter(move |row| row.context == context);
        for row in of(Context::Dashboard).chain(of(Context::Route)) {
            let is_it = |entry: &Entry| entry.pick == Pick::Action(row.action);
            let leads_nowhere = [Action::AskPalette, Action::Route(RouteAction::Leave)];
            assert_eq!(
                all.iter().any(is_it),
                !leads_nowhere.contains(&row.action),
                "{row:?}"
            );
        }
        for command in Request::commands() {
            assert!(
                all.iter()
                    .any(|entry| entry.pick == Pick::Words(command.to_owned())),
                "{command}"
            );
        }
    }

    #[test]
    fn the_choice_stays_within_what_is_found() {
        let mut palette = Palette::default();
        let all = found(&palette);
        palette.choose(&all[..3], -1);
        assert_eq!(palette.chosen(&all[..3]), Some(0));
        for _ in 0..5 {
            palette.choose(&all[..3], 1);
        }
        assert_eq!(palette.chosen(&all[..3]), Some(2));
        assert_eq!(palette.chosen(&all[..1]), Some(0));
        assert_eq!(palette.chosen(&[]), None);
        palette.choose(&[], 1);
        assert_eq!(palette.chosen(&all[..1]), Some(0));
    }
}
