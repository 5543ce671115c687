//! Draws what `groundwave export --to map` makes of 10 min, 1 h and 8 h in the house of the demo, with the true outlines in red:
//! `cargo run --all-features --example floor_maps > docs/floor-maps.png`, half a minute.

use std::error::Error;
use std::io::{self, Write as _};
use std::time::Duration;

use groundwave_mapping::{CELL_IN, FloorCell, FloorMap, Mapper};
use groundwave_protocol::decoder::{Decoder, Received};
use sr04_sim::{Outline, Simulation, SimulationConfig, World};
use tiny_skia::{Color, Paint, PathBuilder, Pixmap, Rect, Stroke, Transform};

const SEED: u64 = 1;
const TIMES_MIN: [u64; 3] = [10, 60, 480];

/// Pixels per inch, and around each map.
const SCALE: f32 = 0.75;
const MARGIN: f32 = 12.0;

fn main() -> Result<(), Box<dyn Error>> {
    let world = World::built_in("house").ok_or("no house")?;
    let mut simulation = Simulation::new(&SimulationConfig::new(world, SEED));
    let (mut decoder, mut mapper) = (Decoder::default(), Mapper::default());
    let (mut maps, mut ms) = (Vec::new(), 0);
    for minutes in TIMES_MIN {
        while ms < minutes * 60_000 {
            simulation.step();
            while let Some(byte) = simulation.poll_downlink() {
                if let Some(Received::Line(line, _)) = decoder.lines(&[byte]).next() {
                    mapper.handle_line(Duration::from_millis(ms), &line);
                }
            }
            ms += 1;
        }
        let made = mapper.clone().finish()?;
        if let Some(until) = made.until {
            eprintln!("{minutes} min: up to {} s", until.as_secs());
        }
        maps.push(made.map);
    }
    let picture = draw(&maps, simulation.outlines()).ok_or("no picture")?;
    io::stdout().write_all(&picture.encode_png()?)?;
    Ok(())
}

/// The maps side by side.
fn draw(maps: &[FloorMap], outlines: &[Outline]) -> Option<Pixmap> {
    let rows = |map: &FloorMap| map.cells.len() / map.columns;
    let side = |cells: usize| cells as f32 * CELL_IN as f32 * SCALE;
    let (left_in, low_in) = maps.iter().fold((f64::MAX, f64::MAX), |low, map| {
        (low.0.min(map.corner_in.0), low.1.min(map.corner_in.1))
    });
    let reach = |corner_in: f64, from_in: f64, cells: usize| {
        (corner_in - from_in) as f32 * SCALE + side(cells)
    };
    let width = maps
        .iter()
        .map(|map| reach(map.corner_in.0, left_in, map.columns));
    let width = width.fold(0.0, f32::max) + 2.0 * MARGIN;
    let height = maps
        .iter()
        .map(|map| reach(map.corner_in.1, low_in, rows(map)));
    let height = height.fold(0.0, f32::max) + 2.0 * MARGIN;
    let mut picture = Pixmap::new((width * maps.len() as f32) as u32, height as u32)?;
    picture.fill(Color::from_rgba8(205, 205, 205, 255));
    let mut paint = Paint {
        anti_alias: false,
        ..Paint::default()
    };
    for (at, map) in maps.iter().enumerate() {
        let place = |(x_in, y_in): (f64, f64)| {
            let x = MARGIN + at as f32 * width + (x_in - left_in) as f32 * SCALE;
            (x, height - MARGIN - (y_in - low_in) as f32 * SCALE)
        };
        for (kind, grey) in [
            (FloorCell::Free, 254),
            (FloorCell::Obstacle, 0),
            (FloorCell::Drop, 0),
        ] {
            paint.set_color_rgba8(grey, grey, grey, 255);
            for middle_in in map.middles_in(kind) {
                let (x, y) = place(middle_in);
                let half = side(1) / 2.0;
                let cell = Rect::from_ltrb(x - half, y - half, x + half, y + half)?;
                picture.fill_rect(cell, &paint, Transform::identity(), None);
            }
        }
        let mut truth = PathBuilder::new();
        for outline in outlines {
            match outline {
                Outline::Segment { from, to, .. } => {
                    let ((x, y), (to_x, to_y)) =
                        (place((from.x_in, from.y_in)), place((to.x_in, to.y_in)));
                    truth.move_to(x, y);
                    truth.line_to(to_x, to_y);
                }
                Outline::Block { from, to } => {
                    let ((x, y), (to_x, to_y)) =
                        (place((from.x_in, from.y_in)), place((to.x_in, to.y_in)));
                    truth.push_rect(Rect::from_ltrb(
                        x.min(to_x),
                        y.min(to_y),
                        x.max(to_x),
                        y.max(to_y),
                    )?);
                }
                Outline::Circle {
                    center, radius_in, ..
                } => {
                    let (x, y) = place((center.x_in, center.y_in));
                    truth.push_circle(x, y, *radius_in as f32 * SCALE);
                }
            }
        }
        paint.set_color_rgba8(220, 0, 0, 255);
        let stroke = Stroke::default();
        picture.stroke_path(
            &truth.finish()?,
            &paint,
            &stroke,
            Transform::identity(),
            None,
        );
    }
    Some(picture)
}
