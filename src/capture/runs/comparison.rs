//! How two runs differ.

use std::io::{self, Write};

use serde::Serialize;

use super::Course;
use super::course::{Place, way};

/// Places compared; more would say nothing new and take time by the square.
const PLACES_MAX: usize = 2048;

/// What a run amounts to.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Figures {
    /// The capture.
    pub capture: String,
    /// What its operator calls it.
    pub name: Option<String>,
    /// Why it does not count.
    pub void: Option<String>,
    /// From the first report of its course to the last, seconds.
    pub duration_s: f64,
    /// Way driven, inches.
    pub distance_in: f64,
    /// From where it ended back to where it began, inches; none without a report.
    pub closing_error_in: Option<f64>,
    /// Contacts of the bumper.
    pub bumps: u32,
    /// How often the odometer was set in the middle; the figures are of what came after the last time.
    pub restarts: u32,
}

impl Figures {
    /// Those of a course.
    #[must_use]
    pub fn of(capture: String, label: super::Label, course: &Course) -> Self {
        Self {
            capture,
            name: label.name,
            void: label.void,
            duration_s: course.duration().as_secs_f64(),
            distance_in: course.distance_in,
            closing_error_in: course.closing_error_in(),
            bumps: course.bumps(),
            restarts: course.restarts,
        }
    }
}

/// How far two courses are from each other.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Apart {
    /// On average over both courses, inches.
    pub mean_in: f64,
    /// At most, inches.
    pub worst_in: f64,
    /// Where on one of them, inches.
    pub worst_at_in: Place,
}

impl Apart {
    /// From each place of either course to the nearest of the other; `None` when one has no place.
    ///
    /// Both are taken as they were reported: in the robot's own frame, as it was last set.
    #[must_use]
    pub fn between(a: &Course, b: &Course) -> Option<Self> {
        let (a, b) = (places(a), places(b));
        if a.is_empty() || b.is_empty() {
            return None;
        }
        let mut sum_in = 0.0;
        let mut worst = (0.0, a[0]);
        for (own, other) in [(&a, &b), (&b, &a)] {
            for &place in own {
                let apart_in = nearest_in(place, other);
                sum_in += apart_in;
                if apart_in > worst.0 {
                    worst = (apart_in, place);
                }
            }
        }
        Some(Self {
            mean_in: sum_in / (a.len() + b.len()) as f64,
            worst_in: worst.0,
            worst_at_in: worst.1,
        })
    }
}

fn places(course: &Course) -> Vec<Place> {
    let points = course.points();
    let every = points.len().div_ceil(PLACES_MAX).max(1);
    points.iter().copied().step_by(every).collect()
}

/// From a place to a line through others, inches.
fn nearest_in(place: Place, line: &[Place]) -> f64 {
    let alone = way(place, line[0]);
    line.windows(2)
        .map(|piece| from_piece_in(place, piece[0], piece[1]))
        .fold(alone, f64::min)
}

fn from_piece_in(place: Place, from: Place, to: Place) -> f64 {
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let square = dx * dx + dy * dy;
    let part = if square > 0.0 {
        (((place.0 - from.0) * dx + (place.1 - from.1) * dy) / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    way(place, (from.0 + part * dx, from.1 + part * dy))
}

/// Two runs side by side.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// The one and the other.
    pub runs: [Figures; 2],
    /// Between their courses.
    pub apart: Option<Apart>,
}

impl Comparison {
    /// Writes it for a person.
    ///
    /// # Errors
    /// When the output takes no more.
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
        let (way_a, way_b) = (a.distance_in, b.distance_in);
        row(
            "way",
            figure(way_a, "in"),
            figure(way_b, "in"),
            more(way_a, way_b, "in"),
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
            if run.restarts > 0 {
                writeln!(
                    output,
                    "run {number} set its odometer anew {} times: compared is what came after the last",
                    run.restarts
                )?;
            }
        }
        Ok(())
    }
}

/// The end of a long name: that is where captures differ.
fn short(name: &str) -> String {
    const WIDTH: usize = 18;
    let length = name.chars().count();
    if length <= WIDTH {
        return name.to_owned();
    }
    let tail: String = name.chars().skip(length - WIDTH + 2).collect();
    format!("..{tail}")
}

#[cfg(test)]
mod tests {
    use super::super::Label;
    use super::super::course::tests::through;
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn parallel_courses_are_as_far_apart_as_they_are_drawn() {
        let a = through(&[(0.0, 0.0), (10.0, 0.0), (20.0, 0.0)]);
        let b = through(&[(0.0, 4.0), (10.0, 4.0), (20.0, 4.0)]);
        let apart = Apart::between(&a, &b).unwrap();
        assert!((apart.mean_in - 4.0).abs() < 1e-9);
        assert!((apart.worst_in - 4.0).abs() < 1e-9);
    }

    #[test]
    fn an_excursion_is_found_where_it_was() {
        let a = through(&[(0.0, 0.0), (20.0, 0.0), (40.0, 0.0)]);
        let b = through(&[(0.0, 0.0), (20.0, 12.0), (40.0, 0.0)]);
        let apart = Apart::between(&a, &b).unwrap();
        assert!((apart.worst_in - 12.0).abs() < 1e-9);
        assert_eq!(apart.worst_at_in, (20.0, 12.0));
    }

    proptest! {
        #[test]
        fn a_track_is_nowhere_apart_from_itself_and_both_ways_are_one(
            a in proptest::collection::vec((-20.0..20.0_f64, -20.0..20.0_f64), 1..30),
            b in proptest::collection::vec((-20.0..20.0_f64, -20.0..20.0_f64), 1..30),
        ) {
            let (a, b) = (through(&a), through(&b));
            let own = Apart::between(&a, &a).unwrap();
            prop_assert!(own.worst_in < 1e-9);
            let there = Apart::between(&a, &b).unwrap();
            let back = Apart::between(&b, &a).unwrap();
            prop_assert!((there.worst_in - back.worst_in).abs() < 1e-9);
            prop_assert!(there.mean_in <= there.worst_in + 1e-9);
        }
    }

    #[test]
    fn a_person_reads_what_differs() {
        let a = through(&[(0.0, 0.0), (20.0, 0.0), (0.0, 1.0)]);
        let b = through(&[(0.0, 0.0), (20.0, 0.0), (0.0, 5.0)]);
        let void = Label {
            void: Some("the cat".to_owned()),
            ..Label::default()
        };
        let comparison = Comparison {
            runs: [
                Figures::of("a.mcap".into(), Label::default(), &a),
                Figures::of("b.mcap".into(), void, &b),
            ],
            apart: Apart::between(&a, &b),
        };
        let mut text = Vec::new();
        comparison.write_text(&mut text).unwrap();
        let text = String::from_utf8(text).unwrap();
        for fact in ["a.mcap", "VOID", "+4.0 in", "the cat", "closing error"] {
            assert!(text.contains(fact), "{fact} is not in\n{text}");
        }
    }
}
