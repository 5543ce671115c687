//! Writes the documents that are generated from tables: `cargo run --example documents`. `tests/documents.rs` checks that
//! they are current.

use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use clap::CommandFactory as _;
use groundwave::capture::topics::Topic;
use groundwave::commands::cli::Cli;
use groundwave::model::keys::Keymap;
use groundwave::request::in_whole_unit;
use sr04_firmware::parameters::Parameter;

/// A path in the repository and the function that generates the file's text.
pub type Document = (&'static str, fn() -> String);

/// All generated documents.
pub const DOCUMENTS: &[Document] = &[
    ("docs/commands.md", commands),
    ("docs/keys.md", keys),
    ("docs/parameters.md", parameters),
    ("tests/judges/topics.json", topics),
];

/// Number of columns of the help texts.
const HELP_COLUMNS: usize = 100;

/// Path of a document.
#[must_use]
pub fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

#[allow(dead_code, reason = "the test that uses this file does not write")]
fn main() -> Result<(), Box<dyn Error>> {
    for (name, make) in DOCUMENTS {
        fs::write(path(name), make())?;
    }
    Ok(())
}

/// All commands with their help.
fn commands() -> String {
    let mut text = String::from(
        "# Commands\n\n\
         Generated from the definitions in `src/commands/cli` by `cargo run --example documents`. `groundwave COMMAND --help` prints\n\
         the same text, `groundwave man` a manual page, and `groundwave completions SHELL` the completion script for a shell.\n",
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

/// All keys, from the table of the dashboard.
fn keys() -> String {
    let mut text = String::from(
        "# Keys\n\n\
         Generated from the table in `src/model/keys.rs` by `cargo run --example documents`. `?` shows the keys in the dashboard. The\n\
         configuration changes a key, under the name in the third column; `groundwave config` prints all names:\n\n\
         ```toml\n[keys]\nscan = [\"v\", \"F12\"]\n[keys.drive]\nleave-drive = \"x\"\n```\n\n\
         STOP always keeps Space and Ctrl-S. Keys for `stop` in `[keys]` also count in sections that name no other key for it; a character\n\
         does not count while text is entered.\n",
    );
    let mut place = String::new();
    for [context, group, keys, name, does] in Keymap::default().manual() {
        let here = if group.is_empty() {
            context.into_owned()
        } else {
            format!("{context}: {group}")
        };
        if here != place {
            let _ = writeln!(
                text,
                "\n## {here}\n\n| keys | action | name |\n|---|---|---|"
            );
            place = here;
        }
        let keys: Vec<String> = keys
            .split(' ')
            .map(|key| format!("`{}`", key.replace('|', "\\|")))
            .collect();
        let _ = writeln!(text, "| {} | {does} | `{name}` |", keys.join(" "));
    }
    text
}

/// The topics of a recording and the types of their messages, for the programs that check recordings.
fn topics() -> String {
    let rows = Topic::ALL.map(|topic| format!("  {:?}: {:?}", topic.name(), topic.schema().name));
    format!("{{\n{}\n}}\n", rows.join(",\n"))
}

/// The robot's parameters, from the table of its program.
fn parameters() -> String {
    let mut text = String::from(
        "# The robot's parameters\n\n\
         Generated from the table in `firmware/src/parameters.rs` by `cargo run --example documents`.\n\n\
         `groundwave param LINK get NAME` reads a parameter, `groundwave param LINK set NAME VALUE` changes it until the robot's next\n\
         reset, and `groundwave param LINK save` saves all of them. A whole number is in the unit of the third column; a number with a\n\
         decimal point is in the whole unit: `set battery-low 118` and `set battery-low 11.8` are the same. The robot reports name,\n\
         limits and unit, and refuses values outside the limits.\n\n\
         | name | meaning | unit | from | to | default | in the whole unit |\n\
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
