//! A radio link: a serial device, a TCP bridge or standard input, kept open.
//!
//! Two threads own it. The reader hands every chunk to the [`Sink`] (the recorder) before anything
//! else sees it, and opens the link again by itself when it is gone. The writer keeps a stuck device
//! from holding up anybody.

use std::fmt;
use std::io::{self, Read, Write};
use std::net::TcpStream;
use std::path::PathBuf;
use std::str::FromStr;
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use groundwave_protocol::LINE_BYTES;
use serialport::SerialPort;
use tokio::sync::mpsc::Sender;

/// The radio's speed.
pub const BAUD: u32 = 2400;

/// How long to wait before a lost link is tried again.
const RETRY_EVERY: Duration = Duration::from_millis(400);

/// A read that brings nothing returns after this; it only bounds how late a dead thread is noticed.
const READ_TIMEOUT: Duration = Duration::from_secs(1);

const CONNECT_TIMEOUT: Duration = Duration::from_secs(3);

/// Where the radio is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LinkSpec {
    /// A serial device.
    Serial(PathBuf),
    /// A serial server: `HOST:PORT`.
    Tcp(String),
    /// Standard input, receive only.
    Stdin,
    /// An embedded simulated robot.
    Sim,
}

impl FromStr for LinkSpec {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        match text {
            "" => Err("a link is a serial device, `tcp:HOST:PORT`, `-` or `sim`".to_owned()),
            "-" => Ok(Self::Stdin),
            "sim" => Ok(Self::Sim),
            _ => match text.strip_prefix("tcp:") {
                Some(address) if has_port(address) => Ok(Self::Tcp(address.to_owned())),
                Some(address) => Err(format!(
                    "`{address}` is not HOST:PORT; try tcp:localhost:4000"
                )),
                None => Ok(Self::Serial(PathBuf::from(text))),
            },
        }
    }
}

fn has_port(address: &str) -> bool {
    address
        .rsplit_once(':')
        .is_some_and(|(host, port)| !host.is_empty() && port.parse::<u16>().is_ok())
}

impl fmt::Display for LinkSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Serial(path) => write!(f, "{}", path.display()),
            Self::Tcp(address) => write!(f, "tcp:{address}"),
            Self::Stdin => f.write_str("standard input"),
            Self::Sim => f.write_str("sim"),
        }
    }
}

/// Why a link cannot be opened, with the remedy.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// Nothing of that name.
    #[error(
        "cannot open {0}: there is no such device. `groundwave ports` lists what is plugged in"
    )]
    Missing(String),
    /// Another program holds it.
    #[error(
        "cannot open {0}: it is busy, another program holds it. Close that program (`fuser {0}` names it on Linux) and try again"
    )]
    Busy(String),
    /// Not ours to open.
    #[error("cannot open {0}: permission denied. {remedy}", remedy = permission_remedy())]
    Permission(String),
    /// It is there and does not behave like a serial device.
    #[error("cannot open {0}: it is not a serial device")]
    NotSerial(String),
    /// The other end of a TCP link does not answer.
    #[error("cannot connect to {0}: {1}. Is the serial server running and the address right?")]
    Tcp(String, io::Error),
    /// Something else.
    #[error("cannot open {0}: {1}")]
    Other(String, String),
}

const fn permission_remedy() -> &'static str {
    if cfg!(target_os = "linux") {
        "Serial devices belong to a group, mostly `dialout` or `uucp`: `sudo usermod -aG dialout $USER`, then log in again"
    } else if cfg!(target_os = "macos") {
        "Use the device under /dev/cu.*, and check System Settings for a driver that waits for permission"
    } else {
        "Check who may use the device"
    }
}

/// What the reader thread reports.
#[derive(Debug)]
pub enum LinkInput {
    /// The link is open (again).
    Opened,
    /// Bytes, and when the read that brought them returned.
    Bytes(Instant, Vec<u8>),
    /// The link is gone and will be tried again.
    Lost(String),
    /// Standard input has ended.
    Ended,
}

/// Takes every received chunk before anything else does.
pub type Sink = Box<dyn FnMut(Instant, &[u8]) + Send>;

type Reading = Box<dyn Read + Send>;
type Writing = Box<dyn Write + Send>;
type SharedWriting = Arc<Mutex<Option<Writing>>>;

/// An open link.
#[derive(Debug)]
pub struct Link {
    to_writer: Option<SyncSender<Vec<u8>>>,
    overflowed: u64,
}

impl Link {
    /// Starts the threads of a link that is open. It stays open: a loss is reported as
    /// [`LinkInput::Lost`] and the link is opened again as soon as it can be.
    #[must_use]
    pub fn start(
        spec: LinkSpec,
        baud: u32,
        connection: Connection,
        mut sink: Sink,
        inputs: Sender<LinkInput>,
    ) -> Self {
        let Connection {
            mut reading,
            writing,
        } = connection;
        let can_send = writing.is_some();
        let shared: SharedWriting = Arc::new(Mutex::new(writing));
        let to_writer = can_send.then(|| start_writer(Arc::clone(&shared)));
        thread::spawn(move || {
            loop {
                if inputs.blocking_send(LinkInput::Opened).is_err() {
                    return;
                }
                match read_until_lost(&mut reading, &mut sink, &inputs) {
                    End::Closed => return,
                    End::Finished if spec == LinkSpec::Stdin => {
                        // The station may be gone already; there is nobody else to tell.
                        let _ = inputs.blocking_send(LinkInput::Ended);
                        return;
                    }
                    End::Finished => lose(&inputs, &shared, "unplugged".to_owned()),
                    End::Failed(error) => lose(&inputs, &shared, describe(&error)),
                }
                let Some(again) = reopen(&spec, baud, &inputs) else {
                    return;
                };
                reading = again.reading;
                *shared.lock().unwrap_or_else(PoisonError::into_inner) = again.writing;
            }
        });
        Self {
            to_writer,
            overflowed: 0,
        }
    }

    /// No radio at all: what is received comes from elsewhere.
    #[must_use]
    pub const fn receive_only() -> Self {
        Self {
            to_writer: None,
            overflowed: 0,
        }
    }

    /// Whether anything can be sent.
    #[must_use]
    pub const fn can_send(&self) -> bool {
        self.to_writer.is_some()
    }

    /// Sends bytes. A device that takes none for long loses them, which the protocol repairs.
    pub fn send(&mut self, bytes: &[u8]) {
        if let Some(to_writer) = &self.to_writer
            && let Err(TrySendError::Full(_)) = to_writer.try_send(bytes.to_vec())
        {
            self.overflowed += bytes.len() as u64;
        }
    }

    /// Bytes that a stuck device did not take.
    #[must_use]
    pub const fn overflowed(&self) -> u64 {
        self.overflowed
    }
}

fn start_writer(shared: SharedWriting) -> SyncSender<Vec<u8>> {
    let (to_writer, from_station): (_, Receiver<Vec<u8>>) = sync_channel(8);
    thread::spawn(move || {
        for bytes in from_station {
            let mut writing = shared.lock().unwrap_or_else(PoisonError::into_inner);
            if let Some(port) = writing.as_mut()
                && port.write_all(&bytes).and_then(|()| port.flush()).is_err()
            {
                // The reader finds out why, and brings the link back.
                *writing = None;
            }
        }
    });
    to_writer
}

fn lose(inputs: &Sender<LinkInput>, shared: &SharedWriting, reason: String) {
    *shared.lock().unwrap_or_else(PoisonError::into_inner) = None;
    // A station that is gone needs no report; `reopen` notices.
    let _ = inputs.blocking_send(LinkInput::Lost(reason));
}

fn reopen(spec: &LinkSpec, baud: u32, inputs: &Sender<LinkInput>) -> Option<Connection> {
    while !inputs.is_closed() {
        if let Ok(connection) = Connection::open(spec, baud) {
            return Some(connection);
        }
        thread::sleep(RETRY_EVERY);
    }
    None
}

enum End {
    /// Nobody listens to us any more.
    Closed,
    /// End of file: a closed pty, an unplugged device or the end of standard input.
    Finished,
    Failed(io::Error),
}

/// Reads until there is nothing more to read. The sink gets every chunk at once; the station is woken
/// when a line may be complete, three times a second instead of at each of a port's small clumps.
fn read_until_lost(reading: &mut Reading, sink: &mut Sink, inputs: &Sender<LinkInput>) -> End {
    let mut buffer = [0; 4096];
    let mut held = Vec::new();
    loop {
        match reading.read(&mut buffer) {
            Ok(0) => return End::Finished,
            Ok(count) => {
                let now = Instant::now();
                let bytes = &buffer[..count];
                sink(now, bytes);
                held.extend_from_slice(bytes);
                let may_be_whole = bytes.contains(&b'\n') || held.len() >= LINE_BYTES;
                if may_be_whole
                    && inputs
                        .blocking_send(LinkInput::Bytes(now, std::mem::take(&mut held)))
                        .is_err()
                {
                    return End::Closed;
                }
            }
            Err(error) => match error.kind() {
                io::ErrorKind::TimedOut
                | io::ErrorKind::WouldBlock
                | io::ErrorKind::Interrupted => {
                    if inputs.is_closed() {
                        return End::Closed;
                    }
                }
                _ => return End::Failed(error),
            },
        }
    }
}

fn describe(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::BrokenPipe => "unplugged".to_owned(),
        _ => error.to_string(),
    }
}

/// An open device or socket.
pub struct Connection {
    reading: Reading,
    writing: Option<Writing>,
}

impl Connection {
    /// Opens a link.
    ///
    /// # Errors
    /// When it cannot be opened now.
    pub fn open(spec: &LinkSpec, baud: u32) -> Result<Self, OpenError> {
        match spec {
            LinkSpec::Serial(path) => connect_serial(&path.display().to_string(), baud),
            LinkSpec::Tcp(address) => {
                let stream =
                    connect_tcp(address).map_err(|e| OpenError::Tcp(address.clone(), e))?;
                let writing = stream
                    .try_clone()
                    .map_err(|e| OpenError::Tcp(address.clone(), e))?;
                Ok(Self {
                    reading: Box::new(stream),
                    writing: Some(Box::new(writing)),
                })
            }
            LinkSpec::Stdin => Ok(Self {
                reading: Box::new(io::stdin()),
                writing: None,
            }),
            LinkSpec::Sim => Err(OpenError::Other(
                spec.to_string(),
                "the embedded simulator was not started".to_owned(),
            )),
        }
    }
}

fn connect_tcp(address: &str) -> io::Result<TcpStream> {
    use std::net::ToSocketAddrs;
    let mut failure = io::Error::from(io::ErrorKind::AddrNotAvailable);
    for address in address.to_socket_addrs()? {
        match TcpStream::connect_timeout(&address, CONNECT_TIMEOUT) {
            Ok(stream) => {
                stream.set_nodelay(true)?;
                return Ok(stream);
            }
            Err(error) => failure = error,
        }
    }
    Err(failure)
}

/// Opening leaves DTR as it is: toggling it resets an Arduino.
fn connect_serial(name: &str, baud: u32) -> Result<Connection, OpenError> {
    let port = serialport::new(name, baud)
        .timeout(READ_TIMEOUT)
        .preserve_dtr_on_open()
        .open()
        .map_err(|error| open_error(name, &error))?;
    let writing = clone_port(name, port.as_ref())?;
    Ok(Connection {
        reading: Box::new(port),
        writing: Some(Box::new(writing)),
    })
}

fn clone_port(name: &str, port: &dyn SerialPort) -> Result<Box<dyn SerialPort>, OpenError> {
    port.try_clone().map_err(|error| open_error(name, &error))
}

fn open_error(name: &str, error: &serialport::Error) -> OpenError {
    use serialport::ErrorKind as Kind;
    let name = name.to_owned();
    match error.kind {
        Kind::Io(io::ErrorKind::PermissionDenied) => OpenError::Permission(name),
        // The library says `NoDevice` both for a port that is gone and for one that is locked.
        Kind::NoDevice if cfg!(unix) && std::path::Path::new(&name).exists() => {
            OpenError::Busy(name)
        }
        Kind::NoDevice | Kind::Io(io::ErrorKind::NotFound) => OpenError::Missing(name),
        Kind::Unknown
            if error.description.contains("ioctl") || error.description.contains("typewriter") =>
        {
            OpenError::NotSerial(name)
        }
        _ => OpenError::Other(name, error.description.clone()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_are_told_apart() {
        assert_eq!("-".parse(), Ok(LinkSpec::Stdin));
        assert_eq!("sim".parse(), Ok(LinkSpec::Sim));
        assert_eq!(
            "/dev/ttyUSB0".parse(),
            Ok(LinkSpec::Serial("/dev/ttyUSB0".into()))
        );
        assert_eq!("COM3".parse(), Ok(LinkSpec::Serial("COM3".into())));
        assert_eq!(
            "tcp:[::1]:4000".parse(),
            Ok(LinkSpec::Tcp("[::1]:4000".to_owned()))
        );
        for wrong in [
            "",
            "tcp:",
            "tcp:4000",
            "tcp::4000",
            "tcp:robot",
            "tcp:robot:70000",
        ] {
            assert!(wrong.parse::<LinkSpec>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_missing_device_is_called_missing() {
        let spec = LinkSpec::Serial("/dev/groundwave-no-such-device".into());
        let error = Connection::open(&spec, BAUD).err().expect("opened");
        assert!(matches!(error, OpenError::Missing(_)), "{error}");
    }
}
