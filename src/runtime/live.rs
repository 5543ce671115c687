//! Live tools: joins [`Deriver`] and [`Calls`] to the Foxglove server.

use std::collections::BTreeMap;
use std::convert::Infallible;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use groundwave_protocol::decoder::Received;

use crate::capture::topics::{Deriver, TopicMessage};
use crate::event::{CommandId, Event, Moment};
use crate::io::foxglove::{Answer, Call, Foxglove};
use crate::recorded;
use crate::request::Request;
use crate::share::{CallId, CallOutput, Calls};

/// A request of the live tools to the station.
#[derive(Debug)]
pub(super) enum Wanted {
    /// Queue this request for the client `by`, then call [`Live::handle_started`] with the command's number.
    Start {
        call: CallId,
        request: Request,
        by: String,
    },
    /// Cancel this command, because its timeout has passed.
    GiveUp(CommandId),
}

/// A call that has not been answered.
struct Waiting {
    by: String,
    answer: Answer,
}

/// The server with its topics and calls.
pub(super) struct Live {
    server: Foxglove,
    deriver: Deriver,
    calls: Calls,
    waiting: BTreeMap<CallId, Waiting>,
    newest_call: u64,
    /// Wall-clock time at the station's start, since 1970.
    started_since_1970: Duration,
}

impl Live {
    /// Joins a server to a station; `now` is the station's current time.
    pub(super) fn new(server: Foxglove, now: Moment) -> Self {
        let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH);
        Self {
            server,
            deriver: Deriver::of_decoded_lines(),
            calls: Calls::default(),
            waiting: BTreeMap::new(),
            newest_call: 0,
            started_since_1970: since_1970.unwrap_or_default().saturating_sub(now),
        }
    }

    pub(super) fn address(&self) -> &str {
        self.server.address()
    }

    /// The next call. Cancel-safe.
    pub(super) async fn next(&mut self) -> Call {
        self.server.next().await
    }

    pub(super) fn handle_rx(&mut self, now: Moment, bytes: &[u8]) {
        let at_ns = self.since_1970_ns(now);
        let publish = publish_to(&self.server);
        let Ok(()) = self.deriver.handle_rx(at_ns, bytes, publish);
    }

    pub(super) fn handle_tx(&mut self, now: Moment, bytes: &[u8]) {
        let at_ns = self.since_1970_ns(now);
        let publish = publish_to(&self.server);
        let Ok(()) = self.deriver.handle_tx(at_ns, bytes, publish);
    }

    /// Publishes an event, and answers the call whose command has ended.
    pub(super) fn handle_event(&mut self, now: Moment, event: &Event) {
        if let Event::Command { id, status } = event {
            self.calls.handle_status(*id, status);
        }
        let at_ns = self.since_1970_ns(now);
        let publish = publish_to(&self.server);
        let received = match event {
            Event::Line { line, raw } => Some(Received::Line(**line, *raw)),
            Event::Ack(line) => Some(Received::Ack(*line)),
            _ => None,
        };
        if let Some(received) = received {
            let Ok(()) = self.deriver.handle_received(at_ns, &received, publish);
        } else if let Event::Own(line) = event {
            let Ok(()) = self.deriver.handle_own(at_ns, line, publish);
        } else if let Event::Outage(outage) = event {
            let zero_ns = self.since_1970_ns(Moment::ZERO);
            let Ok(()) = self.deriver.handle_outage(at_ns, zero_ns, outage, publish);
        } else if let Some(event) = recorded::to_recorded(now, event) {
            let Ok(()) = self.deriver.handle_event(at_ns, &event, publish);
        }
    }

    pub(super) fn handle_call(&mut self, now: Moment, call: Call) {
        self.newest_call += 1;
        let id = CallId(self.newest_call);
        let Call {
            by,
            payload,
            answer,
        } = call;
        self.waiting.insert(id, Waiting { by, answer });
        self.calls.handle_call(now, id, &payload);
    }

    pub(super) fn handle_started(&mut self, call: CallId, command: CommandId) {
        self.calls.handle_started(call, command);
    }

    pub(super) fn handle_timeout(&mut self, now: Moment) {
        self.calls.handle_timeout(now);
    }

    pub(super) fn poll_timeout(&self) -> Option<Moment> {
        self.calls.poll_timeout()
    }

    /// Sends the answers that are due; returns a request to the station.
    pub(super) fn poll(&mut self) -> Option<Wanted> {
        loop {
            match self.calls.poll_output()? {
                CallOutput::Answer(id, answer) => {
                    if let Some(waiting) = self.waiting.remove(&id) {
                        waiting.answer.give(&answer);
                    }
                }
                CallOutput::Start(call, request) => {
                    if let Some(Waiting { by, .. }) = self.waiting.get(&call) {
                        let by = by.clone();
                        return Some(Wanted::Start { call, request, by });
                    }
                }
                CallOutput::GiveUp(id) => return Some(Wanted::GiveUp(id)),
            }
        }
    }

    fn since_1970_ns(&self, now: Moment) -> u64 {
        let since_1970 = self.started_since_1970 + now;
        u64::try_from(since_1970.as_nanos()).unwrap_or(u64::MAX)
    }
}

fn publish_to(server: &Foxglove) -> impl FnMut(TopicMessage<'_>) -> Result<(), Infallible> {
    |message| {
        server.publish(message);
        Ok(())
    }
}
