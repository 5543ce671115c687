//! The verbs about runs: captures with what their operator says of them.

use std::path::PathBuf;

use clap::Args;

/// `runs`
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  groundwave runs                         the captures in this folder
  groundwave runs contest/ evening.mcap
  groundwave runs --json | jq 'select(.void == null)'

The figures are of the way since the robot's odometer was last set; the closing error is how far from its
beginning it ended.")]
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
#[command(after_help = "\
Examples:
  groundwave label run7.mcap                            what is said of it
  groundwave label run7.mcap --name 'new wheels, third try'
  groundwave label run7.mcap --note 'sonar sees the glass door' --at 1:30
  groundwave label run7.mcap --void 'the cat sat on it'
  groundwave label run7.mcap --counts                   it does count after all

It is kept beside the capture, in run7.mcap.run.toml; the capture itself is never touched.")]
pub struct Label {
    /// A capture
    pub file: PathBuf,
    /// Call the run this
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
#[command(after_help = "\
Examples:
  groundwave compare before.mcap after.mcap
  groundwave compare before.mcap after.mcap --svg both.svg

Both tracks are laid over each other as the robot reported them, in its own frame: start both runs at the same mark.")]
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

/// Seconds of `1:02:30`, `1:30`, `90` or `90s`.
fn parse_moment(text: &str) -> Result<f64, String> {
    let wrong = || format!("`{text}` is no moment; try 90s, 1:30 or 1:02:30");
    let parts: Vec<&str> = text.trim_end_matches('s').split(':').collect();
    if parts.len() > 3 {
        return Err(wrong());
    }
    let mut seconds = 0.0;
    for (place, part) in parts.iter().enumerate() {
        let value: f64 = part.parse().map_err(|_| wrong())?;
        if !value.is_finite() || value < 0.0 || (place > 0 && value >= 60.0) {
            return Err(wrong());
        }
        seconds = seconds * 60.0 + value;
    }
    Ok(seconds)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_are_read_as_people_write_them() {
        for (text, seconds) in [
            ("90", 90.0),
            ("90s", 90.0),
            ("1:30", 90.0),
            ("1:02:30.5", 3750.5),
        ] {
            assert_eq!(parse_moment(text), Ok(seconds), "{text}");
        }
        for wrong in ["", "x", "1:60", "-1", "1:2:3:4", "1e999"] {
            assert!(parse_moment(wrong).is_err(), "{wrong}");
        }
    }
}
