//! The simulation against the clock: a robot behind a pseudo-terminal or a TCP port.
//!
//! One thread runs the world and never waits for a reader: bytes that nobody takes are lost, as on
//! a radio.

mod eeprom;
#[cfg(unix)]
mod link_file;
#[cfg(unix)]
mod pty;
mod recordings;
mod tcp;

use eeprom::Eeprom;
use recordings::Recordings;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use std::{io, thread};

use groundwave_protocol::BYTES_PER_S;

use crate::plant::Truth;
use crate::simulation::{Simulation, SimulationConfig};
use crate::world::Outline;

/// Where the robot's radio comes out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Endpoint {
    /// A pseudo-terminal in raw mode; only on Unix.
    Pty {
        /// A symbolic link to make to it.
        link: Option<PathBuf>,
        /// Whether it only copies what the robot sends and ignores what it is told.
        copy_only: bool,
    },
    /// A TCP port. Every client receives everything; what clients send is merged.
    Tcp {
        /// What to listen on, as `HOST:PORT`; port 0 chooses a free one.
        address: String,
        /// Whether it only copies what the robot sends and ignores what it is told.
        copy_only: bool,
    },
}

/// How to serve.
#[derive(Clone, Debug)]
pub struct ServeOptions {
    /// Where the radio comes out; several give several copies of the downlink.
    pub endpoints: Vec<Endpoint>,
    /// Virtual seconds a second, above 0 up to 1000.
    pub time_factor: f64,
    /// Virtual time after which the robot is switched off.
    pub duration: Option<Duration>,
    /// A file in the place of the robot's EEPROM: it keeps the boot counter and the parameters.
    pub eeprom: Option<PathBuf>,
    /// A file for a row of [`crate::Trace`] at every tick.
    pub trace: Option<PathBuf>,
    /// A file for the sound of the beeper, in virtual time.
    pub wav: Option<PathBuf>,
}

impl Default for ServeOptions {
    /// A pseudo-terminal at the speed of life.
    fn default() -> Self {
        Self {
            endpoints: vec![Endpoint::Pty {
                link: None,
                copy_only: false,
            }],
            time_factor: 1.0,
            duration: None,
            eeprom: None,
            trace: None,
            wav: None,
        }
    }
}

/// Why a robot cannot be served.
#[derive(Debug, thiserror::Error)]
pub enum ServeError {
    /// The system gives no pseudo-terminal.
    #[error("cannot open a pseudo-terminal: {0}; serve over TCP instead (--listen 127.0.0.1:0)")]
    Pty(io::Error),
    /// The link to the pseudo-terminal cannot be made.
    #[error("cannot make {} point to the pseudo-terminal: {problem}", path.display())]
    Link {
        /// The link.
        path: PathBuf,
        /// Why, and what to do.
        problem: String,
    },
    /// The port cannot be listened on.
    #[error(
        "cannot listen on {address}: {source}; choose another address, or port 0 for a free one"
    )]
    Listen {
        /// The address.
        address: String,
        /// Why.
        source: io::Error,
    },
    /// The boot counter and the parameters cannot be kept.
    #[error("cannot keep the boot counter and the parameters in {}: {problem}", path.display())]
    Eeprom {
        /// The file.
        path: PathBuf,
        /// Why, and what to do.
        problem: String,
    },
    /// The trace or the sound cannot be written.
    #[error("cannot write the {what} to {}: {source}; choose another file", path.display())]
    Recording {
        /// Which of them.
        what: &'static str,
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// Time cannot run like this.
    #[error("time cannot run {0} times as fast: choose a factor above 0 up to 1000")]
    TimeFactor(f64),
    /// The system gives no thread.
    #[error("cannot start the simulation's thread: {0}")]
    Thread(io::Error),
}

const TIME_FACTOR_MAX: f64 = 1000.0;

/// Real time that the simulation makes up for after it was held up; the rest is skipped.
const CATCH_UP_MAX: Duration = Duration::from_millis(250);

/// Shortest rest between two looks at the ports.
const REST_MIN: Duration = Duration::from_millis(1);

/// Ground bytes taken before they have their byte time; beyond that their writer feels it.
const UPLINK_AHEAD: usize = 256;

/// Where bytes come out. Neither direction ever blocks.
trait Port: Send {
    /// Offers bytes to whoever listens.
    fn write(&mut self, bytes: &[u8], now: Instant);
    /// Appends what has been sent to the robot.
    fn read(&mut self, into: &mut Vec<u8>);
}

/// A robot being served. Dropping it switches the robot off.
#[derive(Debug)]
pub struct Server {
    addresses: Vec<String>,
    outlines: Vec<Outline>,
    boots: u16,
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

#[derive(Debug)]
struct Shared {
    stop: AtomicBool,
    uplink_bytes: AtomicU64,
    truth: Mutex<Truth>,
}

/// Opens the endpoints and starts the robot.
///
/// # Errors
///
/// When an endpoint, the link or the EEPROM file cannot be had, or the time factor is senseless.
pub fn serve(mut config: SimulationConfig, options: &ServeOptions) -> Result<Server, ServeError> {
    if !(options.time_factor > 0.0 && options.time_factor <= TIME_FACTOR_MAX) {
        return Err(ServeError::TimeFactor(options.time_factor));
    }
    let mut ports = Vec::new();
    let mut addresses = Vec::new();
    for endpoint in &options.endpoints {
        let (port, address) = open(endpoint)?;
        ports.push(port);
        addresses.push(address);
    }
    let mut eeprom = options.eeprom.clone().map(Eeprom::open).transpose()?;
    if let Some(eeprom) = &mut eeprom {
        config.boots = eeprom.count_boot()?;
        config.parameters.clone_from(eeprom.parameters());
    }
    let recordings = Recordings::begin(options)?;
    let simulation = Simulation::new(&config);
    let shared = Arc::new(Shared {
        stop: AtomicBool::new(false),
        uplink_bytes: AtomicU64::new(0),
        truth: Mutex::new(simulation.truth()),
    });
    let outlines = simulation.outlines().to_vec();
    let boots = simulation.boots();
    let runner = Runner {
        simulation,
        recordings,
        eeprom,
        ports,
        shared: Arc::clone(&shared),
        time_factor: options.time_factor,
        end_ms: options
            .duration
            .map_or(u64::MAX, |duration| duration.as_millis() as u64),
    };
    let thread = thread::Builder::new()
        .name("simulation".to_owned())
        .spawn(move || runner.run())
        .map_err(ServeError::Thread)?;
    Ok(Server {
        addresses,
        outlines,
        boots,
        shared,
        thread: Some(thread),
    })
}

fn open(endpoint: &Endpoint) -> Result<(Box<dyn Port>, String), ServeError> {
    match endpoint {
        #[cfg(unix)]
        Endpoint::Pty { link, copy_only } => {
            let (port, path) = pty::Pty::open(link.as_deref(), *copy_only)?;
            Ok((Box::new(port), path))
        }
        #[cfg(not(unix))]
        Endpoint::Pty { .. } => Err(ServeError::Pty(io::ErrorKind::Unsupported.into())),
        Endpoint::Tcp { address, copy_only } => {
            let (port, bound) = tcp::Tcp::listen(address, *copy_only)?;
            Ok((Box::new(port), bound))
        }
    }
}

impl Server {
    /// The endpoints in order: the path of a pseudo-terminal, or `HOST:PORT`.
    #[must_use]
    pub fn addresses(&self) -> &[String] {
        &self.addresses
    }

    /// The true walls and things in the robot's coordinates.
    #[must_use]
    pub fn outlines(&self) -> &[Outline] {
        &self.outlines
    }

    /// The boot counter that the robot runs with.
    #[must_use]
    pub const fn boots(&self) -> u16 {
        self.boots
    }

    /// What is really so, at most a few byte times ago.
    #[must_use]
    pub fn truth(&self) -> Truth {
        *self
            .shared
            .truth
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }

    /// Bytes taken from the endpoints for the robot.
    #[must_use]
    pub fn uplink_bytes(&self) -> u64 {
        self.shared.uplink_bytes.load(Ordering::Relaxed)
    }

    /// Whether the robot still runs: neither stopped nor at the end of its duration.
    #[must_use]
    pub fn is_running(&self) -> bool {
        self.thread
            .as_ref()
            .is_some_and(|thread| !thread.is_finished())
    }

    /// Tells the robot's thread to end, without waiting for it.
    pub fn stop(&self) {
        self.shared.stop.store(true, Ordering::Relaxed);
    }

    /// Waits until the duration is over or someone stops it.
    pub fn wait(mut self) {
        self.join();
    }

    fn join(&mut self) {
        if let Some(thread) = self.thread.take() {
            // A panic there has already been reported by the thread itself.
            let _ = thread.join();
        }
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.stop();
        self.join();
    }
}

/// What the simulation's thread owns.
struct Runner {
    simulation: Simulation,
    recordings: Recordings,
    eeprom: Option<Eeprom>,
    ports: Vec<Box<dyn Port>>,
    shared: Arc<Shared>,
    time_factor: f64,
    end_ms: u64,
}

impl Runner {
    fn run(mut self) {
        let byte_s = 1.0 / f64::from(BYTES_PER_S);
        let mut begun = Instant::now();
        let mut begun_ms = 0.0;
        while !self.shared.stop.load(Ordering::Relaxed) && self.simulation.now_ms() < self.end_ms {
            let mut target_ms =
                begun_ms + begun.elapsed().as_secs_f64() * 1000.0 * self.time_factor;
            let late_ms = target_ms - self.simulation.now_ms() as f64;
            let late_max_ms = CATCH_UP_MAX.as_secs_f64() * 1000.0 * self.time_factor;
            if late_ms > late_max_ms {
                begun = Instant::now();
                begun_ms = self.simulation.now_ms() as f64;
                target_ms = begun_ms + late_max_ms;
            }
            self.advance((target_ms as u64).min(self.end_ms));
            let next_ms =
                (target_ms / (byte_s * 1000.0)).floor() * byte_s * 1000.0 + byte_s * 1000.0;
            let rest_s =
                (next_ms - begun_ms) / 1000.0 / self.time_factor - begun.elapsed().as_secs_f64();
            thread::sleep(Duration::from_secs_f64(rest_s.max(0.0)).max(REST_MIN));
        }
        self.recordings.finish();
    }

    /// Takes what was sent, runs up to a time, gives out what was received.
    fn advance(&mut self, target_ms: u64) {
        if self.simulation.uplink_pending() < UPLINK_AHEAD {
            let mut sent = Vec::new();
            for port in &mut self.ports {
                port.read(&mut sent);
            }
            self.shared
                .uplink_bytes
                .fetch_add(sent.len() as u64, Ordering::Relaxed);
            self.simulation.handle_uplink(&sent);
        }
        let mut received = Vec::new();
        while self.simulation.now_ms() < target_ms {
            self.simulation.step();
            self.recordings.observe(&self.simulation);
            received.extend(std::iter::from_fn(|| self.simulation.poll_downlink()));
        }
        if let Some(eeprom) = &mut self.eeprom {
            eeprom.keep(self.simulation.kept_parameters());
        }
        let now = Instant::now();
        for port in &mut self.ports {
            port.write(&received, now);
        }
        *self
            .shared
            .truth
            .lock()
            .unwrap_or_else(PoisonError::into_inner) = self.simulation.truth();
    }
}
