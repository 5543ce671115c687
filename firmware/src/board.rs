//! Interface between the robot's program and the pins of its board.

/// Number of ticks per second.
pub const TICK_HZ: u32 = 20;

/// Infrared half cycles per second: the LEDs are modulated at half of this rate.
pub const INFRARED_SAMPLE_HZ: u32 = 250;

/// Encoder counts per inch of wheel travel: 251 per turn of a 5-inch wheel.
pub const COUNTS_PER_IN: i32 = 16;

/// Maximum pulse width in either direction.
pub const PWM_MAX: i16 = 255;

/// Identity of a robot and of its current boot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Identity {
    /// Robot number, 1 to 99; the checksum of the uplink includes it.
    pub robot_id: u8,
    /// Boot counter, incremented by the board in memory that survives a reset.
    pub boots: u16,
    /// Seed of the robot's random numbers (a centre bump turns left or right at random).
    pub rng_seed: u32,
    /// Whether both ends of the radio can send at the same time.
    pub duplex: Duplex,
}

/// Whether both ends of the radio can send at the same time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Duplex {
    /// Both ends can send at the same time.
    #[default]
    Full,
    /// One end sends at a time; the robot announces when it listens.
    Half {
        /// Byte times of silence after which the robot sends again: the ground station's delay and the modem's
        /// delay both ways. [`PATIENCE_BYTES`] for a radio that transmits bytes without delay.
        patience_bytes: u8,
    },
}

/// Patience on a half-duplex radio that transmits bytes without delay.
pub const PATIENCE_BYTES: u8 = 16;

/// Left or right, as seen from the robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Signal on the left.
    Left,
    /// Signal on the right.
    Right,
}

/// A signal on each side.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sides {
    /// Signal on the left.
    pub left: bool,
    /// Signal on the right.
    pub right: bool,
}

impl Sides {
    /// Whether either side has the signal.
    #[must_use]
    pub const fn any(self) -> bool {
        self.left || self.right
    }

    /// The signals of both, combined.
    #[must_use]
    pub const fn or(self, other: Self) -> Self {
        Self {
            left: self.left || other.left,
            right: self.right || other.right,
        }
    }
}

/// Edge sensors that detect no floor: a ring around the body, wired to eight inputs. Each input joins one to four
/// sensors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Edges(u8);

impl Edges {
    /// No missing floor.
    pub const NONE: Self = Self(0);
    /// Below the middle of the bumper.
    pub const AHEAD: Self = Self(1);
    /// Ahead of the left wheel.
    pub const AHEAD_LEFT: Self = Self(1 << 1);
    /// Ahead of the right wheel.
    pub const AHEAD_RIGHT: Self = Self(1 << 2);
    /// Outside the left wheel.
    pub const BESIDE_LEFT: Self = Self(1 << 3);
    /// Outside the right wheel.
    pub const BESIDE_RIGHT: Self = Self(1 << 4);
    /// Behind the caster.
    pub const BEHIND: Self = Self(1 << 5);
    /// The sensors from the left of the caster to behind the left wheel.
    pub const BEHIND_LEFT: Self = Self(1 << 6);
    /// The sensors from the right of the caster to behind the right wheel.
    pub const BEHIND_RIGHT: Self = Self(1 << 7);
    /// No floor anywhere.
    pub const ALL: Self = Self(u8::MAX);
    /// The three inputs of the front.
    pub const FRONT: Self = Self::AHEAD.or(Self::AHEAD_LEFT).or(Self::AHEAD_RIGHT);
    /// The three inputs of the rear.
    pub const REAR: Self = Self::BEHIND.or(Self::BEHIND_LEFT).or(Self::BEHIND_RIGHT);

    /// The inputs with these bits.
    #[must_use]
    pub const fn from_bits(bits: u8) -> Self {
        Self(bits)
    }

    /// One bit per input.
    #[must_use]
    pub const fn bits(self) -> u8 {
        self.0
    }

    /// Whether any sensor detects no floor.
    #[must_use]
    pub const fn any(self) -> bool {
        self.0 != 0
    }

    /// Whether any of these inputs detects no floor.
    #[must_use]
    pub const fn meets(self, inputs: Self) -> bool {
        self.0 & inputs.0 != 0
    }

    /// The edges of both, combined.
    #[must_use]
    pub const fn or(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

/// Bumper switches closed at a tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Switches {
    /// Left pair.
    pub left: bool,
    /// Centre pair.
    pub center: bool,
    /// Right pair.
    pub right: bool,
}

impl Switches {
    /// Whether any switch is closed.
    #[must_use]
    pub const fn any(self) -> bool {
        self.left || self.center || self.right
    }
}

/// Result of a sonar ping.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Echo {
    /// Ranger that pinged.
    pub side: Side,
    /// Distance of the first echo, 3 to 420 inches; `None` without an echo.
    pub range_in: Option<u16>,
}

/// Sensor readings of one tick. A sensor that is not fitted is `None`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Inputs {
    /// Left encoder edges since the previous tick. Single-channel encoders do not show the direction.
    pub counts_left: u16,
    /// Right encoder edges since the previous tick.
    pub counts_right: u16,
    /// Bumper switches.
    pub bumper: Switches,
    /// Ping that finished since the previous tick.
    pub sonar: Option<Echo>,
    /// Left photocell, 0 very bright to 255 dark.
    pub photo_left: Option<u8>,
    /// Right photocell, 0 very bright to 255 dark.
    pub photo_right: Option<u8>,
    /// Battery voltage in tenths of a volt.
    pub battery_dv: u8,
    /// Edge sensors that detect no floor.
    pub cliff: Option<Edges>,
    /// Passive infrared detectors on the servo arm. A stowed arm hides them behind the bumper.
    pub motion: Option<Sides>,
    /// Whether the switch on top of the arm is pressed.
    pub top_hat: bool,
    /// Receivers that detect the dock's infrared beacon; both when it is straight ahead.
    pub beacon: Option<Sides>,
    /// Whether the charger's voltage is on the contacts.
    pub is_docked: bool,
    /// Whether this tick begins late because the previous one had not finished.
    pub is_late: bool,
}

/// Outputs of the robot until the next tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Outputs {
    /// Left motor, from [`PWM_MAX`] full forward to its negative full reverse.
    pub pwm_left: i16,
    /// Right motor, from [`PWM_MAX`] full forward to its negative full reverse.
    pub pwm_right: i16,
    /// Ranger to ping at once; its [`Echo`] is due two ticks later.
    pub ping: Option<Side>,
    /// Tone of the beeper in hertz; 0 is silence.
    pub note_hz: u16,
    /// Whether the servo raises the arm with the motion detectors.
    pub arm_up: bool,
    /// Whether to write [`crate::robot::Robot::parameters`] to memory that survives a reset.
    pub keep_parameters: bool,
}
