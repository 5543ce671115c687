//! Line A: where the robot is, what it senses and who holds its motors.
//!
//! ```text
//! 1-3  5-10   12-17  19-21 23-25 27-29 31-33 35-37 39-41 43-45 47-48 50-51 53-59   61-68    70-74 75-78
//! A42  +123.4 -045.0 273   +06   -12   +00   +12   042   120   61    48    .R..... P--Is..d !5:HS ^*"+
//! seq  X      Y      theta v     rot   wheels L R  sonars L R  photo L R   flags   mode,    ack   CRC
//!                                                                                  layers
//! ```

use super::FieldError;
use super::columns::{Columns, Fields, bad};
use crate::letters::{Arm, Bump, Cliff, Drive, Infrared, Layer, LayerState, Link, Mode, Power};

/// Line A.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StateLine {
    /// X in tenths of an inch; whole inches from 1000 on, saturating at 99,999.
    pub x_tenths_in: i32,
    /// Y in tenths of an inch; whole inches from 1000 on, saturating at 99,999.
    pub y_tenths_in: i32,
    /// Heading, 0 to 359 degrees, clockwise from +Y.
    pub theta_deg: u16,
    /// Requested speed at the centre, in/s.
    pub velocity_in_s: i8,
    /// Requested difference between the wheels, left minus right, in/s.
    pub rotation_in_s: i8,
    /// Measured left wheel, in/s.
    pub wheel_left_in_s: i8,
    /// Measured right wheel, in/s.
    pub wheel_right_in_s: i8,
    /// Left sonar; `None` when no echo came back.
    pub sonar_left_in: Option<u16>,
    /// Right sonar; `None` when no echo came back.
    pub sonar_right_in: Option<u16>,
    /// Left photocell, per cent of full scale, 0 very bright; `None` when not fitted.
    pub photo_left_pct: Option<u8>,
    /// Right photocell, per cent of full scale, 0 very bright; `None` when not fitted.
    pub photo_right_pct: Option<u8>,
    /// Bumper.
    pub bump: Bump,
    /// Infrared detectors.
    pub infrared: Infrared,
    /// Floor edge sensors.
    pub cliff: Cliff,
    /// Servo arm and motion detectors.
    pub arm: Arm,
    /// Drive train and odometer.
    pub drive: Drive,
    /// Battery.
    pub power: Power,
    /// Receiver.
    pub link: Link,
    /// Commanded mode.
    pub mode: Mode,
    /// Layers 1 to 7.
    pub layers: LayerStates,
}

/// The states of layers 1 to 7, of which at most one holds the motors. Layer 0 has no column: it holds
/// them while [`Mode::User`] is on and no other layer does.
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

    /// Sets the state of a layer; layer 0 has none. The motors have one holder: whichever layer held
    /// them before is left raised.
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

    /// The layer that holds the motors; `None` when prowl or User does.
    #[must_use]
    pub fn holder(&self) -> Option<Layer> {
        Layer::ALL
            .into_iter()
            .find(|&layer| self.get(layer) == LayerState::Holds)
    }
}

impl StateLine {
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

    pub(super) fn read(c: &Fields) -> Result<Self, FieldError> {
        c.spaces(&[4, 11, 18, 22, 26, 30, 34, 38, 42, 46, 49, 52, 60, 69])?;
        let theta_deg = c.number::<3>(19)?;
        if theta_deg > 359 {
            return Err(bad(19));
        }
        Ok(Self {
            x_tenths_in: read_position(c, 5)?,
            y_tenths_in: read_position(c, 12)?,
            theta_deg: theta_deg as u16,
            velocity_in_s: c.signed_number::<2>(23)? as i8,
            rotation_in_s: c.signed_number::<2>(27)? as i8,
            wheel_left_in_s: c.signed_number::<2>(31)? as i8,
            wheel_right_in_s: c.signed_number::<2>(35)? as i8,
            sonar_left_in: c.maybe_number::<3>(39)?.map(|v| v as u16),
            sonar_right_in: c.maybe_number::<3>(43)?.map(|v| v as u16),
            photo_left_pct: c.maybe_number::<2>(47)?.map(|v| v as u8),
            photo_right_pct: c.maybe_number::<2>(50)?.map(|v| v as u8),
            bump: c.state(53, Bump::from_letter)?,
            infrared: c.state(54, Infrared::from_letter)?,
            cliff: c.state(55, Cliff::from_letter)?,
            arm: c.state(56, Arm::from_letter)?,
            drive: c.state(57, Drive::from_letter)?,
            power: c.state(58, Power::from_letter)?,
            link: c.state(59, Link::from_letter)?,
            mode: c.state(61, Mode::from_letter)?,
            layers: read_layers(c)?,
        })
    }
}

fn read_layers(c: &Fields) -> Result<LayerStates, FieldError> {
    let letters: [u8; 7] = c.at(62)?;
    let mut states = LayerStates::OFF;
    let mut holders = 0;
    for (i, (letter, state)) in letters.into_iter().zip(&mut states.0).enumerate() {
        let own = Layer::ALL[i + 1].letter();
        *state = match letter {
            b'.' => LayerState::Off,
            b'-' => LayerState::Quiet,
            _ if letter == own => LayerState::Holds,
            _ if letter == own.to_ascii_lowercase() => LayerState::Raised,
            _ => return Err(bad(62 + i)),
        };
        holders += u8::from(*state == LayerState::Holds);
        if holders > 1 {
            return Err(bad(62 + i));
        }
    }
    Ok(states)
}

/// `+123.4` below 1000 inches, `+12346` from there on.
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

fn read_position(c: &Fields, column: usize) -> Result<i32, FieldError> {
    let magnitude = if c.at(column + 4)? == *b"." {
        let (whole_in, tenths) = c.pair::<3, 1>(column + 1, b'.').map_err(|_| bad(column))?;
        whole_in * 10 + tenths
    } else {
        match c.number::<5>(column + 1) {
            Ok(whole_in @ 1000..) => whole_in * 10,
            _ => return Err(bad(column)),
        }
    };
    c.with_sign(column, magnitude as i32)
}
