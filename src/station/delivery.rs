//! Commands on their way: the next one begins, what the link's own end reports becomes a step, and each has its end.

use groundwave_protocol::arq::{FopEvent, Loss, Task};
use groundwave_protocol::command::Order;
use groundwave_protocol::status_codes::LayerMask;
use groundwave_protocol::telemetry::Outcome;

use super::tuner::{self, Tuner, Verdict};
use super::{Station, Waiting, micros};
use crate::event::{CommandId, CommandStep, Event, Failure, Level, Moment};
use crate::request::Request;

impl Station {
    pub(super) fn settle(&mut self, now: Moment) {
        self.drain_fop(now);
        while self.current.is_none() && self.begin_next(now) {
            self.drain_fop(now);
        }
    }

    /// Starts the next command; `false` when there is none.
    pub(super) fn begin_next(&mut self, now: Moment) -> bool {
        let Some(Waiting { id, request }) = self.waiting.pop_front() else {
            return false;
        };
        let now_us = micros(now);
        let started = match &request {
            Request::Route(waypoints) => self.fop.start(now_us, Task::List(waypoints)),
            Request::Parameter(wish) => {
                let (tuner, order) = Tuner::begin(*wish);
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
            // Nothing is under way, so it is the list that no frame can carry.
            self.step(now, id, CommandStep::Refused(Outcome::BadValue));
        }
        true
    }

    pub(super) fn drain_fop(&mut self, now: Moment) {
        while let Some(event) = self.fop.poll_event() {
            match event {
                FopEvent::Session(Ok(())) => {
                    self.stopped = false;
                    self.notice(Level::Info, "session opened");
                }
                FopEvent::Session(Err(loss)) => {
                    self.give_up_tuning(now, failure(loss));
                    self.notice(Level::Warning, lost_session(loss, self.stopped));
                }
                FopEvent::Sent { frames } => {
                    self.step_current(now, CommandStep::Sent { frames });
                }
                FopEvent::Progress {
                    acknowledged,
                    total,
                } => {
                    self.step_current(
                        now,
                        CommandStep::Progress {
                            acknowledged,
                            total,
                        },
                    );
                }
                FopEvent::Concluded { outcome, digest } => self.conclude(now, outcome, digest),
                FopEvent::Failed(loss) => {
                    self.tuner = None;
                    if let Some(id) = self.current.take() {
                        self.step(now, id, CommandStep::Failed(failure(loss)));
                    }
                }
                FopEvent::StopSent => {
                    for id in self.stops.clone() {
                        self.step(now, id, CommandStep::Sent { frames: 1 });
                    }
                }
                FopEvent::StopProven => {
                    for id in std::mem::take(&mut self.stops) {
                        self.step(now, id, CommandStep::Proven { digest: None });
                    }
                }
                FopEvent::StopFailed => {
                    for id in std::mem::take(&mut self.stops) {
                        self.step(now, id, CommandStep::Failed(Failure::TimedOut));
                    }
                }
            }
        }
    }

    pub(super) fn conclude(&mut self, now: Moment, outcome: Outcome, digest: Option<u32>) {
        if let Some(tuner) = &mut self.tuner {
            let verdict = tuner.take_outcome(now, outcome);
            self.follow(now, verdict);
            return;
        }
        let Some(id) = self.current.take() else {
            return;
        };
        if outcome == Outcome::Done {
            self.step(now, id, CommandStep::Proven { digest });
        } else {
            self.step(now, id, CommandStep::Refused(outcome));
        }
    }

    /// Goes on with a wish about parameters.
    pub(super) fn follow(&mut self, now: Moment, verdict: Verdict) {
        let end = match verdict {
            Verdict::Wait => return,
            Verdict::Ask(order) => {
                // Nothing else is under way: this wish is.
                self.fop.start(micros(now), Task::Order(order));
                return;
            }
            Verdict::Proven => CommandStep::Proven { digest: None },
            Verdict::Refused(outcome) => CommandStep::Refused(outcome),
            Verdict::TimedOut => CommandStep::Failed(Failure::TimedOut),
        };
        self.tuner = None;
        if let Some(id) = self.current.take() {
            self.step(now, id, end);
        }
        self.settle(now);
    }

    /// A wish about parameters that waits for a line is nothing that the sending end could lose.
    pub(super) fn give_up_tuning(&mut self, now: Moment, failure: Failure) {
        if self.tuner.take().is_some()
            && let Some(id) = self.current.take()
        {
            self.step(now, id, CommandStep::Failed(failure));
        }
    }

    pub(super) fn step_current(&mut self, now: Moment, step: CommandStep) {
        if let Some(id) = self.current {
            self.step(now, id, step);
        }
    }

    pub(super) fn step(&mut self, now: Moment, id: CommandId, step: CommandStep) {
        match &step {
            CommandStep::Proven { .. } => self.meter.take_end(now, id, true),
            CommandStep::Refused(_) | CommandStep::Failed(_) => self.meter.take_end(now, id, false),
            CommandStep::Queued(_)
            | CommandStep::Sent { .. }
            | CommandStep::Progress { .. }
            | CommandStep::Told(_) => {}
        }
        self.events.push_back(Event::Command { id, step });
    }
}

/// The order that a request stands for; `None` for what is no order.
pub(super) fn order(request: &Request) -> Option<Order> {
    Some(match request {
        Request::Stop | Request::Route(_) => return None,
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
        Request::Parameter(wish) => tuner::order(wish),
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

const fn lost_session(loss: Loss, stopped: bool) -> &'static str {
    match loss {
        Loss::RobotRestarted => {
            "the robot restarted: session, staged list and active list are gone"
        }
        Loss::TakenOver => "another station opened a session: this one sends nothing until you do",
        Loss::Stopped if stopped => "STOP ended the session",
        Loss::Stopped => "the robot ended the session: somebody else's STOP, or it restarted",
        Loss::TimedOut | Loss::Cancelled => "session given up",
    }
}

const fn failure(loss: Loss) -> Failure {
    match loss {
        Loss::TimedOut => Failure::TimedOut,
        Loss::RobotRestarted => Failure::RobotRestarted,
        Loss::TakenOver => Failure::TakenOver,
        Loss::Stopped => Failure::Stopped,
        Loss::Cancelled => Failure::Cancelled,
    }
}
