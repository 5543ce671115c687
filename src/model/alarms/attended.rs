//! What the operator did about alarms: acknowledged or shelved.

use super::Alarms;
use crate::event::Moment;

/// What the operator did about each alarm, by its place in the table.
#[derive(Clone, Debug, Default)]
pub(crate) struct Attended(Vec<Attention>);

/// What the operator did about one alarm.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Attention {
    /// It is acknowledged if it was raised until then.
    pub(super) acknowledged_at: Option<Moment>,
    /// How often it had been raised then.
    pub(super) times: u32,
    /// It does not call until then.
    pub(super) shelved_until: Option<Moment>,
}

impl Attended {
    pub(super) fn of(&self, index: usize) -> Attention {
        self.0.get(index).copied().unwrap_or_default()
    }

    fn at(&mut self, alarms: &Alarms, index: usize) -> Option<&mut Attention> {
        self.0
            .resize_with(alarms.standings.len(), Attention::default);
        self.0.get_mut(index)
    }

    /// Acknowledges an alarm that was raised until `now`.
    pub(in crate::model) fn acknowledge(&mut self, now: Moment, alarms: &Alarms, index: usize) {
        let standing = alarms.standings.get(index);
        let episode = standing.and_then(|standing| standing.episode);
        if let Some(attention) = self.at(alarms, index) {
            attention.acknowledged_at = Some(now);
            attention.times = episode.map_or(0, |episode| episode.times);
        }
    }

    /// Shelves an alarm until a moment, or takes it from the shelf.
    pub(in crate::model) fn shelve(
        &mut self,
        alarms: &Alarms,
        index: usize,
        until: Option<Moment>,
    ) {
        if let Some(attention) = self.at(alarms, index) {
            attention.shelved_until = until;
        }
    }

    /// When the next alarm leaves the shelf.
    pub(in crate::model) fn next_expiry(&self) -> Option<Moment> {
        let shelved = self
            .0
            .iter()
            .filter_map(|attention| attention.shelved_until);
        shelved.min()
    }

    /// Takes alarms whose time is over from the shelf; returns their places.
    pub(in crate::model) fn expire(&mut self, now: Moment) -> Vec<usize> {
        let mut expired = Vec::new();
        for (index, attention) in self.0.iter_mut().enumerate() {
            if attention.shelved_until.is_some_and(|until| until <= now) {
                attention.shelved_until = None;
                expired.push(index);
            }
        }
        expired
    }
}
