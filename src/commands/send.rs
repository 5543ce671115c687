//! `send`: commands from a shell or a script, each with its proof.

use std::fmt::Display;
use std::io::{self, IsTerminal, Write};
use std::time::{Duration, Instant};

use groundwave_protocol::telemetry::{Outcome, ParameterLine};
use serde_json::{Value, json};

use super::cli::{Send, Way};
use super::config::Config;
use super::script::{Line, Script};
use super::simulated::Embedded;
use super::{Exit, Fault, block_on, dry_run, say, say_progress, via};
use crate::event::{CommandId, CommandStep, Event, Failure, LinkEvent};
use crate::io::link::{Connection, Link, LinkSpec};
use crate::radio::Radio;
use crate::request::{Request, Tuning};
use crate::runtime::Driver;
use crate::share::{Heard, Stage, why_refused};

pub(super) fn run(options: &Send, config: &Config) -> Result<(), Fault> {
    let usage = |message| Fault::new(Exit::Usage, message);
    if options.dry_run {
        let words = options.words_to_plan().map_err(usage)?;
        return dry_run::run(options, &Script::read(options, &words)?);
    }
    let radio = options.radio.radio(config);
    let (way, words) = options.way().map_err(usage)?;
    let script = Script::read(options, &words)?;
    let receive_only = |name: &dyn Display| {
        let message = format!("cannot send to {name}: the link is receive-only");
        Err(Fault::new(Exit::ReceiveOnly, message))
    };
    match way {
        Way::Via(address) if !radio.can_send() => receive_only(&address),
        Way::Via(address) => via::deliver(options, &address, &script),
        Way::Link(link @ (LinkSpec::Stdin | LinkSpec::Unix(_))) => receive_only(&link),
        Way::Link(link) if !radio.can_send() => receive_only(&link),
        Way::Link(link) => {
            let baud = options.radio.baud(config);
            block_on(deliver(options, &link, baud, radio, &script))
        }
    }
}

async fn deliver(
    options: &Send,
    link: &LinkSpec,
    baud: u32,
    radio: Radio,
    script: &Script,
) -> Result<(), Fault> {
    let (mut driver, _simulator) = connect(link, baud, radio)?;
    let mut report = Report::new(options);
    for (index, line) in script.lines().iter().enumerate() {
        deliver_one(options, &mut driver, &mut report, line)
            .await
            .map_err(|fault| script.blame(index, fault))?;
    }
    Ok(())
}

/// A station on a link of its own, and the simulated robot behind it if the link is one.
pub(super) fn connect(
    link: &LinkSpec,
    baud: u32,
    radio: Radio,
) -> Result<(Driver, Embedded), Fault> {
    let (inputs, from_link) = tokio::sync::mpsc::channel(64);
    let (spec, simulator) = super::simulated::embed(link, radio.kind)?;
    let connection =
        Connection::open(&spec, baud).map_err(|error| Fault::new(Exit::NoLink, error))?;
    let opened = Link::start(spec, baud, connection, Box::new(|_, _| {}), inputs);
    let driver = Driver::new(
        link.to_string(),
        opened,
        from_link,
        radio,
        Instant::now(),
        Box::new(|_, _| {}),
    );
    Ok((driver, simulator))
}

async fn deliver_one(
    options: &Send,
    driver: &mut Driver,
    report: &mut Report,
    line: &Line,
) -> Result<(), Fault> {
    let begun = driver.now();
    let id = driver.request(line.request.clone());
    let deadline = tokio::time::sleep(options.timeout);
    tokio::pin!(deadline);
    loop {
        let mut ended = None;
        while let Some(event) = driver.poll_event() {
            let after = driver.now().saturating_sub(begun);
            ended = ended.or(report.handle(&event, id, line, after)?);
        }
        if let Some(ended) = ended {
            return ended;
        }
        tokio::select! {
            () = driver.step() => {}
            () = &mut deadline => {
                driver.cancel();
                let after = driver.now().saturating_sub(begun);
                // What it says for a person is known better here.
                report.step(line, &CommandStep::Failed(Failure::TimedOut), after)?;
                let heard = driver.heard();
                return Err(not_confirmed(&line.request, heard, options.timeout, report.frames));
            }
        }
    }
}

/// No proof came in time: says what was heard meanwhile, what was sent, and what is known of the robot.
pub(super) fn not_confirmed(
    request: &Request,
    heard: Heard,
    waited: Duration,
    frames: u32,
) -> Fault {
    let why = if heard.bytes == 0 {
        "nothing at all was heard from the robot (is it switched on, is this the right port?)"
            .to_owned()
    } else if heard.lines == 0 {
        format!(
            "{} bytes were heard and not one intact line (is the baud rate right?)",
            heard.bytes
        )
    } else {
        "the robot was heard and did not confirm: it may be out of reach of our transmitter"
            .to_owned()
    };
    let state = match request {
        _ if frames == 0 => " It was not sent.",
        Request::Route(_) => " The robot holds either its old list or the new one, whole.",
        _ => " The robot may or may not have executed it.",
    };
    let waited = if waited < Duration::from_secs(1) {
        format!("{} ms", waited.as_millis())
    } else {
        format!("{:.1} s", waited.as_secs_f64())
    };
    Fault::new(
        Exit::NotConfirmed,
        format!("`{request}` was not confirmed within {waited}: {why}.{state}"),
    )
}

/// It ended without proof.
pub(super) fn failed(request: &Request, failure: Failure) -> Fault {
    let exit = match failure {
        Failure::ReceiveOnly => Exit::ReceiveOnly,
        Failure::TimedOut => Exit::NotConfirmed,
        _ => Exit::Failed,
    };
    Fault::new(exit, format!("`{request}`: {failure}"))
}

/// What the person or the script is told.
pub(super) struct Report {
    json: bool,
    quiet: bool,
    progress: bool,
    /// Frames of the present command that went out.
    pub(super) frames: u32,
    /// What the robot said last of a parameter that the present command is about.
    told: Option<ParameterLine>,
}

impl Report {
    pub(super) fn new(options: &Send) -> Self {
        Self {
            json: options.json,
            quiet: options.quiet,
            progress: !options.quiet && !options.json && io::stderr().is_terminal(),
            frames: 0,
            told: None,
        }
    }

    /// Reports an event; returns how the command ended, once it has.
    fn handle(
        &mut self,
        event: &Event,
        id: CommandId,
        line: &Line,
        after: Duration,
    ) -> Result<Option<Result<(), Fault>>, Fault> {
        match event {
            Event::Command { id: of, step } if *of == id => self.step(line, step, after),
            Event::Link(LinkEvent::Lost { reason }) => {
                self.lost(reason);
                Ok(None)
            }
            _ => Ok(None),
        }
    }

    /// Reports a step; returns how the command ended, once it has.
    pub(super) fn step(
        &mut self,
        line: &Line,
        step: &CommandStep,
        after: Duration,
    ) -> Result<Option<Result<(), Fault>>, Fault> {
        match step {
            CommandStep::Queued(_) => {
                self.frames = 0;
                self.told = None;
            }
            CommandStep::Told(line) => self.told = Some(**line),
            CommandStep::Sent { frames } => self.frames = *frames,
            _ => {}
        }
        if self.json {
            Self::print(to_json(line, step, after))?;
        }
        Ok(self.handle_step(&line.request, step, after))
    }

    /// The link is gone and may come back.
    pub(super) fn lost(&self, reason: &str) {
        if !self.quiet {
            say(format_args!(
                "groundwave: link lost: {reason}; trying again"
            ));
        }
    }

    fn handle_step(
        &self,
        request: &Request,
        step: &CommandStep,
        after: Duration,
    ) -> Option<Result<(), Fault>> {
        match step {
            CommandStep::Queued(_) | CommandStep::Sent { .. } => None,
            CommandStep::Told(line) => match request {
                Request::Parameter(Tuning::List | Tuning::Get(_)) if !self.json => {
                    Self::print(parameter_text(line)).err().map(Err)
                }
                _ => None,
            },
            CommandStep::Progress {
                acknowledged,
                total,
            } => {
                if self.progress {
                    say_progress(format_args!(
                        "{acknowledged} of {total} waypoints acknowledged"
                    ));
                    if acknowledged == total {
                        say("");
                    }
                }
                None
            }
            CommandStep::Proven { digest } => {
                // What was asked for has been said: nothing is to be added to the values.
                let is_question =
                    matches!(request, Request::Parameter(Tuning::List | Tuning::Get(_)));
                if !self.json && !self.quiet && !is_question {
                    let digest =
                        digest.map_or(String::new(), |digest| format!(", digest {digest:08x}"));
                    return Some(Self::print(format_args!(
                        "{request}: proven after {:.1} s{digest}",
                        after.as_secs_f64()
                    )));
                }
                Some(Ok(()))
            }
            CommandStep::Refused(outcome) => Some(Err(Fault::new(
                Exit::Refused,
                format!(
                    "the robot refused `{request}`: {}",
                    self.why(request, *outcome)
                ),
            ))),
            CommandStep::Failed(failure) => Some(Err(failed(request, *failure))),
        }
    }

    /// Why it refused, with what it takes instead, if it said so.
    fn why(&self, request: &Request, outcome: Outcome) -> String {
        match (&self.told, request, outcome) {
            (Some(line), Request::Parameter(_), Outcome::BadValue) => format!(
                "it takes {} to {} ({})",
                line.least,
                line.most,
                line.unit.as_str()
            ),
            (_, Request::Parameter(Tuning::Get(name) | Tuning::Set(name, _)), Outcome::Unknown) => {
                format!(
                    "it has no parameter `{}`; `param list` shows those it has",
                    name.as_str()
                )
            }
            _ => why_refused(outcome).to_owned(),
        }
    }

    pub(super) fn print(line: impl Display) -> Result<(), Fault> {
        let mut out = io::stdout().lock();
        writeln!(out, "{line}")
            .and_then(|()| out.flush())
            .or_else(|error| Fault::output(&error))
    }
}

/// A parameter in columns for a person, and for `awk`.
fn parameter_text(line: &ParameterLine) -> String {
    let ParameterLine {
        value,
        kept,
        least,
        most,
        ..
    } = line;
    let (name, unit) = (line.name.as_str(), line.unit.as_str());
    let text =
        format!("{name:<18} {value:>6}  kept {kept:>6}  from {least:>6} to {most:>6}  {unit}");
    text.trim_end().to_owned()
}

/// A step for a program, beside the command, its line in the script and the time since it was given.
fn to_json(line: &Line, step: &CommandStep, after: Duration) -> Value {
    let mut value = json!(Stage::of(step));
    value["command"] = json!(line.request.to_string());
    if let Some(number) = line.number {
        value["line"] = json!(number);
    }
    value["after_s"] = json!((after.as_secs_f64() * 1000.0).round() / 1000.0);
    value
}
