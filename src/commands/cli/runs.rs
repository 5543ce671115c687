//! The verbs about runs: captures with what their operator says of them.

use std::path::PathBuf;

use clap::Args;

use super::laid_out;
use crate::capture::when::When;

/// `runs`
#[derive(Debug, Args)]
#[command(after_help = laid_out("\
Examples:
  groundwave runs                         the captures in this folder
  groundwave runs contest/ evening.mcap
  groundwave runs --json | jq 'select(.void == null)'

The figures are of the way since the robot's odometer was last set; the closing error is how far from its
beginning it ended."))]
pub struct Runs {
    /// Captures, or folders of captures
    #[arg(value_name = "FILE|DIR", default_value = ".")]
    pub paths: Vec<PathBuf>,
    /// As JSON, one object a run
    #[arg(long)]
    pub json: bool,
}

/// `label`
#[derive(Debug, Args)]
#[command(after_help = laid_out("\
Examples:
  groundwave label run7.mcap                            what is said of it
  groundwave label run7.mcap --name 'new wheels, third try'
  groundwave label run7.mcap --note 'sonar sees the glass door' --at 1:30
  groundwave label run7.mcap --void 'the cat sat on it'
  groundwave label run7.mcap --counts                   it does count after all

It is kept beside the capture, in run7.mcap.run.toml; the capture itself is never touched."))]
pub struct Label {
    /// A capture
    pub file: PathBuf,
    /// Call the run this; an empty one takes the name away
    #[arg(long, value_name = "TEXT")]
    pub name: Option<String>,
    /// Add a remark
    #[arg(long, value_name = "TEXT")]
    pub note: Option<String>,
    /// The moment the remark is about, since the capture began: 90s, 1:30
    #[arg(long, value_name = "T", requires = "note", value_parser = parse_moment)]
    pub at: Option<f64>,
    /// The run does not count, and why
    #[arg(long, value_name = "REASON", num_args = 0..=1, default_missing_value = "")]
    pub void: Option<String>,
    /// The run counts after all
    #[arg(long, conflicts_with = "void")]
    pub counts: bool,
    /// As JSON
    #[arg(long)]
    pub json: bool,
}

/// `compare`
#[derive(Debug, Args)]
#[command(after_help = laid_out("\
Examples:
  groundwave compare before.mcap after.mcap
  groundwave compare before.mcap after.mcap --svg both.svg

Both tracks are laid over each other as the robot reported them, in its own frame: start both runs at the same mark."))]
pub struct Compare {
    /// A capture
    pub first: PathBuf,
    /// Another one
    pub second: PathBuf,
    /// Draw both tracks, to scale
    #[arg(long, value_name = "FILE")]
    pub svg: Option<PathBuf>,
    /// Overwrite an existing file
    #[arg(long, requires = "svg")]
    pub force: bool,
    /// As JSON
    #[arg(long)]
    pub json: bool,
}

/// Seconds since the capture began.
fn parse_moment(text: &str) -> Result<f64, String> {
    match text.parse::<When>().map_err(|error| error.to_string())? {
        When::Since(since) => Ok(since.as_secs_f64()),
        When::Wall(_) => Err(format!(
            "`{text}` is a time of day; say when since the capture began: 90s, 1:30"
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_remark_is_about_a_moment_since_the_beginning() {
        assert_eq!(parse_moment("1:30"), Ok(90.0));
        let wrong = parse_moment("2025-03-14T09:26:53Z").unwrap_err();
        assert!(wrong.contains("since the capture began"), "{wrong}");
    }
}
