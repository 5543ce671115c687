//! `decode`: a capture as JSON lines or CSV.

use std::io::{self, BufWriter};
use std::path::Path;

use super::Fault;
use super::cli::{Decode, DecodeFormat};
use crate::capture::Capture;
use crate::capture::decode::{DecodeError, Format, decode};

pub(super) fn run(options: &Decode) -> Result<(), Fault> {
    let mut capture = Capture::open(&options.file)?;
    let format = match options.to {
        DecodeFormat::Jsonl => Format::Jsonl,
        DecodeFormat::Csv => Format::Csv,
    };
    let out = io::stdout().lock();
    // A live stream is written unbuffered, line by line.
    let result = if options.file == Path::new("-") {
        decode(&mut capture, format, &mut { out })
    } else {
        decode(
            &mut capture,
            format,
            &mut BufWriter::with_capacity(1 << 16, out),
        )
    };
    match result {
        Ok(seen) if seen.lines + seen.ack_lines == 0 => {
            Err(Fault::no_lines(&options.file, seen.bytes))
        }
        Ok(_) => Ok(()),
        Err(DecodeError::Capture(error)) => Err(Fault::from(error)),
        Err(DecodeError::Output(error)) => Fault::output(&error),
    }
}
