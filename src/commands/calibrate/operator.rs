//! Delivers the calibration's commands over its own link or a shared one, and receives the robot's lines meanwhile.

use std::time::Duration;

use groundwave_protocol::telemetry::{ParameterLine, ParameterName};
use tokio::time::{Instant, sleep_until};

use super::super::cli::{Calibrate, Connection};
use super::super::config::Config;
use super::super::send::faults::{failed, not_confirmed, receive_only, refused};
use super::super::send::own_link::connect;
use super::super::send::shared_link::{converse, status_of};
use super::super::simulated::Embedded;
use super::super::{Exit, Fault};
use crate::event::{CommandStatus, Event, Failure};
use crate::io::link::LinkSpec;
use crate::io::share_client::ShareClient;
use crate::radio::Radio;
use crate::request::outcome_words;
use crate::request::{Amount, Request, Tuning};
use crate::runtime::Driver;
use crate::share::{Address, Ask, Heard, StationLine};

/// Factor on the timeout of a command that lists all parameters.
const LIST_TIMES: u32 = 6;

/// A link to the robot, and the delivery of its commands.
pub(super) struct Operator {
    driver: Driver,
    _simulator: Embedded,
    /// The station that sends the commands; the driver then only listens.
    via: Option<Address>,
    timeout: Duration,
}

impl Operator {
    /// Opens the link, or connects to a station and reads its raw bytes like a radio's.
    pub(super) fn connect(options: &Calibrate, config: &Config) -> Result<Self, Fault> {
        let way = options
            .connection()
            .map_err(|error| Fault::new(Exit::Usage, error))?;
        let (way, config) = &way.at(config)?;
        let radio = options.radio.radio(config);
        let (link, radio, via) = match way {
            Connection::Link(link) => {
                if !radio.can_send() || matches!(link, LinkSpec::Stdin | LinkSpec::Unix(_)) {
                    return Err(receive_only(link));
                }
                (link.clone(), radio, None)
            }
            Connection::Via(address) => {
                let (_, welcome) = ShareClient::connect(address, options.timeout)
                    .map_err(|error| Fault::new(Exit::NoLink, error))?;
                if !welcome.can_send || !radio.can_send() {
                    return Err(receive_only(&welcome.link));
                }
                let link = match address {
                    Address::Tcp(address) => LinkSpec::Tcp(address.clone()),
                    Address::Unix(path) => LinkSpec::Unix(path.clone()),
                };
                (link, Radio::RECEIVE_ONLY, Some(address.clone()))
            }
        };
        let (driver, simulator) = connect(&link, options.radio.baud(config), radio)?;
        Ok(Self {
            driver,
            _simulator: simulator,
            via,
            timeout: options.timeout,
        })
    }

    /// Waits for events; safe to cancel.
    pub(super) async fn step(&mut self) {
        self.driver.step().await;
    }

    /// The next event.
    pub(super) fn poll_event(&mut self) -> Option<Event> {
        self.driver.poll_event()
    }

    /// The value of a parameter.
    pub(super) async fn get(&mut self, name: &str) -> Result<i16, Fault> {
        let request = Request::Parameter(Tuning::Get(ParameterName::new(name)));
        let lines = self.deliver(request).await?;
        lines
            .last()
            .and_then(|line| i16::try_from(line.value).ok())
            .ok_or_else(|| {
                let message = format!("the robot did not report its parameter `{name}`");
                Fault::new(Exit::Failed, message)
            })
    }

    /// Sets a parameter until the robot's next reset.
    pub(super) async fn set(&mut self, name: &str, value: i32) -> Result<(), Fault> {
        let tuning = Tuning::Set(ParameterName::new(name), Amount::Counts(value));
        self.deliver(Request::Parameter(tuning)).await.map(|_| ())
    }

    /// Delivers a command; returns the parameters that the robot reported.
    pub(super) async fn deliver(&mut self, request: Request) -> Result<Vec<ParameterLine>, Fault> {
        let times = match request {
            Request::Parameter(Tuning::List) => LIST_TIMES,
            _ => 1,
        };
        let timeout = self.timeout * times;
        match self.via.clone() {
            Some(address) => self.deliver_via(address, request, timeout).await,
            None => self.deliver_over_own_link(request, timeout).await,
        }
    }

    async fn deliver_over_own_link(
        &mut self,
        request: Request,
        timeout: Duration,
    ) -> Result<Vec<ParameterLine>, Fault> {
        let id = self.driver.request(request.clone());
        let deadline = Instant::now() + timeout;
        let mut progress = Progress::default();
        loop {
            while let Some(event) = self.driver.poll_event() {
                let Event::Command { id: of, status } = event else {
                    continue;
                };
                if of == id && progress.take(&request, &status, self.driver.heard(), timeout)? {
                    return Ok(progress.reported);
                }
            }
            tokio::select! {
                () = self.driver.step() => {}
                () = sleep_until(deadline) => {
                    let heard = self.driver.heard();
                    return Err(not_confirmed(&request, heard, timeout, progress.frames));
                }
            }
        }
    }

    async fn deliver_via(
        &mut self,
        address: Address,
        request: Request,
        timeout: Duration,
    ) -> Result<Vec<ParameterLine>, Fault> {
        // The client blocks; the driver goes on listening.
        let asked = tokio::task::spawn_blocking(move || ask(&address, request, timeout));
        tokio::pin!(asked);
        loop {
            tokio::select! {
                result = &mut asked => {
                    let failed = |error| Fault::new(Exit::Failed, error);
                    return result.map_err(failed)?;
                }
                () = self.driver.step() => while self.driver.poll_event().is_some() {},
            }
        }
    }
}

fn ask(
    address: &Address,
    request: Request,
    timeout: Duration,
) -> Result<Vec<ParameterLine>, Fault> {
    let (mut client, _) =
        ShareClient::connect(address, timeout).map_err(|error| Fault::new(Exit::NoLink, error))?;
    let ask = Ask {
        tag: 1,
        request,
        timeout,
    };
    let mut progress = Progress::default();
    converse(&mut client, &ask, |said| {
        let StationLine::Status { status, heard, .. } = said else {
            return Ok(None);
        };
        let status = status_of(&status, &ask.request)?;
        let ended = progress.take(&ask.request, &status, heard, timeout)?;
        Ok(ended.then_some(()))
    })?;
    Ok(progress.reported)
}

/// Progress of a command.
#[derive(Default)]
struct Progress {
    reported: Vec<ParameterLine>,
    frames: u32,
}

impl Progress {
    /// Handles a status; returns whether the command is confirmed.
    fn take(
        &mut self,
        request: &Request,
        status: &CommandStatus,
        heard: Heard,
        timeout: Duration,
    ) -> Result<bool, Fault> {
        match status {
            CommandStatus::Reported(line) => self.reported.push(*line),
            CommandStatus::Sent { frames } => self.frames = *frames,
            CommandStatus::Confirmed { .. } => return Ok(true),
            CommandStatus::Refused(outcome) => {
                return Err(refused(request, outcome_words(*outcome)));
            }
            CommandStatus::Failed(Failure::TimedOut) => {
                return Err(not_confirmed(request, heard, timeout, self.frames));
            }
            CommandStatus::Failed(failure) => return Err(failed(request, *failure)),
            CommandStatus::Queued | CommandStatus::Progress { .. } => {}
        }
        Ok(false)
    }
}
