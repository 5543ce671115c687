//! Records of commands, marks, notes, alarms, outages and lines of the robot's own.

use std::io::{self, Write};
use std::time::Duration;

use groundwave_lines::{OwnLine, Sample, Value};
use serde_json::to_writer;

use super::{Telemetry, write_commas, write_csv_text, write_name, write_seconds};
use crate::messages::{StationEvent, StationEventKind};
use crate::outages::Outage;
use crate::runs::label::Note;

/// A command's or an alarm's new status, a mark, a note, an outage or a line of the robot's own: some of the fields, in
/// their order.
#[derive(Clone, Debug)]
pub(super) struct EventRecord<'a>(Vec<(&'static str, Cell<'a>)>);

/// The content of a field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Cell<'a> {
    Empty,
    Text(&'a str),
    Integer(u64),
    Number(f64),
    Values(&'a [Sample]),
}

impl<'a> EventRecord<'a> {
    /// Names of the fields, in the order of a table.
    pub(super) const FIELDS: [&'static str; 22] = [
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
        // The client that gave the command, or answered the alarm.
        "by",
        // Time of a mark; beginning of an outage or an alarm.
        "begin_s",
        // End of an outage; empty if it lasts at the end of the capture.
        "end_s",
        // Lines lost in an outage, at least and at most; the second is empty if no clock shows it.
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
        // One of its values: name and value; CSV only. A parameter that the robot reported. The value of an alarm.
        "field",
        "value",
        // Text of a note.
        "note",
        // Frames sent for the command so far; waypoints acknowledged, of the list's.
        "frames",
        "acknowledged",
        "total",
    ];

    /// The record of an event; `None` for other kinds.
    pub(super) fn of(at: Duration, event: &'a StationEvent) -> Option<Self> {
        let ago = |ns| milliseconds(at.saturating_sub(Duration::from_nanos(ns)));
        let text = |text: &'a Option<String>| text.as_deref().into();
        Some(Self(match event.kind.as_ref()? {
            StationEventKind::Command(event) => vec![
                ("event", "command".into()),
                ("command_id", event.command_id.into()),
                ("status", Cell::Text(&event.status)),
                ("command", text(&event.command)),
                ("code", text(&event.code)),
                ("by", text(&event.by)),
                ("field", text(&event.parameter_name)),
                ("value", event.parameter_value.map(f64::from).into()),
                ("frames", event.frames.into()),
                ("acknowledged", event.acknowledged.into()),
                ("total", event.total.into()),
            ],
            StationEventKind::Mark(mark) => vec![
                ("event", "mark".into()),
                ("status", if mark.is_set { "set" } else { "cleared" }.into()),
                ("begin_s", ago(mark.ago_ns).into()),
            ],
            StationEventKind::Alarm(alarm) => vec![
                ("event", "alarm".into()),
                ("status", alarm.status.as_str().into()),
                ("code", alarm.code.as_str().into()),
                ("by", text(&alarm.by)),
                ("begin_s", alarm.ago_ns.map(ago).into()),
                ("severity", alarm.severity.as_str().into()),
                ("limit", alarm.limit.into()),
                (
                    "unit",
                    Some(&*alarm.unit).filter(|unit| !unit.is_empty()).into(),
                ),
                (
                    "shelved_s",
                    alarm
                        .shelved_ns
                        .map(|ns| milliseconds(Duration::from_nanos(ns)))
                        .into(),
                ),
                ("value", alarm.value.into()),
            ],
            _ => return None,
        }))
    }

    /// The record of a line of the robot's own.
    pub(super) fn of_own(line: &'a OwnLine, values: &'a [Sample]) -> Self {
        let values = if values.is_empty() {
            Cell::Empty
        } else {
            Cell::Values(values)
        };
        Self(vec![
            ("event", "own".into()),
            ("own", line.text.as_str().into()),
            ("values", values),
        ])
    }

    /// The record of one value in a line of the robot's own.
    pub(super) fn of_value(sample: &'a Sample) -> Self {
        Self(vec![
            ("event", "own".into()),
            ("field", sample.field.name.as_str().into()),
            ("value", (&sample.value).into()),
        ])
    }

    /// The record of a note in the label.
    pub(super) fn of_note(note: &'a Note) -> Self {
        Self(vec![
            ("event", "note".into()),
            ("note", note.text.as_str().into()),
        ])
    }

    /// The record of an outage.
    pub(super) fn of_outage(outage: &Outage) -> Self {
        Self(vec![
            ("event", "outage".into()),
            ("code", outage.cause.code().into()),
            ("begin_s", milliseconds(outage.begin).into()),
            ("end_s", outage.end.map(milliseconds).into()),
            ("lines_lost", Cell::Integer(outage.lost.min)),
            (
                "lines_lost_max",
                outage.lost.known_max().map(Cell::Integer).into(),
            ),
        ])
    }

    pub(super) fn write_json(&self, output: &mut Vec<u8>, at: Duration) -> io::Result<()> {
        output.write_all(b"{\"at_s\":")?;
        write_seconds(output, at)?;
        for (name, cell) in &self.0 {
            if *cell != Cell::Empty {
                write_name(output, name)?;
                cell.write_json(output)?;
            }
        }
        output.write_all(b"}\n")
    }

    pub(super) fn write_csv(&self, output: &mut Vec<u8>, at: Duration) -> io::Result<()> {
        write_seconds(output, at)?;
        write_commas(output, Telemetry::FIELDS.len())?;
        self.write_cells(output, &Self::FIELDS)
    }

    /// Appends the cells of these fields, which are in the order of a table and hold all with a content, and the end of the row.
    pub(super) fn write_cells(&self, output: &mut Vec<u8>, names: &[&str]) -> io::Result<()> {
        let with_content = |(_, cell): &&(_, Cell<'_>)| *cell != Cell::Empty;
        let mut cells = self.0.iter().filter(with_content).peekable();
        for name in names {
            output.write_all(b",")?;
            if let Some((_, cell)) = cells.next_if(|(of, _)| of == name) {
                cell.write_csv(output)?;
            }
        }
        output.write_all(b"\n")
    }

    /// Names of the fields with a content.
    pub(super) fn names(&self) -> impl Iterator<Item = &'static str> {
        let cells = self.0.iter().filter(|(_, cell)| *cell != Cell::Empty);
        cells.map(|(name, _)| *name)
    }
}

impl Cell<'_> {
    pub(super) fn write_csv(&self, output: &mut Vec<u8>) -> io::Result<()> {
        match self {
            Self::Text(text) => write_csv_text(output, text),
            cell => cell.write_json(output),
        }
    }

    fn write_json(&self, output: &mut Vec<u8>) -> io::Result<()> {
        match self {
            Self::Empty => Ok(()),
            Self::Text(text) => Ok(to_writer(output, text)?),
            Self::Integer(integer) => Ok(to_writer(output, integer)?),
            Self::Number(number) => Ok(to_writer(output, number)?),
            Self::Values(samples) => {
                let mut separator = b'{';
                for (at, sample) in samples.iter().enumerate() {
                    // Of a field that a line contains twice, the last value counts.
                    if is_repeated(sample, &samples[at + 1..]) {
                        continue;
                    }
                    output.push(std::mem::replace(&mut separator, b','));
                    to_writer(&mut *output, &sample.field.name)?;
                    output.push(b':');
                    Cell::from(&sample.value).write_json(output)?;
                }
                output.write_all(b"}")
            }
        }
    }
}

impl<'a> From<&'a str> for Cell<'a> {
    fn from(text: &'a str) -> Self {
        Self::Text(text)
    }
}

impl From<u32> for Cell<'_> {
    fn from(integer: u32) -> Self {
        Self::Integer(integer.into())
    }
}

impl From<f64> for Cell<'_> {
    fn from(number: f64) -> Self {
        if number.is_finite() {
            Self::Number(number)
        } else {
            Self::Empty
        }
    }
}

impl<'a> From<&'a Value> for Cell<'a> {
    fn from(value: &'a Value) -> Self {
        match value {
            Value::Number(number) => (*number).into(),
            Value::Text(text) => Self::Text(text),
        }
    }
}

impl<T: Into<Self>> From<Option<T>> for Cell<'_> {
    fn from(cell: Option<T>) -> Self {
        cell.map_or(Self::Empty, Into::into)
    }
}

/// Whether a line contains the field of a sample again.
fn is_repeated(sample: &Sample, later: &[Sample]) -> bool {
    later.iter().any(|it| it.field.name == sample.field.name)
}

/// Seconds, rounded to milliseconds.
fn milliseconds(at: Duration) -> f64 {
    (at.as_secs_f64() * 1000.0).round() / 1000.0
}
