//! The failsafe: the robot's reaction to a silent ground station.

use crate::board::TICK_HZ;
use groundwave_protocol::failsafe::Failsafe;
use groundwave_protocol::status_codes::{Link, Mode};

/// Counts the ground station's silence. The failsafe acts only while a station has a session open: a robot that was never
/// commanded, or was stopped, does not change.
#[derive(Clone, Debug, Default)]
pub struct Guard {
    setting: Option<Failsafe>,
    silence_ticks: u32,
    acts: bool,
}

impl Guard {
    /// Current setting.
    #[must_use]
    pub const fn setting(&self) -> Option<Failsafe> {
        self.setting
    }

    /// Changes the setting.
    pub const fn set(&mut self, setting: Option<Failsafe>) {
        self.setting = setting;
    }

    /// Handles an intact frame from the ground station.
    pub const fn handle_frame(&mut self) {
        self.silence_ticks = 0;
    }

    /// Handles a mode or STOP command from the operator; returns whether the failsafe had acted.
    pub const fn rearm(&mut self) -> bool {
        core::mem::replace(&mut self.acts, false)
    }

    /// Advances one tick; returns the mode to enter when the silence has lasted too long. Never acts in mode stop,
    /// where the robot is safe.
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

    /// Whether the failsafe has acted: manual driving is blocked until the operator commands again.
    #[must_use]
    pub const fn acts(&self) -> bool {
        self.acts
    }

    /// Link letter of line A.
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
    fn failsafe_acts_once_when_the_silence_limit_is_reached() {
        let mut guard = guard();
        assert_eq!(guard.letter(true), Link::Armed);
        assert_eq!(acts_after(&mut guard, true, Mode::Prowl), Some(200));
        assert_eq!(guard.letter(true), Link::Failsafe);
        assert_eq!(acts_after(&mut guard, true, Mode::GoHome), None);
    }

    #[test]
    fn every_frame_restarts_the_silence() {
        let mut guard = guard();
        for _ in 0..5 {
            for _ in 0..199 {
                assert_eq!(guard.tick(true, Mode::Prowl), None);
            }
            guard.handle_frame();
        }
    }

    #[test]
    fn failsafe_needs_a_session_a_setting_and_a_mode_other_than_stop() {
        assert_eq!(acts_after(&mut guard(), false, Mode::Prowl), None);
        assert_eq!(acts_after(&mut guard(), true, Mode::Stop), None);
        assert_eq!(acts_after(&mut Guard::default(), true, Mode::Prowl), None);
        assert_eq!(guard().letter(false), Link::Ok);
    }

    #[test]
    fn failsafe_ends_by_command_and_not_by_a_frame() {
        let mut guard = guard();
        acts_after(&mut guard, true, Mode::Prowl);
        guard.handle_frame();
        assert_eq!(guard.letter(true), Link::Failsafe);
        assert!(guard.rearm());
        assert_eq!(guard.letter(true), Link::Armed);
        guard.handle_frame();
        assert_eq!(acts_after(&mut guard, true, Mode::Prowl), Some(200));
    }
}
