//! Lines and points on a grid of dots: two across and four down in each cell, as in braille.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::symbols::braille::BRAILLE;
use ratatui::symbols::pixel::{OCTANTS, QUADRANTS};

use super::theme::Theme;
use crate::model::Marker;

/// The object of a dot. If a cell has several, the last in this list determines the colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Ink {
    #[default]
    None,
    Furniture,
    Sonar,
    Wall,
    OldTrail,
    Draft,
    Route,
    Trail,
    /// The left trace of a pair.
    Left,
    Right,
    Robot,
}

/// Every ink, in the order of the list.
pub(super) const INKS: [Ink; 11] = [
    Ink::None,
    Ink::Furniture,
    Ink::Sonar,
    Ink::Wall,
    Ink::OldTrail,
    Ink::Draft,
    Ink::Route,
    Ink::Trail,
    Ink::Left,
    Ink::Right,
    Ink::Robot,
];

impl Ink {
    pub(super) fn style(self, theme: &Theme) -> Style {
        match self {
            Self::None => theme.plain,
            Self::Furniture => theme.furniture,
            Self::Wall => theme.wall,
            Self::Sonar => theme.sonar,
            Self::OldTrail => theme.old_trail,
            Self::Draft | Self::Right => theme.draft,
            Self::Route => theme.route,
            Self::Trail | Self::Left => theme.trail,
            Self::Robot => theme.robot,
        }
    }

    pub(super) const fn ascii(self) -> char {
        match self {
            Self::None => ' ',
            Self::Furniture => ':',
            Self::Wall => '#',
            Self::Sonar => '\'',
            Self::OldTrail => ',',
            Self::Draft => '~',
            Self::Route => '-',
            Self::Trail => '.',
            Self::Left => 'L',
            Self::Right => 'R',
            Self::Robot => 'o',
        }
    }
}

#[cfg(test)]
thread_local! {
    /// Number of dots drawn so far, for tests of the cost of a frame.
    pub(super) static DRAWN: std::cell::Cell<u64> = const { std::cell::Cell::new(0) };
}

/// A picture of dots; the bits of a cell are row by row.
#[derive(Debug)]
pub(super) struct Raster {
    columns: usize,
    cells: Vec<(u8, Ink)>,
    width: f64,
    height: f64,
}

impl Raster {
    /// An empty picture for an area of cells.
    pub(super) fn new(area: Rect) -> Self {
        let (columns, rows) = (usize::from(area.width), usize::from(area.height));
        Self {
            columns,
            cells: vec![(0, Ink::None); columns * rows],
            width: (2 * columns) as f64,
            height: (4 * rows) as f64,
        }
    }

    /// Sets a dot, counted from the upper left; ignores dots outside the picture.
    pub(super) fn dot(&mut self, x: f64, y: f64, ink: Ink) {
        #[cfg(test)]
        DRAWN.set(DRAWN.get() + 1);
        if !(0.0..self.width).contains(&x) || !(0.0..self.height).contains(&y) {
            return;
        }
        let (x, y) = (x as usize, y as usize);
        self.set(y / 4 * self.columns + x / 2, 1 << (y % 4 * 2 + x % 2), ink);
    }

    /// Draws a line of dots; `every` is their spacing.
    pub(super) fn line(&mut self, from: (f64, f64), to: (f64, f64), every: usize, ink: Ink) {
        // The usual case in a trail: both ends in the same dot.
        if from == to {
            self.dot(from.0, from.1, ink);
            return;
        }
        let Some((from, to)) = self.clip(from, to) else {
            return;
        };
        let (dx, dy) = (to.0 - from.0, to.1 - from.1);
        let steps = dx.abs().max(dy.abs()).ceil().max(1.0);
        for step in (0..=steps as usize).step_by(every.max(1)) {
            let part = step as f64 / steps;
            // Whole dots: 23.0 * (13.0 / 23.0) is a little less than 13.
            let (x, y) = (from.0 + dx * part, from.1 + dy * part);
            self.dot(x.round(), y.round(), ink);
        }
    }

    /// Fills a rectangle between two opposite corners.
    pub(super) fn block(&mut self, from: (f64, f64), to: (f64, f64), ink: Ink) {
        let span = |a: f64, b: f64, end: f64| {
            let (low, high) = (a.min(b).max(0.0), a.max(b).min(end - 1.0));
            (low <= high).then_some((low as usize, high as usize))
        };
        let across = span(from.0, to.0, self.width);
        let down = span(from.1, to.1, self.height);
        let (Some((left, right)), Some((top, bottom))) = (across, down) else {
            return;
        };
        for row in top / 4..=bottom / 4 {
            let (first, last) = (top.max(4 * row) % 4, bottom.min(4 * row + 3) % 4);
            let rows = 0xFF_u8 << (2 * first) & 0xFF >> (6 - 2 * last);
            for column in left / 2..=right / 2 {
                let both = (left <= 2 * column, right > 2 * column);
                let columns = match both {
                    (true, true) => 0xFF,
                    (true, false) => 0x55,
                    (false, _) => 0xAA,
                };
                self.set(row * self.columns + column, rows & columns, ink);
            }
        }
    }

    fn set(&mut self, cell: usize, dots: u8, ink: Ink) {
        if let Some((bits, owner)) = self.cells.get_mut(cell) {
            *bits |= dots;
            *owner = ink.max(*owner);
        }
    }

    /// The part of a line inside the picture.
    fn clip(&self, from: (f64, f64), to: (f64, f64)) -> Option<((f64, f64), (f64, f64))> {
        let (dx, dy) = (to.0 - from.0, to.1 - from.1);
        let (mut enters, mut leaves) = (0.0_f64, 1.0_f64);
        for (delta, start, limit) in [(dx, from.0, self.width), (dy, from.1, self.height)] {
            if delta == 0.0 {
                if !(0.0..=limit).contains(&start) {
                    return None;
                }
                continue;
            }
            let (a, b) = (-start / delta, (limit - start) / delta);
            enters = enters.max(a.min(b));
            leaves = leaves.min(a.max(b));
        }
        let at = |part: f64| (from.0 + dx * part, from.1 + dy * part);
        (enters <= leaves).then(|| (at(enters), at(leaves)))
    }

    /// The set dots, counted from the upper left; each dot of a path is doubled in both directions.
    pub(super) fn lit(&self) -> impl Iterator<Item = (usize, usize, Ink)> {
        let cells = self.cells.iter().enumerate();
        let cells = cells.filter(|(_, (bits, _))| *bits != 0);
        cells
            .flat_map(move |(n, &(bits, ink))| {
                let (left, top) = (n % self.columns * 2, n / self.columns * 4);
                let dots = (0..8).filter(move |dot| bits >> dot & 1 == 1);
                dots.flat_map(move |dot| {
                    let (x, y) = (left + dot % 2, top + dot / 2);
                    let more = usize::from(ink >= Ink::Draft);
                    (x..=x + more).flat_map(move |x| (y..=y + more).map(move |y| (x, y, ink)))
                })
            })
            .filter(|(x, _, _)| *x < 2 * self.columns)
    }

    /// Draws the picture.
    pub(super) fn draw(&self, buffer: &mut Buffer, area: Rect, theme: &Theme) {
        let places = area.positions();
        for (place, &(bits, ink)) in places.zip(&self.cells) {
            if bits == 0 {
                continue;
            }
            if let Some(cell) = buffer.cell_mut(place) {
                let symbol = match theme.marker {
                    _ if theme.glyphs.ascii => ink.ascii(),
                    Marker::Octant => OCTANTS[usize::from(bits)],
                    Marker::Braille => BRAILLE[usize::from(bits)],
                    Marker::Quadrant => QUADRANTS[usize::from(quarters(bits))],
                };
                cell.set_char(symbol).set_style(ink.style(theme));
            }
        }
    }
}

/// The quarters of a cell that have dots.
const fn quarters(bits: u8) -> u8 {
    let (upper, lower) = (bits | bits >> 2, bits >> 4 | bits >> 6);
    upper & 0b11 | (lower & 0b11) << 2
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::model::Config;

    #[test]
    fn a_line_from_far_outside_to_far_outside_is_seen_in_between() {
        let area = Rect::new(0, 0, 4, 2);
        let mut raster = Raster::new(area);
        raster.line((-1e6, 3.0), (1e6, 3.0), 1, Ink::Wall);
        let lit = |cells: &[(u8, Ink)]| cells.iter().map(|(bits, _)| *bits).collect::<Vec<_>>();
        assert_eq!(lit(&raster.cells), [0xC0, 0xC0, 0xC0, 0xC0, 0, 0, 0, 0]);
    }

    proptest! {
        /// Filling a rectangle sets the dots that its rows of lines set.
        #[test]
        fn a_block_is_its_lines(
            a in (-9..20_i32, -9..20_i32), b in (-9..20_i32, -9..20_i32)
        ) {
            let area = Rect::new(0, 0, 5, 3);
            let (mut block, mut lines) = (Raster::new(area), Raster::new(area));
            let point = |(x, y): (i32, i32)| (f64::from(x), f64::from(y));
            block.block(point(a), point(b), Ink::Wall);
            for y in a.1.min(b.1)..=a.1.max(b.1) {
                for x in a.0.min(b.0)..=a.0.max(b.0) {
                    lines.dot(f64::from(x), f64::from(y), Ink::Wall);
                }
            }
            prop_assert_eq!(block.cells, lines.cells);
        }
    }

    #[test]
    fn every_marker_draws_the_same_dots() {
        let area = Rect::new(0, 0, 1, 1);
        let mut raster = Raster::new(area);
        raster.line((0.0, 0.0), (0.0, 3.0), 1, Ink::Trail);
        raster.dot(1.0, 3.0, Ink::Trail);
        for (marker, symbol) in [
            (Marker::Braille, '⣇'),
            (Marker::Octant, '\u{1CDC0}'),
            (Marker::Quadrant, '▙'),
        ] {
            let config = Config {
                marker,
                ..Config::default()
            };
            let mut buffer = Buffer::empty(area);
            raster.draw(&mut buffer, area, &Theme::of(&config));
            assert_eq!(buffer[(0, 0)].symbol(), symbol.to_string());
        }
    }

    #[test]
    fn nothing_outside_is_drawn() {
        let mut raster = Raster::new(Rect::new(0, 0, 4, 2));
        raster.line((-5.0, -5.0), (-1.0, 20.0), 1, Ink::Wall);
        raster.dot(f64::NAN, 1.0, Ink::Wall);
        raster.line((f64::NAN, 0.0), (3.0, 3.0), 1, Ink::Wall);
        raster.dot(8.0, 0.0, Ink::Wall);
        assert!(raster.cells.iter().all(|(bits, _)| *bits == 0));
    }
}
