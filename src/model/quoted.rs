//! A line in words: a name with blanks stands in quotes.

/// The words of a line. A quote begins where a word does and ends it: apostrophes within words are none.
///
/// # Errors
/// When a quote is not closed.
pub(super) fn words(line: &str) -> Result<Vec<String>, String> {
    let mut words = Vec::new();
    let mut rest = line.trim_start();
    while let Some(first) = rest.chars().next() {
        let (word, after) = if matches!(first, '"' | '\'') {
            let quoted = &rest[1..];
            quoted
                .split_once(first)
                .ok_or_else(|| format!("the quote before `{quoted}` is not closed"))?
        } else {
            rest.split_once(char::is_whitespace).unwrap_or((rest, ""))
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
}
