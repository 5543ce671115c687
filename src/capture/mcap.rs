//! The MCAP form of a capture: <https://mcap.dev/spec>. Written by [`super::writer`], read by
//! [`super::mcap_reader`].

use super::topics::Topic;

/// Every byte read from the radio.
pub const RAW_RX: &str = Topic::RawRx.name();
/// Every byte sent to the radio.
pub const RAW_TX: &str = Topic::RawTx.name();
/// Every intact line, decoded.
pub const TELEMETRY: &str = Topic::Telemetry.name();
