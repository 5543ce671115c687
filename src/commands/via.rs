//! `send --via`: commands through the station that owns the radio, with the same words and proof.

use std::time::{Duration, Instant};

use super::cli::Send;
use super::report::Report;
use super::script::{Line, Script};
use super::send::{FINDINGS_PATIENCE, is_finding, not_confirmed, tell_findings};
use super::{Exit, Fault};
use crate::event::{CommandStep, Failure};
use crate::io::via::{Via, ViaError};
use crate::request::Request;
use crate::share::{Address, Ask, ClientLine, Stage, StationLine};

/// The station ends a command at its time; this is for one that is stopped itself.
const GRACE: Duration = Duration::from_secs(5);

pub(super) fn deliver(options: &Send, address: &Address, script: &Script) -> Result<(), Fault> {
    let (mut via, _) = Via::connect(address).map_err(|error| Fault::new(Exit::NoLink, error))?;
    let mut report = Report::new(options);
    for (index, (tag, line)) in (1..).zip(script.lines()).enumerate() {
        ask(options, &mut via, &mut report, tag, line)
            .map_err(|fault| script.blame(index, fault))?;
    }
    Ok(())
}

fn ask(
    options: &Send,
    via: &mut Via,
    report: &mut Report,
    tag: u32,
    line: &Line,
) -> Result<(), Fault> {
    let request = &line.request;
    let begun = Instant::now();
    let ask = Ask {
        tag,
        request: request.clone(),
        timeout: options.timeout,
    };
    converse(via, &ask, |said| match said {
        StationLine::Step { stage, heard, .. } => {
            let step = step_of(&stage, request)?;
            if let Stage::Refused { reason, .. } = &stage {
                report.reason = Some(reason.clone());
            }
            let ended = report.step(line, &step, begun.elapsed())?;
            if step == CommandStep::Failed(Failure::TimedOut) {
                let waited = begun.elapsed();
                return Err(not_confirmed(request, heard, waited, report.frames));
            }
            ended.transpose()
        }
        StationLine::Lost { lost } => {
            report.lost(&lost);
            Ok(None)
        }
        _ => Ok(None),
    })?;
    if *request != Request::Scan {
        return Ok(());
    }
    let until = Instant::now() + FINDINGS_PATIENCE;
    let findings = loop {
        match via.next(until) {
            Ok(StationLine::Said { said }) if is_finding(&said) => break Some(said),
            Ok(_) => {}
            Err(_) => break None,
        }
    };
    tell_findings(report, line, findings.as_deref(), begun.elapsed())
}

/// The step that a station told.
pub(super) fn step_of(stage: &Stage, request: &Request) -> Result<CommandStep, Fault> {
    stage.step(request).ok_or_else(|| {
        let message = format!("`{request}`: the station is newer and says {stage:?}");
        Fault::new(Exit::Failed, message)
    })
}

/// Asks, and hands over what the station says of it until that returns something.
pub(super) fn converse<T>(
    via: &mut Via,
    ask: &Ask,
    mut take: impl FnMut(StationLine) -> Result<Option<T>, Fault>,
) -> Result<T, Fault> {
    let request = &ask.request;
    let unknown = |error: ViaError| {
        let message = format!("`{request}`: {error}: the robot may or may not have executed it");
        Fault::new(Exit::NotConfirmed, message)
    };
    let deadline = Instant::now() + ask.timeout + GRACE;
    via.send(&ClientLine::Ask(ask.clone())).map_err(unknown)?;
    loop {
        let line = via.next(deadline).map_err(unknown)?;
        match &line {
            StationLine::Step { id, .. } if *id != ask.tag => continue,
            StationLine::Error { error } => {
                return Err(Fault::new(Exit::Failed, format!("`{request}`: {error}")));
            }
            _ => {}
        }
        if let Some(end) = take(line)? {
            return Ok(end);
        }
    }
}
