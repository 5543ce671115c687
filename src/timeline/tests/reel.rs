//! A moment that is gone to is the moment that playing there shows.

use super::*;

/// Every moment at which something happened, and what was shown then by playing there from the beginning.
fn played(name: &str) -> Vec<(Moment, String)> {
    let mut tape = capture(name);
    let mut scene = Scene::new("radio", Arc::default(), &*tape);
    let mut shown = vec![(Moment::ZERO, told(scene.facts()))];
    while let Some(at) = scene.next_at(&mut tape) {
        scene.step(&mut tape);
        match shown.last_mut() {
            Some(last) if last.0 == at => last.1 = told(scene.facts()),
            _ => shown.push((at, told(scene.facts()))),
        }
    }
    shown
}

#[test]
fn a_seek_shows_what_playing_there_shows() {
    for name in CAPTURES {
        let played = played(name);
        let (mut reel, end) = surveyed(capture(name));
        assert_eq!(end, played.last().unwrap().0, "{name}");
        let mut dice = 1_usize;
        for n in 0..60 {
            dice = dice
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            let place = (dice >> 33) % played.len();
            let (at, shown) = &played[place];
            // Between this and the next thing nothing changes.
            let next = played.get(place + 1).map_or(*at, |(next, _)| *next);
            let between = *at + next.checked_sub(*at).unwrap() * (n % 3) / 4;
            reel.seek(between);
            assert!(!reel.is_partial());
            assert!(
                told(reel.facts()) == *shown,
                "{name} at {between:?}, seek {n}"
            );
        }
    }
}

#[test]
fn steps_go_back_the_way_they_came() {
    for name in CAPTURES {
        let (mut reel, end) = surveyed(capture(name));
        reel.seek(end / 2);
        let mut way = Vec::new();
        for _ in 0..25 {
            assert!(reel.step_forward());
            way.push((reel.packet(), reel.at()));
        }
        for (packet, at) in way.into_iter().rev() {
            assert_eq!((reel.packet(), reel.at()), (packet, at), "{name}");
            assert!(reel.step_back());
        }
        assert!(matches!(reel.seek_line(1, STEPS_MAX), Found::At(_)));
        assert!(!reel.step_back(), "{name}: before the first line");
        reel.seek(end);
        assert!(!reel.step_forward(), "{name}: after the last");
    }
}

/// All landmarks of a kind found by going through everything are found by jumping, both ways.
#[test]
fn jumps_find_every_landmark_and_nothing_else() {
    let kinds = [
        Landmark::Alarm,
        Landmark::Bump,
        Landmark::Behaviour,
        Landmark::Command,
    ];
    let mut found_any = 0;
    for name in CAPTURES {
        for kind in kinds {
            let mut tape = capture(name);
            let mut scene = Scene::new("radio", Arc::default(), &*tape);
            let mut all = Vec::new();
            while let Some(at) = scene.next_at(&mut tape) {
                let before = scene.facts().tally().of(kind);
                scene.step(&mut tape);
                if scene.facts().tally().of(kind) > before && all.last() != Some(&at) {
                    all.push(at);
                }
            }
            found_any += all.len();
            let (mut reel, end) = surveyed(capture(name));
            let mut at = Moment::ZERO;
            let mut forward = Vec::new();
            while let Found::At(next) = reel.find_next(kind, at, STEPS_MAX) {
                forward.push(next);
                at = next;
            }
            assert_eq!(forward, all, "{name} {kind:?}");
            let mut at = end + Moment::from_secs(1);
            let mut back = Vec::new();
            while let Found::At(last) = reel.find_last(kind, at, STEPS_MAX) {
                back.push(last);
                at = last;
            }
            back.reverse();
            assert_eq!(back, all, "{name} {kind:?}");
        }
    }
    assert!(found_any > 50, "{found_any}");
}

/// A long capture is there at once, says that it is not whole, and becomes what it is.
#[test]
fn before_a_long_capture_is_read_a_moment_is_partial_and_then_exact() {
    let day = std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("captures/house-clean.txt"));
    let day = day.unwrap().repeat(40);
    let (mut whole, end) = surveyed(text(&day));
    let at = end / 10 * 9;
    whole.seek(at);
    let tape = text(&day);
    let first = Scene::new("radio", Arc::default(), &*tape);
    let mut reel = Reel::new(tape, first, SPACING);
    reel.seek(at);
    assert!(reel.is_partial() && reel.packet().is_none());
    let robot = |reel: &Reel<Scene>| format!("{:?}", reel.facts().robot.state);
    assert_eq!(robot(&reel), robot(&whole), "what is new is right");
    assert_eq!(reel.find_next(Landmark::Alarm, at, 0), Found::NotYet);
    assert_eq!(reel.find_last(Landmark::Alarm, at, 0), Found::NotYet);
    let newest = reel.facts().newest_line_at();
    assert!(reel.step_back() && reel.facts().newest_line_at() < newest);
    assert!(reel.step_forward());
    assert_eq!(reel.facts().newest_line_at(), newest);
    while !reel.work(1000) {}
    assert!(!reel.is_partial());
    assert_eq!(told(reel.facts()), told(whole.facts()));
}

/// In a day of which nobody has read anything, what lies near is found as in one that has been read.
#[test]
fn a_jump_looks_near_before_all_of_the_front_is_read() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("captures");
    let day = std::fs::read(folder.join("house-clean.txt")).unwrap();
    let day = day.repeat(40);
    let (mut whole, end) = surveyed(text(&day));
    for kind in [Landmark::Alarm, Landmark::Bump, Landmark::Behaviour] {
        let tape = text(&day);
        let first = Scene::new("radio", Arc::default(), &*tape);
        let mut reel = Reel::new(tape, first, SPACING);
        let (mut back, mut ahead) = (end, end / 10 * 7);
        for _ in 0..6 {
            let found = reel.find_last(kind, back, STEPS_MAX);
            assert_eq!(found, whole.find_last(kind, back, STEPS_MAX), "{kind:?}");
            let Found::At(at) = found else {
                panic!("{kind:?}: {found:?}");
            };
            back = at;
            let found = reel.find_next(kind, ahead, STEPS_MAX);
            assert_eq!(found, whole.find_next(kind, ahead, STEPS_MAX), "{kind:?}");
            let Found::At(at) = found else {
                panic!("{kind:?}: {found:?}");
            };
            ahead = at;
        }
    }
}

/// Commands are told in a recording, not in the robot's lines: the last and the next are found in a day of which nobody
/// has read anything, as in one that has been read.
#[test]
fn a_command_near_is_found_before_all_of_the_front_is_read() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("captures");
    let calm = std::fs::read(folder.join("house-clean.txt")).unwrap();
    let session = Session {
        link: "radio".to_owned(),
        start: std::time::UNIX_EPOCH,
        notes: std::collections::BTreeMap::new(),
        configuration: String::new(),
    };
    let mut composer = Composer::new(Vec::new(), &session).unwrap();
    let mut asked = Vec::new();
    for (n, line) in (1_u64..).zip(calm.repeat(20).chunks(80)) {
        let at_ns = n * 1_000_000_000 / 3;
        composer.handle_rx(at_ns, line).unwrap();
        if n % 211 == 100 {
            let id = CommandId(n as u32);
            let request = Request::Scan;
            let by = None;
            let event = crate::recorded::to_recorded(&Event::Asked { id, request, by }).unwrap();
            composer.handle_event(at_ns, &event).unwrap();
            // The recording's first message is of 1970.
            asked.push(Moment::from_nanos(at_ns));
        }
    }
    let day = composer.finish().unwrap();
    let tape = index::read(Arc::new(day), Path::new("day.mcap")).unwrap();
    let first = Scene::new("radio", Arc::default(), &*tape);
    let mut reel = Reel::new(tape, first, SPACING);
    let middle = asked.len() / 2;
    let beside = asked[middle] + Moment::from_secs(1);
    let last = reel.find_last(Landmark::Command, beside, STEPS_MAX);
    assert_eq!(last, Found::At(asked[middle]));
    let last = reel.find_last(Landmark::Command, asked[middle], STEPS_MAX);
    assert_eq!(last, Found::At(asked[middle - 1]));
    let next = reel.find_next(Landmark::Command, beside, STEPS_MAX);
    assert_eq!(next, Found::At(asked[middle + 1]));
    // Too far to look.
    let far = reel.find_last(Landmark::Command, asked[middle], 10);
    assert_eq!(far, Found::NotYet);
}
