//! The command ledger on the screen, compared with the simulated robot: each row's claim about the robot is true at
//! every moment at which the row may change.

use crate::common::{CoSimulation, Rng, on_all_cores, seeds};
use crossterm::event::{KeyCode, KeyEvent, KeyModifiers};
use groundwave::event::{CommandId, CommandStatus, Effect, Event, LinkEvent};
use groundwave::model::{Config, Model};
use groundwave::request::Request;
use groundwave::view;
use groundwave_protocol::Waypoint;
use groundwave_protocol::digest::digest;
use groundwave_protocol::status_codes::{Layer, LayerMask, Mode};
use groundwave_protocol::telemetry::Body;
use ratatui::Terminal;
use ratatui::backend::TestBackend;

const SEEDS: u64 = 20;

const SIZE: (u16, u16) = (160, 50);

/// A robot, a station and the operator's screen.
struct Watched {
    co: CoSimulation,
    model: Model,
    taken: usize,
    terminal: Terminal<TestBackend>,
    /// Maximum number of driven waypoints claimed by a row.
    driven_claimed: u16,
    active_claimed: bool,
    /// The lists sent, in order, with their lengths, by which the screen distinguishes them, and their digests.
    lists: Vec<(CommandId, usize, u32)>,
}

impl Watched {
    fn new(seed: u64, channel: &str) -> Self {
        let mut model = Model::new(Config::default());
        let (width, height) = SIZE;
        let link = LinkEvent::Opened {
            name: "radio".to_owned(),
            can_send: true,
        };
        let co = CoSimulation::new("open-room", seed, channel);
        for event in [Event::Resize { width, height }, Event::Link(link)] {
            model.update(co.now(), event);
        }
        Self {
            co,
            model,
            taken: 0,
            terminal: Terminal::new(TestBackend::new(width, height)).expect("a buffer"),
            driven_claimed: 0,
            active_claimed: false,
            lists: Vec::new(),
        }
    }

    fn send_list(&mut self, waypoints: Vec<Waypoint>) -> CommandId {
        let (length, digest) = (waypoints.len(), digest(waypoints.iter()));
        let id = self.co.request(Request::Route(waypoints));
        self.lists.push((id, length, digest));
        id
    }

    /// Whether the screen may claim that the robot has this list: the robot has it, or the next list is not yet confirmed.
    fn may_be_active(&self, claimed: usize) -> bool {
        let held = self.co.simulation.robot().lists().active_digest();
        let lists = || self.lists.iter();
        let (Some(claimed), Some(held)) = (
            lists().position(|(_, length, _)| *length == claimed),
            lists().position(|(_, _, digest)| *digest == held),
        ) else {
            return false;
        };
        let (successor, ..) = self.lists[held];
        let confirmed = self.co.events[..self.taken].iter().any(|(_, event)| {
            matches!(event, Event::Command { id, status: CommandStatus::Confirmed { .. } } if *id == successor)
        });
        claimed == held || (claimed + 1 == held && !confirmed)
    }

    fn step(&mut self) {
        self.co.step();
        while let Some((at, event)) = self.co.events.get(self.taken).cloned() {
            self.taken += 1;
            // Rows change with the status of a command and with line B.
            let may_claim = match &event {
                Event::Command { .. } => true,
                Event::Line { line, .. } => matches!(line.body, Body::Status(_)),
                _ => false,
            };
            self.model.update(at, event);
            if may_claim {
                self.judge();
            }
        }
    }

    fn run_until(&mut self, what: &str, limit_s: u64, mut done: impl FnMut(&Self) -> bool) {
        for _ in 0..limit_s * 1000 {
            if done(self) {
                return;
            }
            self.step();
        }
        panic!("not within {limit_s} s: {what}; {}", self.co.context());
    }

    fn rows(&mut self) -> Vec<String> {
        let now = self.co.now();
        self.terminal
            .draw(|frame| view::draw(&self.model, now, frame.buffer_mut()))
            .expect("a buffer takes it");
        let cells = self.terminal.backend().buffer().content();
        cells
            .chunks(usize::from(SIZE.0))
            .map(|row| row.iter().map(ratatui::buffer::Cell::symbol).collect())
            .collect()
    }

    /// Compares the claims of the screen with the robot.
    fn judge(&mut self) {
        let rows = self.rows();
        let context = self.co.context();
        let robot = self.co.simulation.robot();
        let mut active_rows = 0;
        for row in &rows {
            let Some((place, length)) = route_claim(row) else {
                continue;
            };
            active_rows += 1;
            let held = robot.lists().active_digest();
            assert!(
                self.may_be_active(length),
                "{row}\nthe robot holds {held:08X}; {context}"
            );
            if let Some((driven, count)) = place {
                let driven: u16 = driven.parse().expect("a number");
                let held = robot.lists().active().len();
                assert!(
                    driven <= robot.driven() && count == held.to_string(),
                    "{row}\nthe robot has driven {} of {held}; {context}",
                    robot.driven()
                );
                self.driven_claimed = self.driven_claimed.max(driven);
            }
        }
        assert!(active_rows <= 1, "{}\n{context}", rows.join("\n"));
        self.active_claimed = active_rows == 1;
    }
}

/// The place in a route and the length of the route that a row of the commands claims to be the robot's.
fn route_claim(row: &str) -> Option<(Option<(&str, &str)>, usize)> {
    let (number, route) = row.split_once(" route of ")?;
    let _: u32 = number.trim().parse().ok()?;
    let mut words = route.split_whitespace();
    let length = words.next()?.parse().ok()?;
    match words.nth(1)? {
        "confirmed" => Some((None, length)),
        "driving" | "driven" | "done" => {
            let place = words.next()?.trim_end_matches('.');
            Some((place.split_once('/'), length))
        }
        _ => None,
    }
}

fn route(rng: &mut Rng, length: usize) -> Vec<Waypoint> {
    let mut part = || rng.below(41) as i16 - 20;
    (0..length)
        .map(|_| Waypoint {
            x_in: part(),
            y_in: part(),
        })
        .collect()
}

#[test]
fn no_row_says_more_than_is_so_at_the_robot() {
    on_all_cores(seeds(SEEDS), |seed| {
        let channel = if seed % 2 == 0 { "" } else { "ber=1e-3" };
        let mut watched = Watched::new(seed, channel);
        let mut rng = Rng(seed);
        for length in [6, 7] {
            let route = route(&mut rng, length);
            let id = watched.send_list(route);
            watched.run_until("the list is active", 120, |watched| {
                matches!(watched.co.fate(id), Some(CommandStatus::Confirmed { .. }))
                    && watched.active_claimed
            });
        }
        let prowl = watched.co.request(Request::Mode(Mode::Prowl));
        watched.run_until(
            "the screen says that some of it is driven",
            240,
            |watched| watched.driven_claimed >= 3,
        );
        assert!(matches!(
            watched.co.fate(prowl),
            Some(CommandStatus::Confirmed { .. })
        ));
        // The robot has no list after a reboot; the screen shows none after the first line of the new life.
        watched.co.simulation.reboot();
        let heard = watched.taken;
        watched.run_until("a line of the new life", 30, |watched| {
            watched.co.events[heard..watched.taken]
                .iter()
                .any(|(_, event)| matches!(event, Event::Line { .. } | Event::Ack(_)))
        });
        let rows = watched.rows();
        let claims: Vec<_> = rows.iter().filter_map(|row| route_claim(row)).collect();
        assert_eq!(claims, [], "{}", watched.co.context());
        assert!(
            rows.concat().contains("the robot restarted"),
            "{}",
            watched.co.context()
        );
    });
}

/// `4`, a second, `4`: forbidden, then allowed again, however late and noisy the radio is.
#[test]
fn a_layer_key_pressed_twice_forbids_and_allows_again() {
    let sonar = LayerMask::NONE.with(Layer::Sonar);
    let channels = ["", "delay=400ms", "delay=1500ms", "ber=1e-3"];
    on_all_cores(seeds(2 * SEEDS), |seed| {
        let channel = channels[seed as usize % channels.len()];
        let mut watched = Watched::new(seed, channel);
        watched.run_until("a line B", 60, |watched| watched.co.allowed.is_some());
        let before_ms = 37 * seed;
        let mut fates = Vec::new();
        for (wait_ms, expected) in [
            (before_ms, Request::Disable(sonar)),
            (1000, Request::Enable(sonar)),
        ] {
            (0..wait_ms).for_each(|_| watched.step());
            let key = KeyEvent::new(KeyCode::Char('4'), KeyModifiers::NONE);
            let effects = watched.model.update(watched.co.now(), Event::Key(key));
            assert_eq!(
                effects,
                [Effect::Send(expected.clone())],
                "{}",
                watched.co.context()
            );
            fates.push(watched.co.request(expected));
        }
        watched.run_until("both ended", 120, |watched| {
            fates.iter().all(|id| watched.co.fate(*id).is_some())
        });
        let allowed = watched.co.simulation.robot().allowed();
        assert!(allowed.contains(Layer::Sonar), "{}", watched.co.context());
    });
}
