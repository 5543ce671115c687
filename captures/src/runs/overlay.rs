//! Two courses over each other as SVG.

use std::fmt::Write as _;

use super::Course;
use super::course::Place;
use crate::picture::svg::escaped;

/// Colours for colour-blind readers, and dashes for print.
const STYLES: [&str; 2] = [
    "stroke=\"#0072b2\"",
    "stroke=\"#d55e00\" stroke-dasharray=\"3 2\"",
];

/// Margin around the courses, inches.
const MARGIN_IN: f64 = 12.0;

/// Height of the legend, inches.
const LEGEND_IN: f64 = 26.0;

/// Left end of the names, and width of a wide letter, inches.
const NAMES_IN: f64 = 24.0;
const LETTER_IN: f64 = 3.2;

/// Pixels per inch.
const SCALE: f64 = 4.0;

/// Both courses as an SVG document to one scale, north up: names, circles at the beginnings, squares at the ends, a scale bar.
#[must_use]
pub fn overlay(courses: [&Course; 2], names: [&str; 2]) -> String {
    let all = || courses.iter().flat_map(|course| course.points());
    let first = all().next().copied().unwrap_or_default();
    let (low, high) = all().fold((first, first), |(low, high), &(x, y)| {
        ((low.0.min(x), low.1.min(y)), (high.0.max(x), high.1.max(y)))
    });
    let letters = names.map(|name| name.chars().count() + 2);
    let names_in = NAMES_IN + LETTER_IN * letters[0].max(letters[1]) as f64;
    let path_in = high.0 - low.0 + 2.0 * MARGIN_IN;
    let bar_in = if path_in > 240.0 { 48.0 } else { 12.0 };
    let width = path_in.max(names_in + bar_in + 2.0 * MARGIN_IN).max(120.0);
    let height = high.1 - low.1 + 2.0 * MARGIN_IN + LEGEND_IN;
    let at = |(x, y): Place| (x - low.0 + MARGIN_IN, high.1 - y + MARGIN_IN);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{:.0}\" height=\"{:.0}\" viewBox=\"0 0 {width:.1} {height:.1}\" \
         font-family=\"sans-serif\" font-size=\"5\">\n<title>{} and {}</title>\n\
         <rect width=\"{width:.1}\" height=\"{height:.1}\" fill=\"#ffffff\"/>\n",
        width * SCALE,
        height * SCALE,
        escaped(names[0]),
        escaped(names[1]),
    );
    for (number, ((course, name), style)) in courses.into_iter().zip(names).zip(STYLES).enumerate()
    {
        let mut points = String::new();
        for &place in course.points() {
            let (x, y) = at(place);
            // A string takes everything.
            let _ = write!(points, "{x:.1},{y:.1} ");
        }
        let legend_y = height - LEGEND_IN + 6.0 + 8.0 * number as f64;
        let _ = writeln!(
            svg,
            "<polyline points=\"{}\" fill=\"none\" {style} stroke-width=\"1\" stroke-linejoin=\"round\"/>\n\
             <path d=\"M4 {:.1}h16\" {style} stroke-width=\"1\"/>\
             <text x=\"{NAMES_IN}\" y=\"{legend_y:.1}\">{} {}</text>",
            points.trim_end(),
            legend_y - 2.0,
            number + 1,
            escaped(name),
        );
        if let (Some(start), Some(end)) = (course.start(), course.end()) {
            let ((x, y), (to_x, to_y)) = (at(start), at(end));
            let _ = writeln!(
                svg,
                "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"2\" fill=\"none\" {style}/>\
                 <rect x=\"{:.1}\" y=\"{:.1}\" width=\"4\" height=\"4\" fill=\"none\" {style}/>",
                to_x - 2.0,
                to_y - 2.0,
            );
        }
    }
    let (x, y) = (width - MARGIN_IN - bar_in, height - 8.0);
    let _ = writeln!(
        svg,
        "<path d=\"M{x:.1} {y:.1}v2h{bar_in}v-2\" fill=\"none\" stroke=\"#000000\" stroke-width=\"0.6\"/>\
         <text x=\"{x:.1}\" y=\"{:.1}\">{:.0} ft</text>\n</svg>",
        y - 1.0,
        bar_in / 12.0,
    );
    svg
}

#[cfg(test)]
mod tests {
    use super::super::course::tests::through;
    use super::*;

    #[test]
    fn both_courses_are_there_with_their_names_and_north_is_up() {
        let a = through(&[(0.0, 0.0), (0.0, 20.0)]);
        let b = through(&[(0.0, 0.0), (20.0, 0.0)]);
        let svg = overlay([&a, &b], ["one & only", "two"]);
        assert_eq!(svg.matches("<polyline").count(), 2);
        assert!(svg.contains("one &amp; only"));
        // The first ends 20 in north of where it began: higher up, so less far from the top.
        assert!(svg.contains("points=\"12.0,32.0 12.0,12.0\""), "{svg}");
        assert!(svg.contains("1 ft"));
    }

    #[test]
    fn a_long_name_is_within_the_picture() {
        let course = through(&[(0.0, 0.0), (0.0, 20.0)]);
        let name = "captures/of/the/contest/evening.mcap".repeat(3);
        let svg = overlay([&course, &course], ["short", &name]);
        let (_, view) = svg.split_once("viewBox=\"0 0 ").unwrap();
        let width: f64 = view.split(' ').next().unwrap().parse().unwrap();
        assert!(width > NAMES_IN + LETTER_IN * name.len() as f64 + MARGIN_IN);
    }
}
