//! The arguments of `ports`, `config`, `completions` and `man`.

use std::path::PathBuf;

use clap::{Args, Subcommand};
use clap_complete::Shell;

use super::laid_out;

/// Arguments of `ports`.
#[derive(Debug, Args)]
#[command(after_help = laid_out("\
Examples:
  groundwave ports
  groundwave ports --json"))]
pub struct Ports {
    /// Print one JSON object per port
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `config`.
#[derive(Debug, Args)]
#[command(after_help = laid_out("\
Examples:
  groundwave config                                     print the default configuration, with comments
  groundwave config > ~/.config/groundwave/config.toml  make a file to edit
  groundwave config path                                print the file's path
  groundwave config check my.toml                       list the mistakes in a file"))]
pub struct ConfigArgs {
    /// The subcommand; without one, the default configuration is printed.
    #[command(subcommand)]
    pub what: Option<ConfigVerb>,
}

/// The subcommands of `config`.
#[derive(Debug, Subcommand)]
pub enum ConfigVerb {
    /// Print the path of the configuration
    Path,
    /// Check a configuration and list its mistakes
    Check {
        /// The file [default: the file in use]
        file: Option<PathBuf>,
    },
}

/// Arguments of `completions`.
#[derive(Debug, Args)]
#[command(after_help = laid_out("\
Examples:
  echo 'source <(groundwave completions bash)' >> ~/.bashrc
  echo 'source <(groundwave completions zsh)' >> ~/.zshrc
  groundwave completions fish > ~/.config/fish/completions/groundwave.fish

The shell asks groundwave at each completion, so it completes worlds, modes, layers, presets, ports and the names in your configuration."))]
pub struct Completions {
    /// The shell
    pub shell: Shell,
}

/// Arguments of `man`.
#[derive(Debug, Args)]
#[command(after_help = laid_out("\
Examples:
  groundwave man | man -l -                             read the page
  groundwave man ~/.local/share/man/man1                write one page for each command"))]
pub struct Man {
    /// Write one page for each command into DIR, which is created if it does not exist
    pub dir: Option<PathBuf>,
}
