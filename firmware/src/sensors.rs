//! State of the robot at a tick for the behaviours: the latest readings and results.

use crate::board::{Echo, Edges, Inputs, Side, Sides, Switches};
use crate::odometry::Pose;
use crate::parameters::{Parameter, Parameters};
use crate::units::cps;
use groundwave_protocol::Waypoint;
use groundwave_protocol::status_codes::Mode;

/// All inputs of a behaviour.
#[derive(Clone, Copy, Debug)]
#[expect(clippy::struct_excessive_bools, reason = "one per sensor")]
pub struct Senses<'a> {
    /// Tunable parameters.
    pub parameters: &'a Parameters,
    /// Current mode.
    pub mode: Mode,
    /// Point that the robot is driving to.
    pub target: Option<Waypoint>,
    /// Number of ticks since boot.
    pub now_ticks: u32,
    /// Pose by odometry.
    pub pose: Pose,
    /// Sum of the counts of both wheels in the past tick, negative backward: twice the distance.
    pub path_counts: i16,
    /// Whether the wheels are not driven and do not turn.
    pub is_standing: bool,
    /// Whether an obstacle holds the robot: the wheels slip or cannot turn.
    pub is_held: bool,
    /// Long-term average of left minus right in counts per second.
    pub turning_cps: i16,
    /// Closed bumper switches.
    pub bumper: Switches,
    /// Infrared detections.
    pub infrared: Sides,
    /// Whether infrared has adapted to walls on both sides, and the robot drives to no target.
    pub is_confined: bool,
    /// Latest sonar ranges.
    pub sonar: Ranges,
    /// Left and right photocells, 0 very bright to 255 dark; `None` if one is not fitted.
    pub photo: Option<(u8, u8)>,
    /// Edge sensors that detect no floor; `None` if not fitted.
    pub cliff: Option<Edges>,
    /// Motion detectors; `None` if not fitted.
    pub motion: Option<Sides>,
    /// Whether an object presses the switch on top of the arm.
    pub top_hat: bool,
    /// Receivers that detect the dock's beacon; `None` if not fitted.
    pub beacon: Option<Sides>,
    /// Whether the charger's voltage is on the contacts.
    pub is_docked: bool,
    /// Whether the battery is full.
    pub is_charged: bool,
    /// Distance ahead beyond which obstacles are ignored, inches.
    pub horizon_in: u16,
    /// Random number for this tick.
    pub random: u32,
}

impl Senses<'_> {
    /// Top speed in counts per second.
    #[must_use]
    pub fn top_cps(&self) -> i16 {
        cps(self.parameters.get(Parameter::TopSpeed))
    }

    /// A rotation of this size in the direction in which the robot has been turning, or to the right.
    #[must_use]
    pub const fn in_turning_direction(&self, size_cps: i16) -> i16 {
        if self.turning_cps < 0 {
            -size_cps
        } else {
            size_cps
        }
    }
}

/// Range from which the floor ahead is open rather than blocked, inches.
const OPEN_IN: u16 = 40;

/// Latest range of each sonar; `None` without an echo.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Ranges {
    /// Range of the left sonar, inches.
    pub left_in: Option<u16>,
    /// Range of the right sonar, inches.
    pub right_in: Option<u16>,
}

impl Ranges {
    /// Sides on which an echo proves open floor ahead.
    #[must_use]
    pub fn open(self) -> Sides {
        self.sides(|range_in| range_in >= OPEN_IN)
    }

    /// Sides on which an echo proves an obstacle ahead. A smooth oblique wall gives no echo.
    #[must_use]
    pub fn blocked(self) -> Sides {
        self.sides(|range_in| range_in < OPEN_IN)
    }

    fn sides(self, is_so: fn(u16) -> bool) -> Sides {
        Sides {
            left: self.left_in.is_some_and(is_so),
            right: self.right_in.is_some_and(is_so),
        }
    }

    /// Stores the result of a ping. An echo beyond the sonar's reach is a false one.
    pub fn update(&mut self, echo: Echo, reach_in: u16) {
        let range_in = echo.range_in.filter(|&range_in| range_in <= reach_in);
        match echo.side {
            Side::Left => self.left_in = range_in,
            Side::Right => self.right_in = range_in,
        }
    }
}

/// Sonar that pings at a tick: left and right alternate, two ticks each.
#[must_use]
pub const fn ping_at(now_ticks: u32) -> Option<Side> {
    match now_ticks & 3 {
        0 => Some(Side::Left),
        2 => Some(Side::Right),
        _ => None,
    }
}

/// Battery voltage averaged over about 3 s, because starting motors must not count as a low battery.
#[derive(Clone, Debug, Default)]
pub struct Battery {
    /// Average in 1/64 of a tenth of a volt; 0 before the first reading.
    average: u16,
}

impl Battery {
    /// Takes a reading.
    pub const fn read(&mut self, inputs: &Inputs) {
        let now = inputs.battery_dv as u16;
        self.average = if self.average == 0 {
            now * 64
        } else {
            self.average + now - self.average / 64
        };
    }

    /// Average voltage in tenths of a volt.
    #[must_use]
    pub const fn decivolts(&self) -> u16 {
        self.average / 64
    }
}

#[cfg(test)]
impl Senses<'static> {
    /// No obstacles; prowling at the origin.
    pub(crate) fn idle() -> Self {
        Self {
            parameters: &Parameters::DEFAULT,
            mode: Mode::Prowl,
            target: None,
            now_ticks: 0,
            pose: Pose::default(),
            path_counts: 0,
            is_standing: false,
            is_held: false,
            turning_cps: 0,
            bumper: Switches::default(),
            infrared: Sides::default(),
            is_confined: false,
            sonar: Ranges::default(),
            photo: None,
            cliff: None,
            motion: None,
            top_hat: false,
            beacon: None,
            is_docked: false,
            is_charged: false,
            horizon_in: 180,
            random: 1,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_echo_is_neither_open_nor_blocked() {
        let ranges = Ranges {
            left_in: Some(OPEN_IN),
            right_in: None,
        };
        assert_eq!(
            ranges.open(),
            Sides {
                left: true,
                right: false
            }
        );
        assert!(!ranges.blocked().any());
        let near = Ranges {
            right_in: Some(OPEN_IN - 1),
            ..ranges
        };
        assert_eq!(
            near.blocked(),
            Sides {
                left: false,
                right: true
            }
        );
    }

    #[test]
    fn an_echo_beyond_the_reach_is_none() {
        let mut ranges = Ranges::default();
        let mut update = |range_in| {
            let side = Side::Right;
            ranges.update(
                Echo {
                    side,
                    range_in: Some(range_in),
                },
                157,
            );
            ranges.right_in
        };
        assert_eq!(
            [156, 157, 158].map(&mut update),
            [Some(156), Some(157), None]
        );
    }

    #[test]
    fn pings_alternate_with_two_ticks_each() {
        let pings: [Option<Side>; 8] = core::array::from_fn(|tick| ping_at(tick as u32));
        let (left, right) = (Some(Side::Left), Some(Side::Right));
        assert_eq!(pings, [left, None, right, None, left, None, right, None]);
    }

    #[test]
    fn short_dip_of_the_battery_is_averaged_out() {
        let mut battery = Battery::default();
        let mut read = |battery_dv, times| {
            for _ in 0..times {
                battery.read(&Inputs {
                    battery_dv,
                    ..Inputs::default()
                });
            }
            battery.decivolts()
        };
        assert_eq!(read(126, 1), 126);
        assert!(read(100, 4) > 120);
        assert_eq!(read(110, 1000), 110);
    }
}
