//! Thins out a track by a tolerance.

use super::{Holder, Place, Point};

/// The parts of a track with one behaviour: the behaviour (`None` in a gap) and the points, at least two. The segment to a
/// point has that point's behaviour.
pub(super) fn stretches<'a>(
    points: &'a [Point],
    gap_lines: &[u64],
) -> Vec<(Option<Holder>, &'a [Point])> {
    let mut found: Vec<(Option<Holder>, &[Point])> = Vec::new();
    let mut begin = 0;
    let mut gaps = gap_lines.iter().peekable();
    for (index, pair) in points.windows(2).enumerate() {
        let [from, to] = pair else { continue };
        while gaps.next_if(|line| **line <= from.line).is_some() {}
        if to.is_apart {
            continue;
        }
        let is_gap = gaps.peek().is_some_and(|line| **line <= to.line);
        let holder = (!is_gap).then_some(to.holder);
        match found.last_mut() {
            Some((last, part)) if *last == holder && !is_gap && begin + part.len() == index + 1 => {
                *part = &points[begin..index + 2];
            }
            _ => {
                begin = index;
                found.push((holder, &points[begin..index + 2]));
            }
        }
    }
    found
}

/// Indexes of the places of a line that are kept, including both ends: no omitted place is farther than `tolerance` from the line
/// through the kept ones (Ramer, Douglas and Peucker).
pub(crate) fn simplify(places: &[Place], tolerance: f32) -> Vec<usize> {
    let Some(last) = places.len().checked_sub(1) else {
        return Vec::new();
    };
    let mut stays = vec![false; places.len()];
    stays[0] = true;
    stays[last] = true;
    let mut parts = vec![(0, last)];
    while let Some((from, to)) = parts.pop() {
        let far = |index: usize| distance(places[index], places[from], places[to]);
        let furthest = (from + 1..to).max_by(|a, b| far(*a).total_cmp(&far(*b)));
        if let Some(middle) = furthest.filter(|index| far(*index) > tolerance) {
            stays[middle] = true;
            parts.push((from, middle));
            parts.push((middle, to));
        }
    }
    (0..=last).filter(|index| stays[*index]).collect()
}

/// Distance of a place from a line segment.
fn distance((x, y): Place, from: Place, to: Place) -> f32 {
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let square = dx * dx + dy * dy;
    let part = if square > 0.0 {
        (((x - from.0) * dx + (y - from.1) * dy) / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (x - from.0 - part * dx).hypot(y - from.1 - part * dy)
}

/// Thins out points to at most `most`, with a tolerance or, if necessary, a larger one; returns the tolerance used.
pub(super) fn reduce(
    points: &mut Vec<Point>,
    gap_lines: &mut Vec<u64>,
    most: usize,
    mut tolerance_in: f32,
) -> f32 {
    /// Maximum tolerance, inches; beyond it, resets determine the number of points.
    const TOLERANCE_MAX_IN: f32 = 10_000.0;
    loop {
        let mut stays = vec![false; points.len()];
        // A single point between two resets is not drawn.
        stays[0] = true;
        stays[points.len() - 1] = true;
        let mut begin = 0;
        for (_, part) in stretches(points, gap_lines) {
            while points[begin].line < part[0].line {
                begin += 1;
            }
            let places: Vec<Place> = part.iter().map(|point| point.place).collect();
            for index in simplify(&places, tolerance_in) {
                stays[begin + index] = true;
            }
        }
        let mut index = 0;
        let mut last: Option<Place> = None;
        let is_crowded = stays.iter().filter(|stays| **stays).count() > most;
        points.retain(|point| {
            index += 1;
            let (x, y) = point.place;
            let is_near = |(last_x, last_y): Place| (x - last_x).hypot(y - last_y) < tolerance_in;
            // Changes of behaviour and gaps within the tolerance are invisible.
            let stays =
                stays[index - 1] && (point.is_apart || !is_crowded || !last.is_some_and(is_near));
            if stays {
                last = Some(point.place);
            }
            stays
        });
        if points.len() <= most || tolerance_in > TOLERANCE_MAX_IN {
            break;
        }
        tolerance_in *= 2.0;
    }
    points.truncate(most);
    merge_gaps(points, gap_lines);
    tolerance_in
}

/// Merges the gaps between two points into one.
pub(super) fn merge_gaps(points: &[Point], gap_lines: &mut Vec<u64>) {
    gap_lines.dedup_by_key(|line| interval(points, *line));
}

/// Number of points before a line.
pub(super) fn interval(points: &[Point], line: u64) -> usize {
    points.partition_point(|point| point.line < line)
}
