//! The route editor: keys that change the draft on the map and in its list.

use groundwave_protocol::Waypoint;

use super::draft::Edit;
use super::keys::RouteAction;
use super::ui::Overlay;
use super::{Facts, Purpose, TextEntry, Ui};
use crate::event::{Effect, FileKind};
use crate::route;

/// Step of an arrow key, inches; the fine step with Shift.
const STEP_IN: f64 = 6.0;
const FINE_STEP_IN: f64 = 1.0;

/// Factor by which one press enlarges the route.
const GROWTH: f64 = 1.1;

/// The state of the open route editor.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Editor {
    /// Whether the arrows move the whole route.
    pub(crate) whole: bool,
    /// Reason why the last key had no effect.
    pub(crate) problem: Option<String>,
}

impl Ui {
    pub(super) fn open_editor(&mut self) {
        self.editor = Some(Editor::default());
        self.show_selected();
    }

    pub(super) fn edit_route(&mut self, facts: &Facts, action: RouteAction) -> Vec<Effect> {
        let whole = self.editor.as_ref().is_some_and(|editor| editor.whole);
        let robot = facts.chart.pose();
        let result = match action {
            RouteAction::Append => match self.pointed_at() {
                Some(at) => {
                    let at = Edit::AppendAt(f64::from(at.x_in), f64::from(at.y_in));
                    self.map.draft.edit(at, robot)
                }
                None => self.map.draft.edit(Edit::Append, robot),
            },
            RouteAction::Insert => self.map.draft.edit(Edit::Insert, robot),
            RouteAction::AppendAtRobot => match robot {
                Some(pose) => {
                    let here = Edit::AppendAt(pose.x_in, pose.y_in);
                    self.map.draft.edit(here, robot)
                }
                None => return self.tell_editor("the robot's position is not known yet"),
            },
            RouteAction::Delete => self.map.draft.edit(Edit::Delete, robot),
            RouteAction::Clear => self.map.draft.edit(Edit::Clear, robot),
            RouteAction::Undo => self.map.draft.undo(),
            RouteAction::Redo => self.map.draft.redo(),
            RouteAction::Select(steps) => {
                self.map.draft.select(steps);
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
                self.map.draft.edit(edit, robot)
            }
            RouteAction::Whole => {
                if let Some(editor) = &mut self.editor {
                    editor.whole = !whole;
                }
                Ok(())
            }
            RouteAction::Rotate(deg) => self.map.draft.edit(Edit::Rotate(deg.into()), robot),
            RouteAction::Mirror => self.map.draft.edit(Edit::Mirror, robot),
            RouteAction::Scale(steps) => {
                let factor = GROWTH.powi(steps.into());
                self.map.draft.edit(Edit::Scale(factor), robot)
            }
            RouteAction::Reverse => self.map.draft.edit(Edit::Reverse, robot),
            RouteAction::TakeRobots => match facts.ledger.active() {
                Some(active) => {
                    self.map.draft.replace(&active.waypoints.clone());
                    Ok(())
                }
                None => {
                    return self.tell_editor(
                        "the robot's route was not sent in this session: it can be replaced, but not read back",
                    );
                }
            },
            RouteAction::Send => {
                let effects = self.send_draft();
                if !effects.is_empty() {
                    self.leave_editor();
                }
                return effects;
            }
            RouteAction::AskToLoad => return self.ask_for_file(Purpose::RouteFile),
            RouteAction::AskToSave if self.map.draft.waypoints().is_empty() => {
                return self.tell_editor("the draft is empty: there is nothing to save");
            }
            RouteAction::AskToSave => return self.ask_for_file(Purpose::SaveRoute),
            RouteAction::Leave => {
                self.leave_editor();
                return Vec::new();
            }
        };
        let problem = result.err().map(|error| self.with_keys(&error.to_string()));
        // A refused change keeps the place under the cursor.
        if problem.is_none() {
            self.show_selected();
        }
        if let Some(editor) = &mut self.editor {
            editor.problem = problem;
        }
        Vec::new()
    }

    /// Place of the cursor, if the mouse moved it away from the selected waypoint.
    fn pointed_at(&self) -> Option<Waypoint> {
        let selected = self.map.draft.selected_waypoint();
        self.map.cursor.filter(|at| Some(*at) != selected)
    }

    pub(super) fn choose_waypoint(&mut self, n: usize) {
        self.map.draft.choose(n);
        self.show_selected();
    }

    fn leave_editor(&mut self) {
        self.editor = None;
        self.map.cursor = None;
    }

    fn ask_for_file(&mut self, purpose: Purpose) -> Vec<Effect> {
        self.overlay = Overlay::Text(TextEntry::new(purpose));
        Vec::new()
    }

    pub(super) fn tell_editor(&mut self, problem: &str) -> Vec<Effect> {
        if let Some(editor) = &mut self.editor {
            editor.problem = Some(problem.to_owned());
        }
        Vec::new()
    }

    /// Moves the cursor to the selected waypoint and keeps it on the map.
    pub(super) fn show_selected(&mut self) {
        if self.editor.is_some() {
            self.map.include_draft();
            let selected = self.map.draft.selected_waypoint();
            self.map.cursor = selected.or(self.map.cursor);
        }
    }

    pub(super) fn save_route(&self, path: String) -> Effect {
        Effect::Save {
            kind: FileKind::Route,
            path,
            text: route::format(self.map.draft.waypoints()),
            overwrite: false,
        }
    }
}
