//! The Foxglove server, built on the `foxglove` crate. Slow clients lose their oldest messages; sends never block.

use std::collections::{BTreeMap, HashMap};
use std::fmt;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use foxglove::websocket::service::{Handler, Request, Responder, Service, ServiceSchema};
use foxglove::websocket::{ChannelView, Client, ClientId, ServerListener};
use foxglove::{
    ChannelBuilder, Context, FoxgloveError as SdkError, PartialMetadata, RawChannel, Schema,
    WebSocketServer, WebSocketServerHandle,
};
use tokio::sync::mpsc;

use super::{Call, FoxgloveError, SERVICE};
use crate::capture::topics::{Topic, TopicMessage};
use crate::share::{Address, busy, is_stop, stop_queued};

/// Maximum number of messages queued for a client: half a minute of all topics.
const BACKLOG: usize = 1024;

/// Maximum number of calls queued for the station.
const CALLS: usize = 32;

/// Maximum number of unanswered calls of a client, STOPs aside. The `foxglove` crate refuses the thirty-third call, which must
/// never be a STOP.
const CALLS_OF_CLIENT: usize = 24;

/// Number of unanswered calls from which a STOP is answered at once, to keep room for the next one.
const STOPS_OF_CLIENT: usize = 30;

const REQUEST_SCHEMA: &str = include_str!("request.schema.json");
const RESPONSE_SCHEMA: &str = include_str!("response.schema.json");

/// A running server; dropping it ends it.
pub struct Foxglove {
    address: String,
    channels: BTreeMap<Topic, Arc<RawChannel>>,
    newest: Newest,
    calls: mpsc::Receiver<Call>,
    /// Separate queue for STOPs.
    stops: mpsc::UnboundedReceiver<Call>,
    /// The registry of channels and clients.
    _context: Arc<Context>,
    server: Option<WebSocketServerHandle>,
}

impl Foxglove {
    /// Starts listening; must be called within the runtime. Clients show `name`.
    ///
    /// # Errors
    /// If the address is open to a network without permission or in use, or the system refuses.
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
        let (stop_station, stops) = mpsc::unbounded_channel();
        let counter = Counter {
            calls: to_station,
            stops: stop_station,
            waiting: Waiting::default(),
        };
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
            .services([Service::builder(SERVICE, service_schema()).handler(counter)])
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
            stops,
            _context: context,
            server: Some(server),
        })
    }

    /// The address for clients.
    #[must_use]
    pub fn address(&self) -> &str {
        &self.address
    }

    /// Sends a message to a topic's subscribers; never waits.
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

    /// The next call of a client. Cancel safe.
    pub async fn next(&mut self) -> Call {
        let call = tokio::select! {
            biased;
            stop = self.stops.recv() => stop,
            call = self.calls.recv() => call,
        };
        match call {
            Some(call) => call,
            // The server has ended, with the runtime.
            None => std::future::pending().await,
        }
    }
}

impl Drop for Foxglove {
    fn drop(&mut self) {
        if let Some(server) = self.server.take() {
            // The program does not wait for clients.
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

/// Cache of the newest message of each topic.
#[derive(Clone, Default)]
struct Newest(Arc<Mutex<BTreeMap<Topic, Message>>>);

impl Newest {
    fn lock(&self) -> MutexGuard<'_, BTreeMap<Topic, Message>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Sends the newest message to a new subscriber, because a route may not change for hours.
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

/// The service's handler.
struct Counter {
    calls: mpsc::Sender<Call>,
    stops: mpsc::UnboundedSender<Call>,
    waiting: Waiting,
}

impl Handler for Counter {
    fn call(&self, request: Request, responder: Responder) {
        let payload = request.payload().to_vec();
        let is_stop = is_stop(&payload);
        let (place, before) = self.waiting.take(request.client_id());
        let mut call = Call {
            by: format!("Foxglove client {}", request.client_id()),
            payload,
            answer: Answer(Some((responder, place))),
        };
        if is_stop {
            if before >= STOPS_OF_CLIENT {
                let answered = Answer(call.answer.0.take());
                answered.give(&stop_queued());
            }
            // The queue is closed only after the station has ended.
            let _ = self.stops.send(call);
        } else if before >= CALLS_OF_CLIENT {
            call.answer.give(&busy());
        } else if let Err(error) = self.calls.try_send(call) {
            error.into_inner().answer.give(&busy());
        }
    }
}

/// Number of unanswered calls by client.
#[derive(Clone, Debug, Default)]
struct Waiting(Arc<Mutex<HashMap<ClientId, usize>>>);

impl Waiting {
    /// Counts one more call; returns its guard and the earlier number.
    fn take(&self, client: ClientId) -> (Place, usize) {
        let mut waiting = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let count = waiting.entry(client).or_default();
        *count += 1;
        let place = Place {
            waiting: self.clone(),
            client,
        };
        (place, *count - 1)
    }
}

/// An unanswered call; dropping it decrements the count.
#[derive(Debug)]
struct Place {
    waiting: Waiting,
    client: ClientId,
}

impl Drop for Place {
    fn drop(&mut self) {
        let mut waiting = self
            .waiting
            .0
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        if let Some(count) = waiting.get_mut(&self.client) {
            *count -= 1;
            if *count == 0 {
                waiting.remove(&self.client);
            }
        }
    }
}

/// Handle for the answer to a call; `None` after the answer.
#[derive(Debug)]
pub struct Answer(Option<(Responder, Place)>);

impl Answer {
    /// Answers with JSON; does nothing if the client has disconnected.
    pub fn give(self, answer: &[u8]) {
        if let Some((responder, _)) = self.0 {
            responder.respond_ok(answer);
        }
    }
}

fn service_schema() -> ServiceSchema {
    let json = |name, text: &'static str| Schema::new(name, "jsonschema", text.as_bytes());
    ServiceSchema::new("groundwave.Send")
        .with_request("json", json("groundwave.SendRequest", REQUEST_SCHEMA))
        .with_response("json", json("groundwave.SendResponse", RESPONSE_SCHEMA))
}
