//! Reads a track from the lines of a capture.

use std::collections::{HashSet, VecDeque};
use std::time::Duration;

use groundwave_protocol::decoder::{Arrival, Counters, Decoder, Received};
use groundwave_protocol::status_codes::{Bump, Cliff, Drive, Infrared, Mode};
use groundwave_protocol::telemetry::{Body, StateLine};

use super::route::Routes;
use super::thin::{interval, merge_gaps, reduce};
use super::{Event, Holder, Place, PlacedMark, Point, Track};
use crate::bumps::Bumps;
use crate::chunk::set_time;
use crate::event::{Mark, Moment};
use crate::gaps::Gaps;
use crate::marks::MARK_REACH;
use crate::odometer::{Odometer, Step};
use crate::outages::{Outage, OutageList};
use crate::pieces::Piece;
use crate::{Capture, CaptureError, Session};

/// Maximum number of points; a longer track is thinned out to half of that.
const POINTS_MAX: usize = 20_000;

/// Maximum number of places kept for each kind of event; the first ones are kept, all events are counted.
const EVENTS_MAX: usize = 2_000;

/// Maximum number of detections kept for each sensor, and the size of the cell that has one detection, inches.
const DETECTIONS_MAX: usize = 20_000;
const CELL_IN: f32 = 2.0;

/// Number of newest lines whose places are kept, because an outage is reported only at the next line C.
const PLACES_MAX: usize = 4096;

/// Minimum distance between two points, inches; shorter steps are joined.
const STEP_IN: f32 = 0.4;

/// Minimum tolerance of a thinned-out track, inches.
const TOLERANCE_IN: f32 = 0.05;

/// Radius of the robot, inches.
const RADIUS_IN: f32 = 5.5;

/// Angle of each sonar, and of each infrared detector, from straight ahead, degrees.
const SONAR_DEG: f32 = 7.5;
const INFRARED_DEG: f32 = 45.0;

/// Position of each sonar: distances ahead of the robot's centre and to the side, inches.
const SONAR_IN: (f32, f32) = (5.0, 1.5);

/// Maximum range of an echo that is shown, inches; farther echoes come from several reflections.
const ECHO_MAX_IN: u16 = 120;

#[derive(Default)]
pub(super) struct Fold {
    pub(super) track: Track,
    odometer: Odometer,
    last: Option<Point>,
    /// Whether the last point has been kept.
    is_kept: bool,
    gaps: Gaps,
    outages: OutageList,
    /// Time of the latest piece of any kind.
    latest: Duration,
    /// Number of outages with a place so far.
    located: usize,
    /// Times and places of the robot at the newest lines.
    places: VecDeque<(Duration, Place)>,
    counters: Counters,
    has_restarted: bool,
    /// Whether the next point is in another frame than the last.
    is_apart: bool,
    active: [bool; 2],
    bumps: Bumps,
    mode: Option<Mode>,
    routes: Routes,
    cells: [HashSet<(i32, i32)>; 2],
    /// Times and texts of the marks that are still to come, in order.
    texts: VecDeque<(Duration, String)>,
}

impl Fold {
    pub(super) fn with_texts(texts: Vec<(Duration, String)>) -> Self {
        Self {
            texts: texts.into(),
            ..Self::default()
        }
    }

    pub(super) fn take_all(
        &mut self,
        capture: &mut Capture,
        decoder: &mut Decoder,
        take: &mut impl FnMut(Duration, &Arrival),
    ) -> Result<(), CaptureError> {
        let end = loop {
            let has_time = match capture.has_time_ahead() {
                Ok(has_time) => has_time,
                Err(error) => break Err(error),
            };
            let (at, piece) = match capture.next_piece() {
                Ok(Some(piece)) => piece,
                end => break end.map(drop),
            };
            self.latest = at;
            match piece {
                Piece::Received(mut bytes) => {
                    if !bytes.is_empty() {
                        self.track.duration = at;
                    }
                    if has_time {
                        set_time(decoder, at);
                    }
                    while let Some(arrival) = decoder.next_arrival(&mut bytes) {
                        if let Arrival::Line(received) = &arrival {
                            self.outages.handle_line(at, received, decoder.counters());
                            self.locate_outages();
                            self.take(at, received, decoder.counters());
                        }
                        take(at, &arrival);
                    }
                }
                Piece::Event(event) => {
                    if event.is_loss_of_link() {
                        self.interrupt(decoder);
                    }
                    self.outages.handle_event(at, &event);
                    self.locate_outages();
                    self.routes.take_event(&event);
                    if let Some(mark) = event.mark() {
                        self.take_mark(at, mark, capture.marks().moments());
                    }
                }
                Piece::Missing(_) | Piece::Damaged(_) => {
                    decoder.skip();
                    self.gaps.interrupt();
                    self.outages.handle_missing();
                    self.locate_outages();
                }
                Piece::Sent(_) | Piece::Repeated(_) => {}
            }
        };
        let at = self.latest;
        for received in decoder.undecided_lines() {
            self.outages.handle_line(at, &received, decoder.counters());
            self.locate_outages();
            self.take(at, &received, decoder.counters());
            take(at, &Arrival::Line(received));
        }
        end
    }

    pub(super) const fn interrupt(&mut self, decoder: &mut Decoder) {
        decoder.interrupt();
        self.gaps.interrupt();
    }

    /// Takes a line, with the decoder's counts after it.
    pub(super) fn take(&mut self, at: Duration, received: &Received, counters: &Counters) {
        if let Some(line) = self.gaps.take_line(at, received, counters) {
            self.add_gap(line);
        }
        if counters.restarts > self.counters.restarts {
            self.has_restarted = true;
            self.happen(Event::Restart, self.place());
        }
        self.counters = *counters;
        while let Some((marked, text)) = self.texts.pop_front_if(|(mark, _)| *mark < at) {
            self.mark(marked, self.place(), Some(text));
        }
        let step = self.odometer.take(at, received);
        if let Some((Step::Reset, (x_in, y_in))) = step {
            self.is_apart = true;
            if !std::mem::take(&mut self.has_restarted) {
                self.happen(Event::OdometerReset, (x_in as f32, y_in as f32));
            }
        }
        if let Received::Line(line, _) = received {
            self.take_body(&line.body, step.map(|(step, _)| step));
        }
        self.places.push_back((at, self.place()));
        if self.places.len() > PLACES_MAX {
            self.places.pop_front();
        }
    }

    fn take_body(&mut self, body: &Body, step: Option<Step>) {
        match body {
            Body::State(state) => {
                self.mode = Some(state.mode);
                self.take_state(state, step);
            }
            Body::Status(status) => self.routes.take_status(self.mode, status),
            Body::Counters(counters) => self.bumps.take_counters(counters),
            _ => {}
        }
    }

    fn take_state(&mut self, state: &StateLine, step: Option<Step>) {
        let place = (
            state.x_tenths_in as f32 / 10.0,
            state.y_tenths_in as f32 / 10.0,
        );
        let point = Point {
            place,
            holder: state.layers.holder().map_or(Holder::Prowl, Holder::Layer),
            is_apart: std::mem::take(&mut self.is_apart) || step == Some(Step::First),
            line: self.counters.received(),
        };
        self.track.heading_deg = state.theta_deg;
        self.add(point);
        self.last = Some(point);
        if self.bumps.take_state(state) {
            let side_deg = match state.bump {
                Bump::Left => -45.0,
                Bump::LeftCenter => -22.5,
                Bump::RightCenter => 22.5,
                Bump::Right => 45.0,
                _ => 0.0,
            };
            let touched = ahead(place, f32::from(state.theta_deg) + side_deg, RADIUS_IN);
            self.happen(Event::Bump, touched);
        }
        let now = [
            !matches!(state.cliff, Cliff::None | Cliff::NotFitted),
            state.drive == Drive::Stalled,
        ];
        let before = std::mem::replace(&mut self.active, now);
        let events = [Event::Edge, Event::Stall];
        for (event, (now, before)) in events.into_iter().zip(now.into_iter().zip(before)) {
            if now && !before {
                self.happen(event, place);
            }
        }
        self.detect(state, place);
    }

    /// Adds the detections of the sonars and the infrared detectors.
    fn detect(&mut self, state: &StateLine, place: Place) {
        let heading_deg = f32::from(state.theta_deg);
        let sonars = [(-1.0, state.sonar_left_in), (1.0, state.sonar_right_in)];
        for (side, range_in) in sonars {
            if let Some(range_in) = range_in.filter(|range_in| *range_in <= ECHO_MAX_IN) {
                let (forward_in, aside_in) = SONAR_IN;
                let eye = ahead(
                    ahead(place, heading_deg, forward_in),
                    heading_deg + 90.0 * side,
                    aside_in,
                );
                let echo = ahead(eye, heading_deg + side * SONAR_DEG, f32::from(range_in));
                note(&mut self.cells[0], &mut self.track.echoes_in, echo);
            }
        }
        let infrared = [
            (
                -1.0,
                matches!(state.infrared, Infrared::Left | Infrared::Both),
            ),
            (
                1.0,
                matches!(state.infrared, Infrared::Right | Infrared::Both),
            ),
        ];
        for (side, detects) in infrared {
            if detects {
                let at = ahead(place, heading_deg + side * INFRARED_DEG, RADIUS_IN);
                note(&mut self.cells[1], &mut self.track.infrared_in, at);
            }
        }
    }

    fn add(&mut self, point: Point) {
        let points = &mut self.track.points;
        self.is_kept = !points.last().is_some_and(|last| {
            let (x, y) = last.place;
            let is_short = (point.place.0 - x).hypot(point.place.1 - y) < STEP_IN;
            is_short && !point.is_apart && point.holder == last.holder
        });
        if !self.is_kept {
            return;
        }
        points.push(point);
        if points.len() >= POINTS_MAX {
            let tolerance_in = self.track.tolerance_in.max(TOLERANCE_IN);
            self.track.tolerance_in = reduce(
                points,
                &mut self.track.gap_lines,
                POINTS_MAX / 2,
                tolerance_in,
            );
        }
    }

    fn add_gap(&mut self, line: u64) {
        let Track {
            points, gap_lines, ..
        } = &mut self.track;
        let place = |line| interval(points, line);
        if gap_lines
            .last()
            .is_none_or(|last| place(*last) != place(line))
        {
            gap_lines.push(line);
        }
    }

    /// Adds the outages that have ended since the last call, at the place of the line where they began.
    fn locate_outages(&mut self) {
        while let Some(outage) = self.outages.ended().get(self.located) {
            let outage = *outage;
            self.locate(&outage);
        }
    }

    fn locate(&mut self, outage: &Outage) {
        self.happen(Event::Outage, self.place_at(outage.begin));
        self.located += 1;
    }

    /// Takes a mark of a recording, with the moments of all that are set.
    fn take_mark(&mut self, now: Duration, mark: Mark, set: &[Moment]) {
        let marks = &mut self.track.marks;
        marks.retain(|known| known.text.is_some() || set.contains(&known.at));
        let at = now.checked_sub(mark.ago).filter(|at| set.contains(at));
        if let Some(at) = at.filter(|_| mark.is_set) {
            self.mark(at, self.place_at(at), None);
        }
    }

    fn mark(&mut self, at: Duration, place_in: Place, text: Option<String>) {
        self.track.marks.push(PlacedMark { at, place_in, text });
    }

    /// The robot's place at a time.
    fn place_at(&self, time: Duration) -> Place {
        let after = self.places.partition_point(|(at, _)| *at <= time);
        let before = self.places.get(after.saturating_sub(1));
        before.map_or_else(|| self.place(), |(_, place)| *place)
    }

    /// The robot's place.
    fn place(&self) -> Place {
        self.last.map_or((0.0, 0.0), |point| point.place)
    }

    fn happen(&mut self, event: Event, place: Place) {
        let events = &mut self.track.events[event as usize];
        events.count += 1;
        if events.places_in.len() < EVENTS_MAX {
            events.places_in.push(place);
        }
    }

    /// The track, with the metadata of its capture.
    pub(super) fn finish(mut self, capture: &Capture, counters: &Counters) -> Track {
        self.end(counters);
        let session = capture.session();
        let said = |key: &str| session?.get(key).cloned();
        self.track.start = said("start");
        self.track.link = said("link");
        self.track.truth = said(Session::TRUTH).and_then(|truth| serde_json::from_str(&truth).ok());
        self.track
    }

    /// Completes the track at the end of its lines, with the decoder's totals.
    pub(super) fn end(&mut self, counters: &Counters) {
        self.track.gaps = self.gaps.count();
        while let Some(line) = self.gaps.settle() {
            self.add_gap(line);
        }
        if let Some(last) = self.last
            && !self.is_kept
        {
            self.track.points.push(last);
        }
        for (at, text) in std::mem::take(&mut self.texts) {
            self.mark(at, self.place(), Some(text));
        }
        let marks = &mut self.track.marks;
        let texts = marks.iter().filter(|mark| mark.text.is_some());
        let texts: Vec<Duration> = texts.map(|mark| mark.at).collect();
        let is_near = |at: Duration| texts.iter().any(|text| text.abs_diff(at) < MARK_REACH);
        marks.retain(|mark| mark.text.is_some() || !is_near(mark.at));
        marks.sort_by_key(|mark| mark.at);
        let Track {
            points, gap_lines, ..
        } = &mut self.track;
        merge_gaps(points, gap_lines);
        self.track.lines_lost = self.counters.lost().min;
        let outages = std::mem::take(&mut self.outages);
        self.track.outages = outages.into_outages(self.latest, counters);
        for outage in self.track.outages.clone().iter().skip(self.located) {
            self.locate(outage);
        }
        self.track.events[Event::Bump as usize].count = self.bumps.total();
        self.track.distance_in = self.odometer.distance_in;
        self.track.waypoints = std::mem::take(&mut self.routes.waypoints);
    }
}

/// The place at a distance in a direction, degrees clockwise from +Y.
fn ahead((x_in, y_in): Place, direction_deg: f32, distance_in: f32) -> Place {
    let (sin, cos) = direction_deg.to_radians().sin_cos();
    (x_in + distance_in * sin, y_in + distance_in * cos)
}

/// Adds a detection, at most one in each cell.
fn note(cells: &mut HashSet<(i32, i32)>, places: &mut Vec<Place>, place: Place) {
    let cell = |at_in: f32| (at_in / CELL_IN).round() as i32;
    if places.len() < DETECTIONS_MAX && cells.insert((cell(place.0), cell(place.1))) {
        places.push(place);
    }
}
