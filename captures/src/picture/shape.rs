//! The elements of a picture.

/// Red, green and blue.
pub(super) type Color = [u8; 3];

/// Position in the picture, pixels right and down.
pub(super) type Spot = (f32, f32);

pub(super) const INK: Color = [0x1f, 0x24, 0x30];
pub(super) const PALE_INK: Color = [0x5c, 0x66, 0x76];
pub(super) const FRAME: Color = [0x9a, 0xa3, 0xb0];
pub(super) const GRID: Color = [0xea, 0xed, 0xf1];
pub(super) const PAPER: Color = [0xff, 0xff, 0xff];
pub(super) const WALL: Color = [0x4a, 0x52, 0x60];
pub(super) const FURNITURE: Color = [0xb4, 0xbc, 0xc8];
pub(super) const ECHO: Color = [0x8f, 0x9b, 0xb0];
pub(super) const GREY: Color = [0x80, 0x88, 0x94];
// Colours of Okabe and Ito, which colour-blind people tell apart.
pub(super) const BLACK: Color = [0x00, 0x00, 0x00];
pub(super) const ORANGE: Color = [0xe6, 0x9f, 0x00];
pub(super) const SKY: Color = [0x56, 0xb4, 0xe9];
pub(super) const GREEN: Color = [0x00, 0x9e, 0x73];
pub(super) const YELLOW: Color = [0xf0, 0xe4, 0x42];
pub(super) const BLUE: Color = [0x00, 0x72, 0xb2];
pub(super) const VERMILION: Color = [0xd5, 0x5e, 0x00];
pub(super) const PURPLE: Color = [0xcc, 0x79, 0xa7];

/// Place of a text relative to its spot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// A text of one line.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Text {
    /// Position of the baseline's start, middle or end.
    pub(super) at: Spot,
    pub(super) words: String,
    /// Height of an em, pixels.
    pub(super) size: f32,
    pub(super) color: Color,
    pub(super) anchor: Anchor,
    pub(super) is_bold: bool,
    /// Whether the text reads upward.
    pub(super) is_upward: bool,
}

impl Text {
    pub(super) fn new(at: Spot, words: impl Into<String>, size: f32, color: Color) -> Self {
        Self {
            at,
            words: words.into(),
            size,
            color,
            anchor: Anchor::Start,
            is_bold: false,
            is_upward: false,
        }
    }
}

/// An element of a picture.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Shape {
    Line {
        spots: Vec<Spot>,
        width: f32,
        color: Color,
        is_dashed: bool,
    },
    Filled {
        spots: Vec<Spot>,
        color: Color,
    },
    /// Circles of one style; filled if the width is 0.
    Circles {
        centers: Vec<Spot>,
        radius: f32,
        width: f32,
        color: Color,
    },
    Text(Text),
}

impl Shape {
    pub(super) fn line(spots: Vec<Spot>, width: f32, color: Color) -> Self {
        Self::Line {
            spots,
            width,
            color,
            is_dashed: false,
        }
    }

    /// Whether both are lines of one style.
    pub(super) fn is_line_like(&self, other: &Self) -> bool {
        let style = |shape: &Self| match shape {
            Self::Line {
                width,
                color,
                is_dashed,
                ..
            } => Some((*width, *color, *is_dashed)),
            _ => None,
        };
        style(self).is_some() && style(self) == style(other)
    }

    pub(super) fn disc(center: Spot, radius: f32, color: Color) -> Self {
        Self::ring(center, radius, 0.0, color)
    }

    pub(super) fn ring(center: Spot, radius: f32, width: f32, color: Color) -> Self {
        Self::Circles {
            centers: vec![center],
            radius,
            width,
            color,
        }
    }
}

/// Shapes of one meaning, drawn together.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Layer {
    pub(super) name: &'static str,
    pub(super) shapes: Vec<Shape>,
}
