//! Furnishing of a generated house.

use super::{Cells, House, pick};

/// Number of cells between pieces of furniture: 18 inches, so that the robot can pass.
const GAP: usize = 3;

impl House {
    /// Number of cells kept free around a piece.
    const fn gap(&self) -> usize {
        if self.is_crowded { 0 } else { GAP }
    }

    /// Places an open stairwell in a room, with floor all around it. Furniture may stand at its edge.
    pub(super) fn stairwell(&mut self) {
        for _ in 0..40 {
            let number = pick(&mut self.rng, self.rooms.len());
            let room = self.rooms[number];
            let (wide, tall) = (5 + pick(&mut self.rng, 4), 5 + pick(&mut self.rng, 4));
            let west = room.west + 3 + pick(&mut self.rng, room.east - room.west - wide - 5);
            let north = room.north + 3 + pick(&mut self.rng, room.south - room.north - tall - 5);
            let drop = Cells {
                west,
                north,
                east: west + wide,
                south: north + tall,
            };
            if self.is_free(drop) {
                self.fill(drop, '~');
                self.reserve(drop);
                return;
            }
        }
    }

    /// Places the robot's start in the middle of the first room and keeps 18 in free around it; in a crowded house only room to stand.
    pub(super) fn start(&mut self) {
        let room = self.rooms[0];
        let row = usize::midpoint(room.north, room.south);
        let column = usize::midpoint(room.west, room.east);
        let nose = ['^', '>', 'v', '<'][pick(&mut self.rng, 4)];
        let cell = Cells {
            west: column,
            north: row,
            east: column + 1,
            south: row + 1,
        };
        self.fill(cell, nose);
        self.reserve(cell.grown(if self.is_crowded { 1 } else { GAP }));
    }

    /// Places a dock at the outer wall of a room and keeps its beam free.
    pub(super) fn dock(&mut self) {
        let number = pick(&mut self.rng, self.rooms.len());
        let room = self.rooms[number];
        let faces_south = room.north == 1;
        for _ in 0..40 {
            let west = room.west + 2 + pick(&mut self.rng, room.east - room.west - 9);
            let beam = if faces_south {
                Cells {
                    west,
                    north: room.north,
                    east: west + 7,
                    south: room.north + 12,
                }
            } else {
                Cells {
                    west,
                    north: room.south - 12,
                    east: west + 7,
                    south: room.south,
                }
            };
            if !self.is_free(beam) {
                continue;
            }
            let row = if faces_south {
                room.north
            } else {
                room.south - 1
            };
            let cell = Cells {
                west: west + 3,
                north: row,
                east: west + 4,
                south: row + 1,
            };
            let (x, y) = self.middle(cell);
            let facing_deg = if faces_south { 180 } else { 0 };
            self.add(&format!(
                "[dock]\nat = [{x}, {y}]\nfacing_deg = {facing_deg}\n"
            ));
            self.reserve(beam);
            return;
        }
    }

    /// Adds a cat that walks across a room.
    pub(super) fn cat(&mut self) {
        let number = pick(&mut self.rng, self.rooms.len());
        let room = self.rooms[number];
        let row = usize::midpoint(room.north, room.south) + 2;
        let path = Cells {
            west: room.west + 4,
            north: row,
            east: room.east - 4,
            south: row + 1,
        };
        self.reserve(path.grown(1));
        let ends = [path.west, path.east - 1].map(|column| {
            let (x, y) = self.middle(Cells {
                west: column,
                north: row,
                east: column + 1,
                south: row + 1,
            });
            format!("[{x}, {y}]")
        });
        let pause_s = 20 + pick(&mut self.rng, 100);
        self.add(&format!(
            "[[walker]]\nkind = \"cat\"\npath = [{}, {}]\nspeed_in_s = 14\npause_s = {pause_s}\n",
            ends[0], ends[1]
        ));
    }

    /// Adds furniture along the walls where there is room, clutter and a lamp.
    pub(super) fn furnish(&mut self, room: Cells) {
        for _ in self.fewer..10 + pick(&mut self.rng, 10) {
            self.piece(room);
        }
        for _ in self.fewer..6 + pick(&mut self.rng, 10) {
            self.clutter(room);
        }
        if self.rng.chance(0.3) {
            let (x, y) = self.middle(room);
            self.add(&format!(
                "[[ground]]\nkind = \"carpet\"\nat = [{x}, {y}]\nsize_in = [72, 54]\n"
            ));
        }
        let (x, y) = self.middle(room);
        let candela = 40 + pick(&mut self.rng, 100);
        let on = self.rng.chance(0.8);
        let name = self.entries.matches("[[lamp]]").count() + 1;
        self.add(&format!(
            "[[lamp]]\nname = \"room {name}\"\nat = [{x}, {y}]\ncandela = {candela}\nheight_in = 84\non = {on}\n"
        ));
    }

    fn piece(&mut self, room: Cells) {
        let long = 5 + pick(&mut self.rng, 9);
        let deep = 3 + pick(&mut self.rng, 4);
        let glyph = ['w', 'w', 's', 'k', 'w'][pick(&mut self.rng, 5)];
        let along_x = pick(&mut self.rng, 2) == 0;
        let at_far_side = pick(&mut self.rng, 2) == 0;
        let (wide, tall) = if along_x { (long, deep) } else { (deep, long) };
        let (room_wide, room_tall) = (room.east - room.west, room.south - room.north);
        let room_along = if along_x {
            room_wide - wide
        } else {
            room_tall - tall
        };
        // A narrow gap between a piece and a corner is useless.
        let shift = match pick(&mut self.rng, room_along + 1) {
            shift if shift < self.gap() => 0,
            shift if shift + self.gap() > room_along => room_along,
            shift => shift,
        };
        let far = usize::from(at_far_side);
        let (west, north) = if along_x {
            (room.west + shift, room.north + far * (room_tall - tall))
        } else {
            (room.west + far * (room_wide - wide), room.north + shift)
        };
        let piece = Cells {
            west,
            north,
            east: west + wide,
            south: north + tall,
        };
        if self.is_free(piece) {
            self.fill(piece, glyph);
            self.reserve(piece.grown(self.gap()));
        }
    }

    fn clutter(&mut self, room: Cells) {
        // Kind, half of its size in cells, and further lines of its entry.
        const KINDS: [(&str, usize, &str); 9] = [
            ("chair", 2, ""),
            ("chair", 2, ""),
            ("table", 4, "size_in = [36, 24]\n"),
            ("low-table", 4, "size_in = [36, 20]\n"),
            ("office-chair", 3, ""),
            ("leg", 1, "radius_in = 4\nmade_of = \"soft\"\n"),
            ("box", 1, "size_in = [12, 8]\n"),
            ("shoe", 1, ""),
            ("cord", 2, "size_in = [36, 1]\n"),
        ];
        let (kind, half, rest) = KINDS[pick(&mut self.rng, KINDS.len())];
        let turned_deg = pick(&mut self.rng, 180);
        let margin = if self.is_crowded { half } else { half + 2 };
        let column = room.west + margin + pick(&mut self.rng, room.east - room.west - 2 * margin);
        let row = room.north + margin + pick(&mut self.rng, room.south - room.north - 2 * margin);
        let cell = Cells {
            west: column,
            north: row,
            east: column + 1,
            south: row + 1,
        };
        if self.is_free(cell.grown(half)) {
            let (x, y) = self.middle(cell);
            self.add(&format!(
                "[[clutter]]\nkind = \"{kind}\"\nat = [{x}, {y}]\nturned_deg = {turned_deg}\n{rest}"
            ));
            self.reserve(cell.grown(half + self.gap()));
        }
    }
}
