//! `recover`: finishes interrupted recordings and repairs damaged ones.

use std::io::{self, Write};
use std::path::PathBuf;

use super::cli::Recover;
use super::{Exit, Fault, out, say, say_fault};
use crate::capture::interrupted::find_interrupted;
use crate::capture::recover::{Outcome, Recovery, recover};

pub(super) fn run(options: &Recover) -> Result<(), Fault> {
    let mut paths: Vec<PathBuf> = Vec::new();
    for file in &options.files {
        if file.is_dir() {
            let found = find_interrupted(file);
            if found.is_empty() && !options.json {
                say(format_args!(
                    "groundwave: {}: no interrupted recordings",
                    file.display()
                ));
            }
            paths.extend(found);
        } else {
            paths.push(file.clone());
        }
    }
    let mut fault = None;
    for path in paths {
        match recover(&path) {
            Ok(recovery) => {
                if let Err(error) = print(&recovery, options.json) {
                    return Fault::output(&error);
                }
                if recovery.outcome == Outcome::Partly {
                    let message = format!("{}: a part of it is lost", path.display());
                    fault.get_or_insert(Fault::new(Exit::Failed, message));
                }
            }
            Err(error) => {
                // Continue with the others; the last fault is returned.
                if let Some(before) = fault.replace(Fault::from(error)) {
                    say_fault(&before);
                }
            }
        }
    }
    fault.map_or(Ok(()), Err)
}

fn print(recovery: &Recovery, json: bool) -> io::Result<()> {
    let mut output = out();
    if json {
        serde_json::to_writer(&mut output, recovery)?;
        writeln!(output)?;
    } else {
        recovery.write_text(&mut output)?;
    }
    output.flush()
}
