//! A Foxglove WebSocket server: a capture's topics live, and a service for commands. The `foxglove` crate does the protocol;
//! without the cargo feature of that name there is no server.

#[cfg(not(feature = "foxglove"))]
#[path = "absent.rs"]
mod server;
#[cfg(feature = "foxglove")]
mod server;

use std::io;

use crate::hint;
use crate::share::{Address, Exposed};
pub use server::{Answer, Foxglove};

/// Default address, the same as Foxglove's.
pub const DEFAULT_ADDRESS: &str = "127.0.0.1:8765";

/// Name of the service for commands.
pub const SERVICE: &str = "/groundwave/send";

/// A client's call of the service.
#[derive(Debug)]
pub struct Call {
    /// The client's name, to show.
    pub by: String,
    /// The command as JSON; see [`crate::share::Calls`].
    pub payload: Vec<u8>,
    /// Handle for the answer.
    pub answer: Answer,
}

/// Reason why Foxglove cannot be served.
#[derive(Debug, thiserror::Error)]
pub enum FoxgloveError {
    /// The address is open to a network without permission.
    #[error(transparent)]
    Exposed(#[from] Exposed),
    /// The address is a path.
    #[error(
        "cannot serve Foxglove on {0}: it connects to a port, such as {DEFAULT_ADDRESS}, and not to a path"
    )]
    Path(Address),
    /// The system refused.
    #[error("cannot serve Foxglove on {0}: {reason}; choose another address, or port 0 for a free one", reason = hint::words(.1))]
    Listen(String, io::Error),
    /// The build has no server.
    #[error(
        "this groundwave was built without the Foxglove server; build it with: cargo install --path . --features foxglove"
    )]
    Absent,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::layout::JSON;
    use crate::share::{CallId, CallOutput, Calls};
    use serde_json::Value;
    use std::time::Duration;

    #[cfg(not(feature = "foxglove"))]
    #[tokio::test]
    async fn without_the_feature_the_error_explains_how_to_build_it() {
        let address = DEFAULT_ADDRESS.parse().unwrap();
        let error = Foxglove::listen(&address, false, "sim").await.unwrap_err();
        assert!(error.to_string().contains("--features foxglove"), "{error}");
    }

    #[test]
    fn the_layout_sends_what_the_service_takes() {
        let layout: Value = serde_json::from_str(JSON).unwrap();
        let panel = &layout["configById"]["CallService!send"];
        assert_eq!(panel["serviceName"], SERVICE);
        let payload = panel["requestPayload"].as_str().unwrap();
        let mut calls = Calls::default();
        calls.handle_call(Duration::ZERO, CallId(1), payload.as_bytes());
        assert!(matches!(
            calls.poll_output(),
            Some(CallOutput::Start(CallId(1), _))
        ));
    }
}
