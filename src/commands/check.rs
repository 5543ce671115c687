//! `check`: the mistakes in a robot's lines.

use std::io::{self, Read, Write};
use std::path::Path;

use super::cli::Check;
use super::progress::Progress;
use super::{Exit, Fault, input, out};
use crate::capture::diagnosis::{Diagnosis, Finding};
use crate::capture::source::Form;
use crate::capture::{Capture, Piece};
use crate::safe_text;

/// Bytes read at a time.
const READ_BYTES: usize = 64 * 1024;

pub(super) fn run(options: &Check) -> Result<(), Fault> {
    let path = &options.file;
    let source = input::open(path, &Progress::new(None, true))?;
    let (form, mut source) = input::detect_form(path, source)?;
    let mut diagnosis = Diagnosis::default();
    match form {
        // Read as they are: a capture's reader mends line ends, which may be the mistake.
        Form::Raw => {
            read(&mut source, &mut diagnosis).map_err(|error| input::cannot_read(path, error))?;
        }
        Form::Mcap => {
            let mut capture = Capture::read(path, source)?;
            while let Some((_, piece)) = capture.next_piece()? {
                if let Piece::Received(bytes) = piece {
                    diagnosis.take(bytes);
                }
            }
        }
    }
    let findings = diagnosis.findings();
    if let Err(error) = write(path, &diagnosis, &findings) {
        return Fault::output(&error);
    }
    if findings.is_empty() && diagnosis.level() > 0 {
        return Ok(());
    }
    let mistakes = match findings.len() {
        0 => "no intact line, and no usual mistake explains the others".to_owned(),
        1 => "1 mistake".to_owned(),
        count => format!("{count} mistakes"),
    };
    let path = path.display();
    Err(Fault::new(Exit::Failed, format!("{path}: {mistakes}")))
}

fn read(source: &mut impl Read, diagnosis: &mut Diagnosis) -> io::Result<()> {
    let mut bytes = vec![0; READ_BYTES];
    loop {
        match source.read(&mut bytes) {
            Ok(0) => return Ok(()),
            Ok(count) => diagnosis.take(&bytes[..count]),
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
}

fn write(path: &Path, diagnosis: &Diagnosis, findings: &[Finding]) -> io::Result<()> {
    let mut out = out();
    for finding in findings {
        let times = match finding.count {
            1 => String::new(),
            count => format!(" ({count} times)"),
        };
        writeln!(
            out,
            "line {} of the input: {}{times}",
            finding.row, finding.cause
        )?;
        let line = String::from_utf8_lossy(&finding.line);
        writeln!(out, "  {}", safe_text::line(line.trim_end_matches('\r')))?;
        if let Some(column) = finding.column {
            writeln!(out, "  {:>column$}", '^')?;
        }
    }
    let counters = diagnosis.counters();
    let path = path.display().to_string();
    let path = safe_text::line(&path);
    writeln!(
        out,
        "{path}: {} intact lines, {} damaged, {} unreadable",
        counters.lines + counters.ack_lines,
        counters.crc_rejected + counters.shape_rejected,
        counters.field_rejected
    )?;
    if let Some(other) = counters.other_robot {
        writeln!(out, "Robot {other} is on the channel, too.")?;
    }
    writeln!(out, "{}", level_words(diagnosis.level()))?;
    out.flush()
}

/// The level heard, and what the next one adds.
const fn level_words(level: u8) -> &'static str {
    match level {
        0 => "Level 1 needs: line A.",
        1 => {
            "Level 1 is heard. Level 2 needs: acknowledgements, frames X, O and C, orders M and L."
        }
        2 => "Level 2 is heard. Level 3 needs: line B, frames W, order A.",
        3 => {
            "Level 3 is heard. Level 4 needs: lines C, T and K, frames D and L, orders P, S and F."
        }
        4 => "Level 4 is heard. Level 5 needs: lines P, S and G, orders V, N and K.",
        _ => "Level 5 is heard.",
    }
}
