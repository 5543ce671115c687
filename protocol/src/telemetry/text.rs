//! Line T: text printed by the robot's program.
//!
//! ```text
//! 1-3  5-68                                       70-74 75-78
//! T49  I'm finished with the co-ordinate list     !5:HS ^*"+
//! ```

use super::Printable;
use super::columns::Columns;
use super::fields::{Fields, Read};

/// Maximum number of characters in a line of text.
pub const TEXT_BYTES: usize = 64;

/// Line T.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TextLine(Printable<TEXT_BYTES>);

impl TextLine {
    /// Makes a line from `text`, cut after `TEXT_BYTES`, with `?` for each byte that is not printable ASCII.
    #[must_use]
    pub fn new(text: &str) -> Self {
        Self(Printable::new(text))
    }

    /// Likewise, from bytes in place of a string.
    #[must_use]
    pub fn from_bytes(text: &[u8]) -> Self {
        Self(Printable::from_bytes(text))
    }

    /// The text without its padding.
    #[must_use]
    pub fn as_str(&self) -> &str {
        self.0.as_str()
    }

    pub(super) fn write(&self, columns: &mut Columns) {
        self.0.write(columns, 5);
    }

    pub(super) fn read(line: &mut Fields) -> Read<Self> {
        line.fields(Printable::parse).map(Self)
    }
}

#[cfg(test)]
mod tests {
    use super::super::Body;
    use super::super::testing::{blamed, edits, has_one_form, read_back};
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn printable_text_survives_a_round_trip(text in "[ -~]{0,64}") {
            let line = TextLine::new(&text);
            prop_assert_eq!(read_back(Body::Text(line)), Body::Text(line));
            prop_assert_eq!(line.as_str(), text.trim_end_matches(' '));
        }

        #[test]
        fn any_text_makes_a_readable_line(text in "\\PC*") {
            read_back(Body::Text(TextLine::new(&text)));
        }

        #[test]
        fn readable_lines_have_one_form(edits in edits()) {
            has_one_form(Body::Text(TextLine::new("I'm finished")), &edits);
        }
    }

    #[test]
    fn long_text_is_cut_and_unprintable_bytes_are_replaced() {
        assert_eq!(TextLine::new("a\tb\u{e9}").as_str(), "a?b??");
        let long = "x".repeat(70);
        assert_eq!(TextLine::new(&long).as_str(), &long[..64]);
    }

    #[test]
    fn bad_columns_are_blamed() {
        let body = Body::Text(TextLine::new("good"));
        for (column, character) in [(4, b"x"), (5, b"\t"), (68, b"\x7f"), (69, b"x")] {
            assert_eq!(blamed(body, column, character), Some(column as u8));
        }
        assert_eq!(blamed(body, 30, b"\r"), Some(30));
        assert_eq!(blamed(body, 30, b"\x80"), Some(30));
    }
}
