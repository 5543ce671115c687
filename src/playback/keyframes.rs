//! Keyframes: kept states, evenly spaced over any length of time, in bounded memory.

use std::collections::VecDeque;

use crate::event::Moment;

/// Maximum number of keyframes. Each has up to 300 KB of its own (plots, log, map, readings of the floor), and a replay has 64 MiB.
const FRAMES_MAX: usize = 96;

/// Frames in order of time, `spacing` apart. When the memory is full, every other frame
/// is dropped and the spacing doubles.
#[derive(Clone, Debug)]
pub struct Keyframes<T> {
    frames: VecDeque<(Moment, T)>,
    spacing: Moment,
}

impl<T> Keyframes<T> {
    /// An empty collection with an initial spacing.
    #[must_use]
    pub const fn new(spacing: Moment) -> Self {
        Self {
            frames: VecDeque::new(),
            spacing,
        }
    }

    /// Whether a frame is due at a moment.
    #[must_use]
    pub fn wants(&self, at: Moment) -> bool {
        let newest = self.frames.back();
        newest.is_none_or(|(newest, _)| at.saturating_sub(*newest) >= self.spacing)
    }

    /// Adds a frame; replaces a frame of the same moment. A frame older than another is ignored.
    pub fn push(&mut self, at: Moment, frame: T) {
        match self.frames.back_mut() {
            Some((newest, _)) if *newest > at => return,
            Some((newest, kept)) if *newest == at => {
                *kept = frame;
                return;
            }
            _ => {}
        }
        if self.frames.len() == FRAMES_MAX {
            let mut keep = false;
            self.frames.retain(|_| {
                keep = !keep;
                keep
            });
            self.spacing *= 2;
            // With the doubled spacing, this frame may be too early.
            if !self.wants(at) {
                return;
            }
        }
        self.frames.push_back((at, frame));
    }

    /// Index of the newest frame not after a moment.
    #[must_use]
    pub fn before(&self, at: Moment) -> Option<usize> {
        self.frames
            .partition_point(|(frame, _)| *frame <= at)
            .checked_sub(1)
    }

    /// Index of the newest frame for which `holds` is true; it must also be true for all earlier frames.
    #[must_use]
    pub fn last_where(&self, holds: impl Fn(&T) -> bool) -> Option<usize> {
        self.frames
            .partition_point(|(_, frame)| holds(frame))
            .checked_sub(1)
    }

    /// The frame with an index, oldest first.
    #[must_use]
    pub fn get(&self, place: usize) -> Option<&(Moment, T)> {
        self.frames.get(place)
    }

    /// Number of frames.
    #[must_use]
    pub fn len(&self) -> usize {
        self.frames.len()
    }

    /// Whether there are no frames.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.frames.is_empty()
    }

    /// Drops the oldest frame unless it is the only one.
    pub fn forget_oldest(&mut self) {
        if self.frames.len() > 1 {
            self.frames.pop_front();
        }
    }

    /// Drops frames that are not needed to reach `at` or later; returns whether any was dropped.
    pub fn forget_before(&mut self, at: Moment) -> bool {
        let mut has_gone = false;
        while self.frames.get(1).is_some_and(|(second, _)| *second <= at) {
            self.frames.pop_front();
            has_gone = true;
        }
        has_gone
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_month_takes_no_more_room_than_an_hour() {
        let mut frames = Keyframes::new(Moment::from_secs(20));
        for s in 0..30 * 86_400 {
            let at = Moment::from_secs(s);
            if frames.wants(at) {
                frames.push(at, s);
            }
            assert!(frames.len() <= FRAMES_MAX);
        }
        assert!(frames.len() >= FRAMES_MAX / 2);
        assert_eq!(frames.get(0).map(|(_, s)| *s), Some(0));
        let spacing = frames.spacing;
        for place in 1..frames.len() {
            let at = |place| frames.get(place).unwrap().0;
            assert_eq!(at(place).checked_sub(at(place - 1)).unwrap(), spacing);
        }
    }

    #[test]
    fn the_nearest_earlier_one_is_found() {
        let mut frames = Keyframes::new(Moment::from_secs(1));
        assert_eq!(frames.before(Moment::MAX), None);
        for s in [2, 4, 6] {
            frames.push(Moment::from_secs(s), s);
        }
        for (s, place) in [
            (1, None),
            (2, Some(0)),
            (3, Some(0)),
            (6, Some(2)),
            (9, Some(2)),
        ] {
            assert_eq!(frames.before(Moment::from_secs(s)), place, "{s}");
        }
        assert_eq!(frames.last_where(|s| *s < 5), Some(1));
        assert!(frames.forget_before(Moment::from_secs(5)));
        assert_eq!(
            frames.get(0).map(|(_, s)| *s),
            Some(4),
            "one is left before it"
        );
        assert!(!frames.forget_before(Moment::from_secs(5)));
    }
}
