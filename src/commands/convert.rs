//! `convert`: raw captures to MCAP and back.

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

/// So far is looked for a line of a robot before anything is written.
const LOOK_BYTES: u64 = 1024 * 1024;

/// What became of a capture.
#[derive(Default)]
struct Made {
    bytes: u64,
    missing_bytes: u64,
    problem: Option<Fault>,
}

pub(super) fn run(options: &Convert) -> Result<(), Fault> {
    let files = batch::files(&options.captures)?;
    let targets = targets(&files, &options.output, |path| {
        // One that cannot be read is told of in its turn, and does not hide the others.
        Ok(other_form(path).unwrap_or("mcap").to_owned())
    })?;
    batch::each(
        &files,
        options.captures.quiet,
        |index, progress| {
            let (path, target) = (&files[index], &targets[index]);
            let source = input::open(path, progress)?;
            let (form, source) = input::tell_form(path, source)?;
            match form {
                Form::Mcap => {
                    let remedy = "name it .txt; `groundwave cut` makes MCAP of MCAP";
                    check_form(target, Form::Raw, remedy)?;
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
                say(format_args!("{file}: {bytes} bytes of the radio"));
            }
            if made.missing_bytes > 0 && made.problem.is_none() {
                let missing = made.missing_bytes;
                let problem = format!("{missing} bytes of the radio are not in it");
                return Err(input::not_whole(&files[index], &problem));
            }
            made.problem.map_or(Ok(ControlFlow::Continue(())), Err)
        },
    )
}

/// The ending of the name that a capture has in its other form.
fn other_form(path: &Path) -> Result<&'static str, Fault> {
    let source = input::open(path, &Progress::new(None, true))?;
    let (form, _) = input::tell_form(path, source)?;
    Ok(match form {
        Form::Mcap => "txt",
        Form::Raw => "mcap",
    })
}

/// The bytes of the radio as they came.
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
            // What could be read is written, and it is said that it is not all.
            Err(error) => {
                made.problem = Some(Fault::from(error));
                break;
            }
        }
    }
    made.missing_bytes = capture.missing_bytes();
    output.finish().map(|()| made)
}

/// Every topic that a recording has.
fn to_mcap(options: &Convert, path: &Path, source: Source, target: &Target) -> Result<Made, Fault> {
    let start_ns = match options.start {
        None => None,
        Some(When::Wall(ns)) => Some(ns),
        Some(When::Since(_)) => {
            let problem = "--start is a time by the clock: 2025-03-14T09:26:53Z";
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
        // What is no capture shall not look like one.
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

/// A source in which a line of a robot has been seen, or too much to look at all of it; so that of what is no capture
/// not even a beginning goes to standard output.
fn with_a_line(path: &Path, source: Source) -> Result<Source, Fault> {
    let mut looked = Looked {
        source,
        kept: Vec::new(),
    };
    let mut reader = TextReader::new(&mut looked);
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
    let Looked { source, kept } = looked;
    Ok(Box::new(Cursor::new(kept).chain(source)))
}

/// Keeps what is read.
struct Looked {
    source: Source,
    kept: Vec<u8>,
}

impl Read for Looked {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = self.source.read(buffer)?;
        self.kept.extend(&buffer[..read]);
        Ok(read)
    }
}
