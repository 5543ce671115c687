//! Writes the documents that are made from tables: `cargo run --example documents`. `tests/documents.rs` sees to it that
//! they are current.

use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use clap::CommandFactory as _;
use groundwave::commands::cli::Cli;
use groundwave::model::keys::Keymap;
use groundwave::request::in_whole_unit;
use sr04_firmware::parameters::Parameter;

/// A name below `docs/`, and what makes the text.
pub type Document = (&'static str, fn() -> String);

/// Each document's name below `docs/`, and what makes it.
pub const DOCUMENTS: &[Document] = &[
    ("commands.md", commands),
    ("keys.md", keys),
    ("parameters.md", parameters),
];

/// Columns of the help texts.
const HELP_COLUMNS: usize = 100;

/// Where a document is.
#[must_use]
pub fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("docs")
        .join(name)
}

#[allow(dead_code, reason = "the test that uses this file does not write")]
fn main() -> Result<(), Box<dyn Error>> {
    for (name, make) in DOCUMENTS {
        fs::write(path(name), make())?;
    }
    Ok(())
}

/// Every verb with its help.
fn commands() -> String {
    let mut text = String::from(
        "# Commands\n\n\
         Made from the definitions in `src/commands/cli` by `cargo run --example documents`. `groundwave VERB --help` prints the same,\n\
         `groundwave man` as a manual page, and `groundwave completions SHELL` what a shell needs to complete it.\n",
    );
    let mut command = Cli::command().term_width(HELP_COLUMNS);
    command.build();
    let mut add = |title: &str, command: &clap::Command| {
        let help = command.clone().render_long_help().to_string();
        let help: Vec<&str> = help.lines().map(str::trim_end).collect();
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "\n## {title}\n\n```text\n{}\n```",
            help.join("\n").trim_end()
        );
    };
    add("groundwave", &command);
    for verb in command
        .get_subcommands()
        .filter(|verb| verb.get_name() != "help")
    {
        add(verb.get_name(), verb);
    }
    text
}

/// Every key, from the table that the dashboard reads.
fn keys() -> String {
    let mut text = String::from(
        "# Keys\n\n\
         Made from the table in `src/model/keys.rs` by `cargo run --example documents`. `?` shows them in the dashboard. Another key is\n\
         chosen in the configuration, under the name in the third column; `groundwave config` prints them all:\n\n\
         ```toml\n[keys]\nscan = [\"v\", \"F9\"]\n[keys.drive]\nleave-drive = \"x\"\n```\n\n\
         STOP keeps Space and Ctrl-S. What `[keys]` says of `stop` counts in every place that says nothing of it, a character not where one\n\
         types.\n",
    );
    let mut place = String::new();
    for [context, keys, name, does] in Keymap::default().manual() {
        if context != place {
            let _ = writeln!(
                text,
                "\n## {context}\n\n| keys | what they do | name |\n|---|---|---|"
            );
            place = context.into_owned();
        }
        let keys: Vec<String> = keys
            .split(' ')
            .map(|key| format!("`{}`", key.replace('|', "\\|")))
            .collect();
        let _ = writeln!(text, "| {} | {does} | `{name}` |", keys.join(" "));
    }
    text
}

/// The robot's parameters, from the table of its program.
fn parameters() -> String {
    let mut text = String::from(
        "# The robot's parameters\n\n\
         Made from the table in `firmware/src/parameters.rs` by `cargo run --example documents`.\n\n\
         A parameter is read with `groundwave param LINK get NAME`, changed until the robot's next reset with\n\
         `groundwave param LINK set NAME VALUE`, and `groundwave param LINK save` keeps all of them as they are. A whole number is\n\
         what the robot counts, in the unit of the third column; a number with a decimal point is in the whole unit: `set battery-low\n\
         118` and `set battery-low 11.8` are the same. The robot itself\n\
         tells name, limits and unit, and refuses what lies outside.\n\n\
         | name | what it is | counted in | from | to | at first | which is |\n\
         |---|---|---|---:|---:|---:|---|\n",
    );
    for parameter in Parameter::ALL {
        let about = parameter.about();
        let one = parameter.definition();
        let whole = in_whole_unit(one.default.into(), one.unit);
        let whole = whole.map_or(String::new(), |(number, unit)| format!("{number} {unit}"));
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "| `{}` | {about} | {} | {} | {} | {} | {whole} |",
            one.name, one.unit, one.least, one.most, one.default
        );
    }
    text
}
