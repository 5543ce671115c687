//! Tasks that the robot cannot carry out, by its line I.

use super::super::status::{CommandStatus, Failure, Shortfall};
use super::{Fop, FopEvent, Work};
use crate::command::Order;
use crate::status_codes::Mode;
use crate::telemetry::{AbilitiesLine, Outcome};

/// Lowest level of robots that obey orders (SPEC.md section 1).
const ORDERS_LEVEL: u8 = 2;
/// Lowest level of robots that keep lists.
const LISTS_LEVEL: u8 = 3;
/// Lowest level of robots that can be driven by hand.
pub const DRIVE_LEVEL: u8 = 4;

/// Maximum wait for a line I that may explain a refusal, microseconds. The robot sends one after each *open*.
const EXPLANATION_US: u64 = 5_000_000;

/// Abilities that a task needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Needs {
    level: u8,
    waypoints: u16,
    mode: Option<Mode>,
}

impl Needs {
    fn of(work: &Work) -> Self {
        let (level, waypoints, mode) = match work {
            Work::List(list) => (LISTS_LEVEL, list.count(), None),
            Work::Order(Order::Mode(mode)) => (ORDERS_LEVEL, 0, Some(*mode)),
            Work::Order(order) => (order.level(), 0, None),
        };
        Self {
            level,
            waypoints,
            mode,
        }
    }

    /// The final status of the task at a robot that cannot carry it out; `None` at a robot that can.
    fn beyond(self, robot: &AbilitiesLine) -> Option<CommandStatus> {
        let failure = if self.level > robot.level {
            Failure::BeyondLevel(Shortfall {
                has: robot.level.into(),
                needs: self.level.into(),
            })
        } else if self.waypoints > robot.capacity {
            Failure::BeyondCapacity(Shortfall {
                has: robot.capacity,
                needs: self.waypoints,
            })
        } else if self.mode.is_some_and(|mode| !robot.has_mode(mode)) {
            return Some(CommandStatus::Refused(Outcome::NotFitted));
        } else {
            return None;
        };
        Some(CommandStatus::Failed(failure))
    }

    /// Whether a line I can explain the outcome of the task.
    fn explain(self, outcome: Outcome) -> bool {
        match outcome {
            Outcome::Unknown => self.level > ORDERS_LEVEL,
            Outcome::BadValue => self.waypoints > 0,
            _ => false,
        }
    }
}

/// A task that the robot has refused, perhaps for a reason in its first line I.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Unexplained {
    needs: Needs,
    outcome: Outcome,
    until_us: u64,
}

impl Fop {
    /// The robot's abilities, from its latest line I; `None` before such a line, and for robots with all abilities.
    #[must_use]
    pub const fn abilities(&self) -> Option<&AbilitiesLine> {
        self.abilities.as_ref()
    }

    /// Whether the robot obeys hand drive, as far as known.
    #[must_use]
    pub fn can_be_driven(&self) -> bool {
        self.abilities
            .is_none_or(|robot| robot.level >= DRIVE_LEVEL)
    }

    /// The final status of a task that the robot cannot carry out and whose command has not been sent.
    pub(super) fn beyond(&self) -> Option<CommandStatus> {
        let work = self.work.as_ref().filter(|_| self.outstanding.is_none())?;
        Needs::of(work).beyond(self.abilities.as_ref()?)
    }

    /// Ends a task that the robot cannot carry out, unless its command has been sent.
    pub(super) fn refuse_beyond(&mut self) {
        if let Some(end) = self.beyond() {
            self.end(end);
        }
    }

    /// Ends the task that the robot has refused, at once or when its first line I shows what the robot lacks.
    pub(super) fn refuse(&mut self, now_us: u64, outcome: Outcome) {
        let Some(work) = self.work.take() else {
            return;
        };
        let needs = Needs::of(&work);
        self.unexplained = Some(Unexplained {
            needs,
            outcome,
            until_us: now_us + self.stretched(EXPLANATION_US),
        });
        if self.abilities.is_some() || !needs.explain(outcome) {
            self.settle_refusal();
        }
    }

    /// Ends the task that the robot has refused, with the reason in line I or without one.
    pub(super) fn settle_refusal(&mut self) {
        if let Some(refusal) = self.unexplained {
            let robot = self.abilities.as_ref();
            let beyond = robot.and_then(|robot| refusal.needs.beyond(robot));
            self.end(beyond.unwrap_or(CommandStatus::Refused(refusal.outcome)));
        }
    }

    /// Time at which the wait for line I ends.
    pub(super) fn explained_by_us(&self) -> Option<u64> {
        self.unexplained.map(|refusal| refusal.until_us)
    }

    /// Ends the task with its final status.
    pub(super) fn end(&mut self, end: CommandStatus) {
        self.work = None;
        self.unexplained = None;
        self.push(FopEvent::Task(end));
    }
}
