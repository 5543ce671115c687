//! The arguments of the verbs that read captures: `replay`, `decode`, `info` and `songs`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

/// `replay`
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  groundwave replay evening.mcap
  groundwave replay evening.txt --speed 10")]
pub struct Replay {
    /// A raw capture or an MCAP file
    pub file: PathBuf,
    /// Multiple of the speed it was recorded at
    #[arg(long, value_name = "X", default_value_t = 1.0)]
    pub speed: f64,
}

/// `decode`
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  groundwave decode evening.txt --to csv > evening.csv
  cat /dev/ttyUSB0 | groundwave decode - --to jsonl")]
pub struct Decode {
    /// A raw capture, an MCAP file, or - for standard input
    pub file: PathBuf,
    /// What to write to standard output
    #[arg(long, value_enum)]
    pub to: DecodeFormat,
}

/// What `decode` writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum DecodeFormat {
    /// One JSON object a line
    Jsonl,
    /// One table with a header
    Csv,
}

/// `info`
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  groundwave info evening.mcap evening.txt
  groundwave info --json *.mcap")]
pub struct Info {
    /// Raw captures or MCAP files
    #[arg(required = true)]
    pub files: Vec<PathBuf>,
    /// As JSON, one object a file
    #[arg(long)]
    pub json: bool,
}

/// `songs`
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  groundwave songs evening.mcap
  groundwave songs evening.txt --wav songs      songs/song-01.wav and so on, numbered as listed

A note is named by the nearest key of a piano (A4 is 440 Hz), with its length in seconds; a dash is a rest.")]
pub struct Songs {
    /// A raw capture, an MCAP file, or - for standard input
    pub file: PathBuf,
    /// Write each song into this folder, which is made if it is not there
    #[arg(long, value_name = "DIR")]
    pub wav: Option<PathBuf>,
    /// Overwrite existing files
    #[arg(long, requires = "wav")]
    pub force: bool,
}
