//! Delivers commands over a link of this process.

use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use groundwave_protocol::decoder::Received;
use groundwave_protocol::telemetry::{Body, Outcome};
use tokio::time::{Instant as TokioInstant, sleep_until};

use super::super::Fault;
use super::super::cli::{LinkArgs, Send};
use super::super::connecting::connect;
use super::super::simulated::{Embedded, embed};
use super::faults::not_confirmed;
use super::report::{Report, SCAN_TIMEOUT, scan_result};
use super::script::Script;
use super::step::{Line, Step};
use crate::event::{CommandId, CommandStatus, Event, Failure, LinkEvent};
use crate::io::link::{BAUD, Connection, Link, LinkSpec};
use crate::radio::Radio;
use crate::request::Request;
use crate::runtime::Driver;
use crate::share::Address;
use crate::wait::{Wait, Waiting};

/// Time to wait for the lines with mode and layers after a refusal.
const REFUSAL_TIMEOUT: Duration = Duration::from_secs(6);

/// An open link without a station.
pub(in super::super) struct Opened {
    name: String,
    spec: LinkSpec,
    /// Baud rate, if one is asked for.
    baud: Option<u32>,
    connection: Connection,
    simulator: Embedded,
}

/// Opens a link; starts a simulated robot if the link is `sim`.
pub(in super::super) fn open(
    link: &LinkSpec,
    baud: Option<u32>,
    options: &LinkArgs,
    radio: Radio,
) -> Result<Opened, Fault> {
    let (spec, simulator) = embed(link, radio.kind)?;
    let connection = connect(&spec, baud.unwrap_or(BAUD), options)?;
    Ok(Opened {
        name: link.to_string(),
        spec,
        baud,
        connection,
        simulator,
    })
}

impl Opened {
    /// The station at the other end, if it shares its link.
    pub(in super::super) fn station(&self) -> Option<Address> {
        self.spec.station().filter(|_| self.connection.is_shared())
    }

    /// Starts a station on the link.
    pub(in super::super) fn start(self, radio: Radio) -> (Driver, Embedded) {
        let (inputs, from_link) = tokio::sync::mpsc::channel(64);
        let no_sink = Box::new(|_, _: &[u8]| ());
        let rate = self.spec.rate(self.baud);
        let baud = self.baud.unwrap_or(BAUD);
        let link = Link::start(self.spec, baud, self.connection, no_sink, inputs);
        let unrecorded = Box::new(|_, _: &[u8]| ());
        let started = Instant::now();
        let driver = Driver::new(self.name, link, from_link, radio, started, unrecorded);
        (driver.at_baud(rate), self.simulator)
    }
}

/// Delivers each command of the script until one fails.
pub(super) async fn deliver(
    options: &Send,
    mut driver: Driver,
    _simulator: Embedded,
    script: &mut Script,
) -> Result<(), Fault> {
    let mut report = Report::new(options, script);
    let mut index = 0;
    while let Some(step) = script.next(options, index, report.parameters())? {
        let result = match &step {
            Step::Send(line) => deliver_one(options, &mut driver, &mut report, line).await,
            Step::Wait(wait, number) => {
                wait_for(options, &mut driver, &mut report, wait, *number).await
            }
        };
        result.map_err(|fault| script.blame(index, fault))?;
        index += 1;
    }
    Ok(())
}

/// Waits for a time or a condition, using the lines received from now on.
async fn wait_for(
    options: &Send,
    driver: &mut Driver,
    report: &mut Report,
    wait: &Wait,
    number: Option<usize>,
) -> Result<(), Fault> {
    let mut waiting = Waiting::new(wait.clone(), options.usual_timeout());
    let begun = TokioInstant::now();
    loop {
        while let Some(event) = driver.poll_event() {
            match &event {
                Event::Line { line, raw } => {
                    report.robot.take(&line.body);
                    waiting.take(&Received::Line(**line, *raw));
                }
                Event::Link(LinkEvent::Lost { reason }) => report.lost(reason),
                _ => {}
            }
        }
        if let Some(ended) = waiting.ended(begun.elapsed()) {
            return report.waited(wait, number, ended, begun.elapsed());
        }
        let limit = waiting.limit().map(|limit| begun + limit);
        tokio::select! {
            () = driver.step() => {}
            () = sleep_until(limit.unwrap_or(begun)), if limit.is_some() => {}
        }
    }
}

async fn deliver_one(
    options: &Send,
    driver: &mut Driver,
    report: &mut Report,
    line: &Line,
) -> Result<(), Fault> {
    let begun = driver.now();
    let id = driver.request(line.request.clone());
    let timeout = options.timeout_of(&line.request);
    let deadline = tokio::time::sleep(timeout);
    tokio::pin!(deadline);
    loop {
        let mut ended = None;
        while let Some(event) = driver.poll_event() {
            if let Some(outcome) = refusal(&event, id) {
                listen_for_reason(driver, report, &line.request, outcome).await;
            }
            let after = driver.now().saturating_sub(begun);
            ended = ended.or(report.handle(&event, id, line, after)?);
        }
        match ended {
            Some(Ok(())) if line.request == Request::Scan => {
                let until = TokioInstant::now() + SCAN_TIMEOUT;
                let result = listen(driver, until, |body| match body {
                    Body::Text(text) => scan_result(text.as_str())
                        .map_or(ControlFlow::Continue(()), |text| {
                            ControlFlow::Break(text.to_owned())
                        }),
                    _ => ControlFlow::Continue(()),
                })
                .await;
                let after = driver.now().saturating_sub(begun);
                return report.scan(line, result.as_deref(), after);
            }
            Some(ended) => return ended,
            None => {}
        }
        tokio::select! {
            () = driver.step() => {}
            () = &mut deadline => {
                driver.cancel();
                let after = driver.now().saturating_sub(begun);
                // The fault below is more precise than the one returned here.
                report.status(line, &CommandStatus::Failed(Failure::TimedOut), after)?;
                let heard = driver.heard();
                return Err(not_confirmed(&line.request, None, heard, timeout, report.frames));
            }
        }
    }
}

/// The outcome with which the robot refused command `id`; `None` for other events.
fn refusal(event: &Event, id: CommandId) -> Option<Outcome> {
    match event {
        Event::Command {
            id: of,
            status: CommandStatus::Refused(outcome),
        } if *of == id => Some(*outcome),
        _ => None,
    }
}

/// Listens for the lines that explain a refusal.
async fn listen_for_reason(
    driver: &mut Driver,
    report: &mut Report,
    request: &Request,
    outcome: Outcome,
) {
    if !report.robot.wants_more(request, outcome) {
        return;
    }
    let until = TokioInstant::now() + REFUSAL_TIMEOUT;
    listen(driver, until, |body| {
        report.robot.take(body);
        if report.robot.wants_more(request, outcome) {
            ControlFlow::Continue(())
        } else {
            ControlFlow::Break(())
        }
    })
    .await;
}

/// Passes each line to `take` until it returns a value; returns `None` when the time is over.
async fn listen<T>(
    driver: &mut Driver,
    until: TokioInstant,
    mut take: impl FnMut(&Body) -> ControlFlow<T>,
) -> Option<T> {
    loop {
        while let Some(event) = driver.poll_event() {
            if let Event::Line { line, .. } = &event
                && let ControlFlow::Break(result) = take(&line.body)
            {
                return Some(result);
            }
        }
        tokio::select! {
            () = driver.step() => {}
            () = sleep_until(until) => return None,
        }
    }
}
