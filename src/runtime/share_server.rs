//! The share server: joins the [`Broker`] to its sockets.

use std::time::{SystemTime, UNIX_EPOCH};

use crate::event::{
    AlarmAnswer, CommandId, Event, Failure, Level, LinkEvent, Moment, Notice, NoticeCode, Truth,
};
use crate::io::share::{FromClient, Share};
use crate::share::{Answers, Asked, Broker, Heard, Output, StationLine};

/// The clients of a shared link.
#[derive(Debug)]
pub(super) struct ShareServer {
    share: Share,
    broker: Broker,
}

/// A request of the share server to the station.
#[derive(Debug)]
pub(super) enum Wanted {
    /// End a command for a reason.
    GiveUp(CommandId, Failure),
    /// Drive by hand for half a second; zeros stop the robot.
    Drive {
        /// Forward speed, in/s.
        velocity_in_s: i8,
        /// Speed of the left wheel minus that of the right wheel, in/s.
        rotation_in_s: i8,
    },
    /// Take an operator's answer to an alarm.
    Answered(AlarmAnswer),
    /// Log this notice.
    Tell(Notice),
}

impl ShareServer {
    pub(super) fn new(share: Share, link: &str, can_send: bool) -> Self {
        let mut broker = Broker::new(link.to_owned(), can_send);
        if let Ok(began) = SystemTime::now().duration_since(UNIX_EPOCH) {
            broker.set_began(began.as_millis() as u64);
        }
        Self { share, broker }
    }

    pub(super) fn address(&self) -> &str {
        self.share.address()
    }

    /// The next input from a client. Cancel-safe.
    pub(super) async fn next(&mut self) -> FromClient {
        self.share.next().await
    }

    /// Takes an input from a client; returns a command for the station.
    pub(super) fn handle(
        &mut self,
        now: Moment,
        input: FromClient,
        answers: &Answers,
    ) -> Option<Asked> {
        match input {
            FromClient::Connected { client, peer } => self.broker.handle_connected(client, peer),
            FromClient::Line { client, line } => {
                let line = line.as_deref().map_err(|error| *error);
                return self.broker.handle_line(now, client, line, answers);
            }
            FromClient::TooSlow {
                client,
                unread_bytes,
            } => self.broker.handle_too_slow(client, unread_bytes),
            FromClient::GaveWay { client } => self.broker.handle_gave_way(client),
            FromClient::Gone { client } => self.broker.handle_gone(client),
        }
        None
    }

    /// Sets whether the station, or the one before it, runs the operator's command for alarms.
    pub(super) const fn set_runs_alarm_hook(&mut self, runs: bool) {
        self.broker.set_runs_alarm_hook(runs);
    }

    /// Takes the answer of the station's operator to an alarm.
    pub(super) fn handle_answer(&mut self, answered: &AlarmAnswer) {
        self.broker.handle_answer(None, answered);
    }

    /// Takes the world of a simulated robot, for the clients' maps.
    pub(super) fn handle_truth(&mut self, truth: Truth) {
        self.broker.handle_truth(truth);
    }

    pub(super) fn handle_started(
        &mut self,
        now: Moment,
        id: CommandId,
        asked: &Asked,
        heard: Heard,
    ) {
        self.broker.handle_started(now, id, asked, heard);
    }

    /// Passes an event to the clients that it concerns.
    pub(super) fn handle_event(&mut self, event: &Event, heard: Heard) {
        match event {
            Event::Asked { id, request, by } => {
                self.broker.handle_asked(*id, request, by.as_deref(), heard);
            }
            Event::Command { id, status } => self.broker.handle_status(*id, status, heard),
            Event::Link(LinkEvent::Lost { reason }) => self.broker.handle_lost(reason),
            Event::Line { line, .. } => self.broker.handle_body(&line.body),
            _ => {}
        }
    }

    /// Passes to the clients what the station before this one tells.
    pub(super) fn pass_on(&mut self, line: &StationLine) {
        self.broker.pass_on(line);
    }

    pub(super) fn handle_timeout(&mut self, now: Moment, heard: Heard) {
        self.broker.handle_timeout(now, heard);
    }

    pub(super) fn poll_timeout(&self) -> Option<Moment> {
        self.broker.poll_timeout()
    }

    /// Carries out requests to the sockets; returns a request to the station.
    pub(super) fn poll(&mut self) -> Option<Wanted> {
        loop {
            match self.broker.poll_output()? {
                Output::Converse { client, raw } => self.share.converse(client, raw),
                Output::Line(client, line) => self.share.send_line(client, &line),
                Output::Close(client) => self.share.close(client),
                Output::Busy(client, is_busy) => self.share.set_busy(client, is_busy),
                Output::Stopping(client) => self.share.start_stop(client),
                Output::GiveUp(id, why) => return Some(Wanted::GiveUp(id, why)),
                Output::Drive {
                    velocity_in_s,
                    rotation_in_s,
                } => {
                    return Some(Wanted::Drive {
                        velocity_in_s,
                        rotation_in_s,
                    });
                }
                Output::Answered(answered) => return Some(Wanted::Answered(answered)),
                Output::Warning(text) => {
                    return Some(Wanted::Tell(Notice::new(
                        NoticeCode::ShareClient,
                        Level::Warning,
                        format!("shared link: {text}"),
                    )));
                }
            }
        }
    }
}
