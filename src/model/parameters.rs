//! The screen that changes the robot's parameters.

use super::keys::Action;
use super::words::parameter_number;
use super::{Facts, Overlay, Purpose, TextEntry, Ui};
use crate::event::Effect;
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
                return Vec::new();
            }
            Action::Choose(steps) => {
                let last = heard.len().saturating_sub(1);
                *chosen = chosen.saturating_add_signed(steps.into()).min(last);
                return Vec::new();
            }
            Action::ReadParameters => return vec![Effect::Send(Request::Parameter(Tuning::List))],
            Action::SaveParameters => return vec![Effect::Send(Request::Parameter(Tuning::Save))],
            Action::DefaultParameter => line.and_then(|line| {
                let default = known_default(line.name.as_str())?;
                Some(parameter_number(default.into(), line.unit.as_str()))
            }),
            _ => Some(String::new()),
        };
        if let (Some(line), Some(value)) = (line, value) {
            let mut entry = TextEntry::new(Purpose::Command);
            entry.insert(&format!("param set {} {value}", line.name.as_str()));
            self.overlay = Overlay::Text(entry);
        }
        Vec::new()
    }
}

#[cfg(test)]
mod tests {
    use crossterm::event::KeyCode;
    use groundwave_protocol::telemetry::{Body, ParameterLine, ParameterName, Printable};

    use super::*;
    use crate::event::CommandStatus;
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
