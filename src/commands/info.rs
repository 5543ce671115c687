//! `info`: what is in captures.

use std::io::{self, Write};
use std::path::Path;

use super::cli::Info;
use super::{Exit, Fault, keeping, say};
use crate::capture::Capture;
use crate::capture::info;

pub(super) fn run(options: &Info) -> Result<(), Fault> {
    let mut fault = None;
    for (index, path) in options.files.iter().enumerate() {
        match Capture::open(path) {
            Ok(mut capture) => {
                let info = info::Info::read(&mut capture);
                if info.lines.total() == 0 && info.problem.is_none() {
                    let message = format!(
                        "{}: not one line of a robot in {} bytes",
                        path.display(),
                        info.bytes
                    );
                    if let Some(earlier) = fault.replace(Fault::new(Exit::Usage, message)) {
                        say(format_args!("groundwave: {earlier}"));
                    }
                    continue;
                }
                if let Err(error) = write(options, index, path, &info) {
                    return Fault::output(&error);
                }
            }
            // One bad file does not hide the others: the last fault is left to the caller.
            Err(error) => {
                if let Some(earlier) = fault.replace(keeping::fault(error)) {
                    say(format_args!("groundwave: {earlier}"));
                }
            }
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
