//! The radio between station and robot.

use std::hash::{BuildHasher as _, RandomState};
use std::time::Duration;

use clap::ValueEnum;
use groundwave_protocol::arq::{Config, Duplex};
use serde::Deserialize;

/// A kind of radio.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RadioKind {
    /// Detect whether the robot takes turns
    #[default]
    Auto,
    /// Both ends send at the same time
    Full,
    /// One end sends at a time; bytes are not buffered
    Half,
    /// A pair of HC-12 modules: half duplex, buffered
    #[value(name = "hc-12")]
    #[serde(rename = "hc-12")]
    Hc12,
    /// A pair of `XBee` modules in transparent mode: half duplex, buffered
    #[value(help = "A pair of XBee modules in transparent mode: half duplex, buffered")]
    Xbee,
    /// Never send a byte
    ReceiveOnly,
}

/// A random nonce of 10 bits that identifies this station; not zero.
#[must_use]
pub fn random_owner() -> u16 {
    (RandomState::new().hash_one(std::process::id()) % 0x3FF) as u16 + 1
}

/// The radio as configured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Radio {
    /// Kind of the radio.
    pub kind: RadioKind,
    /// Latency that the radio adds to a round trip; `None` for the default of its kind.
    pub latency: Option<Duration>,
}

impl Radio {
    /// A radio without a transmitter.
    pub const RECEIVE_ONLY: Self = Self {
        kind: RadioKind::ReceiveOnly,
        latency: None,
    };

    /// Whether the station may send.
    #[must_use]
    pub fn can_send(self) -> bool {
        self.kind != RadioKind::ReceiveOnly
    }

    /// The configuration of command delivery over this radio.
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

/// Latency of two HC-12 modules in a round trip, microseconds, measured in the simulation. With less, commands time out
/// (tests/link.rs).
const HC_12_LATENCY_US: u64 = 400_000;

/// Latency of two `XBee` modules in a round trip, microseconds, measured in the simulation.
const XBEE_LATENCY_US: u64 = 200_000;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn configured_latency_outranks_the_kind() {
        let radio = Radio {
            kind: RadioKind::Hc12,
            latency: Some(Duration::from_millis(80)),
        };
        assert_eq!(radio.config(1).latency_us, 80_000);
        assert_eq!(radio.config(1).duplex, Duplex::Half);
        assert!(radio.can_send());
        assert!(!Radio::RECEIVE_ONLY.can_send());
        assert_eq!(Radio::default().config(7), Config::new(7));
    }
}
