//! The robot's track, with events and detected obstacles.

mod fold;
mod route;
mod thin;

use std::time::Duration;

use groundwave_protocol::decoder::{Arrival, Counters, Decoder};
use groundwave_protocol::status_codes::Layer;

use super::event::Truth;
use super::{Capture, CaptureError};
use crate::chunk::counters_until;
use crate::outages::Outage;
use crate::words::layer_word;
use fold::Fold;
pub(crate) use thin::simplify;

/// A place in the robot's frame: x and y, inches.
pub type Place = (f32, f32);

/// Behaviour that controlled the motors.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Holder {
    /// One of the layers.
    Layer(Layer),
    /// No layer: prowl.
    Prowl,
}

impl Holder {
    /// Name of the layer, or `prowl`.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Layer(layer) => layer_word(layer),
            Self::Prowl => "prowl",
        }
    }
}

/// A point of the track.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// X and Y, inches; positive east and north.
    pub place: Place,
    /// Behaviour that drove there.
    pub holder: Holder,
    /// Whether the odometer was reset since the previous point: the robot did not drive from there.
    pub is_apart: bool,
    /// Number of the point's line in the capture.
    pub line: u64,
}

/// Kind of event on the track.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Event {
    /// A bumper was pressed.
    Bump,
    /// A floor edge was detected.
    Edge,
    /// The wheels stalled.
    Stall,
    /// The robot booted; marked at its last place before the boot.
    Restart,
    /// The odometer was reset without a restart, usually by the operator; marked at the new place.
    OdometerReset,
    /// A time without lines; marked at the last place before.
    Outage,
}

impl Event {
    /// Every kind.
    pub const ALL: [Self; 6] = [
        Self::Bump,
        Self::Edge,
        Self::Stall,
        Self::Restart,
        Self::OdometerReset,
        Self::Outage,
    ];

    /// Name in a legend.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Bump => "bump",
            Self::Edge => "floor edge",
            Self::Stall => "stall",
            Self::Restart => "restart",
            Self::OdometerReset => "odometer reset",
            Self::Outage => "outage",
        }
    }
}

/// Events of one kind.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Events {
    /// Number of events; for bumps the robot's own count, which includes contacts that lines A miss.
    pub count: u32,
    /// Places of the first events, inches.
    pub places_in: Vec<Place>,
}

/// A waypoint that the robot drove to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DrivenTo {
    /// Number of its route in the capture, from 1.
    pub route: u32,
    /// Number in its route, from 1.
    pub number: u16,
    /// X and Y, inches.
    pub place_in: (i16, i16),
    /// Whether the robot reported that it arrived.
    pub is_reached: bool,
}

/// The track of a capture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Track {
    /// Points in order, thinned out where there are many.
    pub points: Vec<Point>,
    /// Tolerance of the thinning, inches; 0 if all points are kept.
    pub tolerance_in: f32,
    /// Numbers of the lines after gaps, in order: one for each gap between two points.
    pub gap_lines: Vec<u64>,
    /// Number of gaps, counted as in the summary.
    pub gaps: u64,
    /// Minimum number of lines lost, counted as in the summary.
    pub lines_lost: u64,
    /// Times without lines, as listed in the summary.
    pub outages: Vec<Outage>,
    /// Events, in the order of [`Event::ALL`].
    pub events: [Events; 6],
    /// Waypoints, by route and number.
    pub waypoints: Vec<DrivenTo>,
    /// The operator's marks, in order.
    pub marks: Vec<PlacedMark>,
    /// Places at which the sonars measured an echo, inches.
    pub echoes_in: Vec<Place>,
    /// Places of the robot's infrared detectors when they detected an obstacle, inches.
    pub infrared_in: Vec<Place>,
    /// The simulator's true walls.
    pub truth: Option<Truth>,
    /// Obstacles that were mapped, as rectangles along the axes: lower left and upper right corners, inches. Set by the caller, because
    /// this crate makes no maps.
    pub obstacles_in: Vec<[(f64, f64); 2]>,
    /// Distance driven, inches.
    pub distance_in: f64,
    /// Duration of the capture.
    pub duration: Duration,
    /// Start in UTC, from the metadata of a recording.
    pub start: Option<String>,
    /// Link of the session, from the metadata of a recording.
    pub link: Option<String>,
    /// Heading at the end, degrees clockwise from +Y.
    pub heading_deg: u16,
}

/// A mark of the operator.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedMark {
    /// Time since the capture began.
    pub at: Duration,
    /// Place of the robot at that time, inches.
    pub place_in: Place,
    /// Text; `None` if the mark has none.
    pub text: Option<String>,
}

/// A part of the track with one behaviour.
#[derive(Clone, Debug, PartialEq)]
pub struct Stretch {
    /// Behaviour that drove the part; `None` if lines are missing, so that the path is unknown.
    pub holder: Option<Holder>,
    /// Points of the part, at least two.
    pub places_in: Vec<Place>,
}

impl Track {
    /// Reads a whole capture; returns the track, and the reason if reading was incomplete.
    #[must_use]
    pub fn read(capture: &mut Capture) -> (Self, Option<CaptureError>) {
        let (track, _, problem) = Self::read_with(capture, Vec::new(), |_, _| {});
        (track, problem)
    }

    /// Reads a whole capture as [`Self::read`] does, with the times since its beginning and the texts of further marks. Calls `take` with
    /// each line and each repaired line A, and the time of its end, and also returns the decoder's totals.
    #[must_use]
    pub fn read_with(
        capture: &mut Capture,
        mut texts: Vec<(Duration, String)>,
        mut take: impl FnMut(Duration, &Arrival),
    ) -> (Self, Counters, Option<CaptureError>) {
        texts.sort_by_key(|(at, _)| *at);
        let mut fold = Fold::with_texts(texts);
        let mut decoder = Decoder::default();
        let result = fold.take_all(capture, &mut decoder, &mut take);
        let counters = counters_until(&decoder, capture.latest());
        (fold.finish(capture, &counters), counters, result.err())
    }

    /// The events of a kind.
    #[must_use]
    pub const fn events(&self, event: Event) -> &Events {
        &self.events[event as usize]
    }

    /// The parts of the track, in order.
    #[must_use]
    pub fn stretches(&self) -> Vec<Stretch> {
        thin::stretches(&self.points, &self.gap_lines)
            .into_iter()
            .map(|(holder, points)| Stretch {
                holder,
                places_in: points.iter().map(|point| point.place).collect(),
            })
            .collect()
    }

    /// The part of the track since the last odometer reset; it is in the frame of the capture's end.
    #[must_use]
    pub fn since_reset(mut self) -> Self {
        if let Some(start) = self.points.iter().rposition(|point| point.is_apart) {
            self.points.drain(..start);
        }
        self
    }
}

#[cfg(test)]
mod tests;
