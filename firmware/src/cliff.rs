//! The cliff guard: keeps every behaviour and the operator from driving over an edge of the floor.
//!
//! It acts behind the arbiter and overrides even manual driving, because backing off an obstacle can lead down the
//! stairs. When a motion would carry a wheel toward missing floor, the guard brakes at full power and then drives away
//! from the edge. In manual driving it only brakes, and the operator decides. Without any floor the robot has been
//! lifted or has fallen, and the wheels stay still until it is put down.
//!
//! The sensors ahead of the wheels and below the middle of the bumper cover forward motion; the rear input covers the
//! tail wheel and both drive wheels backward. A turn on the spot moves one wheel forward, the other and the tail
//! backward; the sensor in each direction can stop it.

use crate::angle::Angle;
use crate::board::{COUNTS_PER_IN, Edges};
use crate::drive::{Counts, Motion};
use crate::parameters::Parameter;
use crate::sensors::Senses;
use crate::units::{cps, ticks};

/// Maximum reverse speed: the sensor behind the tail is less than an inch ahead of it.
const BACK_MOST_CPS: i16 = cps(8);

/// Maximum duration of braking: two or three ticks stop the robot.
const BRAKE_TICKS: u8 = 6;

/// Counts per tick that still count as standing.
const STANDING_COUNTS: i16 = 1;

/// Speed of a retreat: slow enough to detect the next edge in time.
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

/// Turn away from an edge alongside: 45 degrees, after which driving ahead leads away.
const VEER: u16 = 0x2000;

/// Maximum duration of a turn.
const TURN_TICKS: u8 = 5 * ticks(1) as u8;

/// Delay after the robot has been put down.
const PUT_DOWN_TICKS: u8 = ticks(1) as u8 / 2;

/// Duration of a pivot on one wheel, with an edge behind and a bumper switch closed.
const PIVOT_TICKS: u8 = 24;

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
    /// Drives one wheel ahead with the other one still.
    Pivot { right: bool, ticks_left: u8 },
    /// No floor at any sensor, or just put down.
    Lifted { ticks_left: u8 },
}

/// A turn on the spot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Turn {
    right: bool,
    left_to_go: u16,
    /// Whether the turn is away from an edge alongside: the sensors detect it throughout, and the wheels stay clear.
    alongside: bool,
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
    /// Ahead.
    Ahead,
    /// Behind, and not ahead.
    Behind,
    /// At all sensors.
    Below,
}

/// The cliff guard.
#[derive(Clone, Debug, Default)]
pub struct CliffGuard {
    state: State,
    /// Edges that it acts on.
    seen: Edges,
    /// Ticks until it reports again.
    report_ticks: u8,
    report: Option<Missing>,
}

/// Ticks without action after which the next action is reported.
const REPORT_TICKS: u8 = 5 * ticks(1) as u8;

impl CliffGuard {
    /// Returns to watching; call it while the motors are off.
    pub fn rest(&mut self) {
        self.state = State::Watch;
    }

    /// Whether the guard controls the motors.
    #[must_use]
    pub fn acts(&self) -> bool {
        self.state != State::Watch
    }

    /// Edges that the guard acts on; none while it only watches.
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
        if self.is_lifted(edges) {
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
        let ignored = matches!(self.state, State::Turn { turn, .. } if turn.alongside);
        let moves = |count: i16| {
            if count.abs() > STANDING_COUNTS {
                count
            } else {
                0
            }
        };
        let rolls = (moves(counts.left), moves(counts.right));
        if !ignored && (leads_over(edges, left, right) || leads_over(edges, rolls.0, rolls.1)) {
            self.begin(edges, by_hand);
            return self.brake(senses, edges, counts);
        }
        self.advance(senses);
        Command::Drive(motion)
    }

    fn is_lifted(&mut self, edges: Edges) -> bool {
        let ticks_left = if edges.left && edges.center && edges.right && edges.rear {
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

    fn begin(&mut self, edges: Edges, by_hand: bool) {
        if self.report_ticks == 0 {
            let ahead = edges.left || edges.center || edges.right;
            self.report = Some(if ahead {
                Missing::Ahead
            } else {
                Missing::Behind
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
            State::Pivot { right, .. } => {
                Motion::new(TURN_IN_S / 2, if right { TURN_IN_S } else { -TURN_IN_S })
            }
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
                // Pushing against an obstacle ahead leads nowhere.
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
                if turn.alongside {
                    State::retreat(true, None)
                } else {
                    State::Watch
                }
            }
            State::Pivot { ticks_left, .. } => {
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
    let ahead = seen.left || seen.center || seen.right;
    let by_chance = senses.random & 1 == 0;
    // Turn right from an edge on the left.
    let right = if seen.left == seen.right {
        by_chance
    } else {
        seen.left
    };
    let turn = |least: u16, alongside| Turn {
        right,
        left_to_go: least,
        alongside,
    };
    match (ahead, seen.rear) {
        (true, true) => State::turn(turn(VEER, true), senses),
        (false, true) if senses.bumper.any() => State::Pivot {
            right: by_chance,
            ticks_left: PIVOT_TICKS,
        },
        (false, true) => State::retreat(true, None),
        _ => {
            let more = (senses.random >> 8) as u16 % TURN_LEAST;
            State::retreat(false, Some(turn(TURN_LEAST + more, false)))
        }
    }
}

/// Whether these wheel speeds carry the robot toward missing floor.
const fn leads_over(edges: Edges, left: i16, right: i16) -> bool {
    let ahead = left as i32 + right as i32 > 0;
    let front = edges.left || edges.center || edges.right;
    (front && ahead)
        || (edges.left && left > 0)
        || (edges.right && right > 0)
        || (edges.rear && (left < 0 || right < 0))
}

#[cfg(test)]
mod tests;
