//! `label`: what is said of a run.

use std::io::{self, Write};

use super::cli;
use super::{Exit, Fault, keeping};
use crate::capture::Capture;
use crate::capture::runs::Label;

pub(super) fn run(options: &cli::Label) -> Result<(), Fault> {
    // A label without its capture would never be found again.
    Capture::open(&options.file).map_err(keeping::fault)?;
    let mut label = Label::of(&options.file).map_err(|error| Fault::new(Exit::Usage, error))?;
    if change(&mut label, options) {
        return label
            .keep(&options.file)
            .map_err(|error| Fault::new(Exit::Failed, error));
    }
    show(&label, options.json).or_else(|error| Fault::output(&error))
}

fn change(label: &mut Label, options: &cli::Label) -> bool {
    let before = label.clone();
    if let Some(name) = &options.name {
        label.name = Some(name.clone()).filter(|name| !name.is_empty());
    }
    if let Some(reason) = &options.void {
        label.void = Some(reason.clone());
    }
    if options.counts {
        label.void = None;
    }
    if let Some(text) = &options.note {
        label.remark(options.at, text);
    }
    *label != before
}

fn show(label: &Label, json: bool) -> io::Result<()> {
    let mut out = io::stdout().lock();
    if json {
        serde_json::to_writer(&mut out, label)?;
        writeln!(out)?;
        return out.flush();
    }
    if *label == Label::default() {
        writeln!(out, "nothing is said of it; --name, --note and --void do")?;
    }
    if let Some(name) = &label.name {
        writeln!(out, "name   {name}")?;
    }
    if let Some(reason) = &label.void {
        writeln!(out, "{}", format!("VOID   {reason}").trim_end())?;
    }
    for note in &label.notes {
        match note.at_s {
            Some(at_s) => writeln!(out, "note   at {at_s:.1} s: {}", note.text)?,
            None => writeln!(out, "note   {}", note.text)?,
        }
    }
    out.flush()
}
