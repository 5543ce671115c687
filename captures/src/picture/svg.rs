//! Pictures as SVG.

use std::fmt::Write as _;

use super::{Color, Place, Shape};

/// Font sizes, pixels.
const LARGE: u8 = 22;
const SMALL: u8 = 16;

/// The shapes as an SVG document. Writing to a string cannot fail.
pub(super) fn draw(shapes: &[Shape], (width, height): (f32, f32)) -> String {
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" \
         font-family=\"sans-serif\" stroke-linejoin=\"round\" stroke-linecap=\"round\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n"
    );
    for shape in shapes {
        let _ = match shape {
            Shape::Line {
                places,
                width,
                color,
                dashed,
            } => writeln!(
                svg,
                "<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{width}\"{}/>",
                points(places),
                hex(*color),
                if *dashed {
                    " stroke-dasharray=\"4 5\""
                } else {
                    ""
                }
            ),
            Shape::Filled { places, color } => writeln!(
                svg,
                "<polygon points=\"{}\" fill=\"{}\"/>",
                points(places),
                hex(*color)
            ),
            Shape::Ring {
                center: (x, y),
                radius,
                width,
                color,
            } => writeln!(
                svg,
                "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius}\" fill=\"none\" stroke=\"{}\" \
                 stroke-width=\"{width}\"/>",
                hex(*color)
            ),
            Shape::Words {
                at: (x, y),
                words,
                large,
            } => writeln!(
                svg,
                "<text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"{}\">{}</text>",
                if *large { LARGE } else { SMALL },
                escaped(words)
            ),
        };
    }
    svg.push_str("</svg>\n");
    svg
}

fn points(places: &[Place]) -> String {
    let place = |(x, y): &Place| format!("{x:.1},{y:.1}");
    places.iter().map(place).collect::<Vec<_>>().join(" ")
}

fn hex([red, green, blue]: Color) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

/// Text escaped for XML.
pub(in super::super) fn escaped(words: &str) -> String {
    let mut text = String::with_capacity(words.len());
    for c in words.chars() {
        match c {
            '&' => text.push_str("&amp;"),
            '<' => text.push_str("&lt;"),
            '>' => text.push_str("&gt;"),
            c if c.is_control() => text.push('\u{fffd}'),
            c => text.push(c),
        }
    }
    text
}
