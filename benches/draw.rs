//! Cost of drawing: a whole screen from the model, and through `Terminal` to the terminal's bytes.
//!
//! `cargo bench --bench draw`

use std::io;
use std::time::Duration;

use divan::Bencher;
use groundwave::event::{Event, LinkEvent};
use groundwave::model::{Config, Model};
use groundwave::station::Station;
use groundwave::view;
use groundwave_protocol::arq;
use ratatui::backend::CrosstermBackend;
use ratatui::layout::Rect;
use ratatui::{Terminal, TerminalOptions, Viewport};
use sr04_sim::{Simulation, SimulationConfig, World};

fn main() {
    divan::main();
}

/// A dashboard after a minute in the house, to which further lines are added.
struct Watched {
    simulation: Simulation,
    station: Station,
    model: Model,
}

impl Watched {
    fn new(width: u16, height: u16) -> Self {
        let world = World::built_in("house").expect("it comes with the simulator");
        let mut model = Model::new(Config::default());
        model.update(Duration::ZERO, Event::Resize { width, height });
        let mut station = Station::new(arq::Config::new(1), true);
        station.handle_link(
            Duration::ZERO,
            LinkEvent::Opened {
                name: "bench".to_owned(),
                can_send: true,
            },
        );
        let mut watched = Self {
            simulation: Simulation::new(&SimulationConfig::new(world, 1)),
            station,
            model,
        };
        for _ in 0..180 {
            watched.next_line();
        }
        watched
    }

    fn now(&self) -> Duration {
        Duration::from_millis(self.simulation.now_ms())
    }

    /// Runs the simulation until the model has taken another line.
    fn next_line(&mut self) {
        loop {
            self.simulation.step();
            let now = self.now();
            while let Some(byte) = self.simulation.poll_downlink() {
                self.station.handle_bytes(now, &[byte]);
            }
            let mut took = false;
            while let Some(event) = self.station.poll_event() {
                took |= matches!(event, Event::Line { .. });
                self.model.update(now, event);
            }
            if took {
                return;
            }
        }
    }
}

#[divan::bench(args = [(80, 24), (120, 40), (200, 60)])]
fn a_page_after_a_new_line(bencher: Bencher, (width, height): (u16, u16)) {
    let mut watched = Watched::new(width, height);
    let options = TerminalOptions {
        viewport: Viewport::Fixed(Rect::new(0, 0, width, height)),
    };
    let backend = CrosstermBackend::new(io::sink());
    let mut terminal = Terminal::with_options(backend, options).expect("a sink");
    bencher.bench_local(|| {
        let now = watched.now();
        let drawn = terminal.draw(|frame| view::draw(&watched.model, now, frame.buffer_mut()));
        drawn.expect("a sink takes it");
        watched.next_line();
    });
}

/// Cost of simulating and decoding alone, to be subtracted from the other figures.
#[divan::bench]
fn a_new_line_without_a_frame(bencher: Bencher) {
    let mut watched = Watched::new(120, 40);
    bencher.bench_local(|| watched.next_line());
}
