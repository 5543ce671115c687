//! The floor plan: characters to cells, cells to rectangles and outlines.

use std::ops::Range;

use super::drops::Drops;
use super::error::{Source, WorldError};
use super::grid::{Grid, Layout};
use super::material::Material;
use super::outline::{Outline, OutlineKind, Point};
use crate::geometry::{Pose, Solid, Vec2};

/// Maximum number of rows and columns.
const CELLS_MAX: usize = 1000;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Cell {
    Outside,
    Floor,
    /// No floor: a stair going down.
    Drop,
    Solid(Material),
}

/// A checked floor plan: the floor that the robot can reach is enclosed on every side.
pub(super) struct Plan {
    layout: Layout,
    /// Cells by row, north row first.
    cells: Vec<Cell>,
    glyphs: Vec<char>,
    /// Offset of the north row in the file.
    offset: usize,
    marks: Vec<(char, Vec2)>,
    pub(super) start: Pose,
    /// Offset of the start in the file.
    pub(super) start_offset: usize,
}

/// One row of the plan: its text and its offset in the file.
struct Row<'a> {
    offset: usize,
    text: &'a str,
}

impl Plan {
    /// Parses the rows between the quotes at `span`.
    pub(super) fn parse(
        source: &Source<'_>,
        span: Range<usize>,
        cell_in: f64,
    ) -> Result<Self, WorldError> {
        let rows = rows(source, span.clone())?;
        let columns = rows.first().map_or(0, |row| row.text.chars().count());
        let mut plan = Self {
            layout: Layout {
                cell_in,
                columns,
                rows: rows.len(),
            },
            cells: Vec::with_capacity(columns * rows.len()),
            glyphs: Vec::with_capacity(columns * rows.len()),
            offset: rows.first().map_or(span.start, |row| row.offset),
            marks: Vec::new(),
            start: Pose::default(),
            start_offset: span.start,
        };
        let mut start = None;
        for (index, row) in rows.iter().enumerate() {
            plan.check_width(source, &rows, index)?;
            for (column, (at, character)) in row.text.char_indices().enumerate() {
                let offset = row.offset + at;
                let cell = match character {
                    ' ' => Cell::Outside,
                    '.' => Cell::Floor,
                    '~' => Cell::Drop,
                    'A'..='Z' => {
                        plan.add_mark(source, offset, character, index, column)?;
                        Cell::Floor
                    }
                    '^' | '>' | 'v' | '<' => {
                        if start.replace((index, column, offset, character)).is_some() {
                            return Err(source.error(
                                offset,
                                "second start: keep only one of ^ > v <, which shows the robot's heading",
                            ));
                        }
                        Cell::Floor
                    }
                    _ => Cell::Solid(Material::from_char(character).ok_or_else(|| {
                        source.error(
                            offset,
                            format!(
                                "unknown character {character:?} in the floor plan: use . floor, ~ no floor, # wall, \
                                 = glass, w wood, s soft, k dark, o low, ^ > v < start, A to Z a mark, \
                                 space outside"
                            ),
                        )
                    })?),
                };
                plan.cells.push(cell);
                plan.glyphs.push(character);
            }
        }
        let Some((row, column, offset, character)) = start else {
            return Err(source.error(
                span.start,
                "the plan has no start: put one of ^ > v < on a floor cell to show the robot's heading",
            ));
        };
        let center = plan.layout.center(row, column);
        plan.start = Pose {
            x_in: center.x,
            y_in: center.y,
            theta_deg: match character {
                '^' => 0.0,
                '>' => 90.0,
                'v' => 180.0,
                _ => -90.0,
            },
        };
        plan.start_offset = offset;
        plan.check_closed(source, &rows, (row, column))?;
        Ok(plan)
    }

    fn check_width(
        &self,
        source: &Source<'_>,
        rows: &[Row<'_>],
        index: usize,
    ) -> Result<(), WorldError> {
        let row = &rows[index];
        let width = row.text.chars().count();
        if width == self.layout.columns {
            return Ok(());
        }
        let end = row.offset + row.text.len();
        Err(source.error(
            end,
            format!(
                "this row has {width} cells and the first row {}: make all rows equally long, \
                 with # or, outside, with spaces",
                self.layout.columns
            ),
        ))
    }

    fn add_mark(
        &mut self,
        source: &Source<'_>,
        offset: usize,
        mark: char,
        row: usize,
        column: usize,
    ) -> Result<(), WorldError> {
        if self.mark(mark).is_some() {
            return Err(source.error(
                offset,
                format!("mark {mark} is already used: choose another letter from A to Z"),
            ));
        }
        let center = self.layout.center(row, column);
        self.marks.push((mark, center));
        Ok(())
    }

    /// Checks by flood fill from the start that the floor is enclosed: it must not reach the plan's edge or the outside.
    /// A drop ends the fill.
    fn check_closed(
        &self,
        source: &Source<'_>,
        rows: &[Row<'_>],
        start: (usize, usize),
    ) -> Result<(), WorldError> {
        let mut seen = vec![false; self.cells.len()];
        let mut open = vec![start];
        while let Some((row, column)) = open.pop() {
            let index = self.layout.index(row, column);
            match self.cells[index] {
                Cell::Solid(_) | Cell::Drop => continue,
                Cell::Floor if seen[index] => continue,
                Cell::Floor => seen[index] = true,
                Cell::Outside => {
                    return Err(leak(
                        source,
                        rows,
                        row,
                        column,
                        "the floor is open to the outside here",
                    ));
                }
            }
            if row == 0
                || column == 0
                || row + 1 == self.layout.rows
                || column + 1 == self.layout.columns
            {
                return Err(leak(
                    source,
                    rows,
                    row,
                    column,
                    "the floor reaches the edge of the plan here",
                ));
            }
            open.extend([
                (row - 1, column),
                (row + 1, column),
                (row, column - 1),
                (row, column + 1),
            ]);
        }
        Ok(())
    }

    pub(super) fn mark(&self, mark: char) -> Option<Vec2> {
        self.marks
            .iter()
            .find(|(letter, _)| *letter == mark)
            .map(|(_, center)| *center)
    }

    pub(super) fn size(&self) -> Vec2 {
        Vec2::new(self.layout.columns as f64, self.layout.rows as f64) * self.layout.cell_in
    }

    fn cell(&self, row: usize, column: usize) -> Cell {
        self.cells[self.layout.index(row, column)]
    }

    /// The plan as drawn.
    pub(super) fn grid(&self, source: &Source<'_>) -> Grid {
        Grid {
            layout: self.layout,
            glyphs: self.glyphs.clone(),
            first_line: source.line(self.offset),
        }
    }

    /// The cells without floor.
    pub(super) fn drops(&self) -> Drops {
        let is_drop = |cell: &Cell| *cell == Cell::Drop;
        if !self.cells.iter().any(is_drop) {
            return Drops::default();
        }
        Drops {
            layout: self.layout,
            cells: self.cells.iter().map(is_drop).collect(),
        }
    }

    /// The solid cells as rectangles: runs along a row, extended down while the next rows have the same run.
    pub(super) fn solids(&self) -> Vec<(Solid, Material)> {
        let mut done = vec![false; self.cells.len()];
        let mut solids = Vec::new();
        for row in 0..self.layout.rows {
            for column in 0..self.layout.columns {
                let Cell::Solid(material) = self.cell(row, column) else {
                    continue;
                };
                let free = |row: usize, column: usize, done: &[bool]| {
                    self.cell(row, column) == Cell::Solid(material)
                        && !done[self.layout.index(row, column)]
                };
                if !free(row, column, &done) {
                    continue;
                }
                let mut end = column + 1;
                while end < self.layout.columns && free(row, end, &done) {
                    end += 1;
                }
                let mut bottom = row + 1;
                while bottom < self.layout.rows && (column..end).all(|at| free(bottom, at, &done)) {
                    bottom += 1;
                }
                for covered in row..bottom {
                    done[self.layout.index(covered, column)..self.layout.index(covered, end)]
                        .fill(true);
                }
                let west = column as f64 * self.layout.cell_in;
                let north = (self.layout.rows - row) as f64 * self.layout.cell_in;
                let size =
                    Vec2::new((end - column) as f64, (bottom - row) as f64) * self.layout.cell_in;
                let center = Vec2::new(west + size.x / 2.0, north - size.y / 2.0);
                solids.push((Solid::block(center, size, 0.0), material));
            }
        }
        solids
    }

    /// The walls as filled outlines.
    pub(super) fn walls(&self) -> impl Iterator<Item = Outline> {
        let walls = self.solids().into_iter();
        let walls = walls.filter(|(_, material)| OutlineKind::of(*material) == OutlineKind::Wall);
        walls.filter_map(|(solid, _)| match solid {
            Solid::Block { place, cuboid } => {
                let half = cuboid.half_extents;
                Some(Outline::Block {
                    from: place.transform_point(Vec2::new(-half.x, -half.y)).into(),
                    to: place.transform_point(Vec2::new(half.x, half.y)).into(),
                })
            }
            Solid::Round { .. } => None,
        })
    }

    /// The edges of walls on both sides, and of other solid cells towards the floor, joined into long lines, in plan
    /// coordinates.
    pub(super) fn outlines(&self) -> Vec<Outline> {
        let mut outlines = Vec::new();
        let at = |row: usize, column: usize| Point {
            x_in: column as f64 * self.layout.cell_in,
            y_in: (self.layout.rows - row) as f64 * self.layout.cell_in,
        };
        let cell = |row: Option<usize>, column: Option<usize>| match (row, column) {
            (Some(row), Some(column)) if row < self.layout.rows && column < self.layout.columns => {
                self.cell(row, column)
            }
            _ => Cell::Outside,
        };
        for row in 0..=self.layout.rows {
            let edge = |column| {
                let north = cell(row.checked_sub(1), Some(column));
                edge_kind(north, cell(Some(row), Some(column)))
            };
            runs(self.layout.columns, edge, |from, to, kind| {
                outlines.push(Outline::Segment {
                    from: at(row, from),
                    to: at(row, to),
                    kind,
                });
            });
        }
        for column in 0..=self.layout.columns {
            let edge = |row| {
                let west = cell(Some(row), column.checked_sub(1));
                edge_kind(west, cell(Some(row), Some(column)))
            };
            runs(self.layout.rows, edge, |from, to, kind| {
                outlines.push(Outline::Segment {
                    from: at(from, column),
                    to: at(to, column),
                    kind,
                });
            });
        }
        outlines
    }
}

/// Calls `found` with every maximal run of one kind.
fn runs(
    count: usize,
    kind_at: impl Fn(usize) -> Option<OutlineKind>,
    mut found: impl FnMut(usize, usize, OutlineKind),
) {
    let mut from = 0;
    while from < count {
        let kind = kind_at(from);
        let mut to = from + 1;
        while to < count && kind_at(to) == kind {
            to += 1;
        }
        if let Some(kind) = kind {
            found(from, to, kind);
        }
        from = to;
    }
}

fn edge_kind(one: Cell, other: Cell) -> Option<OutlineKind> {
    let is_wall = |cell| matches!(cell, Cell::Solid(material) if OutlineKind::of(material) == OutlineKind::Wall);
    match (one, other) {
        _ if is_wall(one) != is_wall(other) => Some(OutlineKind::Wall),
        (Cell::Floor, Cell::Solid(material)) | (Cell::Solid(material), Cell::Floor) => {
            Some(OutlineKind::of(material))
        }
        (Cell::Floor, Cell::Drop) | (Cell::Drop, Cell::Floor) => Some(OutlineKind::Edge),
        _ => None,
    }
}

fn leak(
    source: &Source<'_>,
    rows: &[Row<'_>],
    row: usize,
    column: usize,
    problem: &str,
) -> WorldError {
    let row = &rows[row];
    let at = row
        .text
        .char_indices()
        .nth(column)
        .map_or(row.text.len(), |(at, _)| at);
    source.error(
        row.offset + at,
        format!("{problem}: close it with #, or the robot could leave the house"),
    )
}

fn rows<'a>(source: &Source<'a>, span: Range<usize>) -> Result<Vec<Row<'a>>, WorldError> {
    let raw = source.text.get(span.clone()).unwrap_or_default();
    let quote = raw
        .get(..3)
        .filter(|quote| *quote == "'''" || *quote == "\"\"\"");
    let Some(body) = quote.and_then(|quote| raw[3..].strip_suffix(quote)) else {
        return Err(source.error(
            span.start,
            "write the rows of the plan between two lines of '''",
        ));
    };
    let mut offset = span.start + 3;
    let mut rows = Vec::new();
    for line in body.split_inclusive('\n') {
        let text = line.trim_end_matches(['\r', '\n']);
        rows.push(Row { offset, text });
        offset += line.len();
    }
    if rows.first().is_some_and(|row| row.text.is_empty()) {
        rows.remove(0);
    }
    if rows.is_empty() || rows.len() > CELLS_MAX || rows[0].text.len() > CELLS_MAX {
        return Err(source.error(
            span.start,
            format!("the plan must have 1 to {CELLS_MAX} rows of at most {CELLS_MAX} cells"),
        ));
    }
    Ok(rows)
}
