//! Captures as JSON lines and as CSV.
//!
//! Both have one record per line of the robot: `at_s`, the time since the capture began, then the fields of [`Telemetry`]. A field
//! that a line does not have is left out in JSON and empty in CSV.

use std::io::{self, Write};
use std::time::Duration;

use groundwave_protocol::decoder::{Counters, Decoder, Received};

use super::messages::{Telemetry, Value};
use super::{Capture, CaptureError};

/// Output format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// One JSON object per line.
    Jsonl,
    /// One table with a header.
    Csv,
}

/// Reason why decoding ended early; everything before it has been written.
#[derive(Debug, thiserror::Error)]
pub enum DecodeError {
    /// The capture cannot be read.
    #[error(transparent)]
    Capture(#[from] CaptureError),
    /// The output cannot be written. A broken pipe means that the reader has seen enough.
    #[error("cannot write: {0}")]
    Output(#[from] io::Error),
}

/// Writes each intact line of a capture; returns the decoder's totals. `output` should be buffered unless it is a
/// terminal.
///
/// # Errors
/// When reading the capture or writing the output fails.
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
/// None: writing to a vector cannot fail.
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
