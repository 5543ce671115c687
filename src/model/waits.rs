//! Waits for the robot in the background: `:wait until driven`, `:expect battery > 12`.

use std::time::Duration;

use groundwave_protocol::decoder::Received;

use super::Ui;
use crate::event::{Effect, Event, Level, Moment};
use crate::wait::{Wait, Waiting};

/// Time for `expect` to receive its fields: two status lines at 2400 baud.
const PATIENCE: Duration = Duration::from_secs(20);

/// A wait in progress, and its beginning.
pub(super) type Begun = (Moment, Waiting);

impl Ui {
    /// Carries out `wait ...` and `expect ...`; `None` for other commands.
    pub(super) fn begin_wait(&mut self, now: Moment, words: &[&str]) -> Option<Result<(), String>> {
        let wait = match Wait::from_words(words)? {
            Ok(_) if self.is_replay() => {
                return Some(Err(
                    "a capture has no robot to wait for; <ask-jump-forward> looks for a moment"
                        .to_owned(),
                ));
            }
            Ok(wait) => wait,
            Err(error) => return Some(Err(error)),
        };
        self.note(
            Level::Info,
            self.with_keys(&format!("{wait}: begun; <cancel-commands> cancels it")),
        );
        self.waits.push((now, Waiting::new(wait, PATIENCE)));
        Some(Ok(()))
    }

    /// Ends all waits.
    pub(super) fn give_up_waits(&mut self) {
        for (_, waiting) in std::mem::take(&mut self.waits) {
            self.note(Level::Info, format!("{}: given up", waiting.wait()));
        }
    }

    /// Takes an event with a line of the robot, and reports the waits that end.
    pub(super) fn wait_on(&mut self, now: Moment, event: &Event) -> Option<Effect> {
        if self.waits.is_empty() {
            return None;
        }
        if let Event::Line { line, raw } = event {
            let line = Received::Line(**line, *raw);
            self.waits
                .iter_mut()
                .for_each(|(_, waiting)| waiting.take(&line));
        }
        let mut ended = Vec::new();
        self.waits.retain(|(begun, waiting)| {
            let after = now.saturating_sub(*begun);
            let Some(end) = waiting.ended(after) else {
                return true;
            };
            ended.push((waiting.wait().to_string(), after, end));
            false
        });
        for (wait, after, end) in &ended {
            match end {
                Ok(seen) if seen.is_empty() => self.note(Level::Info, format!("{wait}: over")),
                Ok(seen) => {
                    let text = format!("{wait}: after {:.1} s, {seen}", after.as_secs_f64());
                    self.note(Level::Info, text);
                }
                Err(why) => self.warn(why),
            }
        }
        (!ended.is_empty() && self.bell).then_some(Effect::Ring)
    }

    /// Time at which the first wait with a limit ends.
    pub(super) fn waits_until(&self) -> Option<Moment> {
        let limits = self
            .waits
            .iter()
            .filter_map(|(begun, waiting)| Some(*begun + waiting.limit()?));
        limits.min()
    }
}

#[cfg(test)]
mod tests {
    use crossterm::event::KeyCode;
    use groundwave_protocol::status_codes::Mode;

    use crate::event::{Effect, Event};
    use crate::model::Config;
    use crate::model::testing::Scene;

    fn logged(scene: &Scene) -> String {
        let log = scene.model.facts.log.newest_first();
        log.map(|entry| &*entry.text).collect::<Vec<_>>().join("\n")
    }

    fn typed(scene: &mut Scene, command: &str) -> Vec<Effect> {
        scene.type_text(command);
        scene.press(&[KeyCode::Enter])
    }

    #[test]
    fn a_wait_reports_when_it_is_met() {
        let mut scene = Scene::new(Config {
            bell: true,
            ..Config::default()
        });
        scene.state.mode = Mode::Prowl;
        scene.hear();
        assert_eq!(typed(&mut scene, ":wait until mode home within 2m"), []);
        assert!(logged(&scene).contains("wait until mode home within 2m: begun"));
        scene.hear();
        assert!(!logged(&scene).contains("after"), "{}", logged(&scene));
        scene.state.mode = Mode::GoHome;
        scene.wait_ms(1000);
        scene.hear();
        let log = logged(&scene);
        assert!(
            log.contains("within 2m: after 1.7 s, mode go_home"),
            "{log}"
        );
        assert_eq!(scene.model.ui.waits_until(), None);
    }

    #[test]
    fn a_wait_that_is_not_met_reports_the_values_received() {
        let mut scene = Scene::new(Config::default());
        typed(&mut scene, ":wait until driven within 30s");
        scene.hear();
        let limit = scene.model.ui.waits_until().unwrap();
        assert_eq!(limit.as_secs(), 30);
        scene.now = limit;
        scene.event(Event::Tick);
        let log = logged(&scene);
        assert!(log.contains("not met in time; "), "{log}");
    }

    #[test]
    fn expect_reports_the_values_received_at_once() {
        let mut scene = Scene::new(Config::default());
        typed(&mut scene, ":expect battery > 20");
        scene.hear_status();
        let log = logged(&scene);
        assert!(log.contains("`expect battery > 20`: battery_v "), "{log}");
    }

    #[test]
    fn waits_are_given_up_with_the_commands() {
        let mut scene = Scene::new(Config::default());
        typed(&mut scene, ":wait until driven");
        assert_eq!(scene.type_text("x"), [Effect::CancelCommands]);
        scene.hear();
        let log = logged(&scene);
        assert!(log.contains("wait until driven: given up"), "{log}");
    }

    #[test]
    fn wrong_words_stay_in_the_prompt() {
        let mut scene = Scene::new(Config::default());
        typed(&mut scene, ":wait until batery < 12");
        assert!(
            matches!(&scene.model.ui.overlay, crate::model::Overlay::Text(entry) if entry.error.as_ref().is_some_and(|error| error.contains("battery")))
        );
    }
}
