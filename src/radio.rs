//! What kind of radio stands between the station and the robot.

use std::time::Duration;

use clap::ValueEnum;
use groundwave_protocol::arq::{Config, Duplex};
use serde::Deserialize;

/// A kind of radio.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RadioKind {
    /// Find out whether the robot takes turns
    #[default]
    Auto,
    /// Both ends talk at the same time
    Full,
    /// One end at a time; bytes are passed on at once
    Half,
    /// A pair of HC-12 modules: half duplex, buffered
    #[value(name = "hc-12")]
    #[serde(rename = "hc-12")]
    Hc12,
    /// A pair of `XBee` modules in transparent mode: half duplex, buffered
    #[value(help = "A pair of XBee modules in transparent mode: half duplex, buffered")]
    Xbee,
    /// No transmitter: never send a byte
    ReceiveOnly,
}

/// A radio as the operator describes it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Radio {
    /// What kind it is.
    pub kind: RadioKind,
    /// What it adds to the time on the wire, both ways together, if that is known better than from its kind.
    pub latency: Option<Duration>,
}

impl Radio {
    /// No transmitter.
    pub const RECEIVE_ONLY: Self = Self {
        kind: RadioKind::ReceiveOnly,
        latency: None,
    };

    /// Whether anything may be sent.
    #[must_use]
    pub fn can_send(self) -> bool {
        self.kind != RadioKind::ReceiveOnly
    }

    /// How command delivery behaves over it.
    #[must_use]
    pub fn config(self, owner: u16) -> Config {
        let config = Config::new(owner);
        let duplex = match self.kind {
            RadioKind::Auto | RadioKind::ReceiveOnly => Duplex::Unknown,
            RadioKind::Full => Duplex::Full,
            RadioKind::Half | RadioKind::Hc12 | RadioKind::Xbee => Duplex::Half,
        };
        let latency_us = match (self.latency, self.kind) {
            (Some(latency), _) => latency.as_micros() as u64,
            (None, RadioKind::Hc12) => HC_12_LATENCY_US,
            (None, RadioKind::Xbee) => XBEE_LATENCY_US,
            (None, _) => config.latency_us,
        };
        Config {
            duplex,
            latency_us,
            ..config
        }
    }
}

/// Two HC-12 add so much, both ways together, when a line has to be cut into packets: measured with
/// the simulated ones. Less, and orders time out (tests/link.rs).
const HC_12_LATENCY_US: u64 = 400_000;

/// Two `XBee` modules add so much, measured likewise.
const XBEE_LATENCY_US: u64 = 200_000;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_said_outranks_the_kind() {
        let told = Radio {
            kind: RadioKind::Hc12,
            latency: Some(Duration::from_millis(80)),
        };
        assert_eq!(told.config(1).latency_us, 80_000);
        assert_eq!(told.config(1).duplex, Duplex::Half);
        assert!(told.can_send());
        assert!(!Radio::RECEIVE_ONLY.can_send());
        assert_eq!(Radio::default().config(7), Config::new(7));
    }
}
