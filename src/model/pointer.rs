//! The mouse: a click chooses, the wheel zooms or turns pages. The mouse sends nothing to the robot.

use groundwave_protocol::Waypoint;

use super::{Facts, Overlay, Panel, Ui};
use crate::event::{Gesture, Spot};

impl Ui {
    /// Takes a gesture; ignored while an overlay is open.
    pub(super) fn take_pointer(&mut self, facts: &Facts, on: Spot, gesture: Gesture) -> bool {
        if self.overlay != Overlay::None {
            return false;
        }
        match (on, gesture) {
            (
                Spot::Floor {
                    x_in,
                    y_in,
                    reach_in,
                },
                Gesture::Click,
            ) => {
                let at = Waypoint::new(x_in, y_in);
                let is_edited = self.editor.is_some();
                let near = at.filter(|_| is_edited);
                let near = near.and_then(|at| self.map.draft.nearest(at, reach_in));
                match near {
                    Some(n) => self.choose_waypoint(n),
                    None => self.map.cursor = at.or(self.map.cursor),
                }
            }
            (Spot::Waypoint(n), Gesture::Click) => self.choose_waypoint(n),
            (Spot::Waypoint(_), Gesture::Wheel(steps)) => {
                self.map.draft.select(-isize::from(steps));
                self.show_selected();
            }
            (Spot::Floor { .. }, Gesture::Wheel(steps)) => self.map.zoom_by(&facts.chart, steps),
            (Spot::Panel(place), gesture) => {
                let Some(panel) = Panel::ALL.get(place).copied() else {
                    return false;
                };
                match gesture {
                    Gesture::Click => self.show(panel),
                    Gesture::Wheel(steps) => {
                        if self.panel != panel {
                            self.show(panel);
                        }
                        self.turn_page(-i32::from(steps));
                    }
                }
            }
        }
        true
    }
}
