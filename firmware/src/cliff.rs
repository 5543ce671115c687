//! The cliff guard: whatever won the motors, nothing drives the robot over an edge of the floor.
//!
//! It stands behind the arbiter, above even the operator's hand: backing off a bumper can back down the
//! stairs. What would carry a wheel toward a place without floor is stopped with full braking power, and
//! then the guard moves the robot away from the edge, so that it does not stand there for ever. By hand it
//! only stops: the operator sees why and decides. Where there is no floor anywhere the robot is in somebody's
//! hand, or has fallen: the wheels stand until it has been put down.
//!
//! The sensors ahead of the wheels and under the bumper's middle look at what the wheels come to next; the
//! rear input covers the tail wheel and what is behind both drive wheels. Turning on the spot moves one
//! wheel forward and the other, with the tail, backward, and each is held back by the sensor on its way.

use crate::angle::Angle;
use crate::board::{COUNTS_PER_IN, Edges};
use crate::drive::{Counts, Motion};
use crate::parameters::Parameter;
use crate::sensors::Senses;
use crate::units::{cps, ticks};

/// Fastest that it lets the robot back up: the sensor behind the tail is less than an inch behind it.
const BACK_MOST_CPS: i16 = cps(8);

/// Full braking stops the robot in two or three ticks; after this it counts as stopped.
const BRAKE_TICKS: u8 = 6;

/// Counts in a tick that are no movement.
const STANDING_COUNTS: i16 = 1;

/// Retreats are slow: whatever is beyond has to be seen in time.
const RETREAT_IN_S: i16 = 5;

/// From an edge ahead: far enough that the wheels clear it while the robot turns. Counts of both wheels.
const BACK_COUNTS: i16 = 5 * COUNTS_PER_IN as i16 * 2;

/// From an edge behind, or alongside.
const AHEAD_COUNTS: i16 = 8 * COUNTS_PER_IN as i16 * 2;

/// A retreat takes two seconds; after this something is in the way.
const RETREAT_TICKS: u8 = 3 * ticks(1) as u8;

/// Turning: 34 degrees a second.
const TURN_IN_S: i16 = 6;

/// The least turn away from an edge ahead, 60 degrees, and how much more chance adds: up to another 60.
const TURN_LEAST: u16 = 0x2AAB;

/// The turn away from an edge alongside: half of a right angle, after which ahead leads away from it.
const VEER: u16 = 0x2000;

/// Most that a turn takes.
const TURN_TICKS: u8 = 5 * ticks(1) as u8;

/// Put down, it waits for so long: hands are still on it.
const PUT_DOWN_TICKS: u8 = ticks(1) as u8 / 2;

/// With an edge behind and a bumper pressed, one wheel pushes on for so long.
const PIVOT_TICKS: u8 = 24;

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum State {
    #[default]
    Watch,
    /// Braking; by hand the guard does not move the robot away after that.
    Brake { by_hand: bool, ticks_left: u8 },
    Retreat {
        forward: bool,
        then: Option<Turn>,
        way_counts: i16,
        ticks_left: u8,
    },
    Turn {
        turn: Turn,
        heading: Angle,
        ticks_left: u8,
    },
    /// One wheel ahead, the other still.
    Pivot { right: bool, ticks_left: u8 },
    /// No floor anywhere, or put down just now.
    Lifted { ticks_left: u8 },
}

/// A turn on the spot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Turn {
    right: bool,
    left_to_go: u16,
    /// Away from an edge alongside: the sensors see it all the time, and the wheels keep clear of it.
    alongside: bool,
}

/// What the guard makes of a tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// Move so.
    Drive(Motion),
    /// Stop as fast as the motors can.
    Brake,
}

/// Where there is no floor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Missing {
    /// Ahead.
    Ahead,
    /// Behind and not ahead.
    Behind,
    /// Anywhere.
    Below,
}

/// The guard.
#[derive(Clone, Debug, Default)]
pub struct CliffGuard {
    state: State,
    /// What it acts for.
    seen: Edges,
    /// Until it says again that it acts.
    told_ticks: u8,
    news: Option<Missing>,
}

/// So long after the last time it acted it says so again.
const TELL_TICKS: u8 = 5 * ticks(1) as u8;

impl CliffGuard {
    /// Forgets what it was about: the motors are off.
    pub fn rest(&mut self) {
        self.state = State::Watch;
    }

    /// Whether it holds the motors.
    #[must_use]
    pub fn acts(&self) -> bool {
        self.state != State::Watch
    }

    /// The edges for which it holds the motors; none while it does not.
    #[must_use]
    pub fn acts_for(&self) -> Edges {
        if self.acts() {
            self.seen
        } else {
            Edges::default()
        }
    }

    /// Why it began to act in this tick, if it did.
    pub fn take_news(&mut self) -> Option<Missing> {
        self.news.take()
    }

    /// What becomes of the motion that won; `by_hand` when the operator's hand won.
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
        self.told_ticks = self.told_ticks.saturating_sub(1);
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
        self.go_on(senses);
        Command::Drive(motion)
    }

    fn is_lifted(&mut self, edges: Edges) -> bool {
        let ticks_left = if edges.left && edges.center && edges.right && edges.rear {
            if !matches!(self.state, State::Lifted { .. }) {
                self.news = Some(Missing::Below);
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
        if self.told_ticks == 0 {
            let ahead = edges.left || edges.center || edges.right;
            self.news = Some(if ahead {
                Missing::Ahead
            } else {
                Missing::Behind
            });
        }
        self.told_ticks = TELL_TICKS;
        self.seen = edges;
        self.state = State::Brake {
            by_hand,
            ticks_left: BRAKE_TICKS,
        };
    }

    fn brake(&mut self, senses: &Senses, edges: Edges, counts: Counts) -> Command {
        self.told_ticks = TELL_TICKS;
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

    /// The motion of this tick: the winner's, or the retreat's.
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

    /// Lets a tick of the retreat pass.
    fn go_on(&mut self, senses: &Senses) {
        let next = match &mut self.state {
            State::Watch | State::Brake { .. } | State::Lifted { .. } => return,
            State::Retreat {
                forward,
                then,
                way_counts,
                ticks_left,
            } => {
                *way_counts = way_counts.saturating_add(senses.way_counts);
                *ticks_left -= 1;
                let far = if *forward { AHEAD_COUNTS } else { BACK_COUNTS };
                // Pushing on against what stands ahead leads nowhere.
                let blocked = *forward && senses.bumper.any();
                if way_counts.abs() < far && *ticks_left > 0 && !blocked {
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
            way_counts: 0,
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

/// Where to go from the edges that were seen.
fn retreat(seen: Edges, senses: &Senses) -> State {
    let ahead = seen.left || seen.center || seen.right;
    let by_chance = senses.dice & 1 == 0;
    // An edge on the left is turned from to the right.
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
            let more = (senses.dice >> 8) as u16 % TURN_LEAST;
            State::retreat(false, Some(turn(TURN_LEAST + more, false)))
        }
    }
}

/// Whether wheels that turn so carry the robot toward where there is no floor.
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
