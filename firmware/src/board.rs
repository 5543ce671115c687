//! What passes between the robot's program and the pins of its board.

/// Ticks a second.
pub const TICK_HZ: u32 = 20;

/// Infrared half cycles a second: the LEDs are modulated at half of this.
pub const INFRARED_LOOK_HZ: u32 = 250;

/// Encoder counts per inch of wheel travel: 251 a turn of a 5-inch wheel.
pub const COUNTS_PER_IN: i32 = 16;

/// Full pulse width, either way.
pub const PWM_MAX: i16 = 255;

/// What tells one robot from another, and one life of it from the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Identity {
    /// 1 to 99; the uplink's checksum is mixed with it.
    pub robot_id: u8,
    /// Counted up by the board in memory that survives a reset, before the first tick.
    pub boots: u16,
    /// Seed of the robot's own dice (a centre bump turns left or right at random).
    pub dice_seed: u32,
    /// Whether the radio lets both ends talk at once.
    pub duplex: Duplex,
}

/// Whether the radio lets both ends talk at once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Duplex {
    /// Both ends talk at the same time.
    #[default]
    Full,
    /// One end at a time: the robot says when it listens.
    Half {
        /// It talks on when it has heard nothing for so many byte times: the ground's delay, and whatever
        /// its modem adds both ways. [`PATIENCE_BYTES`] for a radio that passes bytes on at once.
        patience_bytes: u8,
    },
}

/// Patience with a half-duplex radio that passes bytes on at once.
pub const PATIENCE_BYTES: u8 = 16;

/// Left or right, as seen by the robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Left.
    Left,
    /// Right.
    Right,
}

/// What each side says.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sides {
    /// Left.
    pub left: bool,
    /// Right.
    pub right: bool,
}

impl Sides {
    /// Whether either does.
    #[must_use]
    pub const fn any(self) -> bool {
        self.left || self.right
    }

    /// What either of two said.
    #[must_use]
    pub const fn or(self, other: Self) -> Self {
        Self {
            left: self.left || other.left,
            right: self.right || other.right,
        }
    }
}

/// Edge sensors that see no floor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[expect(clippy::struct_excessive_bools, reason = "one a sensor")]
pub struct Edges {
    /// Ahead of the left wheel.
    pub left: bool,
    /// Under the middle of the bumper.
    pub center: bool,
    /// Ahead of the right wheel.
    pub right: bool,
    /// Behind the tail wheel or either drive wheel: these share an input.
    pub rear: bool,
}

impl Edges {
    /// Whether any does.
    #[must_use]
    pub const fn any(self) -> bool {
        self.left || self.center || self.right || self.rear
    }

    /// What either of two said.
    #[must_use]
    pub const fn or(self, other: Self) -> Self {
        Self {
            left: self.left || other.left,
            center: self.center || other.center,
            right: self.right || other.right,
            rear: self.rear || other.rear,
        }
    }
}

/// Bumper switches closed at this tick.
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
    /// Whether any is closed.
    #[must_use]
    pub const fn any(self) -> bool {
        self.left || self.center || self.right
    }
}

/// A finished sonar ping.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Echo {
    /// Which ranger pinged.
    pub side: Side,
    /// Distance of the first echo, 3 to 420 inches; `None` when none came back.
    pub range_in: Option<u16>,
}

/// Everything the robot senses in one tick. A sensor that is not fitted is `None`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Inputs {
    /// Encoder edges since the previous tick. Single-channel encoders do not know their direction.
    pub counts_left: u16,
    /// Encoder edges since the previous tick.
    pub counts_right: u16,
    /// Bumper switches.
    pub bumper: Switches,
    /// The ping that finished since the previous tick, if one did.
    pub sonar: Option<Echo>,
    /// Left photocell, 0 very bright to 255 dark.
    pub photo_left: Option<u8>,
    /// Right photocell, 0 very bright to 255 dark.
    pub photo_right: Option<u8>,
    /// Battery voltage in tenths of a volt.
    pub battery_dv: u8,
    /// Where the floor ends.
    pub cliff: Option<Edges>,
    /// The passive infrared detectors on the servo arm. While it is stowed they see the bumper.
    pub motion: Option<Sides>,
    /// The switch on the top of the arm: something is above it.
    pub top_hat: bool,
    /// The receivers that see the dock's infrared beacon: it is on that side, on both straight ahead.
    pub beacon: Option<Sides>,
    /// The charger's voltage is on the contacts.
    pub is_docked: bool,
    /// The timer found the previous tick not finished: this one begins late.
    pub is_late: bool,
}

/// Everything the robot does until the next tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Outputs {
    /// Left motor, [`PWM_MAX`] full forward to its negative full reverse.
    pub pwm_left: i16,
    /// Right motor.
    pub pwm_right: i16,
    /// Fire this ranger now; its [`Echo`] is due two ticks later.
    pub ping: Option<Side>,
    /// What the beeper sounds, in hertz; 0 is silence.
    pub note_hz: u16,
    /// The servo raises the arm with the motion detectors, or stows it.
    pub arm_up: bool,
    /// Write [`crate::robot::Robot::parameters`] to memory that survives a reset.
    pub keep_parameters: bool,
}
