//! The address of a radio as given on the command line.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use super::BAUD;
use crate::share::Address;

/// The address of a radio.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LinkSpec {
    /// A serial device.
    Serial(PathBuf),
    /// A serial server or a sharing station: `HOST:PORT`.
    Tcp(String),
    /// A sharing station's Unix socket; any other Unix socket is receive-only.
    Unix(PathBuf),
    /// Standard input, receive only.
    Stdin,
    /// An embedded simulated robot.
    Sim,
}

impl LinkSpec {
    /// The port's rate for a serial device; `None` for other links.
    #[must_use]
    pub const fn baud(&self, asked: u32) -> Option<u32> {
        match self {
            Self::Serial(_) => Some(asked),
            _ => None,
        }
    }

    /// The rate at which bytes leave this program's end of the link: a serial device's, or that of a serial server on the network if
    /// `asked` says it; `None` if it is unknown.
    #[must_use]
    pub fn rate(&self, asked: Option<u32>) -> Option<u32> {
        match self {
            Self::Serial(_) => Some(asked.unwrap_or(BAUD)),
            Self::Tcp(_) => asked,
            Self::Unix(_) | Self::Stdin | Self::Sim => None,
        }
    }

    /// The address of the station at the other end, if it shares its link.
    #[must_use]
    pub fn station(&self) -> Option<Address> {
        match self {
            Self::Tcp(address) => Some(Address::Tcp(address.clone())),
            Self::Unix(path) => Some(Address::Unix(path.clone())),
            Self::Serial(_) | Self::Stdin | Self::Sim => None,
        }
    }
}

impl From<Address> for LinkSpec {
    fn from(address: Address) -> Self {
        match address {
            Address::Tcp(address) => Self::Tcp(address),
            Address::Unix(path) => Self::Unix(path),
        }
    }
}

impl FromStr for LinkSpec {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        if let Some(address) = text.strip_prefix("tcp:") {
            return if has_port(address) {
                Ok(Self::Tcp(address.to_owned()))
            } else {
                Err(format!(
                    "`{address}` is not HOST:PORT; try tcp:localhost:4000"
                ))
            };
        }
        if let Some(path) = text.strip_prefix("unix:").filter(|path| !path.is_empty()) {
            return Ok(Self::Unix(PathBuf::from(path)));
        }
        match text {
            "" | "unix:" => Err(
                "a link is a serial device, `tcp:HOST:PORT`, `unix:PATH`, `-` or `sim`".to_owned(),
            ),
            "-" => Ok(Self::Stdin),
            "sim" => Ok(Self::Sim),
            _ => Ok(Self::Serial(PathBuf::from(text))),
        }
    }
}

/// Whether a text is `HOST:PORT`.
#[must_use]
pub fn has_port(address: &str) -> bool {
    address
        .rsplit_once(':')
        .is_some_and(|(host, port)| !host.is_empty() && port.parse::<u16>().is_ok())
}

impl fmt::Display for LinkSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Serial(path) => write!(f, "{}", path.display()),
            Self::Tcp(address) => write!(f, "tcp:{address}"),
            Self::Unix(path) => write!(f, "unix:{}", path.display()),
            Self::Stdin => f.write_str("standard input"),
            Self::Sim => f.write_str("sim"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rate_is_known_for_a_device_or_if_it_is_said() {
        let of = |spec: &str, asked| spec.parse::<LinkSpec>().unwrap().rate(asked);
        assert_eq!(of("/dev/ttyUSB0", None), Some(2400));
        assert_eq!(of("/dev/ttyUSB0", Some(9600)), Some(9600));
        assert_eq!(of("tcp:robot:4000", None), None);
        assert_eq!(of("tcp:robot:4000", Some(9600)), Some(9600));
        assert_eq!(of("sim", Some(9600)), None);
    }

    #[test]
    fn each_form_of_address_is_recognized() {
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
        assert_eq!(
            "unix:/tmp/x.sock".parse(),
            Ok(LinkSpec::Unix("/tmp/x.sock".into()))
        );
        for wrong in [
            "",
            "unix:",
            "tcp:",
            "tcp:4000",
            "tcp::4000",
            "tcp:robot",
            "tcp:robot:70000",
        ] {
            assert!(wrong.parse::<LinkSpec>().is_err(), "{wrong}");
        }
    }
}
