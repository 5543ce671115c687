//! Remakes the README's picture: a minute of the demo in virtual time, its screen as SVG.
//!
//! `cargo run --release --example screenshot > docs/dashboard.svg`

use std::fmt::Write as _;
use std::time::Duration;

use groundwave::commands::simulated::truth;
use groundwave::event::{Event, LinkEvent};
use groundwave::model::{Config, Model};
use groundwave::request::Request;
use groundwave::station::Station;
use groundwave::view;
use groundwave_protocol::Waypoint;
use groundwave_protocol::arq;
use ratatui::Terminal;
use ratatui::backend::TestBackend;
use ratatui::buffer::Buffer;
use ratatui::style::{Color, Modifier};
use sr04_sim::{Simulation, SimulationConfig, World};

const COLUMNS: u16 = 120;
const ROWS: u16 = 40;
const CELL_WIDTH: f64 = 8.4;
const CELL_HEIGHT: f64 = 17.0;
const BACKGROUND: &str = "#14171c";
const FOREGROUND: &str = "#c8ccd4";

/// When the route is sent and when the picture is taken, virtual seconds.
const ROUTE_AT_S: u64 = 18;
const PICTURE_AT_S: u64 = 40;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let world = World::built_in("house").ok_or("the house comes with the simulator")?;
    let mut simulation = Simulation::new(&SimulationConfig::new(world, 1));
    let mut station = Station::new(arq::Config::new(1), true);
    let mut model = Model::new(Config {
        raw_copy: Some("cat /dev/pts/3".to_owned()),
        silent: false,
        ..Config::default()
    });
    let size = Event::Resize {
        width: COLUMNS,
        height: ROWS,
    };
    model.update(Duration::ZERO, size);
    model.update(Duration::ZERO, Event::Truth(truth(simulation.outlines())));
    station.handle_link(LinkEvent::Opened {
        name: "demo, house seed 1".to_owned(),
        can_send: true,
    });
    let mut now = Duration::ZERO;
    while now < Duration::from_secs(PICTURE_AT_S) {
        simulation.step();
        now = Duration::from_millis(simulation.now_ms());
        if now == Duration::from_secs(ROUTE_AT_S) {
            station.handle_request(now, Request::Route(route()));
        }
        while let Some(byte) = simulation.poll_downlink() {
            station.handle_bytes(now, &[byte]);
        }
        station.handle_timeout(now);
        while let Some(bytes) = station.poll_transmit(now) {
            simulation.handle_uplink(&bytes);
        }
        while let Some(event) = station.poll_event() {
            model.update(now, event);
        }
    }
    let mut terminal = Terminal::new(TestBackend::new(COLUMNS, ROWS))?;
    terminal.draw(|frame| view::draw(&model, now, frame))?;
    print!("{}", svg(terminal.backend().buffer()));
    Ok(())
}

fn route() -> Vec<Waypoint> {
    [(-40, 30), (-90, 50), (-60, 100), (0, 0)]
        .map(|(x_in, y_in)| Waypoint { x_in, y_in })
        .to_vec()
}

fn svg(buffer: &Buffer) -> String {
    let (width, height) = (
        f64::from(COLUMNS) * CELL_WIDTH,
        f64::from(ROWS) * CELL_HEIGHT,
    );
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"-12 -10 {:.0} {:.0}\" font-family=\"'DejaVu Sans Mono', Menlo, Consolas, monospace\" font-size=\"14\">\n<rect x=\"-12\" y=\"-10\" width=\"100%\" height=\"100%\" rx=\"8\" fill=\"{BACKGROUND}\"/>\n",
        width + 24.0,
        height + 20.0
    );
    for row in 0..ROWS {
        for column in 0..COLUMNS {
            let cell = &buffer[(column, row)];
            let (x, y) = (f64::from(column) * CELL_WIDTH, f64::from(row) * CELL_HEIGHT);
            let (mut ink, mut paper) = (color(cell.fg, FOREGROUND), color(cell.bg, BACKGROUND));
            if cell.modifier.contains(Modifier::REVERSED) {
                std::mem::swap(&mut ink, &mut paper);
            }
            // Writing to a string cannot fail.
            if paper != BACKGROUND {
                let _ = writeln!(
                    svg,
                    "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{CELL_WIDTH:.1}\" height=\"{CELL_HEIGHT:.1}\" fill=\"{paper}\"/>"
                );
            }
            let symbol = cell.symbol();
            if symbol.trim().is_empty() {
                continue;
            }
            let bold = if cell.modifier.contains(Modifier::BOLD) {
                " font-weight=\"bold\""
            } else {
                ""
            };
            let dim = if cell.modifier.contains(Modifier::DIM) {
                " opacity=\"0.6\""
            } else {
                ""
            };
            let symbol = symbol.replace('&', "&amp;").replace('<', "&lt;");
            let baseline = y + CELL_HEIGHT * 0.78;
            let _ = writeln!(
                svg,
                "<text x=\"{x:.1}\" y=\"{baseline:.1}\" fill=\"{ink}\"{bold}{dim}>{symbol}</text>"
            );
        }
    }
    svg.push_str("</svg>\n");
    svg
}

fn color(color: Color, default: &'static str) -> &'static str {
    match color {
        Color::Black => BACKGROUND,
        Color::Red => "#e06c75",
        Color::Green => "#8fbf7f",
        Color::Yellow => "#e5c07b",
        Color::Blue => "#61a0e8",
        Color::Magenta => "#c98bdb",
        Color::Cyan => "#5fc0c8",
        Color::Gray | Color::White => "#e6e8ec",
        Color::DarkGray => "#7d8590",
        Color::LightRed => "#ff8a93",
        Color::LightGreen => "#b2e39b",
        Color::LightYellow => "#ffd98f",
        Color::LightBlue => "#8fc1ff",
        Color::LightMagenta => "#e2aef0",
        Color::LightCyan => "#8be4ea",
        _ => default,
    }
}
