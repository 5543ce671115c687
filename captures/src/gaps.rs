//! Gaps: places between two intact lines where lines were lost or damaged, or the link was interrupted. Summaries and pictures count
//! them here, so they agree.

use std::collections::VecDeque;

use groundwave_protocol::decoder::Counters;

/// Number of newest gaps that may still close: a late line or a restart shows that nothing was lost.
const OPEN_MAX: usize = 16;

/// A gap that may still close.
#[derive(Clone, Copy, Debug)]
struct Open {
    /// Number of the line after it.
    line: u64,
    /// Lines lost; `None` if the link was interrupted.
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
}

impl Gaps {
    /// Takes an interruption of the link. It is a gap if lines came before it and lines follow.
    pub(crate) const fn interrupt(&mut self) {
        self.is_interrupted = self.has_begun;
    }

    /// Takes the decoder's counts after an intact line; returns the line after a gap that no longer closes.
    pub(crate) fn take_line(&mut self, counters: &Counters) -> Option<u64> {
        let lines = counters.intact();
        let (before, now) = (self.before.lines_lost, counters.lines_lost);
        if let Some(found) = before.checked_sub(now).filter(|found| *found > 0) {
            self.close(found, counters.restarts > self.before.restarts);
        }
        let lost = now.checked_sub(before).filter(|lost| *lost > 0);
        let is_interrupted = std::mem::take(&mut self.is_interrupted);
        if is_interrupted || lost.is_some() {
            let lost = lost.filter(|_| !is_interrupted);
            self.open.push_back(Open { line: lines, lost });
        }
        self.has_begun = true;
        self.before = *counters;
        if self.open.len() > OPEN_MAX {
            return self.settle();
        }
        None
    }

    /// The line after the oldest gap that could have closed.
    pub(crate) fn settle(&mut self) -> Option<u64> {
        let gap = self.open.pop_front()?;
        self.settled += 1;
        Some(gap.line)
    }

    /// Number of gaps so far.
    pub(crate) fn count(&self) -> u64 {
        self.settled + self.open.len() as u64
    }

    /// Lines counted as lost were not: one was late, or a restart explains all of one gap.
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

    /// Number of gaps after lines with these totals of lost lines and restarts.
    fn count(totals: &[(u64, u64)]) -> u64 {
        let mut gaps = Gaps::default();
        for (number, &(lines_lost, restarts)) in totals.iter().enumerate() {
            gaps.take_line(&Counters {
                lines: number as u64 + 1,
                lines_lost,
                restarts,
                ..Counters::default()
            });
        }
        gaps.count()
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
            gaps.take_line(&counters);
            assert_eq!(gaps.count(), expected);
            gaps.interrupt();
        }
        assert_eq!(gaps.count(), 1, "nothing follows the last one");
    }
}
