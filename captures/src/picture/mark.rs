//! The symbols of the plot and the legend.

use super::font::Font;
use super::shape::{
    Anchor, BLACK, BLUE, Color, ECHO, FURNITURE, GREEN, GREY, INK, ORANGE, PAPER, PURPLE, SKY,
    Shape, Spot, Text, VERMILION, WALL, YELLOW,
};
use crate::track::{Event, Holder};
use groundwave_protocol::status_codes::Layer;

/// Width of the path, and of the white line below the path, pixels.
pub(super) const PATH: f32 = 2.6;
pub(super) const HALO: f32 = 5.0;

/// Radius of the ring around a start, pixels.
pub(super) const START: f32 = 8.0;

/// Half of the length of a line in the legend, pixels.
const REACH: f32 = 15.0;

/// A symbol of the legend.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Symbol {
    Path(Color),
    Gap,
    Event(Event),
    Start(Color),
    /// The end of a path, with the robot's heading, degrees clockwise from +Y.
    End(Color, f32),
    /// A waypoint; `true` if it was reached.
    Waypoint(bool),
    /// A mark of the operator, with its letter.
    Mark(char),
    Echo,
    Infrared,
    Wall,
    Furniture,
    Obstacle,
}

/// Draws a symbol around a spot.
pub(super) fn draw(shapes: &mut Vec<Shape>, font: &Font, symbol: Symbol, at: Spot) {
    let (x, y) = at;
    let across = vec![(x - REACH, y), (x + REACH, y)];
    match symbol {
        Symbol::Path(color) => shapes.push(Shape::line(across, 5.0, color)),
        Symbol::Gap => shapes.push(gap(across)),
        Symbol::Event(kind) => event(shapes, kind, at),
        Symbol::Start(color) => start(shapes, at, START, color),
        Symbol::End(color, heading_deg) => end(shapes, at, heading_deg, color),
        Symbol::Waypoint(is_reached) => waypoint(shapes, font, at, "1", is_reached),
        Symbol::Mark(letter) => flag(shapes, at, letter),
        Symbol::Echo => shapes.extend(dots(
            vec![(x - 8.0, y + 2.0), (x, y - 2.0), (x + 8.0, y)],
            ECHO,
        )),
        Symbol::Infrared => {
            shapes.extend(dots(
                vec![(x - 8.0, y + 2.0), (x, y - 2.0), (x + 8.0, y)],
                ORANGE,
            ));
        }
        Symbol::Wall => shapes.push(wall(across)),
        Symbol::Furniture => shapes.push(furniture(across)),
        Symbol::Obstacle => shapes.push(obstacle([(x - REACH, y + 4.0), (x + REACH, y - 4.0)])),
    }
}

/// A path whose lines were lost or damaged.
pub(super) fn gap(spots: Vec<Spot>) -> Shape {
    Shape::Line {
        spots,
        width: 1.6,
        color: GREY,
        is_dashed: true,
    }
}

pub(super) fn wall(spots: Vec<Spot>) -> Shape {
    Shape::line(spots, 3.0, WALL)
}

pub(super) fn furniture(spots: Vec<Spot>) -> Shape {
    Shape::line(spots, 1.6, FURNITURE)
}

/// A mapped obstacle, given by opposite corners.
pub(super) fn obstacle([(left, bottom), (right, top)]: [Spot; 2]) -> Shape {
    // Obstacles side by side show no seam.
    let (left, right, top, bottom) = (left - 0.3, right + 0.3, top - 0.3, bottom + 0.3);
    Shape::Filled {
        spots: vec![(left, bottom), (right, bottom), (right, top), (left, top)],
        color: FURNITURE,
    }
}

/// Detections of a sensor; `None` if there are none.
pub(super) fn dots(centers: Vec<Spot>, color: Color) -> Option<Shape> {
    (!centers.is_empty()).then_some(Shape::Circles {
        centers,
        radius: 1.7,
        width: 0.0,
        color,
    })
}

/// Draws lines with a white outline.
fn outlined(shapes: &mut Vec<Shape>, lines: &[Vec<Spot>]) {
    for (width, color) in [(4.6, PAPER), (2.0, BLACK)] {
        for line in lines {
            shapes.push(Shape::line(line.clone(), width, color));
        }
    }
}

pub(super) fn event(shapes: &mut Vec<Shape>, event: Event, (x, y): Spot) {
    let lines: &[Vec<Spot>] = &match event {
        Event::Bump => vec![
            vec![(x - 5.0, y - 5.0), (x + 5.0, y + 5.0)],
            vec![(x - 5.0, y + 5.0), (x + 5.0, y - 5.0)],
        ],
        Event::Edge => vec![closed(&[
            (x - 6.0, y + 5.0),
            (x, y - 6.0),
            (x + 6.0, y + 5.0),
        ])],
        Event::Stall => vec![closed(&[
            (x - 5.0, y - 5.0),
            (x + 5.0, y - 5.0),
            (x + 5.0, y + 5.0),
            (x - 5.0, y + 5.0),
        ])],
        Event::Restart => vec![
            vec![(x - 6.0, y), (x + 6.0, y)],
            vec![(x, y - 6.0), (x, y + 6.0)],
        ],
        Event::OdometerReset => vec![closed(&[
            (x - 6.5, y),
            (x, y - 6.5),
            (x + 6.5, y),
            (x, y + 6.5),
        ])],
        Event::Outage => vec![
            vec![(x - 6.0, y + 6.5), (x, y - 6.5)],
            vec![(x, y + 6.5), (x + 6.0, y - 6.5)],
        ],
    };
    outlined(shapes, lines);
}

fn closed(spots: &[Spot]) -> Vec<Spot> {
    spots.iter().chain(&spots[..1]).copied().collect()
}

/// Draws a ring around the start.
pub(super) fn start(shapes: &mut Vec<Shape>, center: Spot, radius: f32, color: Color) {
    for (width, color) in [(6.0, PAPER), (3.0, color)] {
        shapes.push(Shape::ring(center, radius, width, color));
    }
}

/// Draws an arrowhead with the robot's heading.
pub(super) fn end(shapes: &mut Vec<Shape>, (x, y): Spot, heading_deg: f32, color: Color) {
    let (sin, cos) = heading_deg.to_radians().sin_cos();
    let at =
        |ahead: f32, right: f32| (x + ahead * sin + right * cos, y - ahead * cos + right * sin);
    for (size, color) in [(15.5, PAPER), (11.5, color)] {
        let spots = vec![
            at(size, 0.0),
            at(-size * 0.75, size * 0.72),
            at(-size * 0.35, 0.0),
            at(-size * 0.75, -size * 0.72),
        ];
        shapes.push(Shape::Filled { spots, color });
    }
}

/// Draws a numbered disc, hollow if the waypoint was not reached.
pub(super) fn waypoint(
    shapes: &mut Vec<Shape>,
    font: &Font,
    (x, y): Spot,
    label: &str,
    is_reached: bool,
) {
    const SIZE: f32 = 12.0;
    let radius = (font.width(label, SIZE) / 2.0 + 4.5).max(9.0);
    shapes.push(Shape::disc((x, y), radius + 1.8, PAPER));
    shapes.push(Shape::disc((x, y), radius, GREEN));
    if !is_reached {
        shapes.push(Shape::disc((x, y), radius - 2.0, PAPER));
    }
    shapes.push(Shape::Text(Text {
        anchor: Anchor::Middle,
        is_bold: true,
        ..Text::new(
            (x, y + 4.3),
            label,
            SIZE,
            if is_reached { PAPER } else { INK },
        )
    }));
}

/// Draws the letter of a mark in a square.
pub(super) fn flag(shapes: &mut Vec<Shape>, (x, y): Spot, letter: char) {
    for (reach, color) in [(10.8, PAPER), (9.0, PURPLE)] {
        let spots = vec![
            (x - reach, y - reach),
            (x + reach, y - reach),
            (x + reach, y + reach),
            (x - reach, y + reach),
        ];
        shapes.push(Shape::Filled { spots, color });
    }
    shapes.push(Shape::Text(Text {
        anchor: Anchor::Middle,
        is_bold: true,
        ..Text::new((x, y + 4.3), letter.to_string(), 12.0, BLACK)
    }));
}

pub(super) const fn color(holder: Holder) -> Color {
    match holder {
        Holder::Prowl => GREY,
        Holder::Layer(layer) => match layer {
            Layer::User => BLACK,
            Layer::Bumpers => VERMILION,
            Layer::Rotation => PURPLE,
            Layer::Infrared => ORANGE,
            Layer::Sonar => SKY,
            Layer::Photo => YELLOW,
            Layer::Motion => GREEN,
            Layer::DeadReckoning => BLUE,
        },
    }
}
