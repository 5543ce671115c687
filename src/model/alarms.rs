//! Alarms: raised when a rule has matched for long enough, kept until the operator acknowledges them.

mod rules;

use super::age;
use crate::event::Moment;
#[cfg(test)]
pub(crate) use rules::DISK_IS_SILENT;
pub(super) use rules::Inputs;
pub use rules::Limits;
pub(crate) use rules::{PRESSED_S, RULES, Rule, Source};
use rules::{RULES_COUNT, SECONDS, Sight};

/// An alarm that was raised and is active, or not acknowledged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Raised {
    /// When its cause began.
    pub(crate) at: Moment,
    /// When its cause ended; `None` while it is active.
    pub(crate) over_at: Option<Moment>,
    pub(crate) is_acknowledged: bool,
    /// The worst figure since it was raised.
    pub(crate) worst: Option<f64>,
    /// The latest figure while it is active.
    pub(crate) latest: Option<f64>,
    /// How often it was raised since the last acknowledgement.
    pub(crate) times: u32,
}

/// What the operator has acknowledged: alarms raised until a moment.
#[derive(Clone, Debug, Default)]
pub(crate) struct Acknowledged {
    until: Option<Moment>,
    /// How often each rule had been raised then.
    times: [u32; RULES_COUNT],
}

impl Acknowledged {
    /// Everything raised until `now`.
    pub(super) fn until(now: Moment, alarms: &Alarms) -> Self {
        let mut times = [0; RULES_COUNT];
        for (times, standing) in times.iter_mut().zip(&alarms.standings) {
            *times = standing.episode.map_or(0, |episode| episode.times);
        }
        let until = Some(now);
        Self { until, times }
    }
}

/// The latest time that one rule was raised.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Episode {
    /// When its cause began.
    began_at: Moment,
    raised_at: Moment,
    over_at: Option<Moment>,
    worst: Option<f64>,
    latest: Option<f64>,
    /// How often the rule has been raised.
    times: u32,
}

/// An alarm that was raised or ended.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AlarmChange {
    pub(crate) rule: &'static Rule,
    /// Raised, or else ended.
    pub(crate) is_active: bool,
    /// When its cause began.
    pub(crate) began_at: Moment,
    /// The latest figure, in the rule's unit.
    pub(crate) value: Option<f64>,
}

/// The state of one rule.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Standing {
    /// Since when the limit is passed, while that is too short to raise the alarm.
    pending_since: Option<Moment>,
    episode: Option<Episode>,
    /// The latest figure.
    value: Option<f64>,
}

/// All alarms.
#[derive(Clone, Debug, Default)]
pub(crate) struct Alarms {
    standings: [Standing; RULES_COUNT],
}

impl Alarms {
    /// Checks every rule; returns the alarms that were raised or ended now.
    pub(super) fn watch(&mut self, inputs: &Inputs<'_>, limits: &Limits) -> Vec<AlarmChange> {
        let mut changes = Vec::new();
        for (rule, standing) in RULES.iter().zip(&mut self.standings) {
            let was_up = standing.is_up();
            standing.look(rule, inputs, limits);
            let Some(episode) = standing.episode else {
                continue;
            };
            if was_up != standing.is_up() {
                changes.push(AlarmChange {
                    rule,
                    is_active: !was_up,
                    began_at: episode.began_at,
                    value: standing.value.filter(|_| !rule.unit.is_empty()),
                });
            }
        }
        changes
    }

    /// When the next pending alarm is raised.
    pub(super) fn next_due(&self, limits: &Limits) -> Option<Moment> {
        let due = RULES.iter().zip(&self.standings).map(|(rule, standing)| {
            standing
                .pending_since
                .map(|since| since + rule.bounds(limits).persists)
        });
        due.flatten().min()
    }

    /// When the age of an unacknowledged alarm changes on the screen.
    pub(super) fn next_tick(&self, seen: &Acknowledged, now: Moment) -> Option<Moment> {
        let calling = self.calling(seen);
        let ages = calling
            .iter()
            .map(|(_, raised)| age::next_change(raised.at, now));
        ages.min()
    }

    /// Every rule with its latest figure and its alarm, the worst rule first. Acknowledged alarms that are over are
    /// left out.
    pub(crate) fn all(
        &self,
        seen: &Acknowledged,
    ) -> impl Iterator<Item = (&'static Rule, Option<f64>, Option<Raised>)> {
        let standings = self.standings.iter().zip(&seen.times);
        RULES
            .iter()
            .zip(standings)
            .map(|(rule, (standing, times))| {
                let raised = standing.episode.and_then(|episode| {
                    let is_acknowledged = seen.until.is_some_and(|at| episode.raised_at <= at);
                    let is_shown = !is_acknowledged || episode.over_at.is_none();
                    is_shown.then(|| Raised {
                        at: episode.began_at,
                        over_at: episode.over_at,
                        is_acknowledged,
                        worst: episode.worst,
                        latest: episode.latest,
                        times: episode.times.saturating_sub(*times).max(1),
                    })
                });
                (rule, standing.value, raised)
            })
    }

    /// Unacknowledged alarms: active before over, the worst first.
    pub(crate) fn calling(&self, seen: &Acknowledged) -> Vec<(&'static Rule, Raised)> {
        let mut calling: Vec<_> = self
            .all(seen)
            .filter_map(|(rule, _, raised)| Some((rule, raised?)))
            .filter(|(_, raised)| !raised.is_acknowledged)
            .collect();
        calling.sort_by_key(|(_, raised)| raised.over_at.is_some());
        calling
    }
}

impl Standing {
    fn is_up(&self) -> bool {
        self.episode
            .is_some_and(|episode| episode.over_at.is_none())
    }

    /// Checks the rule.
    fn look(&mut self, rule: &Rule, inputs: &Inputs<'_>, limits: &Limits) {
        let bounds = rule.bounds(limits);
        let sight = (rule.look)(inputs);
        if let Sight::Is(value) = sight {
            self.value = Some(value);
        }
        let is_up = self.is_up();
        let (is_bad, persists) = match sight {
            Sight::Unknown => {
                self.pending_since = None;
                return;
            }
            Sight::No => (false, bounds.persists),
            Sight::Yes => (true, bounds.persists),
            Sight::Certain => (true, Moment::ZERO),
            // Hysteresis: a raised alarm lasts until the figure is clear of the limit.
            Sight::Is(value) if is_up => (!bounds.is_clear(value), bounds.persists),
            Sight::Is(value) => (bounds.reaches(value), bounds.persists),
        };
        if !is_bad {
            self.pending_since = None;
            if let Some(episode) = self.episode.as_mut().filter(|_| is_up) {
                episode.over_at = Some(inputs.now);
            }
            return;
        }
        if is_up {
            self.note_worst(bounds.is_high_bad());
            return;
        }
        let since = *self.pending_since.get_or_insert(inputs.now);
        if inputs.now.saturating_sub(since) < persists {
            return;
        }
        self.pending_since = None;
        let began = match sight {
            // The figure is the age of the cause.
            Sight::Is(s) if rule.unit == SECONDS => {
                inputs.now.saturating_sub(Moment::from_secs_f64(s.max(0.0)))
            }
            _ => since,
        };
        let times = self.episode.map_or(0, |episode| episode.times);
        self.episode = Some(Episode {
            began_at: began,
            raised_at: inputs.now,
            over_at: None,
            worst: self.value,
            latest: self.value,
            times: times.saturating_add(1),
        });
    }

    fn note_worst(&mut self, is_high_bad: bool) {
        if let (Some(episode), Some(value)) = (&mut self.episode, self.value) {
            episode.latest = Some(value);
            let worst = episode.worst.unwrap_or(value);
            episode.worst = Some(if is_high_bad {
                worst.max(value)
            } else {
                worst.min(value)
            });
        }
    }
}
