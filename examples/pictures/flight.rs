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
use sr04_sim::{Simulation, SimulationConfig, World};

/// A robot in the house, its station and its dashboard.
pub struct Flight {
    simulation: Simulation,
    station: Station,
    model: Model,
    now: Duration,
    size: (u16, u16),
}

#[allow(dead_code, reason = "each picture uses its own part")]
impl Flight {
    /// Starts the demo on a screen of `size` columns and rows.
    pub fn begin(seed: u64, size: (u16, u16)) -> Result<Self, Box<dyn Error>> {
        let world = World::built_in("house").ok_or("the house comes with the simulator")?;
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
        flight.station.handle_link(LinkEvent::Opened {
            name: format!("demo, house seed {seed}"),
            can_send: true,
        });
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
    pub fn send_route(&mut self, points: &[(i16, i16)]) {
        let point = |&(x_in, y_in): &(i16, i16)| Waypoint { x_in, y_in };
        let route = Request::Route(points.iter().map(point).collect());
        self.station.handle_request(self.now, route, None);
        self.settle();
    }

    /// Presses keys, one after the other.
    pub fn press(&mut self, keys: &str) {
        for c in keys.chars() {
            let code = if c == '\n' {
                KeyCode::Enter
            } else {
                KeyCode::Char(c)
            };
            self.tell(Event::Key(KeyEvent::new(code, KeyModifiers::NONE)));
        }
    }

    /// The screen as it is now.
    pub fn screen(&self) -> Result<Buffer, Box<dyn Error>> {
        let (width, height) = self.size;
        let mut terminal = Terminal::new(TestBackend::new(width, height))?;
        terminal.draw(|frame| view::draw(&self.model, self.now, frame.buffer_mut()))?;
        Ok(terminal.backend().buffer().clone())
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
