//! Alarms: raised when a rule has struck for long enough, kept until somebody has seen them.

mod rules;

use super::age;
use crate::event::Moment;
pub(super) use rules::Facts;
pub use rules::Limits;
pub(crate) use rules::{RULES, Rule, Source};
use rules::{RULES_COUNT, SECONDS, Sight};

/// An alarm that was raised and has not been seen, or is still so.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Raised {
    /// Since when it has been so.
    pub(crate) at: Moment,
    /// Since when it is no longer so.
    pub(crate) over_at: Option<Moment>,
    pub(crate) is_acknowledged: bool,
    /// The figure that raised it, the worst since.
    pub(crate) worst: Option<f64>,
    /// The latest figure while it is so.
    pub(crate) latest: Option<f64>,
    /// How often it was raised before anybody acknowledged it.
    pub(crate) times: u32,
}

/// Where one rule stands.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Standing {
    /// Beyond the limit since then, and not yet for long enough.
    pending_since: Option<Moment>,
    raised: Option<Raised>,
    /// The latest figure.
    value: Option<f64>,
}

/// All alarms.
#[derive(Clone, Debug, Default)]
pub(crate) struct Alarms {
    standings: [Standing; RULES_COUNT],
}

impl Alarms {
    /// Looks whether anything is wrong; returns what is newly so, and whether anything changed.
    pub(super) fn watch(
        &mut self,
        facts: &Facts<'_>,
        limits: &Limits,
    ) -> (Vec<(&'static Rule, Option<f64>)>, bool) {
        let mut new = Vec::new();
        let mut changed = false;
        for (rule, standing) in RULES.iter().zip(&mut self.standings) {
            let before = standing.raised.map(|raised| (raised.over_at, raised.times));
            if standing.look(rule, facts, limits) {
                new.push((rule, standing.value));
            }
            let after = standing.raised.map(|raised| (raised.over_at, raised.times));
            changed |= before != after;
        }
        (new, changed)
    }

    /// Somebody has seen them: what is over goes, what is still so stays without a call. Says whether there
    /// was any.
    pub(super) fn acknowledge(&mut self) -> bool {
        let mut any = false;
        for standing in &mut self.standings {
            if let Some(raised) = &mut standing.raised {
                any |= !raised.is_acknowledged;
                raised.is_acknowledged = true;
                if raised.over_at.is_some() {
                    standing.raised = None;
                }
            }
        }
        any
    }

    /// Somebody has seen what was raised until a moment.
    pub(super) fn acknowledge_until(&mut self, at: Moment) {
        for standing in &mut self.standings {
            if let Some(raised) = &mut standing.raised {
                raised.is_acknowledged |= raised.at <= at;
            }
        }
    }

    /// When something that is beyond its limit has been so for long enough.
    pub(super) fn next_due(&self, limits: &Limits) -> Option<Moment> {
        let due = RULES.iter().zip(&self.standings).map(|(rule, standing)| {
            standing
                .pending_since
                .map(|since| since + rule.bounds(limits).persists)
        });
        due.flatten().min()
    }

    /// When the age of an alarm that calls is told differently.
    pub(super) fn next_tick(&self, now: Moment) -> Option<Moment> {
        let calling = self.calling();
        let ages = calling
            .iter()
            .map(|(_, raised)| age::next_change(raised.at, now));
        ages.min()
    }

    /// Every rule with its latest figure and what was raised, the worst rule first.
    pub(crate) fn all(
        &self,
    ) -> impl Iterator<Item = (&'static Rule, Option<f64>, Option<Raised>)> + '_ {
        RULES
            .iter()
            .zip(&self.standings)
            .map(|(rule, standing)| (rule, standing.value, standing.raised))
    }

    /// What nobody has acknowledged: what is still so before what is over, the worst first.
    pub(crate) fn calling(&self) -> Vec<(&'static Rule, Raised)> {
        let mut calling: Vec<_> = self
            .all()
            .filter_map(|(rule, _, raised)| Some((rule, raised?)))
            .filter(|(_, raised)| !raised.is_acknowledged)
            .collect();
        calling.sort_by_key(|(_, raised)| raised.over_at.is_some());
        calling
    }
}

impl Standing {
    /// Says whether it was raised just now.
    fn look(&mut self, rule: &Rule, facts: &Facts<'_>, limits: &Limits) -> bool {
        let bounds = rule.bounds(limits);
        let sight = (rule.look)(facts);
        if let Sight::Is(value) = sight {
            self.value = Some(value);
        }
        let is_up = self.raised.is_some_and(|raised| raised.over_at.is_none());
        let (is_bad, persists) = match sight {
            Sight::Unknown => {
                self.pending_since = None;
                return false;
            }
            Sight::No => (false, bounds.persists),
            Sight::Yes => (true, bounds.persists),
            Sight::Certain => (true, Moment::ZERO),
            // Once raised it holds until the figure is well on the good side again.
            Sight::Is(value) if is_up => (!bounds.is_clear(value), bounds.persists),
            Sight::Is(value) => (bounds.reaches(value), bounds.persists),
        };
        if !is_bad {
            self.pending_since = None;
            if let Some(raised) = self.raised.as_mut().filter(|_| is_up) {
                raised.over_at = Some(facts.now);
                if raised.is_acknowledged {
                    self.raised = None;
                }
            }
            return false;
        }
        if is_up {
            self.note_worst(bounds.is_high_bad());
            return false;
        }
        let since = *self.pending_since.get_or_insert(facts.now);
        if facts.now.saturating_sub(since) < persists {
            return false;
        }
        self.pending_since = None;
        let began = match sight {
            // The figure is the time itself.
            Sight::Is(s) if rule.unit == SECONDS => {
                facts.now.saturating_sub(Moment::from_secs_f64(s.max(0.0)))
            }
            _ => since,
        };
        let times = self.raised.map_or(0, |raised| raised.times);
        self.raised = Some(Raised {
            at: began,
            over_at: None,
            is_acknowledged: false,
            worst: self.value,
            latest: self.value,
            times: times.saturating_add(1),
        });
        true
    }

    fn note_worst(&mut self, is_high_bad: bool) {
        if let (Some(raised), Some(value)) = (&mut self.raised, self.value) {
            raised.latest = Some(value);
            let worst = raised.worst.unwrap_or(value);
            raised.worst = Some(if is_high_bad {
                worst.max(value)
            } else {
                worst.min(value)
            });
        }
    }
}
