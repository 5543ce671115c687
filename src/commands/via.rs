//! `send --via`: commands through the station that owns the radio, with the same words and proof.

use std::time::{Duration, Instant};

use super::cli::Send;
use super::script::{Line, Script};
use super::send::{Report, not_confirmed};
use super::{Exit, Fault};
use crate::event::{CommandStep, Failure};
use crate::io::via::{Via, ViaError};
use crate::share::{Address, Ask, ClientLine, StationLine};

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
    let unknown = |error: ViaError| {
        let message = format!("`{request}`: {error}: the robot may or may not have executed it");
        Fault::new(Exit::NotConfirmed, message)
    };
    via.send(&ClientLine::Ask(Ask {
        tag,
        request: request.clone(),
        timeout: options.timeout,
    }))
    .map_err(unknown)?;
    let deadline = begun + options.timeout + GRACE;
    loop {
        match via.next(deadline).map_err(unknown)? {
            StationLine::Step { id, stage, heard } if id == tag => {
                let step = stage.step(request).ok_or_else(|| {
                    let message = format!("`{request}`: the station is newer and says {stage:?}");
                    Fault::new(Exit::Failed, message)
                })?;
                let ended = report.step(line, &step, begun.elapsed())?;
                match (step, ended) {
                    (CommandStep::Failed(Failure::TimedOut), _) => {
                        return Err(not_confirmed(
                            request,
                            heard,
                            begun.elapsed(),
                            report.frames,
                        ));
                    }
                    (_, Some(ended)) => return ended,
                    (_, None) => {}
                }
            }
            StationLine::Lost { lost } => report.lost(&lost),
            StationLine::Error { error } => {
                return Err(Fault::new(Exit::Failed, format!("`{request}`: {error}")));
            }
            StationLine::Step { .. } | StationLine::Welcome(_) => {}
        }
    }
}
