//! The demo in virtual time: the same seed gives the same picture.

use std::error::Error;
use std::time::Duration;

use crossterm::event::{KeyCode, KeyEvent, KeyModifiers};
use groundwave::commands::simulated::truth;
use groundwave::event::{Effect, Event, LinkEvent};
use groundwave::model::{Config, Model};
use groundwave::request::Request;
use groundwave::station::Station;
use groundwave::view;
use groundwave_protocol::{Waypoint, arq};
use ratatui::Terminal;
use ratatui::backend::TestBackend;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use sr04_sim::{Simulation, SimulationConfig, World};

/// A robot in the house, its station and its dashboard.
pub struct Flight {
    simulation: Simulation,
    station: Station,
    model: Model,
    now: Duration,
    size: (u16, u16),
}

impl Flight {
    /// Starts the demo on a screen of `size` columns and rows.
    pub fn begin(name: &str, seed: u64, size: (u16, u16)) -> Result<Self, Box<dyn Error>> {
        let world = World::built_in(name).ok_or_else(|| format!("no built-in world `{name}`"))?;
        let mut flight = Self {
            simulation: Simulation::new(&SimulationConfig::new(world, seed)),
            station: Station::new(arq::Config::new(1), true),
            model: Model::new(Config {
                raw_copy: Some("cat /dev/pts/3".to_owned()),
                ..Config::default()
            }),
            now: Duration::ZERO,
            size,
        };
        let (width, height) = size;
        flight.tell(Event::Resize { width, height });
        flight.tell(Event::Truth(truth(flight.simulation.outlines())));
        let opened = LinkEvent::Opened {
            name: format!("demo, {name} seed {seed}"),
            can_send: true,
        };
        flight.station.handle_link(Duration::ZERO, opened);
        Ok(flight)
    }

    /// Runs until `end_s` seconds after the start.
    pub fn fly_to(&mut self, end_s: f64) {
        let end = Duration::from_secs_f64(end_s);
        while self.now < end {
            self.simulation.step();
            self.now = Duration::from_millis(self.simulation.now_ms());
            while let Some(byte) = self.simulation.poll_downlink() {
                self.station.handle_bytes(self.now, &[byte]);
            }
            self.station.handle_timeout(self.now);
            self.settle();
        }
    }

    /// Sends a waypoint list.
    pub fn send_route(&mut self, points: Vec<Waypoint>) {
        let route = Request::Route(points);
        self.station.handle_request(self.now, route, None);
        self.settle();
    }

    /// Presses a key.
    pub fn press(&mut self, key: KeyCode) {
        self.tell(Event::Key(KeyEvent::new(key, KeyModifiers::NONE)));
    }

    /// The current screen, with a caption in a separate row below.
    pub fn screen(&self, caption: Option<&str>) -> Result<Buffer, Box<dyn Error>> {
        let (width, height) = self.size;
        let mut terminal = Terminal::new(TestBackend::new(width, height))?;
        terminal.draw(|frame| view::draw(&self.model, self.now, frame.buffer_mut()))?;
        let mut screen = terminal.backend().buffer().clone();
        if let Some(caption) = caption {
            screen.resize(Rect::new(0, 0, width, height + 2));
            let left = width.saturating_sub(caption.chars().count() as u16) / 2;
            let bold = Style::new().add_modifier(Modifier::BOLD);
            screen.set_stringn(left, height + 1, caption, width.into(), bold);
        }
        Ok(screen)
    }

    fn settle(&mut self) {
        while let Some(bytes) = self.station.poll_transmit(self.now) {
            self.simulation.handle_uplink(&bytes);
        }
        while let Some(event) = self.station.poll_event() {
            self.tell(event);
        }
    }

    fn tell(&mut self, event: Event) {
        for effect in self.model.update(self.now, event) {
            if let Effect::Send(request) = effect {
                self.station.handle_request(self.now, request, None);
                self.settle();
            }
        }
    }
}
