//! The broker of a shared link: its clients, their commands and the answers. Sans-IO.
//!
//! The station queues the commands; there, STOP overtakes others. Commands of a disconnected client continue until
//! their timeout.

use std::collections::{BTreeMap, VecDeque};

use groundwave_protocol::telemetry::Body;

use super::answers::Answers;
use super::codec::{Ask, ClientLine, Heard, RequestJson, StationLine, Welcome};
use super::lines::{LINE_MAX, TooLong};
use super::status::StatusJson;
use crate::event::{AlarmAnswer, CommandId, CommandStatus, Failure, Moment, Truth};
use crate::request::{Request, Standing};
use groundwave_captures::words::counted;

/// Maximum number of clients. When all wait for a command, one more may connect, to send STOP.
pub const CLIENTS_MAX: usize = 16;

/// Maximum number of open commands per client, without STOPs.
const ASKS_MAX: usize = 16;

/// The station's own operator, for display.
pub const OPERATOR: &str = "the station's operator";

/// Code of an invalid line.
const NOT_UNDERSTOOD: &str = "not-understood";

/// Number of a connection, from 1; never reused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ClientId(pub u64);

/// An output for the sockets or the station.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Output {
    /// For the socket of this client.
    Client(ClientId, ToClient),
    /// For the station.
    Station(ToStation),
}

/// A request to a client's socket.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ToClient {
    /// Send only lines from now on; raw bytes as lines, if the client wants them.
    Converse {
        /// Whether the client also gets the raw bytes.
        raw: bool,
    },
    /// Send this line.
    Line(Vec<u8>),
    /// Close the socket after its unsent lines.
    Close,
    /// Set whether the client waits for a command and therefore keeps its place.
    Busy(bool),
    /// The client waits for a STOP.
    Stopping,
}

/// A request to the station.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ToStation {
    /// End a command for a reason.
    GiveUp(CommandId, Failure),
    /// Drive by hand for half a second; zeros stop the robot.
    Drive {
        /// Forward speed, in/s.
        velocity_in_s: i8,
        /// Speed of the left wheel minus that of the right wheel, in/s.
        rotation_in_s: i8,
    },
    /// Take an operator's answer to an alarm.
    Answered(AlarmAnswer),
    /// Log a client's mistake.
    Warning(String),
}

/// A command for the station, and its client.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Asked {
    /// Number of the client.
    pub client: ClientId,
    /// Name of the client, for display.
    pub by: String,
    /// The command.
    pub ask: Ask,
}

#[derive(Debug)]
struct Client {
    peer: String,
    /// Whether the client has sent hello and gets JSON lines.
    converses: bool,
    /// Number of open commands, without STOPs, which continue without their client.
    asks: usize,
}

impl Client {
    fn asked(&self, client: ClientId, ask: Ask) -> Asked {
        Asked {
            client,
            by: self.peer.clone(),
            ask,
        }
    }
}

#[derive(Debug)]
struct Command {
    client: ClientId,
    tag: u32,
    request: Request,
    deadline: Moment,
    heard_before: Heard,
}

/// Clients and their commands.
#[derive(Debug, Default)]
pub struct Broker {
    link: String,
    can_send: bool,
    runs_alarm_hook: bool,
    /// The world of a simulated robot, for the clients' maps.
    truth: Option<Truth>,
    /// Time at which the station began, ms since 1970.
    began_ms: Option<u64>,
    robot: Standing,
    clients: BTreeMap<ClientId, Client>,
    commands: BTreeMap<CommandId, Command>,
    /// Open commands: the client that gave it, if one did, and the line that all others got.
    announced: BTreeMap<CommandId, (Option<ClientId>, StationLine)>,
    outputs: VecDeque<Output>,
}

impl Broker {
    /// A broker for the link with this name.
    #[must_use]
    pub fn new(link: String, can_send: bool) -> Self {
        Self {
            link,
            can_send,
            ..Self::default()
        }
    }

    /// Takes the world of a simulated robot, for every later client. A world too large for a line is omitted.
    pub fn handle_truth(&mut self, truth: Truth) {
        let length = serde_json::to_vec(&truth).map_or(usize::MAX, |json| json.len());
        self.truth = (length <= LINE_MAX / 2).then_some(truth);
    }

    /// Sets the time at which the station began, ms since 1970.
    pub const fn set_began(&mut self, began_ms: u64) {
        self.began_ms = Some(began_ms);
    }

    /// Sets whether the station, or the one before it, runs the operator's command for alarms, so that its clients do not run theirs.
    pub const fn set_runs_alarm_hook(&mut self, runs: bool) {
        self.runs_alarm_hook = runs;
    }

    /// Adds a client.
    pub fn handle_connected(&mut self, client: ClientId, peer: String) {
        self.clients.insert(
            client,
            Client {
                peer,
                converses: false,
                asks: 0,
            },
        );
    }

    /// Removes a client; its commands continue.
    pub fn handle_gone(&mut self, client: ClientId) {
        self.clients.remove(&client);
    }

    /// Removes a client that was closed because it did not read its raw bytes.
    pub fn handle_too_slow(&mut self, client: ClientId, unread_bytes: usize) {
        if let Some(gone) = self.clients.remove(&client) {
            self.tell_station(ToStation::Warning(format!(
                "{} stopped reading and was cut off, {} unread",
                gone.peer,
                counted(unread_bytes as u64, "byte")
            )));
        }
    }

    /// Removes an idle client that was closed to admit another.
    pub fn handle_gave_way(&mut self, client: ClientId) {
        if let Some(gone) = self.clients.remove(&client) {
            self.tell_station(ToStation::Warning(format!(
                "{} was cut off to make room for another program",
                gone.peer
            )));
        }
    }

    /// Takes a line, with the answers to the station's alarms. Returns a command for the station; pass its number to [`Broker::handle_started`].
    pub fn handle_line(
        &mut self,
        now: Moment,
        client: ClientId,
        line: Result<&[u8], TooLong>,
        answers: &Answers,
    ) -> Option<Asked> {
        let busy = self.clients.values().filter(|client| client.asks > 0);
        let is_full = busy.count() >= CLIENTS_MAX;
        let known = self.clients.get_mut(&client)?;
        let parsed = line
            .map_err(|error| (NOT_UNDERSTOOD, error.to_string()))
            .and_then(|line| {
                ClientLine::parse(line).map_err(|error| (error.code(), error.to_string()))
            });
        let (code, problem) = match parsed {
            Ok(ClientLine::Hello { pid, raw }) if !known.converses => {
                known.converses = true;
                // The process number from the system takes precedence over the client's own.
                if let Some(pid) = pid.filter(|_| !known.peer.starts_with("pid ")) {
                    known.peer = format!("pid {pid} from {}", known.peer);
                }
                self.tell_client(client, ToClient::Converse { raw });
                let mut welcome = Welcome::new(self.link.clone(), self.can_send);
                welcome.runs_alarm_hook = self.runs_alarm_hook;
                welcome.answers = answers.all(now);
                welcome.truth.clone_from(&self.truth);
                welcome.began_ms = self.began_ms;
                self.reply(client, &StationLine::Welcome(welcome));
                let open: Vec<StationLine> = self
                    .announced
                    .values()
                    .map(|(_, asked)| asked.clone())
                    .collect();
                for asked in open {
                    self.reply(client, &asked);
                }
                return None;
            }
            Ok(ClientLine::Hello { .. }) => (NOT_UNDERSTOOD, "hello was sent already".to_owned()),
            Ok(_) if !known.converses => {
                let problem = "begin with {\"groundwave\":1}";
                (NOT_UNDERSTOOD, problem.to_owned())
            }
            Ok(ClientLine::Cancel(tag)) => {
                let mut commands = self.commands.iter();
                let meant = |command: &Command| command.client == client && command.tag == tag;
                // The command may have ended meanwhile.
                if let Some((&id, _)) = commands.find(|(_, command)| meant(command)) {
                    self.tell_station(ToStation::GiveUp(id, Failure::Cancelled));
                }
                return None;
            }
            Ok(ClientLine::Drive {
                velocity_in_s,
                rotation_in_s,
            }) => {
                self.tell_station(ToStation::Drive {
                    velocity_in_s,
                    rotation_in_s,
                });
                return None;
            }
            Ok(ClientLine::Answer { alarm, answer }) if answers.has(now, &alarm, answer) => {
                return None;
            }
            Ok(ClientLine::Answer { alarm, answer }) => {
                let by = known.peer.clone();
                let answered = AlarmAnswer { alarm, answer, by };
                self.handle_answer(Some(client), &answered);
                self.tell_station(ToStation::Answered(answered));
                return None;
            }
            // STOP is exempt from the limits.
            Ok(ClientLine::Ask(ask)) if ask.request == Request::Stop => {
                let asked = known.asked(client, ask);
                self.tell_client(client, ToClient::Stopping);
                return Some(asked);
            }
            Ok(ClientLine::Ask(_)) if known.asks == ASKS_MAX => {
                ("busy", format!("{ASKS_MAX} commands are already waiting"))
            }
            Ok(ClientLine::Ask(_)) if known.asks == 0 && is_full => {
                let problem = format!(
                    "{CLIENTS_MAX} programs wait for their commands; only `stop` is taken now, try again later"
                );
                ("full", problem)
            }
            Ok(ClientLine::Ask(ask)) => {
                known.asks += 1;
                let is_first = known.asks == 1;
                let asked = known.asked(client, ask);
                if is_first {
                    self.tell_client(client, ToClient::Busy(true));
                }
                return Some(asked);
            }
            Err(problem) => problem,
        };
        let peer = known.peer.clone();
        self.reply(client, &StationLine::error(code, problem));
        self.tell_client(client, ToClient::Close);
        self.clients.remove(&client);
        let why = match code {
            NOT_UNDERSTOOD => "it sent an invalid line",
            _ => "it was refused",
        };
        self.tell_station(ToStation::Warning(format!("{peer} was closed: {why}")));
        None
    }

    /// Takes the number that the station gave a command.
    pub fn handle_started(&mut self, now: Moment, id: CommandId, asked: &Asked, heard: Heard) {
        self.commands.insert(
            id,
            Command {
                client: asked.client,
                tag: asked.ask.tag,
                request: asked.ask.request.clone(),
                deadline: now + asked.ask.timeout,
                heard_before: heard,
            },
        );
    }

    /// Takes a command that the station queued, from a client or by `by`; `None` is the station's operator. Passes it to all clients but the one that gave it.
    pub fn handle_asked(
        &mut self,
        id: CommandId,
        request: &Request,
        by: Option<&str>,
        heard: Heard,
    ) {
        let line = StationLine::Asked {
            command: id.0,
            by: by.unwrap_or(OPERATOR).to_owned(),
            request: RequestJson::from(request),
        };
        let client = self.commands.get(&id).map(|command| command.client);
        self.send_all_but(client, &line);
        self.announced.insert(id, (client, line));
        self.reply_status(id, &CommandStatus::Queued, heard);
    }

    /// Passes a command's new status to its client and to all others.
    pub fn handle_status(&mut self, id: CommandId, status: &CommandStatus, heard: Heard) {
        if let Some(&(client, _)) = self.announced.get(&id) {
            let line = StationLine::Command {
                command: id.0,
                status: StatusJson::from(status),
            };
            self.send_all_but(client, &line);
        }
        if status.is_end() {
            self.announced.remove(&id);
        }
        self.reply_status(id, status, heard);
    }

    fn reply_status(&mut self, id: CommandId, status: &CommandStatus, heard: Heard) {
        let Some(command) = self.commands.get(&id) else {
            return;
        };
        let mut json = StatusJson::from(status);
        if let CommandStatus::Refused(outcome) = status
            && let Some(why) = self.robot.why(&command.request, *outcome)
        {
            json.text = Some(why);
        }
        let line = StationLine::Status {
            id: command.tag,
            status: json,
            heard: heard.since(command.heard_before),
        };
        self.reply(command.client, &line);
        if status.is_end() {
            self.forget(id);
        }
    }

    /// Takes an operator's answer to an alarm; all clients but the one that gave it are told.
    pub fn handle_answer(&mut self, by: Option<ClientId>, answered: &AlarmAnswer) {
        self.send_all_but(by, &StationLine::Answered(answered.clone()));
    }

    /// Takes the body of a line; a text is sent to all clients.
    pub fn handle_body(&mut self, body: &Body) {
        self.robot.take(body);
        if let Body::Text(text) = body {
            let said = text.as_str().to_owned();
            self.send_all_but(None, &StationLine::Said { said });
        }
    }

    /// Passes to all clients what the station before this one tells of its link and its operator.
    pub fn pass_on(&mut self, line: &StationLine) {
        if let StationLine::Lost { .. } | StationLine::Answered(_) = line {
            self.send_all_but(None, line);
        }
    }

    /// Reports a lost link to all clients.
    pub fn handle_lost(&mut self, reason: &str) {
        let lost = reason.to_owned();
        self.send_all_but(None, &StationLine::Lost { lost });
    }

    fn send_all_but(&mut self, except: Option<ClientId>, line: &StationLine) {
        let conversing: Vec<ClientId> = self
            .clients
            .iter()
            .filter(|(id, client)| client.converses && Some(**id) != except)
            .map(|(id, _)| *id)
            .collect();
        for client in conversing {
            self.reply(client, line);
        }
    }

    /// Ends commands whose timeout has passed.
    pub fn handle_timeout(&mut self, now: Moment, heard: Heard) {
        let over: Vec<CommandId> = self
            .commands
            .iter()
            .filter(|(_, command)| command.deadline <= now)
            .map(|(id, _)| *id)
            .collect();
        for id in over {
            // All others hear of its end from the station.
            self.reply_status(id, &CommandStatus::Failed(Failure::TimedOut), heard);
            self.tell_station(ToStation::GiveUp(id, Failure::TimedOut));
        }
    }

    /// Latest time for the next call of [`Broker::handle_timeout`].
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Moment> {
        self.commands.values().map(|command| command.deadline).min()
    }

    /// The next output.
    pub fn poll_output(&mut self) -> Option<Output> {
        self.outputs.pop_front()
    }

    fn tell_client(&mut self, client: ClientId, output: ToClient) {
        self.outputs.push_back(Output::Client(client, output));
    }

    fn tell_station(&mut self, output: ToStation) {
        self.outputs.push_back(Output::Station(output));
    }

    fn reply(&mut self, client: ClientId, line: &StationLine) {
        if self.clients.contains_key(&client) {
            self.tell_client(client, ToClient::Line(line.to_line()));
        }
    }

    fn forget(&mut self, id: CommandId) {
        if let Some(command) = self.commands.remove(&id)
            && command.request != Request::Stop
            && let Some(client) = self.clients.get_mut(&command.client)
        {
            client.asks -= 1;
            if client.asks == 0 {
                self.tell_client(command.client, ToClient::Busy(false));
            }
        }
    }
}

#[cfg(test)]
mod tests;
