//! Tables of the escape-sequence reader, from control characters and sequences to keys and clicks.

use std::str;

use crossterm::event::{
    Event, KeyCode, KeyEvent, KeyEventKind, KeyModifiers, MouseButton, MouseEvent, MouseEventKind,
};

/// The key of a control character.
pub(super) fn control(byte: u8) -> Option<Event> {
    let code = match byte {
        b'\r' => KeyCode::Enter,
        b'\t' => KeyCode::Tab,
        0x7F => KeyCode::Backspace,
        0 => return pressed(' ', KeyModifiers::CONTROL),
        1..=26 => return pressed(char::from(byte - 1 + b'a'), KeyModifiers::CONTROL),
        28..=31 => return pressed(char::from(byte - 28 + b'4'), KeyModifiers::CONTROL),
        _ => return None,
    };
    Some(Event::Key(code.into()))
}

pub(super) fn character(text: &str) -> Option<Event> {
    let c = text.chars().next()?;
    let is_upper = c.is_uppercase();
    pressed(
        c,
        if is_upper {
            KeyModifiers::SHIFT
        } else {
            KeyModifiers::NONE
        },
    )
}

pub(super) fn alt(c: char) -> Option<Event> {
    pressed(c, KeyModifiers::ALT)
}

#[expect(clippy::unnecessary_wraps, reason = "its callers may have no key")]
pub(super) fn pressed(c: char, modifiers: KeyModifiers) -> Option<Event> {
    Some(Event::Key(KeyEvent::new(KeyCode::Char(c), modifiers)))
}

/// The event of a sequence `ESC [ fields last`; `None` if no key sends it.
pub(super) fn control_sequence(fields: &[u8], last: u8) -> Option<Event> {
    let fields = str::from_utf8(fields).ok()?;
    if let (Some(click), b'M' | b'm') = (fields.strip_prefix('<'), last) {
        let mut numbers = click.splitn(3, ';').map(str::parse::<u16>);
        let mut next = || numbers.next()?.ok();
        let (button, column, row) = (next()?, next()?, next()?);
        return mouse(button, column, row).filter(|_| last == b'M');
    }
    let mut fields = fields.split(';');
    let number = fields.next().unwrap_or_default();
    let number = number.split(':').next().unwrap_or_default();
    let mut pressed = fields.next().unwrap_or_default().split(':');
    let modifiers: u8 = pressed.next().unwrap_or_default().parse().unwrap_or(1);
    let modifiers = modifiers_of(modifiers.wrapping_sub(1));
    let kind = match pressed.next() {
        Some("2") => KeyEventKind::Repeat,
        Some("3") => KeyEventKind::Release,
        _ => KeyEventKind::Press,
    };
    let code = match last {
        b'A' => KeyCode::Up,
        b'B' => KeyCode::Down,
        b'C' => KeyCode::Right,
        b'D' => KeyCode::Left,
        b'H' => KeyCode::Home,
        b'F' => KeyCode::End,
        b'P'..=b'S' => KeyCode::F(last - b'P' + 1),
        b'Z' => {
            let key = KeyEvent::new(KeyCode::BackTab, modifiers | KeyModifiers::SHIFT);
            return Some(Event::Key(key));
        }
        b'~' => numbered(number.parse().ok()?)?,
        b'u' => coded(number.parse().ok()?, modifiers)?,
        _ => return None,
    };
    Some(Event::Key(KeyEvent::new_with_kind(code, modifiers, kind)))
}

/// The key of `ESC [ number ~`.
const fn numbered(number: u8) -> Option<KeyCode> {
    Some(match number {
        1 | 7 => KeyCode::Home,
        2 => KeyCode::Insert,
        3 => KeyCode::Delete,
        4 | 8 => KeyCode::End,
        5 => KeyCode::PageUp,
        6 => KeyCode::PageDown,
        11..=15 => KeyCode::F(number - 10),
        17..=21 => KeyCode::F(number - 11),
        23 | 24 => KeyCode::F(number - 12),
        _ => return None,
    })
}

/// The key of `ESC [ code u`, a character or a number of the kitty keyboard protocol.
fn coded(code: u32, modifiers: KeyModifiers) -> Option<KeyCode> {
    const KEYPAD: [char; 11] = ['0', '1', '2', '3', '4', '5', '6', '7', '8', '9', '.'];
    Some(match code {
        9 if modifiers.contains(KeyModifiers::SHIFT) => KeyCode::BackTab,
        9 => KeyCode::Tab,
        13 | 57_414 => KeyCode::Enter,
        27 => KeyCode::Esc,
        127 => KeyCode::Backspace,
        57_399..=57_409 => KeyCode::Char(*KEYPAD.get(code as usize - 57_399)?),
        57_410 => KeyCode::Char('/'),
        57_411 => KeyCode::Char('*'),
        57_412 => KeyCode::Char('-'),
        57_413 => KeyCode::Char('+'),
        57_417 => KeyCode::Left,
        57_418 => KeyCode::Right,
        57_419 => KeyCode::Up,
        57_420 => KeyCode::Down,
        57_421 => KeyCode::PageUp,
        57_422 => KeyCode::PageDown,
        57_423 => KeyCode::Home,
        57_424 => KeyCode::End,
        57_425 => KeyCode::Insert,
        57_426 => KeyCode::Delete,
        57_344..=63_743 => return None,
        _ => KeyCode::Char(char::from_u32(code)?),
    })
}

/// Converts a terminal's modifier bits; crossterm numbers Shift, Alt and Control differently.
fn modifiers_of(bits: u8) -> KeyModifiers {
    [
        KeyModifiers::SHIFT,
        KeyModifiers::ALT,
        KeyModifiers::CONTROL,
        KeyModifiers::SUPER,
        KeyModifiers::HYPER,
        KeyModifiers::META,
    ]
    .into_iter()
    .enumerate()
    .filter(|(bit, _)| bits >> bit & 1 == 1)
    .map(|(_, modifier)| modifier)
    .collect()
}

/// The event of the left button or the wheel; `None` for other buttons. Column and row count from 1.
pub(super) fn mouse(button: u16, column: u16, row: u16) -> Option<Event> {
    let kind = match button & !0x1C {
        0 => MouseEventKind::Down(MouseButton::Left),
        64 => MouseEventKind::ScrollUp,
        65 => MouseEventKind::ScrollDown,
        _ => return None,
    };
    Some(Event::Mouse(MouseEvent {
        kind,
        column: column.checked_sub(1)?,
        row: row.checked_sub(1)?,
        modifiers: KeyModifiers::NONE,
    }))
}
