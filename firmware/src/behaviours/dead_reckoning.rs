//! Layer 7: dead reckoning. Drives a route, home, to the dock, or the calibration square.

use super::behaviour::Behaviour;
use super::detour::Detour;
use super::docking::{Docking, DockingEvent};
use super::prowl;
use super::square::Square;
use crate::arbiter::Request;
use crate::parameters::Parameter;
use crate::sensors::Senses;
use groundwave_protocol::Waypoint;
use groundwave_protocol::status_codes::Mode;

/// The origin.
const HOME: Waypoint = Waypoint { x_in: 0, y_in: 0 };

/// State of the layer with its progress on the route.
#[derive(Clone, Debug, Default)]
pub struct DeadReckoning {
    driven: u16,
    has_arrived: bool,
    detour: Detour,
    docking: Docking,
    square: Square,
}

impl DeadReckoning {
    /// Begins a new route at its first point.
    pub const fn restart(&mut self) {
        self.driven = 0;
        self.has_arrived = false;
    }

    /// Number of reached points of the route.
    #[must_use]
    pub const fn driven(&self) -> u16 {
        self.driven
    }

    /// Target in a mode; `None` if the mode has none or the route is finished. After its end the robot prowls freely; the
    /// route starts again when it is activated again.
    #[must_use]
    pub fn target(&self, mode: Mode, list: &[Waypoint]) -> Option<Waypoint> {
        match mode {
            Mode::Prowl => list.get(usize::from(self.driven)).copied(),
            Mode::GoHome => Some(HOME),
            Mode::Forage => self.docking.target(),
            _ => None,
        }
    }

    /// Advances when the target was reached in this tick; returns whether it was the last.
    pub fn take_arrival(&mut self, mode: Mode, list: &[Waypoint]) -> Option<bool> {
        if !core::mem::take(&mut self.has_arrived) {
            return None;
        }
        match mode {
            Mode::Prowl => self.driven += 1,
            Mode::Forage => {
                self.docking.arrive();
                return None;
            }
            _ => {}
        }
        Some(mode == Mode::GoHome || usize::from(self.driven) >= list.len())
    }
}

impl DeadReckoning {
    /// State of docking.
    #[must_use]
    pub const fn docking(&self) -> &Docking {
        &self.docking
    }

    /// Docking event of this tick.
    pub const fn take_docking_event(&mut self) -> Option<DockingEvent> {
        self.docking.take_event()
    }

    /// Whether the calibration square was finished in this tick.
    pub fn take_square(&mut self) -> bool {
        self.square.take_done()
    }
}

impl Behaviour for DeadReckoning {
    fn decide(&mut self, senses: &Senses) -> Request {
        if senses.mode == Mode::Calibrate {
            return self.square.decide(senses);
        }
        if senses.mode == Mode::Forage
            && let Some(request) = self.docking.decide(senses)
        {
            return request;
        }
        let Some(target) = senses.target else {
            return Request::QUIET;
        };
        let arrive_in = i32::from(senses.parameters.get(Parameter::Arrive));
        self.has_arrived = prowl::distance_in(&senses.pose, target) < arrive_in;
        Request::raise(self.detour.toward(senses, target))
    }

    /// Keeps the progress on the route.
    fn rest(&mut self) {
        *self = Self {
            driven: self.driven,
            ..Self::default()
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::odometry::Odometer;

    const LIST: [Waypoint; 2] = [
        Waypoint { x_in: 0, y_in: 40 },
        Waypoint { x_in: 40, y_in: 40 },
    ];

    fn at(x_in: i16, y_in: i16, mode: Mode, target: Option<Waypoint>) -> Senses<'static> {
        let mut odometer = Odometer::default();
        odometer.set(Waypoint { x_in, y_in }, crate::angle::Angle(0));
        Senses {
            mode,
            target,
            pose: odometer.pose(),
            ..Senses::idle()
        }
    }

    #[test]
    fn route_is_driven_point_by_point() {
        let mut layer = DeadReckoning::default();
        let mut arrive = |x_in, y_in| {
            let target = layer.target(Mode::Prowl, &LIST);
            let request = layer.decide(&at(x_in, y_in, Mode::Prowl, target));
            let arrival = layer.take_arrival(Mode::Prowl, &LIST);
            (request.flag, arrival, layer.driven())
        };
        assert_eq!(arrive(0, 0), (true, None, 0));
        assert_eq!(arrive(0, 34), (true, None, 0));
        assert_eq!(arrive(0, 35), (true, Some(false), 1));
        assert_eq!(arrive(0, 35), (true, None, 1));
        assert_eq!(arrive(42, 43), (true, Some(true), 2));
        // The route is finished: no request.
        assert_eq!(arrive(42, 43), (false, None, 2));
        layer.restart();
        assert_eq!(layer.target(Mode::Prowl, &LIST), Some(LIST[0]));
    }

    #[test]
    fn home_is_the_origin_and_does_not_advance_the_route() {
        let mut layer = DeadReckoning::default();
        let home = layer.target(Mode::GoHome, &LIST);
        assert_eq!(home, Waypoint::new(0, 0));
        assert!(layer.decide(&at(3, -3, Mode::GoHome, home)).flag);
        assert_eq!(layer.take_arrival(Mode::GoHome, &LIST), Some(true));
        assert_eq!(layer.driven(), 0);
    }

    #[test]
    fn other_modes_have_no_target() {
        let layer = DeadReckoning::default();
        for mode in [Mode::Stop, Mode::User, Mode::Reactive] {
            assert_eq!(layer.target(mode, &LIST), None);
        }
        assert_eq!(layer.target(Mode::Prowl, &[]), None);
    }

    #[test]
    fn rest_forgets_an_arrival_but_not_the_progress() {
        let mut layer = DeadReckoning::default();
        layer.decide(&at(0, 40, Mode::Prowl, Some(LIST[0])));
        layer.take_arrival(Mode::Prowl, &LIST);
        layer.decide(&at(40, 40, Mode::Prowl, Some(LIST[1])));
        layer.rest();
        assert_eq!(layer.take_arrival(Mode::Prowl, &LIST), None);
        assert_eq!(layer.driven(), 1);
    }
}
