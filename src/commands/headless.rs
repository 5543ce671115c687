//! `watch --headless`: what happens, as JSON lines on standard output.

use std::io::{self, Write};

use serde_json::{Value, json};

use super::{Exit, Fault};
use crate::capture::decode;
use crate::event::{Event, LinkEvent};
use crate::io::signals::{Signal, Signals, stop_myself};
use crate::runtime::Driver;

/// Runs until a signal, the end of standard input, or a reader that has seen enough.
pub(super) async fn run(mut driver: Driver) -> Result<(), Fault> {
    let mut signals = Signals::listen()
        .map_err(|error| Fault::new(Exit::Failed, format!("cannot listen for signals: {error}")))?;
    loop {
        tokio::select! {
            signal = signals.next() => match signal {
                Signal::Leave => return Ok(()),
                Signal::Suspend => stop_myself(),
            },
            () = driver.step() => {}
        }
        while let Some(event) = driver.poll_event() {
            if let Some(value) = to_json(&driver, &event)
                && let Err(error) = print(&value)
            {
                return Fault::output(&error);
            }
            if event == Event::Link(LinkEvent::Ended) {
                return Ok(());
            }
        }
    }
}

fn print(value: &Value) -> io::Result<()> {
    let mut out = io::stdout().lock();
    writeln!(out, "{value}")?;
    out.flush()
}

fn to_json(driver: &Driver, event: &Event) -> Option<Value> {
    let mut value = match event {
        Event::Line { line, raw } => {
            let received = groundwave_protocol::decoder::Received::Line(**line, *raw);
            json!({ "event": "line", "line": decode::to_json(&received) })
        }
        Event::Ack(line) => {
            let received = groundwave_protocol::decoder::Received::Ack(*line);
            json!({ "event": "line", "line": decode::to_json(&received) })
        }
        Event::Link(LinkEvent::Opened { name, can_send }) => {
            json!({ "event": "link", "state": "open", "name": name, "can_send": can_send })
        }
        Event::Link(LinkEvent::Lost { reason }) => {
            json!({ "event": "link", "state": "lost", "reason": reason })
        }
        Event::Link(LinkEvent::Ended) => json!({ "event": "link", "state": "ended" }),
        Event::Notice { level, text } => {
            json!({ "event": "notice", "level": format!("{level:?}").to_lowercase(), "text": text })
        }
        _ => return None,
    };
    value["at_s"] = json!((driver.now().as_secs_f64() * 1000.0).round() / 1000.0);
    Some(value)
}
