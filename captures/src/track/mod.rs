//! The robot's track, the events on it and the obstacles around it.

mod fold;
mod route;
mod thin;

use std::time::Duration;

use groundwave_protocol::decoder::{Counters, Decoder, Received};
use groundwave_protocol::status_codes::Layer;

use super::event::Truth;
use super::{Capture, CaptureError};
use crate::outages::Outage;
use crate::words::layer_word;
use fold::Fold;
pub(crate) use thin::simplify;

/// A place in the robot's frame: x and y, inches.
pub type Place = (f32, f32);

/// Behaviour that held the motors.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Holder {
    /// One of the layers.
    Layer(Layer),
    /// None of them.
    Prowl,
}

impl Holder {
    /// Word of the layer, or `prowl`.
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
    /// Whether the odometer was reset since the point before: the robot did not drive from one to the other.
    pub is_apart: bool,
    /// Number of its line in the capture.
    pub line: u64,
}

/// Kind of event on the track.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Event {
    /// A bumper touched.
    Bump,
    /// A floor edge was detected.
    Edge,
    /// The wheels stalled.
    Stall,
    /// The robot booted; its last place before.
    Restart,
    /// The odometer was reset without a restart, mostly because the operator set the position; the new place.
    OdometerReset,
    /// A time without lines; the last place before.
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

    /// Word for a legend.
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
    /// Places of the first ones seen, inches.
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
    /// Tolerance with which the points were thinned out, inches; 0 if all are there.
    pub tolerance_in: f32,
    /// Numbers of the lines after gaps, in order; one for each gap that separates two points.
    pub gap_lines: Vec<u64>,
    /// Number of gaps, as a summary counts them.
    pub gaps: u64,
    /// Lines lost, as a summary counts them, at least.
    pub lines_lost: u64,
    /// Times without lines, as a summary lists them.
    pub outages: Vec<Outage>,
    /// Events, indexed as [`Event::ALL`].
    pub events: [Events; 6],
    /// Waypoints, by route and number.
    pub waypoints: Vec<DrivenTo>,
    /// Where the sonars measured an echo, inches.
    pub echoes_in: Vec<Place>,
    /// Where the robot's infrared detectors were when they detected an obstacle, inches.
    pub infrared_in: Vec<Place>,
    /// The simulator's true walls.
    pub truth: Option<Truth>,
    /// Distance driven, inches.
    pub distance_in: f64,
    /// Duration of the capture.
    pub duration: Duration,
    /// Start in UTC, and the link, from the metadata of a recording.
    pub start: Option<String>,
    /// The link it was recorded from.
    pub link: Option<String>,
    /// Heading at the end, degrees clockwise from +Y.
    pub heading_deg: u16,
}

/// A part of the track that is drawn in one way.
#[derive(Clone, Debug, PartialEq)]
pub struct Stretch {
    /// Behaviour that drove it; `None` where lines are missing and the path is not known.
    pub holder: Option<Holder>,
    /// Its points, at least two.
    pub places_in: Vec<Place>,
}

impl Track {
    /// Reads a whole capture; returns the track and the reason why it is incomplete, if it is.
    #[must_use]
    pub fn read(capture: &mut Capture) -> (Self, Option<CaptureError>) {
        let (track, _, problem) = Self::read_with(capture, |_, _| {});
        (track, problem)
    }

    /// As [`Self::read`]; calls `take` with each line and the time of its end, and returns the decoder's totals too.
    #[must_use]
    pub fn read_with(
        capture: &mut Capture,
        mut take: impl FnMut(Duration, &Received),
    ) -> (Self, Counters, Option<CaptureError>) {
        let mut fold = Fold::default();
        let mut decoder = Decoder::default();
        let result = fold.take_all(capture, &mut decoder, &mut take);
        (fold.finish(capture), *decoder.counters(), result.err())
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

    /// The track since the odometer was last reset, whose frame is the one at the end.
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
