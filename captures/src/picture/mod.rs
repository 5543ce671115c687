//! Pictures of runs, as SVG and PNG.
//!
//! A picture is laid out once, as shapes and outlines of letters; SVG and PNG draw the same shapes. The colours of behaviours are
//! those of Okabe and Ito, which colour-blind people can distinguish; each kind of event also has its own shape.

mod drive;
mod font;
mod mark;
mod pair;
mod png;
mod shape;
mod sheet;
mod svg;

pub use pair::Run;

use super::error::CaptureError;
use super::track::Track;
use font::Font;
use shape::Layer;

/// Width of the outline that makes letters bold, ems.
const BOLD: f32 = 0.035;

/// Tolerance of a drawn path, pixels: maximum distance of an omitted place from the line.
const TOLERANCE: f32 = 0.25;

/// A picture, laid out.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Width and height, pixels.
    size: (f32, f32),
    title: String,
    layers: Vec<Layer>,
}

impl Picture {
    /// Draws a track, with the names of its capture and, if it has one, of its run, and the reason why the capture is incomplete;
    /// returns `None` if there is no position.
    #[must_use]
    pub fn of_track(
        name: &str,
        run: Option<&str>,
        track: &Track,
        problem: Option<&CaptureError>,
    ) -> Option<Self> {
        drive::draw(name, run, track, problem)
    }

    /// Draws two runs over each other, each from its last odometer reset; returns `None` if one has no position.
    #[must_use]
    pub fn of_pair(runs: [&Run<'_>; 2]) -> Option<Self> {
        pair::draw(runs)
    }

    /// The picture as SVG.
    #[must_use]
    pub fn svg(&self) -> String {
        svg::draw(self, &Font::load())
    }

    /// The picture as PNG, with twice the SVG's resolution.
    ///
    /// # Errors
    /// If encoding fails.
    pub fn png(&self) -> Result<Vec<u8>, String> {
        png::draw(self, &Font::load())
    }
}

/// A time as `2 min 5 s`, from an hour on as `8 h 0 min`.
fn time_words(time: std::time::Duration) -> String {
    let s = time.as_secs_f64().round() as u64;
    match (s / 3600, s / 60 % 60, s % 60) {
        (0, 0, s) => format!("{s} s"),
        (0, minutes, s) => format!("{minutes} min {s} s"),
        (hours, minutes, _) => format!("{hours} h {minutes} min"),
    }
}

/// A distance as `4.2 ft`, from 100 ft on as `120 ft`.
fn feet_words(distance_in: f64) -> String {
    let feet = distance_in / 12.0;
    if feet < 99.95 {
        format!("{feet:.1} ft")
    } else {
        format!("{feet:.0} ft")
    }
}

/// `2025-03-14T09:26:53Z` as `2025-03-14 09:26 UTC`; other text unchanged.
fn date_words(start: &str) -> String {
    match (start.get(..10), start.get(10..16)) {
        (Some(day), Some(time)) if time.starts_with('T') && start.ends_with('Z') => {
            format!("{day} {} UTC", &time[1..])
        }
        _ => start.to_owned(),
    }
}

#[cfg(test)]
mod tests;
