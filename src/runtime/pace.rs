//! How often the screen is drawn.

use std::time::Duration;

use crate::event::Moment;

/// No more than two frames in any stretch of this length: a burst of bytes is drawn at its beginning and at its end, and
/// a line that comes just after something else was drawn, a key or an age, need not wait.
const STRETCH: Duration = Duration::from_millis(80);

/// When frames were drawn.
#[derive(Debug, Default)]
pub(super) struct Pace {
    last: Option<Moment>,
    before: Option<Moment>,
}

impl Pace {
    /// From when on a frame may be drawn.
    pub(super) fn earliest(&self) -> Moment {
        self.before.map_or(Moment::ZERO, |at| at + STRETCH)
    }

    /// One was drawn.
    pub(super) fn drew(&mut self, now: Moment) {
        self.before = self.last.replace(now);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whatever wants to be drawn whenever: never three frames in a stretch, and the second one at once.
    #[test]
    fn two_frames_in_a_stretch_and_no_third() {
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
        // A line after a pause, and another thing just before it: both at once.
        for ms in [5000, 5003] {
            let now = Moment::from_millis(ms);
            assert!(pace.earliest() <= now);
            pace.drew(now);
        }
        assert_eq!(pace.earliest(), Moment::from_millis(5080));
    }
}
