//! `watch --headless`: events as JSON lines on standard output.

use std::io::{self, Write};
use std::time::Duration;

use groundwave_protocol::decoder::Received;
use serde_json::{Value, json};

use super::{Exit, Fault, out};
use crate::capture::decode;
use crate::event::{CommandId, CommandStatus, Event, Level, LinkEvent, Moment, Notice, NoticeCode};
use crate::io::signals::{Signal, Signals, stop_myself};
use crate::runtime::{Driver, Keeper};
use crate::share::StatusJson;

/// Interval of the checks on the recording.
const CHECK_EVERY: Duration = Duration::from_secs(1);

/// Interval of the link statistics.
const STATISTICS_EVERY: Duration = Duration::from_secs(10);

/// Runs until a signal, the end of standard input, or a closed pipe.
pub(super) async fn run(mut driver: Driver, keeper: &Keeper) -> Result<(), Fault> {
    let mut signals = Signals::listen()
        .map_err(|error| Fault::new(Exit::Failed, format!("cannot listen for signals: {error}")))?;
    let mut look = tokio::time::interval(CHECK_EVERY);
    let begin = tokio::time::Instant::now() + STATISTICS_EVERY;
    let mut statistics = tokio::time::interval_at(begin, STATISTICS_EVERY);
    let mut reported = None;
    loop {
        tokio::select! {
            signal = signals.next() => match signal {
                Signal::Leave => {
                    return print_statistics(&driver).or_else(|error| Fault::output(&error));
                }
                Signal::Suspend => stop_myself(),
            },
            () = driver.step() => {}
            _ = statistics.tick() => {
                if let Err(error) = print_statistics(&driver) {
                    return Fault::output(&error);
                }
            }
            _ = look.tick() => {
                // The call also flushes the recording when that is due.
                let problem = keeper.status().problem;
                if let Some(text) = problem.clone().filter(|_| problem != reported) {
                    let notice = Event::Notice(Notice::new(NoticeCode::Recording, Level::Alarm, text));
                    if let Err(error) = print(driver.now(), &notice) {
                        return Fault::output(&error);
                    }
                }
                reported = problem;
                while let Some((level, text)) = keeper.poll_notice() {
                    if let Err(error) = print(driver.now(), &Event::Notice(Notice::new(NoticeCode::Recording, level, text))) {
                        return Fault::output(&error);
                    }
                }
            }
        }
        while let Some(event) = driver.poll_event() {
            let has_ended = event == Event::Link(LinkEvent::Ended);
            let last = if has_ended {
                print_statistics(&driver)
            } else {
                Ok(())
            };
            if let Err(error) = last.and_then(|()| print(driver.now(), &event)) {
                return Fault::output(&error);
            }
            if has_ended {
                return Ok(());
            }
        }
    }
}

fn print_statistics(driver: &Driver) -> io::Result<()> {
    let mut value = serde_json::to_value(driver.statistics())?;
    value["event"] = json!("statistics");
    value["at_s"] = seconds(driver.now());
    let mut out = out();
    writeln!(out, "{value}")?;
    out.flush()
}

/// Seconds, rounded to milliseconds.
fn seconds(at: Moment) -> Value {
    json!((at.as_secs_f64() * 1000.0).round() / 1000.0)
}

fn print(at: Moment, event: &Event) -> io::Result<()> {
    let mut text = match event {
        Event::Line { line, raw } => line_json(at, &Received::Line(**line, *raw))?,
        Event::Ack(line) => line_json(at, &Received::Ack(*line))?,
        _ => match other_json(at, event) {
            Some(value) => value.to_string().into_bytes(),
            None => return Ok(()),
        },
    };
    if text.last() != Some(&b'\n') {
        text.push(b'\n');
    }
    let mut out = out();
    out.write_all(&text)?;
    out.flush()
}

/// A line as `decode` writes it, with the key `event`.
fn line_json(at: Moment, received: &Received) -> io::Result<Vec<u8>> {
    let mut decoded = Vec::new();
    decode::write_json(&mut decoded, at, received)?;
    let mut text = b"{\"event\":\"line\",".to_vec();
    text.extend_from_slice(decoded.get(1..).unwrap_or_default());
    Ok(text)
}

fn other_json(at: Moment, event: &Event) -> Option<Value> {
    let mut value = match event {
        Event::Link(LinkEvent::Opened { name, can_send }) => {
            json!({ "event": "link", "state": "open", "name": name, "can_send": can_send })
        }
        Event::Link(LinkEvent::Lost { reason }) => {
            json!({ "event": "link", "state": "lost", "text": reason })
        }
        Event::Link(LinkEvent::Ended) => json!({ "event": "link", "state": "ended" }),
        Event::Reception { reception, since } => json!({
            "event": "reception",
            "code": reception.code(),
            "since_s": since.as_secs_f64(),
        }),
        Event::Asked { id, request, by } => {
            let mut value = command_json(*id, &CommandStatus::Queued);
            value["command"] = json!(request.to_string());
            if let Some(by) = by {
                value["by"] = json!(by);
            }
            value
        }
        Event::Command { id, status } => command_json(*id, status),
        Event::Notice(Notice { code, level, text }) => {
            json!({ "event": "notice", "code": code.code(), "level": level.code(), "text": text })
        }
        _ => return None,
    };
    value["at_s"] = seconds(at);
    Some(value)
}

fn command_json(id: CommandId, status: &CommandStatus) -> Value {
    let mut value = json!(StatusJson::from(status));
    value["event"] = json!("command");
    value["id"] = json!(id.0);
    value
}
