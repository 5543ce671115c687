//! Stations and dashboards that command through another station: in virtual time, then as processes on ptys.
#![cfg(unix)]

use crate::common::CoSimulation;
use crate::programs::{GROUNDWAVE, Sim, Telling, path_in, scratch};
use crate::pty::OnTerminal;
use crate::sharing::{program_in, station, station_on_a_port};
use groundwave::event::{CommandId, CommandStatus, Event, Failure, LinkEvent, Moment, NoticeCode};
use groundwave::request::Request;
use groundwave::share::{
    Answers, Broker, ClientId, Heard, Output, StationLine, ToClient, ToStation,
};
use groundwave::station::Station;
use groundwave_protocol::arq::Config;
use groundwave_protocol::status_codes::Mode;
use sr04_sim::{Simulation, SimulationConfig, World};

/// A robot with its station, and a second station that commands through it, in virtual time.
struct Pair {
    co: CoSimulation,
    broker: Broker,
    second: Station,
    told: usize,
    statuses: Vec<(Moment, CommandId, CommandStatus)>,
}

const SECOND: ClientId = ClientId(1);

impl Pair {
    fn new() -> Self {
        let mut broker = Broker::new("radio".to_owned(), true);
        broker.handle_connected(SECOND, "pid 7".to_owned());
        let hello = b"{\"groundwave\":1,\"raw\":true}";
        assert_eq!(
            broker.handle_line(Moment::ZERO, SECOND, Ok(hello), &Answers::default()),
            None
        );
        let mut second = Station::new(Config::new(2), true);
        second.handle_shared(Moment::ZERO, true);
        Self {
            co: CoSimulation::new("house", 1, ""),
            broker,
            second,
            told: 0,
            statuses: Vec::new(),
        }
    }

    fn step(&mut self) {
        self.co.step();
        let (now, heard) = (self.co.now(), Heard::default());
        if self.second.poll_timeout().is_some_and(|at| at <= now) {
            self.second.handle_timeout(now);
        }
        while let Some(line) = self.second.poll_shared_line() {
            let line = line.to_line();
            if let Some(asked) =
                self.broker
                    .handle_line(now, SECOND, Ok(&line), &Answers::default())
            {
                let request = asked.ask.request.clone();
                let id = self.co.station.handle_request(now, request, None);
                self.broker.handle_started(now, id, &asked, heard);
            }
        }
        for (_, event) in &self.co.events[self.told..] {
            if let Event::Command { id, status } = event {
                self.broker.handle_status(*id, status, heard);
            }
        }
        self.told = self.co.events.len();
        while let Some(output) = self.broker.poll_output() {
            match output {
                Output::Client(_, ToClient::Line(line)) => {
                    let line = StationLine::parse(&line).unwrap();
                    self.second.handle_shared_line(now, &line);
                }
                Output::Station(ToStation::GiveUp(id, why)) => {
                    self.co.station.handle_give_up(now, id, why);
                }
                Output::Station(ToStation::Drive {
                    velocity_in_s,
                    rotation_in_s,
                }) => {
                    let station = &mut self.co.station;
                    station.handle_drive(now, velocity_in_s, rotation_in_s);
                }
                _ => {}
            }
        }
        while let Some(event) = self.second.poll_event() {
            if let Event::Command { id, status } = event {
                self.statuses.push((now, id, status));
            }
        }
        assert_eq!(self.second.poll_transmit(now), None, "a frame for a share");
    }

    fn request(&mut self, request: Request) -> CommandId {
        let now = self.co.now();
        self.second.handle_request(now, request, None)
    }

    fn run_until(&mut self, limit_s: u64, mut done: impl FnMut(&Self) -> bool) {
        for _ in 0..limit_s * 1000 {
            if done(self) {
                return;
            }
            self.step();
        }
        panic!("not within {limit_s} s: {:?}", self.statuses);
    }

    fn fate(&self, id: CommandId) -> Option<CommandStatus> {
        let mut ends = self
            .statuses
            .iter()
            .filter(|(_, _, status)| status.is_end());
        ends.find(|(_, of, _)| *of == id)
            .map(|(.., status)| *status)
    }
}

const CONFIRMED: CommandStatus = CommandStatus::Confirmed { digest: None };

#[test]
fn second_station_commands_like_the_first() {
    let mut pair = Pair::new();
    let reactive = pair.request(Request::Mode(Mode::Reactive));
    let prowl = pair.request(Request::Mode(Mode::Prowl));
    pair.run_until(20, |pair| pair.fate(prowl).is_some());
    assert_eq!(
        (pair.fate(reactive), pair.fate(prowl)),
        (Some(CONFIRMED), Some(CONFIRMED))
    );
    pair.run_until(20, |pair| pair.co.modes.last() == Some(&Mode::Prowl));
    // STOP overtakes, and ends the command that waits.
    let asked_at = pair.co.now();
    let waits = pair.request(Request::Mode(Mode::Reactive));
    let late = pair.request(Request::Mode(Mode::Prowl));
    let stop = pair.request(Request::Stop);
    pair.run_until(20, |pair| pair.fate(stop).is_some());
    assert_eq!(pair.fate(stop), Some(CONFIRMED));
    let took = pair.co.now().saturating_sub(asked_at);
    assert!(took.as_secs() < 1, "{took:?}");
    for id in [waits, late] {
        let stopped = CommandStatus::Failed(Failure::Stopped);
        pair.run_until(20, |pair| pair.fate(id).is_some());
        assert_eq!(pair.fate(id), Some(stopped));
    }
    pair.run_until(5, |pair| pair.co.modes.last() == Some(&Mode::Stop));
    // Cancelling ends the command at the first station too.
    let route = Request::from_words(&["goto", "48", "0"]).unwrap();
    let cancelled = pair.request(route);
    pair.step();
    let now = pair.co.now();
    pair.second.handle_cancel(now);
    pair.run_until(1, |pair| pair.fate(cancelled).is_some());
    assert_eq!(
        pair.fate(cancelled),
        Some(CommandStatus::Failed(Failure::Cancelled))
    );
    pair.run_until(5, |pair| pair.co.station.is_settled());
}

#[test]
fn second_station_drives_by_hand() {
    let mut pair = Pair::new();
    let user = pair.request(Request::Mode(Mode::User));
    pair.run_until(20, |pair| pair.fate(user) == Some(CONFIRMED));
    let moves = |pair: &Pair| {
        pair.co.events.iter().any(|(_, event)| matches!(event, Event::Line { line, .. }
            if matches!(&line.body, groundwave_protocol::telemetry::Body::State(state) if state.velocity_in_s > 0)))
    };
    for _ in 0..50 {
        let now = pair.co.now();
        pair.second.handle_drive(now, 6, 0);
        for _ in 0..100 {
            pair.step();
        }
    }
    assert!(moves(&pair));
}

/// A STOP that was pressed while the connection was lost is sent on the next one; other commands are not repeated.
#[test]
fn stop_outlives_a_lost_connection_to_the_station() {
    let mut pair = Pair::new();
    let prowl = pair.request(Request::Mode(Mode::Prowl));
    pair.second.handle_shared_lost(Moment::ZERO);
    pair.second.handle_link(
        Moment::ZERO,
        LinkEvent::Lost {
            reason: "gone".to_owned(),
        },
    );
    let stop = pair.request(Request::Stop);
    // The robot must not start to move later, when others may have stopped it.
    let late = pair.request(Request::Mode(Mode::Prowl));
    pair.run_until(5, |pair| pair.fate(late).is_some());
    assert_eq!(
        pair.fate(prowl),
        Some(CommandStatus::Failed(Failure::TimedOut))
    );
    let not_sent = Some(CommandStatus::Failed(Failure::NotSent));
    assert_eq!((pair.fate(stop), pair.fate(late)), (None, not_sent));
    for _ in 0..20_000 {
        pair.step();
    }
    assert_eq!(pair.fate(stop), None);
    let now = pair.co.now();
    pair.second.handle_link(
        now,
        LinkEvent::Opened {
            name: "station".to_owned(),
            can_send: true,
        },
    );
    pair.second.handle_shared(now, true);
    pair.run_until(20, |pair| pair.fate(stop) == Some(CONFIRMED));
    for _ in 0..5000 {
        pair.step();
        assert_eq!(pair.co.simulation.robot().mode(), Mode::Stop);
    }
}

/// A demo that was left and begun again is another robot with the same id and boot counter: its lines tell nothing of the first one's.
#[test]
fn a_robot_behind_another_station_has_lost_no_lines_and_makes_no_mistake() {
    let mut second = Station::new(Config::new(2), true);
    second.handle_shared(Moment::ZERO, true);
    let mut now = Moment::ZERO;
    for life in 0..2 {
        let house = World::built_in("house").unwrap();
        let mut simulation = Simulation::new(&SimulationConfig::new(house, 1));
        for _ in 0..60_000 {
            now += Moment::from_millis(1);
            simulation.step();
            while let Some(byte) = simulation.poll_downlink() {
                second.handle_bytes(now, &[byte]);
            }
        }
        if life == 0 {
            second.handle_shared_lost(now);
            second.handle_link(
                now,
                LinkEvent::Lost {
                    reason: "gone".to_owned(),
                },
            );
            now += Moment::from_secs(20);
            second.handle_other_station();
            second.handle_link(
                now,
                LinkEvent::Opened {
                    name: "station".to_owned(),
                    can_send: true,
                },
            );
            second.handle_shared(now, true);
        }
    }
    assert_eq!(second.counters().lines_lost, 0);
    let events = std::iter::from_fn(|| second.poll_event());
    let mistakes = events.filter_map(|event| match event {
        Event::Notice(notice) if notice.code == NoticeCode::RobotMistake => Some(notice.text),
        _ => None,
    });
    assert_eq!(mistakes.collect::<Vec<_>>(), Vec::<String>::new());
}

/// The address in `shared on ADDRESS` on a screen.
fn shared_address(text: &str) -> Option<String> {
    let (_, address) = text.split_once("shared on ")?;
    address.split_whitespace().next().map(str::to_owned)
}

/// A demo that shares its link, and a second dashboard of it: keys, steps and STOP.
fn command_from_a_second_dashboard(share: &str, prefix: &str) {
    let mut owner = OnTerminal::start(GROUNDWAVE, &["demo", "--share", share], 120, 40);
    let mut address = None;
    owner.wait_for("where it shares", |text| {
        address = shared_address(text);
        address.is_some()
    });
    let link = format!("{prefix}{}", address.unwrap());
    let mut second = OnTerminal::start(GROUNDWAVE, &["watch", &link], 120, 40);
    second.wait_for("lines", |text| {
        text.contains("newest <1 s") && text.contains("STOP")
    });
    second.type_keys(":mode prowl\r");
    second.wait_for("the confirmation", |text| {
        text.contains("mode prowl: confirmed")
    });
    for screen in [&mut owner, &mut second] {
        screen.wait_for("that it prowls", |text| text.contains("PROWL"));
    }
    second.type_keys(" ");
    second.wait_for("the confirmation", |text| text.contains("stop: confirmed"));
    owner.wait_for("that it stands", |text| {
        text.lines().next().unwrap().contains("STOP")
    });
    second.wait_for("the walls that the owner shows", |text| {
        text.contains("walls: simulator's truth")
    });
    let text = second.text();
    assert!(
        !text.contains("LINK LOST") && !text.contains("READ ONLY"),
        "{text}"
    );
    // In the past of a live session too.
    second.type_keys(":mode prowl\r");
    owner.wait_for("that it prowls", |text| {
        text.lines().next().unwrap().contains("PROWL")
    });
    second.type_keys(",");
    second.wait_for("the past", |text| text.contains("PAST"));
    second.type_keys(" ");
    owner.wait_for("that it stands", |text| {
        text.lines().next().unwrap().contains("STOP")
    });
    second.type_keys("G");
    second.wait_for("the present", |text| !text.contains("PAST"));
    owner.type_keys(" ");
    second.wait_for("who stopped it", |text| {
        let asked = text.split_once("stop: asked by the station's operator");
        asked.is_some_and(|(_, after)| after.contains("stop: confirmed"))
    });
    let shown = second.text();
    let name = link.rsplit('/').next().unwrap();
    let both = format!("● demo, house seed 1 via {name} ");
    let robot = "● demo, house seed 1  ";
    let fits = both.len() < 38;
    assert!(
        shown.starts_with(if fits { &both } else { robot }),
        "{shown}"
    );
    owner.type_keys("q");
    assert_eq!(owner.wait(), 0);
    second.wait_for("that the station has gone", |text| {
        text.contains(LinkEvent::STATION_CLOSED) && text.contains("Waits for the station")
    });
    second.type_keys("q");
    assert_eq!(second.wait(), 0);
}

#[test]
fn second_dashboard_commands_over_a_port() {
    command_from_a_second_dashboard("0", "tcp:");
}

#[test]
fn second_dashboard_commands_over_a_socket() {
    let folder = scratch("second");
    command_from_a_second_dashboard(&path_in(&folder, "s"), "unix:");
}

/// A shared link opened as a plain link becomes a client or gets a clear error; no frames are sent into it.
#[test]
fn a_share_is_recognized_by_every_verb() {
    let folder = scratch("recognized");
    let sim = Sim::start(&[]);
    let (mut station, address) = station_on_a_port(&sim.path, &folder);
    let run = |arguments: &[&str], token: Option<&str>| {
        let mut program = program_in(&folder, arguments);
        if let Some(token) = token {
            program.env("GROUNDWAVE_TOKEN", token);
        }
        let output = program.output().unwrap();
        let err = String::from_utf8(output.stderr).unwrap();
        (output.status.code(), err)
    };
    let link = format!("tcp:{address}");
    let sent = run(&["send", &link, "mode", "reactive"], None);
    assert_eq!(sent, (Some(0), String::new()));
    let sent = run(&["send", &link, "stop"], None);
    assert_eq!(sent, (Some(0), String::new()));
    let (code, err) = run(&["send", &link, "stop"], Some("wrong"));
    assert_eq!(code, Some(4), "{err}");
    assert!(err.contains("GROUNDWAVE_TOKEN"), "{err}");
    let (code, err) = run(&["watch", &address, "--headless"], None);
    assert_eq!(code, Some(2), "{err}");
    assert!(err.contains(&format!("did you mean {link}?")), "{err}");
    for watch in [&["watch", &link][..], &["watch", "--via", &address]] {
        let mut second = program_in(&folder, watch);
        second.arg("--headless");
        let mut second = Telling::spawn(second);
        let opened = second.wait_for("the link", |value| value["state"] == "open");
        assert_eq!(opened["can_send"], true);
        second.wait_for("a line", |value| value["event"] == "line");
        assert!(second.said.iter().all(|value| value["state"] != "lost"));
    }
    station.wait_for_new("a line", |value| value["event"] == "line");
    let robot = Sim::start(&["--listen", "127.0.0.1:0"]);
    let (code, err) = run(&["watch", "--via", &robot.path, "--headless"], None);
    assert_eq!(code, Some(4), "{err}");
}

#[test]
fn second_dashboard_of_a_receive_only_station_is_read_only() {
    let folder = scratch("read-only");
    let socket = path_in(&folder, "s");
    let sim = Sim::start(&[]);
    let _station = station(&sim.path, &socket, &["--no-uplink"]);
    let link = format!("unix:{socket}");
    for (columns, rows) in [(80, 24), (120, 40)] {
        let mut second = OnTerminal::start(GROUNDWAVE, &["watch", &link], columns, rows);
        second.wait_for("the banner", |text| {
            let first = text.lines().next().unwrap_or_default();
            first.contains("READ ONLY") && text.contains("q quit")
        });
        let text = second.text();
        assert!(!text.contains("Space STOP"), "{text}");
        second.type_keys(" ");
        second.wait_for("why not", |text| text.contains("receive-only"));
    }
}

#[test]
fn only_the_station_with_the_radio_sends_by_itself() {
    let folder = scratch("advise");
    let socket = path_in(&folder, "s");
    let sim = Sim::start(&[]);
    let arguments = ["watch", &sim.path, "--advise=auto", "--share", &socket];
    let mut first = OnTerminal::start(GROUNDWAVE, &arguments, 120, 40);
    first.wait_for("that it may send", |text| {
        text.contains("AUTO") && text.contains("shared on ")
    });
    let link = format!("unix:{socket}");
    let mut second = OnTerminal::start(GROUNDWAVE, &["watch", &link, "--advise=auto"], 120, 40);
    second.wait_for("why not", |text| {
        text.contains("only the station with the radio may send by itself")
    });
    assert_eq!(second.wait(), 2);
}

/// The connection to the station breaks: a STOP pressed meanwhile reaches the robot afterwards.
#[test]
fn second_dashboard_returns_with_its_station() {
    let folder = scratch("returns");
    let socket = path_in(&folder, "s");
    let sim = Sim::start(&[]);
    let first = station(&sim.path, &socket, &[]);
    let link = format!("unix:{socket}");
    let mut second = OnTerminal::start(GROUNDWAVE, &["watch", &link], 120, 40);
    second.wait_for("lines", |text| text.contains("newest <1 s"));
    drop(first);
    second.wait_for("the loss", |text| text.contains("LINK LOST"));
    second.type_keys(" ");
    let mut again = station(&sim.path, &socket, &[]);
    again.wait_for("STOP", |value| value["status"] == "confirmed");
    second.wait_for("the confirmation", |text| text.contains("stop: confirmed"));
}
