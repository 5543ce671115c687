//! Seeking shows the same as playing there.

use super::*;

/// Every moment with a step, and the facts after playing there from the beginning.
fn played(name: &str) -> Vec<(Moment, String)> {
    let mut reader = capture(name);
    let mut scene = CaptureState::new("radio", Arc::default(), &*reader);
    let mut shown = vec![(Moment::ZERO, text_of(scene.facts()))];
    while let Some(at) = scene.next_at(&mut reader) {
        scene.step(&mut reader);
        match shown.last_mut() {
            Some(last) if last.0 == at => last.1 = text_of(scene.facts()),
            _ => shown.push((at, text_of(scene.facts()))),
        }
    }
    shown
}

#[test]
fn a_seek_shows_what_playing_there_shows() {
    for name in CAPTURES {
        let played = played(name);
        let (mut timeline, end) = read_whole(capture(name));
        assert_eq!(end, played.last().unwrap().0, "{name}");
        let mut rng = 1_usize;
        for n in 0..60 {
            rng = rng
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            let place = (rng >> 33) % played.len();
            let (at, shown) = &played[place];
            // Between two steps nothing changes.
            let next = played.get(place + 1).map_or(*at, |(next, _)| *next);
            let between = *at + next.checked_sub(*at).unwrap() * (n % 3) / 4;
            timeline.seek(between);
            assert!(!timeline.is_partial());
            assert!(
                text_of(timeline.facts()) == *shown,
                "{name} at {between:?}, seek {n}"
            );
        }
    }
}

#[test]
fn steps_go_back_the_way_they_came() {
    for name in CAPTURES {
        let (mut timeline, end) = read_whole(capture(name));
        timeline.seek(end / 2);
        let mut way = Vec::new();
        for _ in 0..25 {
            assert!(timeline.step_forward().is_there());
            way.push((timeline.line(), timeline.at()));
        }
        for (line, at) in way.into_iter().rev() {
            assert_eq!((timeline.line(), timeline.at()), (line, at), "{name}");
            assert!(timeline.step_back().is_there());
        }
        assert!(matches!(timeline.seek_line(1, STEPS_MAX), Found::At(_)));
        assert!(
            !timeline.step_back().is_there(),
            "{name}: before the first line"
        );
        timeline.seek(end);
        assert!(
            !timeline.step_forward().is_there(),
            "{name}: after the last"
        );
    }
}

/// Jumping in both directions finds every landmark that playing finds.
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
            let mut reader = capture(name);
            let mut scene = CaptureState::new("radio", Arc::default(), &*reader);
            let mut all = Vec::new();
            while let Some(at) = scene.next_at(&mut reader) {
                let before = scene.facts().tally().of(kind);
                scene.step(&mut reader);
                if scene.facts().tally().of(kind) > before && all.last() != Some(&at) {
                    all.push(at);
                }
            }
            found_any += all.len();
            let (mut timeline, end) = read_whole(capture(name));
            let mut at = Moment::ZERO;
            let mut forward = Vec::new();
            while let Found::At(next) = timeline.find_next(kind, at, STEPS_MAX) {
                forward.push(next);
                at = next;
            }
            assert_eq!(forward, all, "{name} {kind:?}");
            let mut at = end + Moment::from_secs(1);
            let mut back = Vec::new();
            while let Found::At(last) = timeline.find_last(kind, at, STEPS_MAX) {
                back.push(last);
                at = last;
            }
            back.reverse();
            assert_eq!(back, all, "{name} {kind:?}");
        }
    }
    assert!(found_any > 50, "{found_any}");
}

/// A long capture opens at once, is partial at first, and then exact.
#[test]
fn moment_of_an_unread_capture_is_partial_and_then_exact() {
    let day = std::fs::read(groundwave_captures::samples().join("house-clean.txt"));
    let day = day.unwrap().repeat(12);
    let (mut whole, end) = read_whole(text(&day));
    let at = end / 10 * 9;
    whole.seek(at);
    let reader = text(&day);
    let first = CaptureState::new("radio", Arc::default(), &*reader);
    let mut timeline = capture::timeline(reader, first);
    timeline.seek(at);
    assert!(timeline.is_partial() && timeline.line().is_none());
    let robot = |timeline: &Timeline<CaptureState>| format!("{:?}", timeline.facts().robot.state);
    assert_eq!(robot(&timeline), robot(&whole), "what is new is right");
    assert_eq!(timeline.find_next(Landmark::Alarm, at, 0), Found::NotYet);
    assert_eq!(timeline.find_last(Landmark::Alarm, at, 0), Found::NotYet);
    let newest = timeline.facts().newest_line_at();
    assert!(timeline.step_back().is_there() && timeline.facts().newest_line_at() < newest);
    assert!(timeline.step_forward().is_there());
    assert_eq!(timeline.facts().newest_line_at(), newest);
    while !timeline.work(1000) {}
    assert!(!timeline.is_partial());
    assert_eq!(text_of(timeline.facts()), text_of(whole.facts()));
}

/// Nearby landmarks of an unread day are the same as in a read one.
#[test]
fn jump_in_an_unread_capture_searches_nearby_first() {
    let folder = groundwave_captures::samples();
    let day = std::fs::read(folder.join("house-clean.txt")).unwrap();
    let day = day.repeat(40);
    let (mut whole, end) = read_whole(text(&day));
    for kind in [Landmark::Alarm, Landmark::Bump, Landmark::Behaviour] {
        let reader = text(&day);
        let first = CaptureState::new("radio", Arc::default(), &*reader);
        let mut timeline = capture::timeline(reader, first);
        let (mut back, mut ahead) = (end, end / 10 * 7);
        for _ in 0..6 {
            let found = timeline.find_last(kind, back, STEPS_MAX);
            assert_eq!(found, whole.find_last(kind, back, STEPS_MAX), "{kind:?}");
            let Found::At(at) = found else {
                panic!("{kind:?}: {found:?}");
            };
            back = at;
            let found = timeline.find_next(kind, ahead, STEPS_MAX);
            assert_eq!(found, whole.find_next(kind, ahead, STEPS_MAX), "{kind:?}");
            let Found::At(at) = found else {
                panic!("{kind:?}: {found:?}");
            };
            ahead = at;
        }
    }
}

/// Commands are station events, not lines: the last and the next are found in an unread day as
/// in a read one.
#[test]
fn nearby_command_in_an_unread_capture_is_found() {
    let folder = groundwave_captures::samples();
    let calm = std::fs::read(folder.join("house-clean.txt")).unwrap();
    let session = Session {
        link: "radio".to_owned(),
        start: std::time::UNIX_EPOCH,
        notes: std::collections::BTreeMap::new(),
        configuration: String::new(),
    };
    let mut writer = SessionWriter::new(Vec::new(), &session).unwrap();
    let mut asked = Vec::new();
    for (n, line) in (1_u64..).zip(calm.repeat(20).chunks(80)) {
        let at_ns = n * 1_000_000_000 / 3;
        writer.handle_rx(at_ns, line).unwrap();
        if n % 211 == 100 {
            let id = CommandId(n as u32);
            let request = Request::Scan;
            let by = None;
            let event =
                crate::recorded::to_recorded(Moment::ZERO, &Event::Asked { id, request, by })
                    .unwrap();
            writer.handle_event(at_ns, &event).unwrap();
            // The recording's first message has a time in 1970.
            asked.push(Moment::from_nanos(at_ns));
        }
    }
    let day = writer.finish().unwrap();
    let reader = index::read(Arc::new(day), Path::new("day.mcap")).unwrap();
    let first = CaptureState::new("radio", Arc::default(), &*reader);
    let mut timeline = capture::timeline(reader, first);
    let middle = asked.len() / 2;
    let beside = asked[middle] + Moment::from_secs(1);
    let last = timeline.find_last(Landmark::Command, beside, STEPS_MAX);
    assert_eq!(last, Found::At(asked[middle]));
    let last = timeline.find_last(Landmark::Command, asked[middle], STEPS_MAX);
    assert_eq!(last, Found::At(asked[middle - 1]));
    let next = timeline.find_next(Landmark::Command, beside, STEPS_MAX);
    assert_eq!(next, Found::At(asked[middle + 1]));
    // Too far to search at once.
    let far = timeline.find_last(Landmark::Command, asked[middle], 10);
    assert_eq!(far, Found::NotYet);
}
