//! Reasons why a link cannot be opened, each with a hint.

use std::io;
use std::path::Path;

use crate::hint;
use crate::io::ports;
use crate::io::share_client::ShareClientError;

/// Reason why a link cannot be opened, with a hint.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// There is no device with this name.
    #[error(
        "cannot open {0}: there is no such device. `groundwave ports` lists what is plugged in"
    )]
    Missing(String),
    /// Another program uses the device.
    #[error(
        "cannot open {0}: it is busy, another program holds it. Close that program (`fuser {0}` names it on Linux) and try again; or, if it is a groundwave started with --share ADDR, send through it: `groundwave send --via ADDR ...`"
    )]
    Busy(String),
    /// There is no permission to open the device.
    #[error("cannot open {0}: permission denied. {hint}", hint = permission_hint())]
    Permission(String),
    /// The path is not a serial device.
    #[error(
        "cannot open {0}: it is not a serial device. `groundwave ports` lists those there are; a capture is shown with `groundwave replay {0}`"
    )]
    NotSerial(String),
    /// The path is a Unix socket, not a serial device.
    #[error("cannot open {0}: it is a Unix socket; did you mean unix:{0}?")]
    Socket(String),
    /// The other end of a TCP link does not answer.
    #[error("cannot connect to {0}: {reason}. Is the serial server running and the address right?", reason = hint::words(.1))]
    Tcp(String, io::Error),
    /// The station at a Unix socket does not answer.
    #[error("cannot connect to {0}: {reason}. Is a groundwave running with --share {0}?", reason = hint::words(.1))]
    Unix(String, io::Error),
    /// The station that shares its link does not welcome this program.
    #[error(transparent)]
    Share(#[from] ShareClientError),
    /// Another device has the name of the unplugged one.
    #[error("{0} is another USB device now; waiting for the one that was unplugged")]
    Another(String),
    /// Another terminal has the name of the one that has gone.
    #[error(
        "{0} is another terminal now, not the robot's; start again with the robot's terminal, or recreate the link to it"
    )]
    AnotherTerminal(String),
    /// Several devices look like the one that was unplugged.
    #[error(
        "{0} was unplugged and {1} look the same; plug it in at the same port, or start again with the right device"
    )]
    Ambiguous(String, String),
    /// Another error.
    #[error("cannot open {0}: {1}")]
    Other(String, String),
}

impl OpenError {
    /// Whether the link does not exist yet, and may appear.
    pub(super) const fn is_absence(&self) -> bool {
        matches!(self, Self::Missing(_) | Self::Tcp(..) | Self::Unix(..))
    }

    pub(super) fn serial(name: &str, error: &serialport::Error) -> Self {
        use serialport::ErrorKind as Kind;
        let name = name.to_owned();
        match error.kind {
            _ if is_socket(&name) => Self::Socket(name),
            Kind::Io(io::ErrorKind::PermissionDenied) => Self::Permission(name),
            // The library returns `NoDevice` for a missing and for a locked port.
            Kind::NoDevice if exists(&name) => Self::Busy(name),
            Kind::NoDevice | Kind::Io(io::ErrorKind::NotFound) => Self::Missing(name),
            Kind::Unknown
                if error.description.contains("ioctl")
                    || error.description.contains("typewriter") =>
            {
                Self::NotSerial(name)
            }
            _ if Path::new(&name).is_dir() => Self::NotSerial(name),
            _ => Self::Other(name, error.description.clone()),
        }
    }
}

#[cfg(unix)]
fn is_socket(name: &str) -> bool {
    use std::os::unix::fs::FileTypeExt as _;
    let found = std::fs::metadata(name);
    found.is_ok_and(|found| found.file_type().is_socket())
}

#[cfg(not(unix))]
fn is_socket(_: &str) -> bool {
    false
}

/// Whether a port exists: as a file on Unix, in the system's list elsewhere.
fn exists(name: &str) -> bool {
    if cfg!(unix) {
        return Path::new(name).exists();
    }
    ports::is_there(name)
}

const fn permission_hint() -> &'static str {
    if cfg!(target_os = "linux") {
        "Serial devices belong to a group, mostly `dialout` or `uucp` (`ls -l` shows which): `sudo usermod -aG dialout $USER`, then log in again"
    } else if cfg!(target_os = "macos") {
        "Use the device under /dev/cu.*, and check System Settings for a driver that waits for permission"
    } else if cfg!(windows) {
        "Use the port's name from `groundwave ports` (COM3), and check in the Device Manager that its driver is installed"
    } else {
        "Check who may use the device"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn no_device() -> serialport::Error {
        serialport::Error::new(serialport::ErrorKind::NoDevice, "Device or resource busy")
    }

    #[test]
    #[cfg(unix)]
    fn a_locked_port_is_busy_and_names_both_remedies() {
        let error = OpenError::serial("/dev/null", &no_device());
        let words = error.to_string();
        assert!(matches!(error, OpenError::Busy(_)), "{words}");
        assert!(
            words.contains("--via") && words.contains("--share"),
            "{words}"
        );
    }

    #[test]
    fn an_absent_port_is_missing() {
        let error = OpenError::serial("/dev/groundwave-no-such-device", &no_device());
        assert!(matches!(error, OpenError::Missing(_)), "{error}");
    }

    #[test]
    fn a_port_without_permission_names_a_hint() {
        let denied = serialport::ErrorKind::Io(io::ErrorKind::PermissionDenied);
        let error = OpenError::serial("/dev/ttyUSB0", &serialport::Error::new(denied, "denied"));
        let words = error.to_string();
        assert!(
            words.contains("permission denied") && words.contains(permission_hint()),
            "{words}"
        );
    }
}
