//! The share server: joins the [`Broker`] to its sockets.

use std::time::{SystemTime, UNIX_EPOCH};

use crate::event::{Event, LinkEvent, Moment};
use crate::io::share::{FromClient, Share};
use crate::share::{Answers, Asked, Broker, Heard, Output, ToClient, ToStation};

/// The clients of a shared link.
#[derive(Debug)]
pub(super) struct ShareServer {
    share: Share,
    pub(super) broker: Broker,
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

    /// Carries out requests to the sockets; returns a request to the station.
    pub(super) fn poll(&mut self) -> Option<ToStation> {
        loop {
            let (client, output) = match self.broker.poll_output()? {
                Output::Client(client, output) => (client, output),
                Output::Station(output) => return Some(output),
            };
            match output {
                ToClient::Converse { raw } => self.share.converse(client, raw),
                ToClient::Line(line) => self.share.send_line(client, &line),
                ToClient::Close => self.share.close(client),
                ToClient::Busy(is_busy) => self.share.set_busy(client, is_busy),
                ToClient::Stopping => self.share.start_stop(client),
            }
        }
    }
}
