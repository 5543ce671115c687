//! The arguments of `runs`, `label` and `compare`.

use std::path::PathBuf;
use std::time::SystemTime;

use clap::Args;
use clap_complete::engine::ArgValueCompleter;

use super::super::completions;
use super::laid_out;
use crate::capture::when::{NoDate, Stretch, When};

/// Arguments of `runs`.
#[derive(Debug, Args)]
#[command(after_help = laid_out("\
Examples:
  groundwave runs                         list the captures in this folder
  groundwave runs contest/ evening.mcap
  groundwave runs --since yesterday       also 2026-11-20, '2 days', 14:30, '2026-11-20 14:30'
  groundwave runs --since 2026-11-01 --until 2026-11-20
  groundwave runs --json | jq 'select(.void == null)'

Each capture is one run with the figures of `info`; the newest is last. Dates are in UTC, as in all captures. The closing error is the distance from the end of the path to its
beginning, or to the place where the odometer was last reset by a restart or by setting the position."))]
pub struct Runs {
    /// Captures, or folders of captures
    #[arg(value_name = "FILE|DIR", default_value = ".", add = ArgValueCompleter::new(completions::captures))]
    pub paths: Vec<PathBuf>,
    /// List runs that started at this time or later: a date, a time of day, `yesterday`, `2 days`
    #[arg(long, value_name = "DATE", value_parser = parse_stretch)]
    pub since: Option<Stretch>,
    /// List runs that started at this time or earlier; a date includes its whole day, a time its whole minute
    #[arg(long, value_name = "DATE", value_parser = parse_stretch)]
    pub until: Option<Stretch>,
    /// Print one JSON object per run
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `label`.
#[derive(Debug, Args)]
#[command(after_help = laid_out("\
Examples:
  groundwave label run7.mcap                            show the label
  groundwave label run7.mcap --name 'new wheels, third try'
  groundwave label run7.mcap --note 'sonar sees the glass door' --at 1:30
  groundwave label run7.mcap --void 'the cat sat on it'
  groundwave label run7.mcap --counts                   make the run valid again

The label is saved beside the capture, in run7.mcap.run.toml. The capture itself is not changed."))]
pub struct Label {
    /// A capture
    #[arg(add = ArgValueCompleter::new(completions::captures))]
    pub file: PathBuf,
    /// Name the run; an empty text removes the name
    #[arg(long, value_name = "TEXT")]
    pub name: Option<String>,
    /// Add a note
    #[arg(long, value_name = "TEXT")]
    pub note: Option<String>,
    /// Time of the note since the start of the capture: 90s, 1:30
    #[arg(long, value_name = "T", requires = "note", value_parser = parse_moment)]
    pub at: Option<f64>,
    /// Mark the run void, with an optional reason
    #[arg(long, value_name = "REASON", num_args = 0..=1, default_missing_value = "")]
    pub void: Option<String>,
    /// Make a void run valid again
    #[arg(long, conflicts_with = "void")]
    pub counts: bool,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `compare`.
#[derive(Debug, Args)]
#[command(after_help = laid_out("\
Examples:
  groundwave compare before.mcap after.mcap
  groundwave compare before.mcap after.mcap --svg both.svg

Both paths are drawn as the robot reported them, in its own frame, so start both runs at the same mark."))]
pub struct Compare {
    /// A capture
    #[arg(add = ArgValueCompleter::new(completions::captures))]
    pub first: PathBuf,
    /// Another capture
    #[arg(add = ArgValueCompleter::new(completions::captures))]
    pub second: PathBuf,
    /// Draw both paths to scale
    #[arg(long, value_name = "FILE")]
    pub svg: Option<PathBuf>,
    /// Overwrite an existing file
    #[arg(long, requires = "svg")]
    pub force: bool,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// Parses a date or a time of day, in UTC.
fn parse_stretch(text: &str) -> Result<Stretch, NoDate> {
    Stretch::parse(text, SystemTime::now())
}

/// Parses a time since the start of the capture; returns seconds.
fn parse_moment(text: &str) -> Result<f64, String> {
    match text.parse::<When>().map_err(|error| error.to_string())? {
        When::Since(since) => Ok(since.as_secs_f64()),
        When::Wall(_) => Err(format!(
            "`{text}` is a date; give the time since the start of the capture: 90s, 1:30"
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn note_time_is_since_the_start_of_the_capture() {
        assert_eq!(parse_moment("1:30"), Ok(90.0));
        let wrong = parse_moment("2025-03-14T09:26:53Z").unwrap_err();
        assert!(wrong.contains("since the start of the capture"), "{wrong}");
    }
}
