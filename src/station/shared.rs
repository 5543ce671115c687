//! Delivers commands through another station that shares its link: commands are sent as lines, and answers become statuses.
//!
//! One command at a time is in progress, as on a radio; STOP overtakes. A STOP is repeated on the next connection. Any other
//! command that was in progress on a lost connection is reported as not confirmed. Further commands are not sent, because another client may stop the robot
//! before the next connection.

use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

use super::{Station, Waiting};
use crate::event::{Answer, CommandId, CommandStatus, Event, Failure, Level, Moment, NoticeCode};
use crate::request::Request;
use crate::share::{Ask, ClientLine, StationLine, StatusJson};

/// Timeout of a command. If the robot does not answer, the other station gives up much earlier.
const TIMEOUT: Duration = Duration::from_mins(10);

/// Lines for the other station.
#[derive(Clone, Debug, Default)]
pub(super) struct Shared {
    is_open: bool,
    lines: VecDeque<ClientLine>,
    /// Open commands of the other station's operator and its other clients: their numbers here, by those there.
    others: BTreeMap<u32, CommandId>,
}

impl Shared {
    fn ask(&mut self, id: CommandId, request: Request) {
        let ask = Ask {
            tag: id.0,
            request,
            timeout: TIMEOUT,
        };
        self.lines.push_back(ClientLine::Ask(ask));
    }

    pub(super) fn push(&mut self, line: ClientLine) {
        if self.is_open {
            self.lines.push_back(line);
        }
    }

    /// Sends a STOP now, or on the next connection.
    pub(super) fn stop(&mut self, id: CommandId) {
        if self.is_open {
            self.ask(id, Request::Stop);
        }
    }

    pub(super) const fn is_open(&self) -> bool {
        self.is_open
    }

    /// Sends a command; returns `false` if the connection is lost.
    pub(super) fn begin(&mut self, next: &Waiting) -> bool {
        if self.is_open {
            self.ask(next.id, next.request.clone());
        }
        self.is_open
    }
}

impl Station {
    /// Takes a new connection; `is_shared` if another station shares this link and therefore sends the commands.
    pub fn handle_shared(&mut self, now: Moment, is_shared: bool) {
        if !is_shared {
            self.shared = None;
            return;
        }
        if self.is_shared() {
            return;
        }
        self.fop.cancel();
        let mut shared = Shared {
            is_open: true,
            ..Shared::default()
        };
        for (id, _) in &self.stops {
            shared.ask(*id, Request::Stop);
        }
        self.shared = Some(shared);
        self.settle(now);
    }

    /// Whether a connected station sends the commands.
    #[must_use]
    pub fn is_shared(&self) -> bool {
        self.shared.as_ref().is_some_and(|shared| shared.is_open)
    }

    /// Takes the loss of the connection to the other station.
    pub fn handle_shared_lost(&mut self, now: Moment) {
        if self.is_shared() {
            let lost = self.shared.replace(Shared::default());
            for id in lost.into_iter().flat_map(|lost| lost.others.into_values()) {
                let status = CommandStatus::Failed(Failure::TimedOut);
                self.events.push_back(Event::Command { id, status });
            }
            if let Some(id) = self.current.take() {
                self.report(now, id, CommandStatus::Failed(Failure::TimedOut));
            }
            self.cancel_waiting(now, Failure::NotSent);
        }
    }

    /// Takes a line of the other station.
    pub fn handle_shared_line(&mut self, now: Moment, line: &StationLine) {
        match line {
            StationLine::Status { id, status, .. } => {
                if let Some(status) = status.status() {
                    self.take_shared_status(now, CommandId(*id), status);
                }
            }
            StationLine::Lost { lost } => {
                let text = format!("the station lost its link: {lost}");
                self.notice(NoticeCode::SharingStation, Level::Warning, &text);
            }
            StationLine::Error { error, .. } => {
                let text = format!("the station closed the connection: {error}");
                self.notice(NoticeCode::SharingStation, Level::Warning, &text);
            }
            StationLine::Asked {
                command,
                by,
                request,
            } => {
                if let (Some(shared), Ok(request)) = (&mut self.shared, request.clone().read()) {
                    let id = CommandId(self.next_id);
                    self.next_id += 1;
                    shared.others.insert(*command, id);
                    let by = Some(by.clone());
                    self.events.push_back(Event::Asked { id, request, by });
                }
            }
            StationLine::Command { command, status } => self.take_others_status(*command, status),
            StationLine::Answered(answered) => {
                self.events.push_back(Event::AlarmAnswer(answered.clone()));
            }
            // Texts of the robot come with its lines.
            StationLine::Welcome(_) | StationLine::Said { .. } | StationLine::Received { .. } => {}
        }
    }

    fn take_shared_status(&mut self, now: Moment, id: CommandId, status: CommandStatus) {
        if status == CommandStatus::Queued {
            return;
        }
        if let Some(at) = self.stops.iter().position(|(stop, _)| *stop == id) {
            if status.is_end() {
                self.stops.remove(at);
            }
        } else if self.current != Some(id) {
            return;
        } else if status.is_end() {
            self.current = None;
        }
        self.report(now, id, status);
        self.settle(now);
    }

    /// Takes the status of a command that this station did not give.
    fn take_others_status(&mut self, command: u32, status: &StatusJson) {
        let Some(shared) = &mut self.shared else {
            return;
        };
        if let Some(status) = status.status()
            && status != CommandStatus::Queued
            && let Some(&id) = shared.others.get(&command)
        {
            if status.is_end() {
                shared.others.remove(&command);
            }
            self.events.push_back(Event::Command { id, status });
        }
    }

    /// Passes an answer to an alarm to the other station, if there is one.
    pub fn handle_answer(&mut self, alarm: &str, answer: Answer) {
        if let Some(shared) = &mut self.shared {
            let alarm = alarm.to_owned();
            shared.push(ClientLine::Answer { alarm, answer });
        }
    }

    /// The next line for the other station.
    pub fn poll_shared_line(&mut self) -> Option<ClientLine> {
        self.shared.as_mut()?.lines.pop_front()
    }
}
