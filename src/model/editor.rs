//! The route editor: keys that change the draft on the map and in its list.

use groundwave_protocol::Waypoint;

use super::draft::Edit;
use super::log::Subject;
use super::{Model, Overlay, Purpose, Question, TextEntry, Then};
use crate::event::{Effect, Level, Moment, SaveProblem};
use crate::route;

/// A step of an arrow, inches; with Shift a fine one.
const STEP_IN: f64 = 6.0;
const FINE_STEP_IN: f64 = 1.0;

/// One press makes the route larger by this.
const GROWTH: f64 = 1.1;

/// The route editor is open.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Editor {
    /// The arrows move the whole route.
    pub(crate) whole: bool,
    /// Why the last key did nothing.
    pub(crate) problem: Option<String>,
}

/// What a key of the editor does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RouteAction {
    Append,
    Insert,
    AppendAtRobot,
    Delete,
    Clear,
    Undo,
    Redo,
    Select(isize),
    Step { east: i8, north: i8, fine: bool },
    Whole,
    Rotate(i16),
    Mirror,
    Scale(i8),
    Reverse,
    TakeRobots,
    Send,
    AskToLoad,
    AskToSave,
    Leave,
}

impl Model {
    pub(super) fn open_editor(&mut self) {
        self.editor = Some(Editor::default());
        self.show_selected();
    }

    pub(super) fn edit_route(&mut self, now: Moment, action: RouteAction) -> Vec<Effect> {
        let whole = self.editor.as_ref().is_some_and(|editor| editor.whole);
        let robot = self.chart.pose();
        let result = match action {
            RouteAction::Append => match self.pointed_at() {
                Some(at) => {
                    let at = Edit::AppendAt(f64::from(at.x_in), f64::from(at.y_in));
                    self.chart.draft.edit(at, robot)
                }
                None => self.chart.draft.edit(Edit::Append, robot),
            },
            RouteAction::Insert => self.chart.draft.edit(Edit::Insert, robot),
            RouteAction::AppendAtRobot => match robot {
                Some(pose) => {
                    let here = Edit::AppendAt(pose.x_in, pose.y_in);
                    self.chart.draft.edit(here, robot)
                }
                None => return self.tell_editor("the robot has not said yet where it is"),
            },
            RouteAction::Delete => self.chart.draft.edit(Edit::Delete, robot),
            RouteAction::Clear => self.chart.draft.edit(Edit::Clear, robot),
            RouteAction::Undo => self.chart.draft.undo(),
            RouteAction::Redo => self.chart.draft.redo(),
            RouteAction::Select(steps) => {
                self.chart.draft.select(steps);
                Ok(())
            }
            RouteAction::Step { east, north, fine } => {
                let step_in = if fine { FINE_STEP_IN } else { STEP_IN };
                let (east, north) = (f64::from(east) * step_in, f64::from(north) * step_in);
                let edit = if whole {
                    Edit::Shift(east, north)
                } else {
                    Edit::Move(east, north)
                };
                self.chart.draft.edit(edit, robot)
            }
            RouteAction::Whole => {
                if let Some(editor) = &mut self.editor {
                    editor.whole = !whole;
                }
                Ok(())
            }
            RouteAction::Rotate(deg) => self.chart.draft.edit(Edit::Rotate(deg.into()), robot),
            RouteAction::Mirror => self.chart.draft.edit(Edit::Mirror, robot),
            RouteAction::Scale(steps) => {
                let factor = GROWTH.powi(steps.into());
                self.chart.draft.edit(Edit::Scale(factor), robot)
            }
            RouteAction::Reverse => self.chart.draft.edit(Edit::Reverse, robot),
            RouteAction::TakeRobots => match self.ledger.active() {
                Some(active) => {
                    self.chart.draft.replace(&active.waypoints.clone());
                    Ok(())
                }
                None => {
                    return self.tell_editor(
                        "what the robot holds was not sent in this session: it can be replaced, not read back",
                    );
                }
            },
            RouteAction::Send => {
                let effects = self.send_draft(now);
                if !effects.is_empty() {
                    self.leave_editor();
                }
                return effects;
            }
            RouteAction::AskToLoad => return self.ask_for_file(Purpose::RouteFile),
            RouteAction::AskToSave if self.chart.draft.waypoints().is_empty() => {
                return self.tell_editor("the draft is empty: there is nothing to save");
            }
            RouteAction::AskToSave => return self.ask_for_file(Purpose::SaveRoute),
            RouteAction::Leave => {
                self.leave_editor();
                return Vec::new();
            }
        };
        let problem = result.err().map(|error| self.told(&error.to_string()));
        // A place that was pointed at is not forgotten for a key that did nothing.
        if problem.is_none() {
            self.show_selected();
        }
        if let Some(editor) = &mut self.editor {
            editor.problem = problem;
        }
        Vec::new()
    }

    /// Where the cursor is when the mouse has put it somewhere else than on the selected waypoint.
    fn pointed_at(&self) -> Option<Waypoint> {
        let selected = self.chart.draft.selected_waypoint();
        self.chart.cursor.filter(|at| Some(*at) != selected)
    }

    pub(super) fn choose_waypoint(&mut self, n: usize) {
        self.chart.draft.choose(n);
        self.show_selected();
    }

    fn leave_editor(&mut self) {
        self.editor = None;
        self.chart.cursor = None;
    }

    fn ask_for_file(&mut self, purpose: Purpose) -> Vec<Effect> {
        self.overlay = Overlay::Text(TextEntry::new(purpose));
        Vec::new()
    }

    fn tell_editor(&mut self, problem: &str) -> Vec<Effect> {
        if let Some(editor) = &mut self.editor {
            editor.problem = Some(problem.to_owned());
        }
        Vec::new()
    }

    /// The selected waypoint is always on the map, under the cursor.
    pub(super) fn show_selected(&mut self) {
        if self.editor.is_some() {
            self.chart.include_draft();
            let selected = self.chart.draft.selected_waypoint();
            self.chart.cursor = selected.or(self.chart.cursor);
        }
    }

    pub(super) fn save_route(&self, path: &str, overwrite: bool) -> Effect {
        Effect::SaveRoute {
            path: path.to_owned(),
            text: route::format(self.chart.draft.waypoints()),
            overwrite,
        }
    }

    pub(super) fn take_saved(&mut self, now: Moment, path: &str, saved: &Result<(), SaveProblem>) {
        match saved {
            Ok(()) => {
                let text = format!(
                    "{path}: {} waypoints saved",
                    self.chart.draft.waypoints().len()
                );
                self.log.add(now, Level::Info, Subject::Station, text);
                self.end_waiting(None);
            }
            Err(SaveProblem::Exists) => {
                self.overlay = Overlay::Question(Question {
                    text: format!("{path} exists. Overwrite it with the draft?"),
                    then: Then::SaveRoute(path.to_owned()),
                });
            }
            Err(SaveProblem::Failed(problem)) => {
                self.tell_editor(problem);
                self.end_waiting(Some(problem));
                self.log
                    .add(now, Level::Warning, Subject::Station, problem.as_str());
            }
        }
    }
}
