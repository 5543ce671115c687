//! A TCP port shared by several clients.

use std::io::{ErrorKind, Read as _, Write as _};
use std::net::{TcpListener, TcpStream};
use std::time::Instant;

use super::error::ServeError;
use super::port::Port;

/// Maximum number of clients; more are refused.
const CLIENTS_MAX: usize = 8;

/// Maximum number of bytes per read from a client.
const READ_MAX: usize = 256;

/// A listener and its clients.
pub(super) struct Tcp {
    listener: TcpListener,
    clients: Vec<TcpStream>,
    copy_only: bool,
}

impl Tcp {
    /// Starts listening; returns the port and its actual address.
    pub(super) fn listen(address: &str, copy_only: bool) -> Result<(Self, String), ServeError> {
        let fail = |source| ServeError::Listen {
            address: address.to_owned(),
            source,
        };
        let listener = TcpListener::bind(address).map_err(fail)?;
        listener.set_nonblocking(true).map_err(fail)?;
        let bound = listener.local_addr().map_err(fail)?.to_string();
        Ok((
            Self {
                listener,
                clients: Vec::new(),
                copy_only,
            },
            bound,
        ))
    }

    fn accept(&mut self) {
        while let Ok((client, _)) = self.listener.accept() {
            let is_ready = client.set_nonblocking(true).is_ok() && client.set_nodelay(true).is_ok();
            if is_ready && self.clients.len() < CLIENTS_MAX {
                self.clients.push(client);
            }
        }
    }
}

impl Port for Tcp {
    fn write(&mut self, bytes: &[u8], _now: Instant) {
        self.accept();
        if bytes.is_empty() {
            return;
        }
        // A slow client loses the bytes that do not fit; a disconnected one is removed.
        self.clients.retain_mut(|client| match client.write(bytes) {
            Ok(_) => true,
            Err(error) => matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted),
        });
    }

    fn read(&mut self, into: &mut Vec<u8>) {
        let mut bytes = [0; READ_MAX];
        for client in &mut self.clients {
            // A client that has stopped sending may still receive: only writing detects a disconnect.
            if let Ok(count) = client.read(&mut bytes)
                && !self.copy_only
            {
                into.extend(bytes.get(..count).unwrap_or_default());
            }
        }
    }
}
