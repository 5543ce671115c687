//! Layer 1: the bumper reflex, its escapes, and working free from a jam.
//!
//! An obstacle that holds the robot without closing a switch also counts as a contact, such as the edge of the dock,
//! which is lower than the bumper: the wheels detect it.

use super::behaviour::Behaviour;
use crate::angle::Angle;
use crate::arbiter::Request;
use crate::board::{COUNTS_PER_IN, Side, Switches};
use crate::drive::Motion;
use crate::parameters::Parameter;
use crate::sensors::Senses;
use crate::units::ticks;

/// Distance of backing up, in counts of both wheels: 6 inches clear the bumper and leave room to turn.
const BACK_COUNTS: i16 = 6 * COUNTS_PER_IN as i16 * 2;

/// Backing up at two thirds of top speed, to hit obstacles behind less hard.
const BACK: Motion = Motion::new(-8, 0);

/// Maximum duration of backing up, which takes a second unless it is blocked.
const BACK_TICKS: u8 = 2 * ticks(1) as u8;

/// Turning speed on the spot, 92 degrees per second.
const TURN_IN_S: i16 = 16;

/// Minimum turn away from a glancing contact, 15 degrees; a random part of up to as much is added. A wider turn would
/// lead into the opposite wall of a passage. Also the turn from the edge of an opening, a contact beside which sonar sees
/// open floor.
const GLANCING_TURN: u16 = 0x0b00;

/// Minimum turn away from a contact with the centre switch, or without a switch: 90 degrees.
const FRONTAL_TURN: u16 = 0x4000;

/// Turn of an escape: half a turn.
const ESCAPE_TURN: u16 = 0x8000;

/// Angle by which the slew limit extends a turn, about 15 degrees.
const OVERRUN: u16 = (0x1_0000_u32 / 24) as u16;

/// Number of ticks until the wheels have stopped after a turn. Driving on at once would widen the turn by 20 degrees, because the slew
/// limit needs longer from reverse to top speed than from reverse to standing.
const SETTLE_TICKS: u8 = 8;

/// Maximum duration of a turn; a tick per 512th of a half turn is added. A longer turn is blocked.
const TURN_TICKS: u8 = 30;

/// Number of remembered contacts.
const MEMORY: usize = 5;

/// Maximum time of the contacts right, left, right, left that indicate an inside corner.
const CORNER_TICKS: u32 = ticks(15) as u32;

/// Maximum time of the remembered contacts that count as caught, without progress.
const CAUGHT_TICKS: u32 = ticks(20) as u32;

/// Minimum distance from the first of these contacts that counts as progress, inches.
const PROGRESS_IN: i32 = 12;

/// Number of ticks after which a closed switch is jammed.
const JAM_TICKS: u8 = ticks(3) as u8;

/// Twisting and rocking motions, each with its number of ticks.
const JAM_SEQUENCE: [(Motion, u8); 8] = [
    (Motion::new(-6, 0), 20),
    (Motion::new(0, 12), 14),
    (Motion::new(0, -12), 28),
    (Motion::new(6, 0), 10),
    (Motion::new(-12, 0), 16),
    (Motion::new(0, 20), 24),
    (Motion::new(10, -6), 10),
    (Motion::new(-10, -6), 30),
];

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum State {
    #[default]
    Quiet,
    /// Backs up before a turn.
    Back {
        turn: i32,
        path_counts: i16,
        ticks_left: u8,
    },
    /// Turns away.
    Turn {
        left: i32,
        heading: Angle,
        ticks_left: u8,
    },
    /// Comes to rest after the turn.
    Settle { ticks_left: u8 },
    /// Works free.
    Jam { step: u8, ticks: u8 },
}

/// A contact: its time, position and side.
#[derive(Clone, Copy, Debug)]
struct Contact {
    at_ticks: u32,
    x_in: i16,
    y_in: i16,
    side: Option<Side>,
}

/// State of the bumper layer.
#[derive(Clone, Debug, Default)]
pub struct Bumpers {
    state: State,
    held_ticks: u8,
    /// Latest contacts, newest first.
    contacts: [Option<Contact>; MEMORY],
    pressed_before: bool,
}

impl Bumpers {
    /// Whether the jam sequence is running.
    #[must_use]
    pub const fn is_jammed(&self) -> bool {
        matches!(self.state, State::Jam { .. })
    }

    /// Drops the positions of contacts, because the odometer has been set.
    pub fn forget_places(&mut self) {
        self.contacts = [None; MEMORY];
    }

    /// Begins the manoeuvre of a contact: backing up, then turning, independent of the sensors.
    fn begin(&mut self, senses: &Senses) {
        let side = side(senses.bumper);
        self.remember(senses, side);
        let (open, blocked) = (senses.sonar.open(), senses.sonar.blocked());
        let open_side = match (open.left && blocked.right, blocked.left && open.right) {
            (true, _) => Some(Side::Left),
            (_, true) => Some(Side::Right),
            _ => None,
        };
        let away = match (side, open_side) {
            (Some(Side::Left), _) | (None, Some(Side::Right)) => 1,
            (None, None) if senses.random & 1 == 0 => 1,
            (Some(Side::Right) | None, _) => -1,
        };
        let is_edge = open_side.is_some() || side.is_some() && open.any();
        let is_glancing = senses.bumper.any() && (!senses.bumper.center || is_edge);
        let escapes = senses.parameters.is_on(Parameter::Escapes);
        let angle = if escapes && (self.is_corner() || self.is_caught()) {
            self.forget_places();
            ESCAPE_TURN
        } else {
            let least = if is_glancing {
                GLANCING_TURN
            } else {
                FRONTAL_TURN
            };
            // Bits not used for choosing the side.
            least + (senses.random >> 8) as u16 % least
        };
        self.state = State::Back {
            turn: away * i32::from(angle - OVERRUN),
            path_counts: 0,
            ticks_left: BACK_TICKS,
        };
    }

    fn remember(&mut self, senses: &Senses, side: Option<Side>) {
        self.contacts.rotate_right(1);
        if let Some(newest) = self.contacts.first_mut() {
            *newest = Some(Contact {
                at_ticks: senses.now_ticks,
                x_in: (senses.pose.x_tenths_in() / 10) as i16,
                y_in: (senses.pose.y_tenths_in() / 10) as i16,
                side,
            });
        }
    }

    /// Whether the contacts alternated between right and left.
    fn is_corner(&self) -> bool {
        let [Some(newest), Some(second), Some(third), Some(fourth), _] = self.contacts else {
            return false;
        };
        let alternates = |a: Contact, b: Contact| {
            matches!(
                (a.side, b.side),
                (Some(Side::Left), Some(Side::Right)) | (Some(Side::Right), Some(Side::Left))
            )
        };
        alternates(newest, second)
            && alternates(second, third)
            && alternates(third, fourth)
            && newest.at_ticks.wrapping_sub(fourth.at_ticks) <= CORNER_TICKS
    }

    /// Whether there were too many contacts without progress.
    fn is_caught(&self) -> bool {
        let [Some(newest), .., Some(oldest)] = self.contacts else {
            return false;
        };
        let x_in = i32::from(newest.x_in.wrapping_sub(oldest.x_in));
        let y_in = i32::from(newest.y_in.wrapping_sub(oldest.y_in));
        newest.at_ticks.wrapping_sub(oldest.at_ticks) <= CAUGHT_TICKS
            && x_in.abs() < PROGRESS_IN
            && y_in.abs() < PROGRESS_IN
            && x_in * x_in + y_in * y_in < PROGRESS_IN * PROGRESS_IN
    }

    fn advance(&mut self, senses: &Senses, pressed: bool) -> Motion {
        match &mut self.state {
            State::Quiet => Motion::STILL,
            State::Back {
                turn,
                path_counts,
                ticks_left,
            } => {
                *path_counts = path_counts.saturating_add(senses.path_counts);
                *ticks_left -= 1;
                if *path_counts <= -BACK_COUNTS || *ticks_left == 0 {
                    let ticks = TURN_TICKS + (turn.unsigned_abs() >> 9) as u8;
                    self.state = State::Turn {
                        left: *turn,
                        heading: senses.pose.heading,
                        ticks_left: ticks,
                    };
                }
                BACK
            }
            State::Turn {
                left,
                heading,
                ticks_left,
            } => {
                let right = *left > 0;
                *left -= i32::from(senses.pose.heading.minus(*heading));
                *heading = senses.pose.heading;
                *ticks_left -= 1;
                if *ticks_left == 0 || *left == 0 || (*left > 0) != right {
                    self.state = State::Settle {
                        ticks_left: SETTLE_TICKS,
                    };
                }
                Motion::new(0, if right { TURN_IN_S } else { -TURN_IN_S })
            }
            State::Settle { ticks_left } => {
                *ticks_left -= 1;
                if *ticks_left == 0 {
                    self.state = State::Quiet;
                }
                Motion::STILL
            }
            State::Jam { step, ticks } => {
                let (motion, length) = JAM_SEQUENCE
                    .get(usize::from(*step))
                    .copied()
                    .unwrap_or_default();
                *ticks += 1;
                if *ticks >= length {
                    *ticks = 0;
                    *step = (*step + 1) % JAM_SEQUENCE.len() as u8;
                }
                if !pressed {
                    self.state = State::Quiet;
                }
                motion
            }
        }
    }
}

impl Behaviour for Bumpers {
    fn decide(&mut self, senses: &Senses) -> Request {
        let pressed = senses.bumper.any();
        let newly = pressed && !self.pressed_before;
        self.pressed_before = pressed;
        self.held_ticks = if pressed {
            self.held_ticks.saturating_add(1)
        } else {
            0
        };
        match self.state {
            State::Jam { .. } => {}
            _ if self.held_ticks >= JAM_TICKS => {
                self.state = State::Jam { step: 0, ticks: 0 };
            }
            State::Quiet if pressed || senses.is_held => self.begin(senses),
            // Another contact while turning away.
            State::Turn { .. } | State::Settle { .. } if newly => self.begin(senses),
            _ => {}
        }
        if self.state == State::Quiet {
            return Request::QUIET;
        }
        Request::raise(self.advance(senses, pressed))
    }

    fn rest(&mut self) {
        *self = Self::default();
    }
}

/// Side of a contact; `None` for the centre and for both sides at once.
pub(super) const fn side(switches: Switches) -> Option<Side> {
    match (switches.left, switches.right) {
        (true, false) => Some(Side::Left),
        (false, true) => Some(Side::Right),
        _ => None,
    }
}

#[cfg(test)]
mod tests;
