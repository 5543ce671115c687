//! Pictures as PNG.

use embedded_graphics::Pixel;
use embedded_graphics::draw_target::DrawTarget;
use embedded_graphics::geometry::{OriginDimensions, Point, Size};
use embedded_graphics::mono_font::{MonoTextStyle, iso_8859_1};
use embedded_graphics::pixelcolor::BinaryColor;
use embedded_graphics::text::Text;
use embedded_graphics::{Drawable as _, mono_font::MonoFont};
use tiny_skia::{
    Color, FillRule, LineCap, LineJoin, Paint, PathBuilder, Pixmap, PremultipliedColorU8, Stroke,
    StrokeDash, Transform,
};

use super::{Place, Shape};

const LARGE: &MonoFont<'_> = &iso_8859_1::FONT_10X20;
const SMALL: &MonoFont<'_> = &iso_8859_1::FONT_9X15;

pub(super) fn draw(shapes: &[Shape], (width, height): (f32, f32)) -> Result<Vec<u8>, String> {
    let mut pixmap = Pixmap::new(width as u32, height as u32)
        .ok_or_else(|| "not enough memory for the picture".to_owned())?;
    pixmap.fill(Color::WHITE);
    for shape in shapes {
        draw_shape(&mut pixmap, shape);
    }
    pixmap
        .encode_png()
        .map_err(|error| format!("the picture cannot be encoded: {error}"))
}

fn draw_shape(pixmap: &mut Pixmap, shape: &Shape) {
    match shape {
        Shape::Line {
            places,
            width,
            color,
            dashed,
        } => {
            let stroke = Stroke {
                width: *width,
                line_cap: LineCap::Round,
                line_join: LineJoin::Round,
                dash: dashed
                    .then(|| StrokeDash::new(vec![4.0, 5.0], 0.0))
                    .flatten(),
                ..Stroke::default()
            };
            if let Some(path) = path(places, false) {
                pixmap.stroke_path(&path, &paint(*color), &stroke, Transform::identity(), None);
            }
        }
        Shape::Filled { places, color } => {
            if let Some(path) = path(places, true) {
                let rule = FillRule::Winding;
                pixmap.fill_path(&path, &paint(*color), rule, Transform::identity(), None);
            }
        }
        Shape::Ring {
            center: (x, y),
            radius,
            width,
            color,
        } => {
            let stroke = Stroke {
                width: *width,
                ..Stroke::default()
            };
            if let Some(path) = PathBuilder::from_circle(*x, *y, *radius) {
                pixmap.stroke_path(&path, &paint(*color), &stroke, Transform::identity(), None);
            }
        }
        Shape::Words { at, words, large } => {
            let style = MonoTextStyle::new(if *large { LARGE } else { SMALL }, BinaryColor::On);
            let at = Point::new(at.0 as i32, at.1 as i32);
            // Pixels outside the picture are skipped; drawing cannot fail.
            let _ = Text::new(words, at, style).draw(&mut Ink(pixmap));
        }
    }
}

fn path(places: &[Place], closed: bool) -> Option<tiny_skia::Path> {
    let (&(x, y), rest) = places.split_first()?;
    let mut path = PathBuilder::new();
    path.move_to(x, y);
    for &(x, y) in rest {
        path.line_to(x, y);
    }
    if closed {
        path.close();
    }
    path.finish()
}

fn paint([red, green, blue]: super::Color) -> Paint<'static> {
    let mut paint = Paint::default();
    paint.set_color_rgba8(red, green, blue, 0xff);
    paint
}

/// Draws the black pixels of letters.
struct Ink<'a>(&'a mut Pixmap);

impl OriginDimensions for Ink<'_> {
    fn size(&self) -> Size {
        Size::new(self.0.width(), self.0.height())
    }
}

impl DrawTarget for Ink<'_> {
    type Color = BinaryColor;
    type Error = std::convert::Infallible;

    fn draw_iter<I: IntoIterator<Item = Pixel<BinaryColor>>>(
        &mut self,
        pixels: I,
    ) -> Result<(), Self::Error> {
        let (width, height) = (self.0.width(), self.0.height());
        let Some(black) = PremultipliedColorU8::from_rgba(0, 0, 0, 0xff) else {
            return Ok(());
        };
        for Pixel(Point { x, y }, color) in pixels {
            if let (Ok(x), Ok(y)) = (u32::try_from(x), u32::try_from(y))
                && x < width
                && y < height
                && color.is_on()
            {
                self.0.pixels_mut()[(y * width + x) as usize] = black;
            }
        }
        Ok(())
    }
}
