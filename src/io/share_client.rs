//! The share client: sends commands through a station that shares its link.

use std::io::{self, Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::time::{Duration, Instant};

use super::share::find_token;
use crate::share::{Address, ClientLine, Lines, StationLine, Welcome};

/// Timeout of the hello, which a station answers at once unless it is stopped or swapped out.
const HELLO_TIMEOUT: Duration = Duration::from_secs(5);

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
    /// Connects and says hello.
    ///
    /// # Errors
    /// When no station answers there.
    pub fn connect(address: &Address) -> Result<(Self, Welcome), ShareClientError> {
        let (mut socket, token) =
            connect(address).map_err(|error| ShareClientError::Connect(address.clone(), error))?;
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
        client.send(&ClientLine::Hello {
            pid: Some(std::process::id()),
        })?;
        let deadline = Instant::now() + HELLO_TIMEOUT;
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
                Err(ShareClientError::Silent(address) | ShareClientError::Closed(address, _)) => {
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
fn connect(address: &Address) -> io::Result<(Box<dyn Socket>, Option<String>)> {
    match address {
        Address::Tcp(address) => {
            let mut failure = io::Error::from(io::ErrorKind::AddrNotAvailable);
            for address in address.to_socket_addrs()? {
                match TcpStream::connect_timeout(&address, HELLO_TIMEOUT) {
                    Ok(stream) => {
                        stream.set_nodelay(true)?;
                        stream.set_read_timeout(Some(READ_TIMEOUT))?;
                        stream.set_write_timeout(Some(HELLO_TIMEOUT))?;
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
            let stream = std::os::unix::net::UnixStream::connect(path)?;
            stream.set_read_timeout(Some(READ_TIMEOUT))?;
            stream.set_write_timeout(Some(HELLO_TIMEOUT))?;
            Ok((Box::new(stream), None))
        }
        #[cfg(not(unix))]
        Address::Unix(_) => Err(io::Error::new(
            io::ErrorKind::Unsupported,
            "this system has no Unix sockets here",
        )),
    }
}
