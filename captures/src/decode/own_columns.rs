//! The table of a capture that has only lines of the robot's own: a column for each of their fields.

use std::io::{self, Write};
use std::time::Duration;

use groundwave_lines::{OwnLine, Sample};
use groundwave_protocol::decoder::Received;

use super::events::{Cell, EventRecord};
use super::{DecodeError, Notes, Records, Sink, write_commas, write_csv_text, write_seconds};
use crate::runs::label::Note;
use crate::{Capture, CaptureError};

/// Columns of a table of the robot's own lines: `at_s`, its fields in the order in which they came, and the fields of `EventRecord` that
/// have a content. There are at most as many fields as the station distinguishes, [`groundwave_lines::FIELDS_MAX`].
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct OwnColumns {
    fields: Vec<String>,
    events: Vec<&'static str>,
}

impl OwnColumns {
    /// The columns of a capture with these notes; `None` if it has a line of the protocol, or no value of the robot's own. A capture that
    /// cannot be read to its end has the columns of its readable part.
    ///
    /// # Errors
    /// If the capture cannot be read at all.
    pub fn of(capture: &mut Capture, notes: &[Note]) -> Result<Option<Self>, CaptureError> {
        let mut records = Records {
            sink: Survey::default(),
            notes: Notes::of(notes),
            own_lines: 0,
            own_texts: 0,
        };
        match records.read_all(capture, &mut None) {
            Err(DecodeError::Capture(error)) if records.own_lines == 0 => return Err(error),
            _ => {}
        }
        let Survey { has_lines, columns } = records.sink;
        Ok((!has_lines && !columns.fields.is_empty()).then(|| columns.in_order()))
    }

    fn in_order(mut self) -> Self {
        let used = |name: &&str| self.events.contains(name);
        self.events = EventRecord::FIELDS.into_iter().filter(used).collect();
        self
    }

    pub(super) fn write_header(&self, output: &mut impl Write) -> io::Result<()> {
        let mut header = b"at_s".to_vec();
        for name in &self.fields {
            header.push(b',');
            // No two columns have the same name.
            let mut name = name.clone();
            if name == "at_s" || EventRecord::FIELDS.contains(&name.as_str()) {
                name.insert_str(0, "own_");
                while self.fields.contains(&name) {
                    name.insert_str(0, "own_");
                }
            }
            write_csv_text(&mut header, &name)?;
        }
        for name in &self.events {
            write!(header, ",{name}")?;
        }
        header.push(b'\n');
        output.write_all(&header)
    }

    pub(super) fn write_values(
        &self,
        output: &mut Vec<u8>,
        at: Duration,
        values: &[Sample],
    ) -> io::Result<()> {
        write_seconds(output, at)?;
        for name in &self.fields {
            output.write_all(b",")?;
            // Of a field that a line contains twice, the last value counts.
            if let Some(sample) = values.iter().rfind(|it| it.field.name == *name) {
                Cell::from(&sample.value).write_csv(output)?;
            }
        }
        write_commas(output, self.events.len())?;
        output.write_all(b"\n")
    }

    pub(super) fn write_event(
        &self,
        output: &mut Vec<u8>,
        at: Duration,
        event: &EventRecord<'_>,
    ) -> io::Result<()> {
        write_seconds(output, at)?;
        write_commas(output, self.fields.len())?;
        event.write_cells(output, &self.events)
    }
}

/// Finds the columns.
#[derive(Default)]
struct Survey {
    has_lines: bool,
    columns: OwnColumns,
}

impl Sink for Survey {
    fn take_line(&mut self, _: Duration, _: &Received) -> io::Result<()> {
        self.has_lines = true;
        // The table has the columns of the protocol, so nothing else is to be found.
        Err(io::ErrorKind::Interrupted.into())
    }

    fn take_values(&mut self, _: Duration, _: &OwnLine, values: &[Sample]) -> io::Result<()> {
        for sample in values {
            let name = &sample.field.name;
            if !self.columns.fields.contains(name) {
                self.columns.fields.push(name.clone());
            }
        }
        Ok(())
    }

    fn take_event(&mut self, _: Duration, event: &EventRecord<'_>) -> io::Result<()> {
        for name in event.names() {
            if !self.columns.events.contains(&name) {
                self.columns.events.push(name);
            }
        }
        Ok(())
    }
}
