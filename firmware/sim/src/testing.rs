//! Rooms for unit tests.

use std::fmt::Write as _;

use crate::geometry::Vec2;
use crate::scene::Scene;
use crate::sensors::View;
use crate::world::World;

/// A square room of `cells` by `cells` 6-inch cells, walls included; `["box", material]` puts a box of 40 by 10 inches
/// in the middle.
pub(crate) fn room(cells: usize, object: &[&str]) -> Scene {
    Scene::new(&room_world(cells, object))
}

pub(crate) fn room_world(cells: usize, object: &[&str]) -> World {
    let wall = "#".repeat(cells);
    let floor = format!("#{}#", ".".repeat(cells - 2));
    let start = format!("#..^{}#", ".".repeat(cells - 5));
    let mut text = format!("name = \"room\"\ncell_in = 6\nplan = '''\n{wall}\n");
    for row in 1..cells - 1 {
        let line = if row == cells - 4 { &start } else { &floor };
        text.push_str(line);
        text.push('\n');
    }
    write!(text, "{wall}\n'''\n").expect("writing to a string cannot fail");
    if let [kind, material] = object {
        let middle = cells as f64 * 3.0;
        write!(
            text,
            "[[clutter]]\nkind = \"{kind}\"\nat = [{middle:?}, {middle:?}]\n\
             size_in = [40, 10]\nmade_of = \"{material}\"\n"
        )
        .expect("writing to a string cannot fail");
    }
    World::parse("room", &text).expect("the room is a valid world")
}

pub(crate) fn view_at(x_in: f64, y_in: f64, theta_deg: f64) -> View {
    View {
        center: Vec2::new(x_in, y_in),
        theta_rad: theta_deg.to_radians(),
    }
}

/// The scene of a world file's text.
pub(crate) fn scene(text: &str) -> Scene {
    Scene::new(&World::parse("test", text).expect("the text is a valid world"))
}

/// A room of ten by ten feet with no floor north of y = 120 and walls on the other sides.
pub(crate) fn landing() -> Scene {
    let drop = format!("#{}#\n", "~".repeat(20)).repeat(3);
    let floor = format!("#{}#\n", ".".repeat(20));
    let text = format!(
        "name = \"landing\"\ncell_in = 6\nplan = '''\n{drop}{}#.........^..........#\n{}{}\n'''\n",
        floor.repeat(9),
        floor.repeat(9),
        "#".repeat(22)
    );
    Scene::new(&World::parse("landing", &text).expect("the landing is a valid world"))
}

/// A room of twenty by twenty feet with a dock at (120, 12) facing north; `rest` is appended to the file.
pub(crate) fn docking(rest: &str) -> Scene {
    let row = format!("#{}#\n", ".".repeat(38));
    let wall = "#".repeat(40);
    scene(&format!(
        "name = \"docking\"\ncell_in = 6\nplan = '''\n{wall}\n{}#{}^{}#\n{}{wall}\n'''\n\
         [dock]\nat = [120, 12]\nfacing_deg = 0\n{rest}\n",
        row.repeat(8),
        ".".repeat(19),
        ".".repeat(18),
        row.repeat(29),
    ))
}
