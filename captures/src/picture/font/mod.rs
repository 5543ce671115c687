//! The font of the pictures: outlines and widths of letters. SVG and PNG draw the same outlines.

use ttf_parser::{Face, GlyphId, OutlineBuilder};

/// A subset of Inter: Latin, Greek and Cyrillic letters.
const INTER: &[u8] = include_bytes!("inter.ttf");

/// A segment of an outline, in font units, y up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Piece {
    Move(f32, f32),
    Line(f32, f32),
    Quadratic(f32, f32, f32, f32),
    Cubic(f32, f32, f32, f32, f32, f32),
    Close,
}

/// The font.
pub(super) struct Font {
    face: Face<'static>,
}

impl Font {
    pub(super) fn load() -> Self {
        let face = Face::parse(INTER, 0).expect("the built-in font is intact");
        Self { face }
    }

    /// Font units per em.
    pub(super) fn units(&self) -> f32 {
        f32::from(self.face.units_per_em())
    }

    /// The glyphs of a text, and the position of each in font units; unknown letters become boxes.
    pub(super) fn glyphs(&self, text: &str) -> Vec<(u16, f32)> {
        let mut at = 0.0;
        text.chars()
            .map(|letter| {
                let id = self.face.glyph_index(letter).unwrap_or(GlyphId(0));
                let advance = self.face.glyph_hor_advance(id).unwrap_or_default();
                let place = at;
                at += f32::from(advance);
                (id.0, place)
            })
            .collect()
    }

    /// Width of a text at a font size, in the unit of the size.
    pub(super) fn width(&self, text: &str, size: f32) -> f32 {
        let advance = |letter| {
            let id = self.face.glyph_index(letter).unwrap_or(GlyphId(0));
            f32::from(self.face.glyph_hor_advance(id).unwrap_or_default())
        };
        text.chars().map(advance).sum::<f32>() * size / self.units()
    }

    /// The outline of a glyph; empty for a space.
    pub(super) fn outline(&self, glyph: u16) -> Vec<Piece> {
        let mut outline = Outline::default();
        self.face.outline_glyph(GlyphId(glyph), &mut outline);
        outline.0
    }

    /// A text that fits into a width: unchanged, or without its middle.
    pub(super) fn fit(&self, text: &str, size: f32, width: f32) -> String {
        if self.width(text, size) <= width {
            return text.to_owned();
        }
        let letters: Vec<char> = text.chars().collect();
        (0..letters.len())
            .rev()
            .map(|kept| {
                let head = letters[..kept / 2].iter();
                let tail = letters[letters.len() - (kept - kept / 2)..].iter();
                head.chain(&['…']).chain(tail).collect::<String>()
            })
            .find(|short| self.width(short, size) <= width)
            .unwrap_or_default()
    }

    /// A text split into lines that fit into a width.
    pub(super) fn wrap(&self, text: &str, size: f32, width: f32) -> Vec<String> {
        let mut lines: Vec<String> = Vec::new();
        for word in text.split_whitespace() {
            let longer = lines.last().map(|line| format!("{line} {word}"));
            match (longer, lines.last_mut()) {
                (Some(longer), Some(line)) if self.width(&longer, size) <= width => *line = longer,
                _ => lines.push(self.fit(word, size, width)),
            }
        }
        lines
    }
}

#[derive(Default)]
struct Outline(Vec<Piece>);

impl OutlineBuilder for Outline {
    fn move_to(&mut self, x: f32, y: f32) {
        self.0.push(Piece::Move(x, y));
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.0.push(Piece::Line(x, y));
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        self.0.push(Piece::Quadratic(x1, y1, x, y));
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        self.0.push(Piece::Cubic(x1, y1, x2, y2, x, y));
    }

    fn close(&mut self) {
        self.0.push(Piece::Close);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_shortened_and_wrapped_by_their_width() {
        let font = Font::load();
        for text in [
            "a",
            "house-noisy",
            "überall.mcap",
            "кухня 2",
            &"m".repeat(200),
        ] {
            let short = font.fit(text, 16.0, 120.0);
            assert!(font.width(&short, 16.0) <= 120.0, "{short}");
            assert_eq!(short == text, font.width(text, 16.0) <= 120.0);
        }
        let text = "a path of many words that is longer than a line ".repeat(5);
        let lines = font.wrap(&text, 13.0, 300.0);
        assert!(lines.len() > 2);
        assert!(lines.iter().all(|line| font.width(line, 13.0) <= 300.0));
        assert_eq!(lines.join(" "), text.trim_end());
    }

    #[test]
    fn letters_of_file_names_have_outlines_and_unknown_ones_a_box() {
        let font = Font::load();
        for letter in "aZ9éßčжλ−×…".chars() {
            let (glyph, _) = font.glyphs(&letter.to_string())[0];
            assert!(glyph != 0 && !font.outline(glyph).is_empty(), "{letter}");
        }
        assert_eq!(font.glyphs("台")[0].0, 0);
        assert!(!font.outline(0).is_empty());
        assert!(font.outline(font.glyphs(" ")[0].0).is_empty());
    }
}
