//! A world as a picture of text characters.

use std::fmt::Write as _;

use super::World;
use super::ground::GroundKind;
use super::material::Material;
use crate::geometry::{Solid, Vec2};

/// Meaning of the characters, in the order of the legend.
const LEGEND: &[(char, &str)] = &[
    ('#', "wall"),
    ('=', "glass"),
    ('w', "wood"),
    ('s', "soft"),
    ('k', "dark"),
    ('o', "low: only the bumper detects it"),
    ('i', "leg"),
    ('x', "black leg or caster"),
    ('f', "feet of a sitting person"),
    ('-', "cord"),
    ('~', "no floor"),
    (',', "carpet"),
    ('_', "sill"),
    ('/', "incline"),
    ('d', "dock"),
    ('*', "lamp"),
    ('+', "lamp, switched off"),
    ('p', "path of a person or cat"),
    ('^', "start"),
    ('>', "start"),
    ('v', "start"),
    ('<', "start"),
];

impl World {
    /// The world from above, north up, one character per cell, followed by a legend.
    #[must_use]
    pub fn picture(&self) -> String {
        let grid = &self.grid;
        let mut cells = grid.glyphs.clone();
        let mut paint = |glyph: char, is_there: &dyn Fn(Vec2) -> bool| {
            for (index, cell) in cells.iter_mut().enumerate() {
                let center = grid
                    .layout
                    .center(index / grid.layout.columns, index % grid.layout.columns);
                if *cell != '#' && is_there(center) {
                    *cell = glyph;
                }
            }
        };
        for ground in &self.grounds {
            let glyph = match ground.kind {
                GroundKind::Sill => '_',
                GroundKind::Carpet => ',',
                GroundKind::Ramp => '/',
            };
            paint(glyph, &|center| {
                covers(&ground.solid, center, grid.layout.cell_in)
            });
        }
        for snag in &self.snags {
            paint('-', &|center| {
                covers(&snag.solid, center, grid.layout.cell_in)
            });
        }
        for obstacle in self.obstacles.iter().skip(self.plan_solids) {
            let glyph = glyph(obstacle.material);
            paint(glyph, &|center| {
                covers(&obstacle.solid, center, grid.layout.cell_in)
            });
        }
        let mut put = |glyph: char, place: Vec2| {
            if let Some((row, column)) = grid.layout.cell_at(place) {
                cells[row * grid.layout.columns + column] = glyph;
            }
        };
        for place in self.walkers.iter().flat_map(|walker| &walker.path) {
            put('p', *place);
        }
        for lamp in &self.lamps {
            put(if lamp.on { '*' } else { '+' }, lamp.center);
        }
        let start = Vec2::new(self.start.x_in, self.start.y_in);
        if let Some((row, column)) = grid.layout.cell_at(start) {
            put(grid.glyph(row, column), start);
        }
        let mut picture = String::new();
        for row in cells.chunks(grid.layout.columns) {
            picture.extend(row);
            picture.truncate(picture.trim_end_matches(' ').len());
            picture.push('\n');
        }
        let _ = writeln!(picture, "\n  {} inches per character", grid.layout.cell_in);
        for (glyph, meaning) in LEGEND {
            if cells.contains(glyph) {
                let _ = writeln!(picture, "  {glyph} {meaning}");
            }
        }
        picture + &self.marks(&cells)
    }

    /// Legend lines for the plan's marks: visible ones, and ones covered by an object.
    fn marks(&self, cells: &[char]) -> String {
        let marks = self.grid.glyphs.iter().zip(cells);
        let marks = marks.filter(|(mark, _)| mark.is_ascii_uppercase());
        let (seen, covered): (Vec<_>, Vec<_>) = marks.partition(|(mark, cell)| mark == cell);
        let mut text = String::new();
        if !seen.is_empty() {
            text += "  A to Z marks of the plan\n";
        }
        if !covered.is_empty() {
            let covered: Vec<String> = covered
                .iter()
                .map(|(mark, cell)| format!("{mark} under {cell}"))
                .collect();
            let _ = writeln!(text, "  covered marks: {}", covered.join(", "));
        }
        text
    }
}

const fn glyph(material: Material) -> char {
    match material {
        Material::Wall => '#',
        Material::Glass => '=',
        Material::Wood => 'w',
        Material::Soft => 's',
        Material::Dark => 'k',
        Material::Low => 'o',
        Material::Leg => 'i',
        Material::DarkLeg => 'x',
        Material::Alive => 'f',
        Material::Dock => 'd',
    }
}

/// Whether a solid covers a cell's centre, or lies within the cell.
fn covers(solid: &Solid, center: Vec2, cell_in: f64) -> bool {
    let half = Vec2::splat(cell_in / 2.0);
    let is_inside = |point: Vec2| (point - center).abs().cmplt(half).all();
    match *solid {
        Solid::Round { center: middle, .. } if is_inside(middle) => true,
        _ => {
            solid.approach(center).0
                <= if is_thin(solid, cell_in) {
                    cell_in / 2.0
                } else {
                    0.0
                }
        }
    }
}

fn is_thin(solid: &Solid, cell_in: f64) -> bool {
    match solid {
        Solid::Block { cuboid, .. } => cuboid.half_extents.min_element() < cell_in / 2.0,
        Solid::Round { .. } => false,
    }
}
