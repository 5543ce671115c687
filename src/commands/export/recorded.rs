//! Exports captures as recordings and as raw text.

use std::io::{self, Cursor, Read, Write};
use std::path::Path;

use super::super::cli::Export;
use super::super::input::{self, Source};
use super::super::output::{Output, Target, check_form};
use super::super::progress::Progress;
use super::super::{Exit, Fault};
use super::Made;
use crate::capture::CaptureError;
use crate::capture::convert::{ConvertError, convert_raw};
use crate::capture::diagnosis::Diagnosis;
use crate::capture::source::Form;
use crate::capture::text::TextReader;
use crate::capture::when::When;

/// Number of bytes searched for a line before anything is written.
const LOOK_BYTES: u64 = 1024 * 1024;

/// Writes the received bytes.
pub(super) fn to_raw(path: &Path, progress: &Progress, target: &Target) -> Result<Made, Fault> {
    check_form(target, Form::Raw, "name it .txt")?;
    let mut capture = input::open_capture(path, progress)?;
    let mut output = Output::create(target)?;
    let (mut bytes, mut problem) = (0, None);
    loop {
        match capture.next_chunk() {
            Ok(Some(chunk)) => {
                bytes += chunk.bytes.len() as u64;
                if let Err(error) = output.write_all(chunk.bytes) {
                    return output.fault(&error).map(|()| Made::default());
                }
            }
            Ok(None) => break,
            Err(error @ CaptureError::NoRawBytes(_)) => {
                return Err(Fault::new(Exit::Usage, error));
            }
            // The readable part is written; report that a part is missing.
            Err(error) => {
                problem = Some(Fault::from(error));
                break;
            }
        }
    }
    let missing = capture.missing_bytes();
    if missing > 0 && problem.is_none() {
        let words = format!("{missing} received bytes are missing");
        problem = Some(input::not_whole(path, &words));
    }
    output.finish().map(|()| made(bytes, problem))
}

fn made(bytes: u64, problem: Option<Fault>) -> Made {
    let what = format!("{bytes} received bytes");
    Made {
        what,
        problem,
        mistakes: None,
    }
}

/// Writes a recording with all topics.
pub(super) fn to_mcap(
    options: &Export,
    path: &Path,
    progress: &Progress,
    target: &Target,
) -> Result<Made, Fault> {
    check_form(target, Form::Mcap, "name it .mcap")?;
    let (form, source) = input::detect_form(path, input::open(path, progress)?)?;
    if form == Form::Mcap {
        let hint =
            "is MCAP already; `groundwave cut` makes a part of it, `groundwave recover` repairs it";
        return Err(Fault::new(
            Exit::Usage,
            format!("{} {hint}", path.display()),
        ));
    }
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
        Ok(converted) => output.finish().map(|()| made(converted.bytes, None)),
        Err(ConvertError::Read(error)) => Err(input::cannot_read(path, error)),
        Err(ConvertError::Write(error)) => output.fault(&error).map(|()| Made::default()),
    }
}

/// Searches the beginning of a source for a line, because nothing is written for a file that is not a capture; returns
/// the whole source.
fn with_a_line(path: &Path, source: Source) -> Result<Source, Fault> {
    let mut copy = Copying {
        source,
        kept: Vec::new(),
    };
    let mut reader = TextReader::new(&mut copy);
    let mut diagnosis = Diagnosis::default();
    let mut bytes = 0;
    let failed = |error| input::cannot_read(path, error);
    while bytes < LOOK_BYTES {
        let Some(piece) = reader.next_piece().map_err(failed)? else {
            return Err(Fault::no_lines(path, bytes));
        };
        bytes += piece.radio.len() as u64;
        if diagnosis.finds_line(piece.radio) {
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
