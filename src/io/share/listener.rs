//! Opens the socket that clients connect to.

use std::net::SocketAddr;
use std::time::Duration;

use super::ShareError;
use super::client::Stream;
use super::owner::Token;
#[cfg(unix)]
use super::socket_file::SocketFile;
use crate::share::Address;

/// Connections that wait to be accepted, unless the system allows fewer: strangers must not fill the queue while the station does other work.
const QUEUE: i32 = 4096;

/// Pause after the system refused a connection, such as for too many open files.
const REST: Duration = Duration::from_millis(200);

pub(super) struct Opened {
    pub(super) listener: Listener,
    /// The address for clients.
    pub(super) address: String,
    /// Token that clients of a port must send.
    pub(super) token: Option<Token>,
    #[cfg(unix)]
    pub(super) file: Option<SocketFile>,
}

pub(super) enum Listener {
    Tcp(tokio::net::TcpListener),
    #[cfg(unix)]
    Unix(tokio::net::UnixListener),
}

pub(super) fn open(address: &Address, open_to_network: bool) -> Result<Opened, ShareError> {
    match (address, address.to_listen_on(open_to_network)?) {
        (_, Some(socket)) => open_tcp(socket),
        #[cfg(unix)]
        (Address::Unix(path), None) => {
            let refused = |error| ShareError::Listen(address.to_string(), error);
            super::owner::make_folder_of(path).map_err(refused)?;
            let (file, listener) = SocketFile::bind(path)?;
            let listener = tokio::net::UnixListener::from_std(listener).map_err(refused)?;
            Ok(Opened {
                listener: Listener::Unix(listener),
                address: address.to_string(),
                token: None,
                file: Some(file),
            })
        }
        (_, None) => Err(ShareError::Taken(
            address.to_string(),
            "this system has no Unix sockets here; share on a port, such as 4001",
        )),
    }
}

fn open_tcp(socket: SocketAddr) -> Result<Opened, ShareError> {
    let refused = |error| ShareError::Listen(socket.to_string(), error);
    let listener = std::net::TcpListener::bind(socket).map_err(refused)?;
    listener.set_nonblocking(true).map_err(refused)?;
    socket2::SockRef::from(&listener)
        .listen(QUEUE)
        .map_err(refused)?;
    let address = listener.local_addr().map_err(refused)?;
    let token =
        Token::create(address).map_err(|error| ShareError::Token(address.to_string(), error))?;
    let listener = tokio::net::TcpListener::from_std(listener).map_err(refused)?;
    Ok(Opened {
        listener: Listener::Tcp(listener),
        address: address.to_string(),
        token: Some(token),
        #[cfg(unix)]
        file: None,
    })
}

impl Listener {
    /// Accepts the next connection; returns it with the client's name for display.
    pub(super) async fn accept(&self) -> (Box<dyn Stream>, String) {
        loop {
            match self {
                Self::Tcp(listener) => {
                    if let Ok((stream, peer)) = listener.accept().await {
                        // Statuses are small and urgent; without this option they arrive later.
                        let _ = stream.set_nodelay(true);
                        return (Box::new(stream), peer.to_string());
                    }
                }
                #[cfg(unix)]
                Self::Unix(listener) => {
                    if let Ok((stream, _)) = listener.accept().await {
                        let pid = stream.peer_cred().ok().and_then(|who| who.pid());
                        let who = pid.map_or("a program".to_owned(), |pid| format!("pid {pid}"));
                        return (Box::new(stream), who);
                    }
                }
            }
            tokio::time::sleep(REST).await;
        }
    }
}
