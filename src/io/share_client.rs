//! The share client: a connection to a station that shares its link.

use std::io::{self, Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::thread;
use std::time::{Duration, Instant};

use super::share::find_token;
use crate::hint;
use crate::share::{Address, ClientLine, Lines, StationLine, Welcome};

/// Timeout of a write.
const WRITE_TIMEOUT: Duration = Duration::from_secs(5);

/// Pause before another attempt to connect.
const RETRY_PAUSE: Duration = Duration::from_millis(50);

/// Timeout of a read; also the period of deadline checks.
const READ_TIMEOUT: Duration = Duration::from_millis(200);

/// Reason why a station cannot be reached.
#[derive(Debug, thiserror::Error)]
pub enum ShareClientError {
    /// No station shares a link at the address.
    #[error(
        "cannot reach a station at {0}: {reason}. Start one that shares its link: `groundwave watch LINK --share {0}`",
        reason = hint::words(.1)
    )]
    Connect(Address, io::Error),
    /// The server at the address is not a station.
    #[error(
        "the server at {0} is not a groundwave station that shares its link; check the address"
    )]
    NoStation(Address),
    /// The connection ended.
    #[error("the station at {0} closed the connection{1}")]
    Closed(Address, String),
    /// The station did not answer in time.
    #[error("the station at {0} does not answer")]
    Silent(Address),
}

/// Both halves of a socket with a read timeout.
pub struct Halves {
    /// The half to read.
    pub reading: Box<dyn Read + Send>,
    /// The half to write.
    pub writing: Box<dyn Write + Send>,
    /// The token to send first, if the address is a port and the token is known.
    pub token: Option<String>,
}

/// A connection to a station that shares its link.
pub struct ShareClient {
    address: Address,
    halves: Halves,
    lines: Lines,
    unread: Vec<u8>,
}

impl ShareClient {
    /// Connects and sends hello. Tries again after a connection that ends before the welcome, because a station with too many
    /// clients closes some. With `raw`, the station also sends the raw bytes.
    ///
    /// # Errors
    /// If no station answers at the address in time.
    pub fn connect(
        address: &Address,
        timeout: Duration,
        raw: bool,
    ) -> Result<(Self, Welcome), ShareClientError> {
        let deadline = Instant::now() + timeout;
        loop {
            match Self::try_connect(address, deadline, raw) {
                Err(ShareClientError::NoStation(_)) if Instant::now() < deadline => {
                    thread::sleep(RETRY_PAUSE);
                }
                ended => return ended,
            }
        }
    }

    fn try_connect(
        address: &Address,
        deadline: Instant,
        raw: bool,
    ) -> Result<(Self, Welcome), ShareClientError> {
        let halves = connect(address, deadline).map_err(|error| {
            let address = address.clone();
            match error.kind() {
                io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut => {
                    ShareClientError::Silent(address)
                }
                _ => ShareClientError::Connect(address, error),
            }
        })?;
        Self::greet(address.clone(), halves, raw, deadline)
    }

    /// Sends hello on a new connection, before or after the station's announcement. With `raw`, the station also sends the raw bytes.
    ///
    /// # Errors
    /// If the station does not welcome this program before the deadline.
    pub fn greet(
        address: Address,
        mut halves: Halves,
        raw: bool,
        deadline: Instant,
    ) -> Result<(Self, Welcome), ShareClientError> {
        // Reading the answer detects a closed connection, and still returns the station's reason.
        if let Some(token) = &halves.token {
            let _ = halves.writing.write_all(format!("{token}\n").as_bytes());
        }
        let mut client = Self {
            address,
            halves,
            lines: Lines::default(),
            unread: Vec::new(),
        };
        let hello = ClientLine::Hello {
            pid: Some(std::process::id()),
            raw,
        };
        let _ = client.send(&hello);
        loop {
            match client.next(deadline) {
                Ok(StationLine::Welcome(welcome)) => return Ok((client, welcome)),
                Ok(StationLine::Error { error, .. }) => {
                    return Err(ShareClientError::Closed(
                        client.address,
                        format!(": {error}"),
                    ));
                }
                Ok(_) => {}
                Err(ShareClientError::Closed(address, _)) => {
                    return Err(ShareClientError::NoStation(address));
                }
                Err(error) => return Err(error),
            }
        }
    }

    /// The connection, and the bytes read but not used yet.
    #[must_use]
    pub fn into_halves(self) -> (Halves, Vec<u8>) {
        (self.halves, self.unread)
    }

    /// Sends a line to the station.
    ///
    /// # Errors
    /// If the connection is closed.
    pub fn send(&mut self, line: &ClientLine) -> Result<(), ShareClientError> {
        self.halves
            .writing
            .write_all(&line.to_line())
            .map_err(|error| {
                ShareClientError::Closed(self.address.clone(), format!(": {}", hint::words(&error)))
            })
    }

    /// The station's next line; other bytes, such as the raw bytes before its welcome, are skipped.
    ///
    /// # Errors
    /// If the connection is closed, or the station sends no line before the deadline.
    pub fn next(&mut self, deadline: Instant) -> Result<StationLine, ShareClientError> {
        loop {
            while !self.unread.is_empty() {
                let (taken, line) = self.lines.take(&self.unread);
                self.unread.drain(..taken);
                if let Ok(Some(line)) = line
                    && let Some(line) = StationLine::parse(&line)
                {
                    return Ok(line);
                }
            }
            if Instant::now() >= deadline {
                return Err(ShareClientError::Silent(self.address.clone()));
            }
            let mut buffer = [0; 4096];
            match self.halves.reading.read(&mut buffer) {
                Ok(0) => {
                    return Err(ShareClientError::Closed(
                        self.address.clone(),
                        String::new(),
                    ));
                }
                Ok(count) => self.unread.extend_from_slice(&buffer[..count]),
                Err(error) => match error.kind() {
                    io::ErrorKind::WouldBlock
                    | io::ErrorKind::TimedOut
                    | io::ErrorKind::Interrupted => {}
                    _ => {
                        return Err(ShareClientError::Closed(
                            self.address.clone(),
                            format!(": {}", hint::words(&error)),
                        ));
                    }
                },
            }
        }
    }
}

fn connect(address: &Address, deadline: Instant) -> io::Result<Halves> {
    // A time limit of zero is an error.
    let left = || {
        let left = deadline.saturating_duration_since(Instant::now());
        left.max(Duration::from_millis(1))
    };
    match address {
        Address::Tcp(address) => {
            let mut failure = io::Error::from(io::ErrorKind::AddrNotAvailable);
            for address in address.to_socket_addrs()? {
                match TcpStream::connect_timeout(&address, left()) {
                    Ok(stream) => {
                        stream.set_nodelay(true)?;
                        stream.set_read_timeout(Some(READ_TIMEOUT))?;
                        stream.set_write_timeout(Some(WRITE_TIMEOUT))?;
                        return Ok(Halves {
                            token: find_token(&stream),
                            reading: Box::new(stream.try_clone()?),
                            writing: Box::new(stream),
                        });
                    }
                    Err(error) => failure = error,
                }
            }
            Err(failure)
        }
        #[cfg(unix)]
        Address::Unix(path) => {
            let stream = super::unix_socket::connect(path, left())?;
            stream.set_read_timeout(Some(READ_TIMEOUT))?;
            stream.set_write_timeout(Some(WRITE_TIMEOUT))?;
            Ok(Halves {
                token: None,
                reading: Box::new(stream.try_clone()?),
                writing: Box::new(stream),
            })
        }
        #[cfg(not(unix))]
        Address::Unix(_) => Err(io::Error::new(
            io::ErrorKind::Unsupported,
            "this system has no Unix sockets here",
        )),
    }
}
