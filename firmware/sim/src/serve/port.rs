//! The interface of an endpoint.

use std::time::Instant;

/// A connection to the radio. Neither direction blocks.
pub trait Port: Send {
    /// Writes bytes to every client.
    fn write(&mut self, bytes: &[u8], now: Instant);
    /// Appends the bytes that clients have sent to the robot.
    fn read(&mut self, into: &mut Vec<u8>);
}
