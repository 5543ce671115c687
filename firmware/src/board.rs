//! Interface between the robot's program and the pins of its board.
//!
//! Rules for a board:
//!
//! 1. One clock of [`BASE_HZ`] times everything: an infrared look every [`BASE_PER_LOOK`] periods, a tick every
//!    [`BASE_PER_TICK`]. A tick has 12.5 looks, so 12 and 13 alternate. A look that falls into a tick may come late, but
//!    none is left out: the half cycle before it only lasts longer.
//! 2. A tick that could not begin in its period has [`Inputs::is_late`] set.
//! 3. [`crate::robot::Robot::poll_downlink`] is called once per byte time, idle ones included, so the board has a clock of
//!    byte times. The transmitter holds one byte of slack: a call may come up to a byte time late without a gap.
//! 4. The robot is created in its static: `place.write(Robot::restored(...))` in a function of its own, since a second
//!    robot does not fit on the stack.
//! 5. A watchdog resets a board that misses its ticks. Each reset switches the motors off in hardware: pull-down resistors
//!    hold the inputs of the motor driver while the pins float.
//! 6. A panic switches the motors off at once, notes itself in memory that survives a reset, and resets the board.
//!    The reason of the reset is in [`Identity::restart`], and the robot tells it in a line T.
//! 7. Brown-out detection is on, since a processor below its voltage may write anything into its EEPROM. Parameters and
//!    boot counter are kept as [`crate::memory`] describes: power lost at any moment leaves the old or the new ones.

use groundwave_protocol::status_codes::LayerMask;

/// Number of ticks per second.
pub const TICK_HZ: u32 = 20;

/// Infrared half cycles per second: the LEDs are modulated at half of this rate.
pub const INFRARED_SAMPLE_HZ: u32 = 250;

/// Periods of a board's clock per second, from which ticks and looks are counted.
pub const BASE_HZ: u32 = 500;

/// Periods of the clock from one tick to the next.
pub const BASE_PER_TICK: u8 = (BASE_HZ / TICK_HZ) as u8;

/// Periods of the clock from one infrared look to the next.
pub const BASE_PER_LOOK: u8 = (BASE_HZ / INFRARED_SAMPLE_HZ) as u8;

/// Encoder counts per inch of wheel travel: 251 per turn of a 5-inch wheel. [`CountScaler`] makes them from others.
pub const COUNTS_PER_IN: i32 = 16;

/// Maximum pulse width in either direction.
pub const PWM_MAX: i16 = 255;

/// Microseconds in which sound goes an inch and back, at 20 degrees Celsius.
pub const ECHO_US_PER_IN: u32 = 148;

/// Least range of an echo in inches.
pub const RANGE_LEAST_IN: u16 = 3;
/// Most range of an echo in inches.
pub const RANGE_MOST_IN: u16 = 420;

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
    /// Layers whose sensors are wired. Photocells and motion detectors that are missing show in [`Inputs`], too.
    pub fitted: LayerMask,
    /// Reason of the boot.
    pub restart: Restart,
}

impl Identity {
    /// A robot with every sensor that was switched on.
    #[must_use]
    pub const fn new(robot_id: u8, boots: u16, rng_seed: u32, duplex: Duplex) -> Self {
        Self {
            robot_id,
            boots,
            rng_seed,
            duplex,
            fitted: LayerMask::ALL,
            restart: Restart::PowerOn,
        }
    }
}

/// Reason of a boot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Restart {
    /// Switched on, or reset by hand.
    #[default]
    PowerOn,
    /// The supply was below the processor's voltage.
    BrownOut,
    /// The program missed its ticks.
    Watchdog,
    /// The program panicked.
    Panic,
}

impl Restart {
    /// Text for the ground station; `None` if there is nothing to tell.
    #[must_use]
    pub const fn text(self) -> Option<&'static str> {
        match self {
            Self::PowerOn => None,
            Self::BrownOut => Some("restarted: the supply voltage was too low"),
            Self::Watchdog => Some("restarted: the watchdog found the program stuck"),
            Self::Panic => Some("restarted: the program panicked"),
        }
    }
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
        /// delay both ways: [`PATIENCE_BYTES`] or [`HC_12_PATIENCE_BYTES`].
        patience_bytes: u8,
    },
}

/// Patience on a half-duplex radio that transmits bytes without delay.
pub const PATIENCE_BYTES: u8 = 16;

/// Patience behind HC-12 modules. They collect 60 bytes and send them for an eighth of a second, so more than half a
/// second passes between the robot's last byte and the first byte of a long answer.
pub const HC_12_PATIENCE_BYTES: u8 = 160;

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

impl Echo {
    /// The result of a ping whose echo came back after a delay; `None` without an echo. Inches are rounded, and a nearer
    /// obstacle is at the least range.
    #[must_use]
    pub const fn after_us(side: Side, delay_us: Option<u32>) -> Self {
        let range_in = match delay_us {
            Some(delay_us) => {
                let range_in = delay_us.saturating_add(ECHO_US_PER_IN / 2) / ECHO_US_PER_IN;
                if range_in > RANGE_MOST_IN as u32 {
                    None
                } else if range_in < RANGE_LEAST_IN as u32 {
                    Some(RANGE_LEAST_IN)
                } else {
                    Some(range_in as u16)
                }
            }
            None => None,
        };
        Self { side, range_in }
    }
}

/// Scales the edges of a wheel's encoder to [`COUNTS_PER_IN`]; no part of an edge is lost.
#[derive(Clone, Debug)]
pub struct CountScaler {
    /// Counts per edge in 1/256.
    per_edge: u16,
    /// Part of a count left over, in 1/256.
    rest: u8,
}

impl CountScaler {
    /// For a wheel of this diameter in 1/1000 inch with this number of edges per turn, at least 1. The parameters
    /// `wheel-left` and `wheel-right` then correct the diameter: 5000 means exactly the one given here.
    #[must_use]
    pub const fn new(edges_per_turn: u16, diameter_in_1000: u16) -> Self {
        // Pi times 16 counts an inch times 256, per 1000.
        const PER_DIAMETER: u32 = 12_868;
        let counts = diameter_in_1000 as u32 * PER_DIAMETER / 1000;
        let per_edge = (counts + edges_per_turn as u32 / 2) / edges_per_turn as u32;
        Self {
            per_edge: if per_edge > u16::MAX as u32 {
                u16::MAX
            } else {
                per_edge as u16
            },
            rest: 0,
        }
    }

    /// Counts of these edges.
    pub fn counts(&mut self, edges: u16) -> u16 {
        let all = u32::from(edges) * u32::from(self.per_edge) + u32::from(self.rest);
        self.rest = all as u8;
        u16::try_from(all >> 8).unwrap_or(u16::MAX)
    }
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

const _: () =
    assert!(BASE_HZ.is_multiple_of(TICK_HZ) && BASE_HZ.is_multiple_of(INFRARED_SAMPLE_HZ));

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_echo_has_its_range_in_inches() {
        let range_in = |delay_us| Echo::after_us(Side::Left, delay_us).range_in;
        assert_eq!(range_in(None), None);
        assert_eq!(range_in(Some(100)), Some(3), "nearer than the least range");
        assert_eq!(range_in(Some(1480)), Some(10));
        assert_eq!(range_in(Some(1480 + 73)), Some(10));
        assert_eq!(range_in(Some(1480 + 74)), Some(11));
        assert_eq!(range_in(Some(420 * 148)), Some(420));
        assert_eq!(range_in(Some(421 * 148)), None);
        assert_eq!(range_in(Some(u32::MAX)), None);
    }

    #[test]
    fn scaled_counts_are_sixteen_an_inch() {
        let mut nominal = CountScaler::new(251, 5000);
        assert_eq!(
            [0, 1, 16, 255].map(|edges| nominal.counts(edges)),
            [0, 1, 16, 255]
        );
        // A wheel of 65 mm with a disc of 20 slots goes 8.04 inches a turn.
        let mut small = CountScaler::new(40, 2559);
        let counts: u16 = (0..400).map(|edge| small.counts(edge % 2 * 2)).sum();
        assert!((1284..=1288).contains(&counts), "ten turns have {counts}");
        assert_eq!(CountScaler::new(1, u16::MAX).counts(u16::MAX), u16::MAX);
    }
}
