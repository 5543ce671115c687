//! Reports the progress and result of a command, as text or JSON lines.

use std::io::{self, IsTerminal};
use std::time::Duration;

use groundwave_protocol::telemetry::{Outcome, ParameterLine};
use serde_json::{Value, json};

use super::super::cli::Send;
use super::super::{Exit, Fault, say, say_progress, show_line};
use super::faults::{failed, refused};
use super::script::Script;
use super::step::Line;
use crate::event::{CommandId, CommandStatus, Event, LinkEvent};
use crate::parameter_file::limits;
use crate::request::outcome_words;
use crate::request::{Request, Standing, Tuning, in_whole_unit, unit_words};
use crate::share::StatusJson;
use crate::wait::Wait;

/// Time to wait for the result of a scan, which takes 9 s, and at most 16 s.
pub(super) const SCAN_TIMEOUT: Duration = Duration::from_secs(25);

/// The result of a scan in a text; `None` for other text.
pub(super) fn scan_result(text: &str) -> Option<&str> {
    text.starts_with("scan: ").then_some(text)
}

/// Result of a command; `None` while it lasts.
pub(super) type Ended = Option<Result<(), Fault>>;

/// Writes the results to standard output and the progress to standard error.
#[expect(
    clippy::struct_excessive_bools,
    reason = "each chooses another part of the output"
)]
pub(super) struct Report {
    json: bool,
    quiet: bool,
    progress: bool,
    /// Number of frames sent for the current command.
    pub(super) frames: u32,
    /// The robot's answers about the parameters of the current command.
    parameters: Vec<ParameterLine>,
    /// Whether parameter values are written to a file and not to the output.
    hides_values: bool,
    /// The robot's mode and layers, from its lines.
    pub(super) robot: Standing,
    /// The reason for a refusal, as given by the station that shares its link.
    pub(super) reason: Option<String>,
}

impl Report {
    pub(super) fn new(options: &Send, script: &Script) -> Self {
        Self {
            json: options.json,
            quiet: options.quiet,
            progress: !options.quiet && !options.json && io::stderr().is_terminal(),
            frames: 0,
            parameters: Vec::new(),
            hides_values: script.has_task(),
            robot: Standing::default(),
            reason: None,
        }
    }

    /// The robot's answers about the parameters of the latest command.
    pub(super) fn parameters(&self) -> &[ParameterLine] {
        &self.parameters
    }

    /// Reports an event; returns the result once the command has ended.
    pub(super) fn handle(
        &mut self,
        event: &Event,
        id: CommandId,
        line: &Line,
        after: Duration,
    ) -> Result<Ended, Fault> {
        match event {
            Event::Asked { id: of, .. } if *of == id => {
                return self.status(line, &CommandStatus::Queued, after);
            }
            Event::Command { id: of, status } if *of == id => {
                return self.status(line, status, after);
            }
            Event::Link(LinkEvent::Lost { reason }) => self.lost(reason),
            Event::Line { line, .. } => self.robot.take(&line.body),
            _ => {}
        }
        Ok(None)
    }

    /// Reports a status; returns the result once the command has ended.
    pub(super) fn status(
        &mut self,
        line: &Line,
        status: &CommandStatus,
        after: Duration,
    ) -> Result<Ended, Fault> {
        match status {
            CommandStatus::Queued => {
                self.frames = 0;
                self.parameters.clear();
                self.reason = None;
            }
            CommandStatus::Reported(line) => self.parameters.push(*line),
            CommandStatus::Sent { frames } => self.frames = *frames,
            _ => {}
        }
        let is_hidden = self.hides_values && line.request == Request::Parameter(Tuning::List);
        if self.json && !is_hidden {
            let mut value = json!(StatusJson::from(status));
            if let CommandStatus::Refused(outcome) = status {
                value["text"] = json!(self.why(&line.request, *outcome));
            }
            show_line(with_context(value, line, after))?;
        }
        Ok(self.result(&line.request, status, after))
    }

    /// Reports the end of a wait.
    pub(super) fn waited(
        &self,
        wait: &Wait,
        number: Option<usize>,
        ended: Result<String, String>,
        after: Duration,
    ) -> Result<(), Fault> {
        if self.json {
            let (status, seen) = match &ended {
                Ok(seen) => ("came", seen.clone()),
                Err(why) => ("expired", why.clone()),
            };
            show_line(json!({
                "status": status,
                "wait": wait.to_string(),
                "line": number,
                "seen": seen,
                "after_s": (after.as_secs_f64() * 1000.0).round() / 1000.0,
            }))?;
        } else if let Ok(seen) = &ended
            && !self.quiet
        {
            let seen = if seen.is_empty() {
                String::new()
            } else {
                format!(": {seen}")
            };
            show_line(format_args!(
                "{wait}: after {:.1} s{seen}",
                after.as_secs_f64()
            ))?;
        }
        let ended = ended.map(drop);
        ended.map_err(|why| Fault::new(Exit::NotConfirmed, why))
    }

    /// Reports a lost link; the link will be opened again.
    pub(super) fn lost(&self, reason: &str) {
        if !self.quiet {
            say(format_args!(
                "groundwave: link lost: {reason}; reconnecting"
            ));
        }
    }

    /// Reports the result of a scan; a fault if there is no result or the scan was aborted.
    pub(super) fn scan(
        &self,
        line: &Line,
        result: Option<&str>,
        after: Duration,
    ) -> Result<(), Fault> {
        let failed = |message| Err(Fault::new(Exit::Failed, message));
        let Some(text) = result else {
            return failed(format!(
                "the scan was confirmed, but its result did not arrive within {} s; scan again, or read the robot's lines T",
                SCAN_TIMEOUT.as_secs()
            ));
        };
        if self.json {
            let value = json!({ "status": "said", "text": text });
            show_line(with_context(value, line, after))?;
        } else if !self.quiet {
            show_line(text)?;
        }
        if text.ends_with("broken off") {
            return failed(
                "the robot ended the scan early: it met an obstacle, or was stopped".to_owned(),
            );
        }
        Ok(())
    }

    fn result(&self, request: &Request, status: &CommandStatus, after: Duration) -> Ended {
        match status {
            CommandStatus::Queued | CommandStatus::Sent { .. } => None,
            CommandStatus::Reported(line) => match request {
                Request::Parameter(Tuning::List | Tuning::Get(_))
                    if !self.json && !self.hides_values =>
                {
                    show_line(parameter_text(line)).err().map(Err)
                }
                _ => None,
            },
            CommandStatus::Progress {
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
            CommandStatus::Confirmed { digest } => {
                // The values are the command's result.
                let is_question =
                    matches!(request, Request::Parameter(Tuning::List | Tuning::Get(_)));
                if !self.json && !self.quiet && !is_question {
                    let digest =
                        digest.map_or(String::new(), |digest| format!(", digest {digest:08X}"));
                    return Some(show_line(format_args!(
                        "{request}: confirmed after {:.1} s{digest}",
                        after.as_secs_f64()
                    )));
                }
                Some(Ok(()))
            }
            CommandStatus::Echoed if self.json || self.quiet => Some(Ok(())),
            CommandStatus::Echoed => Some(show_line(format_args!(
                "{request}: echoed after {:.1} s, which confirms nothing",
                after.as_secs_f64()
            ))),
            CommandStatus::Refused(outcome) => {
                Some(Err(refused(request, &self.why(request, *outcome))))
            }
            CommandStatus::Failed(failure) => Some(Err(failed(request, *failure))),
        }
    }

    /// The reason for a refusal, with the accepted values if the robot named them.
    fn why(&self, request: &Request, outcome: Outcome) -> String {
        match (self.parameters.last(), request, outcome) {
            (Some(line), Request::Parameter(_), Outcome::BadValue) => limits(line),
            _ => self
                .robot
                .why(request, outcome)
                .filter(|_| self.reason.is_none())
                .or_else(|| self.reason.clone())
                .unwrap_or_else(|| outcome_words(outcome).to_owned()),
        }
    }
}

/// A parameter in columns; also in the whole unit if the robot counts fractions of it.
fn parameter_text(line: &ParameterLine) -> String {
    let ParameterLine {
        value,
        kept,
        least,
        most,
        ..
    } = line;
    let (name, unit) = (line.name.as_str(), line.unit.as_str());
    let words = unit_words(unit);
    let whole = in_whole_unit(*value, unit).map_or(String::new(), |(number, whole)| {
        format!("= {number} {whole}")
    });
    let text = format!(
        "{name:<18} {value:>6}  saved {kept:>6}  from {least:>6} to {most:>6}  {words:<8}  {whole}"
    );
    text.trim_end().to_owned()
}

/// Adds to a status the command, its line in the script, and the seconds since it was sent.
fn with_context(mut value: Value, line: &Line, after: Duration) -> Value {
    value["command"] = json!(line.request.to_string());
    if let Some(number) = line.number {
        value["line"] = json!(number);
    }
    value["after_s"] = json!((after.as_secs_f64() * 1000.0).round() / 1000.0);
    value
}
