//! `info`: what is in captures.

use std::io::{self, Write};
use std::path::Path;

use super::cli::Info;
use super::{Exit, Fault, keeping, say};
use crate::capture::Capture;
use crate::capture::info;

pub(super) fn run(options: &Info) -> Result<(), Fault> {
    // One bad file does not hide the others: the last fault is left to the caller.
    let mut fault: Option<Fault> = None;
    for (index, path) in options.files.iter().enumerate() {
        let found = match Capture::open(path) {
            Ok(mut capture) => {
                let info = info::Info::read(&mut capture);
                if info.lines.total() == 0 && info.problem.is_none() {
                    Some(Fault::no_lines(path, info.bytes))
                } else if let Err(error) = write(options, index, path, &info) {
                    return Fault::output(&error);
                } else {
                    // As `decode` does: what is there is told, and that it is not all.
                    info.problem
                        .map(|problem| Fault::new(Exit::Failed, problem))
                }
            }
            Err(error) => Some(keeping::fault(error)),
        };
        if let Some(found) = found
            && let Some(earlier) = fault.replace(found)
        {
            say(format_args!("groundwave: {earlier}"));
        }
    }
    fault.map_or(Ok(()), Err)
}

fn write(options: &Info, index: usize, path: &Path, info: &info::Info) -> io::Result<()> {
    let mut out = io::stdout().lock();
    if options.json {
        serde_json::to_writer(&mut out, &info)?;
        writeln!(out)?;
    } else {
        let gap = if index > 0 { "\n" } else { "" };
        writeln!(out, "{gap}{}", path.display())?;
        info.write_text(&mut out)?;
    }
    out.flush()
}
