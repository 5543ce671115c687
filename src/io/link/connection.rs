//! Opening serial devices, sockets and standard input.

use std::fs;
use std::io::{self, Cursor, Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::path::Path;
use std::thread;
use std::time::{Duration, Instant};

use super::super::usb::{self, UsbIdentity, Whereabouts};
use super::error::OpenError;
use super::pseudo_terminal::PseudoTerminal;
use super::spec::LinkSpec;
use crate::io::ports;
use crate::io::share::find_token;
use crate::io::share_client::{Halves, ShareClient, ShareClientError};
use crate::share::{Address, Welcome, is_announced};

/// Timeout of each read and write; a dead device must not block a thread.
const PATIENCE: Duration = Duration::from_secs(1);

const CONNECT_TIMEOUT: Duration = Duration::from_secs(3);

/// Timeout of a reconnection; shorter than the first one, to find a host within 2 s of its return.
const RECONNECT_TIMEOUT: Duration = Duration::from_millis(1200);

/// Time for a shared link to announce itself.
const ANNOUNCEMENT_TIMEOUT: Duration = Duration::from_millis(500);

/// First pause before another attempt at a shared link that made room for others; it doubles up to the longest.
const SHARE_RETRY_PAUSE: Duration = Duration::from_millis(50);
const SHARE_RETRY_PAUSE_MAX: Duration = Duration::from_millis(400);

/// Pause between two attempts to open a link that does not exist yet.
const ABSENCE_PAUSE: Duration = Duration::from_millis(250);

/// Maximum time that the system may need to give access to a new device.
const SETTLING: Duration = Duration::from_secs(3);

/// Keepalive probes: idle time before the first, and the interval.
const PROBE_AFTER: Duration = Duration::from_secs(5);
const PROBE_EVERY: Duration = Duration::from_secs(2);

/// Time without TCP acknowledgement after which a peer counts as lost.
#[cfg(target_os = "linux")]
const PEER_TIMEOUT: Duration = Duration::from_secs(10);

pub(super) type Reading = Box<dyn Read + Send>;

pub(super) type Writing = Box<dyn Write + Send>;

/// An open device or socket.
pub struct Connection {
    pub(super) reading: Reading,
    /// Writing half; `None` for receive-only links.
    pub(super) writing: Option<Writing>,
    /// The device's name, if it differs from the operator's.
    pub(super) renamed: Option<String>,
    /// Welcome of the station at the other end, if it shares its link; both ends then exchange lines, not bytes.
    pub(super) share: Option<Welcome>,
}

impl Connection {
    /// Opens a link.
    ///
    /// # Errors
    /// If the link cannot be opened now.
    pub fn open(spec: &LinkSpec, baud: u32) -> Result<Self, OpenError> {
        let deadline = Instant::now() + CONNECT_TIMEOUT;
        let mut pause = SHARE_RETRY_PAUSE;
        loop {
            match Self::open_once(spec, baud, CONNECT_TIMEOUT, deadline) {
                // A station with too many clients closes some.
                Err(OpenError::Share(ShareClientError::NoStation(_)))
                    if Instant::now() + pause < deadline =>
                {
                    thread::sleep(pause);
                    pause = (pause * 2).min(SHARE_RETRY_PAUSE_MAX);
                }
                opened => return opened,
            }
        }
    }

    /// Opens a link that may not exist yet; waits for it, forever if there is no limit. Calls `on_absence` once.
    ///
    /// # Errors
    /// If the link exists but cannot be opened, or the limit has passed.
    pub fn open_once_there(
        spec: &LinkSpec,
        baud: u32,
        limit: Option<Duration>,
        on_absence: impl FnOnce(),
    ) -> Result<Self, OpenError> {
        let begun = Instant::now();
        let mut on_absence = Some(on_absence);
        let mut absent_at = None;
        loop {
            let error = match Self::open(spec, baud) {
                Ok(connection) => return Ok(connection),
                Err(error) => error,
            };
            if error.is_absence() {
                absent_at = Some(Instant::now());
            }
            let may_come = absent_at.is_some_and(|at| at.elapsed() < SETTLING);
            if !may_come || limit.is_some_and(|limit| begun.elapsed() >= limit) {
                return Err(error);
            }
            if let Some(on_absence) = on_absence.take() {
                on_absence();
            }
            thread::sleep(ABSENCE_PAUSE);
        }
    }

    /// Whether a station at the other end shares its link.
    #[must_use]
    pub const fn is_shared(&self) -> bool {
        self.share.is_some()
    }

    fn open_once(
        spec: &LinkSpec,
        baud: u32,
        timeout: Duration,
        deadline: Instant,
    ) -> Result<Self, OpenError> {
        match spec {
            LinkSpec::Serial(path) => open_serial(&path.display().to_string(), baud),
            LinkSpec::Tcp(address) => {
                let failed = |error| OpenError::Tcp(address.clone(), error);
                let stream = open_tcp(address, timeout).map_err(failed)?;
                let limit_reads = |timeout| stream.set_read_timeout(timeout);
                let first = first_bytes(&stream, limit_reads).map_err(failed)?;
                let writing: Writing = Box::new(stream.try_clone().map_err(failed)?);
                if is_announced(&first) == Some(true) {
                    let halves = Halves {
                        token: find_token(&stream),
                        reading: Box::new(stream),
                        writing,
                    };
                    return Self::of_station(Address::Tcp(address.clone()), halves, deadline);
                }
                Ok(Self {
                    writing: Some(writing),
                    ..Self::receive_only(Box::new(Cursor::new(first).chain(stream)))
                })
            }
            #[cfg(unix)]
            LinkSpec::Unix(path) => {
                let failed = |error| OpenError::Unix(path.display().to_string(), error);
                let stream = crate::io::unix_socket::connect(path, timeout).map_err(failed)?;
                let limit_reads = |timeout| stream.set_read_timeout(timeout);
                let first = first_bytes(&stream, limit_reads).map_err(failed)?;
                if is_announced(&first) == Some(true) {
                    let halves = Halves {
                        writing: Box::new(stream.try_clone().map_err(failed)?),
                        reading: Box::new(stream),
                        token: None,
                    };
                    return Self::of_station(Address::Unix(path.clone()), halves, deadline);
                }
                Ok(Self::receive_only(Box::new(
                    Cursor::new(first).chain(stream),
                )))
            }
            #[cfg(not(unix))]
            LinkSpec::Unix(path) => Err(OpenError::Unix(
                path.display().to_string(),
                io::Error::new(
                    io::ErrorKind::Unsupported,
                    "this system has no Unix sockets; share on a port instead",
                ),
            )),
            LinkSpec::Stdin => Ok(Self::receive_only(standard_input())),
            LinkSpec::Sim => Err(OpenError::Other(
                spec.to_string(),
                "the embedded simulator was not started".to_owned(),
            )),
        }
    }

    fn receive_only(reading: Reading) -> Self {
        Self {
            reading,
            writing: None,
            renamed: None,
            share: None,
        }
    }

    /// Becomes a client of the station that announced itself on the connection.
    fn of_station(address: Address, halves: Halves, deadline: Instant) -> Result<Self, OpenError> {
        let (client, welcome) = ShareClient::greet(address, halves, true, deadline)?;
        let (halves, unread) = client.into_halves();
        Ok(Self {
            writing: Some(halves.writing),
            share: Some(welcome),
            ..Self::receive_only(Box::new(Cursor::new(unread).chain(halves.reading)))
        })
    }
}

/// The first bytes of a socket: enough to recognize a shared link if they arrive in time.
fn first_bytes(
    mut stream: impl Read,
    limit_reads: impl Fn(Option<Duration>) -> io::Result<()>,
) -> io::Result<Vec<u8>> {
    let deadline = Instant::now() + ANNOUNCEMENT_TIMEOUT;
    limit_reads(Some(ANNOUNCEMENT_TIMEOUT))?;
    let mut first = Vec::new();
    let mut buffer = [0; 256];
    while is_announced(&first).is_none() && Instant::now() < deadline {
        match stream.read(&mut buffer) {
            Ok(count @ 1..) => first.extend_from_slice(&buffer[..count]),
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            // The reader gets the end or the error again.
            Ok(0) | Err(_) => break,
        }
    }
    limit_reads(Some(PATIENCE))?;
    Ok(first)
}

/// Reopens a lost link.
pub(super) struct Reopener {
    spec: LinkSpec,
    baud: u32,
    usb: Option<UsbIdentity>,
    pseudo_terminal: Option<PseudoTerminal>,
}

impl Reopener {
    /// Prepares to reopen a link; looks up the identity of its device while it is there.
    pub(super) fn new(spec: LinkSpec, baud: u32) -> Self {
        let (mut usb, mut pseudo_terminal) = (None, None);
        if let LinkSpec::Serial(path) = &spec {
            let name = device_name(path);
            usb = ports::plugged()
                .into_iter()
                .find(|port| port.name == name)
                .and_then(|port| port.usb);
            pseudo_terminal = PseudoTerminal::find(path);
        }
        Self {
            spec,
            baud,
            usb,
            pseudo_terminal,
        }
    }

    /// Whether the end of the link's bytes ends the session.
    pub(super) fn is_final(&self) -> bool {
        self.spec == LinkSpec::Stdin
    }

    /// Reason shown for an end of file.
    pub(super) const fn end_of_file(&self) -> &'static str {
        match self.spec {
            LinkSpec::Serial(_) => "unplugged",
            _ => "the other end closed the connection",
        }
    }

    pub(super) fn open(&mut self) -> Result<Connection, OpenError> {
        if let (LinkSpec::Serial(path), Some(known)) = (&self.spec, &self.pseudo_terminal)
            && let Some(now) = PseudoTerminal::find(path)
        {
            if known.is_replaced_by(&now) {
                return Err(OpenError::AnotherTerminal(path.display().to_string()));
            }
            self.pseudo_terminal = Some(now);
        }
        let (LinkSpec::Serial(path), Some(usb)) = (&self.spec, &self.usb) else {
            let deadline = Instant::now() + RECONNECT_TIMEOUT;
            return Connection::open_once(&self.spec, self.baud, RECONNECT_TIMEOUT, deadline);
        };
        let name = device_name(path);
        match usb::find(&name, usb, &ports::plugged()) {
            Whereabouts::Here(now) if now == name => {
                open_serial(&path.display().to_string(), self.baud)
            }
            Whereabouts::Here(now) => {
                let connection = open_serial(&now, self.baud)?;
                Ok(Connection {
                    renamed: Some(now),
                    ..connection
                })
            }
            Whereabouts::Absent => Err(OpenError::Missing(name)),
            Whereabouts::Replaced => Err(OpenError::Another(name)),
            Whereabouts::Ambiguous(names) => Err(OpenError::Ambiguous(name, names.join(", "))),
        }
    }
}

/// The device's name in the system's list of ports; `/dev/serial/by-id/...` is a symbolic link to it.
fn device_name(path: &Path) -> String {
    fs::canonicalize(path)
        .unwrap_or_else(|_| path.to_owned())
        .display()
        .to_string()
}

fn open_tcp(address: &str, timeout: Duration) -> io::Result<TcpStream> {
    let mut failure = io::Error::from(io::ErrorKind::AddrNotAvailable);
    for address in address.to_socket_addrs()? {
        match TcpStream::connect_timeout(&address, timeout) {
            Ok(stream) => {
                prepare_tcp(&stream)?;
                return Ok(stream);
            }
            Err(error) => failure = error,
        }
    }
    Err(failure)
}

/// Sets the write timeout and keepalive probes, which detect a bridge that lost its power.
fn prepare_tcp(stream: &TcpStream) -> io::Result<()> {
    stream.set_nodelay(true)?;
    stream.set_write_timeout(Some(PATIENCE))?;
    let socket = socket2::SockRef::from(stream);
    let probes = socket2::TcpKeepalive::new()
        .with_time(PROBE_AFTER)
        .with_interval(PROBE_EVERY);
    socket.set_tcp_keepalive(&probes)?;
    #[cfg(target_os = "linux")]
    socket.set_tcp_user_timeout(Some(PEER_TIMEOUT))?;
    Ok(())
}

/// Opens a serial port and leaves DTR unchanged: toggling it resets an Arduino.
fn open_serial(name: &str, baud: u32) -> Result<Connection, OpenError> {
    let (reading, writing) =
        serial_halves(name, baud).map_err(|error| OpenError::serial(name, &error))?;
    Ok(Connection {
        writing: Some(writing),
        ..Connection::receive_only(reading)
    })
}

#[cfg(not(windows))]
fn serial_halves(name: &str, baud: u32) -> serialport::Result<(Reading, Writing)> {
    let port = serialport::new(name, baud)
        .timeout(PATIENCE)
        .preserve_dtr_on_open()
        .open()?;
    let writing = port.try_clone()?;
    Ok((Box::new(port), Box::new(writing)))
}

/// Opens both halves of a serial port. With `serialport`, on Windows, a write waits for the current read, so STOP would wait for a silent robot; and DTR is cleared.
#[cfg(windows)]
fn serial_halves(name: &str, baud: u32) -> serialport::Result<(Reading, Writing)> {
    use serial2::{CharSize, Parity, SerialPort, Settings, StopBits};
    let open = || {
        let mut port = SerialPort::open(name, |mut settings: Settings| {
            // The library's flow control would also set DTR.
            settings.set_char_size(CharSize::Bits8);
            settings.set_stop_bits(StopBits::One);
            settings.set_parity(Parity::None);
            settings.set_baud_rate(baud)?;
            Ok(settings)
        })?;
        port.set_read_timeout(PATIENCE)?;
        port.set_write_timeout(PATIENCE)?;
        let writing = port.try_clone()?;
        Ok((
            Box::new(ShortReads(port)) as Reading,
            Box::new(writing) as Writing,
        ))
    };
    open().map_err(|error: io::Error| match error.kind() {
        // The system denies access to a port that another program holds.
        io::ErrorKind::NotFound | io::ErrorKind::PermissionDenied => {
            serialport::Error::new(serialport::ErrorKind::NoDevice, error.to_string())
        }
        _ => error.into(),
    })
}

/// Reads a few bytes at a time: Wine ends a read when its buffer is full, not when bytes have arrived.
#[cfg(windows)]
struct ShortReads(serial2::SerialPort);

#[cfg(windows)]
impl Read for ShortReads {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = buffer.len().min(16);
        self.0.read(&mut buffer[..count])
    }
}

/// Standard input without the standard library's buffer: a killed program would lose the buffered bytes.
fn standard_input() -> Reading {
    #[cfg(unix)]
    {
        use std::os::fd::AsFd;
        if let Ok(handle) = io::stdin().as_fd().try_clone_to_owned() {
            return Box::new(fs::File::from(handle));
        }
    }
    Box::new(io::stdin())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::link::BAUD;

    #[test]
    fn a_missing_device_is_reported_as_missing() {
        let spec = LinkSpec::Serial("/dev/groundwave-no-such-device".into());
        let error = Connection::open(&spec, BAUD).err().expect("opened");
        assert!(matches!(error, OpenError::Missing(_)), "{error}");
    }

    /// The reader paces the attempts, so that each attempt is a single connection.
    #[test]
    fn an_attempt_to_reopen_dials_once() {
        let listener = std::net::TcpListener::bind("127.0.0.1:0").expect("a port");
        let address = listener.local_addr().expect("its address").to_string();
        let station = thread::spawn(move || {
            let mut count = 0;
            for peer in listener.incoming() {
                let mut peer = peer.expect("a peer");
                let mut first = [0];
                let _ = peer.write_all(crate::share::ANNOUNCEMENT);
                let _ = peer.read(&mut first);
                if first == *b"!" {
                    break;
                }
                count += 1;
            }
            count
        });
        let mut reopener = Reopener::new(LinkSpec::Tcp(address.clone()), BAUD);
        let error = reopener.open().err().expect("opened");
        assert!(matches!(error, OpenError::Share(_)), "{error}");
        let mut last = TcpStream::connect(address).expect("a connection");
        last.write_all(b"!").expect("sent");
        assert_eq!(station.join().expect("a count"), 1);
    }

    /// The number of a pseudo-terminal that has gone is soon another program's, such as a shell's.
    #[cfg(target_os = "linux")]
    #[test]
    fn another_terminal_of_the_same_name_is_not_opened() {
        use serialport::{SerialPort as _, TTYPort};
        let folder = tempfile::tempdir().expect("a folder");
        let link = folder.path().join("robot");
        let outer = folder.path().join("outer");
        std::os::unix::fs::symlink("robot", &outer).expect("a link");
        let reopener = |path: &Path| Reopener::new(LinkSpec::Serial(path.to_owned()), BAUD);
        let (master, slave) = TTYPort::pair().expect("a pseudo-terminal");
        let name = slave.name().expect("its name");
        std::os::unix::fs::symlink(&name, &link).expect("a link");
        drop(slave);
        let mut reopeners = [name.as_ref(), &*link, &outer].map(reopener);
        for reopener in &mut reopeners {
            reopener.open().expect("the same terminal");
        }
        let known = PseudoTerminal::find(name.as_ref());
        drop(master);
        let mut others = Vec::new();
        loop {
            match PseudoTerminal::find(name.as_ref()) {
                None => others.push(TTYPort::pair().expect("a pseudo-terminal")),
                // The clock for the times of files ticks every few milliseconds.
                now if now == known => others.clear(),
                _ => break,
            }
        }
        for reopener in &mut reopeners {
            let error = reopener.open().err().expect("opened");
            assert!(matches!(error, OpenError::AnotherTerminal(_)), "{error}");
        }
        let (_master, slave) = TTYPort::pair().expect("a pseudo-terminal");
        fs::remove_file(&link).expect("a link");
        std::os::unix::fs::symlink(slave.name().expect("its name"), &link).expect("a link");
        drop(slave);
        for reopener in &mut reopeners[1..] {
            reopener.open().expect("the terminal of a new link");
        }
    }

    /// The peer reads nothing, so its window closes; without a timeout, the write would block forever.
    #[test]
    fn a_bridge_that_takes_no_bytes_fails_the_write() {
        let listener = std::net::TcpListener::bind("127.0.0.1:0").expect("a port");
        let address = listener.local_addr().expect("its address").to_string();
        let spec = LinkSpec::Tcp(address);
        let mut connection = Connection::open(&spec, BAUD).expect("a connection");
        let _peer = listener.accept().expect("a peer that never reads");
        let writing = connection.writing.as_mut().expect("a writer");
        let error = loop {
            if let Err(error) = writing.write_all(&[0; 1 << 12]) {
                break error;
            }
        };
        assert!(
            matches!(
                error.kind(),
                io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut
            ),
            "{error}"
        );
    }
}
