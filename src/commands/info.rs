//! `info`: summaries of captures.

use std::io::{self, Write};
use std::ops::ControlFlow;
use std::path::Path;

use super::cli::Info;
use super::{Exit, Fault, batch, input};
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
            if info.lines.total() == 0 && info.problem.is_none() {
                return Err(Fault::no_lines(path, info.bytes));
            }
            Ok(info)
        },
        |index, info| {
            let gap = if is_first { "" } else { "\n" };
            is_first = false;
            if let Err(error) = write(options, gap, &files[index], &info) {
                Fault::output(&error)?;
                return Ok(ControlFlow::Break(()));
            }
            // The readable part has been shown; report that it is not all.
            match info.problem {
                Some(problem) => Err(Fault::new(Exit::Failed, problem)),
                None => Ok(ControlFlow::Continue(())),
            }
        },
    )
}

fn write(options: &Info, gap: &str, path: &Path, info: &info::Info) -> io::Result<()> {
    let mut out = io::stdout().lock();
    if options.json {
        serde_json::to_writer(&mut out, &info)?;
        writeln!(out)?;
    } else {
        writeln!(out, "{gap}{}", path.display())?;
        info.write_text(&mut out)?;
    }
    out.flush()
}
