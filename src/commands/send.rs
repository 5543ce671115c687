//! `send`: commands from a shell or a script, each with its proof.

use std::fmt::Display;
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use groundwave_protocol::telemetry::Body;
use tokio::time::{Instant as TokioInstant, sleep_until};

use super::cli::{Send, Way};
use super::config::Config;
use super::report::Report;
use super::script::{Line, Script};
use super::simulated::Embedded;
use super::{Exit, Fault, block_on, dry_run, via};
use crate::event::{CommandStep, Event, Failure};
use crate::io::link::{Connection, Link, LinkSpec};
use crate::radio::Radio;
use crate::request::Request;
use crate::runtime::Driver;
use crate::share::Heard;

/// The lines that tell of mode and layers come within this, unless the channel is bad.
const WHY_PATIENCE: Duration = Duration::from_secs(6);

/// A look around takes nine seconds, and no robot goes on with one for longer than sixteen.
pub(super) const FINDINGS_PATIENCE: Duration = Duration::from_secs(25);

pub(super) fn run(options: &Send, config: &Config) -> Result<(), Fault> {
    let usage = |message| Fault::new(Exit::Usage, message);
    if options.dry_run {
        let words = options.words_to_plan().map_err(usage)?;
        return dry_run::run(options, &Script::read(options, &words)?);
    }
    let (way, words) = options.way().map_err(usage)?;
    let (way, config) = &way.at(config)?;
    let radio = options.radio.radio(config);
    let script = Script::read(options, &words)?;
    let receive_only = |name: &dyn Display| {
        let message = format!(
            "cannot send to {name}: the link is receive-only; name the radio's own link, or the station that has it: \
             --via ADDR"
        );
        Err(Fault::new(Exit::ReceiveOnly, message))
    };
    match way {
        Way::Via(address) if !radio.can_send() => receive_only(address),
        Way::Via(address) => via::deliver(options, address, &script),
        Way::Link(link @ (LinkSpec::Stdin | LinkSpec::Unix(_))) => receive_only(link),
        Way::Link(link) if !radio.can_send() => receive_only(link),
        Way::Link(link) => {
            let baud = options.radio.baud(config);
            block_on(deliver(options, link, baud, radio, &script))
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
    let opened = Link::start(spec, baud, connection, Box::new(|_, _| false), inputs);
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
            if let Event::Command {
                id: of,
                step: CommandStep::Refused(outcome),
            } = &event
                && *of == id
                && report.robot.wants_more(&line.request, *outcome)
            {
                let until = TokioInstant::now() + WHY_PATIENCE;
                listen(driver, until, |body| {
                    report.robot.take(body);
                    if report.robot.wants_more(&line.request, *outcome) {
                        ControlFlow::Continue(())
                    } else {
                        ControlFlow::Break(())
                    }
                })
                .await;
            }
            let after = driver.now().saturating_sub(begun);
            ended = ended.or(report.handle(&event, id, line, after)?);
        }
        match ended {
            Some(Ok(())) if line.request == Request::Scan => {
                let until = TokioInstant::now() + FINDINGS_PATIENCE;
                let findings = listen(driver, until, |body| match body {
                    Body::Text(text) if is_finding(text.as_str()) => {
                        ControlFlow::Break(text.as_str().to_owned())
                    }
                    _ => ControlFlow::Continue(()),
                })
                .await;
                let after = driver.now().saturating_sub(begun);
                return tell_findings(report, line, findings.as_deref(), after);
            }
            Some(ended) => return ended,
            None => {}
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

/// Listens to the robot until something has been heard; `None` when the time is over.
async fn listen<T>(
    driver: &mut Driver,
    until: TokioInstant,
    mut take: impl FnMut(&Body) -> ControlFlow<T>,
) -> Option<T> {
    loop {
        while let Some(event) = driver.poll_event() {
            if let Event::Line { line, .. } = &event
                && let ControlFlow::Break(heard) = take(&line.body)
            {
                return Some(heard);
            }
        }
        tokio::select! {
            () = driver.step() => {}
            () = sleep_until(until) => return None,
        }
    }
}

/// Whether the robot says what its look around found, or that there was none.
pub(super) fn is_finding(text: &str) -> bool {
    text.starts_with("scan: ")
}

/// Tells what the robot found when it looked around, as it said it.
pub(super) fn tell_findings(
    report: &Report,
    line: &Line,
    findings: Option<&str>,
    after: Duration,
) -> Result<(), Fault> {
    let Some(findings) = findings else {
        let message = format!(
            "the robot looks around, and what it found was not heard within {} s: ask again, or read its lines T",
            FINDINGS_PATIENCE.as_secs()
        );
        return Err(Fault::new(Exit::Failed, message));
    };
    report.said(line, findings, after)?;
    if findings.ends_with("broken off") {
        let message =
            "the robot broke the look around off: something was in its way, or somebody stopped it";
        return Err(Fault::new(Exit::Failed, message));
    }
    Ok(())
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
        // One that is going out already for somebody else has no frames of its own.
        _ if frames == 0 && *request != Request::Stop => " It was not sent.",
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
