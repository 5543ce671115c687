//! A simulated session of constructed lines, for tests of the model and the screen.

use std::sync::{Arc, LazyLock};

use crossterm::event::{KeyCode, KeyEvent, KeyModifiers};
use groundwave_protocol::decoder::Counters;
use groundwave_protocol::failsafe::Failsafe;
use groundwave_protocol::status_codes::{Layer, LayerMask, LayerState};
use groundwave_protocol::telemetry::{
    Ack, Body, CountersLine, FirmwareVersion, HOLDERS, LayerStates, Line, ListPlace, ParameterLine,
    ParameterName, Printable, StateLine, StatusLine, TextLine,
};

mod any;

pub(crate) use any::{Happening, any_event, any_happening};

use super::keys::Keymap;
use super::{Config, Model, Shown};
use crate::event::{CommandId, CommandStatus, Effect, Event, LinkEvent, Moment};
use crate::figures::{Apart, Comparison, Figures, Listed, Overlaid};
use crate::playback::Playback;
use crate::request::Request;
use crate::statistics::{Damaged, Loss};

/// A model, the time, and the contents of the next lines.
pub(crate) struct Scene {
    pub(crate) model: Model,
    pub(crate) now: Moment,
    pub(crate) state: StateLine,
    pub(crate) status: StatusLine,
    pub(crate) ack: Ack,
    pub(crate) failsafe: Option<Failsafe>,
    pub(crate) counters: Counters,
    sequence: u8,
}

impl Scene {
    /// A prowling robot on an open link, before its first line.
    pub(crate) fn new(config: Config) -> Self {
        let mut scene = Self {
            model: Model::new(config),
            now: Moment::ZERO,
            state: state(),
            status: status(),
            ack: Ack::default(),
            failsafe: None,
            counters: Counters::default(),
            sequence: 0,
        };
        scene.event(Event::Link(LinkEvent::Opened {
            name: "sim".to_owned(),
            can_send: true,
        }));
        scene
    }

    pub(crate) fn event(&mut self, event: Event) -> Vec<Effect> {
        self.model.update(self.now, event)
    }

    /// Shows another moment, or now.
    pub(crate) fn show_moment(&mut self, playback: Option<Playback>) {
        self.model.ui.show_moment(playback);
    }

    pub(crate) fn happen(&mut self, happening: Happening) {
        match happening {
            Happening::Event(event) => {
                self.event(event);
            }
            Happening::Moment(playback) => self.show_moment(playback.map(|playback| *playback)),
        }
    }

    /// Time at which the screen changes without an event.
    pub(crate) fn redraw_at(&self) -> Option<Moment> {
        Shown::from(&self.model).redraw_at(self.now)
    }

    /// Number of unacknowledged alarms.
    pub(crate) fn calling(&self) -> usize {
        let Model { facts, ui } = &self.model;
        facts.alarms.calling(&ui.attended).len()
    }

    pub(crate) fn wait_ms(&mut self, ms: u64) {
        self.now += Moment::from_millis(ms);
    }

    /// Advances time by a third of a second, and receives a line A.
    pub(crate) fn hear(&mut self) {
        self.hear_body(Body::State(self.state));
    }

    /// Receives a line B.
    pub(crate) fn hear_status(&mut self) {
        self.hear_body(Body::Status(self.status));
    }

    pub(crate) fn hear_text(&mut self, text: &str) {
        self.hear_body(Body::Text(TextLine::new(text)));
    }

    pub(crate) fn hear_parameter(&mut self, name: &str, value: i32) {
        self.hear_body(Body::Parameter(ParameterLine {
            place: 1,
            count: 1,
            name: ParameterName::new(name),
            value,
            kept: value,
            least: 0,
            most: value.max(1),
            unit: Printable::new(""),
        }));
    }

    pub(crate) fn hear_ticks(&mut self, uptime_s: u32, ticks_won: [u16; HOLDERS]) {
        self.hear_body(Body::Counters(CountersLine {
            failsafe: self.failsafe,
            ..counters(uptime_s, ticks_won)
        }));
    }

    fn hear_body(&mut self, body: Body) {
        self.hear_line(body);
        self.counters.lines += 1;
        self.counters.bytes += 80;
        self.event(Event::Counters(self.counters));
    }

    /// Receives a line, without the totals that follow it.
    pub(crate) fn hear_line(&mut self, body: Body) -> Vec<Effect> {
        self.wait_ms(333);
        let line = Line {
            sequence: self.sequence,
            body,
            ack: self.ack,
        };
        self.sequence = (self.sequence + 1) % 100;
        let raw = line.encode();
        self.event(Event::Line {
            line: Box::new(line),
            raw,
        })
    }

    /// Loses lines.
    pub(crate) fn lose(&mut self, lines: u8) {
        self.wait_ms(333 * u64::from(lines));
        self.sequence = (self.sequence + lines) % 100;
        self.counters.lines_lost += u64::from(lines);
    }

    /// Drives ahead for a number of lines.
    pub(crate) fn drive(&mut self, lines: usize, in_a_line: f64, turn_deg: i32) {
        for _ in 0..lines {
            let theta = i32::from(self.state.theta_deg) + turn_deg;
            self.state.theta_deg = theta.rem_euclid(360) as u16;
            let (sin, cos) = f64::from(self.state.theta_deg).to_radians().sin_cos();
            self.state.x_tenths_in += (in_a_line * 10.0 * sin).round() as i32;
            self.state.y_tenths_in += (in_a_line * 10.0 * cos).round() as i32;
            self.hear();
        }
    }

    /// Presses and releases keys.
    pub(crate) fn press(&mut self, keys: &[KeyCode]) -> Vec<Effect> {
        let press = |&code: &KeyCode| self.key(KeyEvent::new(code, KeyModifiers::NONE));
        keys.iter().flat_map(press).collect()
    }

    /// Presses the key whose action this key has in the table, so that tests also run with rebound keys.
    fn key(&mut self, key: KeyEvent) -> Vec<Effect> {
        static TABLE: LazyLock<Keymap> = LazyLock::new(Keymap::default);
        let (keys, context) = (&self.model.ui.config.keys, self.model.ui.context());
        let does = TABLE.action(context, key);
        let chosen = if keys.action(context, key) == does {
            None
        } else {
            let mut rows = keys.rows().filter(|row| row.context == context);
            let row = rows.find(|row| Some(row.action) == does);
            row.and_then(|row| row.keys.first()).copied()
        };
        let (code, held) = chosen.unwrap_or((key.code, key.modifiers));
        self.event(Event::Key(KeyEvent::new(code, held)))
    }

    pub(crate) fn type_text(&mut self, text: &str) -> Vec<Effect> {
        let keys: Vec<KeyCode> = text.chars().map(KeyCode::Char).collect();
        self.press(&keys)
    }

    pub(crate) fn ctrl(&mut self, c: char) -> Vec<Effect> {
        self.key(KeyEvent::new(KeyCode::Char(c), KeyModifiers::CONTROL))
    }

    /// Queues a command of the operator.
    pub(crate) fn ask(&mut self, id: u32, request: Request) {
        self.event(Event::Asked {
            id: CommandId(id),
            request,
            by: None,
        });
    }

    /// Gives a command a new status.
    pub(crate) fn status_of(&mut self, id: u32, status: CommandStatus) {
        let id = CommandId(id);
        self.event(Event::Command { id, status });
    }

    /// Queues and sends a command, and gives it a last status.
    pub(crate) fn command(&mut self, id: u32, request: Request, last: CommandStatus) {
        self.ask(id, request);
        self.status_of(id, CommandStatus::Sent { frames: 1 });
        self.status_of(id, last);
    }

    pub(crate) fn layers(&mut self, states: &[(Layer, LayerState)]) {
        for &(layer, state) in states {
            self.state.layers.set(layer, state);
        }
    }
}

pub(crate) fn counters(uptime_s: u32, ticks_won: [u16; HOLDERS]) -> CountersLine {
    CountersLine {
        robot_id: 7,
        uptime_s,
        boots: 4,
        version: FirmwareVersion { major: 1, minor: 0 },
        ticks_won,
        bumps: 2,
        ..CountersLine::default()
    }
}

pub(crate) fn state() -> StateLine {
    let mut layers = LayerStates::OFF;
    for layer in [
        Layer::Bumpers,
        Layer::Infrared,
        Layer::Sonar,
        Layer::DeadReckoning,
    ] {
        layers.set(layer, LayerState::Quiet);
    }
    StateLine {
        velocity_in_s: 10,
        wheel_left_in_s: 10,
        wheel_right_in_s: 10,
        sonar_left_in: Some(87),
        sonar_right_in: Some(120),
        photo_left_pct: Some(61),
        photo_right_pct: Some(48),
        layers,
        ..StateLine::BLANK
    }
}

pub(crate) fn status() -> StatusLine {
    let fitted = [
        Layer::User,
        Layer::Bumpers,
        Layer::Infrared,
        Layer::Sonar,
        Layer::DeadReckoning,
    ]
    .into_iter()
    .fold(LayerMask::NONE, LayerMask::with);
    StatusLine {
        robot_id: 7,
        battery_dv: 124,
        target_in: None,
        list: ListPlace::default(),
        digest: 0,
        max_count: 12,
        photo_left: Some(155),
        photo_right: Some(122),
        fitted,
        allowed: fitted,
        boots: 4,
        odometer_resets: 0,
    }
}

/// A playback paused at the first of three minutes.
pub(crate) fn playback(is_live: bool) -> Playback {
    Playback {
        is_live,
        paused: true,
        speed: 1.0,
        at: Moment::from_mins(1),
        from: Moment::ZERO,
        until: Moment::from_secs(185),
        unix: None,
        line: Some(180),
        read_until: None,
        is_partial: false,
        markers: Vec::new(),
        repeat: None,
        note: None,
        is_looking: false,
    }
}

/// Two runs in a folder.
pub(crate) fn listed() -> Arc<Listed> {
    let [mut first, mut second] = overlaid().comparison.runs.clone();
    first.name = Some("new wheels".to_owned());
    second.void = Some("the cat".to_owned());
    Arc::new(Listed {
        folder: "runs".to_owned(),
        runs: vec![first, second],
        problems: vec!["runs/old.mcap: it ends in the middle".to_owned()],
    })
}

/// Two loops; the second ends farther from its start.
pub(crate) fn overlaid() -> Arc<Overlaid> {
    let round = |side_in: i32, end_in: i32| {
        let east = (0..=side_in).map(|x| (x, 0));
        let north = (0..=side_in).map(move |y| (side_in, y));
        let west = (0..=side_in).rev().map(move |x| (x, side_in));
        let south = (end_in..=side_in).rev().map(|y| (0, y));
        let way = east.chain(north).chain(west).chain(south);
        way.map(|(x, y)| (f64::from(x), f64::from(y)))
            .collect::<Vec<_>>()
    };
    let run = |capture: &str, start: &str, duration_s, closing_error_in| Figures {
        capture: capture.to_owned(),
        start: Some(start.to_owned()),
        name: None,
        void: None,
        marks: 0,
        duration_s,
        distance_in: 200.0,
        closing_error_in: Some(closing_error_in),
        bumps: 2,
        restarts: 0,
        loss: Loss::of(&Counters::default()),
        damaged: Damaged::default(),
        odometer_resets: 0,
    };
    Arc::new(Overlaid {
        comparison: Comparison {
            runs: [
                run("runs/evening.mcap", "2026-11-19T19:02:00Z", 61.5, 3.0),
                run("runs/morning.mcap", "2026-11-20T07:31:45Z", 75.0, 12.0),
            ],
            apart: Some(Apart {
                mean_in: 4.2,
                worst_in: 9.5,
                worst_at_in: (60.0, 60.0),
            }),
        },
        paths: [round(50, 3), round(60, 12)],
        problems: Vec::new(),
    })
}
