//! The fields of a robot's own lines: newest value, freshness, history and meaning, in bounded memory.

use std::sync::Arc;

use groundwave_lines::{Content, FIELDS_MAX, Field, OwnLine, Role, Sample, Value};

use super::chart::Pose;
use super::plots::Series;
use crate::event::Moment;

/// Minimum age of a stale value.
const STALE_MIN: Moment = Moment::from_secs(2);

/// Age above which any value is stale.
const STALE_MAX: Moment = Moment::from_mins(1);

/// Number of usual intervals without a new value after which a value is stale.
const STALE_INTERVALS: u32 = 3;

/// Maximum step of the sequence that counts as lost lines; a larger step is another count.
const LOST_MAX: f64 = 1e6;

/// A field and its values.
#[derive(Clone, Debug)]
pub(crate) struct Known {
    pub(crate) field: Arc<Field>,
    /// The newest value.
    pub(crate) value: Value,
    /// Time at which the value arrived.
    pub(crate) at: Moment,
    /// Numbers over time.
    pub(crate) series: Series<f32>,
    /// Usual time between two values.
    interval: Moment,
}

impl Known {
    fn new(sample: &Sample, now: Moment) -> Self {
        Self {
            field: Arc::clone(&sample.field),
            value: sample.value.clone(),
            at: now,
            series: Series::default(),
            interval: Moment::ZERO,
        }
    }

    fn take(&mut self, now: Moment, value: &Value) {
        let passed = now.saturating_sub(self.at);
        self.interval = (self.interval * 7 + passed) / 8;
        if let Value::Number(number) = value {
            self.series.push(now, *number as f32, self.stale_after());
        }
        if self.value != *value {
            self.value = value.clone();
        }
        self.at = now;
    }

    /// Age of the newest value.
    pub(crate) fn age(&self, now: Moment) -> Moment {
        now.saturating_sub(self.at)
    }

    /// Age from which the value is stale: some of its usual intervals.
    pub(crate) fn stale_after(&self) -> Moment {
        (self.interval * STALE_INTERVALS).clamp(STALE_MIN, STALE_MAX)
    }

    /// The newest number, in the standard unit of the field's role.
    pub(crate) fn standard(&self) -> Option<f64> {
        match self.value {
            Value::Number(number) => Some(self.field.standard(number)),
            Value::Text(_) => None,
        }
    }

    /// The newest value as text, without its unit.
    pub(crate) fn words(&self) -> String {
        match &self.value {
            Value::Number(number) => words(*number),
            Value::Text(text) => text.to_string(),
        }
    }
}

/// A number as text, with at most six significant digits.
pub(crate) fn words(number: f64) -> String {
    let magnitude = number.abs();
    if magnitude >= 1e9 || magnitude > 0.0 && magnitude < 1e-4 {
        return format!("{number:.3e}");
    }
    let whole_digits = magnitude.max(1.0).log10() as usize + 1;
    let rounded = format!("{number:.*}", 6_usize.saturating_sub(whole_digits));
    match rounded.split_once('.') {
        Some(_) => rounded
            .trim_end_matches('0')
            .trim_end_matches('.')
            .to_owned(),
        None => rounded,
    }
}

/// Values with a role in one line.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Found {
    /// The robot's pose.
    pub(super) pose: Option<Pose>,
    /// The new mode.
    pub(super) mode: Option<String>,
    /// Whether the bumper was pressed.
    pub(super) is_bumped: bool,
    /// Text for the log.
    pub(super) text: Option<String>,
    /// Number of lines lost before this line, by the sequence.
    pub(super) lost: u64,
}

/// All fields, in the order of their first values.
#[derive(Clone, Debug, Default)]
pub(crate) struct Fields {
    known: Vec<Known>,
    /// Number of lines, with or without values.
    pub(crate) lines: u64,
    /// Number of lines that could not be read.
    pub(crate) damaged: u64,
    /// Number of lines lost, by the sequence.
    pub(crate) lost: u64,
    /// The newest line.
    pub(crate) newest: Option<String>,
}

impl Fields {
    /// Takes a line; returns its values with a role.
    pub(super) fn take(&mut self, now: Moment, line: &OwnLine) -> Found {
        self.newest = Some(line.text.clone());
        let samples = match &line.content {
            Content::Damaged => {
                self.damaged += 1;
                return Found::default();
            }
            Content::Text => &[][..],
            Content::Values(samples) => samples,
        };
        self.lines += 1;
        let mut found = Found::default();
        let mut has_pose = false;
        for sample in samples {
            let before = self.take_sample(now, sample);
            let number = match sample.value {
                Value::Number(number) => Some(number),
                Value::Text(_) => None,
            };
            match sample.field.role {
                Some(Role::X | Role::Y | Role::Heading) => has_pose = true,
                Some(Role::Mode) if before.as_ref() != Some(&sample.value) => {
                    found.mode = Some(value_words(&sample.value));
                }
                Some(Role::Bump) => {
                    let was = before.as_ref().is_some_and(is_set);
                    found.is_bumped = is_set(&sample.value) && !was;
                }
                Some(Role::Text) if before.as_ref() != Some(&sample.value) => {
                    found.text = Some(value_words(&sample.value));
                }
                Some(Role::Sequence) => {
                    let before = match before {
                        Some(Value::Number(before)) => Some(before),
                        _ => None,
                    };
                    // A smaller number means a restart, or a wrap at an unknown modulus.
                    let steps = before.zip(number).map(|(before, number)| number - before);
                    let steps = steps.filter(|steps| (1.0..LOST_MAX).contains(steps));
                    found.lost = steps.map_or(0, |steps| steps as u64 - 1);
                    self.lost += found.lost;
                }
                _ => {}
            }
        }
        found.pose = has_pose.then(|| self.pose()).flatten();
        found
    }

    /// Takes a value; returns the previous one.
    fn take_sample(&mut self, now: Moment, sample: &Sample) -> Option<Value> {
        let is_it = |known: &&mut Known| {
            Arc::ptr_eq(&known.field, &sample.field) || known.field.name == sample.field.name
        };
        if let Some(known) = self.known.iter_mut().find(is_it) {
            let before = sample.field.role.map(|_| known.value.clone());
            known.take(now, &sample.value);
            return before;
        }
        if self.known.len() < FIELDS_MAX {
            let mut known = Known::new(sample, now);
            known.take(now, &sample.value);
            self.known.push(known);
        }
        None
    }

    fn pose(&self) -> Option<Pose> {
        let of = |role| self.of(role).and_then(Known::standard);
        Some(Pose {
            x_in: of(Role::X)?,
            y_in: of(Role::Y)?,
            theta_deg: of(Role::Heading).unwrap_or_default().rem_euclid(360.0),
        })
    }

    /// The field with a role.
    pub(crate) fn of(&self, role: Role) -> Option<&Known> {
        self.known
            .iter()
            .find(|known| known.field.role == Some(role))
    }

    /// Every field, in the order of their first values.
    pub(crate) fn all(&self) -> &[Known] {
        &self.known
    }

    /// Whether a line of the robot's own has arrived.
    pub(crate) const fn are_known(&self) -> bool {
        self.lines > 0
    }
}

fn value_words(value: &Value) -> String {
    match value {
        Value::Number(number) => words(*number),
        Value::Text(text) => text.to_string(),
    }
}

/// Whether the value of a bumper means "pressed".
fn is_set(value: &Value) -> bool {
    match value {
        Value::Number(number) => *number != 0.0,
        Value::Text(text) => !text.is_empty(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_true() {
        for (number, expected) in [
            (21.5, "21.5"),
            (0.0, "0"),
            (-3.0, "-3"),
            (1234.5678, "1234.57"),
            (53.361_336_67, "53.3613"),
            (1_700_000_000.0, "1.700e9"),
            (999_999.9, "1000000"),
            (0.000_012, "1.200e-5"),
            (-0.1, "-0.1"),
            (100.0, "100"),
        ] {
            assert_eq!(words(number), expected);
        }
    }
}
