//! What the system tells a program to do.

use std::io;

/// A signal that concerns us.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Signal {
    /// Leave in good order: interrupt, termination or a closed terminal.
    Leave,
    /// Stop and go to the background.
    Suspend,
}

/// Listens for signals.
#[derive(Debug)]
pub struct Signals {
    #[cfg(unix)]
    streams: [tokio::signal::unix::Signal; 4],
}

#[cfg(unix)]
impl Signals {
    /// Begins to listen; must be called within the runtime.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn listen() -> io::Result<Self> {
        use tokio::signal::unix::{SignalKind, signal};
        let suspend = SignalKind::from_raw(rustix::process::Signal::TSTP.as_raw());
        Ok(Self {
            streams: [
                signal(SignalKind::interrupt())?,
                signal(SignalKind::terminate())?,
                signal(SignalKind::hangup())?,
                signal(suspend)?,
            ],
        })
    }

    /// The next signal.
    pub async fn next(&mut self) -> Signal {
        let [interrupt, terminate, hangup, suspend] = &mut self.streams;
        tokio::select! {
            _ = interrupt.recv() => Signal::Leave,
            _ = terminate.recv() => Signal::Leave,
            _ = hangup.recv() => Signal::Leave,
            _ = suspend.recv() => Signal::Suspend,
        }
    }
}

#[cfg(not(unix))]
impl Signals {
    /// Begins to listen.
    ///
    /// # Errors
    /// Never on this system.
    pub fn listen() -> io::Result<Self> {
        Ok(Self {})
    }

    /// The next signal.
    pub async fn next(&mut self) -> Signal {
        // Without a way to listen there is nothing to come.
        if tokio::signal::ctrl_c().await.is_err() {
            std::future::pending::<()>().await;
        }
        Signal::Leave
    }
}

/// Stops this process until the shell continues it.
pub fn stop_myself() {
    #[cfg(unix)]
    {
        use rustix::process::{Signal, getpid, kill_process};
        // A process may always signal itself; if not, it just goes on.
        let _ = kill_process(getpid(), Signal::STOP);
    }
}
