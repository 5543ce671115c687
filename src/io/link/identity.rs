//! A USB adapter that is unplugged may come back under another name: it is known by what it says of
//! itself.

/// What tells a USB adapter from others.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UsbIdentity {
    /// Vendor and product number.
    pub product: (u16, u16),
    /// Serial number, if its maker gave it one.
    pub serial: Option<String>,
    /// Which port of an adapter that has several.
    pub interface: Option<u8>,
}

/// A port that is plugged in now.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plugged {
    /// Its name.
    pub name: String,
    /// What it says of itself, if it is on USB.
    pub usb: Option<UsbIdentity>,
}

/// Where a known adapter is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Whereabouts {
    /// Under this name.
    Here(String),
    /// Not plugged in.
    Absent,
    /// Not plugged in, and something else has its name.
    Replaced,
    /// These are alike, and none has the old name.
    Ambiguous(Vec<String>),
}

/// Looks for an adapter that was known as `name`.
pub(super) fn find(name: &str, known: &UsbIdentity, ports: &[Plugged]) -> Whereabouts {
    let at_name = ports.iter().find(|port| port.name == name);
    // A name whose device says nothing of itself is taken as it is, as it was by the operator.
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
    fn it_is_found_under_another_name() {
        let known = adapter(Some("A5"));
        let ports = [
            port("/dev/ttyS0", None),
            port("/dev/ttyUSB0", Some(adapter(Some("B7")))),
            port("/dev/ttyUSB1", Some(known.clone())),
        ];
        assert_eq!(
            find("/dev/ttyUSB0", &known, &ports),
            here("/dev/ttyUSB1"),
            "not the stranger that has its name"
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
    fn its_old_name_comes_before_its_twins() {
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
    fn another_port_of_the_same_adapter_is_not_it() {
        let known = adapter(Some("A5"));
        let second = UsbIdentity {
            interface: Some(1),
            ..known.clone()
        };
        let ports = [port("/dev/ttyUSB1", Some(second))];
        assert_eq!(find("/dev/ttyUSB0", &known, &ports), Whereabouts::Absent);
    }

    #[test]
    fn a_call_out_device_stays_one() {
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

    /// The system removes such a path with the device, and makes it anew a moment after it.
    #[test]
    fn it_is_found_when_it_was_given_by_a_stable_path() {
        let known = adapter(None);
        let ports = [port("/dev/ttyUSB1", Some(known.clone()))];
        let path = "/dev/serial/by-id/usb-1a86_USB2.0-Serial-if00-port0";
        assert_eq!(find(path, &known, &ports), here("/dev/ttyUSB1"));
    }

    #[test]
    fn a_device_that_says_nothing_of_itself_is_taken_by_its_name() {
        let ports = [port("/dev/ttyUSB0", None)];
        assert_eq!(
            find("/dev/ttyUSB0", &adapter(None), &ports),
            here("/dev/ttyUSB0")
        );
    }
}
