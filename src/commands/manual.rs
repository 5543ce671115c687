//! `completions` and `man`: what shells and `man` read, from the command line's own definitions.

use std::fs;
use std::io::{self, Write as _};
use std::path::Path;

use clap::{Command, CommandFactory as _};

use super::cli::{Cli, Completions, Man};
use super::{Exit, Fault};

const NAME: &str = "groundwave";

pub(super) fn completions(options: &Completions) -> Result<(), Fault> {
    let mut script = Vec::new();
    clap_complete::generate(options.shell, &mut Cli::command(), NAME, &mut script);
    show(&script)
}

pub(super) fn pages(options: &Man) -> Result<(), Fault> {
    let command = Cli::command();
    let Some(folder) = &options.dir else {
        return show(&page(command)?.1);
    };
    let failed = |path: &Path, error| {
        Fault::new(
            Exit::Failed,
            format!("cannot write {}: {error}", path.display()),
        )
    };
    fs::create_dir_all(folder).map_err(|error| failed(folder, error))?;
    for command in std::iter::once(command.clone()).chain(verbs(&command)) {
        let (name, text) = page(command)?;
        let path = folder.join(name);
        fs::write(&path, text).map_err(|error| failed(&path, error))?;
    }
    Ok(())
}

/// The verbs, called as their pages are: `groundwave-watch`.
fn verbs(command: &Command) -> impl Iterator<Item = Command> {
    command.get_subcommands().map(|verb| {
        let name = format!("{NAME}-{}", verb.get_name());
        let usage = format!("{NAME} {}", verb.get_name());
        verb.clone()
            .display_name(name)
            .bin_name(usage)
            .version(env!("CARGO_PKG_VERSION"))
    })
}

/// A page's file name and text.
fn page(command: Command) -> Result<(String, Vec<u8>), Fault> {
    let man =
        clap_mangen::Man::new(command).source(format!("{NAME} {}", env!("CARGO_PKG_VERSION")));
    let mut text = Vec::new();
    man.render(&mut text)
        .map_err(|error| Fault::new(Exit::Failed, error))?;
    Ok((man.get_filename(), text))
}

fn show(text: &[u8]) -> Result<(), Fault> {
    let mut out = io::stdout().lock();
    out.write_all(text)
        .and_then(|()| out.flush())
        .or_else(|error| Fault::output(&error))
}
