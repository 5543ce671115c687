//! The robot's track and the events on it.

use std::time::Duration;

use groundwave_protocol::decoder::{Counters, Decoder, Received};
use groundwave_protocol::status_codes::{Cliff, Drive, Layer};
use groundwave_protocol::telemetry::{Body, StateLine};

use super::bumps::Bumps;
use super::odometer::{Odometer, Step};
use super::source::Chunk;
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
    /// Lines between them were lost, or the link was interrupted: the track there is unknown.
    Guessed,
    /// The odometer was reset: there is no track between them.
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
        let result = fold.take_all(capture);
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
    odometer: Odometer,
    last: Option<Point>,
    /// Whether the last point has been kept.
    is_kept: bool,
    /// Whether the link was interrupted since the last point.
    is_interrupted: bool,
    /// Lines lost until the last point, and restarts of the robot, as the decoder counts them.
    lines_lost: u64,
    restarts: u64,
    active: [bool; 2],
    bumps: Bumps,
}

impl Fold {
    fn take_all(&mut self, capture: &mut Capture) -> Result<(), CaptureError> {
        let mut decoder = Decoder::default();
        while let Some(Chunk {
            at,
            mut bytes,
            is_interrupted,
        }) = capture.next_chunk()?
        {
            if is_interrupted {
                decoder.interrupt();
                self.is_interrupted = true;
            }
            while let Some(received) = decoder.next_line(&mut bytes) {
                self.take(at, &received, decoder.counters());
            }
        }
        Ok(())
    }

    fn take(&mut self, at: Duration, received: &Received, counters: &Counters) {
        if counters.restarts > self.restarts {
            self.restarts = counters.restarts;
            self.happen(Event::Restart);
        }
        let step = self.odometer.take(at, received);
        let Received::Line(line, _) = received else {
            return;
        };
        match &line.body {
            Body::State(state) => {
                let joint = match step {
                    Some((Step::Driven, _)) if self.is_gap(counters) => Joint::Guessed,
                    Some((Step::Driven, _)) => Joint::Driven,
                    _ => Joint::Apart,
                };
                self.lines_lost = counters.lines_lost;
                self.is_interrupted = false;
                self.take_state(state, joint);
            }
            Body::Counters(counters) => self.bumps.take_counters(counters),
            _ => {}
        }
    }

    /// Whether lines are missing since the last point.
    const fn is_gap(&self, counters: &Counters) -> bool {
        self.is_interrupted || counters.lines_lost > self.lines_lost
    }

    fn take_state(&mut self, state: &StateLine, joint: Joint) {
        let point = Point {
            x_in: state.x_tenths_in as f32 / 10.0,
            y_in: state.y_tenths_in as f32 / 10.0,
            holder: state.layers.holder().map_or(Holder::Prowl, Holder::Layer),
            joint,
        };
        self.track.heading_deg = state.theta_deg;
        self.add(point);
        self.last = Some(point);
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
        let place = self.last.map_or((0.0, 0.0), |p| (p.x_in, p.y_in));
        let events = &mut self.track.events[event as usize];
        events.count += 1;
        if events.places_in.len() < EVENTS_MAX {
            events.places_in.push(place);
        }
    }

    fn finish(&mut self) {
        self.track.events[Event::Bump as usize].count = self.bumps.total();
        self.track.distance_in = self.odometer.distance_in;
        if let Some(last) = self.last
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

#[cfg(test)]
mod tests {
    use super::*;
    use groundwave_protocol::telemetry::{Ack, AckLine, Line};

    fn received(sequence: u8, boot: u8, x_tenths_in: i16) -> Received {
        let state = StateLine {
            x_tenths_in: x_tenths_in.into(),
            ..StateLine::BLANK
        };
        let line = Line {
            sequence,
            body: Body::State(state),
            ack: Ack {
                boot,
                ..Ack::default()
            },
        };
        Received::Line(line, line.encode())
    }

    /// Joints of a track that is read from lines, each with the lines lost until then.
    fn joints(lines: &[(Received, u64)]) -> Vec<Joint> {
        let mut fold = Fold::default();
        for (received, lines_lost) in lines {
            let counters = Counters {
                lines_lost: *lines_lost,
                ..Counters::default()
            };
            fold.take(Duration::ZERO, received, &counters);
        }
        fold.track.points.iter().map(|point| point.joint).collect()
    }

    #[test]
    fn many_acknowledgements_between_two_positions_are_no_gap() {
        let k = |sequence| {
            let ack = Ack::default();
            let listens = false;
            let line = AckLine {
                sequence,
                ack,
                listens,
            };
            (Received::Ack(line), 0)
        };
        let mut lines = vec![(received(0, 0, 0), 0)];
        lines.extend((1..9).map(k));
        lines.push((received(9, 0, 50), 0));
        assert_eq!(joints(&lines), [Joint::Apart, Joint::Driven]);
        lines.push((received(11, 0, 60), 1));
        assert_eq!(joints(&lines)[2..], [Joint::Guessed]);
    }

    #[test]
    fn a_restart_is_no_line_across_the_house() {
        let lines = [(received(0, 0, 500), 0), (received(40, 1, 0), 0)];
        assert_eq!(joints(&lines), [Joint::Apart, Joint::Apart]);
    }
}
