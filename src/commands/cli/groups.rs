//! The verbs in groups, for the help of the program.

use std::fmt::Write as _;

/// A heading and its verbs, each with a few words.
type Group = (&'static str, &'static [(&'static str, &'static str)]);

const LIVE: Group = (
    "Live",
    &[
        ("demo", "simulate and show a robot"),
        ("watch", "show a robot"),
        ("record", "record without dashboard"),
        ("send", "send a command"),
        ("param", "read, change parameters"),
        ("calibrate", "calibrate wheels and track"),
        ("check", "find a robot's mistakes"),
    ],
);

const SIMULATOR: Group = (
    "Simulator",
    &[
        ("sim", "serve a simulated robot"),
        ("world", "list, check, draw worlds"),
    ],
);

const CAPTURES: Group = (
    "Captures",
    &[
        ("replay", "play in the dashboard"),
        ("info", "summarize"),
        ("runs", "list with labels"),
        ("label", "name, annotate, void"),
        ("compare", "compare two runs"),
        ("export", "tables, pictures, MCAP"),
        ("map", "one map of several runs"),
        ("cut", "cut out a time range"),
        ("verify", "check for damage, gaps"),
        ("recover", "finish, repair"),
        ("songs", "list, save as sound"),
    ],
);

const SETUP: Group = (
    "Set-up",
    &[
        ("ports", "list serial ports"),
        ("config", "print, check settings"),
    ],
);

const SETUP_GOES_ON: Group = (
    "",
    &[("completions", "for a shell"), ("man", "manual pages")],
);

/// Width of the left column, characters.
const LEFT: usize = 42;

/// Template of the program's help, for a screen of 80 by 24 characters. clap has no headings for subcommands.
pub(super) fn template() -> String {
    let mut left = rows(LIVE);
    left.extend(rows(SIMULATOR));
    let mut text =
        "{about}\n{usage-heading} {usage}; `groundwave help VERB` explains one\n\n".to_owned();
    // The last verb of the captures stands in the row that is empty above the set-up: the help fits a small screen.
    beside(&mut text, &left, &rows(CAPTURES));
    beside(&mut text, &rows(SETUP), &rows(SETUP_GOES_ON));
    text += "\nOptions:\n{options}{after-help}";
    text
}

fn rows((heading, verbs): Group) -> Vec<String> {
    let heading = match heading {
        "" => String::new(),
        heading => format!("{heading}:"),
    };
    let row = |(verb, words): &(&str, &str)| format!("  {verb:<11} {words}");
    std::iter::once(heading)
        .chain(verbs.iter().map(row))
        .collect()
}

/// Appends two columns of text.
fn beside(text: &mut String, left: &[String], right: &[String]) {
    for place in 0..left.len().max(right.len()) {
        let of = |rows: &[String]| rows.get(place).cloned().unwrap_or_default();
        let row = format!("{:LEFT$}{}", of(left), of(right));
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{}", row.trim_end());
    }
}

#[cfg(test)]
mod tests {
    use super::super::Cli;
    use super::*;
    use clap::CommandFactory as _;

    #[test]
    fn every_verb_is_in_one_group() {
        let groups = [LIVE, SIMULATOR, CAPTURES, SETUP, SETUP_GOES_ON];
        let mut grouped: Vec<&str> = groups
            .iter()
            .flat_map(|(_, verbs)| verbs.iter().map(|(verb, _)| *verb))
            .collect();
        let command = Cli::command();
        let mut verbs: Vec<&str> = command
            .get_subcommands()
            .map(clap::Command::get_name)
            .collect();
        grouped.sort_unstable();
        verbs.sort_unstable();
        assert_eq!(grouped, verbs);
    }

    #[test]
    fn the_short_help_fits_a_small_screen() {
        let help = Cli::command().term_width(80).render_help().to_string();
        let help = help.trim_end();
        assert!(help.lines().count() < 24, "{help}");
        assert!(help.lines().all(|row| row.chars().count() < 80), "{help}");
        insta::assert_snapshot!(help);
    }
}
