//! Appearance of the dashboard: from the configuration, else from the environment. The terminal is not queried, because
//! waiting for a terminal that does not answer takes seconds.

use std::env;

use jiff::Timestamp;
use jiff::tz::TimeZone;

use super::config::{self, Clock, MapSigns, Theme};
use crate::io::terminal;
use crate::model::{Colors, Config, MapLines, Marker};

/// The appearance by `--theme` and the configuration, else by `NO_COLOR`, `TERM`, `COLORFGBG` and the locale.
pub(super) fn appearance(config: &config::Config, theme: Option<Theme>) -> Config {
    let set = |name| env::var(name).ok().filter(|value| !value.is_empty());
    let locale = set("LC_ALL")
        .or_else(|| set("LC_CTYPE"))
        .or_else(|| set("LANG"));
    let no_color = set("NO_COLOR").is_some();
    let dashboard = &config.dashboard;
    Config {
        colors: match theme.or(dashboard.theme) {
            // NO_COLOR outranks the configuration, but not the command line.
            _ if no_color && theme.is_none_or(|theme| theme == Theme::Auto) => Colors::Mono,
            None | Some(Theme::Auto) if is_monochrome(set("TERM").as_deref()) => Colors::Mono,
            None | Some(Theme::Auto) => colors(set("COLORFGBG").as_deref()),
            Some(Theme::Dark) => Colors::Dark,
            Some(Theme::Light) => Colors::Light,
            Some(Theme::HighContrast) => Colors::HighContrast,
            Some(Theme::Mono) => Colors::Mono,
        },
        ascii: dashboard
            .ascii
            .unwrap_or_else(|| is_ascii(locale.as_deref())),
        marker: match dashboard.map {
            None | Some(MapSigns::Auto | MapSigns::Pixels) if draws_octants(set) => Marker::Octant,
            None | Some(MapSigns::Auto | MapSigns::Braille | MapSigns::Pixels) => Marker::Braille,
            Some(MapSigns::Octant) => Marker::Octant,
            Some(MapSigns::Quadrant) => Marker::Quadrant,
        },
        lines: match dashboard.map {
            Some(MapSigns::Pixels) if shows_pictures(set) && !terminal::is_slow_line() => {
                MapLines::Pixels
            }
            _ => MapLines::Characters,
        },
        bell: dashboard.bell == Some(true),
        mouse: dashboard.mouse != Some(false),
        local_offset_s: (dashboard.clock == Some(Clock::Local)).then(local_offset_s),
        own_commands: config.own.commands.keys().cloned().collect(),
        limits: config.limits.clone(),
        alarms: config.alarms.clone(),
        keys: config.keys.clone(),
        ..Config::default()
    }
}

/// Current offset of local time from UTC, seconds; positive east of Greenwich.
fn local_offset_s() -> i32 {
    TimeZone::system().to_offset(Timestamp::now()).seconds()
}

fn colors(foreground_background: Option<&str>) -> Colors {
    // `15;0` is white on black. Of the sixteen colours 7 and 9 to 15 are light.
    let background = foreground_background
        .and_then(|value| value.rsplit(';').next())
        .and_then(|value| value.parse::<u8>().ok());
    match background {
        Some(7 | 9..=15) => Colors::Light,
        _ => Colors::Dark,
    }
}

/// Whether a terminal's name denotes a terminal without colours: `dumb`, a DEC terminal up to the VT420, or a monochrome variant.
fn is_monochrome(term: Option<&str>) -> bool {
    term.is_some_and(|term| {
        let is_dec = ["vt1", "vt2", "vt3", "vt4"]
            .iter()
            .any(|dec| term.starts_with(dec));
        is_dec || term == "dumb" || term.ends_with("-m") || term.ends_with("-mono")
    })
}

/// Whether the terminal is known to draw octants itself. Other terminals that do (kitty, foot) do not report their version.
fn draws_octants(set: impl Fn(&'static str) -> Option<String>) -> bool {
    match set("TERM_PROGRAM").as_deref() {
        Some("ghostty") => true,
        // Versions begin with the date; octants came in 2025.
        Some("WezTerm") => set("TERM_PROGRAM_VERSION").is_some_and(|version| *version >= *"2025"),
        _ => false,
    }
}

/// Whether the terminal announces the kitty graphics protocol. A terminal multiplexer hides the announcement.
fn shows_pictures(set: impl Fn(&'static str) -> Option<String>) -> bool {
    let is_kind = |name, kinds: &[&str]| set(name).is_some_and(|value| kinds.contains(&&*value));
    is_kind("TERM", &["xterm-kitty", "xterm-ghostty"])
        || is_kind("TERM_PROGRAM", &["ghostty", "WezTerm"])
}

/// Whether a locale lacks UTF-8. Systems other than Unix always have it.
fn is_ascii(locale: Option<&str>) -> bool {
    if !cfg!(unix) {
        return false;
    }
    locale.is_none_or(|locale| {
        let locale = locale.to_lowercase();
        !locale.contains("utf-8") && !locale.contains("utf8")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn background_follows_from_colorfgbg() {
        assert_eq!(colors(Some("0;15")), Colors::Light);
        assert_eq!(colors(Some("15;0")), Colors::Dark);
        assert_eq!(colors(Some("12;default;8")), Colors::Dark);
        assert_eq!(colors(Some("rubbish")), Colors::Dark);
    }

    #[test]
    fn terminal_without_colours_is_known_by_its_name() {
        for term in ["vt100", "vt220", "dumb", "xterm-mono", "linux-m"] {
            assert!(is_monochrome(Some(term)), "{term}");
        }
        for term in [
            "xterm-256color",
            "linux",
            "screen",
            "tmux-256color",
            "vt525",
        ] {
            assert!(!is_monochrome(Some(term)), "{term}");
        }
        assert!(!is_monochrome(None));
    }

    #[test]
    fn octants_are_for_terminals_that_draw_them() {
        let known = |program: &'static str, version: &'static str| {
            draws_octants(|name| match name {
                "TERM_PROGRAM" => Some(program.to_owned()),
                "TERM_PROGRAM_VERSION" => Some(version.to_owned()),
                _ => None,
            })
        };
        assert!(known("ghostty", "1.1.0"));
        assert!(known("WezTerm", "20250608-074531-abcdef"));
        assert!(!known("WezTerm", "20240203-110809-5046fc22"));
        assert!(!known("tmux", "3.5a"));
        assert!(!draws_octants(|_| None));
    }

    #[test]
    fn pictures_are_for_terminals_that_report_support() {
        let term =
            |term: &'static str| shows_pictures(|name| (name == "TERM").then(|| term.to_owned()));
        assert!(term("xterm-kitty") && term("xterm-ghostty"));
        assert!(!term("xterm-256color") && !term("tmux-256color"));
    }

    #[cfg(unix)]
    #[test]
    fn locale_without_utf_8_gets_ascii() {
        assert!(!is_ascii(Some("en_US.UTF-8")));
        assert!(!is_ascii(Some("C.utf8")));
        assert!(is_ascii(Some("C")));
        assert!(is_ascii(Some("de_DE.ISO-8859-1")));
        assert!(is_ascii(None));
    }
}
