//! What the robot does by itself when the ground falls silent.

use crate::board::TICK_HZ;
use groundwave_protocol::failsafe::Failsafe;
use groundwave_protocol::letters::{Link, Mode};

/// Counts the ground's silence. It concerns a robot only while a station has a session open: who was
/// never commanded, or was stopped, is left alone.
#[derive(Clone, Debug, Default)]
pub struct Guard {
    setting: Option<Failsafe>,
    silence_ticks: u32,
    acts: bool,
}

impl Guard {
    /// What it was told to do.
    #[must_use]
    pub const fn setting(&self) -> Option<Failsafe> {
        self.setting
    }

    /// Tells it what to do from now on.
    pub const fn set(&mut self, setting: Option<Failsafe>) {
        self.setting = setting;
    }

    /// The ground said something intact.
    pub const fn hear(&mut self) {
        self.silence_ticks = 0;
    }

    /// The operator has taken over again, by a mode or by STOP. Returns whether it had acted.
    pub const fn rearm(&mut self) -> bool {
        core::mem::replace(&mut self.acts, false)
    }

    /// Lets a tick pass; returns the mode to enter when the silence has become too long. A robot that
    /// stands in stop has nothing to be saved from, and must never be moved out of it.
    pub fn tick(&mut self, is_open: bool, mode: Mode) -> Option<Mode> {
        self.silence_ticks = self.silence_ticks.saturating_add(1);
        let setting = self
            .setting
            .filter(|_| is_open && !self.acts && mode != Mode::Stop)?;
        if self.silence_ticks < u32::from(setting.silence_s) * TICK_HZ {
            return None;
        }
        self.acts = true;
        Some(setting.mode)
    }

    /// Whether it acts now: then nobody drives by hand until the operator has taken over again.
    #[must_use]
    pub const fn acts(&self) -> bool {
        self.acts
    }

    /// What line A says.
    #[must_use]
    pub const fn letter(&self, is_open: bool) -> Link {
        if self.acts {
            Link::Failsafe
        } else if is_open && self.setting.is_some() {
            Link::Armed
        } else {
            Link::Ok
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn guard() -> Guard {
        let mut guard = Guard::default();
        guard.set(Some(Failsafe {
            silence_s: 10,
            mode: Mode::GoHome,
        }));
        guard
    }

    fn acts_after(guard: &mut Guard, is_open: bool, mode: Mode) -> Option<u32> {
        (1..=1000).find(|_| guard.tick(is_open, mode).is_some())
    }

    #[test]
    fn it_acts_once_and_exactly_when_the_silence_is_over() {
        let mut guard = guard();
        assert_eq!(guard.letter(true), Link::Armed);
        assert_eq!(acts_after(&mut guard, true, Mode::Prowl), Some(200));
        assert_eq!(guard.letter(true), Link::Failsafe);
        assert_eq!(acts_after(&mut guard, true, Mode::GoHome), None);
    }

    #[test]
    fn every_word_begins_the_silence_anew() {
        let mut guard = guard();
        for _ in 0..5 {
            for _ in 0..199 {
                assert_eq!(guard.tick(true, Mode::Prowl), None);
            }
            guard.hear();
        }
    }

    #[test]
    fn without_a_session_or_in_stop_or_untold_it_does_nothing() {
        assert_eq!(acts_after(&mut guard(), false, Mode::Prowl), None);
        assert_eq!(acts_after(&mut guard(), true, Mode::Stop), None);
        assert_eq!(acts_after(&mut Guard::default(), true, Mode::Prowl), None);
        assert_eq!(guard().letter(false), Link::Ok);
    }

    #[test]
    fn hearing_the_ground_again_does_not_end_it_but_the_operator_does() {
        let mut guard = guard();
        acts_after(&mut guard, true, Mode::Prowl);
        guard.hear();
        assert_eq!(guard.letter(true), Link::Failsafe);
        assert!(guard.rearm());
        assert_eq!(guard.letter(true), Link::Armed);
        guard.hear();
        assert_eq!(acts_after(&mut guard, true, Mode::Prowl), Some(200));
    }
}
