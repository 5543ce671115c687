//! The screen that changes the robot's parameters.

use groundwave_captures::words::counted;

use super::keys::Action;
use super::ui::Then;
use super::words::parameter_number;
use super::{Facts, Overlay, Purpose, TextEntry, Ui};
use crate::event::{Effect, FileKind, Level, unquoted};
use crate::parameter_file::{self, ParameterFile};
use crate::request::{Request, Tuning, known_default};

impl Ui {
    /// Opens the screen of parameters; requests them from the robot unless all are known.
    pub(super) fn open_parameters(&mut self, facts: &Facts) -> Vec<Effect> {
        self.overlay = Overlay::None;
        self.parameters = Some(0);
        if facts.parameters.is_partial() && !self.is_replay() {
            return vec![Effect::Send(Request::Parameter(Tuning::List))];
        }
        Vec::new()
    }

    /// Carries out a key on the screen of parameters.
    pub(super) fn act_on_parameters(&mut self, facts: &Facts, action: Action) -> Vec<Effect> {
        let Some(chosen) = &mut self.parameters else {
            return Vec::new();
        };
        let heard = facts.parameters.heard();
        *chosen = (*chosen).min(heard.len().saturating_sub(1));
        let line = heard.get(*chosen);
        let value = match action {
            Action::Close => {
                self.parameters = None;
                self.compared = None;
                return Vec::new();
            }
            Action::Choose(steps) => {
                let last = heard.len().saturating_sub(1);
                *chosen = chosen.saturating_add_signed(steps.into()).min(last);
                return Vec::new();
            }
            Action::ReadParameters => return vec![Effect::Send(Request::Parameter(Tuning::List))],
            Action::SaveParameters => return vec![Effect::Send(Request::Parameter(Tuning::Save))],
            Action::CompareParameters => return self.ask_for_parameter_command("diff "),
            Action::LoadParameters => return self.ask_for_parameter_command("load "),
            Action::WriteParameters => return self.ask_for_parameter_command("save-to "),
            Action::DefaultParameter => line.and_then(|line| {
                let default = known_default(line.name.as_str())?;
                Some(parameter_number(default.into(), line.unit.as_str()))
            }),
            _ => Some(String::new()),
        };
        if let (Some(line), Some(value)) = (line, value) {
            let command = format!("set {} {value}", line.name.as_str());
            return self.ask_for_parameter_command(&command);
        }
        Vec::new()
    }

    fn ask_for_parameter_command(&mut self, beginning: &str) -> Vec<Effect> {
        let mut entry = TextEntry::new(Purpose::Command);
        entry.insert(&format!("param {beginning}"));
        self.overlay = Overlay::Text(entry);
        Vec::new()
    }

    /// The effect of `param save-to FILE`, `param load FILE` and `param diff FILE`; `None` for other commands.
    pub(super) fn name_parameter_file(
        facts: &Facts,
        command: &str,
    ) -> Result<Option<Effect>, String> {
        let Some((verb, file)) = file_command(command) else {
            return Ok(None);
        };
        if file.is_empty() {
            return Err(format!("`param {verb}` needs a file: param {verb} FILE"));
        }
        if facts.parameters.is_partial() {
            let heard = facts.parameters.heard();
            let known = match heard.first() {
                Some(line) => format!(
                    "only {} of {} parameters are known",
                    heard.len(),
                    line.count
                ),
                None => "no parameters are known".to_owned(),
            };
            return Err(format!("{known} yet; `param list` reads them again"));
        }
        let file = unquoted(file);
        Ok(Some(match verb {
            "save-to" => save_parameters(facts, file),
            _ => Effect::LoadParameters(file),
        }))
    }

    /// Compares a file with the robot's parameters; for `param load`, asks whether to set those that differ.
    pub(super) fn take_parameters(&mut self, facts: &Facts, read: Result<ParameterFile, String>) {
        let Overlay::Text(entry) = &self.overlay else {
            return;
        };
        // The operator may have gone on meanwhile.
        let Some((verb, _)) = file_command(&entry.text).filter(|_| entry.waits) else {
            return;
        };
        let loads = verb == "load";
        let heard = facts.parameters.heard();
        let found = read.and_then(|file| match file.differences(heard) {
            Ok(differences) => Ok((file, differences)),
            Err(error) => Err(error.to_string()),
        });
        let (file, differences) = match found {
            Ok(found) => found,
            Err(error) => {
                self.end_waiting(Some(&error));
                return;
            }
        };
        self.end_waiting(None);
        let first = differences.first().map(|first| first.robot.name);
        let first = first.and_then(|name| heard.iter().position(|line| line.name == name));
        self.parameters = Some(first.unwrap_or_default());
        let name = file.name().to_owned();
        self.compared = Some(file);
        if differences.is_empty() {
            self.note(Level::Info, format!("the robot has the values of {name}"));
        } else if loads {
            let requests = differences.iter().map(|differs| differs.entry.request());
            let requests: Vec<Request> = requests.collect();
            let parts: Vec<_> = requests.iter().filter_map(Request::turns_off).collect();
            let takes = match &parts[..] {
                [] => String::new(),
                parts => format!(" This turns {} off.", parts.join(" and ")),
            };
            let count = counted(requests.len() as u64, "parameter");
            self.ask(
                format!("Set {count} as in {name}?{takes}"),
                Then::Send(requests),
            );
        }
    }
}

/// The subcommand and the file of a command with a parameter file.
fn file_command(command: &str) -> Option<(&str, &str)> {
    let rest = command.trim().strip_prefix("param ")?.trim_start();
    let (verb, file) = rest.split_once(char::is_whitespace).unwrap_or((rest, ""));
    Tuning::FILE_VERBS
        .contains(&verb)
        .then(|| (verb, file.trim()))
}

pub(super) fn save_parameters(facts: &Facts, path: String) -> Effect {
    Effect::Save {
        kind: FileKind::Parameters,
        path,
        text: parameter_file::write("The robot's parameters.", facts.parameters.heard()),
        overwrite: false,
    }
}

#[cfg(test)]
mod tests {
    use crossterm::event::KeyCode;
    use groundwave_protocol::telemetry::{Body, ParameterLine, ParameterName, Printable};

    use super::*;
    use crate::event::{CommandStatus, Event};
    use crate::model::Config;
    use crate::model::testing::Scene;

    fn scene() -> Scene {
        let mut scene = Scene::new(Config::default());
        let asked = scene.type_text("P");
        assert_eq!(asked, [Effect::Send(Request::Parameter(Tuning::List))]);
        for (place, name, value, kept, limits, unit) in [
            (1, "top-speed", 10, 12, [2, 12], "in/s"),
            (2, "battery-low", 116, 116, [100, 130], "V/10"),
        ] {
            scene.hear_line(Body::Parameter(ParameterLine {
                place,
                count: 2,
                name: ParameterName::new(name),
                value,
                kept,
                least: limits[0],
                most: limits[1],
                unit: Printable::new(unit),
            }));
        }
        scene
    }

    #[test]
    fn a_value_is_changed_saved_and_read_again() {
        let mut scene = scene();
        scene.press(&[KeyCode::Down, KeyCode::Enter]);
        scene.type_text("11.8");
        let sent = scene.press(&[KeyCode::Enter]);
        let words = |request: &Effect| match request {
            Effect::Send(request) => request.to_string(),
            other => panic!("{other:?}"),
        };
        assert_eq!(
            sent.iter().map(words).collect::<Vec<_>>(),
            ["param set battery-low 11.8"]
        );
        assert_eq!(
            scene.model.ui.parameters,
            Some(1),
            "the list is there again"
        );
        let save = scene.type_text("s");
        assert_eq!(save.iter().map(words).collect::<Vec<_>>(), ["param save"]);
        scene.command(
            7,
            Request::Parameter(Tuning::Save),
            CommandStatus::Confirmed { digest: None },
        );
        let kept = scene.model.facts.parameters.heard()[0].kept;
        assert_eq!(kept, 10);
        let read = scene.type_text("r");
        assert_eq!(read.iter().map(words).collect::<Vec<_>>(), ["param list"]);
        scene.press(&[KeyCode::Esc]);
        assert_eq!(scene.model.ui.parameters, None);
    }

    #[test]
    fn the_default_is_offered_and_stop_works() {
        let mut scene = scene();
        scene.type_text("d");
        assert!(
            matches!(&scene.model.ui.overlay, Overlay::Text(entry) if entry.text == "param set top-speed 12")
        );
        scene.press(&[KeyCode::Esc]);
        assert_eq!(scene.type_text(" "), [Effect::Send(Request::Stop)]);
    }

    fn file(name: &str, text: &str) -> Event {
        let read = ParameterFile::parse(name, text);
        Event::ParametersLoaded {
            read: read.map_err(|error| error.to_string()),
        }
    }

    #[test]
    fn a_set_is_saved_compared_and_loaded() {
        let mut scene = scene();
        scene.type_text("wmy.toml");
        let saved = scene.press(&[KeyCode::Enter]);
        let [Effect::Save { path, text, .. }] = &saved[..] else {
            panic!("{saved:?}");
        };
        assert_eq!(path, "my.toml");
        assert!(text.contains("battery-low = 11.6"), "{text}");
        scene.event(Event::Saved {
            kind: FileKind::Parameters,
            path: "my.toml".to_owned(),
            saved: Ok(()),
        });
        let note = scene.model.facts.log.newest_first().next();
        assert!(note.is_some_and(|note| note.text == "my.toml: 2 parameters saved"));

        scene.type_text("cmy.toml");
        let load = [Effect::LoadParameters("my.toml".to_owned())];
        assert_eq!(scene.press(&[KeyCode::Enter]), load);
        let differs = "top-speed = 10\nbattery-low = 11.8";
        assert_eq!(scene.event(file("my.toml", differs)), []);
        assert_eq!(scene.model.ui.overlay, Overlay::None);
        assert_eq!(scene.model.ui.parameters, Some(1), "the one that differs");

        scene.type_text("lmy.toml");
        assert_eq!(scene.press(&[KeyCode::Enter]), load);
        assert_eq!(scene.event(file("my.toml", differs)), []);
        let Overlay::Question(question) = &scene.model.ui.overlay else {
            panic!("no question");
        };
        assert_eq!(question.text, "Set 1 parameter as in my.toml?");
        let sent = scene.type_text("y");
        assert!(
            matches!(&sent[..], [Effect::Send(request)] if request.to_string() == "param set battery-low 11.8"),
            "{sent:?}"
        );
    }

    #[test]
    fn a_wrong_file_is_corrected_in_the_prompt_and_an_answer_too_late_is_ignored() {
        let mut scene = scene();
        for (text, why) in [
            ("top-spede = 8", "did you mean `top-speed`"),
            ("top-speed = 99", "it takes 2 to 12"),
        ] {
            scene.type_text(":param load a.toml");
            scene.press(&[KeyCode::Enter]);
            scene.event(file("a.toml", text));
            let Overlay::Text(entry) = &scene.model.ui.overlay else {
                panic!("no prompt");
            };
            assert!(
                entry
                    .error
                    .as_ref()
                    .is_some_and(|error| error.contains(why))
            );
            scene.press(&[KeyCode::Esc]);
        }
        scene.type_text(":param load a.toml");
        scene.press(&[KeyCode::Enter, KeyCode::Esc]);
        scene.event(file("a.toml", "top-speed = 8"));
        assert_eq!(scene.model.ui.overlay, Overlay::None);
        assert_eq!(scene.model.ui.compared, None);
    }

    #[test]
    fn a_file_needs_all_of_the_robots_parameters() {
        let mut scene = Scene::new(Config::default());
        scene.type_text(":param diff a.toml");
        assert_eq!(scene.press(&[KeyCode::Enter]), []);
        let Overlay::Text(entry) = &scene.model.ui.overlay else {
            panic!("no prompt");
        };
        let error = "no parameters are known yet; `param list` reads them again";
        assert_eq!(entry.error.as_deref(), Some(error));
    }

    /// A switch that protects is named in the question.
    #[test]
    fn loading_names_what_it_turns_off() {
        let mut scene = scene();
        scene.hear_line(Body::Parameter(ParameterLine {
            place: 2,
            count: 2,
            name: ParameterName::new("cliff-guard"),
            value: 1,
            kept: 1,
            least: 0,
            most: 1,
            unit: Printable::new("0 or 1"),
        }));
        scene.type_text(":param load a.toml");
        scene.press(&[KeyCode::Enter]);
        scene.event(file("a.toml", "cliff-guard = 0"));
        let Overlay::Question(question) = &scene.model.ui.overlay else {
            panic!("no question");
        };
        assert!(
            question.text.ends_with("? This turns its cliff guard off."),
            "{}",
            question.text
        );
    }

    #[test]
    fn the_command_without_words_opens_the_screen() {
        let mut scene = scene();
        scene.press(&[KeyCode::Esc]);
        scene.type_text(":param");
        assert_eq!(scene.press(&[KeyCode::Enter]), [], "all are known");
        assert_eq!(scene.model.ui.parameters, Some(0));
    }

    #[test]
    fn a_restart_brings_the_saved_values_back() {
        let mut parameters = scene().model.facts.parameters.clone();
        parameters.take_restart();
        assert_eq!(parameters.heard()[0].value, 12);
    }
}
