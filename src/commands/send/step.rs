//! A step of a script; reads the files that a step names.

use std::io;
use std::path::Path;

use super::super::{Exit, Fault};
use crate::capture::{files, text_file};
use crate::hint;
use crate::request::Request;
use crate::wait::Wait;

/// A command and its place in the script.
#[derive(Clone)]
pub(super) struct Line {
    pub(super) request: Request,
    /// Line number, from 1; `None` for a command given as words.
    pub(super) number: Option<usize>,
}

/// A step of a script.
#[derive(Clone)]
pub(super) enum Step {
    Send(Line),
    /// A wait or a check, and its line number.
    Wait(Wait, Option<usize>),
}

pub(super) fn usage(message: impl std::fmt::Display) -> Fault {
    Fault::new(Exit::Usage, message)
}

pub(super) fn is_standard_input(path: &Path) -> bool {
    path.as_os_str() == "-"
}

pub(super) fn name_of(path: &Path) -> String {
    if is_standard_input(path) {
        "standard input".to_owned()
    } else {
        path.display().to_string()
    }
}

pub(super) fn read_text(path: &Path) -> Result<String, Fault> {
    let read = if is_standard_input(path) {
        text_file::read_to_end(io::stdin(), text_file::BYTES_MAX)
    } else {
        files::open(path).and_then(|file| text_file::read_to_end(file, text_file::BYTES_MAX))
    };
    read.map_err(|error| {
        let why = hint::of_reading(&error);
        usage(format!("cannot read {}: {why}", name_of(path)))
    })
}
