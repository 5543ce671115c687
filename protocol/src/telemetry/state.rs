//! Line A: pose, speeds, sensors, mode and layers.
//!
//! ```text
//! 1-3  5-10   12-17  19-21 23-25 27-29 31-33 35-37 39-41 43-45 47-48 50-51 53-59   61-68    70-74 75-78
//! A42  +123.4 -045.0 273   +06   -12   +00   +12   042   120   61    48    .R..... P--Is..d !5:HS ^*"+
//! seq  X      Y      theta v     rot   wheels L R  sonars L R  photo L R   flags   mode,    ack   CRC
//!                                                                                  layers
//! ```

use super::columns::Columns;
use super::fields::{Fields, Parsed, Read, character, digits, letter, optional, signed};
use crate::status_codes::{
    Arm, Bump, Cliff, Drive, Infrared, Layer, LayerState, Link, Mode, Power,
};
use nom::Parser;
use nom::branch::alt;
use nom::combinator::verify;
use nom::sequence::separated_pair;

/// Line A.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StateLine {
    /// X, tenths of an inch; whole inches from 1000 in on; saturates at 99,999 in.
    pub x_tenths_in: i32,
    /// Y, tenths of an inch; whole inches from 1000 in on; saturates at 99,999 in.
    pub y_tenths_in: i32,
    /// Heading, 0 to 359 degrees, clockwise from +Y.
    pub theta_deg: u16,
    /// Requested speed at the centre, in/s.
    pub velocity_in_s: i8,
    /// Requested difference between the wheels, left minus right, in/s.
    pub rotation_in_s: i8,
    /// Measured speed of the left wheel, in/s.
    pub wheel_left_in_s: i8,
    /// Measured speed of the right wheel, in/s.
    pub wheel_right_in_s: i8,
    /// Distance of the left sonar, inches; `None` without an echo.
    pub sonar_left_in: Option<u16>,
    /// Distance of the right sonar, inches; `None` without an echo.
    pub sonar_right_in: Option<u16>,
    /// Left photocell, per cent of full scale, 0 very bright; `None` when not fitted.
    pub photo_left_pct: Option<u8>,
    /// Right photocell, per cent of full scale, 0 very bright; `None` when not fitted.
    pub photo_right_pct: Option<u8>,
    /// State of the bumper.
    pub bump: Bump,
    /// State of the infrared detectors.
    pub infrared: Infrared,
    /// State of the floor edge sensors.
    pub cliff: Cliff,
    /// State of servo arm and motion detectors.
    pub arm: Arm,
    /// State of drive train and odometer.
    pub drive: Drive,
    /// State of the battery.
    pub power: Power,
    /// State of the failsafe.
    pub link: Link,
    /// Commanded mode.
    pub mode: Mode,
    /// States of layers 1 to 7.
    pub layers: LayerStates,
}

/// The states of layers 1 to 7; at most one controls the motors. Layer 0 has no column: it controls
/// the motors in [`Mode::User`] while no other layer does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LayerStates([LayerState; 7]);

impl LayerStates {
    /// All layers off.
    pub const OFF: Self = Self([LayerState::Off; 7]);

    /// The state of a layer; layer 0 is always [`LayerState::Off`] here.
    #[must_use]
    pub fn get(&self, layer: Layer) -> LayerState {
        (layer as usize)
            .checked_sub(1)
            .and_then(|i| self.0.get(i).copied())
            .unwrap_or(LayerState::Off)
    }

    /// Sets the state of a layer; layer 0 has none. The layer that controlled the motors before becomes raised.
    pub fn set(&mut self, layer: Layer, state: LayerState) {
        if state == LayerState::Holds
            && let Some(before) = self.holder()
        {
            self.set(before, LayerState::Raised);
        }
        if let Some(slot) = (layer as usize)
            .checked_sub(1)
            .and_then(|i| self.0.get_mut(i))
        {
            *slot = state;
        }
    }

    /// The layer that controls the motors; `None` while prowl or User controls them.
    #[must_use]
    pub fn holder(&self) -> Option<Layer> {
        Layer::ALL
            .into_iter()
            .find(|&layer| self.get(layer) == LayerState::Holds)
    }
}

impl StateLine {
    /// A robot at the origin and at rest, with every layer off, no detections and no optional parts; a base for struct updates.
    pub const BLANK: Self = Self {
        x_tenths_in: 0,
        y_tenths_in: 0,
        theta_deg: 0,
        velocity_in_s: 0,
        rotation_in_s: 0,
        wheel_left_in_s: 0,
        wheel_right_in_s: 0,
        sonar_left_in: None,
        sonar_right_in: None,
        photo_left_pct: None,
        photo_right_pct: None,
        bump: Bump::None,
        infrared: Infrared::None,
        cliff: Cliff::NotFitted,
        arm: Arm::NotFitted,
        drive: Drive::Ok,
        power: Power::Ok,
        link: Link::Ok,
        mode: Mode::Prowl,
        layers: LayerStates::OFF,
    };

    pub(super) fn write(&self, columns: &mut Columns) {
        write_position(columns, 5, self.x_tenths_in);
        write_position(columns, 12, self.y_tenths_in);
        columns.digits(19, 3, u32::from(self.theta_deg % 360));
        for (column, speed) in [
            (23, self.velocity_in_s),
            (27, self.rotation_in_s),
            (31, self.wheel_left_in_s),
            (35, self.wheel_right_in_s),
        ] {
            columns.signed(column, 3, i32::from(speed));
        }
        columns.optional(39, 3, self.sonar_left_in.map(u32::from));
        columns.optional(43, 3, self.sonar_right_in.map(u32::from));
        columns.optional(47, 2, self.photo_left_pct.map(u32::from));
        columns.optional(50, 2, self.photo_right_pct.map(u32::from));
        columns.bytes(
            53,
            &[
                self.bump.letter(),
                self.infrared.letter(),
                self.cliff.letter(),
                self.arm.letter(),
                self.drive.letter(),
                self.power.letter(),
                self.link.letter(),
            ],
        );
        columns.letter(61, self.mode.letter());
        for (column, layer) in (61..).zip(Layer::ALL).skip(1) {
            columns.letter(
                column,
                match self.layers.get(layer) {
                    LayerState::Off => b'.',
                    LayerState::Quiet => b'-',
                    LayerState::Raised => layer.letter().to_ascii_lowercase(),
                    LayerState::Holds => layer.letter(),
                },
            );
        }
    }

    pub(super) fn read(line: &mut Fields) -> Read<Self> {
        Ok(Self {
            x_tenths_in: line.field(position)?,
            y_tenths_in: line.field(position)?,
            theta_deg: line.field(verify(digits::<3, u16>, |&theta_deg| theta_deg < 360))?,
            velocity_in_s: line.field(signed(digits::<2, i8>))?,
            rotation_in_s: line.field(signed(digits::<2, i8>))?,
            wheel_left_in_s: line.field(signed(digits::<2, i8>))?,
            wheel_right_in_s: line.field(signed(digits::<2, i8>))?,
            sonar_left_in: line.field(optional(b"---", digits::<3, u16>))?,
            sonar_right_in: line.field(optional(b"---", digits::<3, u16>))?,
            photo_left_pct: line.field(optional(b"--", digits::<2, u8>))?,
            photo_right_pct: line.field(optional(b"--", digits::<2, u8>))?,
            bump: line.field(letter(Bump::from_letter))?,
            infrared: line.next(letter(Infrared::from_letter))?,
            cliff: line.next(letter(Cliff::from_letter))?,
            arm: line.next(letter(Arm::from_letter))?,
            drive: line.next(letter(Drive::from_letter))?,
            power: line.next(letter(Power::from_letter))?,
            link: line.next(letter(Link::from_letter))?,
            mode: line.field(letter(Mode::from_letter))?,
            layers: line.next(layers)?,
        })
    }
}

/// Parses a coordinate, `+123.4` below 1000 inches or `+12346` from there on; returns tenths of an inch.
fn position(input: &[u8]) -> Parsed<'_, i32> {
    let tenths = separated_pair(digits::<3, i32>, character(b'.'), digits::<1, i32>);
    let tenths = tenths.map(|(whole_in, tenths)| whole_in * 10 + tenths);
    let whole = verify(digits::<5, i32>, |&whole_in| whole_in >= 1000);
    let whole = whole.map(|whole_in| whole_in * 10);
    signed(alt((tenths, whole))).parse(input)
}

/// Parses a letter for each of layers 1 to 7; at most one controls the motors.
fn layers(mut input: &[u8]) -> Parsed<'_, LayerStates> {
    let mut layers = LayerStates::OFF;
    let mut is_held = false;
    for (layer, state) in Layer::ALL[1..].iter().zip(&mut layers.0) {
        let own = layer.letter();
        let states = letter(|letter| match letter {
            b'.' => Some(LayerState::Off),
            b'-' => Some(LayerState::Quiet),
            _ if letter == own && !is_held => Some(LayerState::Holds),
            _ if letter == own.to_ascii_lowercase() => Some(LayerState::Raised),
            _ => None,
        });
        (input, *state) = { states }.parse(input)?;
        is_held |= *state == LayerState::Holds;
    }
    Ok((input, layers))
}

/// Writes a coordinate: `+123.4` below 1000 inches, `+12346` from there on.
fn write_position(columns: &mut Columns, column: usize, tenths_in: i32) {
    let magnitude = tenths_in.unsigned_abs();
    columns.letter(column, if tenths_in < 0 { b'-' } else { b'+' });
    if magnitude < 10_000 {
        columns.digits(column + 1, 3, magnitude / 10);
        columns.letter(column + 4, b'.');
        columns.digits(column + 5, 1, magnitude % 10);
    } else {
        columns.digits(column + 1, 5, magnitude / 10);
    }
}

#[cfg(test)]
mod tests {
    use super::super::Body;
    use super::super::testing::{blamed, edits, has_one_form, read_back};
    use super::*;
    use proptest::prelude::*;

    fn position() -> impl Strategy<Value = i32> {
        // Below 1000 inches in tenths, from there on in whole inches.
        prop_oneof![
            -9999..=9999_i32,
            (1000..=99_999_i32).prop_map(|v| v * 10),
            (-99_999..=-1000_i32).prop_map(|v| v * 10)
        ]
    }

    fn layers() -> impl Strategy<Value = LayerStates> {
        let one = prop::sample::select(LayerState::ALL);
        prop::collection::vec(one, 7).prop_map(|states| {
            let mut layers = LayerStates::OFF;
            for (layer, state) in Layer::ALL.into_iter().skip(1).zip(states) {
                layers.set(layer, state);
            }
            layers
        })
    }

    prop_compose! {
        fn letters()(
            bump in prop::sample::select(Bump::ALL),
            infrared in prop::sample::select(Infrared::ALL),
            cliff in prop::sample::select(Cliff::ALL),
            arm in prop::sample::select(Arm::ALL),
            drive in prop::sample::select(Drive::ALL),
            power in prop::sample::select(Power::ALL),
            link in prop::sample::select(Link::ALL),
            mode in prop::sample::select(Mode::ALL),
            layers in layers(),
        ) -> StateLine {
            StateLine { bump, infrared, cliff, arm, drive, power, link, mode, layers, ..StateLine::BLANK }
        }
    }

    prop_compose! {
        fn state(
            position: BoxedStrategy<i32>, theta_max: u16, speed_max: i8, sonar_max: u16, photo_max: u8,
        )(
            x_tenths_in in position.clone(),
            y_tenths_in in position,
            theta_deg in 0..=theta_max,
            [velocity_in_s, rotation_in_s, wheel_left_in_s, wheel_right_in_s]
                in prop::array::uniform4(!speed_max.saturating_sub(1)..=speed_max),
            [sonar_left_in, sonar_right_in]
                in prop::array::uniform2(prop::option::of(0..=sonar_max)),
            [photo_left_pct, photo_right_pct]
                in prop::array::uniform2(prop::option::of(0..=photo_max)),
            letters in letters(),
        ) -> StateLine {
            StateLine {
                x_tenths_in, y_tenths_in, theta_deg, velocity_in_s, rotation_in_s, wheel_left_in_s,
                wheel_right_in_s, sonar_left_in, sonar_right_in, photo_left_pct, photo_right_pct,
                ..letters
            }
        }
    }

    fn in_range() -> impl Strategy<Value = StateLine> {
        state(position().boxed(), 359, 99, 999, 99)
    }

    proptest! {
        #[test]
        fn values_in_range_survive_a_round_trip(line in in_range()) {
            prop_assert_eq!(read_back(Body::State(line)), Body::State(line));
        }

        #[test]
        fn any_value_makes_a_readable_line(
            line in state(any::<i32>().boxed(), u16::MAX, i8::MAX, u16::MAX, u8::MAX)
        ) {
            read_back(Body::State(line));
        }

        #[test]
        fn readable_lines_have_one_form(line in in_range(), edits in edits()) {
            has_one_form(Body::State(line), &edits);
        }
    }

    #[test]
    fn values_beyond_their_field_saturate() {
        let line = StateLine {
            x_tenths_in: i32::MIN,
            y_tenths_in: 9_999_999,
            theta_deg: 725,
            velocity_in_s: i8::MIN,
            rotation_in_s: i8::MAX,
            sonar_left_in: Some(u16::MAX),
            photo_left_pct: Some(100),
            ..StateLine::BLANK
        };
        let Body::State(read) = read_back(Body::State(line)) else {
            panic!("not a line A");
        };
        let expected = StateLine {
            x_tenths_in: -999_990,
            y_tenths_in: 999_990,
            theta_deg: 5,
            velocity_in_s: -99,
            rotation_in_s: 99,
            sonar_left_in: Some(999),
            photo_left_pct: Some(99),
            ..StateLine::BLANK
        };
        assert_eq!(read, expected);
    }

    #[test]
    fn bad_fields_are_blamed_by_their_first_column() {
        let bad: &[(usize, &[u8], u8)] = &[
            (4, b"x", 4),
            (5, b"-000.0", 5),
            (5, b"+00012", 5),
            (5, b"+00999", 5),
            (5, b" 000.0", 5),
            (5, b"+00.00", 5),
            (5, b"+0000.", 5),
            (5, b"+12a.4", 5),
            (5, b"+123.x", 5),
            (5, b"0123.4", 5),
            (12, b"-000.0", 12),
            (12, b"------", 12),
            (19, b"360", 19),
            (19, b"999", 19),
            (19, b"+12", 19),
            (19, b" 12", 19),
            (23, b"-00", 23),
            (23, b" 00", 23),
            (27, b"+0x", 27),
            (31, b"012", 31),
            (35, b"---", 35),
            (39, b"--1", 39),
            (39, b"1--", 39),
            (43, b" 12", 43),
            (47, b"-1", 47),
            (50, b"1 ", 50),
            (53, b"x", 53),
            (54, b"A", 54),
            (55, b"J", 55),
            (56, b"A", 56),
            (57, b"x", 57),
            (58, b"-", 58),
            (59, b"<", 59),
            (60, b".", 60),
            (61, b".", 61),
            (61, b"p", 61),
            (62, b"T", 62),
            (63, b"b", 63),
            (68, b"+", 68),
            (62, b"B-I", 64),
            (69, b"0", 69),
        ];
        for &(column, characters, column_blamed) in bad {
            let said = blamed(Body::State(StateLine::BLANK), column, characters);
            let shown = characters.escape_ascii();
            assert_eq!(said, Some(column_blamed), "{shown} at {column}");
        }
    }

    #[test]
    fn positions_change_form_at_a_thousand_inches() {
        for (tenths, text) in [
            (0, b"+000.0"),
            (-1, b"-000.1"),
            (9999, b"+999.9"),
            (10_000, b"+01000"),
            (10_009, b"+01000"),
            (-123_460, b"-12346"),
        ] {
            let line = StateLine {
                x_tenths_in: tenths,
                ..StateLine::BLANK
            };
            assert_eq!(Body::State(line).head(0)[4..10], *text);
        }
    }

    #[test]
    fn at_most_one_layer_holds_the_motors() {
        let mut layers = LayerStates::OFF;
        layers.set(Layer::Sonar, LayerState::Holds);
        layers.set(Layer::Bumpers, LayerState::Holds);
        assert_eq!(layers.holder(), Some(Layer::Bumpers));
        assert_eq!(layers.get(Layer::Sonar), LayerState::Raised);
        layers.set(Layer::Bumpers, LayerState::Holds);
        assert_eq!(layers.holder(), Some(Layer::Bumpers));
        layers.set(Layer::User, LayerState::Holds);
        assert_eq!(layers.get(Layer::User), LayerState::Off);
        assert_eq!(layers.holder(), None);
    }
}
