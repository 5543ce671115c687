//! `groundwave` without a command: suggests what to run on this machine.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use super::{Fault, config};
use crate::capture::interrupted::find_interrupted;
use crate::capture::runs::folder;
use crate::hint::shell_word;
use crate::io::ports::{Port, list};

/// Maximum number of ports shown; a machine may have dozens of built-in ports.
const PORTS_MAX: usize = 4;

pub(super) fn run(named: Option<&Path>) -> Result<(), Fault> {
    let config = config::load(named)?;
    let profiles = config.robots.keys().chain(config.links.keys());
    let lines = lines(
        &profiles.map(String::as_str).collect::<Vec<_>>(),
        &list().unwrap_or_default(),
        &Captures::here(),
    );
    lines.iter().try_for_each(super::show_line)
}

fn lines(profiles: &[&str], ports: &[Port], captures: &Captures) -> Vec<String> {
    let mut offers: Vec<(String, &str)> = Vec::new();
    let mut offer = |what, command: &str| offers.push((format!("groundwave {command}"), what));
    offer("simulate a robot in a house", "demo");
    for name in profiles {
        offer("from the configuration", &format!("watch {name}"));
    }
    // Built-in ports are rarely connected to a radio, and often do not exist on a PC.
    let rank = |port: &Port| match () {
        () if port.kind.starts_with("USB") => 0,
        () if !port.name.starts_with("/dev/ttyS") => 1,
        () => 2,
    };
    let best = ports.iter().map(rank).min();
    let shown = ports.iter().filter(|port| Some(rank(port)) == best);
    for port in shown.take(PORTS_MAX) {
        let what = match (&port.description, port.kind.as_str()) {
            (Some(description), _) => description,
            (None, "serial") => "a built-in serial port",
            (None, kind) => kind,
        };
        offer(what, &format!("watch {}", port.name));
    }
    if ports.is_empty() {
        offer("list serial ports; none found yet", "ports");
    }
    if let Some(path) = &captures.newest {
        offer(
            "play the newest capture here",
            &format!("replay {}", shell_word(path)),
        );
    }
    if let Some(path) = &captures.interrupted {
        let command = format!("recover {}", shell_word(path));
        offer("finish an interrupted recording", &command);
    }
    offer("list all commands", "--help");
    let width = offers
        .iter()
        .map(|(command, _)| command.chars().count())
        .max();
    let width = width.unwrap_or_default();
    let heading = [
        "Groundwave, a ground station for a small robot. Try one of these:".to_owned(),
        String::new(),
    ];
    let offers = offers.into_iter();
    let rows = offers.map(|(command, what)| format!("  {command:width$}  {what}"));
    heading.into_iter().chain(rows).collect()
}

/// Captures in the current folder.
#[derive(Debug, Default)]
struct Captures {
    /// The newest finished capture.
    newest: Option<PathBuf>,
    /// The newest interrupted recording.
    interrupted: Option<PathBuf>,
}

impl Captures {
    fn here() -> Self {
        Self {
            newest: newest(),
            interrupted: interrupted(),
        }
    }
}

fn newest() -> Option<PathBuf> {
    let captures = folder::captures(Path::new(".")).ok()?;
    let has_some = |path: &PathBuf| fs::metadata(path).is_ok_and(|file| file.len() > 0);
    let captures = captures.into_iter().filter(has_some);
    captures.max_by_key(|path| written_at(path))
}

fn interrupted() -> Option<PathBuf> {
    let newest = find_interrupted(Path::new("."))
        .into_iter()
        .max_by_key(|path| written_at(path))?;
    Some(newest.strip_prefix(".").unwrap_or(&newest).to_owned())
}

/// Time of the last change of a file; `None` if there is no such file.
fn written_at(path: &Path) -> Option<SystemTime> {
    fs::metadata(path).and_then(|file| file.modified()).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn suggestions_follow_from_profiles_ports_and_captures() {
        let port = |name: &str, kind: &str| Port {
            name: name.to_owned(),
            kind: kind.to_owned(),
            description: None,
        };
        let text = |profiles: &[&str], ports: &[Port], captures: &Captures| {
            lines(profiles, ports, captures).join("\n")
        };
        let none = Captures::default();
        let bare = text(&[], &[], &none);
        assert!(
            bare.contains("groundwave demo") && bare.contains("none found yet"),
            "{bare}"
        );
        let ports = [
            port("/dev/ttyS0", "serial"),
            port("/dev/ttyUSB0", "USB 0403:6001"),
        ];
        let captures = Captures {
            newest: Some("evening.mcap".into()),
            interrupted: Some("late.mcap".into()),
        };
        let all = text(&["marvin"], &ports, &captures);
        for command in [
            "watch marvin",
            "watch /dev/ttyUSB0",
            "replay evening.mcap",
            "recover late.mcap",
            "demo",
        ] {
            assert!(
                all.contains(&format!("groundwave {command} ")),
                "{command}\n{all}"
            );
        }
        assert!(!all.contains("ttyS0"), "{all}");
        let first = all.lines().find(|line| line.starts_with("  "));
        assert!(first.is_some_and(|line| line.contains("demo")), "{all}");
        let on_board = [port("/dev/ttyAMA0", "serial"), ports[0].clone()];
        let all = text(&[], &on_board, &none);
        assert!(all.contains("ttyAMA0") && !all.contains("ttyS0"), "{all}");
        assert!(text(&[], &ports[..1], &none).contains("watch /dev/ttyS0"));
        let columns = all.lines().filter_map(|line| line.rfind("  ")).skip(1);
        let columns: Vec<usize> = columns.collect();
        assert!(columns.windows(2).all(|pair| pair[0] == pair[1]), "{all}");
    }
}
