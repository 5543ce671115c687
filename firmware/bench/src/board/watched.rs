//! A house with an operator at the radio.

use std::collections::VecDeque;

use groundwave_protocol::BYTES_PER_S;
use groundwave_protocol::command::Order;
use groundwave_protocol::parameter::key;
use groundwave_protocol::telemetry::Body;

use super::checks::Programs;
use super::emulator::Loss;
use super::house::House;
use crate::operator::{Operator, Task};

/// Most bytes that a step takes.
const STEP_BYTES: usize = 255;

/// Time in which a robot tells its first lines.
pub(super) const FIRST_LINES_MS: u64 = 5000;

/// Time in which the operator's tasks are done.
const TASKS_MS: u64 = 30_000;

/// Time in which the robot has written its parameters, 3.4 ms a byte.
const WRITES_MS: u64 = 600;

/// Parameter that is kept.
pub(super) const KEPT: &str = "top-speed";

/// A house with an operator at the radio.
pub(super) struct Watched {
    pub(super) house: House,
    pub(super) operator: Operator,
    /// Bytes on their way to the board, and the time when they have come.
    queue: VecDeque<u8>,
    busy_to_ms: u64,
}

impl Watched {
    /// The whole program in a world.
    pub(super) fn start(programs: &Programs, world: &str, seed: u64) -> Result<Self, String> {
        Ok(Self {
            house: House::new(world, seed, &programs.emulator, &programs.full)?,
            operator: Operator::default(),
            queue: VecDeque::new(),
            busy_to_ms: 0,
        })
    }

    pub(super) fn step(&mut self) -> Result<(), String> {
        let count = self.queue.len().min(STEP_BYTES);
        let received: Vec<u8> = self.queue.drain(..count).collect();
        for byte in self.house.step(&received)? {
            self.operator.receive(byte);
        }
        let now_ms = self.house.now_ms;
        if let Some(ack) = self.house.ack
            && now_ms >= self.busy_to_ms
        {
            let bytes = self.operator.transmit(now_ms, ack);
            self.busy_to_ms = now_ms + bytes.len() as u64 * 1000 / u64::from(BYTES_PER_S) + 1;
            self.queue.extend(bytes);
        }
        Ok(())
    }

    pub(super) fn run_ms(&mut self, ms: u64) -> Result<(), String> {
        for _ in 0..ms {
            self.step()?;
        }
        Ok(())
    }

    /// Lets the robot do orders one after the other.
    pub(super) fn order(&mut self, orders: impl IntoIterator<Item = Order>) -> Result<(), String> {
        for order in orders {
            self.operator.queue(Task::Order(order));
        }
        let end_ms = self.house.now_ms + TASKS_MS;
        while !self.operator.is_idle() {
            if self.house.now_ms > end_ms {
                return Err("the robot does not confirm its orders".to_owned());
            }
            self.step()?;
        }
        Ok(())
    }

    /// Power is lost and restored.
    pub(super) fn lose_power(&mut self) -> Result<(), String> {
        self.house.emulator.lose_power()?;
        self.forget();
        Ok(())
    }

    /// Another boot needs another session, which the operator opens when it has heard of it.
    pub(super) fn forget(&mut self) {
        self.operator = Operator::default();
        self.house.forget();
        self.queue.clear();
    }

    /// Does the queued tasks; returns whether the chip is reset meanwhile, in a write of the EEPROM, the next one counted
    /// as 1.
    pub(super) fn is_lost_in(&mut self, write: u16, loss: Loss) -> Result<bool, String> {
        let boots = self.house.sent.len();
        self.house.emulator.lose_in(write, loss)?;
        let end_ms = self.house.now_ms + TASKS_MS;
        let mut rest_ms = WRITES_MS;
        while rest_ms > 0 {
            self.step()?;
            if self.house.sent.len() > boots {
                self.forget();
                return Ok(true);
            }
            if self.operator.is_idle() {
                rest_ms -= 1;
            } else if self.house.now_ms > end_ms {
                return Err("the robot does not confirm its orders".to_owned());
            }
        }
        self.house.emulator.lose_in(0, loss)?;
        Ok(false)
    }

    /// Keeps another value of a parameter again and again. The chip is reset in a write, each time `later` ones later, up to
    /// the time that has fewer writes.
    pub(super) fn keep(
        &mut self,
        kept: &mut i32,
        mut write: u16,
        later: u16,
        loss: Loss,
    ) -> Result<(), String> {
        loop {
            let value = if *kept == 5 { 9 } else { 5 };
            let set = Order::SetParameter {
                key: key(KEPT),
                value,
            };
            for order in [set, Order::KeepParameters] {
                self.operator.queue(Task::Order(order));
            }
            let is_lost = self.is_lost_in(write, loss)?;
            if !is_lost {
                self.lose_power()?;
            }
            while self.house.ack.is_none() {
                self.step()?;
            }
            let found = self.parameter(KEPT)?;
            if found != value && (found != *kept || !is_lost) {
                return Err(format!(
                    "{loss:?} lost in write {write}: {found}, not {kept} or {value}"
                ));
            }
            *kept = found;
            if !is_lost {
                return Ok(());
            }
            write += later;
        }
    }

    pub(super) fn newest_boots(&self) -> Result<u16, String> {
        let told = self.house.bodies(|body| match body {
            Body::Status(status) => Some(status.boots),
            _ => None,
        });
        told.last().copied().ok_or("no line B".to_owned())
    }

    /// Value of a parameter that the robot tells.
    pub(super) fn parameter(&mut self, name: &str) -> Result<i32, String> {
        let from = self.house.lines.len();
        self.order([Order::ReadParameter { key: key(name) }])?;
        for _ in 0..FIRST_LINES_MS {
            let told = self.house.lines.iter().skip(from);
            let mut values = told.filter_map(|(_, line)| match &line.body {
                Body::Parameter(parameter) if parameter.name.as_str() == name => {
                    Some(parameter.value)
                }
                _ => None,
            });
            if let Some(value) = values.next_back() {
                return Ok(value);
            }
            self.step()?;
        }
        Err(format!("no line P about {name}"))
    }
}
