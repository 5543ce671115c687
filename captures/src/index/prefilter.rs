//! Finds possible landmarks in lines, five times as fast as a search with the model.

use groundwave_protocol::decoder::{Decoder, Received};
use groundwave_protocol::telemetry::{Ack, Body};

use crate::event::Landmark;
use crate::topics::is_contact;

/// Finds every landmark of a kind; may also report lines without one.
#[derive(Debug)]
pub(super) struct Prefilter {
    kind: Kind,
    decoder: Decoder,
}

#[derive(Debug)]
enum Kind {
    Bump,
    /// Searches for commands; holds the robot's latest acknowledgement.
    Command(Option<(u8, u8, u8, u8)>),
}

impl Prefilter {
    /// A prefilter for landmarks that follow from the lines alone; `None` for others.
    pub(super) fn of(landmark: Landmark) -> Option<Self> {
        let kind = match landmark {
            Landmark::Bump => Kind::Bump,
            Landmark::Command => Kind::Command(None),
            Landmark::Line | Landmark::Alarm | Landmark::Behaviour | Landmark::Marker => {
                return None;
            }
        };
        let decoder = Decoder::default();
        Some(Self { kind, decoder })
    }

    /// Takes the next received bytes; returns whether they may contain a landmark.
    pub(super) fn may_hold(&mut self, mut bytes: &[u8]) -> bool {
        let mut may_hold = false;
        while let Some(received) = self.decoder.next_own_line(&mut bytes) {
            may_hold |= self.is_one(&received);
        }
        may_hold
    }

    fn is_one(&mut self, received: &Received) -> bool {
        match &mut self.kind {
            Kind::Bump => match received {
                Received::Line(line, _) => {
                    matches!(&line.body, Body::State(state) if is_contact(state.bump))
                }
                Received::Ack(_) => false,
            },
            Kind::Command(known) => {
                let key = |ack: &Ack| (ack.boot, ack.session, ack.sequence, ack.outcome as u8);
                let acknowledged = Some(key(received.ack()));
                std::mem::replace(known, acknowledged) != acknowledged
            }
        }
    }
}
