//! Protobuf messages of a recording; their flat fields are also those of JSON lines and CSV.
//!
//! Each line of any type is one message. Its fields are flat, so plotting tools reach every value by one
//! short path. A field is present when the line contains it. `proto/groundwave.proto` declares the same messages for
//! other languages; a test keeps the two equal.

mod fill;

use groundwave_protocol::decoder::Received;

pub use super::estimate::{CorrectedMessage, EstimateMessage, FloorKind, FloorMessage};
pub use super::station_event::{StationEvent, StationEventKind};
pub use super::uplink_event::UplinkEvent;
pub(crate) use fill::line_type;

/// Bytes of a stream as they were read or sent.
#[derive(Clone, PartialEq, Eq, prost::Message)]
pub struct RawBytes {
    /// Number of bytes in the stream before `data`. A jump means that bytes are missing from the capture.
    #[prost(uint64, tag = 1)]
    pub stream_offset: u64,
    /// The bytes.
    #[prost(bytes = "vec", tag = 2)]
    pub data: Vec<u8>,
}

/// A time without lines.
#[derive(Clone, PartialEq, Eq, prost::Message)]
pub struct OutageMessage {
    /// A code of [`OutageCause`](crate::event::OutageCause).
    #[prost(string, tag = 1)]
    pub code: String,
    /// Beginning of the outage, nanoseconds since 1970.
    #[prost(uint64, tag = 2)]
    pub begin_ns: u64,
    /// End of the outage, nanoseconds since 1970; `None` while it lasts.
    #[prost(uint64, optional, tag = 3)]
    pub end_ns: Option<u64>,
    /// Minimum number of lines lost in the outage.
    #[prost(uint64, tag = 4)]
    pub lines_lost: u64,
    /// Maximum number of lines lost in the outage; `None` if no clock shows it.
    #[prost(uint64, optional, tag = 5)]
    pub lines_lost_max: Option<u64>,
}

impl From<&Received> for Telemetry {
    fn from(received: &Received) -> Self {
        let mut message = Self::default();
        fill::fill(received, &mut message);
        message
    }
}

/// One value of a [`Telemetry`] message.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value<'a> {
    /// A whole number.
    Integer(i64),
    /// A number with tenths.
    Decimal(f64),
    /// A state, in lower case with underscores.
    Word(&'static str),
    /// Text from the robot.
    Text(&'a str),
}

/// A field of [`Telemetry`] as `proto/groundwave.proto` must declare it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Field {
    /// Name in MCAP, JSON and CSV.
    pub name: &'static str,
    /// Protobuf tag; never changes.
    pub tag: u32,
    /// The protobuf type; `int32` for states.
    pub kind: &'static str,
    /// Names of the states 0, 1, 2, ...; empty for numbers and text.
    pub words: &'static [&'static str],
}

/// Rust types of the protobuf types in use.
#[expect(non_camel_case_types, reason = "protobuf's own names")]
mod kind {
    pub type double = f64;
    pub type int32 = i32;
    pub type sint32 = i32;
    pub type string = String;
    pub type uint32 = u32;
}

trait ToValue {
    fn value(&self, words: &'static [&'static str]) -> Value<'_>;
}

impl ToValue for i32 {
    fn value(&self, words: &'static [&'static str]) -> Value<'_> {
        match usize::try_from(*self).ok().and_then(|i| words.get(i)) {
            Some(word) => Value::Word(word),
            None => Value::Integer((*self).into()),
        }
    }
}

impl ToValue for u32 {
    fn value(&self, _: &'static [&'static str]) -> Value<'_> {
        Value::Integer((*self).into())
    }
}

impl ToValue for f64 {
    fn value(&self, _: &'static [&'static str]) -> Value<'_> {
        Value::Decimal(*self)
    }
}

impl ToValue for String {
    fn value(&self, _: &'static [&'static str]) -> Value<'_> {
        Value::Text(self)
    }
}

macro_rules! telemetry {
    ($($(#[$doc:meta])+ $tag:tt $name:ident: $kind:ident $(of $words:ident)?;)+) => {
        /// The content of a line from the robot.
        #[derive(Clone, PartialEq, prost::Message)]
        pub struct Telemetry {
            $($(#[$doc])+ #[prost($kind, optional, tag = $tag)] pub $name: Option<kind::$kind>,)+
        }

        impl Telemetry {
            /// All fields, in the order of [`Self::for_each`].
            pub const FIELDS: &[Field] = &[$(Field {
                name: stringify!($name),
                tag: $tag,
                kind: stringify!($kind),
                words: telemetry!(@words $($words)?),
            }),+];

            /// Calls `take` with the name and the value of every field; the value is `None` where the line does not
            /// contain the field.
            ///
            /// # Errors
            /// The first error of `take`.
            pub fn for_each<E>(
                &self,
                mut take: impl FnMut(&'static str, Option<Value<'_>>) -> Result<(), E>,
            ) -> Result<(), E> {
                $(take(
                    stringify!($name),
                    self.$name.as_ref().map(|value| value.value(telemetry!(@words $($words)?))),
                )?;)+
                Ok(())
            }
        }
    };
    (@words) => { &[] };
    (@words $words:ident) => { $words };
}

pub(crate) const LINE_TYPES: &[&str] = &["A", "B", "C", "T", "K", "P", "S", "I", "F", "V"];
const OUTCOMES: &[&str] = &[
    "done",
    "not_fitted",
    "bad_value",
    "list_incomplete",
    "digest_mismatch",
    "not_now",
    "unknown",
    "failed",
];
const BUMPS: &[&str] = &[
    "none",
    "left",
    "center",
    "right",
    "left_center",
    "right_center",
    "sides",
    "all",
    "jammed",
    "not_fitted",
];
const INFRARED: &[&str] = &["none", "left", "right", "both", "jammed", "not_fitted"];
const CLIFFS: &[&str] = &["none", "left", "center", "right", "several", "not_fitted"];
const ARMS: &[&str] = &[
    "stowed",
    "up",
    "armed",
    "motion_left",
    "motion_right",
    "motion_both",
    "top_hat",
    "not_fitted",
];
const DRIVES: &[&str] = &[
    "ok",
    "saturated",
    "stalled",
    "odometer_reset",
    "out_of_range",
];
const POWERS: &[&str] = &["ok", "low", "critical", "docked", "charging"];
const LINKS: &[&str] = &["ok", "armed", "failsafe"];
const MODES: &[&str] = &[
    "prowl",
    "reactive",
    "passive",
    "stop",
    "user",
    "wander",
    "go_home",
    "forage",
    "calibrate",
];
const LAYER_STATES: &[&str] = &["off", "quiet", "raised", "holds"];
const LAYERS: &[&str] = &[
    "user",
    "bumpers",
    "rotation",
    "infrared",
    "sonar",
    "photo",
    "motion",
    "dead_reckoning",
];

telemetry! {
    /// Type of the line: A state, B status, C counters, T text, K acknowledgement, P parameter, S song, I abilities, F field, V values.
    1 line_type: int32 of LINE_TYPES;
    /// Number of the line, 0 to 99.
    2 sequence: uint32;
    /// Low 3 bits of the boot counter.
    3 ack_boot: uint32;
    /// Session, 1 to 7 in turn; 0 before the first.
    4 ack_session: uint32;
    /// Sequence of the latest command that the robot took, low 3 bits.
    5 ack_sequence: uint32;
    /// Outcome of the latest command.
    6 ack_outcome: int32 of OUTCOMES;
    /// Nonce of the session's owner; absent while a list is being staged.
    7 ack_owner: uint32;
    /// Number of the robot, 1 to 99; absent while a list is being staged.
    8 ack_robot_id: uint32;
    /// First block of the staged list that has not arrived.
    9 ack_first_missing_block: uint32;
    /// Bit n: block first missing + 1 + n has arrived.
    10 ack_window_bits: uint32;
    /// Low 2 bits of the tag of the list being staged.
    11 ack_list_tag: uint32;

    /// X, inches; positive right of the start.
    12 x_in: double;
    /// Y, inches; positive ahead of the start.
    13 y_in: double;
    /// Heading, degrees clockwise from +Y.
    14 theta_deg: uint32;
    /// Requested speed at the centre, in/s.
    15 velocity_in_s: sint32;
    /// Requested difference between the wheels, left minus right, in/s.
    16 rotation_in_s: sint32;
    /// Measured speed of the left wheel, in/s.
    17 wheel_left_in_s: sint32;
    /// Measured speed of the right wheel, in/s.
    18 wheel_right_in_s: sint32;
    /// Distance of the left sonar, inches; absent without an echo.
    19 sonar_left_in: uint32;
    /// Distance of the right sonar, inches; absent without an echo.
    20 sonar_right_in: uint32;
    /// Left photocell, per cent of full scale, 0 very bright.
    21 photo_left_pct: uint32;
    /// Right photocell, per cent of full scale, 0 very bright.
    22 photo_right_pct: uint32;
    /// State of the bumper switches.
    23 bump: int32 of BUMPS;
    /// State of the infrared detectors.
    24 infrared: int32 of INFRARED;
    /// State of the floor edge sensors.
    25 cliff: int32 of CLIFFS;
    /// State of the servo arm and of the motion detectors.
    26 arm: int32 of ARMS;
    /// State of drive train and odometer.
    27 drive: int32 of DRIVES;
    /// State of the battery.
    28 power: int32 of POWERS;
    /// State of the robot's receiver.
    29 link: int32 of LINKS;
    /// Commanded mode.
    30 mode: int32 of MODES;
    /// State of layer 1, bumpers.
    31 layer_bumpers: int32 of LAYER_STATES;
    /// State of layer 2, rotation.
    32 layer_rotation: int32 of LAYER_STATES;
    /// State of layer 3, infrared.
    33 layer_infrared: int32 of LAYER_STATES;
    /// State of layer 4, sonar.
    34 layer_sonar: int32 of LAYER_STATES;
    /// State of layer 5, photo.
    35 layer_photo: int32 of LAYER_STATES;
    /// State of layer 6, motion.
    36 layer_motion: int32 of LAYER_STATES;
    /// State of layer 7, dead reckoning.
    37 layer_dead_reckoning: int32 of LAYER_STATES;
    /// Layer that controls the motors; absent while prowl or User controls them.
    38 holder: int32 of LAYERS;

    /// Number of the robot, 1 to 99.
    39 robot_id: uint32;
    /// Battery voltage, volts.
    40 battery_v: double;
    /// X of the point that the robot drives to, inches.
    41 target_x_in: sint32;
    /// Y of the point that the robot drives to, inches.
    42 target_y_in: sint32;
    /// Number of waypoints of the active list that have been reached.
    43 waypoints_driven: uint32;
    /// Number of waypoints in the active list.
    44 waypoints_count: uint32;
    /// Digest of the active list.
    45 list_digest: uint32;
    /// Current threshold of the infrared layer.
    46 max_count: uint32;
    /// Left photocell, 0 very bright to 255 dark.
    47 photo_left_raw: uint32;
    /// Right photocell, 0 very bright to 255 dark.
    48 photo_right_raw: uint32;
    /// Bit n: the firmware has layer n.
    49 layers_fitted_bits: uint32;
    /// Bit n: layer n is allowed.
    50 layers_allowed_bits: uint32;
    /// Boot counter, modulo 1000.
    51 boots: uint32;
    /// Odometer resets since boot, modulo 100.
    52 odometer_resets: uint32;

    /// Time since boot by the robot's clock, seconds, modulo 1,000,000.
    53 uptime_s: uint32;
    /// Firmware version before the point.
    54 firmware_major: uint32;
    /// Firmware version after the point.
    55 firmware_minor: uint32;
    /// Number of ticks (20 Hz) since boot in which layer 0 controlled the motors, modulo 4096.
    56 ticks_won_user: uint32;
    /// Number of ticks in which layer 1 controlled the motors.
    57 ticks_won_bumpers: uint32;
    /// Number of ticks in which layer 2 controlled the motors.
    58 ticks_won_rotation: uint32;
    /// Number of ticks in which layer 3 controlled the motors.
    59 ticks_won_infrared: uint32;
    /// Number of ticks in which layer 4 controlled the motors.
    60 ticks_won_sonar: uint32;
    /// Number of ticks in which layer 5 controlled the motors.
    61 ticks_won_photo: uint32;
    /// Number of ticks in which layer 6 controlled the motors.
    62 ticks_won_motion: uint32;
    /// Number of ticks in which layer 7 controlled the motors.
    63 ticks_won_dead_reckoning: uint32;
    /// Number of ticks in which prowl controlled the motors.
    64 ticks_won_prowl: uint32;
    /// Intact uplink frames since boot, modulo 1000.
    65 frames_heard: uint32;
    /// Uplink frames rejected since boot, modulo 1000.
    66 frames_rejected: uint32;
    /// Ticks that began late since boot, modulo 1000.
    67 ticks_late: uint32;
    /// Bumper contacts since boot, modulo 10,000.
    68 bumps: uint32;

    /// A line of text from the robot's program.
    69 text: string;

    /// Silence of the ground station that triggers the failsafe, seconds; absent when the failsafe is off.
    70 failsafe_silence_s: uint32;
    /// Mode that the failsafe enters.
    71 failsafe_mode: int32 of MODES;

    /// Number of the parameter in the robot's table, from 1.
    72 parameter_place: uint32;
    /// Number of parameters of the robot.
    73 parameter_count: uint32;
    /// Name of the parameter.
    74 parameter_name: string;
    /// Current value.
    75 parameter_value: sint32;
    /// Saved value, which a reset restores.
    76 parameter_kept: sint32;
    /// Minimum value.
    77 parameter_least: sint32;
    /// Maximum value.
    78 parameter_most: sint32;
    /// Unit of the value.
    79 parameter_unit: string;
    /// Notes of a song that begins, `Hz:seconds` each, separated by spaces; 0 Hz is a rest.
    80 song: string;

    /// Level of the robot's abilities, 1 to 5.
    81 level: uint32;
    /// Maximum number of waypoints in a list.
    82 list_capacity: uint32;
    /// Letters of the robot's modes.
    83 modes_fitted: string;
    /// Letters of the readings that the robot has: B battery, W wheels, S sonars, I `max_count`.
    84 measured: string;
    /// Maximum number of bytes per second that the robot accepts.
    85 rate_bytes_per_s: uint32;
    /// Number of the robot's own fields; their values are on /values.
    86 own_fields: uint32;
}

#[cfg(test)]
mod tests {
    use super::*;
    use groundwave_protocol::status_codes::{
        Arm, Bump, Cliff, Drive, Infrared, Layer, LayerState, Link, Mode, Power,
    };
    use groundwave_protocol::telemetry::{LineType, Outcome};
    use std::fmt::Debug;

    /// Names of enum values in snake case: `LeftCenter` becomes `left_center`.
    fn words<T: Debug>(all: &[T]) -> Vec<String> {
        let word = |state: &T| {
            let mut word = String::new();
            for c in format!("{state:?}").chars() {
                if c.is_uppercase() && !word.is_empty() {
                    word.push('_');
                }
                word.extend(c.to_lowercase());
            }
            word
        };
        all.iter().map(word).collect()
    }

    #[test]
    fn every_state_of_the_wire_has_its_word() {
        // Recordings hold the places of these letters, so new ones go to the end.
        assert_eq!(LINE_TYPES.concat(), "ABCTKPSIFV");
        for line_type in LineType::ALL {
            let letter = char::from(line_type.letter()).to_string();
            assert!(LINE_TYPES.contains(&letter.as_str()), "{line_type:?}");
        }
        assert_eq!(BUMPS, words(Bump::ALL));
        assert_eq!(INFRARED, words(Infrared::ALL));
        assert_eq!(CLIFFS, words(Cliff::ALL));
        assert_eq!(ARMS, words(Arm::ALL));
        assert_eq!(DRIVES, words(Drive::ALL));
        assert_eq!(POWERS, words(Power::ALL));
        assert_eq!(LINKS, words(Link::ALL));
        assert_eq!(MODES, words(Mode::ALL));
        assert_eq!(LAYER_STATES, words(LayerState::ALL));
        assert_eq!(LAYERS, words(&Layer::ALL));
        let outcomes = [
            Outcome::Done,
            Outcome::NotFitted,
            Outcome::BadValue,
            Outcome::ListIncomplete,
            Outcome::DigestMismatch,
            Outcome::NotNow,
            Outcome::Unknown,
            Outcome::Failed,
        ];
        assert_eq!(OUTCOMES, words(&outcomes));
        assert!(outcomes.iter().enumerate().all(|(i, &o)| o as usize == i));
    }
}
