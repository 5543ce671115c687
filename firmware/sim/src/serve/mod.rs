//! A simulation in real time: a robot behind a pseudo-terminal or a TCP port.
//!
//! One thread runs the world and never waits for a reader: unread bytes are lost, as on a radio.

mod eeprom;
mod error;
#[cfg(unix)]
mod link_file;
mod options;
mod port;
#[cfg(unix)]
mod pty;
mod recordings;
mod tcp;

use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use groundwave_protocol::BYTES_PER_S;

pub use error::ServeError;
pub use options::{Endpoint, ServeOptions};
pub use port::Port;
#[cfg(unix)]
pub use pty::Pty;

use crate::plant::Truth;
use crate::simulation::{Simulation, SimulationConfig};
use crate::world::Outline;
use eeprom::Eeprom;
use recordings::Recordings;

/// Minimum time factor; the wait for the next byte, during which the simulation cannot be stopped, grows with its inverse.
const TIME_FACTOR_MIN: f64 = 0.01;

/// Maximum time factor.
const TIME_FACTOR_MAX: f64 = 1000.0;

/// Maximum real time that the simulation catches up after a delay; the rest is skipped.
const CATCH_UP_MAX: Duration = Duration::from_millis(250);

/// Minimum sleep between two polls of the ports.
const REST_MIN: Duration = Duration::from_millis(1);

/// Number of uplink bytes taken before their byte time; at this limit the ports are not read.
const UPLINK_AHEAD: usize = 256;

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
    errors: Mutex<VecDeque<ServeError>>,
}

/// Opens the endpoints and starts the robot.
///
/// # Errors
///
/// If an endpoint, its link or a file cannot be opened, or the time factor is out of range.
pub fn serve(mut config: SimulationConfig, options: &ServeOptions) -> Result<Server, ServeError> {
    if !(TIME_FACTOR_MIN..=TIME_FACTOR_MAX).contains(&options.time_factor) {
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
        errors: Mutex::default(),
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
            let (port, path) = Pty::open(link.as_deref(), *copy_only)?;
            Ok((Box::new(port), path))
        }
        #[cfg(not(unix))]
        Endpoint::Pty { .. } => Err(ServeError::Pty(std::io::ErrorKind::Unsupported.into())),
        Endpoint::Tcp { address, copy_only } => {
            let (port, bound) = tcp::Tcp::listen(address, *copy_only)?;
            Ok((Box::new(port), bound))
        }
    }
}

impl Server {
    /// Addresses of the endpoints in order: the path of a pseudo-terminal, or `HOST:PORT`.
    #[must_use]
    pub fn addresses(&self) -> &[String] {
        &self.addresses
    }

    /// Walls and furniture in the robot's coordinates.
    #[must_use]
    pub fn outlines(&self) -> &[Outline] {
        &self.outlines
    }

    /// Boot counter of the running robot.
    #[must_use]
    pub const fn boots(&self) -> u16 {
        self.boots
    }

    /// True state of the robot, at most a few byte times old.
    #[must_use]
    pub fn truth(&self) -> Truth {
        *self
            .shared
            .truth
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }

    /// Number of bytes taken from the endpoints for the robot.
    #[must_use]
    pub fn uplink_bytes(&self) -> u64 {
        self.shared.uplink_bytes.load(Ordering::Relaxed)
    }

    /// Whether the robot still runs: not stopped, and its duration has not passed.
    #[must_use]
    pub fn is_running(&self) -> bool {
        self.thread
            .as_ref()
            .is_some_and(|thread| !thread.is_finished())
    }

    /// Requests the robot's thread to end, without waiting for it.
    pub fn stop(&self) {
        self.shared.stop.store(true, Ordering::Relaxed);
    }

    /// The next error of a file that could not be written completely; all errors are available when the robot has
    /// [stopped](Server::end).
    #[must_use]
    pub fn poll_error(&self) -> Option<ServeError> {
        self.shared.errors().pop_front()
    }

    /// Stops the robot and completes its files.
    pub fn end(&mut self) {
        self.stop();
        self.join();
    }

    /// Waits until the duration has passed or another thread calls [`Server::stop`].
    pub fn wait(mut self) {
        self.join();
    }

    fn join(&mut self) {
        if let Some(thread) = self.thread.take() {
            // The thread has already reported a panic of its own.
            let _ = thread.join();
        }
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.end();
    }
}

impl Shared {
    fn errors(&self) -> MutexGuard<'_, VecDeque<ServeError>> {
        self.errors.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// State of the simulation's thread.
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
        self.shared.errors().extend(self.recordings.finish());
    }

    /// Takes input, runs the simulation up to a time and writes the output.
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
        let mut errors = Vec::new();
        while self.simulation.now_ms() < target_ms {
            self.simulation.step();
            errors.extend(self.recordings.observe(&self.simulation));
            received.extend(std::iter::from_fn(|| self.simulation.poll_downlink()));
        }
        if let Some(eeprom) = &mut self.eeprom {
            errors.extend(eeprom.keep(self.simulation.kept_parameters()));
        }
        if !errors.is_empty() {
            self.shared.errors().extend(errors);
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
