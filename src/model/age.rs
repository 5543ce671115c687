//! Ages in words: by the second at first, by ten seconds from a minute on.

use crate::event::Moment;

const COARSE_AFTER_S: u64 = 60;
const COARSE_STEP_S: u64 = 10;

/// An age in words.
pub(crate) fn words(age: Moment) -> String {
    match told_s(age) {
        0 => "<1 s".to_owned(),
        s @ 1..60 => format!("{s} s"),
        s @ 60..3600 => format!("{} m {:02} s", s / 60, s % 60),
        s => format!("{} h {:02} m", s / 3600, s / 60 % 60),
    }
}

fn told_s(age: Moment) -> u64 {
    let s = age.as_secs();
    if s < COARSE_AFTER_S {
        s
    } else {
        s / COARSE_STEP_S * COARSE_STEP_S
    }
}

/// The next moment after `now` when the words for the age of `since` change.
pub(super) fn next_change(since: Moment, now: Moment) -> Moment {
    let s = now.saturating_sub(since).as_secs();
    let step_s = if s < COARSE_AFTER_S { 1 } else { COARSE_STEP_S };
    since + Moment::from_secs(s / step_s * step_s + step_s)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_age_changes_when_its_words_do_and_not_before() {
        let since = Moment::from_millis(1700);
        let shown = |now: Moment| words(now.saturating_sub(since));
        let mut now = since;
        for _ in 0..120 {
            let next = next_change(since, now);
            assert!(next > now);
            let just_before = next.saturating_sub(Moment::from_millis(1));
            assert_eq!(shown(now), shown(just_before));
            assert_ne!(shown(now), shown(next));
            now = next;
        }
        assert_eq!(
            shown(now),
            "11 m 00 s",
            "a minute by the second, then by ten"
        );
    }
}
