//! `config`: prints the default configuration and its path, and checks a file.

use std::fmt::Write as _;
use std::path::Path;

use super::cli::{ConfigArgs, ConfigVerb};
use super::config::{self, Config};
use super::{Exit, Fault, say, show, show_line};
use crate::model::keys::Keymap;

pub(super) fn run(options: &ConfigArgs, named: Option<&Path>) -> Result<(), Fault> {
    match &options.what {
        None => {
            say(place(named));
            show(commented())
        }
        Some(ConfigVerb::Path) => {
            let path = named
                .map(Path::to_path_buf)
                .or_else(config::usual_place)
                .ok_or_else(|| {
                    Fault::new(
                        Exit::Failed,
                        "this system has no folder for configurations; use --config FILE",
                    )
                })?;
            show_line(path.display())
        }
        Some(ConfigVerb::Check { file }) => check(file.as_deref().or(named)),
    }
}

/// Describes where the configuration is read from.
fn place(named: Option<&Path>) -> String {
    match named.map(Path::to_path_buf).or_else(config::usual_place) {
        Some(path) => {
            let state = if path.exists() {
                "exists"
            } else {
                "does not exist yet"
            };
            format!(
                "read from {}, which {state}, or from --config FILE",
                path.display()
            )
        }
        None => "read from --config FILE".to_owned(),
    }
}

fn check(file: Option<&Path>) -> Result<(), Fault> {
    let Some(path) = file.map(Path::to_path_buf).or_else(config::usual_place) else {
        return Err(Fault::new(Exit::Usage, "no configuration; name a file"));
    };
    if file.is_none() && !path.exists() {
        return show_line(format_args!(
            "{}: file not found, so all settings have their defaults; `groundwave config` prints a file to start from",
            path.display()
        ));
    }
    let read = config::load(Some(&path))?;
    for note in &read.notes {
        show_line(format_args!("{}:{note}", path.display()))?;
    }
    show_line(format_args!("{}: {}", path.display(), summary(&read)))
}

fn summary(config: &Config) -> String {
    let names = |what: &str, names: Vec<&str>| match names[..] {
        [] => format!("no {what}s"),
        _ => format!("{what}s {}", names.join(", ")),
    };
    let links = config.links.keys().map(String::as_str).collect();
    let robots = config.robots.keys().map(String::as_str).collect();
    let table = Keymap::default();
    let others = config.keys.manual().zip(table.manual());
    let changed = others.filter(|(now, then)| now[2] != then[2]);
    // A key for STOP counts in several contexts.
    let (stops, others): (Vec<_>, Vec<_>) = changed.partition(|(now, _)| now[3] == "stop");
    let keys = match others.len() + usize::from(!stops.is_empty()) {
        0 => "default keys".to_owned(),
        1 => "1 key of your own".to_owned(),
        count => format!("{count} keys of your own"),
    };
    format!(
        "good: {}, {}, {keys}",
        names("link", links),
        names("robot", robots)
    )
}

/// The complete default file, with the keys.
fn commented() -> String {
    let mut text = config::DEFAULT.to_owned();
    text += "\n# Keys by action: one such as \"F12\", several such as [\"F12\", \"Ctrl-B\"], or none: []. Actions that are not named keep\n\
             # their keys. STOP always has Space and Ctrl-S as well. Its keys here also count in sections that name no other\n\
             # key for it; a character does not count while text is entered.\n[keys]\n";
    let mut place = String::from("dashboard");
    for [context, _, keys, name, does] in Keymap::default().manual() {
        if context != place {
            let _ = writeln!(text, "\n[keys.{context}]");
            place = context.into_owned();
        }
        let keys: Vec<String> = keys.split(' ').map(|key| format!("{key:?}")).collect();
        let keys = match &keys[..] {
            [only] => only.clone(),
            several => format!("[{}]", several.join(", ")),
        };
        let _ = writeln!(text, "{:<44}  # {does}", format!("# {name} = {keys}"));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn summary_counts_stop_as_one_key() {
        let said = |text: &str| summary(&config::parse(text).expect("it is right"));
        for (text, keys) in [
            ("", "default keys"),
            ("[keys]\nstop = \"F12\"", "1 key of your own"),
            ("[keys.drive]\nstop = \"F12\"", "1 key of your own"),
            (
                "[keys]\nstop = \"F12\"\nscan = \"F11\"",
                "2 keys of your own",
            ),
        ] {
            assert!(said(text).ends_with(keys), "{text}: {}", said(text));
        }
    }

    #[test]
    fn printed_keys_uncommented_change_nothing() {
        let text = commented();
        let (_, keys) = text.split_once("\n[keys]\n").expect("there are keys");
        let said: Vec<&str> = keys
            .lines()
            .map(|line| line.trim_start_matches("# "))
            .collect();
        let said = said.join("\n");
        let config = config::parse(&format!("[keys]\n{said}"))
            .unwrap_or_else(|mistakes| panic!("{mistakes:?}\n{said}"));
        let keys = |config: &Config| {
            let rows = config.keys.manual();
            let rows = rows.map(|[_, _, keys, name, _]| (name.into_owned(), keys.into_owned()));
            rows.collect::<Vec<_>>()
        };
        assert_eq!(keys(&config), keys(&Config::default()));
        assert_eq!(config::parse(&text), Ok(Config::default()));
    }
}
