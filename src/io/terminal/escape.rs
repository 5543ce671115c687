//! Esc and a key that come in one burst, as a slow line or a quick hand makes them.
//!
//! An arrow is an escape and letters. When another escape comes right before it crossterm 0.29 takes the two for one Esc and
//! hands the letters over as if they were typed: `[` and `D`, which docks the robot.

use std::io;

use crossterm::event::{Event, KeyCode, KeyEvent, KeyEventKind, KeyModifiers};

/// The longest sequence of a key.
const LETTERS_MAX: usize = 16;

/// What follows an Esc that has been told. `next` is the next event, if it comes in the same burst.
pub(super) fn after_escape(
    mut next: impl FnMut() -> io::Result<Option<Event>>,
) -> io::Result<Vec<Event>> {
    let mut told = Vec::new();
    loop {
        let Some(event) = next()? else {
            return Ok(told);
        };
        match letter(&event) {
            Some('[') => {
                let (letters, other) = rest_of(&mut next)?;
                told.extend(key(&letters));
                told.extend(other);
            }
            Some('O') => {
                let event = next()?;
                match event.as_ref().and_then(letter) {
                    Some(letter) => told.extend(key(&[letter])),
                    None => told.extend(event),
                }
            }
            _ => told.push(event),
        }
        if !told.last().is_some_and(is_escape) {
            return Ok(told);
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

/// The letters of a sequence up to the one that ends it, or whatever came instead.
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

/// The key of a sequence, without the modifiers that may stand in it; what no key sends is dropped.
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

    /// The keys told for what crossterm makes of `\x1b` and these bytes, all in one burst.
    fn mended(keys: &str) -> Vec<KeyCode> {
        let mut events = typed(keys).into_iter();
        let mut told = Vec::new();
        while let Some(event) = events.next() {
            let is_escape = is_escape(&event);
            told.push(event);
            if is_escape {
                told.extend(after_escape(|| Ok(events.next())).expect("nothing fails here"));
            }
        }
        let code = |event| match event {
            Event::Key(key) => key.code,
            other => panic!("{other:?}"),
        };
        told.into_iter().map(code).collect()
    }

    #[test]
    fn esc_and_another_key_are_these_two() {
        for (keys, code) in [
            ("\x1b[D", KeyCode::Left),
            ("\x1b[1;2D", KeyCode::Left),
            ("\x1bOA", KeyCode::Up),
            ("\x1b[5~", KeyCode::PageUp),
            ("\x1b[6~", KeyCode::PageDown),
            ("\x1b[3~", KeyCode::Delete),
            ("\x1bOP", KeyCode::F(1)),
        ] {
            assert_eq!(mended(keys), [KeyCode::Esc, code], "{keys:?}");
        }
    }

    #[test]
    fn what_no_key_sends_is_dropped_and_what_follows_is_not() {
        assert_eq!(mended("\x1b[15~ "), [KeyCode::Esc, KeyCode::Char(' ')]);
        assert_eq!(mended("\x1b[1;2"), [KeyCode::Esc]);
        assert_eq!(mended("\x1bO"), [KeyCode::Esc]);
        let two = [KeyCode::Esc, KeyCode::Left, KeyCode::Esc, KeyCode::Right];
        assert_eq!(mended("\x1b[D\x1b[C"), two);
        assert_eq!(
            mended("\x1b\x1b "),
            [KeyCode::Esc, KeyCode::Esc, KeyCode::Char(' ')]
        );
        assert_eq!(mended("[D"), [KeyCode::Char('['), KeyCode::Char('D')]);
    }
}
