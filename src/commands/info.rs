//! `info`: summarizes captures.

use std::io::{self, Write};
use std::ops::ControlFlow;
use std::path::Path;

use super::cli::Info;
use super::{Exit, Fault, batch, input, out};
use crate::capture::info;
use crate::capture::runs::label::Label;

pub(super) fn run(options: &Info) -> Result<(), Fault> {
    let files = batch::files(&options.captures)?;
    let mut is_first = true;
    batch::each(
        &files,
        options.captures.quiet,
        |index, progress| {
            let path = &files[index];
            let mut capture = input::open_capture(path, progress)?;
            let info = info::Info::read(&mut capture);
            let label = Label::of(path).map_err(|error| Fault::new(Exit::Failed, error));
            let info = info.with_label(label?);
            if !info.has_lines() && info.problem.is_none() {
                return Err(Fault::no_lines(path, info.bytes));
            }
            Ok(info)
        },
        |index, info| {
            let has_gap = !std::mem::take(&mut is_first);
            if let Err(error) = write(options, has_gap, &files[index], &info) {
                Fault::output(&error)?;
                return Ok(ControlFlow::Break(()));
            }
            // The readable part has been shown; report that a part is missing.
            match info.problem {
                Some(problem) => Err(Fault::new(Exit::Failed, problem)),
                None => Ok(ControlFlow::Continue(())),
            }
        },
    )
}

fn write(options: &Info, has_gap: bool, path: &Path, info: &info::Info) -> io::Result<()> {
    let mut out = out();
    if options.json {
        serde_json::to_writer(&mut out, &info)?;
        writeln!(out)?;
    } else {
        if has_gap {
            writeln!(out)?;
        }
        writeln!(out, "{}", path.display())?;
        info.write_text(&mut out)?;
    }
    out.flush()
}
