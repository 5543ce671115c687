//! Pictures of the track with its events, as SVG and PNG.
//!
//! Both draw the same shapes. The colours are those of Okabe and Ito, which colour-blind people tell apart; each kind of event
//! also has a shape of its own.

mod png;
pub(super) mod svg;

use super::error::CaptureError;
use super::track::{Event, Holder, Joint, Track};
use groundwave_protocol::status_codes::Layer;

/// Least width and height of the picture, pixels; long words make it larger.
const WIDTH: f32 = 1280.0;
const HEIGHT: f32 = 960.0;

/// Area of the track: left, top, width, height, pixels.
const PLOT: [f32; 4] = [30.0, 60.0, 980.0, 870.0];

/// Left edge of the legend and distance of its rows, pixels.
const LEGEND_X: f32 = 1035.0;
const ROW: f32 = 28.0;

/// Widths of a wide letter, pixels: large and small.
const LETTERS: [f32; 2] = [13.5, 10.0];

/// Most letters of the capture's name in the title.
const NAME_MAX: usize = 60;

/// Letters in a line of the caption, and distance of its lines, pixels.
const CAPTION_LETTERS: usize = 120;
const CAPTION_ROW: f32 = 20.0;

const BLACK: Color = [0x00, 0x00, 0x00];
const GREY: Color = [0x8c, 0x8c, 0x8c];
const FAINT: Color = [0xe6, 0xe6, 0xe6];
const WHITE: Color = [0xff, 0xff, 0xff];
const ORANGE: Color = [0xe6, 0x9f, 0x00];
const SKY: Color = [0x56, 0xb4, 0xe9];
const GREEN: Color = [0x00, 0x9e, 0x73];
const YELLOW: Color = [0xf0, 0xe4, 0x42];
const BLUE: Color = [0x00, 0x72, 0xb2];
const VERMILION: Color = [0xd5, 0x5e, 0x00];
const PURPLE: Color = [0xcc, 0x79, 0xa7];

/// Red, green and blue.
type Color = [u8; 3];

/// Position in the picture, pixels right and down.
type Place = (f32, f32);

/// An element of a picture.
#[derive(Clone, Debug, PartialEq)]
enum Shape {
    Line {
        places: Vec<Place>,
        width: f32,
        color: Color,
        dashed: bool,
    },
    Filled {
        places: Vec<Place>,
        color: Color,
    },
    Ring {
        center: Place,
        radius: f32,
        width: f32,
        color: Color,
    },
    Words {
        /// Left end of the baseline.
        at: Place,
        words: String,
        large: bool,
    },
}

impl Shape {
    /// Right edge of words, pixels; 0 of other shapes, which are within the plot.
    fn right(&self) -> f32 {
        match self {
            Self::Words { at, words, large } => {
                at.0 + words.chars().count() as f32 * LETTERS[usize::from(!large)]
            }
            _ => 0.0,
        }
    }
}

/// The drawing of a track.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Width and height, pixels.
    size: (f32, f32),
    shapes: Vec<Shape>,
}

impl Picture {
    /// Draws a track with its title and the reason why it is incomplete; `None` if there is no position.
    #[must_use]
    pub fn new(title: &str, track: &Track, problem: Option<&CaptureError>) -> Option<Self> {
        let [x, y] = track.bounds_in()?;
        let scale = Scale::fit(x, y);
        let mut shapes = Vec::new();
        grid(&mut shapes, &scale);
        draw_path(&mut shapes, &scale, track);
        marks(&mut shapes, &scale, track);
        words(&mut shapes, title, track);
        let mut height = HEIGHT;
        if let Some(problem) = problem {
            for line in wrap(&problem.to_string()) {
                put_words(&mut shapes, (PLOT[0], height - 8.0), line, false);
                height += CAPTION_ROW;
            }
        }
        legend(&mut shapes, &scale, track);
        let right = shapes.iter().map(Shape::right).fold(WIDTH, f32::max);
        Some(Self {
            size: (right.ceil(), height),
            shapes,
        })
    }

    /// The picture as SVG.
    #[must_use]
    pub fn svg(&self) -> String {
        svg::draw(&self.shapes, self.size)
    }

    /// The picture as PNG.
    ///
    /// # Errors
    /// When it cannot be encoded.
    pub fn png(&self) -> Result<Vec<u8>, String> {
        png::draw(&self.shapes, self.size)
    }
}

/// Conversion from inches to pixels.
#[expect(clippy::struct_field_names, reason = "units come last")]
struct Scale {
    pixels_per_in: f32,
    left_in: f32,
    top_in: f32,
    /// Length of the scale bar and spacing of the grid, inches.
    bar_in: f32,
}

impl Scale {
    /// Smallest floor shown, inches.
    const SPAN_MIN_IN: f32 = 36.0;
    const MARGIN: f32 = 1.08;
    const BARS_IN: [f32; 9] = [6.0, 12.0, 24.0, 60.0, 120.0, 240.0, 600.0, 1200.0, 2400.0];

    fn fit((x0, x1): (f32, f32), (y0, y1): (f32, f32)) -> Self {
        let [_, _, width, height] = PLOT;
        let span = |from: f32, to: f32| (to - from).max(Self::SPAN_MIN_IN) * Self::MARGIN;
        let pixels_per_in = (width / span(x0, x1)).min(height / span(y0, y1));
        let fits = |bar: &&f32| **bar * pixels_per_in >= width / 10.0;
        let bars = Self::BARS_IN.iter().find(fits);
        Self {
            pixels_per_in,
            left_in: f32::midpoint(x0, x1) - width / pixels_per_in / 2.0,
            top_in: f32::midpoint(y0, y1) + height / pixels_per_in / 2.0,
            bar_in: bars.copied().unwrap_or(6000.0),
        }
    }

    /// Converts inches to a place in the picture; +Y is up.
    fn place(&self, x_in: f32, y_in: f32) -> Place {
        let x = PLOT[0] + (x_in - self.left_in) * self.pixels_per_in;
        (x, PLOT[1] + (self.top_in - y_in) * self.pixels_per_in)
    }
}

const fn color(holder: Holder) -> Color {
    match holder {
        Holder::Prowl => GREY,
        Holder::Layer(layer) => match layer {
            Layer::User => BLACK,
            Layer::Bumpers => VERMILION,
            Layer::Rotation => PURPLE,
            Layer::Infrared => ORANGE,
            Layer::Sonar => SKY,
            Layer::Photo => YELLOW,
            Layer::Motion => GREEN,
            Layer::DeadReckoning => BLUE,
        },
    }
}

fn grid(shapes: &mut Vec<Shape>, scale: &Scale) {
    let [left, top, width, height] = PLOT;
    let mut line = |from: Place, to: Place| {
        shapes.push(Shape::Line {
            places: vec![from, to],
            width: 1.0,
            color: FAINT,
            dashed: false,
        });
    };
    let step_in = scale.bar_in;
    let steps = |from_in: f32, span: f32| {
        let first = (from_in / step_in).ceil() as i32;
        let last = ((from_in + span / scale.pixels_per_in) / step_in).floor() as i32;
        (first..=last).map(move |step| step as f32 * step_in)
    };
    for x_in in steps(scale.left_in, width) {
        let (x, _) = scale.place(x_in, 0.0);
        line((x, top), (x, top + height));
    }
    for y_in in steps(scale.top_in - height / scale.pixels_per_in, height) {
        let (_, y) = scale.place(0.0, y_in);
        line((left, y), (left + width, y));
    }
}

/// Draws a line for each stretch with the same behaviour, dashed where the path was not received.
fn draw_path(shapes: &mut Vec<Shape>, scale: &Scale, track: &Track) {
    let mut points = track.points.iter().peekable();
    while let Some(first) = points.next() {
        let mut last = *first;
        let mut places = vec![scale.place(first.x_in, first.y_in)];
        while let Some(next) = points.peek().copied() {
            if next.joint == Joint::Apart {
                break;
            }
            let at = scale.place(next.x_in, next.y_in);
            if next.joint == Joint::Guessed {
                push_line(
                    shapes,
                    std::mem::take(&mut places),
                    color(last.holder),
                    false,
                );
                let from = scale.place(last.x_in, last.y_in);
                push_line(shapes, vec![from, at], GREY, true);
                places.push(at);
            } else {
                places.push(at);
                if next.holder != last.holder {
                    // The stretch to a point has the behaviour of its end.
                    let from = places[places.len().saturating_sub(2)];
                    let end = places.len() - 1;
                    push_line(shapes, places[..end].to_vec(), color(last.holder), false);
                    places = vec![from, at];
                }
            }
            last = *next;
            points.next();
        }
        push_line(shapes, places, color(last.holder), false);
    }
}

fn push_line(shapes: &mut Vec<Shape>, places: Vec<Place>, color: Color, dashed: bool) {
    if places.len() > 1 {
        shapes.push(Shape::Line {
            places,
            width: if dashed { 1.5 } else { 2.5 },
            color,
            dashed,
        });
    }
}

fn marks(shapes: &mut Vec<Shape>, scale: &Scale, track: &Track) {
    for event in Event::ALL.into_iter().rev() {
        for &(x_in, y_in) in &track.events(event).places_in {
            mark(shapes, event, scale.place(x_in, y_in));
        }
    }
    if let (Some(first), Some(last)) = (track.points.first(), track.points.last()) {
        start(shapes, scale.place(first.x_in, first.y_in));
        let heading = f32::from(track.heading_deg).to_radians();
        end(shapes, scale.place(last.x_in, last.y_in), heading);
    }
}

fn mark(shapes: &mut Vec<Shape>, event: Event, (x, y): Place) {
    let mut stroke = |places: Vec<Place>| {
        shapes.push(Shape::Line {
            places,
            width: 2.0,
            color: BLACK,
            dashed: false,
        });
    };
    match event {
        Event::Bump => {
            stroke(vec![(x - 5.0, y - 5.0), (x + 5.0, y + 5.0)]);
            stroke(vec![(x - 5.0, y + 5.0), (x + 5.0, y - 5.0)]);
        }
        Event::Edge => {
            stroke(vec![
                (x - 6.0, y + 5.0),
                (x, y - 6.0),
                (x + 6.0, y + 5.0),
                (x - 6.0, y + 5.0),
            ]);
        }
        Event::Stall => {
            stroke(vec![
                (x - 5.0, y - 5.0),
                (x + 5.0, y - 5.0),
                (x + 5.0, y + 5.0),
                (x - 5.0, y + 5.0),
                (x - 5.0, y - 5.0),
            ]);
        }
        Event::Restart => {
            stroke(vec![(x - 6.0, y), (x + 6.0, y)]);
            stroke(vec![(x, y - 6.0), (x, y + 6.0)]);
        }
    }
}

fn start(shapes: &mut Vec<Shape>, center: Place) {
    for (width, color) in [(6.0, WHITE), (3.0, BLACK)] {
        shapes.push(Shape::Ring {
            center,
            radius: 9.0,
            width,
            color,
        });
    }
}

/// Draws an arrowhead with the robot's heading.
fn end(shapes: &mut Vec<Shape>, (x, y): Place, heading: f32) {
    let at = |ahead: f32, right: f32| {
        let (sin, cos) = heading.sin_cos();
        (x + ahead * sin + right * cos, y - ahead * cos + right * sin)
    };
    for (size, color) in [(16.0, WHITE), (12.0, BLACK)] {
        let places = vec![
            at(size, 0.0),
            at(-size * 0.7, size * 0.7),
            at(-size * 0.7, -size * 0.7),
        ];
        shapes.push(Shape::Filled { places, color });
    }
}

fn words(shapes: &mut Vec<Shape>, title: &str, track: &Track) {
    let s = track.duration.as_secs();
    let length = format!("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
    let said = format!("{:.0} ft in {length}", track.distance_in / 12.0);
    let too_long = title.chars().count().saturating_sub(NAME_MAX);
    let title = match title.char_indices().nth(too_long) {
        Some((start, _)) if too_long > 0 => format!("..{}", &title[start..]),
        _ => title.to_owned(),
    };
    put_words(shapes, (PLOT[0], 38.0), format!("{title}   {said}"), true);
}

/// Lines of a caption.
fn wrap(text: &str) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + word.chars().count() < CAPTION_LETTERS => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

fn put_words(shapes: &mut Vec<Shape>, at: Place, words: String, large: bool) {
    shapes.push(Shape::Words { at, words, large });
}

fn legend(shapes: &mut Vec<Shape>, scale: &Scale, track: &Track) {
    let mut y = PLOT[1] + ROW / 2.0;
    let mut row = |shapes: &mut Vec<Shape>, label: String| {
        let at = (LEGEND_X + 20.0, y);
        put_words(shapes, (LEGEND_X + 52.0, y + 5.0), label, false);
        y += ROW;
        at
    };
    start_row(shapes, &mut row);
    let at = row(shapes, "end".to_owned());
    end(shapes, at, std::f32::consts::FRAC_PI_2);
    for event in Event::ALL {
        let count = track.events(event).count;
        if count > 0 || !track.events(event).places_in.is_empty() {
            let shown = track.events(event).places_in.len();
            let how_many = if shown == count as usize {
                count.to_string()
            } else {
                format!("{count} counted, {shown} shown")
            };
            let at = row(shapes, format!("{} ({how_many})", event.word()));
            mark(shapes, event, at);
        }
    }
    let mut holders: Vec<Holder> = track.points.iter().map(|point| point.holder).collect();
    holders.sort_unstable();
    holders.dedup();
    for holder in holders {
        let (x, y) = row(shapes, holder.word().to_owned());
        let places = vec![(x - 18.0, y), (x + 18.0, y)];
        push_wide(shapes, places, color(holder));
    }
    if track.points.iter().any(|p| p.joint == Joint::Guessed) {
        let (x, y) = row(shapes, "path not received".to_owned());
        push_line(shapes, vec![(x - 18.0, y), (x + 18.0, y)], GREY, true);
    }
    scale_bar(shapes, scale);
}

fn start_row(shapes: &mut Vec<Shape>, row: &mut impl FnMut(&mut Vec<Shape>, String) -> Place) {
    let at = row(shapes, "start".to_owned());
    start(shapes, at);
}

fn push_wide(shapes: &mut Vec<Shape>, places: Vec<Place>, color: Color) {
    shapes.push(Shape::Line {
        places,
        width: 6.0,
        color,
        dashed: false,
    });
}

fn scale_bar(shapes: &mut Vec<Shape>, scale: &Scale) {
    let y = PLOT[1] + PLOT[3] - 12.0;
    let right = LEGEND_X + scale.bar_in * scale.pixels_per_in;
    let places = vec![
        (LEGEND_X, y - 8.0),
        (LEGEND_X, y),
        (right, y),
        (right, y - 8.0),
    ];
    shapes.push(Shape::Line {
        places,
        width: 2.0,
        color: BLACK,
        dashed: false,
    });
    let bar_in = scale.bar_in;
    let label = if bar_in < 12.0 {
        format!("{bar_in} in")
    } else {
        format!("{bar_in} in = {} ft", bar_in / 12.0)
    };
    put_words(shapes, (LEGEND_X, y - 16.0), label, false);
}

#[cfg(test)]
mod tests {
    use super::super::track::{Events, Point};
    use super::*;

    #[test]
    fn all_words_are_within_the_picture() {
        let events = |count| Events {
            count,
            places_in: vec![(0.0, 0.0)],
        };
        let track = Track {
            points: vec![Point {
                x_in: 0.0,
                y_in: 0.0,
                holder: Holder::Prowl,
                joint: Joint::Apart,
            }],
            events: [10_000, 20_000, 1, 0].map(events),
            ..Track::default()
        };
        let problem = CaptureError::Unfinished {
            path: "folder/".repeat(40).into(),
            is_in_use: false,
        };
        let name = "a long name of a capture ".repeat(10);
        let picture = Picture::new(&name, &track, Some(&problem)).unwrap();
        let (width, height) = picture.size;
        for shape in &picture.shapes {
            if let Shape::Words { at, words, .. } = shape {
                assert!(shape.right() <= width && at.1 < height, "{words}");
            }
        }
        let svg = picture.svg();
        assert!(svg.contains("edge of the floor (20000 counted, 1 shown)"));
        assert!(svg.contains(&format!("viewBox=\"0 0 {width} {height}\"")));
        let png = tiny_skia::Pixmap::decode_png(&picture.png().unwrap()).unwrap();
        assert_eq!((png.width() as f32, png.height() as f32), (width, height));
    }
}
