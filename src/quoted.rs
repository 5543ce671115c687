//! A line in words: a name with blanks stands in quotes.

/// The words of a line. A quote begins where a word does and ends it: apostrophes within words are none.
///
/// # Errors
/// When a quote is not closed.
pub fn words(line: &str) -> Result<Vec<String>, String> {
    words_before(line, None)
}

/// The words of a line of a script, in which a remark begins with `#`, but not within quotes.
///
/// # Errors
/// When a quote is not closed.
pub fn words_of_script(line: &str) -> Result<Vec<String>, String> {
    words_before(line, Some('#'))
}

/// A text without the quotes around the whole of it.
pub fn unquoted(text: &str) -> String {
    match words(text).as_deref() {
        Ok([word]) => word.clone(),
        _ => text.to_owned(),
    }
}

fn words_before(line: &str, remark: Option<char>) -> Result<Vec<String>, String> {
    let mut words = Vec::new();
    let mut rest = line.trim_start();
    while let Some(first) = rest.chars().next().filter(|c| Some(*c) != remark) {
        let (word, after) = if matches!(first, '"' | '\'') {
            let quoted = &rest[1..];
            quoted
                .split_once(first)
                .ok_or_else(|| format!("the quote before `{quoted}` is not closed"))?
        } else {
            let end = rest.find(|c: char| c.is_whitespace() || Some(c) == remark);
            rest.split_at(end.unwrap_or(rest.len()))
        };
        words.push(word.to_owned());
        rest = after.trim_start();
    }
    Ok(words)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blanks_part_words_but_for_those_in_quotes() {
        for (line, wanted) in [
            ("", &[][..]),
            ("  a  b ", &["a", "b"]),
            (
                "compare \"a b.mcap\" 'c  d'",
                &["compare", "a b.mcap", "c  d"],
            ),
            ("runs \"the cat's\"", &["runs", "the cat's"]),
            ("the cat's 5\" wheel", &["the", "cat's", "5\"", "wheel"]),
            ("''", &[""]),
        ] {
            assert_eq!(
                words(line).as_deref(),
                Ok(&wanted.iter().map(|it| (*it).to_owned()).collect::<Vec<_>>()[..]),
                "{line}"
            );
        }
        assert!(words("runs 'a b").is_err());
        assert!(words("\"").is_err());
    }

    #[test]
    fn a_remark_begins_outside_of_quotes() {
        for (line, wanted) in [
            ("# the cat's", &[][..]),
            ("stop # the cat's", &["stop"]),
            ("stop#now", &["stop"]),
            ("route 'a #1.csv'# it's", &["route", "a #1.csv"]),
        ] {
            let words = words_of_script(line).expect("quotes are closed");
            assert_eq!(words, wanted, "{line}");
        }
        assert_eq!(words("a #1").as_deref().map(<[_]>::len), Ok(2));
    }

    #[test]
    fn quotes_around_the_whole_are_left_out() {
        for (text, wanted) in [
            ("\"a, b\"", "a, b"),
            ("a  b", "a  b"),
            ("'a' and 'b'", "'a' and 'b'"),
            ("'tis so", "'tis so"),
        ] {
            assert_eq!(unquoted(text), wanted);
        }
    }
}
