//! Service calls: one command and one answer each.
//!
//! A call is JSON: `{"do":"mode prowl"}`, with a command as typed for `groundwave send`, or `{"route":[{"x_in":48,"y_in":0}]}`;
//! `"timeout_ms"` replaces the default of 20 s. The answer is sent when the robot has confirmed or refused the command,
//! or when the timeout has passed. The commands of a `preset` are sent one by one, up to the first that is not
//! confirmed.
//!
//! An answer is JSON; its `status` is the result. A failed command is also an answer, because not all tools show a
//! failed call.

use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

use serde::Deserialize;
use serde_json::{Value, json};

use super::codec::{CodecError, read_route, read_timeout};
use super::status::{ParameterJson, StatusJson};
use crate::event::{CommandId, CommandStatus, Failure, Moment};
use crate::request::Request;

/// Number of a call, from 1; never reused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct CallId(pub u64);

/// Reason why a call is invalid.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CallError {
    /// The call is not JSON of the expected form.
    #[error(
        "not understood: {0}. A call is {{\"do\":\"mode prowl\"}} or {{\"route\":[{{\"x_in\":48,\"y_in\":0}}]}}, in whole \
         inches; \"timeout_ms\" may be added"
    )]
    Json(String),
    /// The call has neither or both of `do` and `route`.
    #[error("a call needs either \"do\" or \"route\"")]
    Shape,
    /// The command is invalid, or there are too many waypoints.
    #[error("{0}")]
    Request(String),
}

/// An output for the server or the station.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CallOutput {
    /// Queue this request at the station, and pass the command's number to [`Calls::handle_started`].
    Start(CallId, Request),
    /// Answer the call with this JSON.
    Answer(CallId, Vec<u8>),
    /// Cancel this command, because its timeout has passed.
    GiveUp(CommandId),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CallJson {
    r#do: Option<String>,
    route: Option<Vec<PointJson>>,
    timeout_ms: Option<u64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PointJson {
    x_in: i16,
    y_in: i16,
}

#[derive(Debug)]
struct Call {
    /// The current command.
    request: Request,
    command: Option<CommandId>,
    /// Commands to send after the current one.
    rest: VecDeque<Request>,
    deadline: Moment,
    /// Parameters that the robot reported.
    parameters: Vec<ParameterJson>,
}

/// Calls that have not been answered.
#[derive(Debug, Default)]
pub struct Calls {
    calls: BTreeMap<CallId, Call>,
    outputs: VecDeque<CallOutput>,
}

impl Calls {
    /// Takes a call. Accepts any bytes.
    pub fn handle_call(&mut self, now: Moment, id: CallId, payload: &[u8]) {
        match parse(payload) {
            Ok((first, rest, timeout)) => {
                let call = Call {
                    request: first.clone(),
                    command: None,
                    rest,
                    deadline: now + timeout,
                    parameters: Vec::new(),
                };
                self.calls.insert(id, call);
                self.outputs.push_back(CallOutput::Start(id, first));
            }
            Err(error) => {
                let failed = StatusJson::failed("not-understood", error.to_string());
                self.answer(id, &json!(failed));
            }
        }
    }

    /// Takes the number that the station gave a call's command.
    pub fn handle_started(&mut self, id: CallId, command: CommandId) {
        if let Some(call) = self.calls.get_mut(&id) {
            call.command = Some(command);
        }
    }

    /// Takes a command's new status.
    pub fn handle_status(&mut self, command: CommandId, status: &CommandStatus) {
        let mut calls = self.calls.iter();
        if let Some((&id, _)) = calls.find(|(_, call)| call.command == Some(command)) {
            self.take_status(id, status);
        }
    }

    fn take_status(&mut self, id: CallId, status: &CommandStatus) {
        let Some(call) = self.calls.get_mut(&id) else {
            return;
        };
        match status {
            CommandStatus::Queued | CommandStatus::Sent { .. } | CommandStatus::Progress { .. } => {
                return;
            }
            CommandStatus::Reported(line) => {
                call.parameters.push(line.into());
                return;
            }
            CommandStatus::Confirmed { .. } | CommandStatus::Echoed => {
                if let Some(next) = call.rest.pop_front() {
                    call.request = next.clone();
                    call.command = None;
                    self.outputs.push_back(CallOutput::Start(id, next));
                    return;
                }
            }
            CommandStatus::Refused(_) | CommandStatus::Failed(_) => {}
        }
        let mut answer = json!(StatusJson::from(status));
        answer["command"] = json!(call.request.to_string());
        if !call.parameters.is_empty() {
            answer["parameters"] = json!(call.parameters);
        }
        self.answer(id, &answer);
    }

    /// Ends calls whose timeout has passed.
    pub fn handle_timeout(&mut self, now: Moment) {
        let over: Vec<CallId> = self
            .calls
            .iter()
            .filter(|(_, call)| call.deadline <= now)
            .map(|(id, _)| *id)
            .collect();
        for id in over {
            let command = self.calls.get(&id).and_then(|call| call.command);
            self.take_status(id, &CommandStatus::Failed(Failure::TimedOut));
            let given_up = command.map(CallOutput::GiveUp);
            self.outputs.extend(given_up);
        }
    }

    /// Latest time for the next call of [`Calls::handle_timeout`].
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Moment> {
        self.calls.values().map(|call| call.deadline).min()
    }

    /// The next output.
    pub fn poll_output(&mut self) -> Option<CallOutput> {
        self.outputs.pop_front()
    }

    fn answer(&mut self, id: CallId, answer: &Value) {
        self.calls.remove(&id);
        let answer = answer.to_string().into_bytes();
        self.outputs.push_back(CallOutput::Answer(id, answer));
    }
}

/// Whether a call asks for STOP, which is never refused.
#[must_use]
pub fn is_stop(payload: &[u8]) -> bool {
    matches!(parse(payload), Ok((Request::Stop, _, _)))
}

/// The answer to a call above the limit of waiting calls.
#[must_use]
pub fn busy() -> Vec<u8> {
    let text = "too many of your calls are waiting for the robot; try again when some are answered";
    json!(StatusJson::failed("busy", text))
        .to_string()
        .into_bytes()
}

/// The answer to a further STOP of a client whose other STOPs are waiting; this STOP is sent, too.
#[must_use]
pub fn stop_queued() -> Vec<u8> {
    let mut answer = json!(StatusJson::from(&CommandStatus::Queued));
    answer["command"] = json!(Request::Stop.to_string());
    answer.to_string().into_bytes()
}

/// Parses a call; returns the first request, the later requests, and the timeout of all together.
fn parse(payload: &[u8]) -> Result<(Request, VecDeque<Request>, Duration), CallError> {
    let json: CallJson =
        serde_json::from_slice(payload).map_err(|error| CallError::Json(error.to_string()))?;
    let refused = |error: CodecError| CallError::Request(error.to_string());
    let mut requests: VecDeque<Request> = match (json.r#do, json.route) {
        (Some(words), None) => {
            let words: Vec<&str> = words.split_whitespace().collect();
            Request::all_from_words(&words)
                .map_err(|error| CallError::Request(error.to_string()))?
                .into()
        }
        (None, Some(points)) => {
            let points = points.iter().map(|at| (at.x_in, at.y_in)).collect();
            [read_route(points).map_err(refused)?].into()
        }
        _ => return Err(CallError::Shape),
    };
    let timeout = read_timeout(json.timeout_ms).map_err(refused)?;
    let first = requests.pop_front().ok_or(CallError::Shape)?;
    Ok((first, requests, timeout))
}

#[cfg(test)]
mod tests;
