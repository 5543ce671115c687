//! `man`: writes manual pages from the definitions of the command line and the keys.

use std::path::Path;
use std::{fs, io};

use clap::{Command, CommandFactory as _};
use clap_mangen::Man as Page;
use clap_mangen::roff::{Roff, bold, roman};

use super::cli::{Cli, Man};
use super::{Exit, Fault, show};
use crate::hint;
use crate::model::keys::Keymap;

pub(super) fn run(options: &Man) -> Result<(), Fault> {
    let mut command = Cli::command().disable_help_subcommand(true);
    command.build();
    let Some(folder) = &options.dir else {
        return show(&page(&command)?.1);
    };
    let failed = |path: &Path, error: io::Error| {
        Fault::new(
            Exit::Failed,
            format!(
                "cannot write {}: {}",
                path.display(),
                hint::of_writing(&error)
            ),
        )
    };
    fs::create_dir_all(folder).map_err(|error| failed(folder, error))?;
    for command in with_all_below(&command) {
        let (name, text) = page(command)?;
        let path = folder.join(name);
        fs::write(&path, text).map_err(|error| failed(&path, error))?;
    }
    Ok(())
}

/// A command with all its subcommands.
fn with_all_below(command: &Command) -> Vec<&Command> {
    let mut all = vec![command];
    all.extend(command.get_subcommands().flat_map(with_all_below));
    all
}

/// A page's file name and text.
fn page(command: &Command) -> Result<(String, Vec<u8>), Fault> {
    let is_whole = command.get_name() == "groundwave";
    let version = concat!("groundwave ", env!("CARGO_PKG_VERSION"));
    let man = Page::new(command.clone())
        .source(version)
        .manual("Groundwave");
    let mut text = Vec::new();
    let written = man
        .render_title(&mut text)
        .and_then(|()| man.render_name_section(&mut text))
        .and_then(|()| man.render_synopsis_section(&mut text))
        .and_then(|()| man.render_description_section(&mut text))
        .and_then(|()| man.render_options_section(&mut text));
    let written = if command.has_subcommands() {
        written.and_then(|()| man.render_subcommands_section(&mut text))
    } else {
        written
    };
    let mut roff = Roff::new();
    let after =
        (command.get_after_long_help().or(command.get_after_help())).map(ToString::to_string);
    after_options(&mut roff, &after.unwrap_or_default());
    if is_whole {
        keys(&mut roff);
    }
    exit_status(&mut roff);
    files(&mut roff);
    see_also(&mut roff, command);
    written
        .and_then(|()| roff.to_writer(&mut text))
        .map_err(|error| Fault::new(Exit::Failed, error))?;
    Ok((man.get_filename(), text))
}

/// Adds the text below the options. Examples get a separate section, indented rows keep their lines.
fn after_options(roff: &mut Roff, text: &str) {
    let blocks = text.split("\n\n").filter(|block| !block.is_empty());
    let (examples, notes): (Vec<&str>, Vec<&str>) =
        blocks.partition(|block| block.starts_with("Examples:"));
    // Exit codes have a separate section.
    let notes = notes
        .into_iter()
        .filter(|block| !block.starts_with("Exit codes:"));
    for (place, block) in notes.enumerate() {
        if place == 0 {
            roff.control("SH", ["NOTES"]);
        }
        roff.control("PP", []);
        for (place, line) in block.lines().enumerate() {
            if place > 0 && line.starts_with(' ') {
                roff.control("br", []);
            }
            roff.text([roman(line.trim_start())]);
        }
    }
    for block in examples {
        roff.control("SH", ["EXAMPLES"]);
        roff.control("nf", []);
        for line in block.lines().skip(1) {
            roff.text([roman(line.strip_prefix("  ").unwrap_or(line))]);
        }
        roff.control("fi", []);
    }
}

/// Adds all keys of the dashboard, by context.
fn keys(roff: &mut Roff) {
    roff.control("SH", ["KEYS"]);
    roff.text([roman(
        "Keys of the dashboard. The configuration changes them, by the name in brackets.",
    )]);
    let keymap = Keymap::default();
    let mut place = String::new();
    for [context, _, keys, name, does] in keymap.manual() {
        if context != place {
            roff.control("SS", [&*context]);
            place = context.into_owned();
        }
        roff.control("TP", ["18"]);
        roff.text([bold(&*keys)]);
        roff.text([roman(format!("{does} [{name}]"))]);
    }
}

fn exit_status(roff: &mut Roff) {
    roff.control("SH", ["EXIT STATUS"]);
    for (code, meaning) in Exit::meanings() {
        roff.control("TP", ["4"]);
        roff.text([bold(code.to_string())]);
        roff.text([roman(meaning)]);
    }
}

fn files(roff: &mut Roff) {
    roff.control("SH", ["FILES"]);
    roff.control("TP", []);
    roff.text([bold("$XDG_CONFIG_HOME/groundwave/config.toml")]);
    roff.text([roman(
        "The configuration, usually in ~/.config. `groundwave config` prints the defaults with comments, `groundwave config \
         path` prints the path on this system.",
    )]);
}

fn see_also(roff: &mut Roff, command: &Command) {
    let name = command
        .get_display_name()
        .unwrap_or_else(|| command.get_name());
    let Some((above, _)) = name.rsplit_once('-') else {
        return;
    };
    roff.control("SH", ["SEE ALSO"]);
    let above = format!("{above}(1)");
    let whole = if above == "groundwave(1)" {
        ""
    } else {
        ", groundwave(1)"
    };
    roff.text([roman(format!("{above}{whole}"))]);
}
