//! What `send` tells the person or the script of a command.

use std::fmt::Display;
use std::io::{self, IsTerminal, Write};
use std::time::Duration;

use groundwave_protocol::telemetry::{Outcome, ParameterLine};
use serde_json::{Value, json};

use super::cli::Send;
use super::script::Line;
use super::send::failed;
use super::{Exit, Fault, say, say_progress};
use crate::event::{CommandId, CommandStep, Event, LinkEvent};
use crate::request::{Request, Standing, Tuning, in_whole_unit};
use crate::share::{Stage, why_refused};

/// How a command ended, once it has.
pub(super) type Ended = Option<Result<(), Fault>>;

/// What the person or the script is told.
pub(super) struct Report {
    json: bool,
    quiet: bool,
    progress: bool,
    /// Frames of the present command that went out.
    pub(super) frames: u32,
    /// What the robot said last of a parameter that the present command is about.
    told: Option<ParameterLine>,
    /// What the robot is set to, from its lines.
    pub(super) robot: Standing,
    /// Why the present command was refused, in the words of the station that shares its link.
    pub(super) reason: Option<String>,
}

impl Report {
    pub(super) fn new(options: &Send) -> Self {
        Self {
            json: options.json,
            quiet: options.quiet,
            progress: !options.quiet && !options.json && io::stderr().is_terminal(),
            frames: 0,
            told: None,
            robot: Standing::default(),
            reason: None,
        }
    }

    /// Reports an event; returns how the command ended, once it has.
    pub(super) fn handle(
        &mut self,
        event: &Event,
        id: CommandId,
        line: &Line,
        after: Duration,
    ) -> Result<Ended, Fault> {
        match event {
            Event::Command { id: of, step } if *of == id => return self.step(line, step, after),
            Event::Link(LinkEvent::Lost { reason }) => self.lost(reason),
            Event::Line { line, .. } => self.robot.take(&line.body),
            _ => {}
        }
        Ok(None)
    }

    /// Reports a step; returns how the command ended, once it has.
    pub(super) fn step(
        &mut self,
        line: &Line,
        step: &CommandStep,
        after: Duration,
    ) -> Result<Ended, Fault> {
        match step {
            CommandStep::Queued(_) => {
                self.frames = 0;
                self.told = None;
                self.reason = None;
            }
            CommandStep::Told(line) => self.told = Some(**line),
            CommandStep::Sent { frames } => self.frames = *frames,
            _ => {}
        }
        if self.json {
            let mut value = json!(Stage::of(step));
            if let CommandStep::Refused(outcome) = step {
                value["reason"] = json!(self.why(&line.request, *outcome));
            }
            Self::print(placed(value, line, after))?;
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

    /// What the robot said of what it was asked to look for.
    pub(super) fn said(&self, line: &Line, text: &str, after: Duration) -> Result<(), Fault> {
        if self.json {
            return Self::print(placed(
                json!({ "stage": "said", "text": text }),
                line,
                after,
            ));
        }
        if self.quiet {
            return Ok(());
        }
        Self::print(text)
    }

    fn handle_step(&self, request: &Request, step: &CommandStep, after: Duration) -> Ended {
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
            (Some(line), Request::Parameter(_), Outcome::BadValue) => limits_text(line),
            _ => self
                .robot
                .why(request, outcome)
                .filter(|_| self.reason.is_none())
                .or_else(|| self.reason.clone())
                .unwrap_or_else(|| why_refused(outcome).to_owned()),
        }
    }

    pub(super) fn print(line: impl Display) -> Result<(), Fault> {
        let mut out = io::stdout().lock();
        writeln!(out, "{line}")
            .and_then(|()| out.flush())
            .or_else(|error| Fault::output(&error))
    }
}

/// A parameter in columns for a person, and for `awk`; where it counts parts of a unit, in the whole unit too.
fn parameter_text(line: &ParameterLine) -> String {
    let ParameterLine {
        value,
        kept,
        least,
        most,
        ..
    } = line;
    let (name, unit) = (line.name.as_str(), line.unit.as_str());
    let whole = in_whole_unit(*value, unit).map_or(String::new(), |(number, whole)| {
        format!("= {number} {whole}")
    });
    let text = format!(
        "{name:<18} {value:>6}  kept {kept:>6}  from {least:>6} to {most:>6}  {unit:<8}  {whole}"
    );
    text.trim_end().to_owned()
}

/// What a parameter takes: `it takes 100 to 130 (V/10), or 10.0 to 13.0 V`.
fn limits_text(line: &ParameterLine) -> String {
    let unit = line.unit.as_str();
    let counts = format!("it takes {} to {} ({unit})", line.least, line.most);
    match (
        in_whole_unit(line.least, unit),
        in_whole_unit(line.most, unit),
    ) {
        (Some((least, _)), Some((most, whole))) => {
            format!("{counts}, or {least} to {most} {whole}")
        }
        _ => counts,
    }
}

/// Beside what happened: the command, its line in the script and the time since it was given.
fn placed(mut value: Value, line: &Line, after: Duration) -> Value {
    value["command"] = json!(line.request.to_string());
    if let Some(number) = line.number {
        value["line"] = json!(number);
    }
    value["after_s"] = json!((after.as_secs_f64() * 1000.0).round() / 1000.0);
    value
}
