//! Records of commands, marks, notes, alarms and outages.

use std::io::{self, Write};
use std::time::Duration;

use groundwave_lines::{Content, OwnLine, Sample, Value as OwnValue};
use serde_json::{Map, Value, json};

use super::{Format, Telemetry, write_commas, write_csv_text, write_seconds};
use crate::messages::{StationEvent, StationEventKind};
use crate::outages::Outage;
use crate::runs::label::Note;

/// A command's or an alarm's new status, a mark, a note or an outage.
#[derive(Clone, Debug, Default)]
pub(super) struct EventRecord(Map<String, Value>);

impl EventRecord {
    /// Names of the fields, in the order of a table.
    pub(super) const FIELDS: [&str; 19] = [
        // `command`, `mark`, `note`, `outage`, `alarm` or `own`.
        "event",
        // Number of the command.
        "command_id",
        // Status of the command or the alarm; `set` or `cleared` of a mark.
        "status",
        // The command in words, when it is queued.
        "command",
        // Code: why a command was refused or failed; cause of an outage; the alarm.
        "code",
        // The client that gave the command.
        "by",
        // Time of a mark; beginning of an outage or an alarm.
        "begin_s",
        // End of an outage; empty if it lasts at the end of the capture.
        "end_s",
        // Lines lost in an outage, at least and at most.
        "lines_lost",
        "lines_lost_max",
        // `warning` or `alarm`.
        "severity",
        // Limit of an alarm, and the unit of limit and value.
        "limit",
        "unit",
        // Time for which an alarm is shelved.
        "shelved_s",
        // A line of the robot's own, unchanged.
        "own",
        // Values of the line by the name of their field; JSON only.
        "values",
        // One of its values: name and value; CSV only. The value of an alarm.
        "field",
        "value",
        // Text of a note.
        "note",
    ];

    /// The record of an event; `None` for other kinds.
    pub(super) fn of(at: Duration, event: &StationEvent) -> Option<Self> {
        let value = match event.kind.as_ref()? {
            StationEventKind::Command(event) => json!({
                "event": "command",
                "command_id": event.command_id,
                "status": event.status,
                "command": event.command,
                "code": event.code,
                "by": event.by,
            }),
            StationEventKind::Mark(mark) => json!({
                "event": "mark",
                "status": if mark.is_set { "set" } else { "cleared" },
                "begin_s": milliseconds(at.saturating_sub(Duration::from_nanos(mark.ago_ns))),
            }),
            StationEventKind::Alarm(alarm) => json!({
                "event": "alarm",
                "status": alarm.status,
                "code": alarm.code,
                "begin_s": milliseconds(at.saturating_sub(Duration::from_nanos(alarm.ago_ns))),
                "severity": alarm.severity,
                "value": alarm.value,
                "limit": alarm.limit,
                "unit": Some(&alarm.unit).filter(|unit| !unit.is_empty()),
                "shelved_s": alarm.shelved_ns.map(|ns| milliseconds(Duration::from_nanos(ns))),
            }),
            _ => return None,
        };
        Some(Self::from(value))
    }

    /// The records of a line of the robot's own: one in JSON, one for each value in CSV.
    pub(super) fn of_own(line: &OwnLine, format: Format) -> Vec<Self> {
        let samples = match &line.content {
            Content::Values(samples) => &samples[..],
            Content::Text => &[],
            Content::Damaged => return Vec::new(),
        };
        let value = |sample: &Sample| match &sample.value {
            OwnValue::Number(number) => json!(number),
            OwnValue::Text(text) => json!(&**text),
        };
        if format == Format::Jsonl || samples.is_empty() {
            let values = samples.iter();
            let values = values.map(|sample| (sample.field.name.clone(), value(sample)));
            let values: Map<_, _> = values.collect();
            return vec![Self::from(json!({
                "event": "own",
                "own": line.text,
                "values": (!values.is_empty()).then_some(values),
            }))];
        }
        let rows = samples.iter().map(|sample| {
            Self::from(json!({
                "event": "own",
                "field": sample.field.name,
                "value": value(sample),
            }))
        });
        rows.collect()
    }

    /// The record of a note in the label.
    pub(super) fn of_note(note: &Note) -> Self {
        Self::from(json!({ "event": "note", "note": note.text }))
    }

    /// The record of an outage.
    pub(super) fn of_outage(outage: &Outage) -> Self {
        Self::from(json!({
            "event": "outage",
            "code": outage.cause.code(),
            "begin_s": milliseconds(outage.begin),
            "end_s": outage.end.map(milliseconds),
            "lines_lost": outage.lost.min,
            "lines_lost_max": outage.lost.max,
        }))
    }

    pub(super) fn write_json(&self, output: &mut Vec<u8>, at: Duration) -> io::Result<()> {
        output.write_all(b"{\"at_s\":")?;
        write_seconds(output, at)?;
        for (name, value) in self.fields().filter(|(_, value)| !value.is_null()) {
            write!(output, ",\"{name}\":{value}")?;
        }
        output.write_all(b"}\n")
    }

    pub(super) fn write_csv(&self, output: &mut Vec<u8>, at: Duration) -> io::Result<()> {
        write_seconds(output, at)?;
        write_commas(output, Telemetry::FIELDS.len())?;
        for (_, value) in self.fields() {
            output.write_all(b",")?;
            match value {
                Value::Null => {}
                Value::String(text) => write_csv_text(output, text)?,
                other => write!(output, "{other}")?,
            }
        }
        output.write_all(b"\n")
    }

    fn fields(&self) -> impl Iterator<Item = (&str, &Value)> {
        Self::FIELDS
            .into_iter()
            .map(|name| (name, self.0.get(name).unwrap_or(&Value::Null)))
    }
}

impl From<Value> for EventRecord {
    fn from(value: Value) -> Self {
        match value {
            Value::Object(fields) => Self(fields),
            _ => Self::default(),
        }
    }
}

/// Seconds, rounded to milliseconds.
fn milliseconds(at: Duration) -> f64 {
    (at.as_secs_f64() * 1000.0).round() / 1000.0
}
