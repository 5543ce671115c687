//! Targets in the unread part are found by the index, and are the same as
//! reading finds.

use proptest::prelude::*;

use super::capture::SHORTCUTS;
use super::*;
use crate::capture::Session;
use crate::capture::SessionWriter;
use crate::capture::index::Piece;
use crate::model::Facts;

/// The received bytes of a capture.
fn bytes_of(name: &str) -> Vec<u8> {
    let mut reader = capture(name);
    let mut bytes = Vec::new();
    while let Some(piece) = reader.next_piece() {
        if let Piece::Received(some) = piece {
            bytes.extend_from_slice(some);
        }
    }
    bytes
}

fn of_bytes(bytes: Vec<u8>) -> Box<dyn SeekableReader + Send> {
    index::read(Arc::new(bytes), Path::new("unread")).unwrap()
}

/// The lines as a recording, three a second, in chunks of the given numbers of lines.
fn recorded(text: &[u8], chunks: impl IntoIterator<Item = usize>) -> Vec<u8> {
    let session = Session {
        link: "radio".to_owned(),
        start: std::time::UNIX_EPOCH,
        notes: std::collections::BTreeMap::new(),
        configuration: String::new(),
    };
    let mut writer = SessionWriter::new(Vec::new(), &session).unwrap();
    let mut chunks = chunks.into_iter();
    let mut left = chunks.next();
    for (n, line) in (1_u64..).zip(text.split_inclusive(|&byte| byte == b'\n')) {
        writer.handle_rx(n * 1_000_000_000 / 3, line).unwrap();
        left = left.map(|left| left.saturating_sub(1));
        if left == Some(0) {
            writer.end_chunk().unwrap();
            left = chunks.next();
        }
    }
    writer.finish().unwrap()
}

/// The recording without a topic, as other tools filter it.
fn without(topic: &str, recording: &[u8]) -> Vec<u8> {
    let mut filtered = std::io::Cursor::new(Vec::new());
    let options = mcap::WriteOptions::new().chunk_size(Some(1024));
    let mut writer = options.create(&mut filtered).unwrap();
    for message in mcap::MessageStream::new(recording).unwrap() {
        let message = message.unwrap();
        if message.channel.topic != topic {
            writer.write(&message).unwrap();
        }
    }
    writer.finish().unwrap();
    drop(writer);
    filtered.into_inner()
}

fn unread(reader: Box<dyn SeekableReader + Send>) -> Timeline<CaptureState> {
    let first = CaptureState::new("radio", Arc::default(), &*reader);
    capture::timeline(reader, first)
}

fn lines(facts: &Facts) -> u64 {
    facts.tally().lines
}

const KINDS: [Landmark; 4] = [
    Landmark::Alarm,
    Landmark::Bump,
    Landmark::Behaviour,
    Landmark::Command,
];

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// For any chunks: the index has the time of each line and rules out no landmark,
    /// and neither does the prefilter of a text.
    #[test]
    fn index_and_prefilter_agree_with_reading(
        name in prop::sample::select(&CAPTURES[..]),
        times in 1_usize..4,
        chunks in prop::collection::vec(1_usize..60, 1..40),
    ) {
        let text = bytes_of(name).repeat(times);
        for (is_counted, bytes) in [(true, recorded(&text, chunks)), (false, text)] {
            let mut reader = of_bytes(bytes);
            let mut scene = CaptureState::new("radio", Arc::default(), &*reader);
            let mut index = reader.reopen();
            let mut left_out = 0;
            // Lines up to each moment.
            let mut came = vec![(Moment::ZERO, 0)];
            while let Some(at) = scene.next_at(&mut reader) {
                let counted = scene.facts().tally();
                scene.step(&mut reader);
                let tally = scene.facts().tally();
                let is_line = tally.lines > counted.lines;
                for kind in KINDS {
                    let is_one = tally.of(kind) > counted.of(kind);
                    // A scan of the text takes time.
                    if is_counted || is_one || tally.lines.is_multiple_of(16) {
                        let may_hold = index.may_hold(kind, at, at);
                        prop_assert!(may_hold || !is_one, "{kind:?} at {at:?}");
                        left_out += u32::from(!may_hold);
                    }
                }
                if is_line && is_counted {
                    came.push((at, tally.lines));
                    let (from, count) = index.about_line(tally.lines).expect("it is there");
                    // Acknowledgement lines make the estimate early.
                    prop_assert!(from <= at);
                    if name != "demo-commands.mcap" {
                        prop_assert_eq!(from, at);
                        let earlier = came.iter().rev().find(|(at, _)| *at < from);
                        prop_assert_eq!(count, earlier.map_or(0, |(_, lines)| *lines));
                    }
                }
            }
            let is_there = index.about_line(lines(scene.facts()) + 1).is_some();
            prop_assert!(!is_there || !is_counted || name == "demo-commands.mcap");
            prop_assert!(left_out > 0 || times == 1, "it leaves nothing out");
        }
    }
}

/// A missing topic does not rule landmarks out.
#[test]
fn landmarks_without_a_topic_are_searched() {
    for name in CAPTURES {
        let recording = recorded(&bytes_of(name), std::iter::repeat(5));
        for (topic, kind) in [("/log", Landmark::Bump), ("/uplink", Landmark::Command)] {
            let mut whole = of_bytes(recording.clone());
            let mut filtered = of_bytes(without(topic, &recording));
            let end = whole.length();
            let mut some = 0;
            for ms in (0..end.as_millis() as u64).step_by(1000) {
                let (from, until) = (Moment::from_millis(ms), Moment::from_millis(ms + 999));
                some += u32::from(whole.may_hold(kind, from, until));
                assert!(filtered.may_hold(kind, from, until), "{name}: {kind:?}");
            }
            assert!(
                u128::from(some) < end.as_millis() / 1000,
                "{name}: {kind:?}"
            );
        }
    }
}

/// A line of an unread recording is shown at once, and exactly when it is read.
#[test]
fn line_in_the_unread_part_is_shown_at_its_estimate() {
    for (name, slack) in [("house-clean.txt", 0.001), ("house-noisy.txt", 0.03)] {
        let text = bytes_of(name).repeat(40);
        for (form, slack, bytes) in [
            ("mcap", 0.0, recorded(&text, None)),
            ("raw", slack, text.clone()),
        ] {
            let (mut whole, end) = read_whole(of_bytes(bytes.clone()));
            whole.seek(end);
            let all = lines(whole.facts());
            for number in [all / 2, all * 4 / 5, all * 19 / 20] {
                assert!(matches!(whole.seek_line(number, 0), Found::At(_)));
                let reader = of_bytes(bytes.clone());
                let length = reader.length();
                let timeline = unread(reader);
                let mut player = Player::of_capture(timeline, Moment::ZERO, 1.0, length, None);
                player.handle(Moment::ZERO, Control::Seek(Position::Line(number)));
                let playback = player.playback();
                assert!(playback.is_looking && player.is_paused(), "{name} {form}");
                let note = said(playback);
                assert!(note.starts_with(&format!("about line {number}:")), "{note}");
                let off = player.at().abs_diff(whole.at());
                assert!(
                    off <= end.mul_f64(slack),
                    "{name} {form}: line {number} is off by {off:?} of {end:?}"
                );
                if off.is_zero() {
                    let robot = |facts: &Facts| format!("{:?}", facts.robot.state);
                    assert_eq!(robot(player.facts()), robot(whole.facts()));
                }
                while player.has_work() {
                    player.work(997);
                }
                assert_eq!(player.playback().line, Some(number), "{name} {form}");
                assert_eq!(
                    text_of(player.facts()),
                    text_of(whole.facts()),
                    "{name} {form}"
                );
                assert!(!player.playback().is_looking);
            }
        }
    }
}

/// A damaged index may lead anywhere; reading corrects it.
#[test]
fn reading_corrects_a_damaged_index() {
    let bytes = recorded(&bytes_of("house-clean.txt"), (3..30).cycle().take(100));
    let summary_at = bytes.len() * 9 / 10;
    let mut rng = 11_usize;
    for n in 0..150 {
        rng = rng
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        let mut bytes = bytes.clone();
        let at = summary_at + (rng >> 33) % (bytes.len() - summary_at);
        bytes[at] ^= 1 << (n % 8);
        let Ok(reader) = index::read(Arc::new(bytes), Path::new("unread")) else {
            continue;
        };
        let mut again = reader.reopen();
        let first = CaptureState::new("radio", Arc::default(), &*reader);
        let mut timeline = unread(reader);
        timeline.seek_about_line(300);
        let mut player = Player::of_capture(timeline, Moment::ZERO, 1.0, Moment::MAX, None);
        player.handle(
            Moment::ZERO,
            Control::Jump {
                to: Some(Landmark::Command),
                forward: true,
            },
        );
        player.handle(Moment::ZERO, Control::Seek(Position::Line(300)));
        read_through(
            first,
            &mut again,
            || true,
            |finding| {
                match finding {
                    Finding::State(scene) => player.timeline_mut().keep(*scene),
                    Finding::Marks(_) => {}
                    Finding::End(at) => player.set_read_through(at),
                }
                true
            },
        );
        assert_eq!(player.playback().line, Some(300), "flipped at {at}");
        assert!(!player.playback().is_looking, "flipped at {at}");
    }
}

/// Ending a search stays at the estimate; a missing line is reported when all is read.
#[test]
fn estimate_of_a_line_can_be_kept() {
    let bytes = recorded(&bytes_of("house-clean.txt").repeat(15), None);
    let reader = of_bytes(bytes);
    let length = reader.length();
    let mut player = Player::of_capture(unread(reader), Moment::ZERO, 1.0, length, None);
    player.handle(Moment::ZERO, Control::Seek(Position::Line(5_000)));
    let at = player.at();
    assert!(at > Moment::from_mins(8));
    player.handle(Moment::ZERO, Control::StopSearch);
    assert!(player.at() == at && !player.playback().is_looking);
    player.handle(Moment::ZERO, Control::Seek(Position::Line(200_000)));
    assert!(player.at() == at && player.playback().is_looking);
    player.set_read_through(length);
    assert_eq!(said(player.playback()), "there is no line 200000");
}

/// A search interrupted after every few steps finds what reading finds, in text and in recordings.
#[test]
fn a_search_goes_on_where_it_was_interrupted() {
    let clean = bytes_of("house-clean.txt").repeat(30);
    let noisy = bytes_of("house-noisy.txt").repeat(30);
    let commands = bytes_of("demo-commands.mcap").repeat(30);
    for bytes in [
        recorded(&clean, (3..50).cycle().take(2000)),
        recorded(&noisy, (3..50).cycle().take(2000)),
        recorded(&commands, (3..50).cycle().take(2000)),
        clean,
        noisy,
        commands,
    ] {
        let (mut whole, end) = read_whole(of_bytes(bytes.clone()));
        for kind in KINDS {
            let mut timeline = unread(of_bytes(bytes.clone()));
            for place in [5, 6, 9] {
                let at = end * place / 10;
                let searched = |found: Found, timeline: &mut Timeline<CaptureState>| {
                    let mut found = found;
                    while found == Found::NotYet && timeline.is_searching() {
                        found = timeline.search(7);
                    }
                    found
                };
                let found = timeline.find_next(kind, at, 1);
                let found = searched(found, &mut timeline);
                assert_eq!(found, whole.find_next(kind, at, 0), "{kind:?} after {at:?}");
                let found = timeline.find_last(kind, at, 1);
                let found = searched(found, &mut timeline);
                assert_eq!(
                    found,
                    whole.find_last(kind, at, 0),
                    "{kind:?} before {at:?}"
                );
            }
        }
        // Keyframes show that there is no landmark before the first.
        let mut timeline = unread(of_bytes(bytes));
        let first = whole.find_next(Landmark::Bump, Moment::ZERO, 0);
        let Found::At(first) = first else {
            panic!("{first:?}");
        };
        let mut found = timeline.find_last(Landmark::Bump, first, 1);
        while found == Found::NotYet && timeline.is_searching() {
            found = timeline.search(7);
        }
        assert_eq!(found, Found::Nowhere);
    }
}

/// Cached states between distant keyframes give the same moments, lines and landmarks.
#[test]
fn cached_states_equal_played_states() {
    let bytes = bytes_of("house-noisy.txt").repeat(12);
    let mut reader = of_bytes(bytes.clone());
    let mut scene = CaptureState::new("radio", Arc::default(), &*reader);
    let mut timeline = Timeline::unread(reader.reopen(), &SHORTCUTS, scene.clone(), Moment::MAX);
    timeline.complete();
    let mut played = Vec::new();
    let mut things = 0;
    while scene.next_at(&mut reader).is_some() {
        let counted = lines(scene.facts());
        scene.step(&mut reader);
        things += 1;
        if things % 41 == 0 && lines(scene.facts()) > counted {
            played.push(scene.clone());
        }
    }
    let last = played.len() - 1;
    assert!(
        things > 3 * 512 && last > 40,
        "{things} things, {last} places"
    );
    // On the way to the last place, states are cached.
    let number = lines(played[last].facts());
    assert!(matches!(timeline.seek_line(number, 0), Found::At(_)));
    let mut rng = 3_usize;
    for n in 0..60 {
        rng = rng
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        let wanted = &played[(rng >> 33) % played.len()];
        let number = lines(wanted.facts());
        match n % 3 {
            0 => timeline.seek(wanted.moment()),
            1 => assert!(matches!(timeline.seek_line(number, 0), Found::At(_))),
            _ => {
                assert!(matches!(timeline.seek_line(number, 0), Found::At(_)));
                assert!(timeline.step_forward().is_there() && timeline.step_back().is_there());
            }
        }
        assert!(!timeline.is_partial());
        assert_eq!(timeline.line(), Some(number), "visit {n}");
        assert!(
            text_of(timeline.facts()) == text_of(wanted.facts()),
            "visit {n}"
        );
    }
}
