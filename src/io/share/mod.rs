//! The sockets behind a shared link: who connects is handed the raw bytes, and what it writes comes in
//! as lines. Nobody who is slow, silent or gone holds up the radio.

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

/// Connections at a time.
const CLIENTS_MAX: usize = 16;

/// Inputs that wait for the station; clients wait when it is full.
const INPUTS: usize = 32;

/// Why a link cannot be shared.
#[derive(Debug, thiserror::Error)]
pub enum ShareError {
    /// It would be open to a network.
    #[error(transparent)]
    Exposed(#[from] Exposed),
    /// Something that must not be replaced has this name.
    #[error("cannot share on {0}: {1}")]
    Taken(String, &'static str),
    /// The system refuses.
    #[error("cannot share on {0}: {1}; {hint}", hint = match .1.kind() {
        io::ErrorKind::NotFound => "make the folder first",
        io::ErrorKind::PermissionDenied => "choose a port above 1023 or a folder of yours",
        _ => "choose another address, or port 0 for a free one",
    })]
    Listen(String, io::Error),
}

/// What clients do.
#[derive(Debug)]
pub enum FromClient {
    /// A client connected.
    Connected {
        /// Its number.
        client: ClientId,
        /// Who it is, for a person.
        peer: String,
    },
    /// A line came.
    Line {
        /// From whom.
        client: ClientId,
        /// The line without its end.
        line: Result<Vec<u8>, TooLong>,
    },
    /// A client that did not read was closed.
    TooSlow {
        /// Who.
        client: ClientId,
        /// Bytes that waited for it.
        unread_bytes: usize,
    },
    /// A reading client was closed to make room for another.
    GaveWay {
        /// Who.
        client: ClientId,
    },
    /// A client left.
    Gone {
        /// Who.
        client: ClientId,
    },
}

/// The bytes that wait for each client.
#[derive(Clone, Debug, Default)]
struct Outboxes(Arc<Mutex<BTreeMap<ClientId, Arc<Outbox>>>>);

impl Outboxes {
    fn lock(&self) -> MutexGuard<'_, BTreeMap<ClientId, Arc<Outbox>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Where there are too many already, whoever has only read for longest gives way: a STOP must get
    /// through. `None` when none of them only reads.
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

/// Copies received bytes to those who listen; never waits.
#[derive(Clone, Debug)]
pub struct Tap(Outboxes);

impl Tap {
    /// Takes what the radio delivered.
    pub fn take(&self, bytes: &[u8]) {
        for outbox in self.0.lock().values() {
            outbox.add_raw(bytes);
        }
    }
}

/// A link that is shared. It ends when this is dropped.
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
    /// Begins to listen; must be called within the runtime.
    ///
    /// # Errors
    /// When the address is open to a network and must not be, is taken, or the system refuses.
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

    /// Where it listens, as others have to name it.
    #[must_use]
    pub fn address(&self) -> &str {
        &self.address
    }

    /// For the thread that reads from the radio.
    #[must_use]
    pub fn tap(&self) -> Tap {
        Tap(self.outboxes.clone())
    }

    /// What clients do next. Nothing is lost when the wait is abandoned.
    pub async fn next(&mut self) -> FromClient {
        match self.inputs.recv().await {
            Some(input) => input,
            // The listener has ended, with the runtime.
            None => std::future::pending().await,
        }
    }

    /// No raw bytes for this client any more, only lines.
    pub fn end_raw(&self, client: ClientId) {
        self.with(client, Outbox::end_raw);
    }

    /// A line for a client.
    pub fn send_line(&self, client: ClientId, line: &[u8]) {
        self.with(client, |outbox| outbox.add_line(line));
    }

    /// Closes a client's connection when it has its lines.
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
            // A station that is gone needs no word.
            let _ = to_station.send(last).await;
        });
    }
}

/// The most that is read ahead from a client.
const READ_MAX: usize = LINE_MAX;
