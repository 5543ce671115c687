//! The arguments of the verbs that work on captures.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::{laid_out, parse_factor};
use crate::capture::when::When;

/// Which captures.
#[derive(Clone, Debug, Args)]
pub struct Captures {
    /// Raw captures or MCAP files, patterns in quotes ('*.mcap'), or - for standard input
    #[arg(required = true, value_name = "FILE")]
    pub files: Vec<PathBuf>,
    /// Say nothing but results and errors
    #[arg(short, long)]
    pub quiet: bool,
}

/// Where results go.
#[derive(Clone, Debug, Args)]
pub struct Output {
    /// Write to FILE, or to standard output for -
    #[arg(short, long, value_name = "FILE", conflicts_with = "output_dir")]
    pub output: Option<PathBuf>,
    /// Write into DIR, which is made if it is not there, under names made from those of the captures
    #[arg(long, value_name = "DIR")]
    pub output_dir: Option<PathBuf>,
    /// Overwrite existing files
    #[arg(long)]
    pub force: bool,
}

/// `replay`
#[derive(Debug, Args)]
#[command(after_help = laid_out("\
Examples:
  groundwave replay evening.mcap
  groundwave replay evening.txt --speed 10

In the dashboard, with the keys as they come: k stands still and goes on, comma and full stop step a line back and
on, < and > change the speed, g goes to 12:30, +30s, 90% or packet #1234, n and N go to the next and last alarm,
bump, behaviour change or command, m marks, o loops, ? shows every key."))]
pub struct Replay {
    /// A raw capture, with times before its lines or without, or an MCAP file
    pub file: PathBuf,
    /// Multiple of the speed it was recorded at
    #[arg(long, value_name = "X", default_value_t = 1.0, value_parser = parse_factor)]
    pub speed: f64,
}

/// `decode`
#[derive(Debug, Args)]
#[command(after_help = laid_out("\
Examples:
  groundwave decode evening.txt --to csv > evening.csv
  cat /dev/ttyUSB0 | groundwave decode - --to jsonl"))]
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
#[command(after_help = laid_out("\
Examples:
  groundwave info evening.mcap
  groundwave info --json 'evenings/*.mcap' | jq .distance_in"))]
pub struct Info {
    /// Which captures.
    #[command(flatten)]
    pub captures: Captures,
    /// As JSON, one object a file
    #[arg(long)]
    pub json: bool,
}

/// `convert`
#[derive(Debug, Args)]
#[command(after_help = laid_out("\
Examples:
  groundwave convert evening.txt                   evening.mcap, with every topic a recording has
  groundwave convert evening.mcap                  evening.txt, the bytes of the radio as they came
  groundwave convert 'evenings/*.txt' --output-dir converted
  ssh robot cat evening.txt | groundwave convert - -o evening.mcap

A raw capture knows no time: its lines are given that of a radio at 2400 baud which never paused, from --start on. One with
a time before each line, as other stations and `ts` write it, has those times; it and one whose CR LF an editor has changed
become what the radio delivered."))]
pub struct Convert {
    /// Which captures.
    #[command(flatten)]
    pub captures: Captures,
    /// Where results go; beside each capture if nothing is said.
    #[command(flatten)]
    pub output: Output,
    /// When a raw capture began: 2025-03-14T09:26:53Z [default: what its lines say, else 1970]
    #[arg(long, value_name = "TIME")]
    pub start: Option<When>,
    /// Make MCAP also of what has not one line of a robot, such as noise
    #[arg(long)]
    pub anyway: bool,
}

/// `export`
#[derive(Debug, Args)]
#[command(after_help = laid_out("\
Examples:
  groundwave export evening.mcap --to svg              evening.svg: the track with its events
  groundwave export 'evenings/*.mcap' --to csv --output-dir tables
  groundwave export evening.txt --to jsonl -o -"))]
pub struct Export {
    /// Which captures.
    #[command(flatten)]
    pub captures: Captures,
    /// What to make
    #[arg(long, value_enum)]
    pub to: ExportFormat,
    /// Where results go; beside each capture if nothing is said.
    #[command(flatten)]
    pub output: Output,
}

/// What `export` makes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ExportFormat {
    /// One table with a header, a row a line of the robot
    Csv,
    /// One JSON object a line of the robot
    Jsonl,
    /// The track with its events, as a drawing
    Svg,
    /// The track with its events, as pixels
    Png,
}

/// `cut`
#[derive(Debug, Args)]
#[command(after_help = laid_out("\
Examples:
  groundwave cut evening.mcap --from 1:30 --to 2m -o bump.mcap
  groundwave cut evening.mcap --from 2025-03-14T20:15:00Z      evening.cut.mcap
  groundwave cut evening.txt --to 10m -o -

The part has the form of the capture. A line belongs to the part in which it ends, so parts that meet make up the whole."))]
pub struct Cut {
    /// Which captures.
    #[command(flatten)]
    pub captures: Captures,
    /// Where the part begins: 90s, 1:30, 1:02:03 since the beginning, or by the clock, 2025-03-14T09:26:53Z
    #[arg(long, value_name = "TIME")]
    pub from: Option<When>,
    /// Where it ends, likewise
    #[arg(long, value_name = "TIME")]
    pub to: Option<When>,
    /// Where results go; beside each capture, as NAME.cut.mcap, if nothing is said.
    #[command(flatten)]
    pub output: Output,
}

/// `verify`
#[derive(Debug, Args)]
#[command(after_help = laid_out("\
Examples:
  groundwave verify 'evenings/*.mcap'
  groundwave verify evening.mcap --raw evening.txt

Every checksum, the numbers of the messages, the offsets of the bytes, the statistics; that each message which
follows from the bytes and the station's events is what they give today, on every topic; and that the raw file (NAME.txt) and the
journal (NAME.mcap.journal) beside it, where there are such, hold the same bytes. What the radio lost is told and no fault of the capture.
Exit code 0: all good; 1: not; 2: not a capture at all."))]
pub struct Verify {
    /// Which captures.
    #[command(flatten)]
    pub captures: Captures,
    /// The raw file with the same bytes [default: NAME.txt beside NAME.mcap, where there is one]
    #[arg(long, value_name = "FILE")]
    pub raw: Option<PathBuf>,
    /// As JSON, one object a file
    #[arg(long)]
    pub json: bool,
}

/// `recover`
#[derive(Debug, Args)]
#[command(after_help = laid_out("\
Examples:
  groundwave recover evening.mcap
  groundwave recover .                    every interrupted recording of this folder"))]
pub struct Recover {
    /// Recordings, or folders with interrupted ones
    #[arg(required = true)]
    pub files: Vec<PathBuf>,
    /// What was saved as a JSON line for each
    #[arg(long)]
    pub json: bool,
}

/// `songs`
#[derive(Debug, Args)]
#[command(after_help = laid_out("\
Examples:
  groundwave songs evening.mcap
  groundwave songs evening.txt --wav songs      songs/song-01.wav and so on, numbered as listed

A note is named by the nearest key of a piano (A4 is 440 Hz), with its length in seconds; a dash is a rest."))]
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
