//! Gaps: places between two intact lines where lines were lost or damaged, or the link was interrupted. Summaries and pictures count
//! them here, so they agree.

use std::collections::VecDeque;

use groundwave_protocol::decoder::{Counters, Received};

use crate::event::Moment;
use crate::outages::Likelihood;

/// Maximum number of gaps that may still close: a late line or a restart shows that no line was lost.
const OPEN_MAX: usize = 16;

/// A gap that may still close.
#[derive(Clone, Copy, Debug)]
struct Open {
    /// Number of the line after the gap.
    line: u64,
    /// Number of lines lost; `None` if the link was interrupted.
    lost: Option<u64>,
}

/// Counts gaps.
#[derive(Clone, Debug, Default)]
pub(crate) struct Gaps {
    has_begun: bool,
    is_interrupted: bool,
    before: Counters,
    open: VecDeque<Open>,
    settled: u64,
    /// Time at which the latest line arrived.
    at: Moment,
    /// The pause since the latest line C in which the loss of hundreds of lines is most likely, and the line after the pause; `None`
    /// if the pause is already a gap.
    likeliest: Option<(Likelihood, Option<u64>)>,
}

impl Gaps {
    /// Takes an interruption of the link. It counts as a gap if lines came before and after it.
    pub(crate) const fn interrupt(&mut self) {
        self.is_interrupted = self.has_begun;
    }

    /// Takes an intact line and the decoder's counts after it; returns the line after a gap that can no longer close.
    pub(crate) fn take_line(
        &mut self,
        at: Moment,
        received: &Received,
        counters: &Counters,
    ) -> Option<u64> {
        let lines = counters.intact();
        let (before, now) = (self.before.lines_lost, counters.lines_lost);
        if let Some(found) = before.checked_sub(now).filter(|found| *found > 0) {
            self.close(found, counters.restarts > self.before.restarts);
        }
        let lost = now.checked_sub(before).filter(|lost| *lost > 0);
        let is_interrupted = std::mem::take(&mut self.is_interrupted);
        let is_after_boot = counters.restarts > self.before.restarts
            && counters.hidden.max > self.before.hidden.max;
        let is_replaced = self.before.replaced_robot != counters.replaced_robot;
        if is_interrupted || lost.is_some() || is_after_boot || is_replaced {
            let lost = lost.filter(|_| !is_interrupted);
            self.open.push_back(Open { line: lines, lost });
        }
        let pause = at.saturating_sub(self.at);
        let likelihood = Likelihood::of(pause, lost.unwrap_or_default());
        if self.has_begun && self.likeliest.is_none_or(|(it, _)| likelihood > it) {
            let is_gap = self.open.back().is_some_and(|gap| gap.line == lines);
            self.likeliest = Some((likelihood, (!is_gap).then_some(lines)));
        }
        if received.uptime_s().is_some() {
            let hidden = counters.hidden.max > self.before.hidden.max;
            let place = self.likeliest.take().and_then(|(_, line)| line);
            // Whole hundreds of lines, which the sequence does not show, were lost there.
            if let Some(line) = place.filter(|_| hidden) {
                let place = self.open.partition_point(|gap| gap.line < line);
                self.open.insert(place, Open { line, lost: None });
            }
        }
        self.at = at;
        self.has_begun = true;
        self.before = *counters;
        if self.open.len() > OPEN_MAX {
            return self.settle();
        }
        None
    }

    /// Removes the oldest open gap; returns the line after it.
    pub(crate) fn settle(&mut self) -> Option<u64> {
        let gap = self.open.pop_front()?;
        self.settled += 1;
        Some(gap.line)
    }

    /// Number of gaps so far.
    pub(crate) fn count(&self) -> u64 {
        self.settled + self.open.len() as u64
    }

    /// Closes gaps whose lines were not lost: a line was late, or a restart explains the whole gap.
    fn close(&mut self, found: u64, is_restart: bool) {
        let fits = |gap: &Open| {
            gap.lost
                .is_some_and(|lost| lost == found || !is_restart && lost > found)
        };
        let Some(index) = self.open.iter().rposition(fits) else {
            return;
        };
        match &mut self.open[index].lost {
            Some(lost) if *lost > found => *lost -= found,
            _ => drop(self.open.remove(index)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use groundwave_protocol::decoder::Decoder;

    /// Number of gaps after lines with these totals of lost lines and restarts.
    fn count(totals: &[(u64, u64)]) -> u64 {
        let mut gaps = Gaps::default();
        let line = line('A');
        for (number, &(lines_lost, restarts)) in totals.iter().enumerate() {
            let counters = Counters {
                lines: number as u64 + 1,
                lines_lost,
                restarts,
                ..Counters::default()
            };
            gaps.take_line(Moment::ZERO, &line, &counters);
        }
        gaps.count()
    }

    /// A line of this type.
    fn line(letter: char) -> Received {
        let mut decoder = Decoder::default();
        let sample = include_bytes!("../house-clean.txt");
        let mut lines = decoder.lines(sample);
        let is_wanted =
            |line: &Received| matches!(line, Received::Line(_, raw) if raw[0] == letter as u8);
        lines.find(is_wanted).unwrap()
    }

    /// The gaps of five lines: C, three lines A, and a line C that reports a hundred more lost lines. Each line is given by its second
    /// and the number of lines lost in the sequence so far.
    fn before_line_c(lines: [(u64, u64); 5]) -> Gaps {
        let mut gaps = Gaps::default();
        let mut counters = Counters::default();
        for ((at_s, lost), letter) in lines.into_iter().zip("CAAAC".chars()) {
            counters.lines += 1;
            counters.lines_lost = lost;
            if counters.lines == 5 {
                (counters.hidden.min, counters.hidden.max) = (100, 100);
            }
            gaps.take_line(Moment::from_secs(at_s), &line(letter), &counters);
        }
        gaps
    }

    #[test]
    fn hidden_lines_are_a_gap_in_the_longest_pause() {
        for lost in [0, 2] {
            let mut gaps = before_line_c([(0, 0), (1, 0), (40, lost), (41, lost), (42, lost)]);
            assert_eq!(gaps.count(), 1, "{lost} lines lost in the sequence");
            assert_eq!(gaps.settle(), Some(3), "the line after the pause");
        }
    }

    #[test]
    fn hidden_lines_without_times_are_in_the_gap_of_the_sequence() {
        let mut gaps = before_line_c([(0, 0), (1, 0), (2, 65), (3, 65), (4, 65)]);
        assert_eq!(gaps.count(), 1);
        assert_eq!(gaps.settle(), Some(3), "the line after the gap");
    }

    #[test]
    fn a_gap_is_counted_once_however_many_lines_it_has() {
        assert_eq!(count(&[(0, 0), (0, 0), (7, 0), (7, 0), (8, 0)]), 2);
        let many: Vec<_> = (0..100).map(|lost| (lost, 0)).collect();
        assert_eq!(count(&many), 99);
    }

    #[test]
    fn late_lines_and_a_restart_close_gaps() {
        assert_eq!(count(&[(0, 0), (2, 0), (1, 0)]), 1);
        assert_eq!(count(&[(0, 0), (2, 0), (1, 0), (0, 0)]), 0);
        assert_eq!(count(&[(0, 0), (40, 0), (41, 0), (1, 1)]), 1);
    }

    #[test]
    fn an_interruption_between_lines_is_a_gap() {
        let mut gaps = Gaps::default();
        let mut counters = Counters::default();
        gaps.interrupt();
        for expected in [0, 1] {
            counters.lines += 1;
            gaps.take_line(Moment::ZERO, &line('A'), &counters);
            assert_eq!(gaps.count(), expected);
            gaps.interrupt();
        }
        assert_eq!(gaps.count(), 1, "nothing follows the last one");
    }
}
