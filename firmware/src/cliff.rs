//! The cliff guard: keeps every behaviour and the operator from driving over an edge of the floor.
//!
//! It acts behind the arbiter and overrides even manual driving, because backing off an obstacle can lead down the
//! stairs. When a motion would carry a wheel toward missing floor, the guard brakes at full power and then drives away
//! from the edge. In manual driving it only brakes, and the operator decides. Without any floor the robot has been
//! lifted or has fallen, and the wheels stay still until it is put down.
//!
//! A ring of sensors surrounds the body. They are closer together than the corner of a stairwell is wide, so that no edge reaches a wheel
//! or the caster unseen. The sensors are not perfect. The guard brakes in the tick of a first detection, while the edge
//! is still far enough away, and acts on the edge when a second detection within eight ticks confirms it. After a false
//! detection the robot continues. While the robot stands, the floor around it does not change, so the guard remembers a
//! confirmed edge that a sensor no longer detects for three seconds.

use crate::angle::Angle;
use crate::board::{COUNTS_PER_IN, Edges};
use crate::drive::{Counts, Motion};
use crate::parameters::Parameter;
use crate::sensors::Senses;
use crate::units::{cps, ticks};

/// Maximum reverse speed: the sensors behind the caster are 2 in ahead of it.
const BACK_MOST_CPS: i16 = cps(8);

/// Maximum duration of braking: two or three ticks stop the robot.
const BRAKE_TICKS: u8 = 6;

/// Maximum number of counts per tick of a standing wheel.
const STANDING_COUNTS: i16 = 1;

/// Speed of a retreat, in/s: slow enough to detect the next edge in time.
const RETREAT_IN_S: i16 = 5;

/// Distance back from an edge ahead, in counts of both wheels: the wheels clear the edge in the turn.
const BACK_COUNTS: i16 = 5 * COUNTS_PER_IN as i16 * 2;

/// Distance ahead from an edge behind or alongside, in counts of both wheels.
const AHEAD_COUNTS: i16 = 8 * COUNTS_PER_IN as i16 * 2;

/// Maximum duration of a retreat, which takes two seconds unless it is blocked.
const RETREAT_TICKS: u8 = 3 * ticks(1) as u8;

/// Turning speed: 34 degrees per second.
const TURN_IN_S: i16 = 6;

/// Minimum turn away from an edge ahead, 60 degrees; a random part of up to 60 degrees is added.
const TURN_LEAST: u16 = 0x2AAB;

/// Number of ticks for which a detection is kept, and number of detections among them that confirm an edge.
const HELD_TICKS: usize = 8;
const SURE_COUNT: u8 = 2;

/// Number of ticks for which a robot that stands remembers a confirmed edge that its sensors do not see.
const KNOWN_TICKS: u8 = 3 * ticks(1) as u8;

/// Maximum duration of a turn.
const TURN_TICKS: u8 = 5 * ticks(1) as u8;

/// Delay after the robot has been put down.
const PUT_DOWN_TICKS: u8 = ticks(1) as u8 / 2;

/// Duration of a swing: 40 degrees.
const SWING_TICKS: u8 = 24;

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum State {
    #[default]
    Watch,
    /// Brakes; in manual driving the guard does not move the robot afterwards.
    Brake { by_hand: bool, ticks_left: u8 },
    Retreat {
        forward: bool,
        then: Option<Turn>,
        path_counts: i16,
        ticks_left: u8,
    },
    Turn {
        turn: Turn,
        heading: Angle,
        ticks_left: u8,
    },
    /// Turns on the spot or on one wheel, between an edge and an obstacle or another edge.
    Swing { motion: Motion, ticks_left: u8 },
    /// No floor at any sensor, or just put down.
    Lifted { ticks_left: u8 },
}

/// A turn on the spot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Turn {
    right: bool,
    left_to_go: u16,
}

/// Decision of the guard for one tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// Drive with this motion.
    Drive(Motion),
    /// Brake at full power.
    Brake,
}

/// Direction of missing floor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Missing {
    /// There is no floor ahead.
    Ahead,
    /// There is no floor behind, but floor ahead.
    Behind,
    /// There is no floor at any sensor.
    Below,
}

/// The cliff guard.
#[derive(Clone, Debug, Default)]
pub struct CliffGuard {
    state: State,
    /// Detections of the past ticks, newest first.
    history: [Edges; HELD_TICKS],
    /// Confirmed edges since the robot has stood here.
    known: Edges,
    /// Number of ticks for which the guard still remembers them.
    known_ticks: u8,
    /// Edges on which the guard acts.
    seen: Edges,
    /// Number of ticks until the guard reports again.
    report_ticks: u8,
    report: Option<Missing>,
}

/// Number of ticks without action after which the next action is reported.
const REPORT_TICKS: u8 = 5 * ticks(1) as u8;

impl CliffGuard {
    /// Returns to watching. Call while the motors are off.
    pub fn rest(&mut self) {
        self.state = State::Watch;
    }

    /// Whether the guard controls the motors.
    #[must_use]
    pub fn acts(&self) -> bool {
        self.state != State::Watch
    }

    /// Edges on which the guard acts; none while it only watches.
    #[must_use]
    pub fn acts_for(&self) -> Edges {
        if self.acts() {
            self.seen
        } else {
            Edges::default()
        }
    }

    /// Direction of the missing floor if the guard began to act in this tick.
    pub fn take_report(&mut self) -> Option<Missing> {
        self.report.take()
    }

    /// Command for the motors in place of the winning motion; `by_hand` in manual driving.
    pub fn guard(
        &mut self,
        senses: &Senses,
        counts: Counts,
        motion: Motion,
        by_hand: bool,
    ) -> Command {
        let fitted = senses.cliff;
        let Some(edges) = fitted.filter(|_| senses.parameters.is_on(Parameter::CliffGuard)) else {
            self.state = State::Watch;
            return Command::Drive(motion);
        };
        self.report_ticks = self.report_ticks.saturating_sub(1);
        self.remember(edges);
        let sure = self.detected(SURE_COUNT);
        if self.is_lifted(sure) {
            return Command::Brake;
        }
        if by_hand && !matches!(self.state, State::Brake { .. }) {
            self.state = State::Watch;
        }
        if let State::Brake { .. } = self.state {
            return self.brake(senses, edges, counts);
        }
        let motion = Motion {
            velocity_cps: self.wanted(motion).velocity_cps.max(-BACK_MOST_CPS),
            ..self.wanted(motion)
        };
        let (left, right) = motion.wheels();
        let moves = |count: i16| {
            if count.abs() > STANDING_COUNTS {
                count
            } else {
                0
            }
        };
        let rolls = (moves(counts.left), moves(counts.right));
        let is_barred = |by: Edges| {
            leads_over(by, left, right)
                || curves_over(by, left, right)
                || leads_over(by, rolls.0, rolls.1)
        };
        if is_barred(self.known(sure, counts)) {
            self.begin(by_hand);
            return self.brake(senses, edges, counts);
        }
        if is_barred(edges) {
            return Command::Brake;
        }
        self.advance(senses);
        Command::Drive(motion)
    }

    fn remember(&mut self, edges: Edges) {
        self.history.rotate_right(1);
        if let Some(newest) = self.history.first_mut() {
            *newest = edges;
        }
    }

    /// Inputs with at least this many detections in the past ticks.
    fn detected(&self, least: u8) -> Edges {
        let is_so = |bit: &u8| {
            let seen = self.history.iter().filter(|then| then.bits() & bit != 0);
            seen.count() >= usize::from(least)
        };
        let bits = (0..8).map(|shift| 1 << shift).filter(is_so);
        Edges::from_bits(bits.fold(0, |all, bit| all | bit))
    }

    /// The confirmed edges, including those confirmed earlier while the robot has stood here.
    fn known(&mut self, sure: Edges, counts: Counts) -> Edges {
        let stands = counts.left.abs() <= STANDING_COUNTS && counts.right.abs() <= STANDING_COUNTS;
        self.known_ticks = match self.known_ticks.saturating_sub(1) {
            _ if !stands => 0,
            _ if sure.any() => KNOWN_TICKS,
            ticks_left => ticks_left,
        };
        self.known = if self.known_ticks > 0 {
            self.known.or(sure)
        } else {
            sure
        };
        self.known
    }

    fn is_lifted(&mut self, edges: Edges) -> bool {
        let ticks_left = if edges == Edges::ALL {
            if !matches!(self.state, State::Lifted { .. }) {
                self.report = Some(Missing::Below);
            }
            self.seen = edges;
            PUT_DOWN_TICKS
        } else if let State::Lifted { ticks_left } = self.state {
            ticks_left.saturating_sub(1)
        } else {
            return false;
        };
        self.state = if ticks_left > 0 {
            State::Lifted { ticks_left }
        } else {
            State::Watch
        };
        ticks_left > 0
    }

    fn begin(&mut self, by_hand: bool) {
        let edges = self.detected(1);
        if self.report_ticks == 0 {
            self.report = Some(if edges.meets(Edges::REAR) && !edges.meets(Edges::FRONT) {
                Missing::Behind
            } else {
                Missing::Ahead
            });
        }
        self.report_ticks = REPORT_TICKS;
        self.seen = edges;
        self.state = State::Brake {
            by_hand,
            ticks_left: BRAKE_TICKS,
        };
    }

    fn brake(&mut self, senses: &Senses, edges: Edges, counts: Counts) -> Command {
        self.report_ticks = REPORT_TICKS;
        self.seen = self.seen.or(edges);
        let State::Brake {
            by_hand,
            ticks_left,
        } = &mut self.state
        else {
            return Command::Brake;
        };
        *ticks_left = ticks_left.saturating_sub(1);
        let stands = counts.left.abs() <= STANDING_COUNTS && counts.right.abs() <= STANDING_COUNTS;
        if stands || *ticks_left == 0 {
            self.state = if *by_hand {
                State::Watch
            } else {
                retreat(self.seen, senses)
            };
        }
        Command::Brake
    }

    /// Motion of this tick: the winner's or the retreat's.
    const fn wanted(&self, motion: Motion) -> Motion {
        match self.state {
            State::Watch => motion,
            State::Brake { .. } | State::Lifted { .. } => Motion::STILL,
            State::Retreat { forward, .. } => {
                Motion::new(if forward { RETREAT_IN_S } else { -RETREAT_IN_S }, 0)
            }
            State::Turn { turn, .. } => {
                Motion::new(0, if turn.right { TURN_IN_S } else { -TURN_IN_S })
            }
            State::Swing { motion, .. } => motion,
        }
    }

    /// Advances the retreat by a tick.
    fn advance(&mut self, senses: &Senses) {
        let next = match &mut self.state {
            State::Watch | State::Brake { .. } | State::Lifted { .. } => return,
            State::Retreat {
                forward,
                then,
                path_counts,
                ticks_left,
            } => {
                *path_counts = path_counts.saturating_add(senses.path_counts);
                *ticks_left -= 1;
                let far = if *forward { AHEAD_COUNTS } else { BACK_COUNTS };
                // Pushing against an obstacle ahead makes no progress.
                let blocked = *forward && senses.bumper.any();
                if path_counts.abs() < far && *ticks_left > 0 && !blocked {
                    return;
                }
                then.map_or(State::Watch, |turn| State::turn(turn, senses))
            }
            State::Turn {
                turn,
                heading,
                ticks_left,
            } => {
                let turned = senses.pose.heading.minus(*heading);
                *heading = senses.pose.heading;
                let turned = if turn.right {
                    turned
                } else {
                    turned.saturating_neg()
                };
                turn.left_to_go = turn.left_to_go.saturating_sub(turned.max(0) as u16);
                *ticks_left -= 1;
                if turn.left_to_go > 0 && *ticks_left > 0 {
                    return;
                }
                State::Watch
            }
            State::Swing { ticks_left, .. } => {
                *ticks_left -= 1;
                if *ticks_left > 0 {
                    return;
                }
                State::Watch
            }
        };
        self.state = next;
    }
}

impl State {
    const fn retreat(forward: bool, then: Option<Turn>) -> Self {
        Self::Retreat {
            forward,
            then,
            path_counts: 0,
            ticks_left: RETREAT_TICKS,
        }
    }

    const fn turn(turn: Turn, senses: &Senses) -> Self {
        Self::Turn {
            turn,
            heading: senses.pose.heading,
            ticks_left: TURN_TICKS,
        }
    }
}

/// The retreat from the detected edges.
fn retreat(seen: Edges, senses: &Senses) -> State {
    const LEFT: Edges = Edges::AHEAD_LEFT.or(Edges::BESIDE_LEFT);
    const RIGHT: Edges = Edges::AHEAD_RIGHT.or(Edges::BESIDE_RIGHT);
    let by_chance = senses.random & 1 == 0;
    // Turn right from an edge on the left.
    let right = if seen.meets(LEFT) == seen.meets(RIGHT) {
        by_chance
    } else {
        seen.meets(LEFT)
    };
    // Also back off an edge beside the robot, the way it came: a turn could bring the wheel over its corner.
    let is_ahead = seen.meets(Edges::FRONT.or(LEFT).or(RIGHT));
    match (is_ahead, seen.meets(Edges::REAR)) {
        (true, false) => {
            let left_to_go = TURN_LEAST + (senses.random >> 8) as u16 % TURN_LEAST;
            State::retreat(false, Some(Turn { right, left_to_go }))
        }
        (false, true) if !senses.bumper.any() => State::retreat(true, None),
        _ => swing(seen, right),
    }
}

/// The first swing, on the spot or on one wheel, that does not lead over an edge.
fn swing(seen: Edges, right: bool) -> State {
    let rotation_in_s = if right { TURN_IN_S } else { -TURN_IN_S };
    let swings = [0, TURN_IN_S / 2, -TURN_IN_S / 2]
        .into_iter()
        .flat_map(|velocity_in_s| {
            [rotation_in_s, -rotation_in_s].map(|rotation| Motion::new(velocity_in_s, rotation))
        });
    let is_free = |motion: &Motion| {
        let (left, right) = motion.wheels();
        !leads_over(seen, left, right) && !curves_over(seen, left, right)
    };
    swings
        .into_iter()
        .find(is_free)
        .map_or(State::Watch, |motion| State::Swing {
            motion,
            ticks_left: SWING_TICKS,
        })
}

/// Whether these wheel speeds carry a wheel or the caster toward missing floor.
const fn leads_over(edges: Edges, left: i16, right: i16) -> bool {
    let path = left as i32 + right as i32;
    // A turn on the spot also carries the caster to the side.
    let (turns_right, turns_left) = (left > 0 && right < 0, left < 0 && right > 0);
    // An edge beside the body is ahead of its wheel wherever it juts out, unless the robot turns on the spot.
    let (passes_left, passes_right) = (left > 0 && right >= 0, right > 0 && left >= 0);
    (edges.meets(Edges::FRONT) && path > 0)
        || (edges.meets(Edges::BESIDE_LEFT) && passes_left)
        || (edges.meets(Edges::BESIDE_RIGHT) && passes_right)
        || (edges.meets(Edges::REAR) && path < 0)
        || (edges.meets(Edges::AHEAD_LEFT) && left > 0)
        || (edges.meets(Edges::AHEAD_RIGHT) && right > 0)
        || (edges.meets(Edges::BEHIND_LEFT) && (left < 0 || turns_right))
        || (edges.meets(Edges::BEHIND_RIGHT) && (right < 0 || turns_left))
}

/// Whether these wheel speeds make an arc so narrow that its inner wheel can come over an edge beside it.
const fn curves_over(edges: Edges, left: i16, right: i16) -> bool {
    const fn is_inner(one: i16, other: i16) -> bool {
        let (one, other) = (one as i32, other as i32);
        one * other >= 0 && one.abs() * 5 < other.abs() * 4
    }
    (edges.meets(Edges::BESIDE_LEFT) && is_inner(left, right))
        || (edges.meets(Edges::BESIDE_RIGHT) && is_inner(right, left))
}

#[cfg(test)]
mod tests;
