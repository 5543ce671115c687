//! What somebody who mistyped a word may have meant.

use std::fmt::Display;

/// The known word that is nearest to one that is not known; `None` when none is near.
#[must_use]
pub fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    // One slip in a short word, two from six letters on.
    let slips_max = if word.chars().count() < 6 { 1 } else { 2 };
    known
        .into_iter()
        .map(|candidate| (strsim::osa_distance(word, candidate), candidate))
        .filter(|(slips, _)| *slips <= slips_max)
        .min_by_key(|(slips, _)| *slips)
        .map(|(_, candidate)| candidate)
}

/// `; did you mean `WORD`?`, or nothing.
#[must_use]
pub fn question<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    nearest(word, known).map_or(String::new(), |known| format!("; did you mean `{known}`?"))
}

/// `; did you mean `WORD`?`, or else what there is.
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
    fn what_is_near_is_suggested_and_nothing_else() {
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
