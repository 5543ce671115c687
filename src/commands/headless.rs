//! `watch --headless`: events as JSON lines on standard output.

use std::io::{self, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use std::time::Duration;

use groundwave_captures::messages::EstimateMessage;
use groundwave_lines::{Content, OwnLine, Value as OwnValue};
use groundwave_protocol::decoder::Received;
use serde_json::{Value, json};
use tokio::sync::{mpsc, oneshot};

use super::{Exit, Fault, out, say};
use crate::capture::decode;
use crate::event::{
    CommandId, CommandStatus, Event, Level, LinkEvent, Mark, Moment, Notice, NoticeCode,
};
use crate::io::signals::{Signal, Signals, stop_myself};
use crate::model::{Config, Facts};
use crate::runtime::{Driver, Keeper, Reports};
use crate::share::StatusJson;
use groundwave_captures::words::counted;

/// Interval of the checks on the recording and the alarms.
const CHECK_EVERY: Duration = Duration::from_secs(1);

/// Interval of the link statistics.
const STATISTICS_EVERY: Duration = Duration::from_secs(10);

/// Maximum number of lines queued for standard output.
const LINES_MAX: usize = 1 << 14;

/// Maximum number of lines that one step of the session can produce.
const ROOM: usize = LINES_MAX / 2;

/// Maximum time for standard output to take the last lines after a signal to leave.
const PATIENCE: Duration = Duration::from_secs(1);

/// Runs until a signal, the end of standard input, or a closed pipe. If `waits`, a slow reader of standard output delays the
/// session; otherwise the reader loses lines, and neither commands nor recordings wait for it.
pub(super) async fn run(
    mut driver: Driver,
    keeper: &Keeper,
    config: Config,
    waits: bool,
) -> Result<(), Fault> {
    let mut signals = Signals::listen().map_err(|error| failed("listen for signals", &error))?;
    let mut observer = Observer::new(config);
    let mut printer = Printer::start().map_err(|error| failed("start a thread", &error))?;
    let mut look = tokio::time::interval(CHECK_EVERY);
    let begin = tokio::time::Instant::now() + STATISTICS_EVERY;
    let mut statistics = tokio::time::interval_at(begin, STATISTICS_EVERY);
    let (mut reported, mut is_look_due) = (None, false);
    loop {
        let has_room = printer.lines.capacity() >= ROOM;
        if has_room {
            printer.tell_lost(driver.now())?;
        }
        tokio::select! {
            biased;
            signal = signals.next() => match signal {
                Signal::Leave => {
                    driver.end();
                    while let Some(event) = driver.poll_event() {
                        printer.print(driver.now(), &event)?;
                    }
                    printer.print_statistics(&driver)?;
                    return printer.finish(tokio::time::sleep(PATIENCE)).await;
                }
                Signal::Suspend => stop_myself(),
            },
            result = &mut printer.ended => return output(result),
            _ = statistics.tick() => printer.print_statistics(&driver)?,
            _ = look.tick() => {
                // The facts know of a suspension before they judge a silence.
                driver.detect_suspension();
                is_look_due = true;
            }
            () = room(&printer.lines), if waits && !has_room => {}
            () = driver.step(), if has_room || !waits => {}
        }
        while let Some(event) = driver.poll_event() {
            let has_ended = event == Event::Link(LinkEvent::Ended);
            if has_ended {
                printer.print_statistics(&driver)?;
            }
            printer.print(driver.now(), &event)?;
            observer.take(&mut driver, &event);
            if has_ended {
                let leave = async {
                    while signals.next().await == Signal::Suspend {
                        stop_myself();
                    }
                };
                return printer.finish(leave).await;
            }
        }
        if std::mem::take(&mut is_look_due) {
            // The call also flushes the recording when that is due.
            let recording = keeper.status();
            let problem = recording.problem.clone();
            let news = problem.clone().filter(|_| problem != reported);
            reported = problem;
            let alarm = news.map(|text| (Level::Alarm, text));
            let notices = std::iter::from_fn(|| keeper.poll_notice());
            for (level, text) in alarm.into_iter().chain(notices) {
                let notice = Notice::new(NoticeCode::Recording, level, text);
                printer.print(driver.now(), &Event::Notice(notice))?;
            }
            observer.take(&mut driver, &Event::Recording(recording));
        }
    }
}

/// The facts of a session without a screen.
pub(super) struct Observer {
    facts: Facts,
    reports: Reports,
}

impl Observer {
    pub(super) fn new(config: Config) -> Self {
        Self {
            facts: Facts::new(Arc::new(config)),
            reports: Reports::default(),
        }
    }

    /// Updates the facts with an event, and passes on what they report.
    pub(super) fn take(&mut self, driver: &mut Driver, event: &Event) {
        let now = driver.now();
        self.facts.update(now, event);
        for report in self.reports.take(now, event, &self.facts) {
            driver.tell(report);
        }
    }
}

/// Waits until half of the queue is free, or the printing thread has ended.
async fn room(lines: &mpsc::Sender<Vec<u8>>) {
    // The caller notices the end itself.
    let _ = lines.reserve_many(ROOM).await;
}

fn failed(what: &str, error: &dyn std::fmt::Display) -> Fault {
    Fault::new(Exit::Failed, format!("cannot {what}: {error}"))
}

/// Prints lines on its own thread. An unread standard output stalls no other thread.
struct Printer {
    lines: mpsc::Sender<Vec<u8>>,
    /// Result of the thread: all lines printed, or an error of standard output.
    ended: oneshot::Receiver<io::Result<()>>,
    /// Number of lines taken so far.
    taken: usize,
    printed: Arc<AtomicUsize>,
    /// Number of lines lost since the last notice because the queue was full.
    lost: usize,
}

impl Printer {
    fn start() -> io::Result<Self> {
        let (lines, mut queue) = mpsc::channel::<Vec<u8>>(LINES_MAX);
        let (end, ended) = oneshot::channel();
        let printed = Arc::<AtomicUsize>::default();
        let counter = Arc::clone(&printed);
        let mut print = move || {
            while let Some(line) = queue.blocking_recv() {
                let mut out = out();
                out.write_all(&line)?;
                out.flush()?;
                counter.fetch_add(1, Ordering::Relaxed);
            }
            Ok(())
        };
        thread::Builder::new()
            .name("printer".into())
            // The session may have ended.
            .spawn(move || drop(end.send(print())))?;
        Ok(Self {
            lines,
            ended,
            taken: 0,
            printed,
            lost: 0,
        })
    }

    fn queue(&mut self, line: Vec<u8>) {
        self.taken += 1;
        self.lost += usize::from(self.lines.try_send(line).is_err());
    }

    fn print(&mut self, at: Moment, event: &Event) -> Result<(), Fault> {
        let text = json_line(at, event).map_err(|error| failed("print an event", &error))?;
        if let Some(text) = text {
            self.queue(text);
        }
        Ok(())
    }

    fn print_statistics(&mut self, driver: &Driver) -> Result<(), Fault> {
        let mut value = serde_json::to_value(driver.statistics())
            .map_err(|error| failed("print statistics", &error))?;
        value["event"] = json!("statistics");
        value["at_s"] = seconds(driver.now());
        self.queue(format!("{value}\n").into_bytes());
        Ok(())
    }

    fn tell_lost(&mut self, at: Moment) -> Result<(), Fault> {
        let lost = std::mem::take(&mut self.lost);
        if lost == 0 {
            return Ok(());
        }
        let lost = counted(lost as u64, "line");
        let text = format!("{lost} not printed, because standard output was not read");
        let notice = Notice::new(NoticeCode::NotPrinted, Level::Warning, text);
        self.print(at, &Event::Notice(notice))
    }

    /// Waits until all lines are printed or `leave` ends.
    async fn finish(self, leave: impl Future<Output = ()>) -> Result<(), Fault> {
        drop(self.lines);
        tokio::select! {
            biased;
            result = self.ended => output(result),
            () = leave => {
                let lost = self.taken - self.printed.load(Ordering::Relaxed);
                say(format_args!(
                    "groundwave: {} not printed, because standard output is not read",
                    counted(lost as u64, "line")
                ));
                Ok(())
            }
        }
    }
}

/// The result of the printing thread.
fn output(result: Result<io::Result<()>, oneshot::error::RecvError>) -> Result<(), Fault> {
    match result {
        Ok(Err(error)) => Fault::output(&error),
        // A thread that panicked has reported the panic.
        Ok(Ok(())) | Err(_) => Ok(()),
    }
}

/// Seconds, rounded to milliseconds.
fn seconds(at: Moment) -> Value {
    json!((at.as_secs_f64() * 1000.0).round() / 1000.0)
}

/// An event as a line of JSON; `None` for events that only a screen shows.
fn json_line(at: Moment, event: &Event) -> io::Result<Option<Vec<u8>>> {
    let mut text = match event {
        Event::Line { line, raw } => line_json(at, &Received::Line(**line, *raw))?,
        Event::Ack(line) => line_json(at, &Received::Ack(*line))?,
        _ => match other_json(at, event) {
            Some(value) => value.to_string().into_bytes(),
            None => return Ok(None),
        },
    };
    if text.last() != Some(&b'\n') {
        text.push(b'\n');
    }
    Ok(Some(text))
}

/// A line of the robot as `export --to jsonl` writes it, with the key `event`.
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
        Event::Own(line) => own_json(line),
        Event::Outage(outage) => {
            let mut value = json!(outage);
            value["event"] = json!("outage");
            value
        }
        Event::Suspended(duration) => {
            json!({ "event": "suspended", "duration_s": duration.as_secs_f64() })
        }
        Event::Mark(Mark { ago, is_set }) => json!({
            "event": "mark",
            "status": if *is_set { "set" } else { "cleared" },
            "begin_s": seconds(at.saturating_sub(*ago)),
        }),
        Event::Asked { id, request, by } => {
            let mut value = command_json(*id, &CommandStatus::Queued);
            value["command"] = json!(request.to_string());
            if let Some(by) = by {
                value["by"] = json!(by);
            }
            value
        }
        Event::Alarm(alarm) => {
            let mut value = alarm.to_json();
            if let Some(began_at) = alarm.began_at {
                value["begin_s"] = seconds(began_at);
            }
            value
        }
        Event::Suggestion(suggestion) => suggestion.to_json(),
        Event::Estimate(estimate) => estimate_json(estimate),
        Event::Command { id, status } => command_json(*id, status),
        Event::Notice(Notice { code, level, text }) => {
            json!({ "event": "notice", "code": code.code(), "level": level.code(), "text": text })
        }
        _ => return None,
    };
    value["at_s"] = seconds(at);
    Some(value)
}

/// A line of the robot's own as JSON, with its values by name.
fn own_json(line: &OwnLine) -> Value {
    let (status, samples) = match &line.content {
        Content::Values(samples) => ("values", &samples[..]),
        Content::Text => ("text", &[][..]),
        Content::Damaged => ("damaged", &[][..]),
    };
    let values = samples.iter().map(|sample| {
        let value = match &sample.value {
            OwnValue::Number(number) => json!(number),
            OwnValue::Text(text) => json!(&**text),
        };
        (sample.field.name.clone(), value)
    });
    let values: serde_json::Map<_, _> = values.collect();
    json!({ "event": "own", "status": status, "text": line.text, "values": values })
}

fn estimate_json(estimate: &EstimateMessage) -> Value {
    let mut value = json!(estimate);
    value["event"] = json!("estimate");
    value
}

fn command_json(id: CommandId, status: &CommandStatus) -> Value {
    let mut value = json!(StatusJson::from(status));
    value["event"] = json!("command");
    value["id"] = json!(id.0);
    value
}
