//! The map as a picture, for terminals that show pictures by the kitty graphics protocol. The terminal draws it behind the
//! characters, so that marks and labels remain text.

use std::fmt::Write as _;

use base64::prelude::{BASE64_STANDARD, Engine as _};
use ratatui::layout::Rect;
use ratatui::style::Color;

use super::raster::{INKS, Raster};
use super::theme::Theme;
use crate::model::Colors;

/// Number of cells of the fine raster along a cell of the screen; a screen cell has 8 by 16 pixels.
pub(super) const FINE: u16 = 4;

/// Number of the picture in the terminal; a new picture replaces the old one.
const NUMBER: u32 = 7704;

/// Maximum number of base64 characters in one sequence, by the protocol.
const CHUNK: usize = 4096;

/// Sequence that removes the picture.
const REMOVE: &str = "\x1b_Ga=d,d=i,i=7704,q=2\x1b\\";

/// A picture behind an area of the screen.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    area: Rect,
    /// Width, pixels.
    width: u32,
    height: u32,
    /// Four bits per pixel: 0 is transparent, others are indexes in the palette.
    packed: Vec<u8>,
    /// Red, green and blue of each palette entry.
    palette: Vec<u8>,
}

impl Picture {
    /// The picture of a raster that is finer than its area by [`FINE`].
    pub(super) fn of(raster: &Raster, area: Rect, theme: &Theme, colors: Colors) -> Self {
        let (width, height) = (u32::from(area.width) * 8, u32::from(area.height) * 16);
        let mut packed = vec![0; (width / 2 * height) as usize];
        for (x, y, ink) in raster.lit() {
            if let Some(byte) = packed.get_mut(y * width as usize / 2 + x / 2) {
                let shift = if x % 2 == 0 { 4 } else { 0 };
                let last = *byte >> shift & 0xF;
                *byte = *byte & !(0xF << shift) | last.max(ink as u8) << shift;
            }
        }
        let palette = INKS.map(|ink| rgb(ink.style(theme).fg, colors));
        Self {
            area,
            width,
            height,
            packed,
            palette: palette.concat(),
        }
    }

    /// The sequences that replace the last picture by a picture, or remove it.
    #[must_use]
    pub fn sequences(picture: Option<&Self>) -> Vec<u8> {
        let shown = picture.and_then(|picture| Some((picture.area, picture.png().ok()?)));
        let Some((area, png)) = shown else {
            return REMOVE.into();
        };
        let mut text = format!("\x1b[{};{}H", area.y + 1, area.x + 1);
        let encoded = BASE64_STANDARD.encode(png);
        let mut rest = &*encoded;
        let mut control = format!(
            "a=T,f=100,i={NUMBER},p=1,c={},r={},z=-1,C=1,q=2,",
            area.width, area.height
        );
        while !rest.is_empty() {
            let (chunk, after) = rest.split_at(rest.len().min(CHUNK));
            let more = u8::from(!after.is_empty());
            // Writing to a string cannot fail.
            let _ = write!(text, "\x1b_G{control}m={more};{chunk}\x1b\\");
            control.clear();
            rest = after;
        }
        text.into_bytes()
    }

    fn png(&self) -> Result<Vec<u8>, png::EncodingError> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.width, self.height);
        encoder.set_color(png::ColorType::Indexed);
        encoder.set_depth(png::BitDepth::Four);
        encoder.set_palette(&self.palette[..]);
        encoder.set_trns(&[0][..]);
        encoder.set_compression(png::Compression::Fast);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&self.packed)?;
        writer.finish()?;
        Ok(bytes)
    }
}

/// A colour of the screen as red, green and blue; a named colour has the usual value of terminals.
fn rgb(color: Option<Color>, colors: Colors) -> [u8; 3] {
    match color {
        Some(Color::Cyan) => [0x2a, 0xa1, 0xb8],
        Some(Color::Blue) => [0x3b, 0x78, 0xd8],
        Some(Color::Magenta) => [0xb0, 0x50, 0xb8],
        Some(Color::Yellow) => [0xd8, 0xb0, 0x20],
        Some(Color::Indexed(gray @ 232..)) => [8 + 10 * (gray - 232); 3],
        Some(Color::Indexed(n @ 16..)) => {
            let part = |n: u8| if n == 0 { 0 } else { 55 + 40 * n };
            [
                part((n - 16) / 36),
                part((n - 16) / 6 % 6),
                part((n - 16) % 6),
            ]
        }
        _ if colors == Colors::Light => [0x30; 3],
        _ => [0xd0; 3],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Config;
    use crate::view::raster::Ink;

    /// A line across an area of 3 by 2 cells.
    fn picture() -> Picture {
        let area = Rect::new(5, 2, 3, 2);
        let mut raster = Raster::new(Rect::new(0, 0, area.width * FINE, area.height * FINE));
        raster.line((0.0, 9.0), (23.0, 9.0), 1, Ink::Wall);
        let theme = Theme::of(&Config::default());
        Picture::of(&raster, area, &theme, Colors::Dark)
    }

    #[test]
    fn the_sequences_hold_the_pixels_and_the_place() {
        let text = String::from_utf8(Picture::sequences(Some(&picture()))).unwrap();
        let begin = "\x1b[3;6H\x1b_Ga=T,f=100,i=7704,p=1,c=3,r=2,z=-1,C=1,q=2,m=0;";
        let data = text.strip_prefix(begin).unwrap();
        let png = BASE64_STANDARD
            .decode(data.strip_suffix("\x1b\\").unwrap())
            .unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(png))
            .read_info()
            .unwrap();
        assert_eq!((reader.info().width, reader.info().height), (24, 32));
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut pixels).unwrap();
        let rows: Vec<&[u8]> = pixels.chunks(12).collect();
        let wall = Ink::Wall as u8 * 0x11;
        assert!(rows[9].iter().all(|byte| *byte == wall), "{:?}", rows[9]);
        assert!(rows[20].iter().all(|byte| *byte == 0));
    }

    #[test]
    fn a_large_picture_goes_in_chunks() {
        let area = Rect::new(0, 0, 60, 30);
        let mut raster = Raster::new(Rect::new(0, 0, 240, 120));
        for n in 0..20_000_u32 {
            let dot = n.wrapping_mul(2_654_435_761);
            raster.dot(f64::from(dot % 480), f64::from(dot / 480 % 480), Ink::Wall);
        }
        let theme = Theme::of(&Config::default());
        let picture = Picture::of(&raster, area, &theme, Colors::Dark);
        let text = String::from_utf8(Picture::sequences(Some(&picture))).unwrap();
        let parts: Vec<&str> = text
            .split("\x1b\\")
            .filter(|part| !part.is_empty())
            .collect();
        assert!(parts.len() > 2, "{}", parts.len());
        for (n, part) in parts.iter().enumerate() {
            let (control, data) = part.split_once(';').unwrap();
            let (control, data) = if n == 0 {
                part.split_once(",m=1;").unwrap()
            } else {
                (control, data)
            };
            assert!(data.len() <= CHUNK && data.is_ascii(), "{control}");
            assert_eq!(part.contains("m=0;"), n + 1 == parts.len(), "{control}");
        }
    }
}
