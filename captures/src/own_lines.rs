//! Lines in a robot's own format: their form in a recording, and their values as messages and records.

use std::collections::BTreeMap;
use std::io::{self, Write};
use std::sync::Arc;

use groundwave_lines::{Content, Field, Limits, OwnLine, Recognizer, Sample, Value};
use groundwave_protocol::telemetry::{Body, FIELDS_MAX};

use crate::session::Session;
use crate::source::Form;
use crate::statistics::Damaged;

/// Values of one line, recorded on `/values`.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Values {
    /// Numbers by the name of their field.
    #[prost(btree_map = "string, double", tag = 1)]
    pub numbers: BTreeMap<String, f64>,
    /// Texts by the name of their field.
    #[prost(btree_map = "string, string", tag = 2)]
    pub texts: BTreeMap<String, String>,
}

impl From<&[Sample]> for Values {
    fn from(samples: &[Sample]) -> Self {
        let mut values = Self::default();
        for sample in samples {
            let name = sample.field.name.clone();
            match &sample.value {
                Value::Number(number) => {
                    values.numbers.insert(name, *number);
                }
                Value::Text(text) => {
                    values.texts.insert(name, text.to_string());
                }
            }
        }
        values
    }
}

/// The recognizer with the profile from a session's table; without a profile if the table has no valid one.
#[must_use]
pub fn recognizer(table: Option<&BTreeMap<String, String>>) -> Recognizer {
    let profile = table.and_then(|table| serde_json::from_str(table.get(Session::LINES)?).ok());
    let configured = profile.and_then(|profile| Recognizer::new(&profile).ok());
    configured.unwrap_or_default()
}

/// Maximum number of lines of text for each line with values, for raw text to be a robot's.
const TEXTS_PER_LINE_MAX: u64 = 9;

/// Whether a capture's own lines are a robot's, by the numbers of lines with values, of text, and of another kind that are damaged. Prose looks
/// like a value now and then, and the origin of raw text is not known.
pub(crate) fn are_robots(form: Form, lines: u64, texts: u64, damaged: u64) -> bool {
    match form {
        Form::Mcap => outweigh(lines, texts, damaged),
        Form::Raw => lines > 0 && texts <= lines * TEXTS_PER_LINE_MAX,
    }
}

/// Whether a capture without an intact line has own lines rather than damaged ones of another kind: noise looks like text now and then.
const fn outweigh(lines: u64, texts: u64, damaged: u64) -> bool {
    lines > 0 || texts > damaged
}

/// Fields that a robot describes in lines F; lines V contain their values.
#[derive(Clone, Debug, Default)]
pub struct DescribedFields(Vec<Option<Described>>);

#[derive(Clone, Debug)]
struct Described {
    field: Arc<Field>,
    /// Divisor of the value in the line. Dividing gives the number nearest to the decimal one.
    divisor: f64,
}

impl DescribedFields {
    /// Takes the content of a line F or V; returns the values in a line V as a line of the robot's own. A value whose line F has
    /// not arrived is left out.
    pub fn take(&mut self, body: &Body) -> Option<OwnLine> {
        match body {
            Body::Field(field) => {
                self.0.resize(usize::from(FIELDS_MAX), None);
                let known = self.0.get_mut(usize::from(field.place.checked_sub(1)?))?;
                let unit = field.unit.as_str();
                let divisor = 10_f64.powi(i32::from(field.decimals));
                let field = Field {
                    name: field.name.as_str().to_owned(),
                    unit: (!unit.is_empty()).then(|| unit.to_owned()),
                    scale: divisor.recip(),
                    offset: 0.0,
                    role: None,
                    limits: Limits::default(),
                };
                if known.as_ref().is_none_or(|known| *known.field != field) {
                    let field = Arc::new(field);
                    *known = Some(Described { field, divisor });
                }
                None
            }
            Body::Values(line) => {
                let described = self.0.iter().zip(line.values());
                let samples = described.filter_map(|(described, value)| {
                    let described = described.as_ref()?;
                    Some(Sample {
                        field: Arc::clone(&described.field),
                        value: Value::Number(f64::from(value?) / described.divisor),
                    })
                });
                let samples: Vec<_> = samples.collect();
                let words = samples.iter().map(|sample| match &sample.value {
                    Value::Number(number) => format!("{}={number}", sample.field.name),
                    Value::Text(text) => format!("{}={text}", sample.field.name),
                });
                let text = words.collect::<Vec<_>>().join(" ");
                (!samples.is_empty()).then_some(OwnLine {
                    text,
                    content: Content::Values(samples),
                })
            }
            _ => None,
        }
    }
}

/// A field in the summary of a capture.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct FieldSummary {
    /// Name.
    pub name: String,
    /// Unit, if known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// Number of values.
    pub values: u64,
    /// Smallest value.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub least: Option<f64>,
    /// Largest value.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub greatest: Option<f64>,
}

/// Maximum number of fields in a summary. A robot describes 64 at once, but may give them other names at any time.
pub const SUMMARY_FIELDS_MAX: usize = 256;

/// Lines of the robot's own in a capture.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct OwnSummary {
    /// Number of lines with values.
    pub lines: u64,
    /// Number of lines of text.
    pub texts: u64,
    /// Number of damaged lines.
    pub damaged: u64,
    /// Fields, in the order of their first values; at most [`SUMMARY_FIELDS_MAX`].
    pub fields: Vec<FieldSummary>,
    /// Number of values of further fields.
    #[serde(skip_serializing_if = "is_zero")]
    pub other_values: u64,
}

#[expect(
    clippy::trivially_copy_pass_by_ref,
    reason = "serde passes a reference"
)]
const fn is_zero(count: &u64) -> bool {
    *count == 0
}

impl OwnSummary {
    /// Adds a line.
    pub(super) fn take(&mut self, line: &OwnLine) {
        let samples = match &line.content {
            Content::Damaged => {
                self.damaged += 1;
                return;
            }
            Content::Text => {
                self.texts += 1;
                return;
            }
            Content::Values(samples) => samples,
        };
        self.lines += 1;
        for sample in samples {
            let name = &sample.field.name;
            let known = self.fields.iter().position(|field| field.name == *name);
            if known.is_none() && self.fields.len() >= SUMMARY_FIELDS_MAX {
                self.other_values += 1;
                continue;
            }
            let at = known.unwrap_or_else(|| {
                self.fields.push(FieldSummary {
                    name: name.clone(),
                    unit: sample.field.unit.clone(),
                    values: 0,
                    least: None,
                    greatest: None,
                });
                self.fields.len() - 1
            });
            let field = &mut self.fields[at];
            field.values += 1;
            if let Value::Number(number) = sample.value {
                field.least = Some(field.least.map_or(number, |least| least.min(number)));
                field.greatest = Some(field.greatest.map_or(number, |most| most.max(number)));
            }
        }
    }

    /// Whether the lines are a robot's (see [`are_robots`]).
    pub(super) fn is_of_robot(&self, form: Form, damaged: &Damaged) -> bool {
        are_robots(form, self.lines, self.texts, damaged.lines())
    }

    /// Whether a capture without an intact line has these lines rather than the damaged ones.
    pub(super) fn outweighs(&self, damaged: &Damaged) -> bool {
        outweigh(self.lines, self.texts, damaged.lines())
    }

    /// Writes the numbers of lines as a row of text.
    pub(super) fn write_row(&self, output: &mut impl Write) -> io::Result<()> {
        let (lines, texts, damaged) = (self.lines, self.texts, self.damaged);
        writeln!(
            output,
            "own lines  {lines} with values, {texts} of text, {damaged} damaged"
        )
    }

    /// Whether there was no line.
    pub(super) const fn is_empty(&self) -> bool {
        self.lines + self.texts + self.damaged == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A robot that names its fields anew again and again does not fill the memory.
    #[test]
    fn summary_has_bounded_fields() {
        let named = |n: usize| OwnLine {
            text: String::new(),
            content: Content::Values(vec![Sample {
                field: Arc::new(Field {
                    name: format!("name{n}"),
                    unit: None,
                    scale: 1.0,
                    offset: 0.0,
                    role: None,
                    limits: Limits::default(),
                }),
                value: Value::Number(1.0),
            }]),
        };
        let mut summary = OwnSummary::default();
        (0..SUMMARY_FIELDS_MAX + 10).for_each(|n| summary.take(&named(n)));
        summary.take(&named(0));
        assert_eq!(summary.fields.len(), SUMMARY_FIELDS_MAX);
        assert_eq!(summary.fields[0].values, 2);
        assert_eq!(summary.other_values, 10);
    }
}
