//! The bytes of one read, as every reader of captures returns them.

use std::collections::BTreeMap;
use std::time::Duration;

use groundwave_protocol::decoder::{Counters, Decoder};

/// Bytes that were received together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Chunk<'a> {
    /// Time since the capture began. Without timestamps in a raw capture, the time is that of a 2400-baud radio without
    /// pauses.
    pub at: Duration,
    /// Whether the time was measured.
    pub has_time: bool,
    /// The bytes.
    pub bytes: &'a [u8],
    /// Whether bytes are missing before these.
    pub is_after_missing: bool,
    /// Time at which the link was lost before these bytes, if it was.
    pub unplugged_at: Option<Duration>,
    /// Time at which the station was suspended before these bytes, if it was.
    pub suspended_at: Option<Duration>,
    /// Metadata of an MCAP read so far.
    pub session: Option<&'a BTreeMap<String, String>>,
}

impl Chunk<'_> {
    /// Whether the link was interrupted or bytes are missing before these; no line spans the gap.
    #[must_use]
    pub const fn is_interrupted(&self) -> bool {
        self.is_after_missing || self.unplugged_at.is_some()
    }

    /// Sets the time of these bytes in a decoder, if it was measured, and the gap before them.
    pub fn tell(&self, decoder: &mut Decoder) {
        if self.has_time {
            set_time(decoder, self.at);
        }
        if self.is_after_missing {
            decoder.skip();
        } else if self.unplugged_at.is_some() {
            decoder.interrupt();
        }
    }
}

/// The decoder's totals if the capture ends at a time.
pub(crate) fn counters_until(decoder: &Decoder, at: Duration) -> Counters {
    decoder.counters_until(milliseconds(at))
}

/// Sets the time of the next bytes in a decoder.
pub(crate) const fn set_time(decoder: &mut Decoder, at: Duration) {
    decoder.set_time(milliseconds(at));
}

const fn milliseconds(at: Duration) -> u64 {
    at.as_millis() as u64
}
