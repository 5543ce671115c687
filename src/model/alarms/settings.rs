//! Alarms of the configuration: limits on any field of the robot's lines, and changes to the built-in alarms.

use groundwave_captures::messages::{Telemetry, Value};
use groundwave_lines::{Content, OwnLine, Value as OwnValue};
use serde::Deserialize;

use super::rules::{Bounds, Limits, Sight, built_in_codes, is_built_in};
use crate::event::{Level, Moment};
use crate::suggest;
use crate::wait::{check_comparison, field_named, recorded_word};

/// Maximum time beyond a limit before an alarm is raised, s.
const FOR_S_MAX: f64 = 86_400.0;

/// Names of units at the end of a field's name.
const UNITS: [(&str, &str); 6] = [
    ("_in_s", "in/s"),
    ("_v", "V"),
    ("_in", "in"),
    ("_deg", "°"),
    ("_pct", "%"),
    ("_s", "s"),
];

/// A table `[[alarm]]` of the configuration: an alarm, or a change to a built-in alarm.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct AlarmSetting {
    /// Name of the alarm; the name of a built-in alarm changes that alarm.
    pub name: String,
    /// The field with the limit.
    pub field: Option<String>,
    /// Value above which the alarm is raised.
    pub above: Option<f64>,
    /// Value below which the alarm is raised.
    pub below: Option<f64>,
    /// Number or word at which the alarm is raised.
    pub equals: Option<Operand>,
    /// Value that ends the alarm, if not the limit.
    pub clear: Option<f64>,
    /// Time beyond the limit before the alarm is raised, s.
    pub for_s: Option<f64>,
    /// Level of the alarm.
    pub severity: Option<Severity>,
    /// Advice for the operator.
    pub hint: Option<String>,
    /// Whether the alarm is enabled.
    pub enabled: bool,
}

impl Default for AlarmSetting {
    fn default() -> Self {
        Self {
            name: String::new(),
            field: None,
            above: None,
            below: None,
            equals: None,
            clear: None,
            for_s: None,
            severity: None,
            hint: None,
            enabled: true,
        }
    }
}

/// Severity of an alarm.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// Needs a look.
    Warning,
    /// Needs an action.
    Alarm,
}

/// A number or a word.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(untagged, expecting = "expected a number or a word in quotes")]
pub enum Operand {
    /// A number.
    Number(f64),
    /// A word.
    Word(String),
}

/// The limit on a field.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct FieldLimit {
    /// Name of the field in a robot's own lines.
    own_field: String,
    /// Name of the field in Groundwave's lines, if they have it.
    field: Option<&'static str>,
    /// Value that raises the alarm; `None` if the bounds do.
    pub(super) equals: Option<Operand>,
}

impl AlarmSetting {
    /// Stable code: the name in lower case, with underscores.
    #[must_use]
    pub fn code(&self) -> String {
        code(&self.name)
    }

    /// Checks the setting by itself.
    ///
    /// # Errors
    /// The first mistake, and how to correct it.
    pub fn check(&self) -> Result<(), String> {
        let name = &self.name;
        if self.code().is_empty() {
            return Err("[[alarm]] needs a name, such as name = \"warm\"".to_owned());
        }
        if let Some(for_s) = self.for_s
            && !(0.0..=FOR_S_MAX).contains(&for_s)
        {
            return Err(format!(
                "alarm `{name}`: for_s must be from 0 to {FOR_S_MAX}"
            ));
        }
        let limits = [
            self.above.is_some(),
            self.below.is_some(),
            self.equals.is_some(),
        ];
        let limits = limits.into_iter().filter(|&is_given| is_given).count();
        if is_built_in(&self.code()) {
            return self.check_built_in();
        }
        let Some(field) = &self.field else {
            let question = suggest::question_or(
                &self.code(),
                built_in_codes(),
                "give it a field, such as field = \"battery_v\"",
            );
            return Err(format!("no built-in alarm is named `{name}`{question}"));
        };
        if limits != 1 {
            return Err(format!(
                "alarm `{name}` needs one limit: above, below or equals"
            ));
        }
        self.check_field(field)
            .map_err(|error| format!("alarm `{name}`: {error}"))?;
        let is_clear_right = match (self.clear, self.above, self.below) {
            (None, ..) => true,
            (Some(clear), Some(above), _) => clear <= above,
            (Some(clear), _, Some(below)) => clear >= below,
            (Some(_), None, None) => false,
        };
        if is_clear_right {
            Ok(())
        } else {
            Err(format!(
                "alarm `{name}`: clear must be on the good side of above or below"
            ))
        }
    }

    /// A note on a field that only a robot's own lines can have.
    #[must_use]
    pub fn note(&self) -> Option<String> {
        let field = self.field.as_ref()?;
        field_named(field).is_none().then(|| {
            format!(
                "alarm `{}`: only a robot with its own lines can have the field `{field}`; `groundwave export --to jsonl` names the fields of the others, such as `battery_v`",
                self.name
            )
        })
    }

    fn check_field(&self, field: &str) -> Result<(), String> {
        if field_named(field).is_none() {
            let known = Telemetry::FIELDS.iter().map(|field| field.name);
            return match suggest::nearest(field, known) {
                Some(near) => Err(format!("unknown field `{field}`; did you mean `{near}`?")),
                // A robot's own lines may have the field.
                None => Ok(()),
            };
        }
        let (relation, value) = match (&self.equals, self.above.or(self.below)) {
            (Some(Operand::Word(word)), _) => ("=", word.clone()),
            (Some(Operand::Number(number)), _) => ("=", number.to_string()),
            (None, Some(number)) => (">", number.to_string()),
            (None, None) => return Ok(()),
        };
        check_comparison(field, relation, &value)
    }

    /// Checks that a change to a built-in alarm sets only limits that the alarm has.
    fn check_built_in(&self) -> Result<(), String> {
        let name = &self.name;
        if self.field.is_some() || self.equals.is_some() || self.clear.is_some() {
            return Err(format!(
                "`{name}` is a built-in alarm, which has its own field; choose another name"
            ));
        }
        if self.is_adjustable() {
            return Ok(());
        }
        let with = |limit: fn(&mut Self)| {
            let mut setting = Self {
                name: name.clone(),
                ..Self::default()
            };
            limit(&mut setting);
            setting.is_adjustable()
        };
        let mut known = vec!["severity", "hint", "enabled"];
        known.extend(with(|it| it.below = Some(0.0)).then_some("below"));
        known.extend(with(|it| it.above = Some(0.0)).then_some("above"));
        known.extend(with(|it| it.for_s = Some(0.0)).then_some("for_s"));
        Err(format!(
            "the built-in alarm `{name}` has no such limit; known: {}",
            known.join(", ")
        ))
    }

    /// Whether the built-in alarm has the limits that the setting changes.
    fn is_adjustable(&self) -> bool {
        self.adjust(&mut Limits::default(), &Limits::default())
    }

    /// Copies the limits of a built-in alarm's setting into `limits`, where they still equal `before`; returns `false` if the
    /// alarm has no such limit.
    pub fn adjust(&self, limits: &mut Limits, before: &Limits) -> bool {
        let set = |limit: &mut u16, before: u16, figure: Option<f64>| {
            if let Some(figure) = figure
                && *limit == before
            {
                *limit = figure.round().clamp(0.0, f64::from(u16::MAX)) as u16;
            }
        };
        let (for_s, above) = (self.for_s, self.above);
        let dv = self.below.map(|v| v * 10.0);
        let (takes_above, takes_below, takes_for) = match self.code().as_str() {
            "battery_low" => {
                set(&mut limits.battery_low_dv, before.battery_low_dv, dv);
                set(&mut limits.battery_for_s, before.battery_for_s, for_s);
                (false, true, true)
            }
            "battery_critical" => {
                set(
                    &mut limits.battery_critical_dv,
                    before.battery_critical_dv,
                    dv,
                );
                set(&mut limits.battery_for_s, before.battery_for_s, for_s);
                (false, true, true)
            }
            "robot_silent" => {
                set(&mut limits.silent_s, before.silent_s, for_s);
                (false, false, true)
            }
            "stalled" => {
                set(&mut limits.stalled_s, before.stalled_s, for_s);
                (false, false, true)
            }
            "fallen_or_lifted" => {
                set(&mut limits.fallen_s, before.fallen_s, for_s);
                (false, false, true)
            }
            "layers_thrash" => {
                set(&mut limits.thrash_s, before.thrash_s, for_s);
                (false, false, true)
            }
            "lines_not_intact" => {
                if let Some(above) = above
                    && limits.loss_pct == before.loss_pct
                {
                    limits.loss_pct = above.round().clamp(0.0, f64::from(u8::MAX)) as u8;
                }
                set(&mut limits.loss_for_s, before.loss_for_s, for_s);
                (true, false, true)
            }
            "left_side_blind" => {
                let limit = &mut limits.left_unseen_bumps;
                set(limit, before.left_unseen_bumps, above);
                (true, false, false)
            }
            "right_side_blind" => {
                let limit = &mut limits.right_unseen_bumps;
                set(limit, before.right_unseen_bumps, above);
                (true, false, false)
            }
            _ => (false, false, false),
        };
        (above.is_none() || takes_above)
            && (dv.is_none() || takes_below)
            && (for_s.is_none() || takes_for)
    }

    pub(super) fn level(&self) -> Option<Level> {
        self.severity.map(|severity| match severity {
            Severity::Warning => Level::Warning,
            Severity::Alarm => Level::Alarm,
        })
    }

    /// The limit on the alarm's field; `None` for a change to a built-in alarm.
    pub(super) fn limit(&self) -> Option<FieldLimit> {
        let own_field = self.field.clone()?;
        let field = field_named(&own_field);
        let equals = match &self.equals {
            // Commands and recordings name two modes differently.
            Some(Operand::Word(word)) => Some(Operand::Word(
                field
                    .map_or(word.as_str(), |field| recorded_word(field.name, word))
                    .to_owned(),
            )),
            equals => equals.clone(),
        };
        Some(FieldLimit {
            own_field,
            field: field.map(|field| field.name),
            equals,
        })
    }

    pub(super) fn bounds(&self) -> Bounds {
        let raise = self.above.or(self.below).unwrap_or_default();
        Bounds {
            raise,
            clear: self.clear.unwrap_or(raise),
            is_high_bad: self.below.is_none(),
            is_inclusive: false,
            persists: Moment::from_secs_f64(self.for_s.unwrap_or_default().clamp(0.0, FOR_S_MAX)),
        }
    }

    /// Unit of the value, from the end of the field's name.
    pub(super) fn unit(&self) -> &'static str {
        let field = self.field.as_deref().unwrap_or_default();
        let name = field_named(field).map_or(field, |field| field.name);
        let unit = UNITS.into_iter().find(|(end, _)| name.ends_with(end));
        unit.map_or("", |(_, unit)| unit)
    }
}

/// Converts a name to a code.
pub(crate) fn code(name: &str) -> String {
    let lower = name.trim().to_lowercase();
    lower.replace(|c: char| !c.is_alphanumeric(), "_")
}

impl FieldLimit {
    /// The value of the field in a line of Groundwave's protocol.
    pub(super) fn in_line(&self, telemetry: &Telemetry) -> Option<Operand> {
        let field = self.field?;
        let mut found = None;
        let mut take = |name, value: Option<Value<'_>>| -> Result<(), std::convert::Infallible> {
            if name == field {
                found = value.map(|value| match value {
                    Value::Integer(number) => Operand::Number(number as f64),
                    Value::Decimal(number) => Operand::Number(number),
                    Value::Word(word) => Operand::Word(word.to_owned()),
                    Value::Text(text) => Operand::Word(text.to_owned()),
                });
            }
            Ok(())
        };
        let Ok(()) = telemetry.for_each(&mut take);
        found
    }

    /// The value of the field in a line of the robot's own.
    pub(super) fn in_own_line(&self, line: &OwnLine) -> Option<Operand> {
        let Content::Values(samples) = &line.content else {
            return None;
        };
        let mut samples = samples.iter();
        let sample = samples.find(|sample| sample.field.name == self.own_field)?;
        Some(match &sample.value {
            OwnValue::Number(number) => Operand::Number(*number),
            OwnValue::Text(text) => Operand::Word(text.to_string()),
        })
    }

    /// Checks the latest value.
    pub(super) fn look(&self, reading: Option<&Operand>) -> Sight {
        match (reading, &self.equals) {
            (Some(Operand::Number(number)), None) => Sight::Is(*number),
            (None, _) | (Some(Operand::Word(_)), None) => Sight::Unknown,
            (Some(reading), Some(equals)) if reading == equals => Sight::Yes,
            (Some(_), Some(_)) => Sight::No,
        }
    }
}
