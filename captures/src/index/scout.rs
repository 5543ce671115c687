//! Looks through lines for landmarks without a model, which takes a fifth of the time.

use groundwave_protocol::decoder::{Decoder, Received};
use groundwave_protocol::telemetry::{Ack, Body};

use crate::event::Landmark;
use crate::topics::is_contact;

/// Sees every landmark of its kind, and may see some that are none.
#[derive(Debug)]
pub(super) struct Scout {
    kind: Kind,
    decoder: Decoder,
}

#[derive(Debug)]
enum Kind {
    Bump,
    /// With what the robot has acknowledged.
    Command(Option<(u8, u8, u8, u8)>),
}

impl Scout {
    /// One for a kind that the lines alone tell of; `None` for another.
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

    /// Takes what was received next; whether there may be one in it.
    pub(super) fn sees_one(&mut self, mut bytes: &[u8]) -> bool {
        let mut sees_one = false;
        while !bytes.is_empty() {
            let (taken, received) = self.decoder.handle_bytes(bytes);
            bytes = &bytes[taken..];
            sees_one |= received.is_some_and(|received| self.is_one(&received));
        }
        sees_one
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
                let told = |ack: &Ack| (ack.boot, ack.session, ack.sequence, ack.outcome as u8);
                let told = Some(told(received.ack()));
                std::mem::replace(known, told) != told
            }
        }
    }
}
