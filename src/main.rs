//! Parses the command line and leaves with the exit code that scripts rely on.

use std::process::ExitCode;

use clap::Parser;
use groundwave::commands::{cli::Cli, run};

fn main() -> ExitCode {
    run(&Cli::parse())
}
