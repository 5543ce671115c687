use std::time::Duration;

use groundwave_protocol::status_codes::Layer as RobotLayer;
use proptest::prelude::*;

use super::shape::{Anchor, Shape, Text};
use super::*;
use crate::event::Truth;
use crate::track::{DrivenTo, Event, Events, Holder, PlacedMark, Point};

fn point(x: f32, y: f32, line: u64) -> Point {
    Point {
        place: (x, y),
        holder: Holder::Prowl,
        is_apart: line == 1,
        line,
    }
}

fn track(points: Vec<Point>) -> Track {
    Track {
        points,
        duration: Duration::from_secs(125),
        ..Track::default()
    }
}

/// Left, top, right and bottom of a text.
fn extent(font: &Font, text: &Text) -> [f32; 4] {
    let width = font.width(&text.words, text.size);
    let (before, after) = match text.anchor {
        Anchor::Start => (0.0, width),
        Anchor::Middle => (width / 2.0, width / 2.0),
        Anchor::End => (width, 0.0),
    };
    let (x, y) = text.at;
    let (up, down) = (0.75 * text.size, 0.25 * text.size);
    if text.is_upward {
        [x - up, y - after, x + down, y + before]
    } else {
        [x - before, y - up, x + after, y + down]
    }
}

fn layer<'a>(picture: &'a Picture, name: &str) -> &'a [Shape] {
    let found = picture.layers.iter().find(|layer| layer.name == name);
    found.map_or(&[], |layer| &layer.shapes)
}

fn texts(shapes: &[Shape]) -> impl Iterator<Item = &Text> {
    shapes.iter().filter_map(|shape| match shape {
        Shape::Text(text) => Some(text),
        _ => None,
    })
}

/// Asserts that nothing is outside the sheet, and that texts do not overlap.
fn is_whole(picture: &Picture) {
    let font = Font::load();
    let (width, height) = picture.size;
    let mut boxes: Vec<([f32; 4], &str)> = Vec::new();
    for Layer { name, shapes } in &picture.layers {
        for shape in shapes {
            let spots = match shape {
                Shape::Line { spots, .. } | Shape::Filled { spots, .. } => spots.clone(),
                Shape::Circles {
                    centers, radius, ..
                } => centers
                    .iter()
                    .flat_map(|&(x, y)| [(x - radius, y - radius), (x + radius, y + radius)])
                    .collect(),
                Shape::Text(text) => {
                    let [left, top, right, bottom] = extent(&font, text);
                    if *name != "marks" {
                        boxes.push(([left, top, right, bottom], &text.words));
                    }
                    vec![(left, top), (right, bottom)]
                }
            };
            for (x, y) in spots {
                let is_inside = (0.0..=width).contains(&x) && (0.0..=height).contains(&y);
                assert!(
                    is_inside,
                    "{name}: ({x}, {y}) of ({width}, {height}): {shape:?}"
                );
            }
        }
    }
    for (number, (a, text)) in boxes.iter().enumerate() {
        for (b, other) in &boxes[number + 1..] {
            let is_apart = a[2] <= b[0] || b[2] <= a[0] || a[3] <= b[1] || b[3] <= a[1];
            assert!(is_apart, "{text:?} {a:?} is over {other:?} {b:?}");
        }
    }
}

fn same_in_both_forms(picture: &Picture) {
    let (width, height) = picture.size;
    assert!(
        picture
            .svg()
            .contains(&format!("viewBox=\"0 0 {width} {height}\""))
    );
    let png = tiny_skia::Pixmap::decode_png(&picture.png().unwrap()).unwrap();
    assert_eq!(
        (png.width() as f32, png.height() as f32),
        (2.0 * width, 2.0 * height)
    );
}

#[test]
fn long_names_counts_and_problems_are_within_the_picture() {
    let mut track = track(vec![point(0.0, 0.0, 1)]);
    track.events = [10_000, 20_000, 1, 0, 2, 3].map(|count| Events {
        count,
        places_in: vec![(0.0, 0.0)],
    });
    track.gaps = 12_345;
    let problem = CaptureError::Unfinished {
        path: "folder/".repeat(40).into(),
        is_in_use: false,
    };
    let name = "a long name of a capture ".repeat(10);
    let picture = Picture::of_track(&name, None, &track, Some(&problem)).unwrap();
    is_whole(&picture);
    same_in_both_forms(&picture);
    let legend: Vec<_> = texts(layer(&picture, "legend"))
        .map(|it| &it.words[..])
        .collect();
    assert!(
        legend.contains(&"floor edge (20000, 1 shown)"),
        "{legend:?}"
    );
    assert!(
        legend.contains(&"lost or damaged (12345 gaps)"),
        "{legend:?}"
    );
}

#[test]
fn the_paper_has_the_orientation_of_the_path() {
    let size = |x: f32, y: f32| {
        let track = track(vec![point(0.0, 0.0, 1), point(x, y, 2)]);
        let picture = Picture::of_track("a", None, &track, None).unwrap();
        is_whole(&picture);
        picture.size
    };
    let (wide, tall, corridor) = (size(600.0, 300.0), size(300.0, 600.0), size(2400.0, 10.0));
    assert!(wide.0 > wide.1, "{wide:?}");
    assert!(tall.0 < tall.1, "{tall:?}");
    assert!(corridor.0 > 2.0 * corridor.1, "{corridor:?}");
}

#[test]
fn names_of_other_alphabets_are_drawn_and_named() {
    let track = track(vec![point(0.0, 0.0, 1), point(9.0, 9.0, 2)]);
    for name in ["Küche", "кухня", "台所", "a<b>&\"c\""] {
        let picture = Picture::of_track(name, None, &track, None).unwrap();
        is_whole(&picture);
        same_in_both_forms(&picture);
    }
    assert!(
        Picture::of_track("Küche", None, &track, None)
            .unwrap()
            .svg()
            .contains("aria-label=\"Küche\"")
    );
}

#[test]
fn gaps_are_dashed_and_moves_are_not_drawn() {
    let mut points: Vec<Point> = (1..=6_u16)
        .map(|n| point(f32::from(n) * 20.0, 0.0, u64::from(n)))
        .collect();
    points[4].is_apart = true;
    let mut track = track(points);
    let whole = Picture::of_track("a", None, &track, None).unwrap();
    assert!(layer(&whole, "gaps").is_empty() && !whole.svg().contains("dash"));
    track.gap_lines = vec![3];
    track.gaps = 1;
    let picture = Picture::of_track("a", None, &track, None).unwrap();
    assert_eq!(layer(&picture, "gaps").len(), 1);
    assert_eq!(layer(&picture, "path").len(), 3);
    // One in the plot and one in the legend.
    assert_eq!(picture.svg().matches("stroke-dasharray").count(), 2);
    let Shape::Line { spots, .. } = &layer(&picture, "path")[2] else {
        panic!("not a line");
    };
    assert_eq!(
        spots.len(),
        2,
        "nothing joins the parts before and after a reset"
    );
}

#[test]
fn true_walls_replace_detections() {
    let mut track = track(vec![point(0.0, 0.0, 1), point(20.0, 0.0, 2)]);
    track.echoes_in = vec![(5.0, 5.0)];
    let measured = Picture::of_track("a", None, &track, None).unwrap();
    assert_eq!(layer(&measured, "detections").len(), 1);
    track.truth = Some(Truth {
        walls: vec![
            [(-100.0, -50.0), (100.0, -50.0)],
            [(100.0, -50.0), (100.0, 90.0)],
        ],
        circles: vec![((10.0, 10.0), 4.0)],
        ..Truth::default()
    });
    let known = Picture::of_track("a", None, &track, None).unwrap();
    is_whole(&known);
    assert!(layer(&known, "detections").is_empty());
    assert!(layer(&known, "notes").is_empty());
    track.events[Event::Restart as usize].count = 1;
    let restarted = Picture::of_track("a", None, &track, None).unwrap();
    assert!(texts(layer(&restarted, "notes")).any(|it| it.words.contains("walls do not fit")));
    assert_eq!(layer(&known, "walls").len(), 3);
}

#[test]
fn two_runs_have_their_facts_beside_them() {
    let mut a = track(vec![point(0.0, 0.0, 1), point(120.0, -6.0, 2)]);
    a.start = Some("2025-03-14T09:26:53Z".to_owned());
    let mut b = track(vec![point(0.0, 0.0, 1), point(100.0, 60.0, 2)]);
    b.gaps = 1;
    b.gap_lines = vec![2];
    let run = |name: &str, track| Run {
        name: name.to_owned(),
        track,
        closing_error_in: Some(3.21),
    };
    let picture = Picture::of_pair([&run("before", &a), &run(&"after".repeat(40), &b)]).unwrap();
    is_whole(&picture);
    same_in_both_forms(&picture);
    let legend: Vec<_> = texts(layer(&picture, "legend"))
        .map(|it| &it.words[..])
        .collect();
    for fact in [
        "2025-03-14 09:26 UTC",
        "2 min 5 s, 0.0 ft driven",
        "start (0.0, 0.0) ft",
        "end (10.0, −0.5) ft",
        "closing error 3.2 in",
        "lost or damaged (1 gap)",
    ] {
        assert!(legend.contains(&fact), "{fact} is not in {legend:?}");
    }
    assert!(!layer(&picture, "grid").is_empty());
    let none = track(Vec::new());
    assert_eq!(Picture::of_pair([&run("a", &a), &run("b", &none)]), None);
}

#[test]
fn mapped_obstacles_replace_detections_and_are_whole() {
    let points = vec![point(0.0, 0.0, 1), point(50.0, 0.0, 2)];
    let mut mapped = track(points);
    mapped.echoes_in = vec![(20.0, 20.0)];
    mapped.obstacles_in = vec![[(-90.0, 30.0), (-84.0, 33.0)], [(60.0, -3.0), (63.0, 0.0)]];
    let picture = Picture::of_track("mapped", None, &mapped, None).unwrap();
    is_whole(&picture);
    assert_eq!(layer(&picture, "map").len(), 2);
    assert!(!picture.layers.iter().any(|it| it.name == "detections"));
    let mut legend = texts(layer(&picture, "legend"));
    assert!(legend.any(|it| it.words == "obstacle, mapped"));
}

#[test]
fn marks_have_letters_in_the_plot_and_their_texts_in_the_legend() {
    let points = (1..9_u16).map(|n| point(f32::from(n) * 20.0, 0.0, n.into()));
    let track = Track {
        marks: (0..30_u16)
            .map(|n| PlacedMark {
                at: Duration::from_secs(n.into()),
                place_in: (f32::from(n), 40.0),
                text: (n != 2).then(|| format!("mark {n}")),
            })
            .collect(),
        ..track(points.collect())
    };
    let picture = Picture::of_track("evening", Some("new wheels"), &track, None).unwrap();
    is_whole(&picture);
    let words = |name: &str| -> Vec<String> {
        texts(layer(&picture, name))
            .map(|text| text.words.clone())
            .collect()
    };
    assert_eq!(words("title")[0], "new wheels");
    assert!(
        words("title")[1].starts_with("evening"),
        "{:?}",
        words("title")
    );
    let letters: Vec<String> = ('A'..='Z').map(String::from).collect();
    assert_eq!(words("marks"), letters);
    let legend = words("legend");
    let at = legend.iter().position(|it| it == "B").unwrap();
    assert_eq!(legend[at + 1], "mark 1");
    assert_eq!(legend[at + 3], "mark at 2 s", "one without a text");
    assert!(!legend.contains(&"mark 26".to_owned()));
    assert_eq!(words("notes"), ["4 later marks are not shown."]);
}

#[test]
fn a_long_drive_makes_a_small_picture() {
    let points = (1..20_000_u16).map(|n| {
        let angle = f32::from(n) * 0.05;
        let radius = 100.0 + f32::from(n) * 0.01;
        point(radius * angle.cos(), radius * angle.sin(), n.into())
    });
    let track = track(points.collect());
    let svg = Picture::of_track("a", None, &track, None).unwrap().svg();
    assert!(svg.len() < 500_000, "{}", svg.len());
}

fn any_track() -> impl Strategy<Value = Track> {
    let place = || (-900.0..900.0_f32, -900.0..900.0_f32);
    (
        proptest::collection::vec((place(), any::<bool>(), 0..8_usize), 1..40),
        proptest::collection::vec(1..40_u64, 0..6),
        proptest::array::uniform6(proptest::collection::vec(place(), 0..4)),
        proptest::collection::vec(place(), 0..10),
        proptest::collection::vec((-900..900_i16, -900..900_i16, any::<bool>()), 0..12),
    )
        .prop_map(|(points, mut gaps, events, echoes_in, waypoints)| {
            gaps.sort_unstable();
            let points = (1..)
                .zip(points)
                .map(|(line, ((x, y), apart, layer))| Point {
                    holder: Holder::Layer(RobotLayer::ALL[layer]),
                    is_apart: line == 1 || apart && line % 5 == 0,
                    ..point(x, y, line)
                });
            Track {
                gaps: gaps.len() as u64,
                gap_lines: gaps,
                events: events.map(|places_in| Events {
                    count: places_in.len() as u32,
                    places_in,
                }),
                waypoints: (1..)
                    .zip(waypoints)
                    .map(|(number, (x, y, is_reached))| DrivenTo {
                        route: 1 + u32::from(number > 6),
                        number,
                        place_in: (x, y),
                        is_reached,
                    })
                    .collect(),
                echoes_in,
                ..track(points.collect())
            }
        })
}

proptest! {
    #[test]
    fn any_track_fits_its_paper(track in any_track(), name in "\\PC{0,80}") {
        let picture = Picture::of_track(&name, None, &track, None).unwrap();
        is_whole(&picture);
        let gaps = track.stretches().iter().filter(|it| it.holder.is_none()).count();
        prop_assert_eq!(layer(&picture, "gaps").len(), gaps);
        let rows = layer(&picture, "legend");
        let font = Font::load();
        for text in texts(rows) {
            let [_, _, right, _] = extent(&font, text);
            prop_assert!(right <= picture.size.0 - 8.0, "{}", text.words);
        }
        for event in Event::ALL {
            prop_assert!(track.events(event).places_in.is_empty()
                || texts(rows).any(|text| text.words.starts_with(event.word())));
        }
    }
}
