//! Replacement for the Foxglove server in a build without it.

use super::{Call, FoxgloveError};
use crate::capture::topics::TopicMessage;
use crate::share::Address;

/// A server that is never created.
#[derive(Debug)]
pub enum Foxglove {}

/// An answer that is never created.
#[derive(Debug)]
pub enum Answer {}

impl Foxglove {
    /// Fails, because the build has no server.
    ///
    /// # Errors
    /// Always.
    #[expect(clippy::unused_async, reason = "the server's own function waits")]
    pub async fn listen(_: &Address, _: bool, _: &str) -> Result<Self, FoxgloveError> {
        Err(FoxgloveError::Absent)
    }

    /// The server's address.
    #[must_use]
    pub fn address(&self) -> &str {
        match *self {}
    }

    /// Sends a message to a topic's subscribers.
    pub fn publish(&self, _: TopicMessage<'_>) {
        match *self {}
    }

    /// The next call of a client.
    #[expect(clippy::unused_async, reason = "the server's own function waits")]
    pub async fn next(&mut self) -> Call {
        match *self {}
    }
}

impl Answer {
    /// Answers.
    pub fn give(self, _: &[u8]) {
        match self {}
    }
}
