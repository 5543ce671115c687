//! `world`: lists, checks and draws worlds.

use std::io::{self, Write};
use std::path::Path;

use sr04_sim::World;

use super::cli;
use super::output::write_file;
use super::simulated::bad_world;
use super::{Exit, Fault, out, say, show, show_line};

pub(super) fn run(options: &cli::World) -> Result<(), Fault> {
    let Some(name) = &options.world else {
        return show(list());
    };
    let bad = |error| bad_world(&error);
    if options.text {
        let source = World::source(name).map_err(bad)?;
        return source.lines().try_for_each(show_line);
    }
    let world = World::open(name).map_err(bad)?;
    let warnings = world.warnings(name);
    for warning in &warnings {
        say(format_args!("{warning}"));
    }
    if options.check {
        let count = warnings.len();
        let message = format!("{name}: {count} warnings; the world can be simulated");
        return match count {
            0 => Ok(()),
            _ => Err(Fault::new(Exit::Failed, message)),
        };
    }
    match &options.svg {
        Some(path) => write_file(path, &world.svg(), options.force, &[Path::new(name)]),
        None => describe(&world).or_else(|error| Fault::output(&error)),
    }
}

fn list() -> String {
    World::built_in_names()
        .filter_map(|name| Some((name, World::built_in(name)?)))
        .map(|(name, world)| format!("{name:12}  {}\n", world.about()))
        .chain(["generated:7   A house generated from seed 7, or any other\n".to_owned()])
        .collect()
}

fn describe(world: &World) -> io::Result<()> {
    let mut out = out();
    let [width, height] = world.size_in();
    writeln!(out, "{}: {}", world.name(), world.about())?;
    writeln!(
        out,
        "{:.0} by {:.0} ft; the robot can reach {:.0} % of the free floor",
        width / 12.0,
        height / 12.0,
        world.reach() * 100.0
    )?;
    writeln!(out)?;
    out.write_all(world.picture().as_bytes())?;
    out.flush()
}
