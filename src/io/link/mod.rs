//! A radio link: a serial device, a TCP bridge or standard input, kept open.
//!
//! Two threads own it. The reader hands every chunk to the [`Sink`] (the recorder) before anything
//! else sees it, and opens the link again by itself when it is gone. The writer keeps a stuck device
//! from holding up anybody.

mod connection;
mod error;
mod identity;
mod reader;
mod rest;
mod spec;
mod writer;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Instant;

use tokio::sync::mpsc::Sender;

pub use connection::Connection;
pub use error::OpenError;
pub use identity::{Plugged, UsbIdentity};
pub use spec::LinkSpec;

use connection::Reopener;
use reader::{Reader, Reopen};
use writer::Outlet;

/// The radio's speed.
pub const BAUD: u32 = 2400;

/// What the reader thread reports.
#[derive(Debug)]
pub enum LinkInput {
    /// The link is open (again).
    Opened {
        /// The device's name, where it is another than the operator gave.
        renamed: Option<String>,
    },
    /// Bytes, and when the read that brought them returned.
    Bytes(Instant, Vec<u8>),
    /// The link is gone and will be tried again; or why it could not be opened again so far.
    Lost(String),
    /// Standard input has ended.
    Ended,
}

/// Takes every received chunk before anything else does; says whether it is kept in a file, so that the next one may not
/// wait in the system.
pub type Sink = Box<dyn FnMut(Instant, &[u8]) -> bool + Send>;

/// An open link.
pub struct Link {
    outlet: Option<Outlet>,
    is_eager: Arc<AtomicBool>,
}

impl Link {
    /// Starts the threads of a link that is open. It stays open: a loss is reported as
    /// [`LinkInput::Lost`] and the link is opened again as soon as it can be, under another name too if
    /// it is a USB adapter.
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
        let outlet = Outlet::default();
        let is_eager = Arc::<AtomicBool>::default();
        outlet.connect(writing);
        let reader = Reader {
            reopener,
            sink,
            inputs,
            outlet: outlet.clone(),
            is_eager: Arc::clone(&is_eager),
            sleep: Box::new(thread::sleep),
        };
        thread::spawn(move || reader.run(connection));
        Self {
            outlet: can_send.then_some(outlet),
            is_eager,
        }
    }

    /// No radio at all: what is received comes from elsewhere.
    #[must_use]
    pub fn receive_only() -> Self {
        Self {
            outlet: None,
            is_eager: Arc::default(),
        }
    }

    /// Hands every byte over when it comes, instead of waiting until a line may be complete: for a station
    /// that speaks when the robot is silent.
    pub fn hand_over_at_once(&self, is_eager: bool) {
        self.is_eager.store(is_eager, Ordering::Relaxed);
    }

    /// Whether anything can be sent.
    #[must_use]
    pub const fn can_send(&self) -> bool {
        self.outlet.is_some()
    }

    /// Sends bytes and does not wait. A device that takes none for long loses them, which the protocol
    /// repairs.
    pub fn send(&self, bytes: &[u8]) {
        if let Some(outlet) = &self.outlet {
            outlet.send(bytes);
        }
    }

    /// Bytes that a stuck device did not take.
    #[must_use]
    pub fn not_taken(&self) -> u64 {
        self.outlet.as_ref().map_or(0, Outlet::not_taken)
    }
}
