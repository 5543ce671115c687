//! The server, by the `foxglove` crate.
//!
//! Whoever does not read loses the oldest messages that wait for it, and nobody waits for whoever does
//! not read: messages are handed over without waiting, and the sockets are served between the
//! station's own turns.

use std::collections::BTreeMap;
use std::fmt;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use foxglove::websocket::service::{Handler, Request, Responder, Service, ServiceSchema};
use foxglove::websocket::{ChannelView, Client, ServerListener};
use foxglove::{
    ChannelBuilder, Context, FoxgloveError as SdkError, PartialMetadata, RawChannel, Schema,
    WebSocketServer, WebSocketServerHandle,
};
use tokio::sync::mpsc;

use super::{Call, FoxgloveError, SERVICE};
use crate::capture::topics::{Topic, TopicMessage};
use crate::share::Address;

/// Messages that wait for a client that does not read: half a minute of all topics.
const BACKLOG: usize = 1024;

/// Calls that wait for the station.
const CALLS: usize = 32;

const REQUEST_SCHEMA: &str = include_str!("request.schema.json");
const RESPONSE_SCHEMA: &str = include_str!("response.schema.json");

/// A server; it ends when this is dropped.
pub struct Foxglove {
    address: String,
    channels: BTreeMap<Topic, Arc<RawChannel>>,
    newest: Newest,
    calls: mpsc::Receiver<Call>,
    /// Channels and clients find each other here.
    _context: Arc<Context>,
    server: Option<WebSocketServerHandle>,
}

impl Foxglove {
    /// Begins to listen; must be called within the runtime. `name` is what clients show it as.
    ///
    /// # Errors
    /// When the address is open to a network and must not be, is taken, or the system refuses.
    pub async fn listen(
        address: &Address,
        open_to_network: bool,
        name: &str,
    ) -> Result<Self, FoxgloveError> {
        let Some(socket) = address.to_listen_on(open_to_network)? else {
            return Err(FoxgloveError::Path(address.clone()));
        };
        let refused =
            |error| FoxgloveError::Listen(socket.to_string(), std::io::Error::other(error));
        let context = Context::new();
        let mut channels = BTreeMap::new();
        for topic in Topic::ALL {
            let schema = topic.schema();
            let channel = ChannelBuilder::new(topic.name())
                .context(&context)
                .message_encoding("protobuf")
                .schema(Schema::new(schema.name, "protobuf", schema.descriptors))
                .build_raw()
                .map_err(refused)?;
            channels.insert(topic, channel);
        }
        let newest = Newest::default();
        let (to_station, calls) = mpsc::channel(CALLS);
        let host = socket.to_string();
        let host = host.rsplit_once(':').map_or(&*host, |(host, _)| host);
        let server = WebSocketServer::new()
            .context(&context)
            .name(name)
            .bind(host, socket.port())
            .message_backlog_size(BACKLOG)
            .listener(Arc::new(Greeter {
                newest: newest.clone(),
                channels: channels.clone(),
            }))
            .services([Service::builder(SERVICE, service_schema()).handler(Counter(to_station))])
            .start()
            .await
            .map_err(|error| match error {
                SdkError::Bind(error) => FoxgloveError::Listen(socket.to_string(), error),
                error => refused(error),
            })?;
        Ok(Self {
            address: format!("ws://{host}:{}", server.port()),
            channels,
            newest,
            calls,
            _context: context,
            server: Some(server),
        })
    }

    /// Where it listens, as clients have to name it.
    #[must_use]
    pub fn address(&self) -> &str {
        &self.address
    }

    /// Sends a message to those who subscribed to its topic; never waits.
    pub fn publish(&self, message: TopicMessage<'_>) {
        let Some(channel) = self.channels.get(&message.topic) else {
            return;
        };
        let mut newest = self.newest.lock();
        let kept = newest.entry(message.topic).or_default();
        kept.log_time_ns = message.log_time_ns;
        kept.data.clear();
        kept.data.extend_from_slice(message.data);
        drop(newest);
        channel.log_with_meta(message.data, at(message.log_time_ns));
    }

    /// What clients ask for. Nothing is lost when the wait is abandoned.
    pub async fn next(&mut self) -> Call {
        match self.calls.recv().await {
            Some(call) => call,
            // The server has ended, with the runtime.
            None => std::future::pending().await,
        }
    }
}

impl Drop for Foxglove {
    fn drop(&mut self) {
        if let Some(server) = self.server.take() {
            // Nobody waits for its clients.
            drop(server.stop());
        }
    }
}

impl fmt::Debug for Foxglove {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Foxglove")
            .field("address", &self.address)
            .finish_non_exhaustive()
    }
}

#[derive(Clone, Default)]
struct Message {
    log_time_ns: u64,
    data: Vec<u8>,
}

/// The newest message of each topic.
#[derive(Clone, Default)]
struct Newest(Arc<Mutex<BTreeMap<Topic, Message>>>);

impl Newest {
    fn lock(&self) -> MutexGuard<'_, BTreeMap<Topic, Message>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Hands the newest message to who subscribes: a list of waypoints may not change for hours.
struct Greeter {
    newest: Newest,
    channels: BTreeMap<Topic, Arc<RawChannel>>,
}

impl ServerListener for Greeter {
    fn on_subscribe(&self, client: Client, channel: ChannelView) {
        let Some(topic) = Topic::from_name(channel.topic()) else {
            return;
        };
        let newest = self.newest.lock().get(&topic).cloned();
        if let (Some(channel), Some(kept)) = (self.channels.get(&topic), newest) {
            channel.log_with_meta_to_sink(&kept.data, at(kept.log_time_ns), client.sink_id());
        }
    }
}

fn at(log_time_ns: u64) -> PartialMetadata {
    PartialMetadata {
        log_time: Some(log_time_ns),
    }
}

/// Where clients come to ask.
struct Counter(mpsc::Sender<Call>);

impl Handler for Counter {
    fn call(&self, request: Request, responder: Responder) {
        let call = Call {
            by: format!("Foxglove client {}", request.client_id()),
            payload: request.payload().to_vec(),
            answer: Answer(responder),
        };
        if let Err(error) = self.0.try_send(call) {
            let busy = "the station is busy; try again in a moment".to_owned();
            error.into_inner().answer.0.respond_err(busy);
        }
    }
}

/// Where the answer to a call goes.
#[derive(Debug)]
pub struct Answer(Responder);

impl Answer {
    /// Answers with JSON. A client that is gone hears nothing.
    pub fn give(self, answer: &[u8]) {
        self.0.respond_ok(answer);
    }
}

fn service_schema() -> ServiceSchema {
    let json = |name, text: &'static str| Schema::new(name, "jsonschema", text.as_bytes());
    ServiceSchema::new("groundwave.Send")
        .with_request("json", json("groundwave.SendRequest", REQUEST_SCHEMA))
        .with_response("json", json("groundwave.SendResponse", RESPONSE_SCHEMA))
}
