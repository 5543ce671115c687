//! Samples of a value over a whole session in bounded memory, evenly spaced; the spacing grows.

use crate::event::Moment;

const SAMPLES_MAX: usize = 128;

/// Spacing at the beginning of a session.
const FIRST_SPACING: Moment = Moment::from_secs(2);

/// Samples of one value, oldest first, `spacing` apart. When the memory is full, every other
/// sample is dropped and the spacing doubles.
#[derive(Clone, Debug)]
pub(crate) struct History {
    samples: Vec<u16>,
    spacing: Moment,
    newest_at: Option<Moment>,
}

impl Default for History {
    fn default() -> Self {
        Self {
            samples: Vec::new(),
            spacing: FIRST_SPACING,
            newest_at: None,
        }
    }
}

impl History {
    /// Takes a sample, unless the newest is younger than the spacing.
    pub(super) fn push(&mut self, now: Moment, value: u16) {
        if self
            .newest_at
            .is_some_and(|at| now.saturating_sub(at) < self.spacing)
        {
            return;
        }
        if self.samples.len() == SAMPLES_MAX {
            let mut keep = false;
            self.samples.retain(|_| {
                keep = !keep;
                keep
            });
            self.spacing *= 2;
        }
        self.newest_at = Some(now);
        self.samples.push(value);
    }

    /// All samples, oldest first.
    pub(crate) fn samples(&self) -> &[u16] {
        &self.samples
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_session_takes_no_more_room_than_a_short_one() {
        let mut history = History::default();
        for s in 0..100_000_u32 {
            history.push(Moment::from_secs(u64::from(s)), (s / 1000) as u16);
        }
        let samples = history.samples();
        assert!((SAMPLES_MAX / 2..=SAMPLES_MAX).contains(&samples.len()));
        assert_eq!(samples[0], 0);
        assert!(samples.is_sorted());
        assert!(samples[samples.len() - 1] > 95, "the newest is there");
    }
}
