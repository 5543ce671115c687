//! A radio link: a serial device, a TCP bridge or standard input, kept open.
//!
//! Two threads own the link. The reader passes every chunk to the [`Sink`] (the recorder) before anything else sees it, and reopens
//! a lost link. The writer takes frames from the transmit queue; a stuck device delays only this thread.

mod backoff;
mod connection;
mod error;
mod pseudo_terminal;
mod reader;
mod spec;
mod tx_queue;

use std::hash::{BuildHasher as _, RandomState};
use std::process;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Instant;

use tokio::sync::mpsc::Sender;

pub use connection::Connection;
pub use error::OpenError;
pub use spec::{LinkSpec, has_port};

use crate::share::{StationLine, Welcome};
use backoff::Backoff;
use connection::Reopener;
use reader::{Reader, Reopen};
use tx_queue::TxQueue;

/// The radio's rate, bit/s.
pub const BAUD: u32 = 2400;

/// A report of the reader thread.
#[derive(Debug)]
pub enum LinkInput {
    /// The link is open, or open again.
    Opened {
        /// The device's name, if it differs from the operator's.
        renamed: Option<String>,
        /// Number of connections without a byte, or without a welcome, since the latest loss; they were not reported.
        empty: u32,
        /// The welcome of the station at the other end, if it shares its link.
        share: Option<Welcome>,
    },
    /// A line of the station that shares its link.
    Said(StationLine),
    /// Bytes, and the time at which their read returned.
    Bytes(Instant, Vec<u8>),
    /// The link is lost or cannot be reopened, for a reason.
    Lost(String),
    /// Standard input has ended.
    Ended,
}

/// Takes every received chunk before anything else does.
pub type Sink = Box<dyn FnMut(Instant, &[u8]) + Send>;

/// An open link.
pub struct Link {
    tx_queue: Option<TxQueue>,
    is_eager: Arc<AtomicBool>,
    share: Option<Welcome>,
}

impl Link {
    /// Starts the threads of an open link. A loss is reported as [`LinkInput::Lost`], and the link is reopened as soon as
    /// possible, also a USB adapter under another name. A peer that closes each connection without a byte is reported once.
    #[must_use]
    pub fn start(
        spec: LinkSpec,
        baud: u32,
        connection: Connection,
        sink: Sink,
        inputs: Sender<LinkInput>,
    ) -> Self {
        Self::start_with(Reopener::new(spec, baud), connection, sink, inputs)
    }

    fn start_with(
        reopener: impl Reopen + 'static,
        mut connection: Connection,
        sink: Sink,
        inputs: Sender<LinkInput>,
    ) -> Self {
        let writing = connection.writing.take();
        let can_send = writing.is_some();
        let share = connection.share.clone();
        let tx_queue = TxQueue::default();
        let is_eager = Arc::<AtomicBool>::default();
        tx_queue.connect(writing);
        let reader = Reader {
            reopener,
            sink,
            inputs,
            tx_queue: tx_queue.clone(),
            is_eager: Arc::clone(&is_eager),
            backoff: Backoff::new(RandomState::new().hash_one(process::id())),
        };
        thread::spawn(move || reader.run(connection));
        Self {
            tx_queue: can_send.then_some(tx_queue),
            is_eager,
            share,
        }
    }

    /// A link without a device, for a driver that gets its bytes from a station.
    #[must_use]
    pub fn receive_only() -> Self {
        Self {
            tx_queue: None,
            is_eager: Arc::default(),
            share: None,
        }
    }

    /// Sets whether to deliver every byte at once, not only when a line may be complete; needed by a station that sends in
    /// the robot's pauses.
    pub fn hand_over_at_once(&self, is_eager: bool) {
        self.is_eager.store(is_eager, Ordering::Relaxed);
    }

    /// Whether anything can be sent.
    #[must_use]
    pub const fn can_send(&self) -> bool {
        self.tx_queue.is_some()
    }

    /// The welcome of the station at the other end when the link was started, if it shares its link.
    #[must_use]
    pub const fn share(&self) -> Option<&Welcome> {
        self.share.as_ref()
    }

    /// Queues a frame, without waiting. If a device accepts no bytes for long, the frame is lost, which the protocol
    /// repairs.
    pub fn send(&self, bytes: &[u8]) {
        if let Some(queue) = &self.tx_queue {
            queue.send(bytes);
        }
    }

    /// Drops queued frames, so that STOP directly follows the current frame.
    pub fn clear_queue(&self) {
        if let Some(queue) = &self.tx_queue {
            queue.clear();
        }
    }

    /// Number of bytes that a stuck device did not accept.
    #[must_use]
    pub fn not_taken_bytes(&self) -> u64 {
        self.tx_queue.as_ref().map_or(0, TxQueue::not_taken_bytes)
    }
}
