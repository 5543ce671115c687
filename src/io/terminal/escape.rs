//! The escape-sequence reader: converts a terminal's bytes to keys, clicks and pastes.
//!
//! A sequence or paste without its end ends after a silence, because STOP must not wait for the end.

mod keys;
#[cfg(test)]
mod tests;

use std::mem;
use std::str;
use std::time::{Duration, Instant};

use crossterm::event::{Event, KeyCode, KeyEvent, KeyModifiers};

use self::keys::{alt, character, control, control_sequence, mouse};

/// Maximum silence within a sequence or a character. Keys are typed more slowly.
const SEQUENCE_GAP: Duration = Duration::from_millis(50);

/// Maximum silence within a paste.
const PASTE_GAP: Duration = Duration::from_secs(1);

/// Maximum length of a sequence in bytes.
const SEQUENCE_MAX: usize = 32;

/// Maximum length of a paste in bytes; the rest is dropped.
const PASTE_MAX: usize = 64 << 10;

const ESC: u8 = 0x1B;
const PASTE_BEGIN: &[u8] = b"\x1b[200~";
const PASTE_END: &[u8] = b"\x1b[201~";
const OLD_CLICK: &[u8] = b"\x1b[M";

/// Bytes that count as keys even within a paste or a string: Ctrl-C and Ctrl-S. Text does not contain them.
const KEYS_IN_TEXT: [u8; 2] = [0x03, 0x13];

/// The escape-sequence reader.
pub(super) struct Reader {
    /// An unfinished sequence or character; for a string, its first three bytes and its latest byte.
    held: Vec<u8>,
    /// The current paste.
    paste: Option<Vec<u8>>,
    /// Time of the latest byte.
    latest: Instant,
    events: Vec<Event>,
}

/// The state of a sequence after a byte.
enum Sequence {
    Unfinished,
    /// The sequence is finished; with its event, if any key has this sequence.
    Finished(Option<Event>),
    /// The latest byte cannot belong to the sequence.
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
        // A terminal sends a paste in large parts, and rarely splits a string or a click at a space.
        let hides_keys = match self.paste {
            Some(_) => now >= self.latest + SEQUENCE_GAP,
            None => {
                bytes.starts_with(b" ") && (self.is_in_string() || self.held.starts_with(OLD_CLICK))
            }
        };
        if hides_keys {
            self.events.extend(keys_alone(now, bytes));
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

    /// Time at which to call [`Reader::end`] if no byte arrives before.
    pub(super) fn poll_timeout(&self) -> Option<Instant> {
        if self.paste.is_some() {
            Some(self.latest + PASTE_GAP)
        } else {
            (!self.held.is_empty()).then(|| self.latest + SEQUENCE_GAP)
        }
    }

    /// Takes a silence; returns the events that it completes.
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

    /// Ends an unfinished sequence; its bytes may be separate keys.
    fn end_sequence(&mut self) {
        let event = match *self.held.as_slice() {
            [ESC] => Some(Event::Key(KeyCode::Esc.into())),
            [ESC, c] if c.is_ascii() => alt(char::from(c)),
            _ => None,
        };
        self.events.extend(event);
        self.held.clear();
    }

    /// Takes a byte of a paste; `held` contains a possible beginning of the end sequence.
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

/// The keys of these bytes if all are Space, Ctrl-C or Ctrl-S; otherwise none. [`KEYS_IN_TEXT`] count anyway.
fn keys_alone(now: Instant, bytes: &[u8]) -> Vec<Event> {
    let mut reader = Reader::new(now);
    let counted = |byte: &&u8| KEYS_IN_TEXT.contains(byte);
    for &byte in bytes.iter().filter(|byte| !counted(byte)) {
        reader.take(byte);
    }
    let is_one = |event: &Event| {
        matches!(event, Event::Key(key) if match key.code {
            KeyCode::Char(' ') => true,
            KeyCode::Char('c' | 's') => key.modifiers.contains(KeyModifiers::CONTROL),
            _ => false,
        })
    };
    let are_alone = reader.held.is_empty() && reader.events.iter().all(is_one);
    reader.events.retain(|_| are_alone);
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
        // Esc and Ctrl-C that arrive together, not Alt and Ctrl-C.
        [ESC, key] if KEYS_IN_TEXT.contains(&key) => Sequence::Broken,
        // End of a string.
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

/// Reads a click in the old encoding: button, column and row, one byte each.
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
