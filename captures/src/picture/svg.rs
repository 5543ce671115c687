//! Draws pictures as SVG.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use super::Picture;
use super::font::{Font, Piece};
use super::shape::{Anchor, Color, Layer, Shape, Spot, Text};

/// The picture as an SVG document. Letters are outlines, each defined once; the picture looks the same in every viewer.
pub(super) fn draw(picture: &Picture, font: &Font) -> String {
    let (width, height) = picture.size;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" \
         stroke-linejoin=\"round\" stroke-linecap=\"round\">\n\
         <title>{}</title>\n",
        escaped(&picture.title)
    );
    define(&mut svg, font, &picture.layers);
    svg.push_str("<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n");
    for layer in &picture.layers {
        // Writing to a string cannot fail.
        let _ = writeln!(svg, "<g id=\"{}\">", layer.name);
        for alike in layer.shapes.chunk_by(Shape::is_line_like) {
            draw_alike(&mut svg, font, alike);
        }
        svg.push_str("</g>\n");
    }
    svg.push_str("</svg>\n");
    svg
}

/// Defines the outlines of the letters.
fn define(svg: &mut String, font: &Font, layers: &[Layer]) {
    let shapes = layers.iter().flat_map(|layer| &layer.shapes);
    let glyphs: BTreeSet<u16> = shapes
        .filter_map(|shape| match shape {
            Shape::Text(text) => Some(font.glyphs(&text.words)),
            _ => None,
        })
        .flatten()
        .map(|(glyph, _)| glyph)
        .collect();
    svg.push_str("<defs>\n");
    for glyph in glyphs {
        let mut path = String::new();
        for piece in font.outline(glyph) {
            let _ = match piece {
                Piece::Move(x, y) => write!(path, "M{x} {y}"),
                Piece::Line(x, y) => write!(path, "L{x} {y}"),
                Piece::Quadratic(x1, y1, x, y) => write!(path, "Q{x1} {y1} {x} {y}"),
                Piece::Cubic(x1, y1, x2, y2, x, y) => {
                    write!(path, "C{x1} {y1} {x2} {y2} {x} {y}")
                }
                Piece::Close => write!(path, "Z"),
            };
        }
        if !path.is_empty() {
            let _ = writeln!(svg, "<path id=\"g{glyph}\" d=\"{path}\"/>");
        }
    }
    svg.push_str("</defs>\n");
}

/// Draws a shape. Lines of one style become one path, because a day's drive has thousands.
fn draw_alike(svg: &mut String, font: &Font, alike: &[Shape]) {
    let Some(first) = alike.first() else {
        return;
    };
    let _ = match first {
        Shape::Line {
            width,
            color,
            is_dashed,
            ..
        } => writeln!(
            svg,
            "<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{width}\"{}/>",
            lines(alike),
            hex(*color),
            if *is_dashed {
                " stroke-dasharray=\"4 5\""
            } else {
                ""
            }
        ),
        Shape::Filled { spots, color } => writeln!(
            svg,
            "<polygon points=\"{}\" fill=\"{}\"/>",
            points(spots),
            hex(*color)
        ),
        Shape::Circles {
            centers,
            radius,
            width,
            color,
        } => draw_circles(svg, centers, *radius, *width, *color),
        Shape::Text(text) => draw_text(svg, font, text),
    };
}

/// Lines as the data of an SVG path.
fn lines(shapes: &[Shape]) -> String {
    let mut path = String::new();
    for shape in shapes {
        let Shape::Line { spots, .. } = shape else {
            continue;
        };
        for (number, (x, y)) in spots.iter().enumerate() {
            let command = if number == 0 { 'M' } else { 'L' };
            let _ = write!(path, "{command}{x:.1} {y:.1}");
        }
    }
    path
}

fn draw_circles(
    svg: &mut String,
    centers: &[Spot],
    radius: f32,
    width: f32,
    color: Color,
) -> std::fmt::Result {
    let color = hex(color);
    if let ([(x, y)], true) = (centers, width > 0.0) {
        return writeln!(
            svg,
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"{width}\"/>"
        );
    }
    // Many dots are one path of points with round caps.
    let mut dots = String::new();
    for (x, y) in centers {
        write!(dots, "M{x:.1} {y:.1}h0")?;
    }
    writeln!(
        svg,
        "<path d=\"{dots}\" stroke=\"{color}\" stroke-width=\"{}\"/>",
        2.0 * radius
    )
}

fn draw_text(svg: &mut String, font: &Font, text: &Text) -> std::fmt::Result {
    let scale = text.size / font.units();
    let (x, y) = text.at;
    let turn = if text.is_upward { " rotate(-90)" } else { "" };
    let bold = if text.is_bold {
        format!(
            " stroke=\"{}\" stroke-width=\"{:.0}\"",
            hex(text.color),
            font.units() * super::BOLD
        )
    } else {
        String::new()
    };
    write!(
        svg,
        "<g transform=\"translate({x:.1} {y:.1}){turn} scale({scale:.5} -{scale:.5})\" fill=\"{}\"{bold} role=\"img\" aria-label=\"{}\">",
        hex(text.color),
        escaped(&text.words)
    )?;
    let start = match text.anchor {
        Anchor::Start => 0.0,
        Anchor::Middle => -font.width(&text.words, font.units()) / 2.0,
        Anchor::End => -font.width(&text.words, font.units()),
    };
    for ((glyph, at), letter) in font.glyphs(&text.words).into_iter().zip(text.words.chars()) {
        if !letter.is_whitespace() {
            write!(svg, "<use href=\"#g{glyph}\" x=\"{:.0}\"/>", start + at)?;
        }
    }
    writeln!(svg, "</g>")
}

fn points(spots: &[Spot]) -> String {
    let spot = |(x, y): &Spot| format!("{x:.1},{y:.1}");
    spots.iter().map(spot).collect::<Vec<_>>().join(" ")
}

fn hex([red, green, blue]: Color) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

/// Text escaped for XML.
fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            c if c.is_control() => escaped.push('\u{fffd}'),
            c => escaped.push(c),
        }
    }
    escaped
}
