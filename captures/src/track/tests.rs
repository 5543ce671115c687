use std::time::Duration;

use groundwave_protocol::decoder::{Counters, Decoder, Received};
use groundwave_protocol::status_codes::{Bump, Drive, LayerMask, LayerState, Mode};
use groundwave_protocol::telemetry::{Ack, AckLine, Body, Line, ListPlace, StateLine, StatusLine};
use groundwave_protocol::{Waypoint, digest};
use proptest::prelude::*;

use super::thin::reduce;
use super::*;

/// A line A of a robot at a place, tenths of an inch.
fn state(sequence: u8, boot: u8, x_tenths_in: i32) -> Line {
    let state = StateLine {
        x_tenths_in,
        ..StateLine::BLANK
    };
    line(sequence, boot, Body::State(state))
}

fn line(sequence: u8, boot: u8, body: Body) -> Line {
    Line {
        sequence,
        body,
        ack: Ack {
            boot,
            ..Ack::default()
        },
    }
}

/// The track of bytes from the radio.
fn track(bytes: &[u8]) -> Track {
    let mut capture =
        Capture::read("test", Box::new(std::io::Cursor::new(bytes.to_vec()))).unwrap();
    let (track, problem) = Track::read(&mut capture);
    assert!(problem.is_none());
    track
}

fn of_lines(lines: &[Line]) -> Track {
    let bytes: Vec<u8> = lines.iter().flat_map(Line::encode).collect();
    track(&bytes)
}

/// Number of gaps drawn, and of stretches driven.
fn drawn(track: &Track) -> (usize, usize) {
    let stretches = track.stretches();
    let gaps = stretches.iter().filter(|it| it.holder.is_none()).count();
    (gaps, stretches.len() - gaps)
}

#[test]
fn acknowledgements_between_two_positions_are_no_gap_and_lost_lines_are_one() {
    let mut bytes = state(0, 0, 0).encode().to_vec();
    for sequence in 1..9 {
        let line = AckLine {
            sequence,
            ack: Ack::default(),
            listens: false,
        };
        bytes.extend(line.encode());
    }
    bytes.extend(state(9, 0, 50).encode());
    let whole = track(&bytes);
    assert_eq!((whole.gaps, drawn(&whole)), (0, (0, 1)));
    bytes.extend(state(12, 0, 90).encode());
    bytes.extend(state(13, 0, 130).encode());
    let lossy = track(&bytes);
    assert_eq!(
        (lossy.gaps, lossy.lines_lost, drawn(&lossy)),
        (1, 2, (1, 2))
    );
}

#[test]
fn a_restart_and_a_set_position_are_moves() {
    let mut set = state(3, 1, 700);
    if let Body::State(state) = &mut set.body {
        state.drive = Drive::OdometerReset;
    }
    let lines = [
        state(0, 0, 490),
        state(1, 0, 500),
        state(0, 1, 0),
        state(1, 1, 10),
        state(2, 1, 20),
        set,
        state(4, 1, 710),
    ];
    let track = of_lines(&lines);
    let stretches = track.stretches();
    let xs: Vec<Vec<f32>> = stretches
        .iter()
        .map(|stretch| stretch.places_in.iter().map(|place| place.0).collect())
        .collect();
    assert_eq!(
        xs,
        [vec![49.0, 50.0], vec![0.0, 1.0, 2.0], vec![70.0, 71.0]]
    );
    assert_eq!(track.events(Event::Restart).places_in, [(50.0, 0.0)]);
    assert_eq!(track.events(Event::OdometerReset).places_in, [(70.0, 0.0)]);
    assert_eq!(track.gaps, 0);
    assert_eq!(track.since_reset().points.len(), 2);
}

#[test]
fn a_bump_is_at_the_shell_where_it_touched() {
    let mut touch = state(1, 0, 0);
    if let Body::State(state) = &mut touch.body {
        state.theta_deg = 90;
        state.bump = Bump::Center;
    }
    let track = of_lines(&[state(0, 0, 0), touch]);
    let places_in = &track.events(Event::Bump).places_in;
    assert!((places_in[0].0 - 5.5).abs() < 1e-3 && places_in[0].1.abs() < 1e-3);
}

#[test]
fn marks_are_where_the_robot_was() {
    let lines = [0, 1, 2].map(|n| state(n, 0, 100 * i32::from(n)).encode());
    let bytes = lines.concat();
    let mut capture = Capture::read("test", Box::new(std::io::Cursor::new(bytes))).unwrap();
    let marks = [
        (0.8, "end"),
        (0.5, "middle"),
        (0.1, "first"),
        (99.0, "after"),
    ];
    let marks = marks.map(|(s, text)| (Duration::from_secs_f64(s), text.to_owned()));
    let (track, _, problem) = Track::read_with(&mut capture, marks.to_vec(), |_, _| {});
    assert!(problem.is_none());
    let seen: Vec<(f32, &str)> = track
        .marks
        .iter()
        .map(|mark| (mark.place_in.0, mark.text.as_deref().unwrap()))
        .collect();
    assert_eq!(
        seen,
        [
            (0.0, "first"),
            (0.0, "middle"),
            (10.0, "end"),
            (20.0, "after")
        ]
    );
}

#[test]
fn waypoints_are_those_that_the_robot_drove_to() {
    let list = [(10, 20), (30, 40), (50, 60)].map(|(x_in, y_in)| Waypoint { x_in, y_in });
    let status = |sequence, driven: u16| {
        let target = list.get(usize::from(driven));
        let status = StatusLine {
            robot_id: 4,
            battery_dv: 120,
            target_in: target.map(|point| (point.x_in, point.y_in)),
            list: ListPlace { driven, count: 3 },
            digest: digest::digest(list.iter()),
            max_count: 12,
            photo_left: None,
            photo_right: None,
            fitted: LayerMask::default(),
            allowed: LayerMask::default(),
            boots: 0,
            odometer_resets: 0,
        };
        line(sequence, 0, Body::Status(status))
    };
    let seen = |lines: &[Line]| -> Vec<(u32, u16, (i16, i16), bool)> {
        let track = of_lines(lines);
        let seen = track.waypoints.iter();
        seen.map(|it| (it.route, it.number, it.place_in, it.is_reached))
            .collect()
    };
    let lines = [state(0, 0, 0), status(1, 0), status(2, 1)];
    let once = [(1, 1, (10, 20), true), (1, 2, (30, 40), false)];
    assert_eq!(seen(&lines), once);
    let again = [&lines[..], &[status(3, 0)]].concat();
    let twice = [&once[..], &[(2, 1, (10, 20), false)]].concat();
    assert_eq!(seen(&again), twice, "the same list is driven again");
    let mut stopped = state(4, 0, 0);
    if let Body::State(state) = &mut stopped.body {
        state.mode = Mode::Stop;
    }
    let driven = [&lines[..], &[status(3, 2), stopped, status(5, 3)]].concat();
    let all = [1, 2, 3].map(|n: u16| {
        let place = list[usize::from(n) - 1];
        (1, n, (place.x_in, place.y_in), true)
    });
    assert_eq!(seen(&driven), all, "the robot stops at its last waypoint");
    let sent = [stopped, status(5, 0)];
    assert_eq!(seen(&sent), [], "a route that is not driven");
}

/// Points of a random walk, with their lines.
fn walk() -> impl Strategy<Value = Vec<Point>> {
    let step = (-30.0..30.0_f32, -30.0..30.0_f32, 0..8_u8, 0..40_u8);
    proptest::collection::vec(step, 2..400).prop_map(|steps| {
        let mut place = (0.0, 0.0);
        (1..)
            .zip(steps)
            .map(|(number, (x, y, holder, apart))| {
                place = (place.0 + x, place.1 + y);
                Point {
                    place,
                    holder: Layer::ALL
                        .get(usize::from(holder / 4) + 3)
                        .map_or(Holder::Prowl, |layer| Holder::Layer(*layer)),
                    is_apart: number == 1 || apart == 0,
                    line: 3 * number,
                }
            })
            .collect()
    })
}

proptest! {
    #[test]
    fn a_simplified_line_is_within_its_tolerance(
        places in proptest::collection::vec((-50.0..50.0_f32, -50.0..50.0_f32), 1..80),
        tolerance in 0.0..20.0_f32,
    ) {
        let kept = simplify(&places, tolerance);
        prop_assert_eq!(kept.first(), Some(&0));
        prop_assert_eq!(kept.last(), Some(&(places.len() - 1)));
        for pair in kept.windows(2) {
            let (from, to) = (places[pair[0]], places[pair[1]]);
            for &(x, y) in &places[pair[0]..=pair[1]] {
                let (dx, dy) = (to.0 - from.0, to.1 - from.1);
                let square = (dx * dx + dy * dy).max(f32::MIN_POSITIVE);
                let part = (((x - from.0) * dx + (y - from.1) * dy) / square).clamp(0.0, 1.0);
                let apart = (x - from.0 - part * dx).hypot(y - from.1 - part * dy);
                prop_assert!(apart <= tolerance + 0.01, "{apart}");
            }
        }
    }

    #[test]
    fn a_thinned_track_is_bounded_and_keeps_whether_it_has_gaps_and_moves(
        points in walk(),
        gaps in proptest::collection::btree_set(1..1200_u64, 0..40),
        most in 20..100_usize,
    ) {
        let gap_lines: Vec<u64> = gaps.into_iter().collect();
        let before = thin::stretches(&points, &gap_lines);
        let had_gap = before.iter().any(|(holder, _)| holder.is_none());
        let (mut thinned, mut kept_gaps) = (points.clone(), gap_lines.clone());
        let tolerance_in = reduce(&mut thinned, &mut kept_gaps, most, 0.05);
        prop_assert!(thinned.len() <= most.max(points.len().min(most)));
        prop_assert!(tolerance_in >= 0.05);
        prop_assert!(kept_gaps.len() <= thinned.len() + 1);
        let after = thin::stretches(&thinned, &kept_gaps);
        prop_assert!(had_gap || after.iter().all(|(holder, _)| holder.is_some()));
        for (_, part) in after {
            prop_assert!(part.len() >= 2 && part[1..].iter().all(|point| !point.is_apart));
        }
    }

    /// A picture and a summary count the same gaps, whatever is lost, and the picture draws none where no line was lost.
    #[test]
    fn gaps_are_those_of_the_summary(
        lost in proptest::collection::vec(any::<bool>(), 2..60),
        x in proptest::collection::vec(-40..40_i32, 60),
    ) {
        let mut bytes = Vec::new();
        let mut x_tenths_in = 0;
        for (number, (lost, step)) in lost.iter().zip(x).enumerate() {
            x_tenths_in += step;
            if !lost {
                bytes.extend(state(number as u8, 0, x_tenths_in).encode());
            }
        }
        let track = track(&bytes);
        let mut capture =
            Capture::read("test", Box::new(std::io::Cursor::new(bytes))).unwrap();
        let info = crate::info::Info::read(&mut capture);
        prop_assert_eq!(track.gaps, info.gaps);
        prop_assert_eq!(track.lines_lost, info.loss.lines_lost);
        prop_assert_eq!(&track.outages, &info.outages);
        prop_assert_eq!(track.gaps == 0, info.loss.lines_lost == 0);
        prop_assert!(drawn(&track).0 as u64 <= track.gaps);
    }
}

#[test]
fn a_day_of_driving_keeps_its_shape_in_bounded_memory() {
    let mut fold = Fold::default();
    let mut counters = Counters::default();
    for number in 0..250_000_u32 {
        let angle = f64::from(number) * 0.02;
        let radius_in = 60.0 + f64::from(number % 5000) * 0.01;
        let mut line = state(
            (number % 100) as u8,
            0,
            (radius_in * angle.cos() * 10.0) as i32,
        );
        if let Body::State(state) = &mut line.body {
            state.y_tenths_in = (radius_in * angle.sin() * 10.0) as i32;
            state.layers.set(
                if number % 3 == 0 {
                    Layer::Sonar
                } else {
                    Layer::Infrared
                },
                LayerState::Holds,
            );
        }
        counters.lines += 1;
        counters.lines_lost += u64::from(number % 4 == 0);
        let at = Duration::from_millis(u64::from(number) * 333);
        fold.take(at, &Received::Line(line, line.encode()), &counters);
    }
    fold.end(&counters);
    let track = fold.track;
    assert!((100..=20_000).contains(&track.points.len()));
    assert!(track.gap_lines.len() <= track.points.len());
    assert!(track.tolerance_in > 0.0 && track.tolerance_in < 60.0);
    assert!(track.echoes_in.len() <= 20_000);
    let far = track
        .points
        .iter()
        .map(|point| point.place.0.hypot(point.place.1));
    assert!(far.fold(0.0, f32::max) < 111.0);
}

#[test]
fn interrupted_links_are_gaps_too() {
    let mut fold = Fold::default();
    let mut decoder = Decoder::default();
    for sequence in 0..3 {
        let line = state(sequence, 0, i32::from(sequence) * 50).encode();
        let received = decoder.lines(&line).next().unwrap();
        fold.take(Duration::ZERO, &received, decoder.counters());
        if sequence == 1 {
            fold.interrupt(&mut decoder);
        }
    }
    fold.end(decoder.counters());
    assert_eq!((fold.track.gaps, fold.track.lines_lost), (1, 0));
    assert_eq!(drawn(&fold.track), (1, 1));
}
