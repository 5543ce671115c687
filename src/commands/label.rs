//! `label`: shows and changes the name, notes and validity of a run.

use std::io::{self, Write};
use std::path::Path;

use super::cli;
use super::{Exit, Fault, out};
use crate::capture::Capture;
use crate::capture::index;
use crate::capture::runs::Label;
use crate::playback::clock_words;

pub(super) fn run(options: &cli::Label) -> Result<(), Fault> {
    if options
        .note
        .as_ref()
        .is_some_and(|note| note.trim().is_empty())
    {
        let message = "--note is empty; give a text, such as --note 'the glass door'";
        return Err(Fault::new(Exit::Usage, message));
    }
    // A label needs a capture.
    Capture::open(&options.file)?;
    if let Some(at_s) = options.at {
        check_moment(&options.file, at_s)?;
    }
    let mut label = Label::of(&options.file).map_err(|error| Fault::new(Exit::Usage, error))?;
    if change(&mut label, options) {
        return label
            .keep(&options.file)
            .map_err(|error| Fault::new(Exit::Failed, error));
    }
    show(&label, options.json).or_else(|error| Fault::output(&error))
}

/// Refuses a time after the end of the capture.
fn check_moment(file: &Path, at_s: f64) -> Result<(), Fault> {
    let length = index::open(file)?.length();
    if at_s <= length.as_secs_f64().ceil() {
        return Ok(());
    }
    let (file, length) = (file.display(), clock_words(length));
    Err(Fault::new(
        Exit::Usage,
        format!("{file}: --at {at_s} s is after the end of the capture, which is {length} long"),
    ))
}

fn change(label: &mut Label, options: &cli::Label) -> bool {
    let before = label.clone();
    if let Some(name) = &options.name {
        label.name = Some(name.clone()).filter(|name| !name.trim().is_empty());
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
    let mut out = out();
    if json {
        serde_json::to_writer(&mut out, label)?;
        writeln!(out)?;
        return out.flush();
    }
    if *label == Label::default() {
        writeln!(out, "No label yet; add one with --name, --note or --void")?;
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
