//! Finds a USB adapter again, whose name may have changed after it was unplugged.

/// Identity of a USB adapter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UsbIdentity {
    /// Vendor and product number.
    pub product: (u16, u16),
    /// Serial number, if the adapter has one.
    pub serial: Option<String>,
    /// Number of the port on an adapter with several.
    pub interface: Option<u8>,
}

/// A plugged-in port.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plugged {
    /// Name of the port.
    pub name: String,
    /// Identity of a USB port.
    pub usb: Option<UsbIdentity>,
}

/// Location of a known adapter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Whereabouts {
    /// The adapter has this name.
    Here(String),
    /// The adapter is not plugged in.
    Absent,
    /// The adapter is not plugged in, and another device has its name.
    Replaced,
    /// Several adapters match, but none has the old name.
    Ambiguous(Vec<String>),
}

/// Finds an adapter formerly called `name`.
pub(super) fn find(name: &str, known: &UsbIdentity, ports: &[Plugged]) -> Whereabouts {
    let at_name = ports.iter().find(|port| port.name == name);
    // A device without an identity is known by its name alone.
    if at_name.is_some_and(|port| port.usb.as_ref().is_none_or(|usb| usb == known)) {
        return Whereabouts::Here(name.to_owned());
    }
    let mut alike = ports
        .iter()
        .filter(|port| port.usb.as_ref() == Some(known) && family(&port.name) == family(name))
        .map(|port| port.name.clone());
    match (alike.next(), alike.next()) {
        (Some(only), None) => Whereabouts::Here(only),
        (Some(first), Some(second)) => {
            Whereabouts::Ambiguous([first, second].into_iter().chain(alike).collect())
        }
        (None, _) if at_name.is_some() => Whereabouts::Replaced,
        (None, _) => Whereabouts::Absent,
    }
}

/// macOS gives each adapter two names, `/dev/cu.X` and `/dev/tty.X`, which behave differently.
fn family(name: &str) -> Option<&'static str> {
    ["/dev/cu.", "/dev/tty."]
        .into_iter()
        .find(|family| name.starts_with(family))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn adapter(serial: Option<&str>) -> UsbIdentity {
        UsbIdentity {
            product: (0x1a86, 0x7523),
            serial: serial.map(str::to_owned),
            interface: Some(0),
        }
    }

    fn port(name: &str, usb: Option<UsbIdentity>) -> Plugged {
        Plugged {
            name: name.to_owned(),
            usb,
        }
    }

    fn here(name: &str) -> Whereabouts {
        Whereabouts::Here(name.to_owned())
    }

    #[test]
    fn an_adapter_is_found_under_another_name() {
        let known = adapter(Some("A5"));
        let ports = [
            port("/dev/ttyS0", None),
            port("/dev/ttyUSB0", Some(adapter(Some("B7")))),
            port("/dev/ttyUSB1", Some(known.clone())),
        ];
        assert_eq!(
            find("/dev/ttyUSB0", &known, &ports),
            here("/dev/ttyUSB1"),
            "another adapter has its name"
        );
        assert_eq!(
            find("/dev/ttyUSB0", &known, &ports[..2]),
            Whereabouts::Replaced
        );
        assert_eq!(
            find("/dev/ttyUSB0", &known, &ports[..1]),
            Whereabouts::Absent
        );
    }

    #[test]
    fn of_twins_the_one_with_the_old_name_is_found() {
        let known = adapter(None);
        let twins = [
            port("/dev/ttyUSB1", Some(known.clone())),
            port("/dev/ttyUSB2", Some(known.clone())),
        ];
        assert_eq!(find("/dev/ttyUSB2", &known, &twins), here("/dev/ttyUSB2"));
        assert_eq!(
            find("/dev/ttyUSB0", &known, &twins),
            Whereabouts::Ambiguous(vec!["/dev/ttyUSB1".into(), "/dev/ttyUSB2".into()])
        );
    }

    #[test]
    fn another_port_of_the_same_adapter_is_ignored() {
        let known = adapter(Some("A5"));
        let second = UsbIdentity {
            interface: Some(1),
            ..known.clone()
        };
        let ports = [port("/dev/ttyUSB1", Some(second))];
        assert_eq!(find("/dev/ttyUSB0", &known, &ports), Whereabouts::Absent);
    }

    #[test]
    fn a_call_out_device_is_found_as_a_call_out_device() {
        let known = adapter(None);
        let ports = [
            port("/dev/cu.usbserial-20", Some(known.clone())),
            port("/dev/tty.usbserial-20", Some(known.clone())),
        ];
        assert_eq!(
            find("/dev/cu.usbserial-10", &known, &ports),
            here("/dev/cu.usbserial-20")
        );
    }

    /// The system creates such a path shortly after the device.
    #[test]
    fn an_adapter_given_by_a_stable_path_is_found() {
        let known = adapter(None);
        let ports = [port("/dev/ttyUSB1", Some(known.clone()))];
        let path = "/dev/serial/by-id/usb-1a86_USB2.0-Serial-if00-port0";
        assert_eq!(find(path, &known, &ports), here("/dev/ttyUSB1"));
    }

    #[test]
    fn a_device_without_an_identity_is_found_by_its_name() {
        let ports = [port("/dev/ttyUSB0", None)];
        assert_eq!(
            find("/dev/ttyUSB0", &adapter(None), &ports),
            here("/dev/ttyUSB0")
        );
    }
}
