//! The robot's end, consisting of the real receiver and FARM, with a log of its actions.

use groundwave_protocol::Waypoint;
use groundwave_protocol::arq::{Action, Farm};
use groundwave_protocol::command::{Message, Order};
use groundwave_protocol::decoder::{Decoder, Received};
use groundwave_protocol::receiver::Receiver;
use groundwave_protocol::status_codes::Mode;
use groundwave_protocol::telemetry::{Ack, Body, Line, Outcome, StateLine};
use std::hash::{Hash, Hasher};

use super::instants::Quick;
use crate::world::ROBOT_ID;

/// Number of a task of a station, carried as theta of an order or in the first waypoint of a list.
pub type TaskId = u16;

/// A robot's life and the session that was open in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Epoch {
    pub boots: u16,
    pub session: u8,
}

/// An action of the robot, and its epoch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Deed {
    pub task: TaskId,
    pub epoch: Epoch,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Robot {
    pub farm: Farm,
    pub boots: u16,
    mode: Mode,
    /// All actions in order, over all lives.
    pub deeds: Vec<Deed>,
    /// Number of STOPs taken, over all lives.
    pub stops: u8,
    /// Hash of the FARM; cached because the FARM is large and rarely changes.
    hash: u64,
}

impl Hash for Robot {
    fn hash<H: Hasher>(&self, hasher: &mut H) {
        self.hash.hash(hasher);
        self.mode.hash(hasher);
        self.boots.hash(hasher);
        self.deeds.hash(hasher);
        self.stops.hash(hasher);
    }
}

impl Robot {
    pub fn new() -> Self {
        let mut robot = Self {
            farm: Farm::new(ROBOT_ID, 1),
            boots: 1,
            mode: Mode::Prowl,
            deeds: Vec::new(),
            stops: 0,
            hash: 0,
        };
        robot.remember();
        robot
    }

    fn remember(&mut self) {
        let mut hasher = Quick::default();
        self.farm.hash(&mut hasher);
        self.hash = hasher.finish();
    }

    /// Reboots: only the count of boots remains.
    pub fn reboot(&mut self) {
        self.boots += 1;
        self.farm = Farm::new(ROBOT_ID, self.boots);
        self.mode = Mode::Prowl;
        self.remember();
    }

    pub fn epoch(&self) -> Epoch {
        Epoch {
            boots: self.boots,
            session: self.farm.ack().session,
        }
    }

    /// Receives a frame; returns the task that the robot executes.
    pub fn hear(&mut self, frame: &[u8]) -> Option<TaskId> {
        let mut receiver = Receiver::default();
        let mut done = None;
        for &byte in frame {
            let message = receiver.handle_byte(byte, ROBOT_ID, self.farm.key());
            done = message.and_then(|message| self.obey(&message)).or(done);
        }
        self.remember();
        done
    }

    fn obey(&mut self, message: &Message) -> Option<TaskId> {
        let task = match self.farm.handle(message) {
            Action::Stop => {
                self.mode = Mode::Stop;
                self.stops += 1;
                None
            }
            Action::Execute(order) => {
                self.farm.conclude(Outcome::Done);
                match order {
                    Order::Pose { theta_deg, .. } => Some(theta_deg),
                    _ => None,
                }
            }
            Action::ListReplaced => Some(task_of_list(self.farm.lists().active())),
            _ => None,
        };
        let epoch = self.epoch();
        self.deeds.extend(task.map(|task| Deed { task, epoch }));
        task
    }

    /// The robot's next line, decoded.
    pub fn say(&self, sequence: u8, ack: Ack) -> Received {
        let line = Line {
            sequence,
            body: Body::State(StateLine {
                mode: self.mode,
                ..StateLine::BLANK
            }),
            ack,
        };
        let received = Decoder::default().lines(&line.encode()).next();
        received.expect("what was encoded is read")
    }
}

/// The task that sent this list; `u16::MAX` for none.
pub fn task_of_list(list: &[Waypoint]) -> TaskId {
    list.first().map_or(TaskId::MAX, |w| w.x_in as TaskId)
}
