//! The share client: sends commands through a station that shares its link.

use std::io::{self, Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::thread;
use std::time::{Duration, Instant};

use super::share::find_token;
use crate::share::{Address, ClientLine, Lines, StationLine, Welcome};

/// Timeout of a write.
const WRITE_TIMEOUT: Duration = Duration::from_secs(5);

/// Pause before another attempt to connect.
const RETRY_PAUSE: Duration = Duration::from_millis(50);

/// Timeout of a read, so that deadlines are checked.
const READ_TIMEOUT: Duration = Duration::from_millis(200);

/// Reason why a station cannot be reached.
#[derive(Debug, thiserror::Error)]
pub enum ShareClientError {
    /// No station shares a link at the address.
    #[error(
        "cannot reach a station at {0}: {1}. Start one that shares its link: `groundwave watch LINK --share {0}`"
    )]
    Connect(Address, io::Error),
    /// The server at the address is no station.
    #[error("the server at {0} is no groundwave station that shares its link; check the address")]
    NoStation(Address),
    /// The connection ended.
    #[error("the station at {0} closed the connection{1}")]
    Closed(Address, String),
    /// The station did not answer in time.
    #[error("the station at {0} does not answer")]
    Silent(Address),
}

trait Socket: Read + Write {}

impl<T: Read + Write> Socket for T {}

/// A connection to a station that shares its link.
pub struct ShareClient {
    address: Address,
    socket: Box<dyn Socket>,
    lines: Lines,
    unread: Vec<u8>,
}

impl ShareClient {
    /// Connects and says hello. Tries again after a connection that ends before the welcome, because a station with too many
    /// clients closes some.
    ///
    /// # Errors
    /// When no station answers there in time.
    pub fn connect(
        address: &Address,
        timeout: Duration,
    ) -> Result<(Self, Welcome), ShareClientError> {
        let deadline = Instant::now() + timeout;
        loop {
            match Self::try_connect(address, deadline) {
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
    ) -> Result<(Self, Welcome), ShareClientError> {
        let (mut socket, token) = connect(address, deadline).map_err(|error| {
            let address = address.clone();
            match error.kind() {
                io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut => {
                    ShareClientError::Silent(address)
                }
                _ => ShareClientError::Connect(address, error),
            }
        })?;
        if let Some(token) = token {
            // A station that is gone is noticed with the hello.
            let _ = socket.write_all(format!("{token}\n").as_bytes());
        }
        let mut client = Self {
            address: address.clone(),
            socket,
            lines: Lines::default(),
            unread: Vec::new(),
        };
        let hello = ClientLine::Hello {
            pid: Some(std::process::id()),
        };
        // The reason of a station that closed the connection can still be read.
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

    /// Sends a line to the station.
    ///
    /// # Errors
    /// When the station is gone.
    pub fn send(&mut self, line: &ClientLine) -> Result<(), ShareClientError> {
        self.socket
            .write_all(&line.to_line())
            .map_err(|error| ShareClientError::Closed(self.address.clone(), format!(": {error}")))
    }

    /// The station's next line; other bytes, such as the raw bytes before its welcome, are skipped.
    ///
    /// # Errors
    /// When the station is gone or sends no line until the deadline.
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
            match self.socket.read(&mut buffer) {
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
                            format!(": {error}"),
                        ));
                    }
                },
            }
        }
    }
}

/// The socket, and the token to show first.
fn connect(address: &Address, deadline: Instant) -> io::Result<(Box<dyn Socket>, Option<String>)> {
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
                        let token = find_token(&stream);
                        return Ok((Box::new(stream), token));
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
            Ok((Box::new(stream), None))
        }
        #[cfg(not(unix))]
        Address::Unix(_) => Err(io::Error::new(
            io::ErrorKind::Unsupported,
            "this system has no Unix sockets here",
        )),
    }
}
