//! The escape-sequence reader: Esc directly followed by a key.
//!
//! An arrow key is an escape and letters. With another escape right before it, crossterm 0.29 returns one Esc and the letters
//! as if typed: `[` and `D`, and `D` docks the robot.

use std::io;

use crossterm::event::{Event, KeyCode, KeyEvent, KeyEventKind, KeyModifiers};

/// Maximum length of a key's sequence.
const LETTERS_MAX: usize = 16;

/// The events after an Esc. `next` returns the next event of the same burst.
pub(super) fn after_escape(
    mut next: impl FnMut() -> io::Result<Option<Event>>,
) -> io::Result<Vec<Event>> {
    let mut events = Vec::new();
    loop {
        let Some(event) = next()? else {
            return Ok(events);
        };
        match letter(&event) {
            Some('[') => {
                let (letters, other) = rest_of(&mut next)?;
                events.extend(key(&letters));
                events.extend(other);
            }
            Some('O') => {
                let event = next()?;
                match event.as_ref().and_then(letter) {
                    Some(letter) => events.extend(key(&[letter])),
                    None => events.extend(event),
                }
            }
            _ => events.push(event),
        }
        if !events.last().is_some_and(is_escape) {
            return Ok(events);
        }
    }
}

/// Whether Esc was pressed.
pub(super) fn is_escape(event: &Event) -> bool {
    matches!(event, Event::Key(key) if key.code == KeyCode::Esc && key.kind == KeyEventKind::Press)
}

fn letter(event: &Event) -> Option<char> {
    match event {
        Event::Key(KeyEvent {
            code: KeyCode::Char(c),
            modifiers,
            ..
        }) if (*modifiers - KeyModifiers::SHIFT).is_empty() => Some(*c),
        _ => None,
    }
}

/// The letters of a sequence up to its final one, or the event that came instead.
fn rest_of(
    next: &mut impl FnMut() -> io::Result<Option<Event>>,
) -> io::Result<(Vec<char>, Option<Event>)> {
    let mut letters = Vec::new();
    while letters.len() < LETTERS_MAX {
        let Some(event) = next()? else {
            break;
        };
        let Some(letter) = letter(&event) else {
            return Ok((Vec::new(), Some(event)));
        };
        letters.push(letter);
        if matches!(letter, '@'..='~') {
            return Ok((letters, None));
        }
    }
    Ok((Vec::new(), None))
}

/// The key of a sequence, without modifiers; `None` if no key sends it.
fn key(letters: &[char]) -> Option<Event> {
    let (last, said) = letters.split_last()?;
    let number: String = said.iter().take_while(|c| c.is_ascii_digit()).collect();
    let code = match (last, number.as_str()) {
        ('A', _) => KeyCode::Up,
        ('B', _) => KeyCode::Down,
        ('C', _) => KeyCode::Right,
        ('D', _) => KeyCode::Left,
        ('H', _) | ('~', "1" | "7") => KeyCode::Home,
        ('F', _) | ('~', "4" | "8") => KeyCode::End,
        ('Z', _) => KeyCode::BackTab,
        ('P', _) | ('~', "11") => KeyCode::F(1),
        ('~', "3") => KeyCode::Delete,
        ('~', "5") => KeyCode::PageUp,
        ('~', "6") => KeyCode::PageDown,
        _ => return None,
    };
    Some(Event::Key(code.into()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn typed(keys: &str) -> Vec<Event> {
        let code = |c| match c {
            '\x1b' => KeyCode::Esc,
            c => KeyCode::Char(c),
        };
        keys.chars().map(|c| Event::Key(code(c).into())).collect()
    }

    /// The keys read from one burst of bytes as crossterm returns them.
    fn keys_of(keys: &str) -> Vec<KeyCode> {
        let mut events = typed(keys).into_iter();
        let mut read = Vec::new();
        while let Some(event) = events.next() {
            let is_escape = is_escape(&event);
            read.push(event);
            if is_escape {
                read.extend(after_escape(|| Ok(events.next())).expect("nothing fails here"));
            }
        }
        let code = |event| match event {
            Event::Key(key) => key.code,
            other => panic!("{other:?}"),
        };
        read.into_iter().map(code).collect()
    }

    #[test]
    fn esc_and_another_key_are_two_keys() {
        for (keys, code) in [
            ("\x1b[D", KeyCode::Left),
            ("\x1b[1;2D", KeyCode::Left),
            ("\x1bOA", KeyCode::Up),
            ("\x1b[5~", KeyCode::PageUp),
            ("\x1b[6~", KeyCode::PageDown),
            ("\x1b[3~", KeyCode::Delete),
            ("\x1bOP", KeyCode::F(1)),
        ] {
            assert_eq!(keys_of(keys), [KeyCode::Esc, code], "{keys:?}");
        }
    }

    #[test]
    fn unknown_sequences_are_dropped_and_the_next_key_is_not() {
        assert_eq!(keys_of("\x1b[15~ "), [KeyCode::Esc, KeyCode::Char(' ')]);
        assert_eq!(keys_of("\x1b[1;2"), [KeyCode::Esc]);
        assert_eq!(keys_of("\x1bO"), [KeyCode::Esc]);
        let two = [KeyCode::Esc, KeyCode::Left, KeyCode::Esc, KeyCode::Right];
        assert_eq!(keys_of("\x1b[D\x1b[C"), two);
        assert_eq!(
            keys_of("\x1b\x1b "),
            [KeyCode::Esc, KeyCode::Esc, KeyCode::Char(' ')]
        );
        assert_eq!(keys_of("[D"), [KeyCode::Char('['), KeyCode::Char('D')]);
    }
}
