//! Restricts a share to its owner: the default socket, and the token of a port.
//!
//! Every user of a machine can connect to its ports. A client of a port therefore first sends the token from a file
//! that only the owner can read.

use std::env;
use std::fmt::{self, Write as _};
use std::fs::{self, DirBuilder, OpenOptions};
use std::io::{self, Read as _, Write as _};
use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpStream};
use std::path::{Path, PathBuf};
use std::time::Duration;

use etcetera::BaseStrategy as _;

use crate::io::files;
#[cfg(unix)]
use crate::io::unix_socket;
use crate::share::Address;

/// Environment variable with the token, for other users and other machines.
const TOKEN_VARIABLE: &str = "GROUNDWAVE_TOKEN";

/// Number of random bytes of a token.
const TOKEN_BYTES: usize = 32;

/// Maximum length of a token's file, bytes.
const TOKEN_FILE_MAX: u64 = 256;

/// Time for a station to take a connection that only shows that it is there.
const PROBE_TIMEOUT: Duration = Duration::from_millis(100);

/// Default address of `--share` and `--via`: a socket, or a local port if the system has no Unix sockets. `None`
/// if the system has no home folder.
#[must_use]
pub fn usual_address() -> Option<Address> {
    if cfg!(unix) {
        Some(Address::Unix(folder()?.join("station.sock")))
    } else {
        Some(Address::Tcp("127.0.0.1:4001".to_owned()))
    }
}

/// The address of `--via` without one: the default address, or the port of the only station that listens on a port instead.
///
/// # Errors
/// If several stations listen on ports; the operator must choose.
pub fn find_station() -> Result<Option<Address>, SeveralStations> {
    let (Some(usual), Some(folder)) = (usual_address(), folder()) else {
        return Ok(None);
    };
    Ok(Some(find_port(&usual, &folder)?.unwrap_or(usual)))
}

/// Several stations share their links, each on a port.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("several stations share their links; choose one: {}", .0.iter().map(|address| format!("--via {address}")).collect::<Vec<_>>().join(" or "))]
pub struct SeveralStations(Vec<SocketAddr>);

/// The port of the only station that listens on one, if nothing listens at the usual address.
fn find_port(usual: &Address, folder: &Path) -> Result<Option<Address>, SeveralStations> {
    let mut ports: Vec<SocketAddr> = fs::read_dir(folder)
        .into_iter()
        .flatten()
        .filter_map(|entry| address_of_token(entry.ok()?.file_name().to_str()?))
        .collect();
    // A killed station leaves its token.
    ports.retain(|port| TcpStream::connect_timeout(port, PROBE_TIMEOUT).is_ok());
    ports.sort_unstable();
    if ports.is_empty() || listens(usual) {
        return Ok(None);
    }
    match ports[..] {
        [port] => Ok(Some(Address::Tcp(port.to_string()))),
        _ => Err(SeveralStations(ports)),
    }
}

/// Whether a station listens at an address. The usual port of a system without Unix sockets is among the ports with a token.
fn listens(address: &Address) -> bool {
    match address {
        #[cfg(unix)]
        Address::Unix(path) => unix_socket::connect(path, PROBE_TIMEOUT).is_ok(),
        _ => false,
    }
}

/// The token for the peer of a connection: from the environment, or the file of a station on this machine.
#[must_use]
pub fn find_token(stream: &TcpStream) -> Option<String> {
    if let Ok(token) = env::var(TOKEN_VARIABLE) {
        return Some(token.trim().to_owned());
    }
    let (own, peer) = (stream.local_addr().ok()?, stream.peer_addr().ok()?);
    // Another machine must not get the token of a station on this machine.
    if own.ip() != peer.ip() && !peer.ip().is_loopback() {
        return None;
    }
    let of_all = SocketAddr::new(IpAddr::V4(Ipv4Addr::UNSPECIFIED), peer.port());
    let tokens = [peer, of_all].into_iter().filter_map(token_path);
    let token = tokens.map(|path| read_token(&path)).find_map(Result::ok)?;
    Some(token.trim().to_owned())
}

/// Creates the folder of the default socket, if the path is in it.
#[cfg(unix)]
pub(super) fn make_folder_of(path: &Path) -> io::Result<()> {
    match folder() {
        Some(folder) if path.parent() == Some(&*folder) => make_private(&folder),
        _ => Ok(()),
    }
}

/// The token of a share on a port; dropping it removes its file.
pub(super) struct Token {
    text: String,
    path: PathBuf,
}

impl Token {
    /// Creates a token in a file named by the address; replaces a leftover file.
    pub(super) fn create(address: SocketAddr) -> io::Result<Self> {
        let path = token_path(address).ok_or(io::ErrorKind::NotFound)?;
        if let Some(folder) = path.parent() {
            make_private(folder)?;
        }
        let mut bytes = [0; TOKEN_BYTES];
        getrandom::fill(&mut bytes)?;
        let mut text = String::new();
        for byte in bytes {
            // Writing to a string does not fail.
            let _ = write!(text, "{byte:02x}");
        }
        let token = Self { text, path };
        token.keep()?;
        Ok(token)
    }

    fn keep(&self) -> io::Result<()> {
        let new = files::beside(&self.path);
        // A leftover of a killed process with the same number.
        let _ = fs::remove_file(&new);
        let mut options = OpenOptions::new();
        options.write(true).create_new(true);
        #[cfg(unix)]
        std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
        writeln!(options.open(&new)?, "{}", self.text)?;
        fs::rename(&new, &self.path)
    }

    /// Whether a client's first line is the token; takes constant time for lines of the token's length.
    pub(super) fn is(&self, line: &[u8]) -> bool {
        let line = line.trim_ascii_end();
        let pairs = line.iter().zip(self.text.as_bytes());
        let difference = pairs.fold(0, |all, (shown, own)| all | (shown ^ own));
        line.len() == self.text.len() && difference == 0
    }

    /// The instruction for clients without the token.
    pub(super) fn how_to_show(&self) -> String {
        format!(
            "this share wants its token as the first line. Programs of its owner find it in {}; elsewhere set \
             {TOKEN_VARIABLE} to what that file holds",
            self.path.display()
        )
    }
}

impl Drop for Token {
    fn drop(&mut self) {
        let is_own = fs::read(&self.path).is_ok_and(|kept| self.is(&kept));
        if is_own {
            // A file that cannot be removed is useless without the station.
            let _ = fs::remove_file(&self.path);
        }
    }
}

impl fmt::Debug for Token {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Token")
            .field("path", &self.path)
            .finish_non_exhaustive()
    }
}

/// The folder for files of running stations.
fn folder() -> Option<PathBuf> {
    let strategy = etcetera::choose_base_strategy().ok()?;
    let runtime = strategy.runtime_dir().or_else(|| strategy.state_dir());
    Some(
        runtime
            .unwrap_or_else(|| strategy.cache_dir())
            .join("groundwave"),
    )
}

/// The file of a token. Stations on different addresses may have the same port; that of the usual address has the short name.
fn token_path(address: SocketAddr) -> Option<PathBuf> {
    let (ip, port) = (address.ip(), address.port());
    let is_usual = ip.is_unspecified() || ip == IpAddr::V4(Ipv4Addr::LOCALHOST);
    let name = if is_usual {
        format!("{port}.token")
    } else {
        // No file on Windows has a colon in its name.
        format!("{}-{port}.token", ip.to_string().replace(':', "_"))
    };
    Some(folder()?.join(name))
}

/// The address whose token has a file of this name.
fn address_of_token(name: &str) -> Option<SocketAddr> {
    let stem = name.strip_suffix(".token")?;
    let (ip, port) = match stem.rsplit_once('-') {
        Some((ip, port)) => (ip.replace('_', ":").parse().ok()?, port),
        None => (IpAddr::V4(Ipv4Addr::LOCALHOST), stem),
    };
    Some(SocketAddr::new(ip, port.parse().ok()?))
}

fn make_private(folder: &Path) -> io::Result<()> {
    let mut builder = DirBuilder::new();
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    builder.recursive(true).create(folder)?;
    #[cfg(unix)]
    {
        use std::os::unix::fs::{MetadataExt as _, PermissionsExt as _};
        let found = fs::symlink_metadata(folder)?;
        if !found.is_dir() || found.uid() != rustix::process::geteuid().as_raw() {
            let name = folder.display();
            return Err(io::Error::other(format!(
                "{name} is a link or belongs to another user; remove it"
            )));
        }
        if found.mode() & 0o077 != 0 {
            fs::set_permissions(folder, fs::Permissions::from_mode(0o700))?;
        }
    }
    Ok(())
}

/// Reads a token's file. Refuses links, pipes and longer files, which may belong to another user.
fn read_token(path: &Path) -> io::Result<String> {
    let mut options = OpenOptions::new();
    options.read(true);
    #[cfg(unix)]
    {
        use rustix::fs::OFlags;
        let flags = (OFlags::NOFOLLOW | OFlags::NONBLOCK).bits() as i32;
        std::os::unix::fs::OpenOptionsExt::custom_flags(&mut options, flags);
    }
    let file = options.open(path)?;
    if !file.metadata()?.is_file() {
        return Err(io::ErrorKind::InvalidInput.into());
    }
    let mut token = String::new();
    file.take(TOKEN_FILE_MAX).read_to_string(&mut token)?;
    Ok(token)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn token(path: PathBuf) -> Token {
        let text = "0123456789abcdef".repeat(4);
        let token = Token { text, path };
        token.keep().expect("a file");
        token
    }

    #[test]
    fn only_the_whole_token_is_taken() {
        let folder = tempfile::tempdir().expect("a folder");
        let token = token(folder.path().join("4001.token"));
        let text = token.text.clone();
        assert!(token.is(text.as_bytes()));
        assert!(token.is(format!("{text}\r").as_bytes()));
        for wrong in ["", &text[1..], &text.replace('f', "e"), &text.repeat(2)] {
            assert!(!token.is(wrong.as_bytes()), "{wrong}");
        }
        assert!(!format!("{token:?}").contains(&text));
    }

    #[test]
    fn the_only_station_on_a_port_is_found() {
        use std::net::TcpListener;
        let folder = tempfile::tempdir().expect("a folder");
        let folder = folder.path();
        let usual = Address::Unix(folder.join("station.sock"));
        let find = || find_port(&usual, folder);
        assert_eq!(find(), Ok(None), "no station");
        let station = || {
            let listener = TcpListener::bind(("127.0.0.1", 0)).expect("a port");
            let address = listener.local_addr().expect("an address");
            let name = token_path(address).expect("a home folder");
            let token = token(folder.join(name.file_name().expect("a name")));
            (listener, token, address)
        };
        let (first, leftover, _) = station();
        drop(leftover);
        assert_eq!(find(), Ok(None), "a port without a token is no station");
        let (second, of_second, port) = station();
        assert_eq!(find(), Ok(Some(Address::Tcp(port.to_string()))));
        drop(first);
        let (third, of_third, other) = station();
        let mut both = vec![port, other];
        both.sort_unstable();
        let several = find().expect_err("two stations");
        assert_eq!(several, SeveralStations(both));
        assert!(several.to_string().contains(&format!("--via {other}")));
        drop(second);
        let found = find().expect("the killed station does not count");
        assert_eq!(found, Some(Address::Tcp(other.to_string())));
        #[cfg(unix)]
        {
            let path = folder.join("station.sock");
            let _own = std::os::unix::net::UnixListener::bind(path).expect("a socket");
            assert_eq!(find(), Ok(None), "the default socket comes first");
        }
        drop((third, of_second, of_third));
    }

    #[test]
    fn the_address_of_a_token_is_in_its_name() {
        for text in [
            "127.0.0.1:4001",
            "192.168.1.7:80",
            "[::1]:4001",
            "[fe80::1]:9",
        ] {
            let address: SocketAddr = text.parse().expect("an address");
            let path = token_path(address).expect("a home folder");
            let name = path.file_name().and_then(|name| name.to_str());
            assert_eq!(name.and_then(address_of_token), Some(address));
        }
        for other in ["station.sock", "x.token", "-.token", ".token"] {
            assert_eq!(address_of_token(other), None, "{other}");
        }
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn foreign_folders_and_pipes_are_not_trusted() {
        use std::os::unix::fs::{PermissionsExt as _, symlink};
        let folder = tempfile::tempdir().expect("a folder");
        let own = folder.path().join("own");
        fs::create_dir(&own).expect("a folder");
        fs::set_permissions(&own, fs::Permissions::from_mode(0o777)).expect("open to all");
        make_private(&own).expect("it becomes private");
        let mode = fs::metadata(&own).expect("it exists").permissions().mode();
        assert_eq!(mode & 0o777, 0o700);
        let link = folder.path().join("link");
        symlink(&own, &link).expect("a link");
        make_private(&link).expect_err("links are not followed");
        let pipe = own.join("4001.token");
        let mode = rustix::fs::Mode::RWXU;
        let kind = rustix::fs::FileType::Fifo;
        rustix::fs::mknodat(rustix::fs::CWD, &pipe, kind, mode, 0).expect("a pipe");
        read_token(&pipe).expect_err("a pipe is not waited for");
    }

    #[test]
    fn its_file_is_private_and_goes_with_it() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("4001.token");
        fs::write(&path, "of a station that was killed").expect("a file");
        let kept = token(path.clone());
        let text = fs::read_to_string(&path).expect("a token");
        assert_eq!(text.trim(), kept.text);
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            let mode = fs::metadata(&path).expect("it exists").permissions().mode();
            assert_eq!(mode & 0o777, 0o600);
        }
        drop(kept);
        assert!(!path.exists());
        let kept = token(path.clone());
        fs::write(&path, "of another station").expect("a file");
        drop(kept);
        assert!(path.exists(), "only its own file is removed");
    }
}
