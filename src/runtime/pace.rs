//! The limit of frames per second.

use std::time::Duration;

use crate::event::Moment;

/// Time in which at most two frames are drawn. Several changes are drawn at their start and their end, and a line right after a key does
/// not have to wait.
const STRETCH: Duration = Duration::from_millis(80);

/// Times of the latest two frames.
#[derive(Debug, Default)]
pub(super) struct Pace {
    last: Option<Moment>,
    before: Option<Moment>,
}

impl Pace {
    /// Earliest time of the next frame.
    pub(super) fn earliest(&self) -> Moment {
        self.before.map_or(Moment::ZERO, |at| at + STRETCH)
    }

    /// Records the time of a frame.
    pub(super) fn drew(&mut self, now: Moment) {
        self.before = self.last.replace(now);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stretch_has_two_frames_and_no_third() {
        let mut pace = Pace::default();
        let mut drawn: Vec<Moment> = Vec::new();
        for ms in 0..1000 {
            let now = Moment::from_millis(ms);
            if pace.earliest() <= now {
                pace.drew(now);
                drawn.push(now);
            }
        }
        assert_eq!(drawn[1], Moment::from_millis(1));
        assert!(drawn.windows(3).all(|three| three[0] + STRETCH <= three[2]));
        assert_eq!(drawn.len(), 26);
        // After a pause, two frames may follow each other at once.
        for ms in [5000, 5003] {
            let now = Moment::from_millis(ms);
            assert!(pace.earliest() <= now);
            pace.drew(now);
        }
        assert_eq!(pace.earliest(), Moment::from_millis(5080));
    }
}
