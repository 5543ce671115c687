//! Addresses of shared links: a port of this machine or a Unix socket.

use std::fmt;
use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// The address at which a station shares its link.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Address {
    /// A TCP port: `HOST:PORT`.
    Tcp(String),
    /// A Unix socket.
    Unix(PathBuf),
}

/// Reason why a station must not listen on an address.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Exposed {
    /// The address can be reached from other machines.
    #[error(
        "{0} can be reached from other machines, and nothing there is encrypted. Share on 127.0.0.1 or a Unix socket, or add --share-open-to-network if that is what you want"
    )]
    Network(SocketAddr),
    /// The address is a name, which may stand for any machine.
    #[error("cannot share on `{0}`: give an IP address of this machine, such as 127.0.0.1:4001")]
    Name(String),
}

impl Address {
    /// The socket address to listen on, unless it is open to a network and must not be; `None` for a
    /// Unix socket.
    ///
    /// # Errors
    /// If the address is open to a network, or when that is unknown.
    pub fn to_listen_on(&self, open_to_network: bool) -> Result<Option<SocketAddr>, Exposed> {
        let Self::Tcp(text) = self else {
            return Ok(None);
        };
        let local = text.strip_prefix("localhost:").map(|port| {
            let port = port.parse().unwrap_or_default();
            SocketAddr::from((Ipv4Addr::LOCALHOST, port))
        });
        let address = match local {
            Some(local) => local,
            None => text.parse().map_err(|_| Exposed::Name(text.clone()))?,
        };
        if open_to_network || is_local(address.ip()) {
            Ok(Some(address))
        } else {
            Err(Exposed::Network(address))
        }
    }
}

fn is_local(ip: IpAddr) -> bool {
    ip.to_canonical().is_loopback()
}

impl FromStr for Address {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let (path, is_named) = match text.strip_prefix("unix:") {
            Some(path) => (path, true),
            None => (text, false),
        };
        let is_socket = Path::new(path)
            .extension()
            .is_some_and(|extension| extension == "sock");
        let is_file = path.contains('/') || is_socket && !path.starts_with("tcp:");
        if is_named || is_file {
            if path.is_empty() {
                return Err("unix: needs a path".to_owned());
            }
            return Ok(Self::Unix(PathBuf::from(path)));
        }
        let address = text.strip_prefix("tcp:").unwrap_or(text);
        if address.parse::<u16>().is_ok() {
            return Ok(Self::Tcp(format!("127.0.0.1:{address}")));
        }
        match address.rsplit_once(':') {
            Some((host, port)) if !host.is_empty() && port.parse::<u16>().is_ok() => {
                Ok(Self::Tcp(address.to_owned()))
            }
            _ => Err(format!(
                "`{text}` is neither a port (4001), HOST:PORT nor a Unix socket (station.sock, or a path with a `/`)"
            )),
        }
    }
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Tcp(address) => f.write_str(address),
            Self::Unix(path) => write!(f, "{}", path.display()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tcp(text: &str) -> Address {
        Address::Tcp(text.to_owned())
    }

    #[test]
    fn ports_addresses_and_paths_are_distinguished() {
        assert_eq!("4001".parse(), Ok(tcp("127.0.0.1:4001")));
        assert_eq!("0.0.0.0:4001".parse(), Ok(tcp("0.0.0.0:4001")));
        assert_eq!("tcp:[::1]:4001".parse(), Ok(tcp("[::1]:4001")));
        assert_eq!("desk.local:4001".parse(), Ok(tcp("desk.local:4001")));
        assert_eq!(
            "/tmp/x.sock".parse(),
            Ok(Address::Unix("/tmp/x.sock".into()))
        );
        assert_eq!("unix:x.sock".parse(), Ok(Address::Unix("x.sock".into())));
        assert_eq!("x.sock".parse(), Ok(Address::Unix("x.sock".into())));
        assert_eq!("x.sock:4001".parse(), Ok(tcp("x.sock:4001")));
        for wrong in [
            "",
            "x.socket",
            "tcp:x.sock",
            "70000",
            ":4001",
            "unix:",
            "host:port",
        ] {
            assert!(wrong.parse::<Address>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_port_alone_is_of_this_machine() {
        for local in [
            "127.0.0.1:1",
            "[::1]:1",
            "localhost:1",
            "[::ffff:127.0.0.1]:1",
        ] {
            assert!(
                matches!(tcp(local).to_listen_on(false), Ok(Some(_))),
                "{local}"
            );
        }
        for open in ["0.0.0.0:1", "[::]:1", "192.168.1.5:1"] {
            assert!(
                matches!(tcp(open).to_listen_on(false), Err(Exposed::Network(_))),
                "{open}"
            );
            assert!(
                matches!(tcp(open).to_listen_on(true), Ok(Some(_))),
                "{open}"
            );
        }
        assert!(matches!(
            tcp("desk:1").to_listen_on(true),
            Err(Exposed::Name(_))
        ));
        assert_eq!(Address::Unix("/x".into()).to_listen_on(false), Ok(None));
    }
}
