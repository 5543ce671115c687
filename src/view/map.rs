//! The map: the robot, its trail, its route and its encounters.

use groundwave_mapping::{CorrectedPose, Ellipse};
use groundwave_protocol::Waypoint;
use groundwave_protocol::telemetry::Reading;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};

use super::estimate::dashed_ellipse;
use super::pixels::{FINE, Picture};
use super::pointer::Mark;
use super::projection::Projection;
use super::raster::{Ink, Raster};
use super::{Screen, columns, fill, put, put_right, split_bottom, width_of};
use crate::event::Figure;
use crate::model::chart::{Pose, ROBOT_RADIUS_IN};
use crate::model::ghost::{Ghost, ghost};
use crate::model::ground::Statement;
use crate::model::map::Focus;
use crate::model::robot::STATE_STALE;
use crate::model::{Large, MapLines};
use crate::request::Request;

/// Lengths of the scale bar, inches and label.
const BARS: [(f64, &str); 11] = [
    (6.0, "6 in"),
    (12.0, "1 ft"),
    (24.0, "2 ft"),
    (60.0, "5 ft"),
    (120.0, "10 ft"),
    (240.0, "20 ft"),
    (600.0, "50 ft"),
    (1200.0, "100 ft"),
    (2400.0, "200 ft"),
    (6000.0, "500 ft"),
    (12000.0, "1000 ft"),
];

/// Minimum distance between two coordinates on an axis, columns.
const AXIS_COLUMNS: u16 = 12;

/// Maximum number of coordinates along an edge.
const AXIS_LABELS_MAX: u32 = 64;

/// Width of a sonar beam, degrees; the two beams are adjacent.
const BEAM_DEG: f64 = 15.0;

impl Screen<'_> {
    pub(super) fn map(&self, buffer: &mut Buffer, area: Rect) {
        let chart = &self.facts.chart;
        let map = &self.ui.map;
        let focus = match map.focus {
            Focus::Follow => "<follow>: show all",
            Focus::Robot(_) | Focus::Everything | Focus::Floor(_) => "<follow>: follow robot",
        };
        let right = Span::styled(self.with_keys(focus), self.theme.dim);
        let below = self.panel(buffer, area, &self.map_title(), Some(right));
        let (below, legend) = split_bottom(below, 1);
        let ground = self.ground(usize::from(below.width));
        let (picture, row) = split_bottom(below, ground.is_some().into());
        if let Some(ground) = ground {
            put(buffer, row, 0, &ground);
        }
        let projection = Projection::of(chart, map, picture);
        if self.ui.config.lines == MapLines::Pixels && !self.is_covered() {
            let fine = projection.finer(FINE);
            let mut raster = Raster::new(fine.area());
            self.lines(&fine, &mut raster);
            let pixels = Picture::of(&raster, picture, &self.theme, self.ui.config.colors);
            self.picture.replace(Some(pixels));
        } else {
            let mut raster = Raster::new(picture);
            self.lines(&projection, &mut raster);
            raster.draw(buffer, picture, &self.theme);
        }
        if self.ui.enlarged == Some(Large::Map) {
            self.axes(&projection, buffer, picture);
        }
        self.marks(&projection, buffer);
        self.legend(&projection, buffer, legend);
        self.claim(picture, Mark::Map(projection));
    }

    /// The suggestion, else the ground's own estimate of the pose: the longest text that fits.
    fn ground(&self, width: usize) -> Option<Line<'_>> {
        let suggestion = self.present.suggestion(self.present_at);
        let suggestion = suggestion.filter(|_| self.ui.playback.is_none());
        let (texts, style) = if let Some(suggestion) = suggestion {
            let commands = suggestion.requests.iter().map(Request::to_string);
            let commands = commands.collect::<Vec<_>>().join(", ");
            let short = self.with_keys(&format!("<accept-suggestion>: {commands}"));
            let why = suggestion.figures.iter().map(|figure| self.figure(figure));
            let why = why.collect::<Vec<_>>().join(", ");
            let long = match why.as_str() {
                "" => format!("{short} (heading unknown)"),
                why if suggestion.figures.iter().all(|it| it.half.is_some()) => {
                    format!("{short} (off by {why})")
                }
                why => format!("{short} ({why})"),
            };
            (vec![long, short], self.theme.warning)
        } else {
            if !self.facts.robot.measures(Reading::Sonars) {
                return None;
            }
            let within = self.theme.glyphs.within;
            let reported = self.facts.chart.reported()?;
            let old = self.old_mark(reported.age(self.now), STATE_STALE);
            match self.facts.ground.statement? {
                Statement::HeadingUnknown => (
                    vec![format!("{old}ground: heading unknown")],
                    self.theme.warning,
                ),
                Statement::Lifted => (
                    vec![
                        format!("{old}ground: lifted; put it down, then :set-pose"),
                        format!("{old}ground: lifted, pose unknown"),
                    ],
                    self.theme.warning,
                ),
                Statement::Pose(pose) => {
                    let CorrectedPose {
                        x_in,
                        y_in,
                        theta_deg: heading,
                        ellipse,
                    } = pose;
                    let degrees = heading.value.round().rem_euclid(360.0);
                    let heading = format!("{degrees:.0} deg {within}{:.0}", heading.half);
                    // Adding zero makes a rounded -0.4 a plain 0.
                    let (x_in, y_in) = (x_in.round() + 0.0, y_in.round() + 0.0);
                    let within_in = ellipse.long_in;
                    let position = format!("({x_in:.0}, {y_in:.0}) {within}{within_in:.0} in");
                    let texts = vec![
                        format!("{old}ground: heading {heading}, {position}"),
                        format!("{old}ground: {heading}, {position}"),
                        format!("{old}ground: {heading}"),
                    ];
                    (texts, self.theme.dim)
                }
            }
        };
        let text = texts.into_iter().find(|text| columns(text) <= width)?;
        Some(Line::styled(text, style))
    }

    fn figure(&self, figure: &Figure) -> String {
        let Some(half) = figure.half else {
            return figure.to_string();
        };
        let within = self.theme.glyphs.within;
        let places = usize::from(figure.unit == "%") * 2;
        format!(
            "{:.places$} {within}{half:.places$} {}",
            figure.value, figure.unit
        )
    }

    fn map_title(&self) -> String {
        match self.facts.chart.reported() {
            Some(reported) => {
                let pose = reported.value;
                let old = self.old_mark(reported.age(self.now), STATE_STALE);
                format!(
                    "map: {old}x {:+.0} y {:+.0} in, {:.0} deg",
                    pose.x_in, pose.y_in, pose.theta_deg
                )
            }
            None => "map".to_owned(),
        }
    }

    fn lines(&self, projection: &Projection, raster: &mut Raster) {
        let chart = &self.facts.chart;
        let dot = |point| projection.dot(point);
        if !self.ui.map.truth_hidden {
            for [from, to] in &chart.truth.furniture {
                raster.line(dot(*from), dot(*to), 1, Ink::Furniture);
            }
            for (center, radius_in) in &chart.truth.circles {
                circle(raster, projection, *center, *radius_in, Ink::Furniture);
            }
            for [from, to] in &chart.truth.blocks {
                raster.block(dot(*from), dot(*to), Ink::Wall);
            }
            for [from, to] in &chart.truth.walls {
                raster.line(dot(*from), dot(*to), 1, Ink::Wall);
            }
        }
        if self.shows_obstacles() {
            for [from, to] in chart.obstacles.obstacles() {
                raster.block(dot(from), dot(to), Ink::Sonar);
            }
        }
        for place in chart.trail.older() {
            let (x, y) = dot(place);
            raster.dot(x, y, Ink::OldTrail);
        }
        let mut last = None;
        for point in chart.trail.recent() {
            let here = dot((point.x_in, point.y_in));
            match last.filter(|_| point.joined) {
                Some(last) => raster.line(last, here, 1, Ink::Trail),
                None => raster.dot(here.0, here.1, Ink::Trail),
            }
            last = Some(here);
        }
        if let Some(active) = self.facts.ledger.active() {
            polyline(raster, projection, &active.waypoints, 2, Ink::Route);
        }
        polyline(
            raster,
            projection,
            self.ui.map.draft.waypoints(),
            4,
            Ink::Draft,
        );
        if let Some(pending) = self.facts.ledger.pending_route() {
            polyline(raster, projection, pending, 4, Ink::Draft);
        }
        if let Some(route) = self.suggested_route() {
            polyline(raster, projection, route, 4, Ink::Draft);
        }
        self.estimate_lines(projection, raster);
        self.robot_lines(projection, raster);
        if let Some(ghost) = self.ghost() {
            let circle = Ellipse {
                long_in: ghost.radius_in,
                short_in: ghost.radius_in,
                bearing_deg: 0.0,
            };
            let center = (ghost.pose.x_in, ghost.pose.y_in);
            dashed_ellipse(raster, projection, center, circle, Ink::Robot);
        }
    }

    /// The waypoints of the suggestion.
    fn suggested_route(&self) -> Option<&[Waypoint]> {
        let suggestion = self.present.suggestion(self.present_at)?;
        let is_present = self.ui.playback.is_none();
        suggestion.waypoints().filter(|_| is_present)
    }

    /// Whether to draw the obstacles found by sensors, because the walls are unknown.
    fn shows_obstacles(&self) -> bool {
        self.facts.chart.plan().is_none() || self.ui.map.truth_hidden
    }

    /// The dead-reckoned position of a silent robot with its uncertainty.
    fn ghost(&self) -> Option<Ghost> {
        ghost(self.facts.robot.state.as_ref()?, self.now)
    }

    fn robot_lines(&self, projection: &Projection, raster: &mut Raster) {
        if let Some(state) = self.facts.robot.state
            && state.age(self.now) < STATE_STALE
        {
            let pose = Pose::of(&state.value);
            for (range_in, left_edge_deg) in [
                (state.value.sonar_left_in, -BEAM_DEG),
                (state.value.sonar_right_in, 0.0),
            ] {
                if let Some(range_in) = range_in {
                    beam(
                        raster,
                        projection,
                        &pose,
                        f64::from(range_in),
                        left_edge_deg,
                    );
                }
            }
        }
        let Some(pose) = self.facts.chart.pose() else {
            return;
        };
        if projection.scale_in() <= ROBOT_RADIUS_IN / 2.5 {
            let center = (pose.x_in, pose.y_in);
            circle(raster, projection, center, ROBOT_RADIUS_IN, Ink::Robot);
            let nose = projection.dot(pose.ahead(0.0, 2.0 * ROBOT_RADIUS_IN));
            raster.line(projection.dot(center), nose, 1, Ink::Robot);
        }
    }

    /// Draws the coordinates, inches, at the left and lower edge.
    fn axes(&self, projection: &Projection, buffer: &mut Buffer, area: Rect) {
        let label = |buffer: &mut Buffer, at: Rect, value: f64| {
            let text = Line::styled(format!("{value:.0}"), self.theme.dim);
            let width = text.width() as u16;
            if at.x + width <= area.right() {
                put(buffer, Rect { width, ..at }, 0, &text);
            }
        };
        let least_in = f64::from(AXIS_COLUMNS) * 2.0 * projection.scale_in();
        let step_in = BARS.iter().find(|(length_in, _)| *length_in >= least_in);
        let step_in = step_in.map_or(least_in, |(length_in, _)| *length_in);
        let (west_in, south_in) = projection.corner();
        let steps = |from_in: f64| {
            (0..AXIS_LABELS_MAX).map(move |n| {
                (from_in / step_in)
                    .ceil()
                    .mul_add(step_in, f64::from(n) * step_in)
            })
        };
        for x_in in steps(west_in) {
            if let Some(cell) = projection.cell((x_in, south_in)) {
                label(buffer, cell, x_in);
            }
        }
        for y_in in steps(south_in) {
            if let Some(cell) = projection.cell((west_in, y_in)) {
                label(buffer, cell, y_in);
            }
        }
    }

    /// Draws marks of one cell; more important marks cover others.
    fn marks(&self, projection: &Projection, buffer: &mut Buffer) {
        let theme = &self.theme;
        let glyphs = theme.glyphs;
        let facts = self.facts;
        let mut mark = |point: (f64, f64), glyph: &str, style: Style| {
            if let Some(cell) = projection.cell(point) {
                fill(buffer, cell, glyph, style);
            }
        };
        for seen in &facts.chart.infrareds {
            mark((seen.x_in, seen.y_in), glyphs.infrared, theme.raised);
        }
        mark((0.0, 0.0), glyphs.origin, theme.dim);
        if let Some(active) = facts.ledger.active() {
            let driven = active.driven.map_or(0, |place| usize::from(place.driven));
            for (n, waypoint) in active.waypoints.iter().enumerate() {
                let glyph = if n < driven {
                    glyphs.reached
                } else {
                    glyphs.waypoint
                };
                mark(place(*waypoint), glyph, theme.route);
            }
        }
        let pending = facts.ledger.pending_route().unwrap_or_default();
        for waypoint in self.ui.map.draft.waypoints().iter().chain(pending) {
            mark(place(*waypoint), glyphs.draft, theme.draft);
        }
        if self.ui.enlarged == Some(Large::Map) {
            let route = facts
                .ledger
                .active()
                .map_or(&[][..], |active| &active.waypoints);
            for (n, waypoint) in (1..).zip(route) {
                let (x_in, y_in) = place(*waypoint);
                // The number is in the cell to the right.
                mark(
                    (x_in + 2.0 * projection.scale_in(), y_in),
                    &number(n),
                    theme.route,
                );
            }
        }
        for hit in &facts.chart.bumps {
            mark((hit.x_in, hit.y_in), glyphs.bump, theme.holder);
        }
        let target = facts.robot.status.and_then(|status| status.value.target_in);
        if let Some((x_in, y_in)) = target {
            let point = (f64::from(x_in), f64::from(y_in));
            mark(point, glyphs.target, theme.strong);
        }
        if let Some(reported) = facts.chart.reported() {
            let pose = reported.value;
            let eighth = ((pose.theta_deg + 22.5) / 45.0) as usize % 8;
            let style = if reported.age(self.now) < STATE_STALE {
                theme.robot
            } else {
                theme.dim
            };
            mark((pose.x_in, pose.y_in), glyphs.arrows[eighth], style);
        }
        if let Some(ghost) = self.ghost() {
            mark(
                (ghost.pose.x_in, ghost.pose.y_in),
                glyphs.stale,
                theme.robot,
            );
        }
        if let Some(cursor) = &self.ui.map.cursor {
            mark(place(*cursor), glyphs.cursor, theme.strong);
        }
    }

    fn legend(&self, projection: &Projection, buffer: &mut Buffer, area: Rect) {
        let theme = &self.theme;
        let glyphs = theme.glyphs;
        let chart = &self.facts.chart;
        let room_in = f64::from(area.width) / 5.0 * 2.0 * projection.scale_in();
        let (length_in, name) = BARS
            .into_iter()
            .rev()
            .find(|(length_in, _)| *length_in <= room_in)
            .unwrap_or(BARS[0]);
        let cells = (length_in / projection.scale_in() / 2.0).round().max(2.0) as usize;
        let [left, middle, right] = glyphs.scale;
        let bar = format!("{left}{}{right} {name}", middle.repeat(cells - 2));
        let mut notes = Vec::new();
        if let Some(cursor) = &self.ui.map.cursor {
            notes.push(format!("cursor ({}, {})", cursor.x_in, cursor.y_in));
        }
        if !chart.bumps.is_empty() {
            notes.push(format!("{} bump", glyphs.bump));
        }
        if !chart.infrareds.is_empty() && self.ui.map.cursor.is_none() {
            notes.push(format!("{} infrared", glyphs.infrared));
        }
        if !self.shows_obstacles() {
            notes.push("walls: simulator's truth".to_owned());
        } else if chart.obstacles.obstacles().next().is_some() {
            notes.push("walls: measured".to_owned());
        }
        if self.estimate().is_some() {
            notes.push("dashed: ground's 95 %".to_owned());
        }
        if let Some(ghost) = self.ghost() {
            let words = format!(
                "{} reckoned, within {:.0} in",
                glyphs.stale, ghost.radius_in
            );
            notes.push(words);
        }
        let bar = Line::styled(bar, theme.dim);
        let room = usize::from(area.width).saturating_sub(width_of(&bar.spans) + 1);
        let legend = (0..=notes.len())
            .map(|dropped| Line::styled(notes[dropped..].join("  "), theme.dim))
            .find(|legend| width_of(&legend.spans) <= room)
            .unwrap_or_default();
        put(buffer, area, 0, &bar);
        put_right(buffer, area, 0, &legend);
    }
}

/// The number of a waypoint as one character; letters from the tenth.
fn number(n: u32) -> String {
    let digit = char::from_digit(n, 36).unwrap_or('+');
    digit.to_string()
}

fn place(waypoint: Waypoint) -> (f64, f64) {
    (f64::from(waypoint.x_in), f64::from(waypoint.y_in))
}

fn polyline(
    raster: &mut Raster,
    projection: &Projection,
    waypoints: &[Waypoint],
    every: usize,
    ink: Ink,
) {
    for pair in waypoints.windows(2) {
        if let [from, to] = pair {
            let (from, to) = (projection.dot(place(*from)), projection.dot(place(*to)));
            raster.line(from, to, every, ink);
        }
    }
}

fn circle(
    raster: &mut Raster,
    projection: &Projection,
    (x_in, y_in): (f64, f64),
    radius_in: f64,
    ink: Ink,
) {
    let dots = (radius_in / projection.scale_in() * 7.0).clamp(8.0, 800.0);
    for n in 0..dots as u32 {
        let (sin, cos) = (f64::from(n) / dots * std::f64::consts::TAU).sin_cos();
        let (x, y) = projection.dot((x_in + radius_in * sin, y_in + radius_in * cos));
        raster.dot(x, y, ink);
    }
}

/// Draws the edges of a sonar beam and the arc of its echo.
fn beam(
    raster: &mut Raster,
    projection: &Projection,
    pose: &Pose,
    range_in: f64,
    left_edge_deg: f64,
) {
    let nose = projection.dot(pose.ahead(0.0, ROBOT_RADIUS_IN));
    let at = |deg: f64| projection.dot(pose.ahead(deg, range_in + ROBOT_RADIUS_IN));
    let right_edge_deg = left_edge_deg + BEAM_DEG;
    // The edge between the two beams is not drawn.
    let outer_deg = if left_edge_deg < 0.0 {
        left_edge_deg
    } else {
        right_edge_deg
    };
    raster.line(nose, at(outer_deg), 3, Ink::Sonar);
    let steps = 6;
    let degree = |n: i32| left_edge_deg + BEAM_DEG * f64::from(n) / f64::from(steps);
    for n in 0..steps {
        raster.line(at(degree(n)), at(degree(n + 1)), 1, Ink::Sonar);
    }
}
