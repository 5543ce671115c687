//! What the operator and the clients of the shared link request: commands, hand drive, and giving both up.

use std::time::Duration;

use super::delivery::unsent;
use super::{Sending, Station, Waiting, micros};
use crate::event::{CommandId, CommandStatus, Event, Failure, Moment};
use crate::request::Request;
use crate::share::ClientLine;

/// Lines with values of a robot that has only lines of its own, before it is refused commands.
const OWN_LINES_MIN: u64 = 10;

/// Time for which a drive key is valid unless it is pressed again.
const DRIVE_LEASE: Duration = Duration::from_millis(500);

impl Station {
    /// Queues a request; returns the command's number. `by` names a client of the shared link.
    pub fn handle_request(
        &mut self,
        now: Moment,
        request: Request,
        by: Option<String>,
    ) -> CommandId {
        let id = CommandId(self.next_id);
        self.next_id += 1;
        self.meter.take_asked(now, id);
        self.events.push_back(Event::Asked {
            id,
            request: request.clone(),
            by,
        });
        let is_late = match &self.shared {
            Some(shared) => !shared.is_open(),
            None => self.is_attended && self.sending == Sending::Later,
        };
        if self.sending == Sending::Never {
            self.report(now, id, CommandStatus::Failed(Failure::ReceiveOnly));
        } else if is_late && request != Request::Stop {
            self.report(now, id, CommandStatus::Failed(Failure::NotSent));
        } else if let (Some(uplink), None) = (&mut self.own_uplink, &self.shared) {
            uplink.handle_request(now, id, &request);
            self.settle_own(now);
        } else if request == Request::Stop {
            self.cancel_waiting(now, Failure::Stopped);
            self.give_up_tuning(now, Failure::Stopped);
            self.stops.push((id, 0));
            self.stopped = true;
            match &mut self.shared {
                Some(shared) => shared.stop(id),
                None => self.fop.stop(micros(now)),
            }
        } else if self.shared.is_none() && self.has_only_own_lines() {
            self.report(now, id, CommandStatus::Failed(Failure::NotConfigured));
        } else {
            self.waiting.push_back(Waiting { id, request });
        }
        self.settle(now);
        id
    }

    /// Whether nearly all lines are the robot's own, with values. Damaged lines of Groundwave's look like them now and then.
    const fn has_only_own_lines(&self) -> bool {
        let counters = self.decoder.counters();
        counters.received() == 0
            && self.own_values >= OWN_LINES_MIN
            && self.own_values * 10 >= self.all_lines * 9
    }

    /// Drives by hand for half a second; call again to continue.
    pub fn handle_drive(&mut self, now: Moment, velocity_in_s: i8, rotation_in_s: i8) {
        match &mut self.shared {
            _ if self.sending != Sending::Now || self.own_uplink.is_some() => {}
            Some(shared) => shared.push(ClientLine::Drive {
                velocity_in_s,
                rotation_in_s,
            }),
            None => {
                let until_us = micros(now + DRIVE_LEASE);
                self.fop
                    .drive(micros(now), velocity_in_s, rotation_in_s, until_us);
            }
        }
    }

    /// Ends hand drive; the robot stops.
    pub fn handle_drive_end(&mut self, now: Moment) {
        if self.shared.is_some() {
            self.handle_drive(now, 0, 0);
        } else if self.sending == Sending::Now {
            self.fop.drive(micros(now), 0, 0, micros(now));
        }
    }

    /// Cancels all commands, an unconfirmed STOP included.
    pub fn handle_cancel(&mut self, now: Moment) {
        if let (Some(uplink), None) = (&mut self.own_uplink, &self.shared) {
            uplink.cancel(Failure::Cancelled, None);
            return self.settle_own(now);
        }
        self.cancel_waiting(now, Failure::Cancelled);
        self.give_up_tuning(now, Failure::Cancelled);
        if let Some(id) = self.current.filter(|_| self.shared.is_some()) {
            self.handle_give_up(now, id, Failure::Cancelled);
        }
        if let Some(shared) = &mut self.shared {
            for (id, _) in &self.stops {
                shared.push(ClientLine::Cancel(id.0));
            }
            self.end_stops(now, CommandStatus::Failed(Failure::Cancelled), 0);
        }
        self.fop.cancel_stop();
        self.fop.cancel();
        self.settle(now);
    }

    /// Ends a command for a reason, such as a passed timeout; a STOP continues unless it is cancelled.
    pub fn handle_give_up(&mut self, now: Moment, id: CommandId, mut why: Failure) {
        if let (Some(uplink), None) = (&mut self.own_uplink, &self.shared) {
            uplink.cancel(why, Some(id));
            return self.settle_own(now);
        }
        if self.current == Some(id) {
            why = self.unless_sent(why);
            self.current = None;
            self.tuner = None;
            self.fop.cancel();
            if let Some(shared) = &mut self.shared {
                shared.push(ClientLine::Cancel(id.0));
            }
        } else if let Some(at) = self.waiting.iter().position(|waiting| waiting.id == id) {
            self.waiting.remove(at);
            why = unsent(why);
        } else if let Some(at) = self.stops.iter().position(|(stop, _)| *stop == id)
            && why == Failure::Cancelled
        {
            self.stops.remove(at);
            if let Some(shared) = &mut self.shared {
                shared.push(ClientLine::Cancel(id.0));
            } else if self.stops.is_empty() {
                self.fop.cancel_stop();
            }
        } else {
            return;
        }
        self.report(now, id, CommandStatus::Failed(why));
        self.settle(now);
    }

    pub(super) fn cancel_waiting(&mut self, now: Moment, failure: Failure) {
        for waiting in std::mem::take(&mut self.waiting) {
            self.report(now, waiting.id, CommandStatus::Failed(failure));
        }
    }
}
