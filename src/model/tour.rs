//! The tour of the demo: one step at a time, each done by its key.

use groundwave_protocol::status_codes::Mode;

use super::{Facts, Overlay, Ui};
use crate::event::Effect;
use crate::model::keys::Context;
use crate::playback::Control;
use crate::request::Request;

/// The tour of a session.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Tour {
    /// This session has no tour.
    #[default]
    Absent,
    /// A step of [`STEPS`] is shown.
    At(usize),
    /// All steps were done, or the operator dismissed it.
    Ended,
}

/// A step of the tour.
struct Step {
    /// The instruction, with the names of its keys.
    text: &'static str,
    /// Whether the operator has just done the step.
    is_done: fn(&Ui, &Facts, &[Effect]) -> bool,
}

/// The steps, from STOP to the help.
const STEPS: [Step; 8] = [
    Step {
        text: "Press <stop>: the robot stops",
        is_done: |_, _, effects| effects.contains(&Effect::Send(Request::Stop)),
    },
    Step {
        text: "Press <modes/mode-go-home>: it drives home",
        is_done: |_, _, effects| effects.contains(&Effect::Send(Request::Mode(Mode::GoHome))),
    },
    Step {
        text: "Move the cursor with <move-cursor-left..>, press <add-waypoint>: a waypoint",
        is_done: |ui, _, _| !ui.map.draft.waypoints().is_empty(),
    },
    Step {
        text: "Press <send-draft>: the route goes to the robot",
        is_done: |_, _, effects| {
            let is_route = |effect: &Effect| matches!(effect, Effect::Send(Request::Route(_)));
            effects.iter().any(is_route)
        },
    },
    Step {
        text: "Press <modes/mode-prowl>: it drives the route",
        // A robot that prowls has begun the route already.
        is_done: |_, facts, effects| {
            let prowls = |mode| mode == Mode::Prowl;
            facts.robot.mode().is_some_and(prowls)
                || effects.contains(&Effect::Send(Request::Mode(Mode::Prowl)))
        },
    },
    Step {
        text: "Press <playback-step-back>: one line back in time",
        is_done: |ui, _, _| ui.shows_past(),
    },
    Step {
        text: "Press <playback-newest>: back to now",
        is_done: |_, _, effects| effects.contains(&Effect::Playback(Control::Newest)),
    },
    Step {
        text: "Press <help>: all keys",
        is_done: |ui, _, _| ui.overlay == Overlay::Help,
    },
];

/// The displayed step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TourStep {
    /// Number of the step, from 1.
    pub(crate) number: usize,
    /// Total number of steps.
    pub(crate) of: usize,
    /// The instruction, with the names of its keys.
    pub(crate) text: &'static str,
}

impl Ui {
    /// Begins the tour.
    pub const fn begin_tour(&mut self) {
        self.tour = Tour::At(0);
    }

    /// The displayed step.
    pub(crate) fn tour_step(&self) -> Option<TourStep> {
        let Tour::At(step) = self.tour else {
            return None;
        };
        let text = STEPS.get(step)?.text;
        let (number, of) = (step + 1, STEPS.len());
        Some(TourStep { number, of, text })
    }

    /// Whether the operator has seen or dismissed the tour.
    #[must_use]
    pub fn has_ended_tour(&self) -> bool {
        self.tour == Tour::Ended
    }

    /// Whether the key for closing dismisses the tour, because nothing else can be closed.
    pub(crate) fn closing_ends_tour(&self) -> bool {
        self.context() == Context::Dashboard && !self.can_put_away() && !self.is_looking()
    }

    pub(super) fn end_tour(&mut self) {
        if let Tour::At(_) = self.tour {
            self.tour = Tour::Ended;
        }
    }

    /// Advances the tour if the displayed step is done; returns whether it is.
    pub(super) fn advance_tour(&mut self, facts: &Facts, effects: &[Effect]) -> bool {
        let Tour::At(step) = self.tour else {
            return false;
        };
        let is_done = STEPS
            .get(step)
            .is_some_and(|step| (step.is_done)(self, facts, effects));
        if is_done {
            self.tour = if step + 1 < STEPS.len() {
                Tour::At(step + 1)
            } else {
                Tour::Ended
            };
        }
        is_done
    }
}

#[cfg(test)]
mod tests {
    use crossterm::event::KeyCode;

    use super::*;
    use crate::event::CommandStatus;
    use crate::model::Config;
    use crate::model::testing::{Scene, playback};

    fn scene() -> Scene {
        let mut scene = Scene::new(Config::default());
        scene.model.ui.begin_tour();
        scene.hear_status();
        scene.hear();
        scene
    }

    fn number(scene: &Scene) -> Option<usize> {
        scene.model.ui.tour_step().map(|step| step.number)
    }

    #[test]
    fn the_keys_lead_from_stop_to_help() {
        let mut scene = scene();
        scene.type_text("mpv");
        assert_eq!(number(&scene), Some(1));
        scene.type_text(" ");
        assert_eq!(number(&scene), Some(2));
        scene.type_text("mp");
        assert_eq!(number(&scene), Some(2), "another mode");
        scene.type_text("mh");
        assert_eq!(number(&scene), Some(3));
        scene.press(&[KeyCode::Up, KeyCode::Up]);
        assert_eq!(number(&scene), Some(3));
        scene.type_text("w");
        assert_eq!(number(&scene), Some(4));
        scene.type_text("S");
        assert_eq!(number(&scene), Some(5));
        scene.type_text("mp");
        assert_eq!(number(&scene), Some(6));
        scene.show_moment(Some(playback(true)));
        scene.hear();
        assert_eq!(number(&scene), Some(7));
        scene.type_text("G");
        scene.show_moment(None);
        assert_eq!(number(&scene), Some(8));
        assert!(!scene.model.ui.has_ended_tour());
        scene.type_text("?");
        assert_eq!(number(&scene), None);
        assert!(scene.model.ui.has_ended_tour());
    }

    #[test]
    fn a_robot_that_prowls_is_not_asked_to() {
        let mut scene = scene();
        scene.type_text(" mh");
        scene.command(
            1,
            Request::Mode(Mode::Prowl),
            CommandStatus::Confirmed { digest: None },
        );
        scene.press(&[KeyCode::Up]);
        scene.type_text("wS");
        assert_eq!(number(&scene), Some(5));
        scene.hear();
        assert_eq!(number(&scene), Some(6));
    }

    #[test]
    fn esc_closes_everything_else_first() {
        let mut scene = scene();
        for keys in ["?", "y", ":", "m", "n", "i", "e", "w", "z"] {
            scene.type_text(keys);
            assert!(!scene.model.ui.closing_ends_tour(), "{keys}");
            scene.press(&[KeyCode::Esc]);
            assert_eq!(number(&scene), Some(1), "{keys}");
            assert!(scene.model.ui.closing_ends_tour(), "{keys}");
        }
        scene.press(&[KeyCode::Esc]);
        assert_eq!(number(&scene), None);
        assert!(scene.model.ui.has_ended_tour());
    }

    #[test]
    fn other_sessions_have_none() {
        let mut scene = Scene::new(Config::default());
        scene.type_text(" ?");
        scene.press(&[KeyCode::Esc; 2]);
        assert_eq!(number(&scene), None);
        assert!(!scene.model.ui.has_ended_tour());
    }
}
