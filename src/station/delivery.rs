//! Delivery of commands: starts the next command and reports its statuses.

use groundwave_protocol::arq::{FopEvent, Task};
use groundwave_protocol::command::Order;
use groundwave_protocol::status_codes::LayerMask;
use groundwave_protocol::telemetry::Outcome;

use super::tuner::{self, Tuner, Verdict};
use super::{Station, Waiting, micros};
use crate::event::{CommandId, CommandStatus, Event, Failure, Level, Moment, NoticeCode};
use crate::request::{Request, Tuning};

impl Station {
    pub(super) fn settle(&mut self, now: Moment) {
        self.drain_fop(now);
        self.pause_list();
        while self.current.is_none() && self.begin_next(now) {
            self.drain_fop(now);
        }
    }

    /// Puts a list of parameters, which takes half a minute, behind the other commands.
    fn pause_list(&mut self) {
        let list = Request::Parameter(Tuning::List);
        if self.waiting.iter().all(|waiting| waiting.request == list) {
            return;
        }
        let Some(id) = self.current else {
            return;
        };
        if let Some(tuner) = self.tuner.take_if(|tuner| tuner.is_listening_to_list()) {
            self.current = None;
            self.paused_list = Some((id, tuner));
            self.waiting.push_back(Waiting { id, request: list });
        }
    }

    /// Starts the next command; returns `false` if no command waits.
    pub(super) fn begin_next(&mut self, now: Moment) -> bool {
        if let Some(shared) = &mut self.shared {
            let next = self.waiting.pop_front_if(|next| shared.begin(next));
            self.current = next.map(|next| next.id);
            return false;
        }
        let Some(Waiting { id, request }) = self.waiting.pop_front() else {
            return false;
        };
        self.frames = 0;
        let now_us = micros(now);
        let started = match &request {
            Request::Route(waypoints) => self.fop.start(now_us, Task::List(waypoints)),
            Request::Parameter(tuning) => {
                let paused = self.paused_list.take_if(|(paused, _)| *paused == id);
                let (tuner, order) = match paused {
                    Some((_, tuner)) => {
                        self.frames = 1;
                        tuner.resume()
                    }
                    None => Tuner::begin(*tuning),
                };
                self.tuner = Some(tuner);
                self.fop.start(now_us, Task::Order(order))
            }
            request => {
                order(request).is_some_and(|order| self.fop.start(now_us, Task::Order(order)))
            }
        };
        if started {
            self.current = Some(id);
        } else {
            // No command is in progress, so the list fits into no frame.
            self.report(now, id, CommandStatus::Refused(Outcome::BadValue));
        }
        true
    }

    pub(super) fn drain_fop(&mut self, now: Moment) {
        while let Some(event) = self.fop.poll_event() {
            match event {
                FopEvent::Session(Ok(())) => {
                    self.stopped = false;
                    self.notice(NoticeCode::SessionOpened, Level::Info, "session opened");
                }
                FopEvent::Session(Err(failure)) => {
                    self.give_up_tuning(now, failure);
                    // A robot that has restarted may have other values.
                    self.paused_list = None;
                    // The statuses of the commands say what an own STOP ended.
                    if failure != Failure::Stopped || !self.stopped {
                        let text = lost_session(failure);
                        self.notice(NoticeCode::SessionEnded, Level::Warning, text);
                    }
                }
                FopEvent::Task(status) => self.take_status(now, status),
                FopEvent::Stop(status) => self.take_stop_status(now, status),
                FopEvent::EarlierStop { later } => {
                    let confirmed = CommandStatus::Confirmed { digest: None };
                    self.end_stops(now, confirmed, later + 1);
                }
            }
        }
    }

    fn take_status(&mut self, now: Moment, status: CommandStatus) {
        if let Some(tuner) = &mut self.tuner {
            let outcome = match status {
                CommandStatus::Confirmed { .. } => Some(Outcome::Done),
                CommandStatus::Refused(outcome) => Some(outcome),
                _ => None,
            };
            if let Some(outcome) = outcome {
                let verdict = tuner.take_outcome(now, outcome);
                return self.follow(now, verdict);
            }
        }
        if status.is_end() {
            self.tuner = None;
            let status = match status {
                CommandStatus::Failed(why) => CommandStatus::Failed(self.unless_sent(why)),
                _ => status,
            };
            if let Some(id) = self.current.take() {
                self.report(now, id, status);
            }
        } else {
            if let CommandStatus::Sent { frames } = status {
                self.frames = self.frames.max(frames);
            }
            self.report_current(now, status);
        }
    }

    /// Why the current command failed: the robot cannot have heard what was never sent.
    pub(super) fn unless_sent(&self, why: Failure) -> Failure {
        if self.frames > 0 || self.shared.is_some() {
            why
        } else {
            unsent(why)
        }
    }

    fn take_stop_status(&mut self, now: Moment, status: CommandStatus) {
        match status {
            CommandStatus::Sent { .. } => {
                for (_, sent) in &mut self.stops {
                    *sent = sent.saturating_add(1);
                }
                let new = self.stops.iter().filter(|(_, sent)| *sent == 1);
                for id in new.map(|(id, _)| *id).collect::<Vec<_>>() {
                    self.report(now, id, status);
                }
            }
            CommandStatus::Confirmed { .. } => self.end_stops(now, status, 1),
            CommandStatus::Failed(Failure::TimedOut) if self.is_attended => {
                self.fop.stop(micros(now));
            }
            CommandStatus::Failed(why) if self.stops.iter().all(|(_, sent)| *sent == 0) => {
                self.end_stops(now, CommandStatus::Failed(unsent(why)), 0);
            }
            _ => self.end_stops(now, status, 0),
        }
    }

    /// Ends the STOPs after which at least `sent` STOP frames were sent.
    pub(super) fn end_stops(&mut self, now: Moment, status: CommandStatus, sent: u16) {
        let ended = self.stops.partition_point(|stop| stop.1 >= sent);
        for (id, _) in self.stops.drain(..ended).collect::<Vec<_>>() {
            self.report(now, id, status);
        }
    }

    /// Carries out the verdict about a parameter command.
    pub(super) fn follow(&mut self, now: Moment, verdict: Verdict) {
        let end = match verdict {
            Verdict::Wait => return,
            Verdict::Ask(order) => {
                // The verdict is about the current command.
                self.fop.start(micros(now), Task::Order(order));
                return;
            }
            Verdict::Confirmed => CommandStatus::Confirmed { digest: None },
            Verdict::Refused(outcome) => CommandStatus::Refused(outcome),
            Verdict::TimedOut => CommandStatus::Failed(Failure::TimedOut),
        };
        self.tuner = None;
        if let Some(id) = self.current.take() {
            self.report(now, id, end);
        }
        self.settle(now);
    }

    /// Ends a parameter command, which may wait for a line P while the FOP is idle.
    pub(super) fn give_up_tuning(&mut self, now: Moment, failure: Failure) {
        if self.tuner.take().is_some()
            && let Some(id) = self.current.take()
        {
            self.report(now, id, CommandStatus::Failed(failure));
        }
    }

    pub(super) fn report_current(&mut self, now: Moment, status: CommandStatus) {
        if let Some(id) = self.current {
            self.report(now, id, status);
        }
    }

    pub(super) fn report(&mut self, now: Moment, id: CommandId, status: CommandStatus) {
        if status.is_end() {
            let is_confirmed = matches!(status, CommandStatus::Confirmed { .. });
            self.meter.take_end(now, id, is_confirmed);
        }
        self.events.push_back(Event::Command { id, status });
    }
}

/// The order of a request; `None` for a request without an order.
pub(super) fn order(request: &Request) -> Option<Order> {
    Some(match request {
        Request::Stop | Request::Route(_) | Request::Own(_) => return None,
        Request::Mode(mode) => Order::Mode(*mode),
        Request::Enable(layers) => Order::Layers {
            which: *layers,
            allowed: *layers,
        },
        Request::Disable(layers) => Order::Layers {
            which: *layers,
            allowed: LayerMask::NONE,
        },
        Request::Only(layers) => Order::Layers {
            which: LayerMask::ALL,
            allowed: *layers,
        },
        Request::Failsafe(failsafe) => Order::Failsafe(*failsafe),
        Request::Parameter(tuning) => tuner::order(tuning),
        Request::Pose {
            position,
            theta_deg,
        } => Order::Pose {
            position: *position,
            theta_deg: *theta_deg,
        },
        Request::Scan => Order::Scan,
    })
}

const fn lost_session(loss: Failure) -> &'static str {
    match loss {
        Failure::RobotRestarted => {
            "the robot restarted: session, staged list and active list are lost"
        }
        Failure::TakenOver => {
            "another station opened a session: this one sends nothing until you do"
        }
        Failure::Stopped => {
            "the robot ended all earlier commands: a STOP from elsewhere, or a restart"
        }
        Failure::CannotHear => "the robot cannot hear",
        Failure::TimedOut
        | Failure::NotSent
        | Failure::Cancelled
        | Failure::ReceiveOnly
        | Failure::BeyondLevel(_)
        | Failure::BeyondCapacity(_)
        | Failure::NotConfigured => "session given up",
    }
}

/// Why a command failed of which no frame was sent.
pub(super) const fn unsent(why: Failure) -> Failure {
    match why {
        Failure::TimedOut => Failure::NotSent,
        _ => why,
    }
}
