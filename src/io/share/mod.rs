//! Sockets of a shared link. Clients get the raw bytes, and their input is split into lines. A slow or absent client
//! never delays the radio.

mod client;
mod listener;
mod outbox;
#[cfg(unix)]
mod socket_file;

use std::collections::BTreeMap;
use std::io;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::sync::mpsc;

use crate::share::{Address, ClientId, Exposed, LINE_MAX, TooLong};
use listener::Listener;
use outbox::{Cut, Outbox};

/// Maximum connections.
const CLIENTS_MAX: usize = 16;

/// Maximum inputs that wait for the station; further clients wait.
const INPUTS: usize = 32;

/// Reason why a link cannot be shared.
#[derive(Debug, thiserror::Error)]
pub enum ShareError {
    /// The address is open to a network without permission.
    #[error(transparent)]
    Exposed(#[from] Exposed),
    /// The path exists and must not be replaced.
    #[error("cannot share on {0}: {1}")]
    Taken(String, &'static str),
    /// The system's error.
    #[error("cannot share on {0}: {1}; {hint}", hint = match .1.kind() {
        io::ErrorKind::NotFound => "make the folder first",
        io::ErrorKind::PermissionDenied => "choose a port above 1023 or a folder of yours",
        _ => "choose another address, or port 0 for a free one",
    })]
    Listen(String, io::Error),
}

/// An input from a client.
#[derive(Debug)]
pub enum FromClient {
    /// A client connected.
    Connected {
        /// Its number.
        client: ClientId,
        /// Its name for people.
        peer: String,
    },
    /// A client sent a line.
    Line {
        /// The client.
        client: ClientId,
        /// The line without its end.
        line: Result<Vec<u8>, TooLong>,
    },
    /// A client that did not read was closed.
    TooSlow {
        /// The client.
        client: ClientId,
        /// Number of bytes that it had not read.
        unread_bytes: usize,
    },
    /// A receive-only client was closed to admit another.
    GaveWay {
        /// The client.
        client: ClientId,
    },
    /// A client left.
    Gone {
        /// The client.
        client: ClientId,
    },
}

/// The unsent bytes of each client.
#[derive(Clone, Debug, Default)]
struct Outboxes(Arc<Mutex<BTreeMap<ClientId, Arc<Outbox>>>>);

impl Outboxes {
    fn lock(&self) -> MutexGuard<'_, BTreeMap<ClientId, Arc<Outbox>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds a client. If there are too many, the oldest receive-only client is closed, because a STOP must get through;
    /// `None` if there is none.
    fn add(&self, client: ClientId) -> Option<Arc<Outbox>> {
        let mut all = self.lock();
        if all.len() >= CLIENTS_MAX {
            let mut readers = all.iter().filter(|(_, outbox)| !outbox.converses());
            let longest = *readers.next()?.0;
            if let Some(outbox) = all.remove(&longest) {
                outbox.cut_off();
            }
        }
        let outbox = Arc::new(Outbox::default());
        all.insert(client, Arc::clone(&outbox));
        Some(outbox)
    }
}

/// Copies received bytes to the clients; never waits.
#[derive(Clone, Debug)]
pub struct Tap(Outboxes);

impl Tap {
    /// Takes bytes from the radio.
    pub fn take(&self, bytes: &[u8]) {
        for outbox in self.0.lock().values() {
            outbox.add_raw(bytes);
        }
    }
}

/// A shared link; dropping it ends sharing.
#[derive(Debug)]
pub struct Share {
    address: String,
    outboxes: Outboxes,
    inputs: mpsc::Receiver<FromClient>,
    accepting: tokio::task::JoinHandle<()>,
    #[cfg(unix)]
    _file: Option<socket_file::SocketFile>,
}

impl Share {
    /// Starts listening; must be called within the runtime.
    ///
    /// # Errors
    /// When the address is open to a network without permission or in use, or the system refuses.
    pub fn listen(address: &Address, open_to_network: bool) -> Result<Self, ShareError> {
        let opened = listener::open(address, open_to_network)?;
        let outboxes = Outboxes::default();
        let (to_station, inputs) = mpsc::channel(INPUTS);
        let accepting = tokio::spawn(accept(opened.listener, outboxes.clone(), to_station));
        Ok(Self {
            address: opened.address,
            outboxes,
            inputs,
            accepting,
            #[cfg(unix)]
            _file: opened.file,
        })
    }

    /// The address for clients.
    #[must_use]
    pub fn address(&self) -> &str {
        &self.address
    }

    /// The tap for the link's reader thread.
    #[must_use]
    pub fn tap(&self) -> Tap {
        Tap(self.outboxes.clone())
    }

    /// The next input from a client. Cancel-safe.
    pub async fn next(&mut self) -> FromClient {
        match self.inputs.recv().await {
            Some(input) => input,
            // The listener has ended, with the runtime.
            None => std::future::pending().await,
        }
    }

    /// Stops sending raw bytes to a client.
    pub fn end_raw(&self, client: ClientId) {
        self.with(client, Outbox::end_raw);
    }

    /// Sends a line to a client.
    pub fn send_line(&self, client: ClientId, line: &[u8]) {
        self.with(client, |outbox| outbox.add_line(line));
    }

    /// Closes a client's connection after its lines.
    pub fn close(&self, client: ClientId) {
        self.with(client, Outbox::close);
    }

    fn with(&self, client: ClientId, act: impl FnOnce(&Outbox)) {
        if let Some(outbox) = self.outboxes.lock().get(&client) {
            act(outbox);
        }
    }
}

impl Drop for Share {
    fn drop(&mut self) {
        self.accepting.abort();
    }
}

async fn accept(listener: Listener, outboxes: Outboxes, to_station: mpsc::Sender<FromClient>) {
    let mut next = 1;
    loop {
        let (stream, peer) = listener.accept().await;
        let client = ClientId(next);
        next += 1;
        let Some(outbox) = outboxes.add(client) else {
            tokio::spawn(client::turn_away(stream));
            continue;
        };
        let connected = FromClient::Connected { client, peer };
        if to_station.send(connected).await.is_err() {
            return;
        }
        let (outboxes, to_station) = (outboxes.clone(), to_station.clone());
        tokio::spawn(async move {
            let ended = client::serve(stream, client, &outbox, &to_station).await;
            outboxes.lock().remove(&client);
            let last = match ended {
                client::Ended::Gone => FromClient::Gone { client },
                client::Ended::Cut(Cut::TooSlow { unread_bytes }) => FromClient::TooSlow {
                    client,
                    unread_bytes,
                },
                client::Ended::Cut(Cut::GaveWay) => FromClient::GaveWay { client },
            };
            // The station may have ended.
            let _ = to_station.send(last).await;
        });
    }
}

/// Maximum bytes read ahead from a client.
const READ_MAX: usize = LINE_MAX;
