//! What the robot knows at a tick: the readings as they last were, ready for the behaviours.

use crate::board::{Echo, Edges, Inputs, Side, Sides, Switches};
use crate::odometry::Pose;
use crate::parameters::{Parameter, Parameters};
use crate::units::cps;
use groundwave_protocol::Waypoint;
use groundwave_protocol::letters::Mode;

/// Everything a behaviour may look at.
#[derive(Clone, Copy, Debug)]
#[expect(clippy::struct_excessive_bools, reason = "one a sensor")]
pub struct Senses<'a> {
    /// What the operator may tune.
    pub parameters: &'a Parameters,
    /// What the robot has been told to do.
    pub mode: Mode,
    /// The point being driven to.
    pub target: Option<Waypoint>,
    /// Ticks since boot.
    pub now_ticks: u32,
    /// By odometry.
    pub pose: Pose,
    /// Counts of both wheels together in the past tick, backward negative: twice the way.
    pub way_counts: i16,
    /// Nothing drives the wheels, and they do not turn.
    pub is_standing: bool,
    /// Something holds the robot: the wheels slip or cannot turn.
    pub is_held: bool,
    /// A long running average of left minus right, counts a second.
    pub turning_cps: i16,
    /// Bumper switches that are closed.
    pub bumper: Switches,
    /// Infrared detections.
    pub infrared: Sides,
    /// The latest echoes.
    pub sonar: Ranges,
    /// Both photocells, left and right, 0 very bright to 255 dark; `None` when one is not fitted.
    pub photo: Option<(u8, u8)>,
    /// Where the floor ends; `None` when nothing sees that.
    pub cliff: Option<Edges>,
    /// What the motion detectors say; `None` when there are none.
    pub motion: Option<Sides>,
    /// Something is above the arm.
    pub top_hat: bool,
    /// Receivers that see the dock's beacon; `None` when there are none.
    pub beacon: Option<Sides>,
    /// The charger's voltage is on the contacts.
    pub is_docked: bool,
    /// The battery takes no more.
    pub is_charged: bool,
    /// How far ahead the robot means to go: obstacles beyond are none.
    pub horizon_in: u16,
    /// A number rolled for this tick.
    pub dice: u32,
}

impl Senses<'_> {
    /// The top speed, counts a second.
    #[must_use]
    pub fn top_cps(&self) -> i16 {
        cps(self.parameters.get(Parameter::TopSpeed))
    }

    /// A rotation of this size the way the wheels have been turning: to the right when they have not.
    #[must_use]
    pub const fn the_way_it_turns(&self, size_cps: i16) -> i16 {
        if self.turning_cps < 0 {
            -size_cps
        } else {
            size_cps
        }
    }
}

/// The latest echo of each sonar; `None` when none came back.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Ranges {
    /// Left, inches.
    pub left_in: Option<u16>,
    /// Right, inches.
    pub right_in: Option<u16>,
}

impl Ranges {
    /// Keeps a finished ping.
    pub const fn hear(&mut self, echo: Echo) {
        match echo.side {
            Side::Left => self.left_in = echo.range_in,
            Side::Right => self.right_in = echo.range_in,
        }
    }
}

/// Whose turn it is to ping at a tick: left and right in turn, two ticks each.
#[must_use]
pub const fn ping_at(now_ticks: u32) -> Option<Side> {
    match now_ticks & 3 {
        0 => Some(Side::Left),
        2 => Some(Side::Right),
        _ => None,
    }
}

/// Battery voltage averaged over about 3 s, so that a start of the motors does not count as flat.
#[derive(Clone, Debug, Default)]
pub struct Battery {
    /// In 64ths of a tenth of a volt; 0 before the first reading.
    average: u16,
}

impl Battery {
    /// Takes a reading in tenths of a volt.
    pub const fn read(&mut self, inputs: &Inputs) {
        let now = inputs.battery_dv as u16;
        self.average = if self.average == 0 {
            now * 64
        } else {
            self.average + now - self.average / 64
        };
    }

    /// Tenths of a volt.
    #[must_use]
    pub const fn decivolts(&self) -> u16 {
        self.average / 64
    }
}

#[cfg(test)]
impl Senses<'static> {
    /// Nothing anywhere, prowling at the origin.
    pub(crate) fn nothing() -> Self {
        Self {
            parameters: &Parameters::DEFAULT,
            mode: Mode::Prowl,
            target: None,
            now_ticks: 0,
            pose: Pose::default(),
            way_counts: 0,
            is_standing: false,
            is_held: false,
            turning_cps: 0,
            bumper: Switches::default(),
            infrared: Sides::default(),
            sonar: Ranges::default(),
            photo: None,
            cliff: None,
            motion: None,
            top_hat: false,
            beacon: None,
            is_docked: false,
            is_charged: false,
            horizon_in: 180,
            dice: 1,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pings_alternate_with_two_ticks_each() {
        let pings: [Option<Side>; 8] = core::array::from_fn(|tick| ping_at(tick as u32));
        let (left, right) = (Some(Side::Left), Some(Side::Right));
        assert_eq!(pings, [left, None, right, None, left, None, right, None]);
    }

    #[test]
    fn a_short_dip_of_the_battery_is_averaged_away() {
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
