//! How the dashboard is to look, from the environment. Nothing is asked of the terminal: one that does
//! not answer would cost seconds.

use std::env;

use crate::model::{Colors, Config, Limits};

/// `NO_COLOR`, `COLORFGBG` and the locale.
pub(super) fn from_environment() -> Config {
    let set = |name| env::var(name).ok().filter(|value| !value.is_empty());
    let locale = set("LC_ALL")
        .or_else(|| set("LC_CTYPE"))
        .or_else(|| set("LANG"));
    Config {
        limits: Limits::default(),
        colors: colors(set("NO_COLOR").is_some(), set("COLORFGBG").as_deref()),
        ascii: is_ascii(locale.as_deref()),
        raw_copy: None,
        silent: false,
    }
}

fn colors(no_color: bool, foreground_background: Option<&str>) -> Colors {
    if no_color {
        return Colors::Mono;
    }
    // `15;0` is white on black. Of the sixteen colours 7 and 9 to 15 are light.
    let background = foreground_background
        .and_then(|value| value.rsplit(';').next())
        .and_then(|value| value.parse::<u8>().ok());
    match background {
        Some(7 | 9..=15) => Colors::Light,
        _ => Colors::Dark,
    }
}

/// A locale that names an encoding other than UTF-8 gets ASCII; `C` and none at all too, except where
/// locales are not a thing.
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
    fn no_color_wins_and_light_backgrounds_are_known() {
        assert_eq!(colors(true, Some("0;15")), Colors::Mono);
        assert_eq!(colors(false, Some("0;15")), Colors::Light);
        assert_eq!(colors(false, Some("15;0")), Colors::Dark);
        assert_eq!(colors(false, Some("12;default;8")), Colors::Dark);
        assert_eq!(colors(false, Some("rubbish")), Colors::Dark);
    }

    #[cfg(unix)]
    #[test]
    fn braille_needs_utf_8() {
        assert!(!is_ascii(Some("en_US.UTF-8")));
        assert!(!is_ascii(Some("C.utf8")));
        assert!(is_ascii(Some("C")));
        assert!(is_ascii(Some("de_DE.ISO-8859-1")));
        assert!(is_ascii(None));
    }
}
