//! Parses the command line and exits with a documented code.

use std::process::ExitCode;

use clap::Parser;
use groundwave::commands::{answer_shell, cli::Cli, refuse, run};

fn main() -> ExitCode {
    answer_shell();
    match Cli::try_parse() {
        Ok(cli) => run(&cli),
        Err(error) => refuse(&error),
    }
}
