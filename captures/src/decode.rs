//! Captures as JSON lines and as CSV.
//!
//! Both have one record per line of the robot: `at_s`, the time since the capture began, then the fields of [`Telemetry`]. Commands,
//! marks, notes, alarms, outages and lines of the robot's own are records with the fields of `EventRecord`; its field `event` names the kind. A field that a record does not
//! have is left out in JSON and empty in CSV. A capture without lines of the protocol can have a table with a column for each of its fields: [`OwnColumns`].

mod events;
mod own_columns;

use std::io::{self, Write};
use std::time::Duration;

use groundwave_lines::{Content, OwnLine, Sample};
use groundwave_protocol::decoder::Received;
use serde_json::to_writer;

use super::diagnosis::{Diagnosis, Finding, Line};
use super::messages::{Telemetry, Value};
use super::outages::OutageList;
use super::own_lines::{are_robots, recognizer};
use super::runs::label::Note;
use super::statistics::Damaged;
use super::{Capture, CaptureError, Piece};
use events::EventRecord;
pub use own_columns::OwnColumns;

/// Output format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format<'a> {
    /// One JSON object per line.
    Jsonl,
    /// One table with a header. Each value in a line of the robot's own has a row.
    Csv,
    /// One table with these columns. Each line of the robot's own has a row.
    OwnCsv(&'a OwnColumns),
}

/// Reason why decoding ended early; everything before it has been written.
#[derive(Debug, thiserror::Error)]
pub enum DecodeError {
    /// The capture cannot be read.
    #[error(transparent)]
    Capture(#[from] CaptureError),
    /// The output cannot be written. A broken pipe means that the reader has closed it.
    #[error("cannot write: {0}")]
    Output(#[from] io::Error),
}

/// Writes each intact line, command, mark, alarm, outage and line of the robot's own of a capture, and the notes of its label at their
/// moments; notes about the whole run come first. `output` should be buffered unless it is a terminal.
///
/// # Errors
/// If reading the capture or writing the output fails.
pub fn decode(
    capture: &mut Capture,
    notes: &[Note],
    format: Format<'_>,
    output: &mut impl Write,
) -> Result<Decoded, DecodeError> {
    match format {
        Format::Jsonl => {}
        Format::Csv => write_header(output)?,
        Format::OwnCsv(columns) => columns.write_header(output)?,
    }
    let mut records = Records {
        sink: Writer {
            format,
            output: &mut *output,
            record: Vec::new(),
        },
        notes: Notes::of(notes),
        own_lines: 0,
        own_texts: 0,
    };
    let mut diagnosis = None;
    let result = records.read_all(capture, &mut diagnosis);
    let (values, texts) = (records.own_lines, records.own_texts);
    output.flush()?;
    result?;
    let diagnosis = diagnosis.unwrap_or_default();
    let counters = diagnosis.counters();
    let damaged = Damaged::of(counters).lines();
    let own_lines = if are_robots(capture.form(), values, texts, damaged) {
        values + texts
    } else {
        0
    };
    Ok(Decoded {
        bytes: counters.bytes,
        lines: counters.received() + own_lines,
        mistakes: diagnosis.findings(),
    })
}

/// Counts and mistakes of a decoded capture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Decoded {
    /// Number of bytes received.
    pub bytes: u64,
    /// Number of intact lines, and lines of the robot's own.
    pub lines: u64,
    /// Mistakes in the robot's lines.
    pub mistakes: Vec<Finding>,
}

/// Takes the records of a capture one at a time. An error ends the reading.
trait Sink {
    fn take_line(&mut self, at: Duration, received: &Received) -> io::Result<()>;
    fn take_values(&mut self, at: Duration, line: &OwnLine, values: &[Sample]) -> io::Result<()>;
    fn take_event(&mut self, at: Duration, event: &EventRecord<'_>) -> io::Result<()>;
}

/// Writes records.
struct Writer<'a, W> {
    format: Format<'a>,
    output: W,
    record: Vec<u8>,
}

/// Reads the records of a capture.
struct Records<'a, S> {
    sink: S,
    notes: Notes<'a>,
    /// Numbers of lines of the robot's own with values and without.
    own_lines: u64,
    own_texts: u64,
}

/// Notes still to be written, in descending order of their moments.
struct Notes<'a>(Vec<(Duration, &'a Note)>);

impl<'a> Notes<'a> {
    fn of(notes: &'a [Note]) -> Self {
        let at = |note: &Note| Duration::try_from_secs_f64(note.at_s.unwrap_or(0.0));
        let mut notes: Vec<_> = notes
            .iter()
            .map(|note| (at(note).unwrap_or_default(), note))
            .collect();
        notes.sort_by_key(|(at, _)| *at);
        notes.reverse();
        Self(notes)
    }

    /// The next note, if its moment has come.
    fn next(&mut self, now: Duration) -> Option<(Duration, &'a Note)> {
        self.0.pop_if(|(at, _)| *at <= now)
    }
}

impl<S: Sink> Records<'_, S> {
    fn read_all(
        &mut self,
        capture: &mut Capture,
        diagnosis: &mut Option<Diagnosis>,
    ) -> Result<(), DecodeError> {
        let (mut outages, mut now) = (OutageList::default(), Duration::ZERO);
        let mut written = 0;
        let end = loop {
            let table = if diagnosis.is_none() {
                capture.session_ahead()?
            } else {
                None
            };
            let has_time = match capture.has_time_ahead() {
                Ok(has_time) => has_time,
                Err(error) => break Err(error),
            };
            let (at, piece) = match capture.next_piece() {
                Ok(Some(piece)) => piece,
                end => break end,
            };
            now = at;
            self.take_notes(now)?;
            match piece {
                Piece::Received(bytes) => {
                    let diagnosis =
                        diagnosis.get_or_insert_with(|| Diagnosis::new(recognizer(table.as_ref())));
                    if has_time {
                        diagnosis.set_time(at);
                    }
                    diagnosis.each_line(bytes, |line, counters| match line {
                        Line::Wire(received) => {
                            outages.handle_line(at, received, counters);
                            self.sink.take_line(at, received)
                        }
                        Line::Own(line) => self.take_own(at, line),
                    })?;
                }
                Piece::Missing(_) | Piece::Damaged(_) => {
                    diagnosis.iter_mut().for_each(Diagnosis::skip);
                    outages.handle_missing();
                }
                Piece::Event(event) => {
                    if event.is_loss_of_link() {
                        diagnosis.iter_mut().for_each(Diagnosis::interrupt);
                    }
                    outages.handle_event(at, &event);
                    if let Some(event) = EventRecord::of(at, &event) {
                        self.sink.take_event(at, &event)?;
                    }
                }
                Piece::Sent(_) | Piece::Repeated(_) => {}
            }
            for outage in &outages.ended()[written..] {
                self.sink.take_event(at, &EventRecord::of_outage(outage))?;
            }
            written = outages.ended().len();
        };
        for (received, counters) in diagnosis.iter().flat_map(Diagnosis::undecided_lines) {
            outages.handle_line(now, &received, counters);
            self.sink.take_line(now, &received)?;
        }
        let counters = diagnosis.as_ref().map(|it| it.counters_until(now));
        for outage in &outages.into_outages(now, &counters.unwrap_or_default())[written..] {
            self.sink.take_event(now, &EventRecord::of_outage(outage))?;
        }
        self.take_notes(Duration::MAX)?;
        end?;
        Ok(())
    }

    /// Takes the notes whose moment has come.
    fn take_notes(&mut self, now: Duration) -> io::Result<()> {
        while let Some((at, note)) = self.notes.next(now) {
            self.sink.take_event(at, &EventRecord::of_note(note))?;
        }
        Ok(())
    }

    fn take_own(&mut self, at: Duration, line: &OwnLine) -> io::Result<()> {
        match &line.content {
            Content::Damaged => Ok(()),
            Content::Text => {
                self.own_texts += 1;
                self.sink.take_event(at, &EventRecord::of_own(line, &[]))
            }
            Content::Values(values) => {
                self.own_lines += 1;
                self.sink.take_values(at, line, values)
            }
        }
    }
}

impl<W: Write> Sink for Writer<'_, W> {
    fn take_line(&mut self, at: Duration, received: &Received) -> io::Result<()> {
        self.record.clear();
        match self.format {
            Format::Jsonl => write_json(&mut self.record, at, received),
            Format::Csv => write_csv(&mut self.record, at, received),
            // Its columns were found in a capture without such lines.
            Format::OwnCsv(_) => Ok(()),
        }?;
        self.output.write_all(&self.record)
    }

    fn take_values(&mut self, at: Duration, line: &OwnLine, values: &[Sample]) -> io::Result<()> {
        match self.format {
            Format::Csv if !values.is_empty() => {
                let mut rows = values.iter().map(EventRecord::of_value);
                rows.try_for_each(|row| self.take_event(at, &row))
            }
            Format::OwnCsv(columns) => {
                self.record.clear();
                columns.write_values(&mut self.record, at, values)?;
                self.output.write_all(&self.record)
            }
            _ => self.take_event(at, &EventRecord::of_own(line, values)),
        }
    }

    fn take_event(&mut self, at: Duration, event: &EventRecord<'_>) -> io::Result<()> {
        self.record.clear();
        match self.format {
            Format::Jsonl => event.write_json(&mut self.record, at),
            Format::Csv => event.write_csv(&mut self.record, at),
            Format::OwnCsv(columns) => columns.write_event(&mut self.record, at, event),
        }?;
        self.output.write_all(&self.record)
    }
}

fn write_header(output: &mut impl Write) -> io::Result<()> {
    output.write_all(b"at_s")?;
    for field in Telemetry::FIELDS {
        write!(output, ",{}", field.name)?;
    }
    for name in EventRecord::FIELDS {
        write!(output, ",{name}")?;
    }
    output.write_all(b"\n")
}

/// Appends one line of the robot as a JSON object and a line feed.
///
/// # Errors
/// None: writing to a vector cannot fail.
pub fn write_json(output: &mut Vec<u8>, at: Duration, received: &Received) -> io::Result<()> {
    output.write_all(b"{\"at_s\":")?;
    write_seconds(output, at)?;
    Telemetry::from(received).for_each(|name, value| {
        let Some(value) = value else {
            return Ok(());
        };
        write_name(output, name)?;
        match value {
            Value::Text(text) | Value::Word(text) => Ok(to_writer(&mut *output, text)?),
            number => write_number(output, number),
        }
    })?;
    output.write_all(b"}\n")
}

/// Appends the name of a field that is not the first of its object.
fn write_name(output: &mut Vec<u8>, name: &str) -> io::Result<()> {
    let mut parts = [",\"", name, "\":"].into_iter();
    parts.try_for_each(|part| output.write_all(part.as_bytes()))
}

fn write_csv(output: &mut Vec<u8>, at: Duration, received: &Received) -> io::Result<()> {
    write_seconds(output, at)?;
    Telemetry::from(received).for_each(|_, value| {
        output.write_all(b",")?;
        match value {
            None => Ok(()),
            Some(Value::Text(text)) => write_csv_text(output, text),
            Some(Value::Word(word)) => output.write_all(word.as_bytes()),
            Some(number) => write_number(output, number),
        }
    })?;
    write_commas(output, EventRecord::FIELDS.len())?;
    output.write_all(b"\n")
}

fn write_commas(output: &mut Vec<u8>, count: usize) -> io::Result<()> {
    output.write_all(&COMMAS[..count.min(COMMAS.len())])
}

/// Empty fields of a table.
const COMMAS: &[u8] = &[b','; 128];

fn write_csv_text(output: &mut Vec<u8>, text: &str) -> io::Result<()> {
    if text.contains([',', '"', '\n', '\r']) {
        write!(output, "\"{}\"", text.replace('"', "\"\""))
    } else {
        output.write_all(text.as_bytes())
    }
}

fn write_seconds(output: &mut Vec<u8>, at: Duration) -> io::Result<()> {
    to_writer(&mut *output, &at.as_secs())?;
    let milliseconds = at.subsec_millis();
    let digit = |unit: u32| b'0' + (milliseconds / unit % 10) as u8;
    output.write_all(&[b'.', digit(100), digit(10), digit(1)])
}

fn write_number(output: &mut Vec<u8>, value: Value<'_>) -> io::Result<()> {
    match value {
        Value::Integer(value) => Ok(to_writer(output, &value)?),
        Value::Decimal(value) => write!(output, "{value:.1}"),
        Value::Word(text) | Value::Text(text) => output.write_all(text.as_bytes()),
    }
}
