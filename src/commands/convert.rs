//! `convert`: raw captures to MCAP and back.

use std::io::Write;
use std::ops::ControlFlow;
use std::path::Path;

use super::cli::Convert;
use super::opening::Source;
use super::output::{Output, Target, targets};
use super::progress::Progress;
use super::{Exit, Fault, keeping, many, opening, say};
use crate::capture::convert::{ConvertError, convert_raw};
use crate::capture::source::Form;
use crate::capture::when::When;
use crate::capture::{Capture, CaptureError};

/// What became of a capture.
#[derive(Default)]
struct Made {
    bytes: u64,
    missing_bytes: u64,
    problem: Option<Fault>,
}

pub(super) fn run(options: &Convert) -> Result<(), Fault> {
    let files = many::files(&options.captures)?;
    let targets = targets(&files, &options.output, |path| {
        Ok(other_form(path)?.to_owned())
    })?;
    many::each(
        &files,
        options.captures.quiet,
        |index, progress| {
            let (path, target) = (&files[index], &targets[index]);
            let source = opening::open(path, progress)?;
            let (form, source) = opening::tell_form(path, source)?;
            match form {
                Form::Mcap => to_raw(path, source, target),
                Form::Raw => to_mcap(options, path, source, target),
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
                return Err(opening::not_whole(&files[index], &problem));
            }
            made.problem.map_or(Ok(ControlFlow::Continue(())), Err)
        },
    )
}

/// The ending of the name that a capture has in its other form.
fn other_form(path: &Path) -> Result<&'static str, Fault> {
    let source = opening::open(path, &Progress::new(None, true))?;
    let (form, _) = opening::tell_form(path, source)?;
    Ok(match form {
        Form::Mcap => "txt",
        Form::Raw => "mcap",
    })
}

/// The bytes of the radio as they came.
fn to_raw(path: &Path, source: Source, target: &Target) -> Result<Made, Fault> {
    let mut capture = Capture::read(path, source).map_err(keeping::fault)?;
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
                made.problem = Some(keeping::fault(error));
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
    let mut output = Output::create(target)?;
    match convert_raw(source, start_ns, &mut output) {
        Ok(converted) => output.finish().map(|()| Made {
            bytes: converted.bytes,
            ..Made::default()
        }),
        Err(ConvertError::Read(error)) => Err(opening::cannot_read(path, error)),
        Err(ConvertError::Write(error)) => output.fault(&error).map(|()| Made::default()),
    }
}
