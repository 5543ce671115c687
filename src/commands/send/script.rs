//! The steps of `send`: a command given as words, or a script of commands and waits, one per line.

use std::path::Path;

use groundwave_protocol::status_codes::Mode;
use groundwave_protocol::telemetry::ParameterLine;

use super::super::Fault;
use super::super::cli::Send;
use super::parameter_task::ParameterTask;
use super::step::{Line, Step, is_standard_input, name_of, read_text, usage};
use crate::request::Request;
use crate::route;
use crate::wait::Wait;

/// Steps, in order.
pub(super) struct Script {
    /// Name of the script file, if there is one.
    name: Option<String>,
    steps: Vec<Step>,
    /// Task to carry out with the list of parameters.
    task: Option<ParameterTask>,
}

impl Script {
    /// Reads and checks all commands.
    pub(super) fn read(options: &Send, words: &[&str], own: &[String]) -> Result<Self, Fault> {
        let task = match &options.file {
            Some(_) => None,
            None => ParameterTask::from_words(words)?,
        };
        let list = task.as_ref().map(|_| ["param", "list"]);
        let words = list.as_ref().map_or(words, |list| &list[..]);
        let mut script = match &options.file {
            Some(_) if !words.is_empty() => {
                return Err(usage("give the command either as words or with -f"));
            }
            None => Self {
                name: task
                    .as_ref()
                    .and_then(ParameterTask::name)
                    .map(str::to_owned),
                task,
                steps: read_step(words, own, None).map_err(usage)?,
            },
            Some(path) => Self::read_file(path, own)?,
        };
        if options.go {
            let number = match script.steps.last() {
                Some(Step::Send(Line {
                    request: Request::Route(route),
                    number,
                })) if !route.is_empty() => *number,
                _ => {
                    return Err(usage(
                        "--go needs `goto` or `route`, to drive its waypoints",
                    ));
                }
            };
            script.steps.push(Step::Send(Line {
                request: Request::Mode(Mode::Prowl),
                number,
            }));
        }
        let follow = script.task.as_ref().map(ParameterTask::lines);
        let follow = follow.into_iter().flatten().map(Step::Send);
        if options.dry_run {
            script.steps.extend(follow);
        } else if !options.yes {
            let follow: Vec<Step> = follow.collect();
            script.refuse_hazards(script.steps.iter().chain(&follow))?;
        }
        Ok(script)
    }

    /// Fails on a command that turns off a protection of the robot.
    fn refuse_hazards<'a>(&self, steps: impl Iterator<Item = &'a Step>) -> Result<(), Fault> {
        for step in steps {
            if let Step::Send(Line { request, .. }) = step
                && let Some(part) = request.turns_off()
            {
                let why = format!("`{request}` turns {part} off; add --yes to send it");
                return Err(usage(why).within(self.place(step), ""));
            }
        }
        Ok(())
    }

    fn read_file(path: &Path, own: &[String]) -> Result<Self, Fault> {
        Self::parse(
            name_of(path),
            &read_text(path)?,
            is_standard_input(path),
            own,
        )
    }

    fn parse(
        name: String,
        text: &str,
        is_standard_input: bool,
        own: &[String],
    ) -> Result<Self, Fault> {
        let mut steps = Vec::new();
        for (number, line) in (1..).zip(text.trim_start_matches('\u{feff}').lines()) {
            let wrong = |message| usage(format!("{name}:{number}: {message}"));
            let words = shlex::split(line).ok_or_else(|| {
                wrong("a quote is not closed; write an apostrophe as \"'\"".to_owned())
            })?;
            let words: Vec<&str> = words.iter().map(String::as_str).collect();
            let read = match words[..] {
                [] => continue,
                ["route", "-"] if is_standard_input => Err(
                    "the script itself is read from standard input; name the route's file"
                        .to_owned(),
                ),
                _ => read_step(&words, own, Some(number)),
            };
            steps.extend(read.map_err(wrong)?);
        }
        if steps.is_empty() {
            return Err(usage(format!(
                "{name}: no commands; write one per line, as after `groundwave send LINK`"
            )));
        }
        Ok(Self {
            name: Some(name),
            steps,
            task: None,
        })
    }

    /// The steps, in order.
    pub(super) fn steps(&self) -> &[Step] {
        &self.steps
    }

    /// Whether a step needs the robot's lines.
    pub(super) fn listens(&self) -> bool {
        let has_condition =
            |step: &Step| matches!(step, Step::Wait(wait, _) if wait.condition().is_some());
        self.steps.iter().any(has_condition)
    }

    /// Whether a task follows the list of parameters.
    pub(super) const fn has_task(&self) -> bool {
        self.task.is_some()
    }

    /// The next step of a state. The steps of a parameter file depend on the robot's `parameters`.
    pub(super) fn next(
        &mut self,
        options: &Send,
        index: usize,
        parameters: &[ParameterLine],
    ) -> Result<Option<Step>, Fault> {
        if index == self.steps.len()
            && let Some(task) = self.task.take()
        {
            let lines = task.follow(options, parameters)?;
            self.steps.extend(lines.into_iter().map(Step::Send));
        }
        Ok(self.steps.get(index).cloned())
    }

    /// Adds to a fault the line of the script and the commands that were not sent.
    pub(super) fn blame(&self, index: usize, fault: Fault) -> Fault {
        let after = self.steps.get(index + 1..).unwrap_or_default();
        let unsent: Vec<&Request> = after
            .iter()
            .filter_map(|step| match step {
                Step::Send(line) => Some(&line.request),
                Step::Wait(..) => None,
            })
            .collect();
        let rest = match unsent[..] {
            [] => String::new(),
            [request] => format!("; `{request}` was not sent"),
            _ => format!("; the {} commands after it were not sent", unsent.len()),
        };
        let place = self.steps.get(index).map(|step| self.place(step));
        fault.within(place.unwrap_or_default(), rest)
    }

    /// File and line of a command, to precede a message; empty for a command given as words.
    fn place(&self, step: &Step) -> String {
        let number = match step {
            Step::Send(line) => line.number,
            Step::Wait(_, number) => *number,
        };
        match (&self.name, number) {
            (Some(name), Some(number)) => format!("{name}:{number}: "),
            _ => String::new(),
        }
    }
}

fn read_step(words: &[&str], own: &[String], number: Option<usize>) -> Result<Vec<Step>, String> {
    if let Some(wait) = Wait::from_words(words) {
        return Ok(vec![Step::Wait(wait?, number)]);
    }
    let line = |request| Step::Send(Line { request, number });
    Ok(read_words(words, own)?.into_iter().map(line).collect())
}

fn read_words(words: &[&str], own: &[String]) -> Result<Vec<Request>, String> {
    match words {
        ["route", file] if !own.iter().any(|name| name == "route") => {
            let path = Path::new(file);
            let text = read_text(path).map_err(|fault| fault.to_string())?;
            let waypoints =
                route::parse(&name_of(path), &text).map_err(|error| error.to_string())?;
            let request = Request::route(waypoints).map_err(|error| error.to_string())?;
            Ok(vec![request])
        }
        ["route", ..] if !own.iter().any(|name| name == "route") => Err(
            "`route` takes one file of `X,Y` lines, or - for standard input; quote a name with spaces"
                .to_owned(),
        ),
        _ => Request::all_from_words_or_own(words, own).map_err(|error| error.in_shell()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A script is parsed to steps with their line numbers, or refused with the position of the mistake.
    #[test]
    fn fuzz_script() {
        const LINES: &str =
            "goto 12 -3\nwait until driven within 2m # note\nexpect battery > 11.5\nmode 'prowl'\n";
        bolero::check!()
            .with_iterations(5000)
            .for_each(|bytes: &[u8]| {
                let text = String::from_utf8_lossy(bytes);
                let at = text.chars().count() % LINES.len();
                for text in [&*text, &format!("{}{text}{}", &LINES[..at], &LINES[at..])] {
                    // Routes are read from files.
                    if text.contains("route") {
                        continue;
                    }
                    let own = ["light".to_owned()];
                    match Script::parse("s".to_owned(), text, false, &own) {
                        Ok(script) => {
                            let lines = text.lines().count();
                            let is_in = |number: &Option<usize>| {
                                number.is_some_and(|number| (1..=lines).contains(&number))
                            };
                            assert!(script.steps.iter().all(|step| match step {
                                Step::Send(line) => is_in(&line.number),
                                Step::Wait(_, number) => is_in(number),
                            }));
                        }
                        Err(fault) => assert!(fault.to_string().starts_with("s:"), "{fault}"),
                    }
                }
            });
    }
}
