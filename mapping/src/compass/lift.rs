//! Whether the robot was lifted from the floor: it may be put down anywhere.

use groundwave_protocol::status_codes::{Cliff, Mode};
use groundwave_protocol::telemetry::StateLine;

/// Lines A without floor after which the robot was lifted. One of them may come from an edge behind it (SPEC.md, *Guards*).
const LINES: u8 = 3;

/// What the floor sensors say. A robot without them cannot show it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Lift {
    lines: u8,
    /// The odometer's pose when the floor was last seen.
    floor_at: Option<(i32, i32, u16)>,
}

impl Lift {
    /// Takes a line; returns whether the robot is lifted with it.
    pub(super) fn take(&mut self, state: &StateLine) -> bool {
        let pose = (state.x_tenths_in, state.y_tenths_in, state.theta_deg);
        if state.cliff == Cliff::None {
            self.floor_at = Some(pose);
        }
        let stands = state.velocity_in_s == 0 && state.rotation_in_s == 0;
        // The guard stands still when no sensor sees floor. In two modes a robot also rests without it, and may have come to rest at an edge.
        let may_rest = matches!(state.mode, Mode::Stop | Mode::Reactive);
        let has_none =
            state.layers.holder().is_none() && (!may_rest || self.floor_at == Some(pose));
        self.lines = if state.cliff == Cliff::Several && stands && has_none {
            self.lines.saturating_add(1)
        } else {
            0
        };
        self.lines == LINES
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(mode: Mode, cliff: Cliff, x_tenths_in: i32) -> StateLine {
        StateLine {
            mode,
            cliff,
            x_tenths_in,
            ..StateLine::BLANK
        }
    }

    fn is_lifted(lines: &[StateLine]) -> bool {
        let mut lift = Lift::default();
        lines.iter().filter(|line| lift.take(line)).count() > 0
    }

    #[test]
    fn stopped_robot_is_lifted_if_the_floor_goes_while_it_stands() {
        let floor = line(Mode::Stop, Cliff::None, 100);
        let none = line(Mode::Stop, Cliff::Several, 100);
        assert!(is_lifted(&[floor, none, none, none]));
        assert!(!is_lifted(&[floor, none, none, floor, none, none]));
        // It drove to an edge, and was stopped there.
        let edge = line(Mode::Stop, Cliff::Several, 103);
        assert!(!is_lifted(&[floor, edge, edge, edge, edge]));
    }

    #[test]
    fn moving_robot_is_lifted_if_the_guard_stands_still() {
        let none = line(Mode::Prowl, Cliff::Several, 103);
        assert!(is_lifted(&[none, none, none]));
        let backs_off = StateLine {
            velocity_in_s: -5,
            ..none
        };
        assert!(!is_lifted(&[none, backs_off, none, none]));
        let one_sensor = line(Mode::Prowl, Cliff::Left, 103);
        assert!(!is_lifted(&[one_sensor; 4]));
    }
}
