//! `check`: finds the mistakes in a robot's lines and in its reactions to frames.

mod trials;

use std::io::{self, IsTerminal as _, Read, Write};
use std::path::Path;
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use super::cli::Check;
use super::config::Config;
use super::connecting::connect;
use super::progress::Progress;
use super::{Exit, Fault, block_on, input, out, say, say_progress, simulated};
use crate::capture::diagnosis::{Diagnosis, Finding};
use crate::capture::own_lines::recognizer;
use crate::capture::source::Form;
use crate::capture::{Capture, Piece};
use crate::conformance::Trials;
use crate::hint;
use crate::io::link::{Link, LinkInput, LinkSpec};
use crate::io::signals::{Signal, Signals, stop_myself};
use crate::radio::{RadioKind, random_owner};
use crate::safe_text;
use groundwave_captures::words::counted;

/// Number of bytes read at a time.
const READ_BYTES: usize = 64 * 1024;

/// Maximum number of queued inputs of a link.
const INPUTS_MAX: usize = 256;

/// Time to send STOP when trials end early.
const FAREWELL: Duration = Duration::from_millis(300);

const REPORT_EVERY: Duration = Duration::from_secs(1);

pub(super) fn run(options: &Check, config: &Config) -> Result<(), Fault> {
    let mut trials = None;
    let (diagnosis, has_own_lines) = match &options.from {
        LinkSpec::Stdin if !options.send => read(Path::new("-"))?,
        LinkSpec::Serial(path) if path.is_file() && !options.send => read(path)?,
        link => {
            if options.send {
                trials::confirm(options.yes)?;
            }
            let (diagnosis, tried) = block_on(Box::pin(hear(link, options, config)))?;
            trials = tried;
            let has_own_lines = diagnosis.own_lines() > 0;
            (diagnosis, has_own_lines)
        }
    };
    let name = options.from.to_string();
    let findings = diagnosis.findings();
    let written = if options.json {
        let mut out = out();
        let report = to_json(&name, &diagnosis, &findings, trials.as_ref());
        writeln!(out, "{report}").and_then(|()| out.flush())
    } else {
        write(&name, &diagnosis, has_own_lines, &findings, trials.as_ref())
    };
    if let Err(error) = written {
        return Fault::output(&error);
    }
    let broken = trials.as_ref().map_or(0, trials::broken);
    let is_over = trials.as_ref().is_none_or(Trials::is_over);
    let is_heard = diagnosis.level() > 0 || has_own_lines && !options.send;
    if findings.len() + broken == 0 && is_heard && is_over {
        return Ok(());
    }
    let mistakes = match findings.len() + broken {
        0 if !is_over => "the trials were left before their end".to_owned(),
        0 => "no intact line, and no usual mistake in what was read".to_owned(),
        count => counted(count as u64, "mistake"),
    };
    Err(Fault::new(Exit::Failed, format!("{name}: {mistakes}")))
}

/// Reads a capture; returns also whether it has lines of the robot's own: text of unknown origin may be prose.
fn read(path: &Path) -> Result<(Diagnosis, bool), Fault> {
    let source = input::open(path, &Progress::new(None, true))?;
    let (form, mut source) = input::detect_form(path, source)?;
    let mut diagnosis = Diagnosis::default();
    match form {
        // Bytes are read unchanged: a capture's reader mends line ends, which may be the mistake.
        Form::Raw => {
            read_raw(&mut source, &mut diagnosis)
                .map_err(|error| input::cannot_read(path, error))?;
        }
        Form::Mcap => {
            let mut capture = Capture::read(path, source)?;
            let table = capture.session_ahead()?;
            diagnosis = Diagnosis::new(recognizer(table.as_ref()));
            while let Some((_, piece)) = capture.next_piece()? {
                if let Piece::Received(bytes) = piece {
                    diagnosis.take(bytes);
                }
            }
        }
    }
    let has_own_lines = diagnosis.has_own_lines(form);
    Ok((diagnosis, has_own_lines))
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

/// Listens to a link until a signal, or until the duration, the link or the trials end.
async fn hear(
    link: &LinkSpec,
    options: &Check,
    config: &Config,
) -> Result<(Diagnosis, Option<Trials>), Fault> {
    let (link, config) = config.at(link, &options.link)?;
    let own = config.own.recognizer()?;
    let (spec, _robot) = simulated::embed(&link, RadioKind::default())?;
    let baud = options.link.baud(&config);
    let connection = connect(&spec, baud, &options.link)?;
    let mut signals = Signals::listen().map_err(|error| {
        let reason = hint::words(&error);
        Fault::new(Exit::Failed, format!("cannot listen for signals: {reason}"))
    })?;
    let (inputs, mut heard) = tokio::sync::mpsc::channel(INPUTS_MAX);
    let link = Link::start(spec, baud, connection, Box::new(|_, _| ()), inputs);
    if options.send && (!link.can_send() || link.share().is_some()) {
        return Err(Fault::new(
            Exit::Usage,
            "--send needs the robot's own link: a device or a TCP bridge that no other station shares",
        ));
    }
    link.hand_over_at_once(options.send);
    let start = Instant::now();
    let mut trials = options.send.then(|| Trials::new(random_owner(), baud));
    let mut diagnosis = Diagnosis::new(own);
    let shows_progress = io::stderr().is_terminal();
    let mut report = tokio::time::interval(REPORT_EVERY);
    let end = tokio::time::sleep(options.duration.unwrap_or(Duration::MAX));
    tokio::pin!(end);
    while !trials.as_ref().is_some_and(Trials::is_over) {
        let timeout = trials.as_ref().and_then(Trials::poll_timeout);
        let due = start + timeout.unwrap_or(Duration::ZERO);
        tokio::select! {
            signal = signals.next() => match signal {
                Signal::Leave => {
                    if options.send {
                        link.send(&Trials::farewell());
                        tokio::time::sleep(FAREWELL).await;
                    }
                    break;
                }
                Signal::Suspend => stop_myself(),
            },
            () = &mut end => break,
            input = heard.recv() => match input {
                Some(LinkInput::Bytes(_, bytes)) => {
                    diagnosis.take(&bytes);
                    diagnosis.take_time(start.elapsed());
                    if let Some(trials) = &mut trials {
                        trials.handle_bytes(start.elapsed(), &bytes);
                    }
                }
                Some(LinkInput::Lost(reason)) => {
                    say(format_args!("groundwave: link lost: {reason}"));
                    diagnosis.skip();
                    if !trials.as_ref().is_some_and(Trials::awaits_reset) {
                        break;
                    }
                }
                Some(LinkInput::Ended) | None => break,
                Some(LinkInput::Opened { .. } | LinkInput::Said(_)) => {}
            },
            () = tokio::time::sleep_until(due.into()), if timeout.is_some() => {}
            _ = report.tick() => if shows_progress && trials.is_none() {
                let (counters, found) = (diagnosis.counters(), diagnosis.findings().len());
                say_progress(format_args!(
                    "{}, {}; Ctrl-C ends",
                    counted(counters.received(), "line"),
                    counted(found as u64, "mistake")
                ));
            },
        }
        if let Some(trials) = &mut trials {
            advance(trials, &link, start.elapsed(), !options.json)?;
        }
    }
    if shows_progress && trials.is_none() {
        say("");
    }
    Ok((diagnosis, trials))
}

/// Sends the frames that are due, and prints verdicts and requests.
fn advance(trials: &mut Trials, link: &Link, now: Duration, prints: bool) -> Result<(), Fault> {
    if trials.poll_timeout().is_some_and(|at| at <= now) {
        trials.handle_timeout(now);
    }
    while let Some(bytes) = trials.poll_transmit() {
        link.send(&bytes);
    }
    while let Some(verdict) = trials.poll_verdict() {
        if prints && let Err(error) = trials::print(&verdict) {
            return Fault::output(&error);
        }
    }
    while let Some(request) = trials.poll_prompt() {
        say(request);
    }
    Ok(())
}

fn to_json(
    name: &str,
    diagnosis: &Diagnosis,
    findings: &[Finding],
    trials: Option<&Trials>,
) -> Value {
    let counters = diagnosis.counters();
    json!({
        "name": name,
        "level": trials.and_then(Trials::level).unwrap_or(diagnosis.level()),
        "intact": counters.received(),
        "damaged": counters.damaged.total(),
        "own": diagnosis.own_lines(),
        "findings": findings,
        "trials": trials.map(|it| it.verdicts().iter().map(trials::to_json).collect::<Vec<_>>()),
    })
}

fn write(
    name: &str,
    diagnosis: &Diagnosis,
    has_own_lines: bool,
    findings: &[Finding],
    trials: Option<&Trials>,
) -> io::Result<()> {
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
    if diagnosis.level() == 0 && findings.is_empty() && has_own_lines {
        let (name, lines) = (safe_text::line(name), diagnosis.own_lines());
        writeln!(out, "{name}: {} of the robot's own", counted(lines, "line"))?;
        writeln!(out, "Level 0 is reached. {}", level_words(0))?;
        return out.flush();
    }
    writeln!(
        out,
        "{}: {}, {} damaged",
        safe_text::line(name),
        counted(counters.received(), "intact line"),
        counters.damaged.total()
    )?;
    let level = trials.and_then(Trials::level).unwrap_or(diagnosis.level());
    match trials.and_then(trials::lacking) {
        Some(lacking) => writeln!(out, "{lacking}")?,
        None => writeln!(out, "{}", level_words(level))?,
    }
    out.flush()
}

/// Describes the level reached, and the requirements of the next level.
const fn level_words(level: u8) -> &'static str {
    match level {
        0 => "Level 1 needs: line A.",
        1 => {
            "Level 1 is reached. Level 2 needs: acknowledgements, line I, frames X, O and C, orders M and L."
        }
        2 => "Level 2 is reached. Level 3 needs: line B, frames W, order A.",
        3 => {
            "Level 3 is reached. Level 4 needs: lines C, T and K, frames D and L, orders P, S and F."
        }
        4 => "Level 4 is reached. Level 5 needs: lines P, S and G, orders V, N and K.",
        _ => "Level 5 is reached.",
    }
}
