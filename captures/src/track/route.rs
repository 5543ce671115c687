//! The waypoints that the robot drove to.

use groundwave_protocol::Waypoint;
use groundwave_protocol::digest::digest;
use groundwave_protocol::status_codes::Mode;
use groundwave_protocol::telemetry::StatusLine;

use super::DrivenTo;
use crate::station_event::{StationEvent, StationEventKind};

/// Maximum number of lists kept, and of waypoints.
const LISTS_MAX: usize = 64;
const WAYPOINTS_MAX: usize = 1000;

/// Collects waypoints from lines B and from the lists that the operator sent.
#[derive(Debug, Default)]
pub(super) struct Routes {
    lists: Vec<(u32, Vec<Waypoint>)>,
    /// Digest and length of the active list.
    active: Option<(u32, u16)>,
    route: u32,
    pub(super) waypoints: Vec<DrivenTo>,
}

impl Routes {
    /// Takes an event of the station; a queued command contains its list.
    pub(super) fn take_event(&mut self, event: &StationEvent) {
        let Some(StationEventKind::Command(command)) = &event.kind else {
            return;
        };
        let places = command.waypoints_x_in.iter().zip(&command.waypoints_y_in);
        let list: Vec<Waypoint> = places
            .filter_map(|(&x, &y)| {
                Some(Waypoint {
                    x_in: x.try_into().ok()?,
                    y_in: y.try_into().ok()?,
                })
            })
            .collect();
        let digest = digest(list.iter());
        if !list.is_empty() && self.lists.iter().all(|(known, _)| *known != digest) {
            if self.lists.len() == LISTS_MAX {
                self.lists.remove(0);
            }
            self.lists.push((digest, list));
        }
    }

    /// Takes a line B of a robot in a mode.
    pub(super) fn take_status(&mut self, mode: Option<Mode>, status: &StatusLine) {
        let (driven, count) = (status.list.driven, status.list.count);
        let list = (status.digest, count);
        if count == 0 {
            return;
        }
        if mode != Some(Mode::Prowl) {
            // At its last waypoint the robot stops before it reports the arrival.
            if self.active == Some(list) {
                self.reach(driven);
            }
            return;
        }
        let is_again = self.reached() > usize::from(driven);
        if self.active != Some(list) || is_again {
            self.active = Some(list);
            self.route += 1;
        }
        let known = self.lists.iter().find(|(digest, _)| *digest == list.0);
        let points: Vec<(u16, Waypoint)> = match (known, status.target_in) {
            (Some((_, list)), _) => (0..=driven.min(count - 1))
                .filter_map(|index| Some((index, *list.get(usize::from(index))?)))
                .collect(),
            (None, Some((x_in, y_in))) if driven < count => {
                vec![(driven, Waypoint { x_in, y_in })]
            }
            _ => Vec::new(),
        };
        for (index, Waypoint { x_in, y_in }) in points {
            let number = index + 1;
            let is_new = !self.own().any(|waypoint| waypoint.number == number);
            if is_new && self.waypoints.len() < WAYPOINTS_MAX {
                self.waypoints.push(DrivenTo {
                    route: self.route,
                    number,
                    place_in: (x_in, y_in),
                    is_reached: false,
                });
            }
        }
        self.reach(driven);
    }

    /// Notes that a number of waypoints of the present route were reached.
    fn reach(&mut self, driven: u16) {
        for waypoint in self.waypoints.iter_mut().rev() {
            if waypoint.route != self.route {
                break;
            }
            waypoint.is_reached |= waypoint.number <= driven;
        }
    }

    /// The waypoints of the current route.
    fn own(&self) -> impl Iterator<Item = &DrivenTo> {
        self.waypoints
            .iter()
            .rev()
            .take_while(|waypoint| waypoint.route == self.route)
    }

    /// Number of waypoints of the current route that were reached.
    fn reached(&self) -> usize {
        self.own().filter(|waypoint| waypoint.is_reached).count()
    }
}
