//! Signals of the operating system.

use std::io;

/// A signal that the program handles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Signal {
    /// Interrupt, termination, quit or a closed terminal: leave in good order.
    Leave,
    /// Stop and go to the background.
    Suspend,
}

/// Listens for signals.
#[derive(Debug)]
pub struct Signals {
    #[cfg(unix)]
    streams: [tokio::signal::unix::Signal; 5],
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
                signal(SignalKind::quit())?,
                signal(suspend)?,
            ],
        })
    }

    /// The next signal.
    pub async fn next(&mut self) -> Signal {
        let [interrupt, terminate, hangup, quit, suspend] = &mut self.streams;
        tokio::select! {
            _ = interrupt.recv() => Signal::Leave,
            _ = terminate.recv() => Signal::Leave,
            _ = hangup.recv() => Signal::Leave,
            _ = quit.recv() => Signal::Leave,
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
        // Without a handler no signal arrives.
        if tokio::signal::ctrl_c().await.is_err() {
            std::future::pending::<()>().await;
        }
        Signal::Leave
    }
}

/// Exit code of an interrupted program.
const INTERRUPTED: i32 = 130;

/// Runs `work` on a thread at the first signal to leave, keeps its result until the end, and ends the program.
pub fn on_leave<T>(work: impl FnOnce() -> T + Send + 'static) {
    let (not_yet, listens) = std::sync::mpsc::channel::<()>();
    let listen = move || {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_io()
            .build();
        let Ok(runtime) = runtime else { return };
        runtime.block_on(async {
            let Ok(mut signals) = Signals::listen() else {
                return;
            };
            drop(not_yet);
            while signals.next().await == Signal::Suspend {
                stop_myself();
            }
            let _held = work();
            std::process::exit(INTERRUPTED);
        });
    };
    // Without a thread the signal has its default effect.
    let _ = std::thread::Builder::new()
        .name("signals".into())
        .spawn(listen);
    // Ends when the thread listens, or cannot.
    let _ = listens.recv();
}

/// Stops this process until the shell continues it.
pub fn stop_myself() {
    #[cfg(unix)]
    {
        use rustix::process::{Signal, getpid, kill_process};
        // A process may always signal itself.
        let _ = kill_process(getpid(), Signal::STOP);
    }
}
