//! A station: the real FOP and its operator.

use groundwave_protocol::arq::{CommandStatus, Config, Duplex, Fop, FopEvent, Task};
use groundwave_protocol::command::{BLOCK_WAYPOINTS, Order};
use groundwave_protocol::digest::digest;
use groundwave_protocol::{BYTES_PER_S, Waypoint};
use std::hash::{Hash, Hasher};

use super::instants::Relative;
use super::robot::{Epoch, TaskId};
use crate::world::ROBOT_ID;

/// A task that an operator requests.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Request {
    /// An order that differs from all others.
    Order,
    /// A list with this number of blocks.
    List(usize),
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Ground {
    pub fop: Fop,
    /// Number of the station, part of its task numbers.
    number: usize,
    requests: Vec<Request>,
    /// Number of tasks begun.
    pub begun: usize,
    /// The current task.
    pub task: Option<TaskId>,
    /// The session that the station believes to be its own.
    pub epoch: Option<Epoch>,
    /// Numbers of STOPs that the robot had taken at the latest request for a STOP, and at the latest request that has been sent.
    pub stops_before: [u8; 2],
}

/// A duration longer than all steps between two timers in a search, microseconds.
const SILENCE_US: u64 = 1_000_000_000;

/// A duration longer than any number of silences in a search, microseconds.
const GIVE_UP_US: u64 = 1_000_000_000_000;

pub const US_PER_BYTE: u64 = 1_000_000 / BYTES_PER_S as u64;

impl Ground {
    pub fn new(number: usize, owner: u16, requests: &[Request]) -> Self {
        Self {
            fop: fop(owner),
            number,
            requests: requests.to_vec(),
            begun: 0,
            task: None,
            epoch: None,
            stops_before: [0; 2],
        }
    }

    pub fn hash_at<H: Hasher>(&self, now_us: u64, hasher: &mut H) {
        let mut relative = Relative {
            inner: hasher,
            now_us,
        };
        self.fop.hash(&mut relative);
        self.begun.hash(hasher);
        self.task.hash(hasher);
        self.epoch.hash(hasher);
        self.stops_before.hash(hasher);
    }

    /// Restarts the station; tasks not begun remain.
    pub fn restart(&mut self, owner: u16) {
        self.fop = fop(owner);
        self.task = None;
        self.epoch = None;
    }

    pub fn can_begin(&self) -> bool {
        !self.fop.is_busy() && self.begun < self.requests.len()
    }

    pub fn begin(&mut self, now_us: u64) {
        let request = self.requests[self.begun];
        let task = (1 + self.number * 10 + self.begun) as TaskId;
        let taken = match request {
            Request::Order => self.fop.start(now_us, Task::Order(order(task))),
            Request::List(blocks) => self.fop.start(now_us, Task::List(&list(task, blocks))),
        };
        assert!(taken, "an idle station takes a task");
        self.begun += 1;
        self.task = Some(task);
    }

    /// Whether `digest` belongs to a list of this station.
    pub fn sent_list(&self, active: &[Waypoint]) -> bool {
        self.requests
            .iter()
            .enumerate()
            .any(|(n, request)| match request {
                Request::Order => false,
                Request::List(blocks) => {
                    active == list((1 + self.number * 10 + n) as TaskId, *blocks)
                }
            })
    }

    /// The next frame, and the time at which its last byte was sent; `None` if no frame is due.
    pub fn transmit(&mut self, now_us: u64) -> Option<(Vec<u8>, u64)> {
        let mut frame = Vec::new();
        let mut at_us = now_us;
        loop {
            match self.fop.poll_transmit(at_us) {
                Some(chunk) => frame.extend(chunk),
                None if frame.is_empty() => return None,
                None => at_us += US_PER_BYTE,
            }
            if frame == b"\n" || frame.len() > 1 && frame.ends_with(b"\n") {
                let off_us = now_us + frame.len() as u64 * US_PER_BYTE;
                return Some((frame, off_us.max(at_us)));
            }
        }
    }

    pub fn next_event(&mut self) -> Option<FopEvent> {
        let event = self.fop.poll_event();
        match event {
            Some(FopEvent::Task(CommandStatus::Failed(_))) => self.task = None,
            Some(FopEvent::Stop(CommandStatus::Sent { .. })) => {
                self.stops_before[1] = self.stops_before[0];
            }
            _ => {}
        }
        event
    }
}

fn fop(owner: u16) -> Fop {
    Fop::new(Config {
        robot_id: Some(ROBOT_ID),
        silence_us: SILENCE_US,
        give_up_us: GIVE_UP_US,
        duplex: Duplex::Full,
        ..Config::new(owner)
    })
}

fn order(task: TaskId) -> Order {
    Order::Pose {
        position: Waypoint::default(),
        theta_deg: task,
    }
}

/// A list that differs from every other in every waypoint.
fn list(task: TaskId, blocks: usize) -> Vec<Waypoint> {
    (0..blocks * BLOCK_WAYPOINTS)
        .map(|n| Waypoint {
            x_in: task as i16,
            y_in: n as i16,
        })
        .collect()
}

/// The digest of the active list.
pub fn digest_of(active: &[Waypoint]) -> u32 {
    digest(active.iter())
}

/// Time until all timers of a kind have run out, shortest first.
pub const WAITS_US: [u64; 3] = [500_000, SILENCE_US + 1_000_000, GIVE_UP_US + 1_000_000];
