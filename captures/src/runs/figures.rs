//! Figures of runs, listed and compared as text and on the screen.

use std::fmt;
use std::io::{self, Write};

use serde::Serialize;

use crate::statistics::{Damaged, Loss};
use crate::words::counted;

/// A place in the robot's frame: east and north, inches.
pub type Place = (f64, f64);

/// The figures of a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Figures {
    /// The capture.
    pub capture: String,
    /// The operator's name of the run.
    pub name: Option<String>,
    /// Reason why the run is void; `None` if it is valid.
    pub void: Option<String>,
    /// Number of marks.
    pub marks: usize,
    /// Start in UTC, `2025-03-14T09:26:53Z`; `None` of raw text without dates.
    pub start: Option<String>,
    /// Duration of the capture, seconds.
    pub duration_s: f64,
    /// Distance driven, inches.
    pub distance_in: f64,
    /// Distance from the end to the beginning or to the place of the last odometer reset, inches; `None` without a
    /// position.
    pub closing_error_in: Option<f64>,
    /// Number of contacts of the bumper.
    pub bumps: u32,
    /// Number of restarts of the robot.
    pub restarts: u64,
    /// Loss of lines.
    #[serde(flatten)]
    pub loss: Loss,
    /// Damaged lines.
    pub damaged: Damaged,
    /// Number of odometer resets during the run: restarts and set positions.
    pub odometer_resets: u32,
}

impl Figures {
    /// Start with minutes, `2025-03-14 09:26`; empty if unknown.
    #[must_use]
    pub fn started(&self) -> String {
        let minute = self.start.as_ref().and_then(|start| start.get(..16));
        minute.unwrap_or_default().replace('T', " ")
    }

    /// Returns a row of a narrow list of runs, without the run's name if that does not fit into `room` characters.
    #[must_use]
    pub fn short_row(&self, room: usize) -> String {
        let drive = self.drive();
        let whole = format!("{drive}  {}", self.names());
        if whole.chars().count() <= room {
            whole
        } else {
            format!("{drive}  {}", self.capture)
        }
    }

    /// Returns the figures that a narrow list leaves out.
    #[must_use]
    pub fn details(&self) -> String {
        let closing = self.closing_error_in.map_or_else(String::new, |error_in| {
            format!("closing error {error_in:.1} in, ")
        });
        let (bumps, loss) = (self.bumps, self.loss.share());
        let damaged = self.damaged.lines();
        format!("{closing}bumps {bumps}, loss {loss}, damaged {damaged}")
    }

    /// Start, duration and distance, in columns.
    fn drive(&self) -> String {
        let tenths = (self.duration_s * 10.0).round() as u64;
        let time = format!("{}:{:02}.{}", tenths / 600, tenths / 10 % 60, tenths % 10);
        let distance = format!("{:.1} in", self.distance_in);
        format!("{:16} {time:>8} {distance:>10}", self.started())
    }

    /// Returns the capture, the run's name, the number of its marks, and the reason why it does not count.
    #[must_use]
    pub fn names(&self) -> String {
        let name = self.name.as_ref().map(|name| format!("  {name}"));
        let marks = match self.marks {
            0 => String::new(),
            marks => format!("  ({})", counted(marks as u64, "mark")),
        };
        let void = match self.void.as_deref() {
            None | Some("") => String::new(),
            Some(reason) => format!("  (void: {reason})"),
        };
        format!("{}{}{marks}{void}", self.capture, name.unwrap_or_default())
    }
}

/// Header of a list of runs.
pub const HEADING: &str =
    "start (UTC)          time   distance  closing error  bumps   loss  damaged  capture";

/// Header of a narrow list of runs.
pub const SHORT_HEADING: &str = "start (UTC)          time   distance  capture";

/// A row of a list of runs.
impl fmt::Display for Figures {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let closing = self
            .closing_error_in
            .map_or_else(String::new, |error_in| format!("{error_in:.1} in"));
        let loss = if self.void.is_some() {
            "VOID".to_owned()
        } else {
            self.loss.short_share()
        };
        let (drive, bumps, names) = (self.drive(), self.bumps, self.names());
        let damaged = self.damaged.lines();
        write!(
            f,
            "{drive} {closing:>14} {bumps:>6} {loss:>6} {damaged:>8}  {names}"
        )
    }
}

/// Distance between two courses.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Apart {
    /// Mean over both courses, inches.
    pub mean_in: f64,
    /// Maximum, inches.
    pub worst_in: f64,
    /// Place of the maximum, inches.
    pub worst_at_in: Place,
}

/// A comparison of two runs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// Both runs.
    pub runs: [Figures; 2],
    /// Distance between their courses.
    pub apart: Option<Apart>,
}

impl Comparison {
    /// Writes the comparison as text.
    ///
    /// # Errors
    /// If writing the output fails.
    pub fn write_text(&self, output: &mut impl Write) -> io::Result<()> {
        let [a, b] = &self.runs;
        let mut row = |what: &str, a: String, b: String, more: String| {
            writeln!(
                output,
                "{}",
                format!("{what:14} {a:>18} {b:>18} {more:>14}").trim_end()
            )
        };
        let none = String::new;
        row("", "1".into(), "2".into(), "2 against 1".into())?;
        row("capture", short(&a.capture), short(&b.capture), none())?;
        row("start (UTC)", a.started(), b.started(), none())?;
        if a.name.is_some() || b.name.is_some() {
            let name = |run: &Figures| run.name.as_deref().map_or_else(none, short);
            row("name", name(a), name(b), none())?;
        }
        if a.void.is_some() || b.void.is_some() {
            let counts = |run: &Figures| if run.void.is_some() { "VOID" } else { "counts" };
            row("", counts(a).into(), counts(b).into(), none())?;
        }
        let figure = |value: f64, unit: &str| format!("{value:.1} {unit}");
        let more = |a: f64, b: f64, unit: &str| format!("{:+.1} {unit}", b - a);
        let (took_a, took_b) = (a.duration_s, b.duration_s);
        row(
            "time",
            figure(took_a, "s"),
            figure(took_b, "s"),
            more(took_a, took_b, "s"),
        )?;
        let (distance_a, distance_b) = (a.distance_in, b.distance_in);
        row(
            "distance",
            figure(distance_a, "in"),
            figure(distance_b, "in"),
            more(distance_a, distance_b, "in"),
        )?;
        if let (Some(error_a), Some(error_b)) = (a.closing_error_in, b.closing_error_in) {
            let of = |run: &Figures, error_in: f64| {
                if run.distance_in > 0.0 {
                    format!(
                        "{error_in:.1} in {:.1} %",
                        100.0 * error_in / run.distance_in
                    )
                } else {
                    figure(error_in, "in")
                }
            };
            row(
                "closing error",
                of(a, error_a),
                of(b, error_b),
                more(error_a, error_b, "in"),
            )?;
        }
        let bumps = i64::from(b.bumps) - i64::from(a.bumps);
        row(
            "bumps",
            a.bumps.to_string(),
            b.bumps.to_string(),
            format!("{bumps:+}"),
        )?;
        row("loss", a.loss.share(), b.loss.share(), none())?;
        let (damaged_a, damaged_b) = (a.damaged.lines(), b.damaged.lines());
        row(
            "damaged",
            damaged_a.to_string(),
            damaged_b.to_string(),
            none(),
        )?;
        if let Some(apart) = self.apart {
            let (x_in, y_in) = apart.worst_at_in;
            writeln!(
                output,
                "apart          {:.1} in on average, {:.1} in at worst, at ({x_in:.0}, {y_in:.0})",
                apart.mean_in, apart.worst_in
            )?;
        }
        for (number, run) in [(1, a), (2, b)] {
            if let Some(reason) = run.void.as_deref().filter(|reason| !reason.is_empty()) {
                writeln!(output, "run {number} is void: {reason}")?;
            }
            if run.odometer_resets > 0 {
                writeln!(
                    output,
                    "run {number} reset its odometer {}; closing error and path count from the last reset",
                    counted(run.odometer_resets.into(), "time")
                )?;
            }
        }
        Ok(())
    }
}

/// A name, or only the end of a long name, where captures differ.
fn short(name: &str) -> String {
    const WIDTH: usize = 18;
    let length = name.chars().count();
    if length <= WIDTH {
        return name.to_owned();
    }
    let tail: String = name.chars().skip(length - WIDTH + 2).collect();
    format!("..{tail}")
}

/// The runs in a folder.
#[derive(Clone, Debug, PartialEq)]
pub struct Listed {
    /// Name of the folder or the files.
    pub folder: String,
    /// Figures of the runs, the newest last.
    pub runs: Vec<Figures>,
    /// Problems, one line each.
    pub problems: Vec<String>,
}

/// Two runs and their courses.
#[derive(Clone, Debug, PartialEq)]
pub struct Overlaid {
    /// The comparison.
    pub comparison: Comparison,
    /// Places of both courses, in order.
    pub paths: [Vec<Place>; 2],
    /// Problems, one line each.
    pub problems: Vec<String>,
}
