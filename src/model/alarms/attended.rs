//! The operator's answers to alarms: acknowledged or shelved.

use super::Alarms;
use crate::event::Moment;

/// The operator's answer to each alarm, by its index in the table.
#[derive(Clone, Debug, Default)]
pub(crate) struct Attended(Vec<Attention>);

/// The operator's answer to one alarm.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Attention {
    /// Time of the acknowledgement, or a later one; it applies to an alarm raised before.
    pub(super) acknowledged_at: Option<Moment>,
    /// Number of times the alarm had been raised at the acknowledgement.
    pub(super) times: u32,
    /// Time until which the alarm is shelved.
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

    /// Acknowledges an alarm that is raised until a moment.
    pub(in crate::model) fn acknowledge(&mut self, until: Moment, alarms: &Alarms, index: usize) {
        let standing = alarms.standings.get(index);
        let episode = standing.and_then(|standing| standing.episode);
        if let Some(attention) = self.at(alarms, index) {
            attention.acknowledged_at = Some(until);
            attention.times = episode.map_or(0, |episode| episode.times);
        }
    }

    /// Shelves an alarm until a moment, or unshelves it.
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

    /// Time at which the shelving of the next alarm ends.
    pub(in crate::model) fn next_expiry(&self) -> Option<Moment> {
        let shelved = self
            .0
            .iter()
            .filter_map(|attention| attention.shelved_until);
        shelved.min()
    }

    /// Unshelves alarms whose time is over.
    pub(in crate::model) fn expire(&mut self, now: Moment) {
        for attention in &mut self.0 {
            attention.shelved_until.take_if(|until| *until <= now);
        }
    }
}
