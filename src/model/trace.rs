//! The line and the columns that each value on the screen comes from (SPEC.md section 5, "Lines").

use groundwave_protocol::telemetry::LineType;

/// Line types whose columns are traced.
pub(crate) const TRACED: [LineType; 3] = [LineType::State, LineType::Status, LineType::Counters];

/// Index of a type in [`TRACED`].
pub(crate) fn place(line_type: LineType) -> Option<usize> {
    TRACED.iter().position(|traced| *traced == line_type)
}

/// A value and its columns.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Field {
    pub(crate) line_type: LineType,
    pub(crate) name: &'static str,
    /// First and last column, counted from 1.
    pub(crate) columns: (usize, usize),
}

const fn a(name: &'static str, first: usize, last: usize) -> Field {
    field(LineType::State, name, first, last)
}

const fn b(name: &'static str, first: usize, last: usize) -> Field {
    field(LineType::Status, name, first, last)
}

const fn c(name: &'static str, first: usize, last: usize) -> Field {
    field(LineType::Counters, name, first, last)
}

const fn field(line_type: LineType, name: &'static str, first: usize, last: usize) -> Field {
    Field {
        line_type,
        name,
        columns: (first, last),
    }
}

/// Every value, line by line in the order of its columns.
pub(crate) const FIELDS: [Field; 45] = [
    a("sequence", 2, 3),
    a("x", 5, 10),
    a("y", 12, 17),
    a("heading", 19, 21),
    a("speed ordered", 23, 25),
    a("turning ordered", 27, 29),
    a("left wheel", 31, 33),
    a("right wheel", 35, 37),
    a("left sonar", 39, 41),
    a("right sonar", 43, 45),
    a("darkness left", 47, 48),
    a("darkness right", 50, 51),
    a("bumper", 53, 53),
    a("infrared", 54, 54),
    a("floor edges", 55, 55),
    a("arm and motion", 56, 56),
    a("drive train", 57, 57),
    a("battery's state", 58, 58),
    a("failsafe", 59, 59),
    a("mode", 61, 61),
    a("layers 1 to 7", 62, 68),
    a("acknowledgement", 70, 74),
    b("robot's number", 5, 6),
    b("battery", 8, 11),
    b("target x", 13, 17),
    b("target y", 19, 23),
    b("list driven", 25, 31),
    b("list's digest", 33, 38),
    b("infrared max_count", 40, 41),
    b("left photocell", 43, 45),
    b("right photocell", 47, 49),
    b("layers allowed", 51, 58),
    b("boots", 60, 62),
    b("odometer resets", 64, 65),
    c("robot's number", 5, 6),
    c("uptime", 8, 13),
    c("boots", 15, 17),
    c("version", 19, 23),
    c("ticks won", 25, 42),
    c("frames heard", 44, 46),
    c("frames rejected", 48, 50),
    c("ticks late", 52, 54),
    c("bumps", 56, 59),
    c("failsafe after", 61, 64),
    c("failsafe mode", 66, 66),
];

/// Index of the field `steps` further, wrapping around.
pub(crate) const fn step(at: usize, steps: i8) -> usize {
    let count = FIELDS.len() as isize;
    (at as isize + steps as isize).rem_euclid(count) as usize
}

/// Index of the first field of the next or previous line type.
pub(crate) fn next_line(at: usize, steps: i8) -> usize {
    let field = FIELDS.get(at).and_then(|field| place(field.line_type));
    let next = field.unwrap_or(0) as isize + isize::from(steps);
    let line_type = TRACED[next.rem_euclid(TRACED.len() as isize) as usize];
    FIELDS
        .iter()
        .position(|field| field.line_type == line_type)
        .unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use groundwave_protocol::status_codes::{
        Arm, Bump, Cliff, Drive, Infrared, Layer, LayerMask, LayerState, Link, Mode, Power,
    };
    use groundwave_protocol::telemetry::{Ack, Body, CountersLine, Line, StateLine, StatusLine};

    use super::*;
    use crate::model::testing::{counters, state, status};

    /// Columns in which two lines differ, except sequence, acknowledgement and checksum.
    fn changed(one: Body, other: Body) -> Vec<usize> {
        let encode = |body| {
            let ack = Ack::default();
            Line {
                sequence: 1,
                body,
                ack,
            }
            .encode()
        };
        let (one, other) = (encode(one), encode(other));
        (0..69)
            .filter(|&n| one[n] != other[n])
            .map(|n| n + 1)
            .collect()
    }

    fn assert_within(line_type: LineType, name: &str, changed: &[usize]) {
        let field = FIELDS
            .iter()
            .find(|field| field.line_type == line_type && field.name == name);
        let (first, last) = field.unwrap_or_else(|| panic!("no {name}")).columns;
        assert!(!changed.is_empty(), "{name}");
        for column in changed {
            assert!((first..=last).contains(column), "{name}: {changed:?}");
        }
    }

    #[test]
    fn a_value_changes_its_own_columns_and_no_others() {
        type Change<T> = fn(&mut T);
        let of_state: [(&str, Change<StateLine>); 20] = [
            ("x", |line| line.x_tenths_in = -99_999),
            ("y", |line| line.y_tenths_in = -99_999),
            ("heading", |line| line.theta_deg = 359),
            ("speed ordered", |line| line.velocity_in_s = -99),
            ("turning ordered", |line| line.rotation_in_s = -99),
            ("left wheel", |line| line.wheel_left_in_s = -99),
            ("right wheel", |line| line.wheel_right_in_s = -99),
            ("left sonar", |line| line.sonar_left_in = None),
            ("right sonar", |line| line.sonar_right_in = None),
            ("darkness left", |line| line.photo_left_pct = None),
            ("darkness right", |line| line.photo_right_pct = None),
            ("bumper", |line| line.bump = Bump::Left),
            ("infrared", |line| line.infrared = Infrared::Both),
            ("floor edges", |line| line.cliff = Cliff::Left),
            ("arm and motion", |line| line.arm = Arm::Up),
            ("drive train", |line| line.drive = Drive::Stalled),
            ("battery's state", |line| line.power = Power::Low),
            ("failsafe", |line| line.link = Link::Armed),
            ("mode", |line| line.mode = Mode::Stop),
            ("layers 1 to 7", |line| {
                line.layers.set(Layer::Sonar, LayerState::Holds);
            }),
        ];
        for (name, change) in of_state {
            let mut line = state();
            change(&mut line);
            let changed = changed(Body::State(state()), Body::State(line));
            assert_within(LineType::State, name, &changed);
        }
        let of_status: [(&str, Change<StatusLine>); 9] = [
            ("robot's number", |line| line.robot_id = 98),
            ("battery", |line| line.battery_dv = 999),
            ("list's digest", |line| line.digest = u32::MAX),
            ("infrared max_count", |line| line.max_count = 99),
            ("left photocell", |line| line.photo_left = None),
            ("right photocell", |line| line.photo_right = None),
            ("layers allowed", |line| line.allowed = LayerMask::NONE),
            ("boots", |line| line.boots = 999),
            ("odometer resets", |line| line.odometer_resets = 99),
        ];
        for (name, change) in of_status {
            let mut line = status();
            change(&mut line);
            let changed = changed(Body::Status(status()), Body::Status(line));
            assert_within(LineType::Status, name, &changed);
        }
        let zero = || counters(0, [0; 9]);
        let of_counters: [(&str, Change<CountersLine>); 7] = [
            ("uptime", |line| line.uptime_s = 999_999),
            ("boots", |line| line.boots = 999),
            ("ticks won", |line| line.ticks_won = [4095; 9]),
            ("frames heard", |line| line.frames_heard = 999),
            ("frames rejected", |line| line.frames_rejected = 999),
            ("ticks late", |line| line.ticks_late = 999),
            ("bumps", |line| line.bumps = 9999),
        ];
        for (name, change) in of_counters {
            let mut line = zero();
            change(&mut line);
            let changed = changed(Body::Counters(zero()), Body::Counters(line));
            assert_within(LineType::Counters, name, &changed);
        }
    }

    #[test]
    fn fields_do_not_overlap_and_steps_go_round() {
        for pair in FIELDS.windows(2) {
            assert!(
                pair[0].line_type != pair[1].line_type || pair[0].columns.1 < pair[1].columns.0
            );
        }
        assert_eq!(step(0, -1), FIELDS.len() - 1);
        assert_eq!(step(FIELDS.len() - 1, 1), 0);
        assert_eq!(FIELDS[next_line(3, 1)].line_type, LineType::Status);
        assert_eq!(FIELDS[next_line(3, -1)].line_type, LineType::Counters);
    }
}
