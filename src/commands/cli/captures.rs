//! The arguments of the commands that work on captures.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use clap_complete::engine::ArgValueCompleter;

use super::super::completions;
use super::super::config::Theme;
use super::{laid_out, parse_factor};
use crate::capture::when::When;

/// Captures to read.
#[derive(Clone, Debug, Args)]
pub struct Captures {
    /// Raw text or MCAP files, quoted patterns ('*.mcap'), or - for standard input
    #[arg(required = true, value_name = "FILE", add = ArgValueCompleter::new(completions::captures))]
    pub files: Vec<PathBuf>,
    /// Print only results and errors
    #[arg(short, long)]
    pub quiet: bool,
}

/// Target of the results.
#[derive(Clone, Debug, Args)]
pub struct Output {
    /// Write to FILE; - is standard output
    #[arg(short, long, value_name = "FILE", conflicts_with = "output_dir")]
    pub output: Option<PathBuf>,
    /// Write into DIR under the captures' names; DIR is created if it does not exist
    #[arg(long, value_name = "DIR")]
    pub output_dir: Option<PathBuf>,
    /// Overwrite existing files
    #[arg(long)]
    pub force: bool,
}

/// Arguments of `replay`.
#[derive(Debug, Args)]
#[command(after_help = laid_out("\
Examples:
  groundwave replay evening.mcap
  groundwave replay evening.txt --speed 10

Default keys: p or Space pauses and resumes; comma and full stop step one line back and forward; < and > change the speed; g asks
for a position: 12:30, +30s, 90% or #1234 (a line number); n and N go to the next and the previous alarm, bump, behaviour change, command or
mark; a sets a mark; o starts a loop, and o again ends it; ? shows all keys."))]
pub struct Replay {
    /// A raw text capture, with or without timestamps, or an MCAP file
    #[arg(add = ArgValueCompleter::new(completions::captures))]
    pub file: PathBuf,
    /// Speed, as a multiple of the recorded one
    #[arg(long, value_name = "X", default_value_t = 1.0, value_parser = parse_factor)]
    pub speed: f64,
    /// Colours of the dashboard; key Ctrl-T changes them
    #[arg(long, value_name = "THEME")]
    pub theme: Option<Theme>,
}

/// Arguments of `info`.
#[derive(Debug, Args)]
#[command(after_help = laid_out("\
Examples:
  groundwave info evening.mcap
  groundwave info --json 'evenings/*.mcap' | jq .distance_in"))]
pub struct Info {
    /// Captures to read.
    #[command(flatten)]
    pub captures: Captures,
    /// Print one JSON object per file
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `export`.
#[derive(Debug, Args)]
#[command(after_help = laid_out("\
Examples:
  groundwave export evening.mcap --to svg              writes evening.svg, the path with its events
  groundwave export 'evenings/*.mcap' --to csv --output-dir tables
  groundwave export evening.mcap --to map              writes evening.yaml and evening.pgm, for map_server, RViz and Nav2
  groundwave export evening.mcap --to map -o floor.png      and floor.yaml
  groundwave export evening.mcap --to raw              writes evening.txt, with the received bytes
  groundwave export evening.txt --to mcap              writes evening.mcap, with the topics of a recording
  cat /dev/ttyUSB0 | groundwave export - --to jsonl
  ssh robot cat evening.txt | groundwave export - --to mcap -o evening.mcap

Timestamps in the lines, such as those written by `ts` or another ground station, are kept. Other lines get times as if
the radio had sent them without pauses at 2400 baud, starting at --start. Line ends changed by an editor are restored."))]
pub struct Export {
    /// Captures to read.
    #[command(flatten)]
    pub captures: Captures,
    /// Output format
    #[arg(long, value_enum, value_name = "FORMAT")]
    pub to: ExportFormat,
    /// Target of the results; by default, files beside each capture.
    #[command(flatten)]
    pub output: Output,
    /// Start of raw text, with --to mcap: 2025-03-14T09:26:53Z [default: its first timestamp, else 1970]
    #[arg(long, value_name = "TIME")]
    pub start: Option<When>,
    /// With --to mcap, also convert files without an intact line, such as noise
    #[arg(long)]
    pub anyway: bool,
}

/// The output formats of `export`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ExportFormat {
    /// A table with a header, one row per line
    Csv,
    /// One JSON object per line
    Jsonl,
    /// The path with its events, as SVG
    Svg,
    /// The path with its events, as PNG
    Png,
    /// The floor that the robot saw, as a map for ROS: YAML and an image (PGM, or PNG with `-o NAME.png`)
    Map,
    /// A recording made of raw text, with every topic but the ground's estimate
    Mcap,
    /// The received bytes, as raw text
    Raw,
}

/// Arguments of `map`.
#[derive(Debug, Args)]
#[command(after_help = laid_out("\
Examples:
  groundwave map monday.mcap tuesday.mcap              writes monday.yaml and monday.pgm
  groundwave map 'evenings/*.mcap' -o house.png        writes house.png and house.yaml

The map has the form of `export --to map`. Its origin is the home of the first run on it. Each later run is turned and
shifted as a whole until its walls fit the map, and added. A run is left out and named if its walls fit no place clearly
best: it was in another house or in rooms that are not on the map yet, or was too short. The others are on the map. Put
the longest run first.
Exit codes: 0 all runs are on the map, 1 a run was left out or read only in part, 2 a file is not a capture or has
nothing for a map."))]
pub struct Map {
    /// Captures to read.
    #[command(flatten)]
    pub captures: Captures,
    /// Write to FILE, NAME.yaml or NAME.png, and the second file beside it [default: the first capture's name]
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Overwrite existing files
    #[arg(long)]
    pub force: bool,
}

/// Arguments of `cut`.
#[derive(Debug, Args)]
#[command(after_help = laid_out("\
Examples:
  groundwave cut evening.mcap --from 1:30 --to 2m -o bump.mcap
  groundwave cut evening.mcap --from 2025-03-14T20:15:00Z      writes evening.cut.mcap
  groundwave cut evening.txt --to 10m -o -

The output has the format of the input. A line belongs to the range in which it ends, so adjacent ranges lose no line."))]
pub struct Cut {
    /// Captures to read.
    #[command(flatten)]
    pub captures: Captures,
    /// Start: 90s, 1:30 or 1:02:03 since the start of the capture, or a date, 2025-03-14T09:26:53Z
    #[arg(long, value_name = "TIME")]
    pub from: Option<When>,
    /// End, in the same forms
    #[arg(long, value_name = "TIME")]
    pub to: Option<When>,
    /// Target of the results; by default, a file NAME.cut.mcap beside each capture.
    #[command(flatten)]
    pub output: Output,
}

/// Arguments of `verify`.
#[derive(Debug, Args)]
#[command(after_help = laid_out("\
Examples:
  groundwave verify 'evenings/*.mcap'
  groundwave verify evening.mcap --raw evening.txt

The command checks all checksums, message numbers, byte offsets and statistics. It derives all messages again from the
bytes and the station's events, and compares them with those in the recording. It compares the bytes with the raw file
beside the recording (NAME.txt) if both begin with the same bytes. Lines lost on the radio are reported, but are not a
fault of the capture.
Exit codes: 0 no faults, 1 faults, 2 not a capture."))]
pub struct Verify {
    /// Captures to read.
    #[command(flatten)]
    pub captures: Captures,
    /// Raw file to compare with [default: NAME.txt beside NAME.mcap, if both begin with the same bytes]
    #[arg(long, value_name = "FILE")]
    pub raw: Option<PathBuf>,
    /// Print one JSON object per file
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `recover`.
#[derive(Debug, Args)]
#[command(after_help = laid_out("\
Examples:
  groundwave recover evening.mcap
  groundwave recover --json ~/captures    all interrupted recordings in a folder

The command finishes an interrupted recording: it indexes and compresses the messages. It rewrites a damaged recording
from the readable parts, reports the skipped parts and keeps the original as FILE.damaged. You can interrupt and repeat
the command at any time."))]
pub struct Recover {
    /// Recordings, or folders with interrupted recordings
    #[arg(required = true, add = ArgValueCompleter::new(completions::captures))]
    pub files: Vec<PathBuf>,
    /// Print one JSON object per recording
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `songs`.
#[derive(Debug, Args)]
#[command(after_help = laid_out("\
Examples:
  groundwave songs evening.mcap
  groundwave songs evening.txt --wav songs      writes songs/song-01.wav and so on, numbered as listed

A note has the name of the nearest piano key (A4 is 440 Hz) and its length in seconds; a dash is a rest."))]
pub struct Songs {
    /// A raw text or MCAP file, or - for standard input
    #[arg(add = ArgValueCompleter::new(completions::captures))]
    pub file: PathBuf,
    /// Write each song as a WAV file into DIR, which is created if it does not exist
    #[arg(long, value_name = "DIR")]
    pub wav: Option<PathBuf>,
    /// Overwrite existing files
    #[arg(long, requires = "wav")]
    pub force: bool,
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory as _;

    use crate::commands::cli::Cli;
    use crate::model::keys::{Context, Keymap};

    #[test]
    fn the_help_of_replay_names_the_default_keys() {
        let mut cli = Cli::command();
        let replay = cli.find_subcommand_mut("replay").unwrap();
        let help = replay.render_long_help().to_string();
        let help: Vec<&str> = help.split_whitespace().collect();
        let help = help.join(" ");
        let keymap = Keymap::default();
        for (action, says) in [
            ("playback-toggle-pause", "p or Space pauses"),
            ("ask-moment", "g asks"),
            ("ask-jump-forward", "n and N go"),
            ("mark", "a sets a mark"),
            ("playback-loop", "o starts a loop"),
            ("help", "? shows"),
        ] {
            assert!(help.contains(says), "{says} is not in {help}");
            let mut rows = keymap
                .rows()
                .filter(|row| row.context == Context::Dashboard);
            let row = rows.find(|row| row.name == action).expect(action);
            let key = says.split(' ').next().unwrap();
            assert!(
                row.key_names().split(' ').any(|name| name == key),
                "{action}"
            );
        }
    }
}
