//! Sockets of a shared link. Clients get an announcement and the raw bytes, and their input is split into lines. On a port, a
//! client first sends the token. A slow or absent client never delays the radio.

mod client;
mod listener;
mod outbox;
mod owner;
#[cfg(unix)]
mod socket_file;

use std::collections::{BTreeMap, VecDeque};
use std::io;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use tokio::io::AsyncWriteExt as _;
use tokio::sync::mpsc;
use tokio::task::{AbortHandle, JoinSet};
use tokio::time::sleep_until;

use crate::hint;
use crate::share::{ANNOUNCEMENT, Address, CLIENTS_MAX, ClientId, Exposed, TooLong};
use client::Stream;
use listener::Listener;
use outbox::{Cut, Outbox};
use owner::Token;
pub use owner::{find_station, find_token, usual_address};

/// Maximum number of connections that have not sent the token.
const STRANGERS_MAX: usize = 128;

/// Maximum number of connections.
pub const CONNECTIONS_MAX: usize = CLIENTS_MAX + 1 + STRANGERS_MAX;

/// Time for which a client keeps its place after connecting, after its hello and after its command ends. Among many clients, a program
/// that sends at once is therefore served and gets its answer.
const GRACE: Duration = Duration::from_millis(500);

/// Time for which a client keeps its place after its STOP; usually, the robot confirms sooner.
const STOP_GRACE: Duration = Duration::from_secs(5);

/// Maximum number of inputs queued for the station; further clients wait.
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
    /// The token of a port cannot be written.
    #[error(
        "cannot share on {0}: its token cannot be written: {reason}; set XDG_RUNTIME_DIR to one of your folders",
        reason = hint::words(.1)
    )]
    Token(String, io::Error),
    /// The system's error.
    #[error("cannot share on {0}: {reason}; {hint}", reason = hint::words(.1), hint = match .1.kind() {
        io::ErrorKind::NotFound => "make the folder first",
        io::ErrorKind::PermissionDenied => "choose a port above 1023 or one of your folders",
        _ => "choose another address, or port 0 for a free one",
    })]
    Listen(String, io::Error),
}

/// An input from a client.
#[derive(Debug)]
pub enum FromClient {
    /// A client connected.
    Connected {
        /// Number of the client.
        client: ClientId,
        /// Name of the client, for display.
        peer: String,
    },
    /// A client sent a line.
    Line {
        /// Number of the client.
        client: ClientId,
        /// The line without its line end.
        line: Result<Vec<u8>, TooLong>,
    },
    /// A client that did not read was closed.
    TooSlow {
        /// Number of the client.
        client: ClientId,
        /// Number of bytes that the client had not read.
        unread_bytes: usize,
    },
    /// An idle client was closed to admit another.
    GaveWay {
        /// Number of the client.
        client: ClientId,
    },
    /// A client disconnected.
    Gone {
        /// Number of the client.
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

    /// Adds a client. If there are too many, closes the client that has been idle longest, because a STOP must get
    /// through; if no client is idle, there is one more.
    ///
    /// # Errors
    /// If all idle clients are new; contains the time to try again.
    fn add(&self, client: ClientId, now: Instant) -> Result<Arc<Outbox>, Instant> {
        let mut all = self.lock();
        if all.len() >= CLIENTS_MAX {
            let idle = |(id, outbox): (&ClientId, &Arc<Outbox>)| {
                let idle_since = outbox.idle_since()?;
                Some((now.max(outbox.keeps_until()), idle_since, *id))
            };
            if let Some((can_go_at, _, id)) = all.iter().filter_map(idle).min() {
                if can_go_at > now {
                    return Err(can_go_at);
                }
                if let Some(outbox) = all.remove(&id) {
                    outbox.cut_off();
                }
            }
        }
        let outbox = Arc::new(Outbox::new(now));
        all.insert(client, Arc::clone(&outbox));
        Ok(outbox)
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
    /// If the address is open to a network without permission or in use, or the system refuses.
    pub fn listen(address: &Address, open_to_network: bool) -> Result<Self, ShareError> {
        let opened = listener::open(address, open_to_network)?;
        let outboxes = Outboxes::default();
        let (to_station, inputs) = mpsc::channel(INPUTS);
        let accepting = tokio::spawn(accept(
            opened.listener,
            opened.token,
            Clients {
                outboxes: outboxes.clone(),
                to_station,
                newest: 0,
            },
        ));
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

    /// Sends only lines to a client from now on; with `with_raw`, they include the raw bytes.
    pub fn converse(&self, client: ClientId, with_raw: bool) {
        self.with(client, |outbox| outbox.converse(with_raw, Instant::now()));
    }

    /// Sends a line to a client.
    pub fn send_line(&self, client: ClientId, line: &[u8]) {
        self.with(client, |outbox| outbox.add_line(line));
    }

    /// Sets whether a client waits for a command.
    pub fn set_busy(&self, client: ClientId, is_busy: bool) {
        self.with(client, |outbox| outbox.set_busy(is_busy, Instant::now()));
    }

    /// Lets a client keep its place while the robot confirms its STOP.
    pub fn start_stop(&self, client: ClientId) {
        self.with(client, |outbox| outbox.start_stop(Instant::now()));
    }

    /// Closes a client's connection after its unsent lines.
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

/// Admits clients; on a port, only those that send the token.
async fn accept(listener: Listener, token: Option<Token>, mut clients: Clients) {
    let token = token.map(Arc::new);
    let mut admitted = JoinSet::new();
    let mut strangers = VecDeque::<AbortHandle>::new();
    loop {
        let entered = tokio::select! {
            biased;
            Some(entered) = admitted.join_next() => entered,
            (mut stream, peer) = listener.accept() => {
                // The announcement fits the empty buffer of a new socket, so this never waits; a closed connection is noticed later.
                let _ = stream.write_all(ANNOUNCEMENT).await;
                let Some(token) = token.clone() else {
                    if clients.enter(stream, peer).await.is_none() {
                        return;
                    }
                    continue;
                };
                strangers.retain(|stranger| !stranger.is_finished());
                // The oldest connection is closed at once to make room. The owner's programs send the token at once; if connections waited for
                // room, strangers could fill the system's queue, which refuses the owner's then.
                if strangers.len() >= STRANGERS_MAX
                    && let Some(oldest) = strangers.pop_front()
                {
                    oldest.abort();
                }
                strangers.push_back(admitted.spawn(async move {
                    let stream = client::admit(stream, &token).await?;
                    Some((stream, peer))
                }));
                continue;
            }
        };
        if let Ok(Some((stream, peer))) = entered
            && clients.enter(stream, peer).await.is_none()
        {
            return;
        }
    }
}

struct Clients {
    outboxes: Outboxes,
    to_station: mpsc::Sender<FromClient>,
    /// Number of the newest client.
    newest: u64,
}

impl Clients {
    /// Serves a client until it disconnects; `None` when the station has ended.
    async fn enter(&mut self, stream: Box<dyn Stream>, peer: String) -> Option<()> {
        self.newest += 1;
        let client = ClientId(self.newest);
        let outbox = loop {
            match self.outboxes.add(client, Instant::now()) {
                Ok(outbox) => break outbox,
                Err(then) => sleep_until(then.into()).await,
            }
        };
        let connected = FromClient::Connected { client, peer };
        self.to_station.send(connected).await.ok()?;
        let (outboxes, to_station) = (self.outboxes.clone(), self.to_station.clone());
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
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn add(outboxes: &Outboxes, client: u64, now: Instant) -> Arc<Outbox> {
        let added = outboxes.add(ClientId(client), now);
        added.expect("a place")
    }

    /// The maximum number of clients, each after its hello, and a time at which none is new.
    fn full() -> (Outboxes, Vec<Arc<Outbox>>, Instant) {
        let outboxes = Outboxes::default();
        let start = Instant::now();
        let all = (1..=CLIENTS_MAX as u64).map(|n| add(&outboxes, n, start));
        let all: Vec<_> = all.collect();
        for outbox in &all {
            outbox.converse(false, start);
        }
        (outboxes, all, start + GRACE)
    }

    fn numbers(outboxes: &Outboxes) -> Vec<u64> {
        outboxes.lock().keys().map(|client| client.0).collect()
    }

    #[test]
    fn the_client_that_has_been_idle_for_longest_makes_room() {
        let (outboxes, all, now) = full();
        all[0].touch(now);
        all[1].set_busy(true, now);
        add(&outboxes, 17, now);
        add(&outboxes, 18, now);
        let left: Vec<u64> = [1, 2].into_iter().chain(5..=18).collect();
        assert_eq!(numbers(&outboxes), left);
    }

    #[test]
    fn a_new_client_keeps_its_place_for_a_moment() {
        let outboxes = Outboxes::default();
        let start = Instant::now();
        let spacing = Duration::from_millis(1);
        for n in 1..=CLIENTS_MAX as u32 {
            let added = outboxes.add(ClientId(n.into()), start + n * spacing);
            added.expect("there is room");
        }
        let mut now = start + CLIENTS_MAX as u32 * spacing;
        for n in 1..=CLIENTS_MAX as u64 {
            let next = ClientId(CLIENTS_MAX as u64 + n);
            let then = outboxes.add(next, now).expect_err("all are new");
            assert_eq!(then, start + n as u32 * spacing + GRACE);
            outboxes.add(next, then).expect("the oldest makes room");
            assert!(!numbers(&outboxes).contains(&n), "{n}");
            now = then;
        }
    }

    #[test]
    fn a_client_gets_its_last_status_before_it_makes_room() {
        let (outboxes, all, now) = full();
        for outbox in &all {
            outbox.set_busy(true, now);
        }
        all[0].set_busy(false, now);
        let then = outboxes.add(ClientId(17), now).expect_err("it reads");
        assert_eq!(then, now + GRACE);
        add(&outboxes, 17, then);
        assert!(!numbers(&outboxes).contains(&1));
    }

    #[test]
    fn a_client_that_reads_stays_before_one_that_only_said_hello() {
        let (outboxes, _, mut now) = full();
        let reader = add(&outboxes, 17, now);
        reader.converse(true, now);
        reader.add_raw(b"A");
        for n in 18..18 + CLIENTS_MAX as u64 {
            now += GRACE;
            reader.taken(now);
            add(&outboxes, n, now).converse(false, now);
        }
        assert!(numbers(&outboxes).contains(&17));
    }

    #[test]
    fn one_more_comes_in_when_all_wait_for_commands() {
        let (outboxes, all, mut now) = full();
        for outbox in &all {
            outbox.set_busy(true, now);
        }
        for n in 17..30 {
            now += GRACE;
            add(&outboxes, n, now).converse(false, now);
            let left: Vec<u64> = (1..=CLIENTS_MAX as u64).chain([n]).collect();
            assert_eq!(numbers(&outboxes), left);
        }
    }
}
