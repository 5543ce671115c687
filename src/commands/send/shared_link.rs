//! Delivers commands through a station that shares its link: `--via`, or a link that turns out to be shared.

use std::time::{Duration, Instant};

use groundwave_protocol::decoder::Decoder;

use super::super::cli::Send;
use super::super::{Exit, Fault};
use super::faults::not_confirmed;
use super::report::{Report, SCAN_TIMEOUT, scan_result};
use super::script::Script;
use super::step::{Line, Step};
use crate::event::{CommandStatus, Failure};
use crate::io::share_client::{ShareClient, ShareClientError};
use crate::request::Request;
use crate::share::{Address, Ask, ClientLine, StationLine, StatusJson};
use crate::wait::{Wait, Waiting};

/// Time to wait after the timeout before giving up the station. The station itself handles the timeout.
const GRACE: Duration = Duration::from_secs(5);

/// Time between two checks of a wait without a limit.
const LOOK_EVERY: Duration = Duration::from_secs(1);

/// Delivers each command of the script until one fails.
pub(super) fn deliver(options: &Send, address: &Address, script: &mut Script) -> Result<(), Fault> {
    let (mut client, _) = ShareClient::connect(address, options.usual_timeout(), script.listens())
        .map_err(|error| Fault::new(Exit::NoLink, error))?;
    let mut report = Report::new(options, script);
    for (index, tag) in (1..).enumerate() {
        let Some(step) = script.next(options, index, report.parameters())? else {
            break;
        };
        let result = match &step {
            Step::Send(line) => ask(options, &mut client, &mut report, tag, line),
            Step::Wait(wait, number) => wait_for(options, &mut client, &report, wait, *number),
        };
        result.map_err(|fault| script.blame(index, fault))?;
    }
    Ok(())
}

/// Waits for a time or a condition, using the lines that the station passes on from now on.
fn wait_for(
    options: &Send,
    client: &mut ShareClient,
    report: &Report,
    wait: &Wait,
    number: Option<usize>,
) -> Result<(), Fault> {
    let mut waiting = Waiting::new(wait.clone(), options.usual_timeout());
    let mut decoder = Decoder::default();
    let begun = Instant::now();
    loop {
        if let Some(ended) = waiting.ended(begun.elapsed()) {
            return report.waited(wait, number, ended, begun.elapsed());
        }
        let limit = waiting.limit().map_or(LOOK_EVERY, |limit| {
            limit.saturating_sub(begun.elapsed()).min(LOOK_EVERY)
        });
        match client.next(Instant::now() + limit) {
            Ok(StationLine::Received { rx }) => {
                decoder.lines(&rx.0).for_each(|line| waiting.take(&line));
            }
            Ok(StationLine::Lost { lost }) => report.lost(&lost),
            Ok(_) | Err(ShareClientError::Silent(_)) => {}
            Err(error) => return Err(Fault::new(Exit::NoLink, format!("`{wait}`: {error}"))),
        }
    }
}

fn ask(
    options: &Send,
    client: &mut ShareClient,
    report: &mut Report,
    tag: u32,
    line: &Line,
) -> Result<(), Fault> {
    let request = &line.request;
    let begun = Instant::now();
    let ask = Ask {
        tag,
        request: request.clone(),
        timeout: options.timeout_of(request),
    };
    let mut link_lost = None;
    converse(client, &ask, |said| match said {
        StationLine::Status {
            status: json,
            heard,
            ..
        } => {
            let status = status_of(&json, request)?;
            if let CommandStatus::Refused(_) = status {
                report.reason = json.text;
            }
            let ended = report.status(line, &status, begun.elapsed())?;
            if let CommandStatus::Failed(Failure::TimedOut | Failure::NotSent) = status {
                let waited = begun.elapsed();
                let lost = link_lost.as_deref();
                return Err(not_confirmed(request, lost, heard, waited, report.frames));
            }
            ended.transpose()
        }
        StationLine::Lost { lost } => {
            report.lost(&lost);
            link_lost = Some(lost);
            Ok(None)
        }
        _ => Ok(None),
    })?;
    if *request != Request::Scan {
        return Ok(());
    }
    let until = Instant::now() + SCAN_TIMEOUT;
    let result = loop {
        match client.next(until) {
            Ok(StationLine::Said { said }) if scan_result(&said).is_some() => break Some(said),
            Ok(_) => {}
            Err(_) => break None,
        }
    };
    report.scan(line, result.as_deref(), begun.elapsed())
}

/// The status that a station reported.
fn status_of(json: &StatusJson, request: &Request) -> Result<CommandStatus, Fault> {
    json.status().ok_or_else(|| {
        let message = format!(
            "`{request}`: the station sent an unknown status {json:?}; update this program"
        );
        Fault::new(Exit::Failed, message)
    })
}

/// Sends a command and passes each answer to `take` until it returns a value.
fn converse<T>(
    client: &mut ShareClient,
    ask: &Ask,
    mut take: impl FnMut(StationLine) -> Result<Option<T>, Fault>,
) -> Result<T, Fault> {
    let request = &ask.request;
    let unknown = |error: ShareClientError| {
        let message = format!("`{request}`: {error}: the robot may or may not have executed it");
        Fault::new(Exit::NotConfirmed, message)
    };
    let deadline = Instant::now() + ask.timeout + GRACE;
    client
        .send(&ClientLine::Ask(ask.clone()))
        .map_err(unknown)?;
    loop {
        let line = client.next(deadline).map_err(unknown)?;
        match &line {
            StationLine::Status { id, .. } if *id != ask.tag => continue,
            StationLine::Error { error, .. } => {
                return Err(Fault::new(Exit::Failed, format!("`{request}`: {error}")));
            }
            _ => {}
        }
        if let Some(end) = take(line)? {
            return Ok(end);
        }
    }
}
