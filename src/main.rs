//! Parses the command line and exits with a documented code.

use std::process::ExitCode;

use groundwave::commands::{answer_shell, parse, refuse, run};

fn main() -> ExitCode {
    answer_shell();
    match parse() {
        Ok(cli) => run(&cli),
        Err(error) => refuse(&error),
    }
}
