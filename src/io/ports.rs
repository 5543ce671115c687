//! Serial ports that are plugged in.

use serialport::{SerialPortInfo, SerialPortType};

use super::link::{Plugged, UsbIdentity};

/// A serial port and what is known of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Port {
    /// What to give to `watch`.
    pub name: String,
    /// What kind it is, for a person.
    pub kind: String,
    /// What the device says of itself, if it is on USB.
    pub description: Option<String>,
}

/// The ports of this machine, by name.
///
/// # Errors
/// When the system cannot list them.
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

/// The ports of this machine by what their adapters say of themselves; none where the system cannot
/// list them.
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

fn available() -> Result<Vec<SerialPortInfo>, String> {
    // On Linux the library panics where the kernel shows no such folder.
    if cfg!(target_os = "linux") && !std::path::Path::new("/sys/class/tty").is_dir() {
        return Ok(Vec::new());
    }
    serialport::available_ports().map_err(|error| format!("cannot list serial ports: {error}"))
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
