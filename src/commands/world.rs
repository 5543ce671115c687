//! `world`: lists, checks and draws worlds.

use sr04_sim::World;

use super::cli;
use super::output::write_file;
use super::{Exit, Fault, say, show};

pub(super) fn run(options: &cli::World) -> Result<(), Fault> {
    let Some(name) = &options.world else {
        return show(list());
    };
    let bad = |error| Fault::new(Exit::Usage, error);
    if options.text {
        return show(World::source(name).map_err(bad)?);
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
        Some(path) => write_file(path, &world.svg(), options.force),
        None => show(described(&world)),
    }
}

fn list() -> String {
    World::built_in_names()
        .filter_map(|name| Some((name, World::built_in(name)?)))
        .map(|(name, world)| format!("{name:12}  {}\n", world.about()))
        .chain(["generated:7   A house generated from seed 7, or any other\n".to_owned()])
        .collect()
}

fn described(world: &World) -> String {
    let [width, height] = world.size_in();
    format!(
        "{}: {}\n{:.0} by {:.0} ft; the robot can reach {:.0} % of the free floor\n\n{}",
        world.name(),
        world.about(),
        width / 12.0,
        height / 12.0,
        world.reach() * 100.0,
        world.picture()
    )
}
