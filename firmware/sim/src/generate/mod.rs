//! Houses generated from a seed: rooms, doors and furniture, as the text of a world.

mod furnish;

use std::fmt::Write as _;

use crate::rng::{Rng, Stream};
use crate::world::World;

const CELL_IN: usize = 6;
/// Number of cells kept free on either side of a doorway, except in a crowded house.
const APPROACH: usize = 6;
/// Minimum share of a crowded house's floor that the robot can reach.
const REACH_LEAST: f64 = 0.9;
/// Number of attempts at a crowded house after which each room gets a piece less.
const ATTEMPTS_EACH: usize = 8;
/// Maximum number of houses drawn until one has no warnings; the first nearly always has none.
const ATTEMPTS: u64 = 100;

impl World {
    /// A house generated from a seed: four or six rooms with furniture, clutter, lamps, a cat and a dock. The robot can
    /// reach every room from its start. The same seed gives the same house on every platform.
    #[must_use]
    pub fn generated(seed: u64) -> Self {
        let text = Self::generated_text(seed);
        // `generated_text` returns only texts that parse.
        Self::parse(&format!("generated:{seed}"), &text).unwrap_or_default()
    }

    /// A house like [`World::generated`], but without the spaces that a tidy house keeps: furniture and clutter stand
    /// against each other and before doorways, and a stairwell without a banister is open in one room.
    #[must_use]
    pub fn crowded(seed: u64) -> Self {
        Self::parse(&format!("crowded:{seed}"), &Self::crowded_text(seed)).unwrap_or_default()
    }

    /// The house of [`World::crowded`] as the text of a world file.
    #[must_use]
    pub fn crowded_text(seed: u64) -> String {
        text(seed, &format!("crowded:{seed}"), true)
    }

    /// The house of [`World::generated`] as the text of a world file.
    #[must_use]
    pub fn generated_text(seed: u64) -> String {
        text(seed, &format!("generated:{seed}"), false)
    }
}

/// The first house drawn from a seed that has a dock and no warnings. Crowded houses may have corners that the robot cannot
/// reach.
fn text(seed: u64, name: &str, is_crowded: bool) -> String {
    (0..ATTEMPTS)
        .map(|attempt| House::draw(seed, attempt, is_crowded).text(name))
        .find(|text| {
            World::parse(name, text).is_ok_and(|world| {
                let mut warnings = world.warnings(name).into_iter();
                world.dock.is_some()
                    && if is_crowded {
                        world.reach() > REACH_LEAST && !warnings.any(|one| one.contains("dock"))
                    } else {
                        warnings.next().is_none()
                    }
            })
        })
        .unwrap_or_else(|| BARE.replace("NAME", name))
}

/// The house of a seed whose every attempt has warnings.
const BARE: &str = "name = \"NAME\"\ncell_in = 6\nplan = '''\n########\n#......#\n#......#\n#..^...#\n\
                    #......#\n#......#\n########\n'''\n";

/// A rectangle of cells; `east` and `south` are exclusive.
#[derive(Clone, Copy)]
struct Cells {
    west: usize,
    north: usize,
    east: usize,
    south: usize,
}

impl Cells {
    /// The rectangle with `by` more cells on each side.
    fn grown(self, by: usize) -> Self {
        Self {
            west: self.west.saturating_sub(by),
            north: self.north.saturating_sub(by),
            east: self.east + by,
            south: self.south + by,
        }
    }
}

/// A house being generated.
struct House {
    rng: Rng,
    columns: usize,
    rows: usize,
    glyphs: Vec<char>,
    /// Cells where no more objects may be placed.
    reserved: Vec<bool>,
    rooms: Vec<Cells>,
    entries: String,
    is_crowded: bool,
    /// Number of pieces, and of clutter, by which each room has less than drawn: where everything may stand in the way, most houses are
    /// closed off, so the later attempts at a crowded house have less furniture.
    fewer: usize,
}

impl House {
    fn draw(seed: u64, attempt: u64, is_crowded: bool) -> Self {
        let mut rng = Rng::new(seed ^ attempt.rotate_left(32), Stream::House);
        let widths: Vec<usize> = (0..2 + pick(&mut rng, 2))
            .map(|_| 21 + pick(&mut rng, 10))
            .collect();
        let heights: Vec<usize> = (0..2).map(|_| 20 + pick(&mut rng, 8)).collect();
        let columns = widths.iter().sum::<usize>() + widths.len() + 1;
        let rows = heights.iter().sum::<usize>() + heights.len() + 1;
        let mut house = Self {
            rng,
            columns,
            rows,
            glyphs: vec!['#'; columns * rows],
            reserved: vec![false; columns * rows],
            rooms: Vec::new(),
            entries: String::new(),
            is_crowded,
            fewer: if is_crowded {
                attempt as usize / ATTEMPTS_EACH
            } else {
                0
            },
        };
        let mut north = 1;
        for height in &heights {
            let mut west = 1;
            for width in &widths {
                let room = Cells {
                    west,
                    north,
                    east: west + width,
                    south: north + height,
                };
                house.fill(room, '.');
                house.rooms.push(room);
                west += width + 1;
            }
            north += height + 1;
        }
        house.doors(widths.len());
        house.windows();
        house.start();
        house.dock();
        house.cat();
        if is_crowded {
            house.stairwell();
        }
        for room in house.rooms.clone() {
            house.furnish(room);
        }
        house
    }

    fn fill(&mut self, cells: Cells, glyph: char) {
        for row in cells.north..cells.south {
            for column in cells.west..cells.east {
                self.glyphs[row * self.columns + column] = glyph;
            }
        }
    }

    fn reserve(&mut self, cells: Cells) {
        for row in cells.north..cells.south.min(self.rows) {
            for column in cells.west..cells.east.min(self.columns) {
                self.reserved[row * self.columns + column] = true;
            }
        }
    }

    fn is_free(&self, cells: Cells) -> bool {
        (cells.north..cells.south.min(self.rows)).all(|row| {
            (cells.west..cells.east.min(self.columns))
                .all(|column| !self.reserved[row * self.columns + column])
        })
    }

    /// Adds doors until every room is connected, and most of the others to give alternative routes.
    fn doors(&mut self, across: usize) {
        let mut joined: Vec<usize> = (0..self.rooms.len()).collect();
        let mut walls: Vec<(usize, usize)> = (0..self.rooms.len())
            .flat_map(|room| [(room, room + 1), (room, room + across)])
            .filter(|&(one, other)| {
                other < self.rooms.len() && (other != one + 1 || other % across != 0)
            })
            .collect();
        for last in (1..walls.len()).rev() {
            let other = pick(&mut self.rng, last + 1);
            walls.swap(last, other);
        }
        for (one, other) in walls {
            let (from, to) = (joined[one], joined[other]);
            if from == to && self.rng.chance(0.4) {
                continue;
            }
            for group in &mut joined {
                if *group == from {
                    *group = to;
                }
            }
            self.door(self.rooms[one], self.rooms[other]);
        }
    }

    /// Adds a doorway of 24 to 36 inches between neighbouring rooms and, in a tidy house, keeps its approaches free.
    fn door(&mut self, one: Cells, other: Cells) {
        let width = 4 + pick(&mut self.rng, 3);
        let depth = if self.is_crowded { 0 } else { APPROACH };
        let (gap, approach) = if one.south == other.south {
            let north = one.north + 2 + pick(&mut self.rng, one.south - one.north - width - 3);
            let gap = Cells {
                west: one.east,
                north,
                east: other.west,
                south: north + width,
            };
            (
                gap,
                Cells {
                    west: gap.west - depth,
                    east: gap.east + depth,
                    ..gap
                },
            )
        } else {
            let west = one.west + 2 + pick(&mut self.rng, one.east - one.west - width - 3);
            let gap = Cells {
                west,
                north: one.south,
                east: west + width,
                south: other.north,
            };
            (
                gap,
                Cells {
                    north: gap.north - depth,
                    south: gap.south + depth,
                    ..gap
                },
            )
        };
        self.fill(gap, '.');
        self.reserve(approach);
        if self.rng.chance(0.3) {
            let (x, y) = self.middle(gap);
            let size = if one.south == other.south {
                format!("[3, {}]", width * CELL_IN)
            } else {
                format!("[{}, 3]", width * CELL_IN)
            };
            self.add(&format!(
                "[[ground]]\nkind = \"sill\"\nat = [{x}, {y}]\nsize_in = {size}\n"
            ));
        }
    }

    /// Adds windows to the outer walls.
    fn windows(&mut self) {
        for room in self.rooms.clone() {
            let west = room.west + 3 + pick(&mut self.rng, 6);
            let row = if room.north == 1 { 0 } else { self.rows - 1 };
            if self.rng.chance(0.7) {
                self.fill(
                    Cells {
                        west,
                        north: row,
                        east: west + 8,
                        south: row + 1,
                    },
                    '=',
                );
            }
        }
    }

    /// Centre of a rectangle in inches from the south-west corner.
    fn middle(&self, cells: Cells) -> (usize, usize) {
        let x = (cells.west + cells.east) * CELL_IN / 2;
        let y = (2 * self.rows - cells.north - cells.south) * CELL_IN / 2;
        (x, y)
    }

    fn add(&mut self, entry: &str) {
        self.entries.push('\n');
        self.entries.push_str(entry);
    }

    fn text(&self, name: &str) -> String {
        let mut text = format!(
            "name = \"{name}\"\nabout = \"A house of {} rooms made from a seed\"\ncell_in = {CELL_IN}\n\
             daylight_lux = 10\n\nplan = '''\n",
            self.rooms.len()
        );
        for row in self.glyphs.chunks(self.columns) {
            let row: String = row.iter().collect();
            let _ = writeln!(text, "{row}");
        }
        text.push_str("'''\n");
        text.push_str(&self.entries);
        text
    }
}

/// Uniform from 0 up to but not including `count`.
fn pick(rng: &mut Rng, count: usize) -> usize {
    ((u64::from(rng.next_u32()) * count as u64) >> 32) as usize
}
