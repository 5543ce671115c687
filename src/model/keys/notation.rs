//! The notation of keys and actions.

use std::fmt::Debug;

use crossterm::event::{KeyCode, KeyModifiers};

/// A key and its modifiers.
pub(super) type Key = (KeyCode, KeyModifiers);

const NAMED: [(&str, KeyCode); 15] = [
    ("Space", KeyCode::Char(' ')),
    ("Enter", KeyCode::Enter),
    ("Esc", KeyCode::Esc),
    ("Tab", KeyCode::Tab),
    ("BackTab", KeyCode::BackTab),
    ("Backspace", KeyCode::Backspace),
    ("Delete", KeyCode::Delete),
    ("Insert", KeyCode::Insert),
    ("Left", KeyCode::Left),
    ("Right", KeyCode::Right),
    ("Up", KeyCode::Up),
    ("Down", KeyCode::Down),
    ("PgUp", KeyCode::PageUp),
    ("PgDn", KeyCode::PageDown),
    ("Home", KeyCode::Home),
];

/// Parses a key: `p`, `P`, `Ctrl-S`, `Shift-Left`, `F5`, `Space`.
pub(super) fn read(word: &str) -> Result<Key, String> {
    let (mut held, mut rest) = (KeyModifiers::NONE, word);
    loop {
        if let Some(after) = strip_word(rest, "ctrl-") {
            (held, rest) = (held | KeyModifiers::CONTROL, after);
        } else if let Some(after) = strip_word(rest, "shift-") {
            (held, rest) = (held | KeyModifiers::SHIFT, after);
        } else {
            break;
        }
    }
    let code = read_code(rest).ok_or_else(|| {
        format!(
            "`{word}` is not a key: one character, or Space, Enter, Esc, Tab, Backspace, Left, PgUp, Home, End, F1 to F12 and \
             so on, with Ctrl- or Shift- before it (no Alt-)"
        )
    })?;
    let code = match code {
        // A control character is reported in lower case, and a character implies Shift.
        KeyCode::Char(c) if held.contains(KeyModifiers::CONTROL) => {
            KeyCode::Char(c.to_ascii_lowercase())
        }
        code => code,
    };
    if let KeyCode::Char(_) = code {
        held -= KeyModifiers::SHIFT;
    }
    Ok((code, held))
}

fn strip_word<'a>(text: &'a str, word: &str) -> Option<&'a str> {
    let (head, rest) = text.split_at_checked(word.len())?;
    (head.eq_ignore_ascii_case(word) && !rest.is_empty()).then_some(rest)
}

fn read_code(word: &str) -> Option<KeyCode> {
    let mut characters = word.chars();
    if let (Some(only), None) = (characters.next(), characters.next()) {
        return (!only.is_control()).then_some(KeyCode::Char(only));
    }
    if word.eq_ignore_ascii_case("end") {
        return Some(KeyCode::End);
    }
    let named = NAMED
        .iter()
        .find(|(name, _)| name.eq_ignore_ascii_case(word));
    let number = || word.strip_prefix(['f', 'F'])?.parse().ok();
    named.map(|(_, code)| *code).or_else(|| {
        number()
            .filter(|number| (1..=12).contains(number))
            .map(KeyCode::F)
    })
}

/// The name of a key in the notation of [`read`].
pub(super) fn name((code, held): Key) -> String {
    let mut text = String::new();
    if held.contains(KeyModifiers::CONTROL) {
        text += "Ctrl-";
    }
    if held.contains(KeyModifiers::SHIFT) {
        text += "Shift-";
    }
    let named = NAMED.iter().find(|(_, known)| *known == code);
    match (named, code) {
        (Some((name, _)), _) => text + name,
        (None, KeyCode::Char(c)) if held.contains(KeyModifiers::CONTROL) => {
            text + &c.to_ascii_uppercase().to_string()
        }
        (None, KeyCode::Char(c)) => text + &c.to_string(),
        (None, KeyCode::F(number)) => format!("{text}F{number}"),
        (None, KeyCode::End) => text + "End",
        (None, code) => format!("{text}{code:?}"),
    }
}

/// Names of several keys, separated by spaces.
pub(super) fn names(keys: &[Key]) -> String {
    let names: Vec<String> = keys.iter().copied().map(name).collect();
    names.join(" ")
}

/// An action's name in the configuration, from its name in the code: `Mode(GoHome)` is `mode-go-home`;
/// directions and signs become words.
pub(super) fn action_name(action: impl Debug) -> String {
    let text = format!("{action:?}");
    let mut words: Vec<String> = Vec::new();
    let mut field = None;
    for token in text
        .split([' ', '(', ')', '{', '}', ','])
        .filter(|token| !token.is_empty())
    {
        if let Some(name) = token.strip_suffix(':') {
            field = Some(name);
            continue;
        }
        let value = match (field.take(), token) {
            (_, "0") => continue,
            (Some("east" | "right"), number) => toward(number, "right", "left"),
            (Some("north"), number) => toward(number, "up", "down"),
            (Some("ahead"), number) => toward(number, "ahead", "back"),
            (Some("forward"), "false") => "back".to_owned(),
            (Some(_), "false") => continue,
            (Some(name), "true") => name.to_owned(),
            (_, number) if number.parse::<i32>().is_ok() => match number.trim_start_matches('-') {
                "1" => toward(number, "more", "less"),
                size => format!("{}-{size}", toward(number, "more", "less")),
            },
            (_, "Forage") => "dock".to_owned(),
            (_, word) => kebab(word),
        };
        words.push(value);
    }
    words.join("-")
}

fn toward(number: &str, more: &str, less: &str) -> String {
    if number.starts_with('-') { less } else { more }.to_owned()
}

fn kebab(word: &str) -> String {
    let mut text = String::new();
    for (place, c) in word.chars().enumerate() {
        if c.is_ascii_uppercase() && place > 0 {
            text.push('-');
        }
        text.push(c.to_ascii_lowercase());
    }
    text
}
