//! `check`: the mistakes in a robot's lines.

use std::io::{self, IsTerminal as _, Read, Write};
use std::path::Path;
use std::time::Duration;

use serde_json::{Value, json};

use super::cli::Check;
use super::config::Config;
use super::connecting::connect;
use super::progress::Progress;
use super::{Exit, Fault, block_on, input, out, say, say_progress, simulated};
use crate::capture::diagnosis::{Diagnosis, Finding};
use crate::capture::source::Form;
use crate::capture::{Capture, Piece};
use crate::hint;
use crate::io::link::{Link, LinkInput, LinkSpec};
use crate::io::signals::{Signal, Signals, stop_myself};
use crate::radio::RadioKind;
use crate::safe_text;

/// Bytes read at a time.
const READ_BYTES: usize = 64 * 1024;

/// Inputs of a link that wait.
const INPUTS_MAX: usize = 256;

const REPORT_EVERY: Duration = Duration::from_secs(1);

pub(super) fn run(options: &Check, config: &Config) -> Result<(), Fault> {
    let diagnosis = match &options.from {
        LinkSpec::Stdin => read(Path::new("-"))?,
        LinkSpec::Serial(path) if path.is_file() => read(path)?,
        link => block_on(Box::pin(hear(link, options, config)))?,
    };
    let name = options.from.to_string();
    let findings = diagnosis.findings();
    let written = if options.json {
        let mut out = out();
        writeln!(out, "{}", to_json(&name, &diagnosis, &findings)).and_then(|()| out.flush())
    } else {
        write(&name, &diagnosis, &findings)
    };
    if let Err(error) = written {
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
    Err(Fault::new(Exit::Failed, format!("{name}: {mistakes}")))
}

/// Reads a capture.
fn read(path: &Path) -> Result<Diagnosis, Fault> {
    let source = input::open(path, &Progress::new(None, true))?;
    let (form, mut source) = input::detect_form(path, source)?;
    let mut diagnosis = Diagnosis::default();
    match form {
        // Read as they are: a capture's reader mends line ends, which may be the mistake.
        Form::Raw => {
            read_raw(&mut source, &mut diagnosis)
                .map_err(|error| input::cannot_read(path, error))?;
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
    Ok(diagnosis)
}

fn read_raw(source: &mut impl Read, diagnosis: &mut Diagnosis) -> io::Result<()> {
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

/// Hears a link until a signal, the end of the duration or of the link.
async fn hear(link: &LinkSpec, options: &Check, config: &Config) -> Result<Diagnosis, Fault> {
    let (link, config) = config.at(link)?;
    let (spec, _robot) = simulated::embed(&link, RadioKind::default())?;
    let baud = options.link.baud(&config);
    let connection = connect(&spec, baud, &options.link)?;
    let mut signals = Signals::listen().map_err(|error| {
        let reason = hint::words(&error);
        Fault::new(Exit::Failed, format!("cannot listen for signals: {reason}"))
    })?;
    let (inputs, mut heard) = tokio::sync::mpsc::channel(INPUTS_MAX);
    let _link = Link::start(spec, baud, connection, Box::new(|_, _| ()), inputs);
    let mut diagnosis = Diagnosis::default();
    let shows_progress = io::stderr().is_terminal();
    let mut report = tokio::time::interval(REPORT_EVERY);
    let end = tokio::time::sleep(options.duration.unwrap_or(Duration::MAX));
    tokio::pin!(end);
    loop {
        tokio::select! {
            signal = signals.next() => match signal {
                Signal::Leave => break,
                Signal::Suspend => stop_myself(),
            },
            () = &mut end => break,
            input = heard.recv() => match input {
                Some(LinkInput::Bytes(_, bytes)) => diagnosis.take(&bytes),
                Some(LinkInput::Lost(reason)) => {
                    say(format_args!("groundwave: link lost: {reason}"));
                    break;
                }
                Some(LinkInput::Ended) | None => break,
                Some(LinkInput::Opened { .. } | LinkInput::Said(_)) => {}
            },
            _ = report.tick() => if shows_progress {
                let (counters, found) = (diagnosis.counters(), diagnosis.findings().len());
                say_progress(format_args!(
                    "{} lines, {found} mistakes; Ctrl-C ends",
                    counters.lines + counters.ack_lines
                ));
            },
        }
    }
    if shows_progress {
        say("");
    }
    Ok(diagnosis)
}

fn to_json(name: &str, diagnosis: &Diagnosis, findings: &[Finding]) -> Value {
    let counters = diagnosis.counters();
    let finding = |finding: &Finding| {
        json!({
            "code": finding.kind.code,
            "row": finding.row,
            "column": finding.column,
            "count": finding.count,
            "place": finding.place,
            "cause": finding.kind.cause,
            "remedy": finding.kind.remedy,
            "section": finding.kind.section,
            "line": String::from_utf8_lossy(&finding.line).trim_end_matches('\r'),
        })
    };
    json!({
        "name": name,
        "level": diagnosis.level(),
        "intact": counters.lines + counters.ack_lines,
        "damaged": counters.damaged.total(),
        "findings": findings.iter().map(finding).collect::<Vec<_>>(),
    })
}

fn write(name: &str, diagnosis: &Diagnosis, findings: &[Finding]) -> io::Result<()> {
    let mut out = out();
    for finding in findings {
        let times = match finding.count {
            1 => String::new(),
            count => format!(" ({count} times)"),
        };
        let clause = safe_text::line(&finding.clause()).into_owned();
        writeln!(out, "{}: {clause}{times}", finding.row)?;
        let line = String::from_utf8_lossy(&finding.line);
        writeln!(out, "  {}", safe_text::line(line.trim_end_matches('\r')))?;
        if let Some(column) = finding.column {
            writeln!(out, "  {:>column$}", '^')?;
        }
        let kind = finding.kind;
        writeln!(
            out,
            "  {} (SPEC.md section {}, {})",
            kind.remedy, kind.section, kind.code
        )?;
    }
    let counters = diagnosis.counters();
    writeln!(
        out,
        "{}: {} intact lines, {} damaged",
        safe_text::line(name),
        counters.lines + counters.ack_lines,
        counters.damaged.total()
    )?;
    writeln!(out, "{}", level_words(diagnosis.level()))?;
    out.flush()
}

/// The level heard, and what the next one adds.
const fn level_words(level: u8) -> &'static str {
    match level {
        0 => "Level 1 needs: line A.",
        1 => {
            "Level 1 is heard. Level 2 needs: acknowledgements, line I, frames X, O and C, orders M and L."
        }
        2 => "Level 2 is heard. Level 3 needs: line B, frames W, order A.",
        3 => {
            "Level 3 is heard. Level 4 needs: lines C, T and K, frames D and L, orders P, S and F."
        }
        4 => "Level 4 is heard. Level 5 needs: lines P, S and G, orders V, N and K.",
        _ => "Level 5 is heard.",
    }
}
