//! `verify`: checks captures for damage and gaps.

use std::io::{self, Write};
use std::ops::ControlFlow;
use std::path::Path;

use super::cli::Verify;
use super::{Exit, Fault, batch, input, out};
use crate::capture::source::{Form, open_file};
use crate::capture::verify::{RawCopy, Verdict, verify_mcap, verify_raw};

pub(super) fn run(options: &Verify) -> Result<(), Fault> {
    let captures = batch::files(&options.captures)?;
    if options.raw.is_some() && captures.len() > 1 {
        let problem =
            "--raw takes one capture; several are compared with the raw files beside them";
        return Err(Fault::new(Exit::Usage, problem));
    }
    batch::each(
        &captures,
        options.captures.quiet,
        |index, progress| {
            let path = &captures[index];
            let source = input::open(path, progress)?;
            let (form, source) = input::detect_form(path, source)?;
            let verdict = match form {
                Form::Mcap => verify_mcap(source, raw_file(options, path)?),
                Form::Raw => verify_raw(source),
            };
            let verdict = verdict.map_err(|error| input::cannot_read(path, error))?;
            if form == Form::Raw && !verdict.has_lines() {
                return Err(Fault::no_lines(path, verdict.bytes));
            }
            Ok(verdict)
        },
        |index, verdict| {
            if let Err(error) = write(options, &captures[index], &verdict) {
                Fault::output(&error)?;
                return Ok(ControlFlow::Break(()));
            }
            if verdict.is_good() {
                return Ok(ControlFlow::Continue(()));
            }
            let count = verdict.fault_count;
            let faults = if count == 1 { "fault" } else { "faults" };
            Err(input::not_whole(
                &captures[index],
                &format!("{count} {faults}"),
            ))
        },
    )
}

/// The raw file to compare: the named file, or the file beside the recording.
fn raw_file(options: &Verify, path: &Path) -> Result<Option<RawCopy>, Fault> {
    let is_file = path != Path::new("-");
    let raw = || Some(path.with_extension("txt")).filter(|raw| is_file && raw.is_file());
    let Some(raw) = options.raw.clone().or_else(raw) else {
        return Ok(None);
    };
    Ok(Some(RawCopy {
        source: Box::new(open_file(&raw)?),
        is_named: options.raw.is_some(),
    }))
}

fn write(options: &Verify, path: &Path, verdict: &Verdict) -> io::Result<()> {
    let mut out = out();
    if options.json {
        let mut value = serde_json::to_value(verdict)?;
        value["file"] = path.display().to_string().into();
        value["good"] = verdict.is_good().into();
        writeln!(out, "{value}")?;
    } else {
        let good = if verdict.is_good() {
            "good"
        } else {
            "NOT GOOD"
        };
        writeln!(out, "{}: {good}", path.display())?;
        if !options.captures.quiet || !verdict.is_good() {
            verdict.write_text(&mut out)?;
        }
    }
    out.flush()
}
