//! What stands for the server in a program that was built without it.

use super::{Call, FoxgloveError};
use crate::capture::topics::TopicMessage;
use crate::share::Address;

/// A server that cannot be.
#[derive(Debug)]
pub enum Foxglove {}

/// An answer that nobody waits for.
#[derive(Debug)]
pub enum Answer {}

impl Foxglove {
    /// Says that there is none.
    ///
    /// # Errors
    /// Always.
    #[expect(clippy::unused_async, reason = "the server's own function waits")]
    pub async fn listen(_: &Address, _: bool, _: &str) -> Result<Self, FoxgloveError> {
        Err(FoxgloveError::Absent)
    }

    /// Where it listens.
    #[must_use]
    pub fn address(&self) -> &str {
        match *self {}
    }

    /// Sends a message to those who subscribed to its topic.
    pub fn publish(&self, _: TopicMessage<'_>) {
        match *self {}
    }

    /// What clients ask for.
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
