//! Captures as JSON lines and as CSV.
//!
//! Both have one record a line of the robot, with the field names of [`Telemetry`] after `at_s`, the
//! time since the capture began. JSON leaves out what a line does not say; CSV has every column in
//! every row and leaves the cell empty.

use std::io::{self, Write};
use std::time::Duration;

use groundwave_protocol::decoder::{Counters, Decoder, Received};

use super::messages::{Telemetry, Value};
use super::{Capture, CaptureError};

/// What to write.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// One JSON object a line.
    Jsonl,
    /// One flat table with a header.
    Csv,
}

/// Why decoding ended early. Everything before that has been written.
#[derive(Debug, thiserror::Error)]
pub enum DecodeError {
    /// The capture.
    #[error(transparent)]
    Capture(#[from] CaptureError),
    /// The output. A broken pipe is the reader's way of saying that it has seen enough.
    #[error("cannot write: {0}")]
    Output(#[from] io::Error),
}

/// Writes every intact line of a capture and returns what was seen. Wrap `output` in a buffer, except
/// where somebody watches.
///
/// # Errors
/// When the capture cannot be read on or the output takes no more.
pub fn decode(
    capture: &mut Capture,
    format: Format,
    output: &mut impl Write,
) -> Result<Counters, DecodeError> {
    let mut decoder = Decoder::default();
    if format == Format::Csv {
        write_header(output)?;
    }
    let mut record = Vec::new();
    let result = capture.for_each_line(&mut decoder, |at, received| {
        record.clear();
        match format {
            Format::Jsonl => write_json(&mut record, at, received),
            Format::Csv => write_csv(&mut record, at, received),
        }?;
        output.write_all(&record)?;
        Ok(())
    });
    output.flush()?;
    result.map(|()| *decoder.counters())
}

fn write_header(output: &mut impl Write) -> io::Result<()> {
    output.write_all(b"at_s")?;
    for field in Telemetry::FIELDS {
        write!(output, ",{}", field.name)?;
    }
    output.write_all(b"\n")
}

/// Appends one line of the robot as a JSON object and a line feed.
///
/// # Errors
/// None that a vector could cause.
pub fn write_json(output: &mut Vec<u8>, at: Duration, received: &Received) -> io::Result<()> {
    output.write_all(b"{\"at_s\":")?;
    write_seconds(output, at)?;
    Telemetry::from(received).for_each(|name, value| {
        let Some(value) = value else {
            return Ok(());
        };
        write!(output, ",\"{name}\":")?;
        match value {
            Value::Text(text) => Ok(serde_json::to_writer(&mut *output, text)?),
            Value::Word(word) => write!(output, "\"{word}\""),
            number => write_number(output, number),
        }
    })?;
    output.write_all(b"}\n")
}

fn write_csv(output: &mut Vec<u8>, at: Duration, received: &Received) -> io::Result<()> {
    write_seconds(output, at)?;
    Telemetry::from(received).for_each(|_, value| {
        output.write_all(b",")?;
        match value {
            None => Ok(()),
            Some(Value::Text(text)) if text.contains([',', '"']) => {
                write!(output, "\"{}\"", text.replace('"', "\"\""))
            }
            Some(Value::Text(text)) => output.write_all(text.as_bytes()),
            Some(Value::Word(word)) => output.write_all(word.as_bytes()),
            Some(number) => write_number(output, number),
        }
    })?;
    output.write_all(b"\n")
}

fn write_seconds(output: &mut Vec<u8>, at: Duration) -> io::Result<()> {
    write!(output, "{}.{:03}", at.as_secs(), at.subsec_millis())
}

fn write_number(output: &mut Vec<u8>, value: Value<'_>) -> io::Result<()> {
    match value {
        Value::Integer(value) => write!(output, "{value}"),
        Value::Decimal(value) => write!(output, "{value:.1}"),
        Value::Word(text) | Value::Text(text) => output.write_all(text.as_bytes()),
    }
}
