//! The mouse: a click chooses, the wheel zooms or turns pages. It asks nothing of the robot.

use groundwave_protocol::Waypoint;

use super::{Model, Overlay, Panel};
use crate::event::{Gesture, Spot};

impl Model {
    /// Takes what was done on the screen; whatever lies over the panels has to be closed by a key.
    pub(super) fn take_pointer(&mut self, on: Spot, gesture: Gesture) -> bool {
        if self.overlay != Overlay::None {
            return false;
        }
        match (on, gesture) {
            (Spot::Floor { x_in, y_in }, Gesture::Click) => {
                self.chart.cursor = Waypoint::new(x_in, y_in).or(self.chart.cursor);
            }
            (Spot::Floor { .. }, Gesture::Wheel(steps)) => self.chart.zoom_by(steps),
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
