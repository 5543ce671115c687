//! Suggestions for mistyped words.

use std::fmt::Display;

/// Maximum length of a word for which a suggestion is looked for, bytes; comparing longer ones takes time and finds nothing.
const WORD_BYTES_MAX: usize = 64;

/// The known word most similar to `word`; `None` if none is similar.
#[must_use]
pub fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    if word.len() > WORD_BYTES_MAX {
        return None;
    }
    // One edit is allowed in a short word, two in a word of six letters or more.
    let edits_max = if word.chars().count() < 6 { 1 } else { 2 };
    known
        .into_iter()
        .map(|candidate| (strsim::osa_distance(word, candidate), candidate))
        .filter(|(edits, _)| *edits <= edits_max)
        .min_by_key(|(edits, _)| *edits)
        .map(|(_, candidate)| candidate)
}

/// A suggestion for a mistyped word, `; did you mean `WORD`?`, or an empty text.
#[must_use]
pub fn question<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    nearest(word, known).map_or(String::new(), |known| format!("; did you mean `{known}`?"))
}

/// A suggestion for a mistyped word, `; did you mean `WORD`?`, or `; ` and the list `all`.
pub(crate) fn question_or<'a>(
    word: &str,
    known: impl IntoIterator<Item = &'a str>,
    all: impl Display,
) -> String {
    nearest(word, known).map_or_else(
        || format!("; {all}"),
        |known| format!("; did you mean `{known}`?"),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_similar_words_are_suggested() {
        let known = ["radio", "baud", "latency_ms"];
        assert_eq!(nearest("radoi", known), Some("radio"));
        assert_eq!(nearest("latencyms", known), Some("latency_ms"));
        assert_eq!(nearest("bud", known), Some("baud"));
        assert_eq!(nearest("", known), None);
        assert_eq!(nearest("colour", known), None);
        assert_eq!(question("radoi", known), "; did you mean `radio`?");
        assert_eq!(question("theme", known), "");
        assert_eq!(question_or("theme", known, "there are 3"), "; there are 3");
    }
}
