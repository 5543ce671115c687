//! `groundwave` alone: what can be done next on this machine.

use std::fmt::Write as _;
use std::fs;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use super::{Fault, config};
use crate::io::ports::{Port, list};

/// Ports that are shown; a machine may have dozens that nobody plugged in.
const PORTS_MAX: usize = 4;

pub(super) fn run(named: Option<&Path>) -> Result<(), Fault> {
    let config = config::load(named)?;
    let profiles = config.robots.keys().chain(config.links.keys());
    let text = text(
        &profiles.map(String::as_str).collect::<Vec<_>>(),
        &list().unwrap_or_default(),
        newest_capture().as_deref(),
    );
    let mut out = io::stdout().lock();
    out.write_all(text.as_bytes())
        .and_then(|()| out.flush())
        .or_else(|error| Fault::output(&error))
}

fn text(profiles: &[&str], ports: &[Port], capture: Option<&Path>) -> String {
    let mut text =
        String::from("Groundwave: a ground station for a small robot. What can be done next:\n\n");
    let mut offer = |what: &str, command: &str| {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "  {command:<44}  {what}");
    };
    for name in profiles {
        offer("as it is configured", &format!("groundwave watch {name}"));
    }
    // What was plugged in comes first; a machine's own ports are rarely a radio.
    let (usb, others): (Vec<_>, Vec<_>) =
        ports.iter().partition(|port| port.kind.starts_with("USB"));
    let shown = if usb.is_empty() { others } else { usb };
    for port in shown.iter().take(PORTS_MAX) {
        let what = port.description.as_deref().unwrap_or(&port.kind);
        offer(what, &format!("groundwave watch {}", port.name));
    }
    if ports.is_empty() {
        offer("no serial port is plugged in now", "groundwave ports");
    }
    if let Some(path) = capture {
        offer(
            "the newest capture here",
            &format!("groundwave replay {}", path.display()),
        );
    }
    offer("a simulated robot prowls a house", "groundwave demo");
    offer("everything else", "groundwave --help");
    text
}

/// The capture in this folder that was written last.
fn newest_capture() -> Option<PathBuf> {
    let captures = fs::read_dir(".").ok()?.filter_map(|entry| {
        let path = PathBuf::from(entry.ok()?.file_name());
        let is_capture = path.extension()?.eq_ignore_ascii_case("mcap");
        let written = fs::metadata(&path).and_then(|file| file.modified());
        is_capture.then(|| (written.unwrap_or(SystemTime::UNIX_EPOCH), path))
    });
    captures.max().map(|(_, path)| path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_there_is_offered() {
        let port = |name: &str, kind: &str| Port {
            name: name.to_owned(),
            kind: kind.to_owned(),
            description: None,
        };
        let bare = text(&[], &[], None);
        assert!(
            bare.contains("groundwave demo") && bare.contains("no serial port"),
            "{bare}"
        );
        let ports = [
            port("/dev/ttyS0", "serial"),
            port("/dev/ttyUSB0", "USB 0403:6001"),
        ];
        let all = text(&["marvin"], &ports, Some(Path::new("evening.mcap")));
        for command in [
            "watch marvin",
            "watch /dev/ttyUSB0",
            "replay evening.mcap",
            "demo",
        ] {
            assert!(
                all.contains(&format!("groundwave {command} ")),
                "{command}\n{all}"
            );
        }
        assert!(!all.contains("ttyS0"), "{all}");
        assert!(text(&[], &ports[..1], None).contains("watch /dev/ttyS0"));
    }
}
