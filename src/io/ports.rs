//! The serial ports of this machine.

use std::io::ErrorKind;

use serialport::{SerialPortInfo, SerialPortType};

use super::usb::{Plugged, UsbIdentity};
use crate::hint;

/// A typical port name on this system, for messages and examples.
pub const EXAMPLE: &str = if cfg!(windows) {
    "COM3"
} else if cfg!(target_os = "macos") {
    "/dev/cu.usbserial-1"
} else {
    "/dev/ttyUSB0"
};

/// A serial port and its description.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Port {
    /// Name for `groundwave watch`.
    pub name: String,
    /// Kind of port, to show.
    pub kind: String,
    /// The USB device's description of itself.
    pub description: Option<String>,
}

/// The ports of this machine, sorted by name.
///
/// # Errors
/// If the system cannot list them.
pub fn list() -> Result<Vec<Port>, String> {
    let mut ports: Vec<Port> = available()?
        .into_iter()
        .map(|port| {
            let (kind, description) = describe(&port.port_type);
            Port {
                name: port.port_name,
                kind,
                description,
            }
        })
        .collect();
    ports.sort_by(|a, b| a.name.cmp(&b.name));
    ports.dedup();
    Ok(ports)
}

/// Whether a port of this name exists.
#[must_use]
pub fn is_there(name: &str) -> bool {
    list().is_ok_and(|ports| {
        ports
            .iter()
            .any(|port| port.name.eq_ignore_ascii_case(name))
    })
}

/// The ports of this machine with their USB identities; empty if the system cannot list them.
pub(super) fn plugged() -> Vec<Plugged> {
    available()
        .unwrap_or_default()
        .into_iter()
        .map(|port| Plugged {
            name: port.port_name,
            usb: match port.port_type {
                SerialPortType::UsbPort(usb) => Some(UsbIdentity {
                    product: (usb.vid, usb.pid),
                    serial: usb.serial_number,
                    interface: usb.interface,
                }),
                _ => None,
            },
        })
        .collect()
}

/// The port of a USB adapter, given as `VID:PID` or `VID:PID:SERIAL` in hexadecimal digits.
///
/// # Errors
/// If the identity is malformed, or no adapter or several adapters match.
pub fn find_usb(identity: &str) -> Result<String, String> {
    let ports = plugged();
    find_identity(identity, &ports)
}

fn find_identity(identity: &str, ports: &[Plugged]) -> Result<String, String> {
    let mut parts = identity.splitn(3, ':');
    let mut number = || u16::from_str_radix(parts.next()?, 16).ok();
    let (Some(vendor), Some(product)) = (number(), number()) else {
        return Err(format!(
            "`usb:{identity}` is not usb:VID:PID or usb:VID:PID:SERIAL; `groundwave ports` shows them"
        ));
    };
    let serial = parts.next();
    let is_it = |usb: &UsbIdentity| {
        usb.product == (vendor, product)
            && serial.is_none_or(|serial| usb.serial.as_deref() == Some(serial))
    };
    let found = ports
        .iter()
        .filter(|port| port.usb.as_ref().is_some_and(is_it));
    let names: Vec<&str> = found.map(|port| port.name.as_str()).collect();
    match names[..] {
        [only] => Ok(only.to_owned()),
        [] => Err(format!(
            "no adapter usb:{identity} is plugged in; `groundwave ports` lists those that are"
        )),
        _ => Err(format!(
            "several adapters are usb:{identity}: {}; add :SERIAL, or name the port",
            names.join(", ")
        )),
    }
}

fn available() -> Result<Vec<SerialPortInfo>, String> {
    // On Linux the library panics when it cannot read this folder.
    if cfg!(target_os = "linux")
        && let Err(error) = std::fs::read_dir("/sys/class/tty")
    {
        return match error.kind() {
            ErrorKind::NotFound => Ok(Vec::new()),
            _ => Err(format!("cannot list serial ports: {}", hint::words(&error))),
        };
    }
    let mut ports = serialport::available_ports().map_err(|error| {
        format!(
            "cannot list serial ports: {}",
            hint::plain(&error.to_string())
        )
    })?;
    if cfg!(target_os = "macos") {
        // Opening a port by its other name, /dev/tty.*, waits for a carrier.
        ports.retain(|port| !port.port_name.starts_with("/dev/tty."));
    }
    Ok(ports)
}

fn describe(kind: &SerialPortType) -> (String, Option<String>) {
    match kind {
        SerialPortType::UsbPort(usb) => {
            let words: Vec<&str> = [&usb.manufacturer, &usb.product, &usb.serial_number]
                .into_iter()
                .flatten()
                .map(String::as_str)
                .collect();
            let kind = format!("USB {:04x}:{:04x}", usb.vid, usb.pid);
            (kind, (!words.is_empty()).then(|| words.join(" ")))
        }
        SerialPortType::PciPort => ("PCI".to_owned(), None),
        SerialPortType::BluetoothPort => ("Bluetooth".to_owned(), None),
        SerialPortType::Unknown => ("serial".to_owned(), None),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_adapter_is_found_by_its_usb_identity() {
        let port = |name: &str, serial: Option<&str>| Plugged {
            name: name.to_owned(),
            usb: Some(UsbIdentity {
                product: (0x0403, 0x6001),
                serial: serial.map(str::to_owned),
                interface: None,
            }),
        };
        let ports = [port("/dev/ttyUSB0", Some("A5")), port("/dev/ttyUSB1", None)];
        let find = |identity| find_identity(identity, &ports);
        assert_eq!(find("0403:6001:A5"), Ok("/dev/ttyUSB0".to_owned()));
        assert_eq!(
            find_identity("0403:6001", &ports[1..]),
            Ok("/dev/ttyUSB1".to_owned())
        );
        for (identity, expected) in [
            (
                "0403:6001",
                "several adapters are usb:0403:6001: /dev/ttyUSB0, /dev/ttyUSB1",
            ),
            ("0403:6001:B7", "no adapter usb:0403:6001:B7"),
            ("1a86:7523", "no adapter"),
            ("0403", "is not usb:VID:PID"),
            ("ftdi:6001", "is not usb:VID:PID"),
        ] {
            let error = find(identity).expect_err(identity);
            assert!(error.contains(expected), "{error}");
        }
    }
}
