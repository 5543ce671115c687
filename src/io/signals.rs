//! Signals of the operating system.

use std::io;
#[cfg(unix)]
use std::sync::atomic::{AtomicBool, Ordering};

/// A signal that the program handles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Signal {
    /// Interrupt, termination, quit or a closed terminal: end the program in an orderly way.
    Leave,
    /// Stop and go to the background.
    Suspend,
}

/// Listens for signals.
#[derive(Debug)]
pub struct Signals {
    #[cfg(unix)]
    streams: [tokio::signal::unix::Signal; 5],
    #[cfg(windows)]
    interrupt: tokio::signal::windows::CtrlC,
    #[cfg(windows)]
    break_key: tokio::signal::windows::CtrlBreak,
    #[cfg(windows)]
    close: tokio::signal::windows::CtrlClose,
    #[cfg(windows)]
    log_off: tokio::signal::windows::CtrlLogoff,
    #[cfg(windows)]
    shutdown: tokio::signal::windows::CtrlShutdown,
}

#[cfg(unix)]
impl Signals {
    /// Begins to listen; must be called within the runtime.
    ///
    /// # Errors
    /// If the system refuses.
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
        let (signal, is_terminated) = tokio::select! {
            _ = interrupt.recv() => (Signal::Leave, false),
            _ = terminate.recv() => (Signal::Leave, true),
            _ = hangup.recv() => (Signal::Leave, false),
            _ = quit.recv() => (Signal::Leave, false),
            _ = suspend.recv() => (Signal::Suspend, false),
        };
        IS_TERMINATED.store(is_terminated, Ordering::Relaxed);
        signal
    }
}

#[cfg(windows)]
impl Signals {
    /// Begins to listen; must be called within the runtime. The system ends the process about 5 s after a closed window,
    /// a log-off or a shutdown, even if the program has not finished.
    ///
    /// # Errors
    /// If the system refuses.
    pub fn listen() -> io::Result<Self> {
        use tokio::signal::windows;
        Ok(Self {
            interrupt: windows::ctrl_c()?,
            break_key: windows::ctrl_break()?,
            close: windows::ctrl_close()?,
            log_off: windows::ctrl_logoff()?,
            shutdown: windows::ctrl_shutdown()?,
        })
    }

    /// The next signal.
    pub async fn next(&mut self) -> Signal {
        tokio::select! {
            _ = self.interrupt.recv() => Signal::Leave,
            _ = self.break_key.recv() => Signal::Leave,
            _ = self.close.recv() => Signal::Leave,
            _ = self.log_off.recv() => Signal::Leave,
            _ = self.shutdown.recv() => Signal::Leave,
        }
    }
}

/// From now on, a write beyond the system's limit of a file's length fails; by default, its signal ends the program.
pub fn survive_file_limit() {
    #[cfg(unix)]
    {
        let signal = rustix::process::Signal::XFSZ.as_raw();
        // Without a handler, the signal has its default effect.
        let _ = signal_hook::flag::register(signal, std::sync::Arc::default());
    }
}

/// Whether SIGTERM was the last signal to leave.
#[cfg(unix)]
static IS_TERMINATED: AtomicBool = AtomicBool::new(false);

/// Whether SIGTERM was the last signal to leave.
#[cfg(unix)]
#[must_use]
pub fn is_terminated() -> bool {
    IS_TERMINATED.load(Ordering::Relaxed)
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
    // Without a thread, the signal has its default effect.
    let _ = std::thread::Builder::new()
        .name("signals".into())
        .spawn(listen);
    // Ends when the thread listens, or has failed to.
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
