//! The robot's track and the events on it.

use std::time::Duration;

use groundwave_protocol::decoder::{Decoder, Received};
use groundwave_protocol::status_codes::{Cliff, Drive, Layer};
use groundwave_protocol::telemetry::{Body, Line, StateLine};

use super::bumps::Bumps;
use super::odometer::{can_be_driven, seconds_of, slots_between};
use super::{Capture, CaptureError};
use crate::words::layer_word;

/// Maximum points; a longer track is thinned out.
const POINTS_MAX: usize = 20_000;

/// Maximum places kept of each kind of event, the first ones; all events are counted.
const EVENTS_MAX: usize = 2_000;

/// Minimum distance of two points, inches; shorter steps are joined.
const STEP_IN: f32 = 0.4;

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

/// How a point follows the one before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Joint {
    /// The robot drove straight from one to the other, as it reported.
    Driven,
    /// Lines between them were lost: the track there is unknown.
    Guessed,
    /// The odometer was reset.
    Apart,
}

/// A point of the track.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// X, inches; positive east.
    pub x_in: f32,
    /// Y, inches; positive north.
    pub y_in: f32,
    /// Behaviour that drove there.
    pub holder: Holder,
    /// Link to the point before it.
    pub joint: Joint,
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
    /// The robot booted.
    Restart,
}

impl Event {
    /// Every kind.
    pub const ALL: [Self; 4] = [Self::Bump, Self::Edge, Self::Stall, Self::Restart];

    /// Word for a legend.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Bump => "bump",
            Self::Edge => "edge of the floor",
            Self::Stall => "stall",
            Self::Restart => "restart",
        }
    }
}

/// Events of one kind.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Events {
    /// Number of events; for bumps the robot's own count, which includes contacts that lines A miss.
    pub count: u32,
    /// Places of the first ones seen, inches.
    pub places_in: Vec<(f32, f32)>,
}

/// The track of a capture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Track {
    /// Points in order, thinned out where there are many.
    pub points: Vec<Point>,
    /// Events, indexed as [`Event::ALL`].
    pub events: [Events; 4],
    /// Distance driven, inches.
    pub distance_in: f64,
    /// Duration of the capture.
    pub duration: Duration,
    /// Heading at the end, degrees clockwise from +Y.
    pub heading_deg: u16,
}

impl Track {
    /// Reads a whole capture; returns the track and the reason why it is incomplete, if it is.
    #[must_use]
    pub fn read(capture: &mut Capture) -> (Self, Option<CaptureError>) {
        let mut fold = Fold::default();
        let mut decoder = Decoder::default();
        let result = capture.for_each_line(&mut decoder, |_, received| {
            if let Received::Line(line, _) = received {
                fold.take(line);
            }
            Ok::<_, CaptureError>(())
        });
        fold.finish();
        let track = Self {
            duration: capture.end(),
            ..fold.track
        };
        (track, result.err())
    }

    /// The events of a kind.
    #[must_use]
    pub const fn events(&self, event: Event) -> &Events {
        &self.events[event as usize]
    }

    /// Least and greatest x and y, inches; `None` without a point.
    #[must_use]
    pub fn bounds_in(&self) -> Option<[(f32, f32); 2]> {
        let first = self.points.first()?;
        let start = [(first.x_in, first.x_in), (first.y_in, first.y_in)];
        Some(self.points.iter().fold(start, |[x, y], point| {
            let wider = |(least, most): (f32, f32), at: f32| (least.min(at), most.max(at));
            [wider(x, point.x_in), wider(y, point.y_in)]
        }))
    }
}

#[derive(Default)]
struct Fold {
    track: Track,
    step_in: f32,
    last: Option<(Point, u8)>,
    /// Whether the last point has been kept.
    is_kept: bool,
    active: [bool; 2],
    bumps: Bumps,
    boots: Option<u16>,
}

impl Fold {
    fn take(&mut self, line: &Line) {
        match &line.body {
            Body::State(state) => self.take_state(line.sequence, state),
            Body::Counters(counters) => {
                self.bumps.take_counters(counters);
                let boots = self.boots.replace(counters.boots);
                if boots.is_some_and(|boots| boots != counters.boots) {
                    self.happen(Event::Restart);
                }
            }
            _ => {}
        }
    }

    fn take_state(&mut self, sequence: u8, state: &StateLine) {
        let mut point = Point {
            x_in: state.x_tenths_in as f32 / 10.0,
            y_in: state.y_tenths_in as f32 / 10.0,
            holder: state.layers.holder().map_or(Holder::Prowl, Holder::Layer),
            joint: Joint::Apart,
        };
        self.track.heading_deg = state.theta_deg;
        if let Some((last, before)) = self.last {
            let slots = slots_between(before, sequence);
            let step_in = (point.x_in - last.x_in).hypot(point.y_in - last.y_in);
            if state.drive != Drive::OdometerReset
                && can_be_driven(step_in.into(), seconds_of(slots))
            {
                self.track.distance_in += f64::from(step_in);
                // Two lines in six carry no position.
                let is_near = slots <= 3;
                point.joint = if is_near {
                    Joint::Driven
                } else {
                    Joint::Guessed
                };
            }
        }
        self.add(point);
        self.last = Some((point, sequence));
        if self.bumps.take_state(state) {
            self.happen(Event::Bump);
        }
        let now = [
            !matches!(state.cliff, Cliff::None | Cliff::NotFitted),
            state.drive == Drive::Stalled,
        ];
        let before = std::mem::replace(&mut self.active, now);
        let events = [Event::Edge, Event::Stall];
        for (event, (now, before)) in events.into_iter().zip(now.into_iter().zip(before)) {
            if now && !before {
                self.happen(event);
            }
        }
    }

    fn add(&mut self, point: Point) {
        let points = &mut self.track.points;
        let step_in = self.step_in.max(STEP_IN);
        self.is_kept = !points.last().is_some_and(|last| {
            let is_short = (point.x_in - last.x_in).hypot(point.y_in - last.y_in) < step_in;
            is_short && point.joint != Joint::Apart && point.holder == last.holder
        });
        if !self.is_kept {
            return;
        }
        points.push(point);
        if points.len() >= POINTS_MAX {
            self.step_in = step_in * 2.0;
            thin(points, self.step_in);
            // Distance alone does not thin out a track that changes its behaviour at each point.
            if points.len() > POINTS_MAX / 2 {
                let mut place = 0;
                points.retain(|point| {
                    place += 1;
                    place % 2 == 0 || point.joint == Joint::Apart
                });
                points.truncate(POINTS_MAX / 2 + POINTS_MAX / 4);
            }
        }
    }

    fn happen(&mut self, event: Event) {
        let place = self.last.map_or((0.0, 0.0), |(p, _)| (p.x_in, p.y_in));
        let events = &mut self.track.events[event as usize];
        events.count += 1;
        if events.places_in.len() < EVENTS_MAX {
            events.places_in.push(place);
        }
    }

    fn finish(&mut self) {
        self.track.events[Event::Bump as usize].count = self.bumps.total();
        if let Some((last, _)) = self.last
            && !self.is_kept
        {
            self.track.points.push(last);
        }
    }
}

/// Removes points nearer than `step_in` inches to the point kept before them.
fn thin(points: &mut Vec<Point>, step_in: f32) {
    let mut last: Option<Point> = None;
    points.retain(|point| {
        let keeps = last.is_none_or(|last| {
            let step = (point.x_in - last.x_in).hypot(point.y_in - last.y_in);
            step >= step_in || point.joint == Joint::Apart || point.holder != last.holder
        });
        if keeps {
            last = Some(*point);
        }
        keeps
    });
}
