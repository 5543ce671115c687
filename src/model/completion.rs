//! Completion of the word before the caret of a prompt.

use groundwave_captures::messages::Telemetry;

use super::{Facts, Overlay, Purpose, TextEntry, Ui};
use crate::event::Effect;
use crate::request::completion::{CAPTURES, Candidate, Completion, ROUTES, of_command};
use crate::request::dashboard_commands;
use crate::wait::field_named;

impl Ui {
    /// Completes the word before the caret as far as it is unambiguous, and shows the candidates.
    pub(super) fn complete(&mut self, facts: &Facts) -> Vec<Effect> {
        let Overlay::Text(entry) = &self.overlay else {
            return Vec::new();
        };
        let (typed, _) = entry.parts();
        let (before, current) = match entry.purpose {
            Purpose::Command => typed.rsplit_once(' ').unwrap_or(("", typed)),
            Purpose::RouteFile | Purpose::SaveRoute => {
                return vec![Effect::ListFiles {
                    beginning: typed.to_owned(),
                    extensions: ROUTES,
                }];
            }
            Purpose::Moment | Purpose::Search | Purpose::Mark => return Vec::new(),
        };
        let before: Vec<&str> = before.split_whitespace().collect();
        match self.candidates(facts, &before, current) {
            Completion::File(extensions) => {
                return vec![Effect::ListFiles {
                    beginning: current.to_owned(),
                    extensions,
                }];
            }
            Completion::Words(words) => {
                let current = current.to_owned();
                self.take_candidates(&current, words);
            }
        }
        Vec::new()
    }

    fn candidates(&self, facts: &Facts, before: &[&str], current: &str) -> Completion {
        match before {
            [] => {
                let robots = of_command(before, current, &self.config.own_commands);
                let own = Completion::among(current, dashboard_commands());
                match (robots, own) {
                    (Completion::Words(robots), Completion::Words(own)) => {
                        Completion::Words(robots.into_iter().chain(own).collect())
                    }
                    (robots, _) => robots,
                }
            }
            ["wait"] => Completion::among(current, ["until"]),
            ["wait", "until"] | ["expect"] => {
                let fields = Telemetry::FIELDS.iter().map(|field| field.name);
                Completion::among(current, ["driven", "stopped"].into_iter().chain(fields))
            }
            ["wait", "until", name] | ["expect", name] => {
                let words = field_named(name).map_or(&[][..], |field| field.words);
                Completion::among(current, words.iter().copied())
            }
            ["wait", "until", ..] => Completion::among(current, ["within"]),
            ["plan"] => Completion::among(current, ["home"]),
            ["acknowledge" | "shelve" | "unshelve"] => {
                let alarms = facts.alarms.all(&self.attended);
                let codes: Vec<_> = alarms.map(|shown| shown.rule.code.clone()).collect();
                Completion::among(current, codes.iter().map(|code| &**code))
            }
            ["runs"] => Completion::File(&[]),
            ["compare", ..] => Completion::File(CAPTURES),
            _ => of_command(before, current, &self.config.own_commands),
        }
    }

    /// Takes the files that begin with a text, unless the operator has typed another text meanwhile.
    pub(super) fn take_files(&mut self, beginning: &str, files: Vec<String>) -> bool {
        let candidate = |text| Candidate { text, about: "" };
        self.take_candidates(beginning, files.into_iter().map(candidate).collect());
        true
    }

    fn take_candidates(&mut self, current: &str, candidates: Vec<Candidate>) {
        if let Overlay::Text(entry) = &mut self.overlay
            && entry.parts().0.ends_with(current)
        {
            entry.take_candidates(current, candidates);
        }
    }
}

impl TextEntry {
    fn take_candidates(&mut self, current: &str, candidates: Vec<Candidate>) {
        let mut words = candidates.iter().map(|candidate| &*candidate.text);
        let Some(first) = words.next() else {
            return;
        };
        let common = words.fold(first, common_beginning);
        let mut rest = common.strip_prefix(current).unwrap_or_default().to_owned();
        if candidates.len() == 1 && !common.ends_with('/') {
            rest.push(' ');
        }
        self.insert(&rest);
        self.candidates = candidates;
    }
}

fn common_beginning<'a>(a: &'a str, b: &str) -> &'a str {
    let differs = a.char_indices().zip(b.chars()).find(|((_, a), b)| a != b);
    let end = differs.map_or(a.len().min(b.len()), |((at, _), _)| at);
    &a[..end]
}

#[cfg(test)]
mod tests {
    use crossterm::event::KeyCode;

    use super::*;
    use crate::event::Event;
    use crate::model::Config;
    use crate::model::testing::Scene;

    fn prompt(scene: &Scene) -> &TextEntry {
        let Overlay::Text(entry) = &scene.model.ui.overlay else {
            panic!("no prompt");
        };
        entry
    }

    /// The text of the prompt and the candidates after a tab.
    fn completed(typed: &str) -> (String, String) {
        let mut scene = Scene::new(Config::default());
        scene.type_text(":");
        scene.type_text(typed);
        assert_eq!(scene.press(&[KeyCode::Tab]), []);
        let entry = prompt(&scene);
        let shown = entry.candidates.iter().map(|candidate| &*candidate.text);
        (entry.text.clone(), shown.collect::<Vec<_>>().join(" "))
    }

    #[test]
    fn tab_completes_commands_layers_parameters_alarms_and_conditions() {
        for (typed, text, shown) in [
            ("mode h", "mode home ", "home"),
            ("pre", "preset ", "preset"),
            (
                "disable bumpers,so",
                "disable bumpers,sonar ",
                "bumpers,sonar",
            ),
            (
                "param get battery-",
                "param get battery-",
                "battery-low battery-critical",
            ),
            ("wai", "wait ", "wait"),
            ("wait until stop", "wait until stopped ", "stopped"),
            ("expect mode go", "expect mode go_home ", "go_home"),
            ("shelve rob", "shelve robot_silent ", "robot_silent"),
            ("ack", "acknowledge ", "acknowledge"),
            ("plan h", "plan home ", "home"),
            ("goto 4", "goto 4", ""),
        ] {
            let (completed, candidates) = completed(typed);
            assert_eq!((&*completed, &*candidates), (text, shown), "{typed}");
        }
    }

    #[test]
    fn tab_completes_files_unless_the_text_changed_meanwhile() {
        let mut scene = Scene::new(Config::default());
        scene.type_text(":route ru");
        let asked = scene.press(&[KeyCode::Tab]);
        let list = Effect::ListFiles {
            beginning: "ru".to_owned(),
            extensions: ROUTES,
        };
        assert_eq!(asked, [list]);
        let files = |files: &[&str]| Event::Files {
            beginning: "ru".to_owned(),
            files: files.iter().map(|&file| file.to_owned()).collect(),
        };
        scene.event(files(&["run-1.txt", "run-2.txt"]));
        assert_eq!(prompt(&scene).text, "route run-");
        scene.event(files(&["rust/"]));
        assert_eq!(prompt(&scene).text, "route run-");
    }

    #[test]
    fn typing_on_clears_what_may_follow() {
        let mut scene = Scene::new(Config::default());
        scene.type_text(":pr");
        scene.press(&[KeyCode::Tab]);
        assert_eq!(prompt(&scene).candidates.len(), 2);
        scene.type_text("o");
        assert_eq!(prompt(&scene).candidates, []);
    }
}
