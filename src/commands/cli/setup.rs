//! The arguments of the verbs that are about the program itself and the machine it runs on: `ports`, `config`,
//! `completions` and `man`.

use std::path::PathBuf;

use clap::{Args, Subcommand};
use clap_complete::Shell;

use super::laid_out;

/// `ports`
#[derive(Debug, Args)]
#[command(after_help = laid_out("\
Examples:
  groundwave ports
  groundwave ports --json"))]
pub struct Ports {
    /// As JSON, one object a port
    #[arg(long)]
    pub json: bool,
}

/// `config`
#[derive(Debug, Args)]
#[command(after_help = laid_out("\
Examples:
  groundwave config                                     the file as it comes, every line explained
  groundwave config > ~/.config/groundwave/config.toml  a file to start from
  groundwave config path                                where it is read from
  groundwave config check my.toml                       whether it can be read, and what is wrong with it"))]
pub struct ConfigArgs {
    /// What to do; without a word the file as it comes is printed
    #[command(subcommand)]
    pub what: Option<ConfigVerb>,
}

/// What can be done about the configuration.
#[derive(Debug, Subcommand)]
pub enum ConfigVerb {
    /// Say where it is read from
    Path,
    /// Read it, and say what is in it or what is wrong with it
    Check {
        /// Another file than the usual one
        file: Option<PathBuf>,
    },
}

/// `completions`
#[derive(Debug, Args)]
#[command(after_help = laid_out("\
Examples:
  echo 'source <(groundwave completions bash)' >> ~/.bashrc
  echo 'source <(groundwave completions zsh)' >> ~/.zshrc
  groundwave completions fish > ~/.config/fish/completions/groundwave.fish

The shell asks the program itself, so that worlds, modes, layers, presets, ports and the names of your configuration are
offered as they are."))]
pub struct Completions {
    /// For which shell
    pub shell: Shell,
}

/// `man`
#[derive(Debug, Args)]
#[command(after_help = laid_out("\
Examples:
  groundwave man | man -l -                             read it
  groundwave man ~/.local/share/man/man1                one page for each verb"))]
pub struct Man {
    /// Write a page for each verb into this folder, which is made if it is not there
    pub dir: Option<PathBuf>,
}
