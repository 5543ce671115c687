//! Draws pictures as PNG.

use tiny_skia::{
    Color, FillRule, LineCap, LineJoin, Paint, PathBuilder, Pixmap, Stroke, StrokeDash, Transform,
};

use super::Picture;
use super::font::{Font, Piece};
use super::shape::{self, Anchor, Shape, Spot, Text};

/// Pixels of the file per pixel of the picture; sharp in print.
const SCALE: f32 = 2.0;

pub(super) fn draw(picture: &Picture, font: &Font) -> Result<Vec<u8>, String> {
    let (width, height) = picture.size;
    let mut pixmap = Pixmap::new((width * SCALE) as u32, (height * SCALE) as u32)
        .ok_or_else(|| "not enough memory for the picture".to_owned())?;
    pixmap.fill(Color::WHITE);
    for shape in picture.layers.iter().flat_map(|layer| &layer.shapes) {
        draw_shape(&mut pixmap, font, shape);
    }
    pixmap
        .encode_png()
        .map_err(|error| format!("the picture cannot be encoded: {error}"))
}

fn draw_shape(pixmap: &mut Pixmap, font: &Font, shape: &Shape) {
    match shape {
        Shape::Line {
            spots,
            width,
            color,
            is_dashed,
        } => {
            let dash = is_dashed
                .then(|| StrokeDash::new(vec![4.0, 5.0], 0.0))
                .flatten();
            if let Some(path) = path(spots, false) {
                stroke(pixmap, &path, *width, *color, dash);
            }
        }
        Shape::Filled { spots, color } => {
            if let Some(path) = path(spots, true) {
                fill(pixmap, &path, *color, scaled());
            }
        }
        Shape::Circles {
            centers,
            radius,
            width,
            color,
        } => {
            let mut path = PathBuilder::new();
            for &(x, y) in centers {
                path.push_circle(x, y, *radius);
            }
            if let Some(path) = path.finish() {
                if *width > 0.0 {
                    stroke(pixmap, &path, *width, *color, None);
                } else {
                    fill(pixmap, &path, *color, scaled());
                }
            }
        }
        Shape::Text(text) => draw_text(pixmap, font, text),
    }
}

fn draw_text(pixmap: &mut Pixmap, font: &Font, text: &Text) {
    let start = match text.anchor {
        Anchor::Start => 0.0,
        Anchor::Middle => -font.width(&text.words, font.units()) / 2.0,
        Anchor::End => -font.width(&text.words, font.units()),
    };
    let mut path = PathBuilder::new();
    for (glyph, at) in font.glyphs(&text.words) {
        let right = start + at;
        for piece in font.outline(glyph) {
            match piece {
                Piece::Move(x, y) => path.move_to(x + right, y),
                Piece::Line(x, y) => path.line_to(x + right, y),
                Piece::Quadratic(x1, y1, x, y) => path.quad_to(x1 + right, y1, x + right, y),
                Piece::Cubic(x1, y1, x2, y2, x, y) => {
                    path.cubic_to(x1 + right, y1, x2 + right, y2, x + right, y);
                }
                Piece::Close => path.close(),
            }
        }
    }
    let Some(path) = path.finish() else {
        return;
    };
    let scale = text.size / font.units();
    let turn = if text.is_upward { -90.0 } else { 0.0 };
    let (x, y) = text.at;
    let place = scaled()
        .pre_translate(x, y)
        .pre_rotate(turn)
        .pre_scale(scale, -scale);
    fill(pixmap, &path, text.color, place);
    if text.is_bold {
        let stroke = Stroke {
            width: font.units() * super::BOLD,
            line_join: LineJoin::Round,
            ..Stroke::default()
        };
        pixmap.stroke_path(&path, &paint(text.color), &stroke, place, None);
    }
}

fn scaled() -> Transform {
    Transform::from_scale(SCALE, SCALE)
}

fn fill(pixmap: &mut Pixmap, path: &tiny_skia::Path, color: shape::Color, place: Transform) {
    pixmap.fill_path(path, &paint(color), FillRule::Winding, place, None);
}

fn stroke(
    pixmap: &mut Pixmap,
    path: &tiny_skia::Path,
    width: f32,
    color: shape::Color,
    dash: Option<StrokeDash>,
) {
    let stroke = Stroke {
        width,
        line_cap: LineCap::Round,
        line_join: LineJoin::Round,
        dash,
        ..Stroke::default()
    };
    pixmap.stroke_path(path, &paint(color), &stroke, scaled(), None);
}

fn path(spots: &[Spot], is_closed: bool) -> Option<tiny_skia::Path> {
    let (&(x, y), rest) = spots.split_first()?;
    let mut path = PathBuilder::new();
    path.move_to(x, y);
    for &(x, y) in rest {
        path.line_to(x, y);
    }
    if is_closed {
        path.close();
    }
    path.finish()
}

fn paint([red, green, blue]: shape::Color) -> Paint<'static> {
    let mut paint = Paint {
        anti_alias: true,
        ..Paint::default()
    };
    paint.set_color_rgba8(red, green, blue, 0xff);
    paint
}
