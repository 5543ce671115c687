//! The escape-sequence reader: the bytes of a terminal to keys, clicks and pastes.
//!
//! A sequence or a paste may lack its end. It ends at a silence, because STOP must not wait for the end.

use std::mem;
use std::str;
use std::time::{Duration, Instant};

use crossterm::event::{
    Event, KeyCode, KeyEvent, KeyEventKind, KeyModifiers, MouseButton, MouseEvent, MouseEventKind,
};

/// Longest silence within a sequence or a character. Keys are typed more slowly.
const SEQUENCE_GAP: Duration = Duration::from_millis(50);

/// Longest silence within a paste.
const PASTE_GAP: Duration = Duration::from_secs(1);

/// Maximum length of a sequence in bytes.
const SEQUENCE_MAX: usize = 32;

/// Maximum length of a paste in bytes; the rest is dropped.
const PASTE_MAX: usize = 64 << 10;

const ESC: u8 = 0x1B;
const PASTE_BEGIN: &[u8] = b"\x1b[200~";
const PASTE_END: &[u8] = b"\x1b[201~";
const OLD_CLICK: &[u8] = b"\x1b[M";

/// Bytes that are keys even within a paste or a string: Ctrl-C and Ctrl-S. No text contains them.
const KEYS_IN_TEXT: [u8; 2] = [0x03, 0x13];

/// The reader.
pub(super) struct Reader {
    /// An unfinished sequence or character; of a string, its first three bytes and its latest.
    held: Vec<u8>,
    /// The paste under way.
    paste: Option<Vec<u8>>,
    /// Time of the latest byte.
    latest: Instant,
    events: Vec<Event>,
}

/// The state of a sequence after a byte.
enum Sequence {
    Unfinished,
    /// With an event, unless no key has this sequence.
    Finished(Option<Event>),
    /// The latest byte cannot belong to it.
    Broken,
}

impl Reader {
    /// A reader that has read nothing.
    pub(super) const fn new(now: Instant) -> Self {
        Self {
            held: Vec::new(),
            paste: None,
            latest: now,
            events: Vec::new(),
        }
    }

    /// Takes bytes that were read together; returns the events that they complete.
    pub(super) fn handle_bytes(&mut self, now: Instant, bytes: &[u8]) -> Vec<Event> {
        self.handle_timeout(now);
        // The text of a paste comes in bursts; a terminal seldom cuts a string or a click at a space.
        let hides_keys = match self.paste {
            Some(_) => now >= self.latest + SEQUENCE_GAP,
            None => {
                bytes.starts_with(b" ") && (self.is_in_string() || self.held.starts_with(OLD_CLICK))
            }
        };
        if hides_keys {
            self.events.extend(spaces(now, bytes));
        }
        self.latest = now;
        for &byte in bytes {
            if self.paste.is_some() {
                self.take_pasted(byte);
            } else {
                self.take(byte);
            }
        }
        mem::take(&mut self.events)
    }

    /// When to call [`Reader::end`], if no byte comes before.
    pub(super) fn poll_timeout(&self) -> Option<Instant> {
        if self.paste.is_some() {
            Some(self.latest + PASTE_GAP)
        } else {
            (!self.held.is_empty()).then(|| self.latest + SEQUENCE_GAP)
        }
    }

    /// Takes the time without bytes; returns the events that it completes.
    pub(super) fn end(&mut self, now: Instant) -> Vec<Event> {
        self.handle_timeout(now);
        mem::take(&mut self.events)
    }

    fn handle_timeout(&mut self, now: Instant) {
        if self.poll_timeout().is_some_and(|at| now >= at) {
            self.end_paste();
            self.end_sequence();
        }
    }

    fn is_in_string(&self) -> bool {
        matches!(*self.held, [ESC, begin, ..] if is_string(begin))
    }

    fn take(&mut self, byte: u8) {
        if self.is_in_string() {
            if KEYS_IN_TEXT.contains(&byte) {
                return self.events.extend(control(byte));
            }
            self.held.truncate(3);
        }
        self.held.push(byte);
        match read(&self.held) {
            Sequence::Unfinished => {}
            Sequence::Finished(event) => {
                self.paste = (self.held == PASTE_BEGIN).then(Vec::new);
                self.events.extend(event);
                self.held.clear();
            }
            Sequence::Broken => {
                self.held.pop();
                self.end_sequence();
                self.take(byte);
            }
        }
    }

    /// Ends an unfinished sequence: its bytes may be keys of their own.
    fn end_sequence(&mut self) {
        let event = match *self.held.as_slice() {
            [ESC] => Some(Event::Key(KeyCode::Esc.into())),
            [ESC, c] if c.is_ascii() => alt(char::from(c)),
            _ => None,
        };
        self.events.extend(event);
        self.held.clear();
    }

    /// Takes a byte of a paste; `held` has the beginning of its end.
    fn take_pasted(&mut self, byte: u8) {
        if KEYS_IN_TEXT.contains(&byte) {
            return self.events.extend(control(byte));
        }
        self.held.push(byte);
        if self.held == PASTE_END {
            self.held.clear();
            self.end_paste();
        } else if !PASTE_END.starts_with(&self.held) {
            let is_escape = byte == ESC;
            self.held.truncate(self.held.len() - usize::from(is_escape));
            if let Some(paste) = &mut self.paste {
                let room = PASTE_MAX.saturating_sub(paste.len());
                paste.extend(self.held.drain(..).take(room));
            }
            self.held.extend(is_escape.then_some(ESC));
        }
    }

    fn end_paste(&mut self) {
        if let Some(text) = self.paste.take() {
            self.held.clear();
            let text = String::from_utf8_lossy(&text).into_owned();
            self.events.push(Event::Paste(text));
        }
    }
}

/// The keys of these bytes, if each of them is Space.
fn spaces(now: Instant, bytes: &[u8]) -> Vec<Event> {
    let mut reader = Reader::new(now);
    for &byte in bytes {
        reader.take(byte);
    }
    let is_space =
        |event: &Event| matches!(event, Event::Key(key) if key.code == KeyCode::Char(' '));
    let are_spaces = reader.held.is_empty() && reader.events.iter().all(is_space);
    reader.events.retain(|_| are_spaces);
    reader.events
}

/// Whether `ESC` and this byte begin a string of the terminal: DCS, SOS, OSC, PM or APC. It ends with BEL or at `ESC`.
const fn is_string(begin: u8) -> bool {
    matches!(begin, b'P' | b'X' | b']' | b'^' | b'_')
}

/// Reads the bytes of one key, at least one.
fn read(bytes: &[u8]) -> Sequence {
    match *bytes {
        [ESC] | [ESC, b'[' | b'O'] | [ESC, b'[', b'['] => Sequence::Unfinished,
        [ESC, ESC] => Sequence::Broken,
        // The end of a string.
        [ESC, b'\\'] => Sequence::Finished(None),
        [ESC, begin] if is_string(begin) => Sequence::Unfinished,
        [ESC, begin, .., latest] if is_string(begin) => match latest {
            0x07 => Sequence::Finished(None),
            ESC => Sequence::Broken,
            _ => Sequence::Unfinished,
        },
        // The Linux console's F1 to F5.
        [ESC, b'[', b'[', last] => match last {
            b'A'..=b'E' => Sequence::Finished(Some(Event::Key(KeyCode::F(last - b'A' + 1).into()))),
            _ => Sequence::Broken,
        },
        [ESC, b'[', b'M', ref click @ ..] => read_old_click(click),
        [ESC, b'[', ref fields @ .., last] => match last {
            b'0'..=b'?' if bytes.len() < SEQUENCE_MAX => Sequence::Unfinished,
            b'@'..=b'~' => Sequence::Finished(control_sequence(fields, last)),
            _ => Sequence::Broken,
        },
        [ESC, b'O', last] => match last {
            b'@'..=b'~' => Sequence::Finished(control_sequence(b"", last)),
            _ => Sequence::Broken,
        },
        [ESC, ref rest @ ..] => match read(rest) {
            Sequence::Finished(Some(Event::Key(key))) => {
                let modifiers = key.modifiers | KeyModifiers::ALT;
                Sequence::Finished(Some(Event::Key(KeyEvent { modifiers, ..key })))
            }
            other => other,
        },
        [byte] if byte < b' ' || byte == 0x7F => Sequence::Finished(control(byte)),
        _ => match str::from_utf8(bytes) {
            Ok(text) => Sequence::Finished(character(text)),
            Err(error) if error.error_len().is_none() => Sequence::Unfinished,
            Err(_) if bytes.len() == 1 => Sequence::Finished(None),
            Err(_) => Sequence::Broken,
        },
    }
}

/// The key of a control character.
fn control(byte: u8) -> Option<Event> {
    let code = match byte {
        b'\r' => KeyCode::Enter,
        b'\t' => KeyCode::Tab,
        0x7F => KeyCode::Backspace,
        0 => return held(' ', KeyModifiers::CONTROL),
        1..=26 => return held(char::from(byte - 1 + b'a'), KeyModifiers::CONTROL),
        28..=31 => return held(char::from(byte - 28 + b'4'), KeyModifiers::CONTROL),
        _ => return None,
    };
    Some(Event::Key(code.into()))
}

fn character(text: &str) -> Option<Event> {
    let c = text.chars().next()?;
    let is_upper = c.is_uppercase();
    held(
        c,
        if is_upper {
            KeyModifiers::SHIFT
        } else {
            KeyModifiers::NONE
        },
    )
}

fn alt(c: char) -> Option<Event> {
    held(c, KeyModifiers::ALT)
}

#[expect(clippy::unnecessary_wraps, reason = "its callers may have no key")]
fn held(c: char, modifiers: KeyModifiers) -> Option<Event> {
    Some(Event::Key(KeyEvent::new(KeyCode::Char(c), modifiers)))
}

/// The event of a sequence `ESC [ fields last`; `None` if no key sends it.
fn control_sequence(fields: &[u8], last: u8) -> Option<Event> {
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

/// Terminals number Shift, Alt and Control otherwise than crossterm.
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

/// A click as terminals without reports of any width send it: button, column and row, a byte each.
fn read_old_click(bytes: &[u8]) -> Sequence {
    match *bytes {
        [.., ..=0x1F] => Sequence::Broken,
        [button, column, row] => {
            let [column, row] = [column, row].map(|byte| u16::from(byte - b' '));
            Sequence::Finished(mouse(u16::from(button - b' '), column, row))
        }
        _ => Sequence::Unfinished,
    }
}

/// The left button or the wheel; column and row count from 1.
fn mouse(button: u16, column: u16, row: u16) -> Option<Event> {
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

#[cfg(test)]
mod tests {
    use super::*;

    const MS: Duration = Duration::from_millis(1);

    /// A reader with a clock of its own.
    struct Terminal {
        reader: Reader,
        now: Instant,
    }

    impl Terminal {
        fn new() -> Self {
            let now = Instant::now();
            let reader = Reader::new(now);
            Self { reader, now }
        }

        fn silent(&mut self, silence: Duration) -> Vec<Event> {
            self.now += silence;
            self.reader.end(self.now)
        }

        /// Sends bytes after a silence.
        fn after(&mut self, silence: Duration, bytes: &str) -> Vec<Event> {
            let mut events = self.silent(silence);
            events.extend(self.reader.handle_bytes(self.now, bytes.as_bytes()));
            events
        }
    }

    fn read_all(bytes: &str) -> Vec<Event> {
        let mut terminal = Terminal::new();
        let mut events = terminal.after(MS, bytes);
        events.extend(terminal.silent(PASTE_GAP));
        events
    }

    fn keys_of(bytes: &str) -> Vec<KeyCode> {
        let code = |event| match event {
            Event::Key(key) => key.code,
            other => panic!("{other:?}"),
        };
        read_all(bytes).into_iter().map(code).collect()
    }

    fn key(c: char) -> Vec<Event> {
        vec![Event::Key(KeyCode::Char(c).into())]
    }

    fn ctrl(c: char) -> Vec<Event> {
        held(c, KeyModifiers::CONTROL).into_iter().collect()
    }

    #[test]
    fn stop_and_ctrl_c_count_after_an_unfinished_sequence() {
        for begun in [
            "\x1b[200~",
            "\x1b[200~1,2\r",
            "\x1b[200~\x1b[201",
            "\x1b[1;1;",
            "\x1b[",
            "\x1bO",
            "\x1b[<0;1",
            "\x1b[?",
            "\x1b[M",
            "\x1b]0;title",
            "\x1bP",
            "\x1b_G\x1b",
            "\u{e9}\u{1b}[",
        ] {
            for (pressed, event) in [(" ", key(' ')), ("\x03", ctrl('c')), ("\x13", ctrl('s'))] {
                let mut terminal = Terminal::new();
                terminal.after(MS, begun);
                let events = terminal.after(SEQUENCE_GAP, pressed);
                assert!(
                    events.ends_with(&event),
                    "{begun:?} {pressed:?}: {events:?}"
                );
            }
        }
    }

    #[test]
    fn stop_and_ctrl_c_break_a_sequence_off_at_once() {
        for begun in ["\x1b[1;1;", "\x1b[", "\x1b[[", "\x1bO", "\x1b[<0;1"] {
            for (pressed, event) in [(" ", key(' ')), ("\x03", ctrl('c'))] {
                let events = read_all(&format!("{begun}{pressed}"));
                assert!(
                    events.ends_with(&event),
                    "{begun:?} {pressed:?}: {events:?}"
                );
            }
        }
    }

    #[test]
    fn strings_of_the_terminal_are_no_keys() {
        let body = "11;rgb:1e1e/1e1e/1e1e >|tmux 3.4 \r\n\t w".repeat(9);
        for begin in ["\x1b]", "\x1bP", "\x1b_", "\x1b^", "\x1bX"] {
            for end in ["\x07", "\x1b\\"] {
                let keys = keys_of(&format!("{begin}{body}{end}p"));
                assert_eq!(keys, [KeyCode::Char('p')], "{begin:?} {end:?}");
            }
            let next = keys_of(&format!("{begin}{body}\x1b[Dp"));
            assert_eq!(next, [KeyCode::Left, KeyCode::Char('p')], "{begin:?}");

            let mut terminal = Terminal::new();
            assert_eq!(terminal.after(MS, &format!("{begin}{body}")), []);
            assert_eq!(terminal.after(MS, "w"), []);
            assert_eq!(terminal.after(MS, " "), key(' '));
            assert_eq!(terminal.after(MS, "\x03"), ctrl('c'));
            assert_eq!(terminal.after(MS, "\x13"), ctrl('s'));
            assert_eq!(terminal.after(MS, "w"), []);
            assert!(terminal.reader.held.len() <= 4, "the body is not held");
            assert_eq!(terminal.silent(SEQUENCE_GAP), []);
            assert_eq!(terminal.after(MS, "p"), key('p'));
        }
        let alt = held('P', KeyModifiers::ALT).into_iter().collect::<Vec<_>>();
        assert_eq!(read_all("\x1bP"), alt);
    }

    #[test]
    fn space_counts_however_it_is_sent() {
        for begun in ["\x1b[200~", "\x1b[200~1,2", "\x1b[M", "\x1bP1"] {
            for (pressed, count) in [
                (" ", 1),
                ("  ", 2),
                ("\x1b[32u", 1),
                ("\x1b[32;5u", 1),
                ("\x1b[32;1:1u\x1b[32;1:3u", 2),
            ] {
                let mut terminal = Terminal::new();
                terminal.after(MS, begun);
                let is_paste = terminal.reader.paste.is_some();
                let silence = if is_paste { SEQUENCE_GAP } else { MS };
                let events = terminal.after(silence, pressed);
                let is_space = |event: &Event| matches!(event, Event::Key(key) if key.code == KeyCode::Char(' '));
                let spaces = events.iter().filter(|event| is_space(event)).count();
                assert_eq!(spaces, count, "{begun:?} {pressed:?}: {events:?}");
            }
        }
        for text in [" 1", "1 ", "\x1b[32u1", " \x1b[3"] {
            let mut terminal = Terminal::new();
            terminal.after(MS, "\x1b[200~");
            assert_eq!(terminal.after(SEQUENCE_GAP, text), [], "{text:?}");
        }
    }

    #[test]
    fn a_paste_without_an_end_ends_after_a_second_and_is_bounded() {
        let mut terminal = Terminal::new();
        assert_eq!(terminal.after(MS, "\x1b[200~1,2"), []);
        assert_eq!(terminal.silent(PASTE_GAP.saturating_sub(MS)), []);
        let text = "1,2".to_owned();
        assert_eq!(terminal.silent(MS), [Event::Paste(text)]);
        assert_eq!(terminal.after(MS, "p"), key('p'));

        terminal.after(MS, "\x1b[200~");
        for _ in 0..200 {
            assert_eq!(terminal.after(MS, &"7".repeat(1000)), []);
        }
        assert_eq!(terminal.after(SEQUENCE_GAP, " "), key(' '));
        let events = terminal.after(MS, "\x1b[201~p");
        let [Event::Paste(text), end @ ..] = events.as_slice() else {
            panic!("{events:?}");
        };
        assert_eq!(text.len(), PASTE_MAX);
        assert_eq!(end, key('p'));
    }

    #[test]
    fn a_paste_is_one_text_however_it_is_cut() {
        let text = "1,2 \r\x1b[20~ü\x1b\x1b[201";
        let sent = format!("\x1b[200~{text}\x1b[201~");
        for size in 1..sent.len() {
            let mut terminal = Terminal::new();
            let mut events = Vec::new();
            for bytes in sent.as_bytes().chunks(size) {
                terminal.now += MS;
                events.extend(terminal.reader.handle_bytes(terminal.now, bytes));
            }
            assert_eq!(events, [Event::Paste(text.to_owned())], "by {size}");
        }
    }

    #[test]
    fn a_lone_escape_is_a_key_after_a_silence() {
        let mut terminal = Terminal::new();
        assert_eq!(terminal.after(MS, "\x1b"), []);
        let escape = Event::Key(KeyCode::Esc.into());
        assert_eq!(terminal.silent(SEQUENCE_GAP), std::slice::from_ref(&escape));
        assert_eq!(terminal.reader.poll_timeout(), None);
        // A slow line cuts an arrow in pieces.
        assert_eq!(terminal.after(MS, "\x1b"), []);
        assert_eq!(terminal.after(SEQUENCE_GAP.saturating_sub(MS), "["), []);
        let left = Event::Key(KeyCode::Left.into());
        assert_eq!(terminal.after(SEQUENCE_GAP.saturating_sub(MS), "D"), [left]);
        assert_eq!(keys_of("\x1b\x1b"), [KeyCode::Esc, KeyCode::Esc]);
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
            ("\x1b[15~", KeyCode::F(5)),
            ("\x1b[24~", KeyCode::F(12)),
            ("\x1b[[E", KeyCode::F(5)),
            ("\x1b[27u", KeyCode::Esc),
            ("\x1b[57400u", KeyCode::Char('1')),
        ] {
            let both = format!("\x1b{keys}");
            assert_eq!(keys_of(&both), [KeyCode::Esc, code], "{keys:?}");
        }
    }

    #[test]
    fn unknown_sequences_are_dropped_and_the_next_key_is_not() {
        assert_eq!(keys_of("\x1b[99~ "), [KeyCode::Char(' ')]);
        assert_eq!(keys_of("\x1b[?62;4c "), [KeyCode::Char(' ')]);
        assert_eq!(keys_of("\x1b[1;2"), []);
        assert_eq!(
            keys_of(&format!("\x1b[{} ", "1;".repeat(99))).last(),
            Some(&KeyCode::Char(' '))
        );
        assert_eq!(keys_of("[D"), [KeyCode::Char('['), KeyCode::Char('D')]);
        let mut terminal = Terminal::new();
        assert_eq!(
            terminal.reader.handle_bytes(terminal.now, b"\xFF\xC3 "),
            key(' ')
        );
    }

    #[test]
    fn modifiers_and_kinds_are_read() {
        for (keys, code, modifiers, kind) in [
            (
                "A",
                KeyCode::Char('A'),
                KeyModifiers::SHIFT,
                KeyEventKind::Press,
            ),
            (
                "\x1b ",
                KeyCode::Char(' '),
                KeyModifiers::ALT,
                KeyEventKind::Press,
            ),
            (
                "\x1b[1;1:3A",
                KeyCode::Up,
                KeyModifiers::NONE,
                KeyEventKind::Release,
            ),
            (
                "\x1b[1;2:2C",
                KeyCode::Right,
                KeyModifiers::SHIFT,
                KeyEventKind::Repeat,
            ),
            (
                "\x1b[99;5u",
                KeyCode::Char('c'),
                KeyModifiers::CONTROL,
                KeyEventKind::Press,
            ),
            (
                "\x1b[9;2u",
                KeyCode::BackTab,
                KeyModifiers::SHIFT,
                KeyEventKind::Press,
            ),
            (
                "\x1b[Z",
                KeyCode::BackTab,
                KeyModifiers::SHIFT,
                KeyEventKind::Press,
            ),
        ] {
            let key = KeyEvent::new_with_kind(code, modifiers, kind);
            assert_eq!(read_all(keys), [Event::Key(key)], "{keys:?}");
        }
    }

    #[test]
    fn clicks_and_the_wheel_are_read() {
        let event = |kind| {
            let (column, row, modifiers) = (19, 11, KeyModifiers::NONE);
            vec![Event::Mouse(MouseEvent {
                kind,
                column,
                row,
                modifiers,
            })]
        };
        let click = event(MouseEventKind::Down(MouseButton::Left));
        assert_eq!(read_all("\x1b[<0;20;12M"), click);
        assert_eq!(read_all("\x1b[M 4,"), click);
        assert_eq!(read_all("\x1b[<64;20;12M"), event(MouseEventKind::ScrollUp));
        assert_eq!(
            read_all("\x1b[<65;20;12M"),
            event(MouseEventKind::ScrollDown)
        );
        assert_eq!(read_all("\x1b[<0;20;12m\x1b[<0;0;0M\x1b[<2;1;1M"), []);
    }

    proptest::proptest! {
        #[test]
        fn stop_counts_after_any_bytes(bytes: Vec<u8>) {
            let mut terminal = Terminal::new();
            terminal.reader.handle_bytes(terminal.now, &bytes);
            let events = terminal.after(SEQUENCE_GAP, " ");
            proptest::prop_assert!(events.ends_with(&key(' ')), "{:?}", events);
        }
    }
}
