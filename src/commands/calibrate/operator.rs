//! Delivers the commands of a calibration over its own link or a shared link, and receives the robot's lines.

use std::time::Duration;

use groundwave_protocol::telemetry::{ParameterLine, ParameterName};
use tokio::time::{Instant, sleep_until};

use super::super::cli::{Calibrate, Connection};
use super::super::config::Config;
use super::super::send::direct_link::open;
use super::super::send::faults::{failed, not_confirmed, receive_only, refused};
use super::super::simulated::Embedded;
use super::super::{Exit, Fault};
use crate::event::{CommandStatus, Event, Failure};
use crate::io::link::LinkSpec;
use crate::io::share_client::ShareClientError;
use crate::request::outcome_words;
use crate::request::{Amount, Request, Tuning};
use crate::runtime::Driver;
use crate::share::Heard;

/// Factor for the timeout of a command that lists all parameters.
const LIST_TIMES: u32 = 6;

/// A link to the robot that delivers commands.
pub(super) struct Operator {
    driver: Driver,
    _simulator: Embedded,
    timeout: Duration,
}

impl Operator {
    /// Opens the link, or connects to a station that shares one.
    pub(super) fn connect(options: &Calibrate, config: &Config) -> Result<Self, Fault> {
        let way = options
            .connection()
            .map_err(|error| Fault::new(Exit::Usage, error))?;
        let (way, config) = &way.at(config, &options.radio.link)?;
        let radio = options.radio.radio(config);
        let baud = options.radio.link.asked_baud(config);
        let link = way.link();
        if !radio.can_send() || link == LinkSpec::Stdin {
            return Err(receive_only(&link));
        }
        let opened = open(&link, baud, &options.radio.link, radio)?;
        if let (Connection::Via(address), None) = (way, opened.station()) {
            let error = ShareClientError::NoStation(address.clone());
            return Err(Fault::new(Exit::NoLink, error));
        }
        let (driver, simulator) = opened.start(radio);
        if !driver.can_send() {
            return Err(receive_only(&link));
        }
        Ok(Self {
            driver,
            _simulator: simulator,
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
                    self.driver.cancel();
                    let heard = self.driver.heard();
                    return Err(not_confirmed(&request, None, heard, timeout, progress.frames));
                }
            }
        }
    }
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
            CommandStatus::Failed(Failure::TimedOut | Failure::NotSent) => {
                return Err(not_confirmed(request, None, heard, timeout, self.frames));
            }
            CommandStatus::Failed(failure) => return Err(failed(request, *failure)),
            CommandStatus::Queued | CommandStatus::Echoed | CommandStatus::Progress { .. } => {}
        }
        Ok(false)
    }
}
