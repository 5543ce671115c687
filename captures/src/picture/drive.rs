//! Draws the picture of a track.

use super::font::Font;
use super::mark::{self, HALO, PATH, Symbol};
use super::shape::{BLACK, ECHO, Layer, ORANGE, PAPER, Shape, Spot};
use super::sheet::{Plan, Row, Sheet};
use super::{Picture, TOLERANCE, date_words, feet_words, time_words};
use crate::CaptureError;
use crate::event::Truth;
use crate::track::{Event, Holder, Place, Stretch, Track, simplify};
use crate::words::counted;

/// The letters of marks; later marks are only counted.
const LETTERS: std::ops::RangeInclusive<char> = 'A'..='Z';

/// Number of line segments that draw a circle.
const CIRCLE: u8 = 32;

pub(super) fn draw(
    name: &str,
    run: Option<&str>,
    track: &Track,
    problem: Option<&CaptureError>,
) -> Option<Picture> {
    let font = Font::load();
    let stretches = track.stretches();
    let plan = Plan {
        title: run.unwrap_or(name).to_owned(),
        facts: run
            .map(|_| name.to_owned())
            .into_iter()
            .chain(facts(track))
            .collect(),
        legend: legend(track, &stretches),
        notes: notes(track, problem),
        bounds_in: bounds_in(track)?,
    };
    let sheet = Sheet::new(&font, &plan);
    let mut layers = surroundings(&sheet, track);
    layers.extend(path(&sheet, &stretches, mark::color));
    layers.push(marks(&sheet, &font, track));
    Some(sheet.picture(&font, plan, layers))
}

fn facts(track: &Track) -> Vec<String> {
    let mut facts: Vec<String> = track.start.as_deref().map(date_words).into_iter().collect();
    facts.push(time_words(track.duration));
    facts.push(format!("{} driven", feet_words(track.distance_in)));
    facts.extend(track.link.clone());
    facts
}

fn notes(track: &Track, problem: Option<&CaptureError>) -> Vec<String> {
    let mut notes = Vec::new();
    if track.tolerance_in > 0.0 {
        notes.push(format!(
            "The path is simplified with a tolerance of {} in.",
            track.tolerance_in
        ));
    }
    if track.events(Event::Restart).count > 0 {
        let walls = match &track.truth {
            Some(_) => ", where the walls do not fit them",
            None => "",
        };
        notes.push(format!(
            "After a restart, positions count from the place of the restart{walls}."
        ));
    }
    let unmarked = track.marks.len().saturating_sub(LETTERS.count());
    if unmarked > 0 {
        notes.push(format!("{unmarked} later marks are not shown."));
    }
    if let Some(longest) = track.outages.iter().max_by_key(|it| it.duration()) {
        notes.push(match track.outages.len() {
            1 => format!("1 outage: {longest}."),
            count => format!("{count} outages, the longest: {longest}."),
        });
    }
    notes.extend(problem.map(ToString::to_string));
    notes
}

/// Bounds of the path, the waypoints, the walls or mapped obstacles, and the marks.
fn bounds_in(track: &Track) -> Option<[(f32, f32); 2]> {
    let mut places: Vec<Place> = track.points.iter().map(|point| point.place).collect();
    places.first()?;
    let waypoints = track.waypoints.iter().map(|waypoint| waypoint.place_in);
    places.extend(waypoints.map(|(x, y)| (f32::from(x), f32::from(y))));
    for event in Event::ALL {
        places.extend(&track.events(event).places_in);
    }
    places.extend(track.marks.iter().map(|mark| mark.place_in));
    let ends = match &track.truth {
        Some(truth) => truth.walls.iter().flatten(),
        None => track.obstacles_in.iter().flatten(),
    };
    places.extend(ends.map(|&(x, y)| (x as f32, y as f32)));
    Some(bounds(&places))
}

/// Minimum and maximum x and y of places.
pub(super) fn bounds(places: &[Place]) -> [(f32, f32); 2] {
    let none = (f32::INFINITY, f32::NEG_INFINITY);
    places.iter().fold([none, none], |[x, y], place| {
        let wider = |(least, most): (f32, f32), at: f32| (least.min(at), most.max(at));
        [wider(x, place.0), wider(y, place.1)]
    })
}

/// The true walls; if unknown, the mapped obstacles; without these, the detections of the sensors.
fn surroundings(sheet: &Sheet, track: &Track) -> Vec<Layer> {
    if let Some(truth) = &track.truth {
        return vec![Layer {
            name: "walls",
            shapes: walls(sheet, truth),
        }];
    }
    if !track.obstacles_in.is_empty() {
        let mapped = track.obstacles_in.iter();
        let shapes = mapped.map(|corners| mark::obstacle(corners.map(|at| spot(sheet, at))));
        return vec![Layer {
            name: "map",
            shapes: shapes.collect(),
        }];
    }
    let spots = |places: &[Place]| -> Vec<Spot> {
        let spots = places.iter().map(|place| sheet.spot(*place));
        spots.filter(|spot| sheet.is_in_plot(*spot, 2.0)).collect()
    };
    let echoes = mark::dots(spots(&track.echoes_in), ECHO);
    let infrared = mark::dots(spots(&track.infrared_in), ORANGE);
    vec![Layer {
        name: "detections",
        shapes: echoes.into_iter().chain(infrared).collect(),
    }]
}

fn spot(sheet: &Sheet, (x_in, y_in): (f64, f64)) -> Spot {
    sheet.spot((x_in as f32, y_in as f32))
}

fn walls(sheet: &Sheet, truth: &Truth) -> Vec<Shape> {
    let spot = |at| spot(sheet, at);
    let is_inside = |spots: &[Spot]| spots.iter().all(|spot| sheet.is_in_plot(*spot, 0.0));
    let mut shapes = Vec::new();
    let mut push = |spots: Vec<Spot>, shape: fn(Vec<Spot>) -> Shape| {
        if is_inside(&spots) {
            shapes.push(shape(spots));
        }
    };
    for ends in &truth.furniture {
        push(ends.map(spot).to_vec(), mark::furniture);
    }
    for &((x_in, y_in), radius_in) in &truth.circles {
        let at = |number: u8| {
            let angle = f64::from(number) / f64::from(CIRCLE) * std::f64::consts::TAU;
            spot((
                x_in + radius_in * angle.cos(),
                y_in + radius_in * angle.sin(),
            ))
        };
        push((0..=CIRCLE).map(at).collect(), mark::furniture);
    }
    for ends in &truth.walls {
        push(ends.map(spot).to_vec(), mark::wall);
    }
    shapes
}

/// The path in the colours of its behaviours, dashed where lines were lost or damaged.
pub(super) fn path(
    sheet: &Sheet,
    stretches: &[Stretch],
    color: impl Fn(Holder) -> super::shape::Color,
) -> Vec<Layer> {
    let mut layers = ["halo", "gaps", "path"].map(|name| Layer {
        name,
        shapes: Vec::new(),
    });
    let tolerance_in = TOLERANCE / sheet.pixels_per_in;
    // Lines of one colour together become one path of an SVG.
    let mut stretches: Vec<&Stretch> = stretches.iter().collect();
    stretches.sort_by_key(|stretch| stretch.holder);
    for Stretch { holder, places_in } in stretches {
        let kept = simplify(places_in, tolerance_in);
        let spots: Vec<Spot> = kept
            .iter()
            .map(|index| sheet.spot(places_in[*index]))
            .collect();
        let [halo, gaps, path] = &mut layers;
        match holder {
            Some(holder) => {
                halo.shapes.push(Shape::line(spots.clone(), HALO, PAPER));
                path.shapes.push(Shape::line(spots, PATH, color(*holder)));
            }
            None => gaps.shapes.push(mark::gap(spots)),
        }
    }
    layers.into()
}

fn marks(sheet: &Sheet, font: &Font, track: &Track) -> Layer {
    let mut shapes = Vec::new();
    if let Some(first) = track.points.first() {
        mark::start(&mut shapes, sheet.spot(first.place), mark::START, BLACK);
    }
    let routes = track.waypoints.iter().map(|waypoint| waypoint.route).max();
    for waypoint in &track.waypoints {
        let (x, y) = waypoint.place_in;
        let number = waypoint.number;
        let label = match routes {
            Some(1) => number.to_string(),
            _ => format!("{}.{number}", waypoint.route),
        };
        let spot = sheet.spot((f32::from(x), f32::from(y)));
        mark::waypoint(&mut shapes, font, spot, &label, waypoint.is_reached);
    }
    for event in Event::ALL.into_iter().rev() {
        for place in &track.events(event).places_in {
            mark::event(&mut shapes, event, sheet.spot(*place));
        }
    }
    if let Some(last) = track.points.last() {
        let heading_deg = f32::from(track.heading_deg);
        mark::end(&mut shapes, sheet.spot(last.place), heading_deg, BLACK);
    }
    for (letter, mark) in LETTERS.zip(&track.marks) {
        mark::flag(&mut shapes, sheet.spot(mark.place_in), letter);
    }
    Layer {
        name: "marks",
        shapes,
    }
}

fn legend(track: &Track, stretches: &[Stretch]) -> Vec<Vec<Row>> {
    let mut marks = vec![
        Row::new(Symbol::Start(BLACK), "start"),
        Row::new(Symbol::End(BLACK, 90.0), "end"),
    ];
    let count = |is_reached| {
        let waypoints = track.waypoints.iter();
        waypoints.filter(|it| it.is_reached == is_reached).count()
    };
    for (is_reached, words) in [(true, "waypoint reached"), (false, "waypoint not reached")] {
        if count(is_reached) > 0 {
            marks.push(Row::new(Symbol::Waypoint(is_reached), words));
        }
    }
    for event in Event::ALL {
        let count = track.events(event).count;
        let shown = track.events(event).places_in.len();
        if count > 0 || shown > 0 {
            let how_many = if shown == count as usize {
                count.to_string()
            } else {
                format!("{count}, {shown} shown")
            };
            let text = format!("{} ({how_many})", event.word());
            marks.push(Row::new(Symbol::Event(event), text));
        }
    }
    let flags = LETTERS.zip(&track.marks);
    marks.extend(flags.map(|(letter, mark)| {
        let at = || format!("mark at {}", time_words(mark.at));
        let text = mark.text.clone().unwrap_or_else(at);
        Row::new(Symbol::Mark(letter), text)
    }));
    let mut holders: Vec<Holder> = stretches.iter().filter_map(|it| it.holder).collect();
    holders.sort_unstable();
    holders.dedup();
    let mut path: Vec<Row> = holders
        .into_iter()
        .map(|holder| {
            Row::new(
                Symbol::Path(mark::color(holder)),
                holder.word().replace('-', " "),
            )
        })
        .collect();
    if track.gaps > 0 {
        path.push(Row::new(Symbol::Gap, gap_words(track)));
    }
    let mut around = Vec::new();
    if let Some(truth) = &track.truth {
        around.push(Row::new(Symbol::Wall, "wall, simulated"));
        if !truth.furniture.is_empty() || !truth.circles.is_empty() {
            around.push(Row::new(Symbol::Furniture, "furniture"));
        }
    } else if !track.obstacles_in.is_empty() {
        around.push(Row::new(Symbol::Obstacle, "obstacle, mapped"));
    } else {
        if !track.echoes_in.is_empty() {
            around.push(Row::new(Symbol::Echo, "sonar echo"));
        }
        if !track.infrared_in.is_empty() {
            around.push(Row::new(Symbol::Infrared, "infrared detection"));
        }
    }
    // A blank row separates the blocks.
    for rows in [&mut marks, &mut path] {
        rows.push(Row::new(None, ""));
    }
    vec![marks, path, around]
}

/// Number of gaps as text, counted as in the summary.
pub(super) fn gap_words(track: &Track) -> String {
    format!("lost or damaged ({})", counted(track.gaps, "gap"))
}
