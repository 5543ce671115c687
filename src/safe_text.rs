//! Makes text from outside safe to show: no character controls the terminal, reorders the surrounding text or begins another line.

use std::borrow::Cow;
use std::fmt::{self, Write as _};
use std::io::{self, Write};

/// Whether a character controls a terminal (C0, DEL, C1), breaks a line or changes the direction of text.
#[must_use]
pub fn is_control(character: char) -> bool {
    character.is_control()
        || matches!(
            character,
            '\u{61C}' | '\u{200E}' | '\u{200F}' | '\u{2028}'..='\u{202E}' | '\u{2066}'..='\u{2069}'
        )
}

/// The text as one line, with control characters escaped as in JSON: `\n`, `\u001b`.
#[must_use]
pub fn line(text: &str) -> Cow<'_, str> {
    escape(text, is_control)
}

/// The text with its line feeds and tabs, and with other control characters escaped.
fn lines(text: &str) -> Cow<'_, str> {
    escape(text, |character| {
        is_control(character) && !matches!(character, '\n' | '\t')
    })
}

fn escape(text: &str, is_escaped: impl Fn(char) -> bool) -> Cow<'_, str> {
    if !text.contains(&is_escaped) {
        return Cow::Borrowed(text);
    }
    let mut escaped = String::with_capacity(text.len() + 8);
    for character in text.chars() {
        match character {
            '\n' if is_escaped('\n') => escaped.push_str("\\n"),
            _ if is_escaped(character) => {
                // Writing to a string cannot fail.
                let _ = write!(escaped, "\\u{:04x}", u32::from(character));
            }
            _ => escaped.push(character),
        }
    }
    Cow::Owned(escaped)
}

/// A writer of text for users. Each `writeln!` is one line: a line feed in a value is escaped, like every other control character.
/// `write_all` takes whole lines, and keeps their line feeds and tabs.
pub struct SafeWriter<W>(pub W);

impl<W: Write> Write for SafeWriter<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let text = String::from_utf8_lossy(bytes);
        self.0.write_all(lines(&text).as_bytes())?;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }

    fn write_fmt(&mut self, arguments: fmt::Arguments<'_>) -> io::Result<()> {
        let text = arguments.to_string();
        let (text, end) = match text.strip_suffix('\n') {
            Some(text) => (text, "\n"),
            None => (&*text, ""),
        };
        self.0.write_all(format!("{}{end}", line(text)).as_bytes())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_value_stays_on_its_line_whatever_is_in_it(value in any::<String>()) {
            let mut out = SafeWriter(Vec::new());
            writeln!(out, "name  {value}.").unwrap();
            let text = String::from_utf8(out.0).unwrap();
            prop_assert_eq!(text.matches(is_control).collect::<String>(), "\n");
            prop_assert!(text.ends_with(".\n"));
            prop_assert_eq!(line(&text[..text.len() - 1]), &text[..text.len() - 1]);
        }

        #[test]
        fn escaped_json_means_the_same(value in any::<String>()) {
            let mut out = SafeWriter(Vec::new());
            serde_json::to_writer(&mut out, &value).unwrap();
            let text = String::from_utf8(out.0).unwrap();
            prop_assert!(!text.contains(is_control), "{text:?}");
            prop_assert_eq!(serde_json::from_str::<String>(&text).unwrap(), value);
        }
    }

    #[test]
    fn controls_are_named() {
        for (text, shown) in [
            ("Straße, 東京 \\n", "Straße, 東京 \\n"),
            ("a\nb\tc", "a\\nb\\u0009c"),
            ("\x1b[2J\x7f\u{9b}1m", "\\u001b[2J\\u007f\\u009b1m"),
            (
                "\u{202e}txt.\u{2066}\u{61c}\u{200f}",
                "\\u202etxt.\\u2066\\u061c\\u200f",
            ),
        ] {
            assert_eq!(line(text), shown);
        }
        assert_eq!(lines("a\n\tb\r\x07"), "a\n\tb\\u000d\\u0007");
    }
}
