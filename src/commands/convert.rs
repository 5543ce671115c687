//! `convert`: raw text to MCAP and back.

use std::io::{self, Cursor, Read, Write};
use std::ops::ControlFlow;
use std::path::Path;

use groundwave_protocol::decoder::Decoder;

use super::cli::Convert;
use super::input::Source;
use super::output::{Output, Target, check_form, targets};
use super::progress::Progress;
use super::{Exit, Fault, batch, input, say};
use crate::capture::convert::{ConvertError, convert_raw};
use crate::capture::source::Form;
use crate::capture::text::TextReader;
use crate::capture::when::When;
use crate::capture::{Capture, CaptureError};

/// Bytes searched for a line before anything is written.
const LOOK_BYTES: u64 = 1024 * 1024;

/// The result for a capture.
#[derive(Default)]
struct Made {
    bytes: u64,
    missing_bytes: u64,
    problem: Option<Fault>,
}

pub(super) fn run(options: &Convert) -> Result<(), Fault> {
    let files = batch::files(&options.captures)?;
    let targets = targets(&files, &options.output, |path| {
        // A file that cannot be read is reported later, in its turn.
        Ok(other_form(path).unwrap_or("mcap").to_owned())
    })?;
    batch::each(
        &files,
        options.captures.quiet,
        |index, progress| {
            let (path, target) = (&files[index], &targets[index]);
            let source = input::open(path, progress)?;
            let (form, source) = input::detect_form(path, source)?;
            match form {
                Form::Mcap => {
                    let hint = "name it .txt; `groundwave cut` makes MCAP of MCAP";
                    check_form(target, Form::Raw, hint)?;
                    to_raw(path, source, target)
                }
                Form::Raw => {
                    check_form(target, Form::Mcap, "name it .mcap")?;
                    to_mcap(options, path, source, target)
                }
            }
        },
        |index, made| {
            if let Target::File(file, _) = &targets[index]
                && !options.captures.quiet
            {
                let (bytes, file) = (made.bytes, file.display());
                say(format_args!("{file}: {bytes} received bytes"));
            }
            if made.missing_bytes > 0 && made.problem.is_none() {
                let missing = made.missing_bytes;
                let problem = format!("{missing} received bytes are missing");
                return Err(input::not_whole(&files[index], &problem));
            }
            made.problem.map_or(Ok(ControlFlow::Continue(())), Err)
        },
    )
}

/// The file extension of the other format.
fn other_form(path: &Path) -> Result<&'static str, Fault> {
    let source = input::open(path, &Progress::new(None, true))?;
    let (form, _) = input::detect_form(path, source)?;
    Ok(match form {
        Form::Mcap => "txt",
        Form::Raw => "mcap",
    })
}

/// Writes the received bytes.
fn to_raw(path: &Path, source: Source, target: &Target) -> Result<Made, Fault> {
    let mut capture = Capture::read(path, source)?;
    let mut output = Output::create(target)?;
    let mut made = Made::default();
    loop {
        match capture.next_chunk() {
            Ok(Some(chunk)) => {
                made.bytes += chunk.bytes.len() as u64;
                if let Err(error) = output.write_all(chunk.bytes) {
                    return output.fault(&error).map(|()| Made::default());
                }
            }
            Ok(None) => break,
            Err(error @ CaptureError::NoRawBytes(_)) => {
                return Err(Fault::new(Exit::Usage, error));
            }
            // The readable part is written; report that it is not all.
            Err(error) => {
                made.problem = Some(Fault::from(error));
                break;
            }
        }
    }
    made.missing_bytes = capture.missing_bytes();
    output.finish().map(|()| made)
}

/// Writes a recording with all topics.
fn to_mcap(options: &Convert, path: &Path, source: Source, target: &Target) -> Result<Made, Fault> {
    let start_ns = match options.start {
        None => None,
        Some(When::Wall(ns)) => Some(ns),
        Some(When::Since(_)) => {
            let problem = "--start takes a date, such as 2025-03-14T09:26:53Z";
            return Err(Fault::new(Exit::Usage, problem));
        }
    };
    let source = if options.anyway {
        source
    } else {
        with_a_line(path, source)?
    };
    let mut output = Output::create(target)?;
    match convert_raw(source, start_ns, &mut output) {
        // A file without a line is not a capture.
        Ok(converted) if converted.lines == 0 && !options.anyway => {
            Err(Fault::no_lines(path, converted.bytes))
        }
        Ok(converted) => output.finish().map(|()| Made {
            bytes: converted.bytes,
            ..Made::default()
        }),
        Err(ConvertError::Read(error)) => Err(input::cannot_read(path, error)),
        Err(ConvertError::Write(error)) => output.fault(&error).map(|()| Made::default()),
    }
}

/// Searches the beginning of a source for a line, so that nothing is written for a file that is not a capture; returns
/// the whole source.
fn with_a_line(path: &Path, source: Source) -> Result<Source, Fault> {
    let mut copy = Copying {
        source,
        kept: Vec::new(),
    };
    let mut reader = TextReader::new(&mut copy);
    let mut decoder = Decoder::default();
    let mut bytes = 0;
    let failed = |error| input::cannot_read(path, error);
    while bytes < LOOK_BYTES {
        let Some(piece) = reader.next_piece().map_err(failed)? else {
            return Err(Fault::no_lines(path, bytes));
        };
        bytes += piece.radio.len() as u64;
        if decoder.lines(piece.radio).next().is_some() {
            break;
        }
    }
    let Copying { source, kept } = copy;
    Ok(Box::new(Cursor::new(kept).chain(source)))
}

/// A source that keeps a copy of the bytes read.
struct Copying {
    source: Source,
    kept: Vec<u8>,
}

impl Read for Copying {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = self.source.read(buffer)?;
        self.kept.extend(&buffer[..read]);
        Ok(read)
    }
}
