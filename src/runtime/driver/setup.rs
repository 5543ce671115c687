//! What a station does besides its link: sharing, recording, live tools, the hook of the alarms.

use std::collections::BTreeMap;

use groundwave_lines::{OwnCommand, Recognizer};

use super::{Advising, Driver, EventSink};
use crate::event::{Event, Level, Notice, NoticeCode, Truth};
use crate::io::alarm_hook::AlarmHook;
use crate::io::foxglove::Foxglove;
use crate::io::share::Share;
use crate::runtime::live::Live;
use crate::runtime::share_server::ShareServer;

impl Driver {
    /// Serves an operator who watches.
    #[must_use]
    pub fn attended(mut self) -> Self {
        self.station.set_attended();
        self
    }

    /// Shows the world of a simulated robot, here and to the clients of the link. Call after [`Self::shared`].
    #[must_use]
    pub fn simulating(mut self, truth: Option<Truth>) -> Self {
        if let (Some(truth), Some(server)) = (&truth, &mut self.share) {
            server.broker.handle_truth(truth.clone());
        }
        self.events.extend(truth.map(Event::Truth));
        self
    }

    /// Sets the link's rate, if it is known; frames are paced and airtime is measured by this rate.
    #[must_use]
    pub fn at_baud(mut self, baud: Option<u32>) -> Self {
        if let Some(baud) = baud {
            self.station.set_baud(baud);
        }
        self
    }

    /// Enables notices about a link without intact lines. `baud` is the port's rate, if the station sets it.
    #[must_use]
    pub fn advising(mut self, baud: Option<u32>) -> Self {
        self.advising = Some(Advising {
            baud,
            has_complained: false,
        });
        self
    }

    /// Reads the lines of a robot that does not use Groundwave's protocol, and sends its command strings.
    #[must_use]
    pub fn reading(mut self, own: Recognizer, commands: BTreeMap<String, OwnCommand>) -> Self {
        self.station.set_own_lines(own);
        self.station.set_own_commands(commands);
        self
    }

    /// Passes every event to a sink, in the order of [`Self::poll_event`].
    #[must_use]
    pub fn observed_by(mut self, observer: EventSink) -> Self {
        self.observer = Some(observer);
        self
    }

    /// Shares the link.
    #[must_use]
    pub fn shared(mut self, share: Option<Share>) -> Self {
        if let Some(share) = share {
            let server = ShareServer::new(share, &self.name, self.can_send());
            self.events.push_back(Event::Notice(Notice::new(
                NoticeCode::Shared,
                Level::Info,
                format!("shared on {}", server.address()),
            )));
            self.share = Some(server);
        }
        self
    }

    /// Passes every event of an alarm to the operator's command. Call after [`Self::shared`].
    #[must_use]
    pub fn hooked(mut self, hook: Option<AlarmHook>) -> Self {
        self.alarm_hook = hook;
        self.tell_clients_of_hook();
        self
    }

    /// Serves live tools.
    #[must_use]
    pub fn watched(mut self, server: Option<Foxglove>) -> Self {
        if let Some(server) = server {
            let live = Live::new(server, self.now());
            self.events.push_back(Event::Notice(Notice::new(
                NoticeCode::Foxglove,
                Level::Info,
                format!("Foxglove at {}", live.address()),
            )));
            self.live = Some(live);
        }
        self
    }
}
