//! Playing: speeds, loops, marks, and jumps to targets that may not have been read yet.

use super::*;
use crate::model::keys::{Keymap, Rebinding};
use crate::recorded;

fn player(name: &str) -> Player<CaptureState> {
    let reader = capture(name);
    let (length, unix) = (reader.length(), reader.unix());
    let (timeline, end) = read_whole(reader);
    let mut player = Player::of_capture(timeline, Moment::ZERO, 1.0, length, unix);
    player.set_read_through(end);
    player
}

/// A target in the unread part is reached once it has been read.
#[test]
fn jump_into_the_unread_part_waits_for_it() {
    let calm = std::fs::read(groundwave_captures::samples().join("house-clean.txt"));
    let calm = calm.unwrap();
    let day = calm.repeat(20);
    let lines = 20 * 359;
    let reader = text(&day);
    let length = reader.length();
    let first = CaptureState::new("radio", Arc::default(), &*reader);
    let mut again = reader.reopen();
    let timeline = capture::timeline(reader.reopen(), first.clone());
    let host = Moment::ZERO;
    let mut player = Player::of_capture(timeline, host, 1.0, length, None);
    let line = |number| Control::Seek(Position::Line(number));
    player.handle(host, line(lines - 100));
    let looks = |player: &Player<CaptureState>| {
        let playback = player.playback();
        let note = said(playback.clone());
        let says = ["looking for line", "about line"];
        let says = says.into_iter().any(|words| note.starts_with(words));
        assert_eq!(playback.is_looking, says, "{note}");
        playback.is_looking
    };
    assert!(looks(&player) && player.is_paused());
    player.handle(host, line(lines - 100));
    let mut findings = 0;
    read_through(
        first.clone(),
        &mut again,
        || true,
        |finding| {
            match finding {
                Finding::State(scene) => {
                    let at = scene.moment();
                    player.timeline_mut().keep(*scene);
                    player.set_read(at);
                    findings += 1;
                }
                Finding::Marks(_) => {}
                Finding::End(at) => player.set_read_through(at),
            }
            looks(&player)
        },
    );
    assert!(findings > 10 && !looks(&player), "{findings}");
    assert_eq!(player.playback().line, Some(lines - 100));
    // At the end of reading the target is known not to exist.
    let mut player = Player::of_capture(
        capture::timeline(reader.reopen(), first),
        host,
        1.0,
        length,
        None,
    );
    player.handle(host, line(lines * 2));
    assert!(looks(&player));
    player.set_read_through(length);
    let note = said(player.playback());
    assert_eq!(note, format!("there is no line {}", lines * 2));
}

/// A length that was estimated too short is corrected, and the newest moment stays the newest.
#[test]
fn newest_moment_follows_the_length() {
    let reader = capture("house-clean.txt");
    let (mut timeline, end) = read_whole(reader);
    timeline.seek(Moment::ZERO);
    let estimated = end / 2;
    let mut player = Player::of_capture(timeline, Moment::ZERO, 1.0, estimated, None);
    player.handle(Moment::ZERO, Control::Newest);
    player.advance(Moment::from_secs(1));
    assert!(player.is_paused() && player.at() == estimated);
    player.set_read_through(end);
    assert!(player.is_at_end() && player.is_paused());
    assert_eq!(player.at(), end);
    assert_eq!(player.playback().line, Some(359));

    // A capture that has been played to the estimated end goes on.
    let (timeline, _) = read_whole(capture("house-clean.txt"));
    let mut player = Player::of_capture(timeline, Moment::ZERO, 1.0, estimated, None);
    player.advance(end);
    assert!(player.is_paused());
    player.set_read_through(end);
    assert!(!player.is_paused() && player.at() == estimated);
    player.advance(end + Moment::from_secs(100));
    assert_eq!(player.at(), estimated, "the wait is not skipped");
    player.advance(end + Moment::from_secs(101));
    assert_eq!(player.at(), estimated + Moment::from_secs(1));
}

#[test]
fn time_passes_at_any_speed_and_loops() {
    let mut player = player("house-clean.txt");
    let s = Moment::from_secs;
    let mut host = s(0);
    let mut pass = |player: &mut Player<CaptureState>, seconds: u64| {
        for _ in 0..seconds * 10 {
            host += Moment::from_millis(100);
            player.advance(host);
        }
        host
    };
    let about = |player: &Player<CaptureState>, wanted: u64| {
        let off = player.at().abs_diff(s(wanted));
        assert!(
            off < Moment::from_millis(5),
            "{:?}, not {wanted} s",
            player.at()
        );
    };
    let host = pass(&mut player, 10);
    about(&player, 10);
    player.handle(host, Control::Speed(4.0));
    let host = pass(&mut player, 5);
    about(&player, 30);
    player.handle(host, Control::TogglePause);
    let shown = text_of(player.facts());
    let host = pass(&mut player, 100);
    about(&player, 30);
    assert_eq!(text_of(player.facts()), shown, "it stands still");
    assert_eq!(player.wake_at(), None, "and costs nothing");
    player.handle(host, Control::TogglePause);
    player.handle(host, Control::Speed(0.1));
    let host = pass(&mut player, 10);
    about(&player, 31);
    player.handle(host, Control::Speed(1.0));
    player.handle(host, Control::Loop);
    let host = pass(&mut player, 5);
    player.handle(host, Control::Loop);
    about(&player, 36);
    let host = pass(&mut player, 7);
    about(&player, 33);
    player.handle(host, Control::Loop);
    player.handle(host, Control::Speed(f64::MAX));
    let host = pass(&mut player, 1);
    assert!(player.is_at_end() && player.is_paused());
    player.handle(host, Control::TogglePause);
    about(&player, 0);
}

#[test]
fn typed_positions_are_reached() {
    let mut player = player("demo-commands.mcap");
    let s = Moment::from_secs;
    let host = s(0);
    player.handle(host, Control::TogglePause);
    let end = player.playback().until;
    let unix = player.playback().unix.unwrap();
    let mut go = |text: &str| {
        let target: Position = text.parse().unwrap();
        player.handle(host, Control::Seek(target));
        (player.at(), player.playback())
    };
    assert_eq!(go("0:20").0, s(20));
    assert_eq!(go("+5s").0, s(25));
    assert_eq!(go("-10s").0, s(15));
    assert_eq!(go("-10m").0, s(0));
    assert!(go("50%").0.abs_diff(end / 2) <= Moment::from_nanos(1));
    assert_eq!(go("9:59:59").0, end);
    let (at, playback) = go("#30");
    assert_eq!(playback.line, Some(30));
    assert!(at > s(5) && at < s(20), "{at:?}");
    let (there, playback) = go("#999999");
    assert_eq!((there, &*said(playback)), (at, "there is no line 999999"));
    let second = unix.as_secs() + 10;
    let clock = format!(
        "{:02}:{:02}:{:02}Z",
        second / 3600 % 24,
        second / 60 % 60,
        second % 60
    );
    assert_eq!(unix + go(&clock).0, s(second));
    let hours = (second / 3600 + 12) % 24;
    assert!(go(&format!("{hours}:00Z")).1.note.is_some());
}

#[test]
fn marks_are_set_visited_and_removed() {
    let mut player = player("house-clean.txt");
    let host = Moment::ZERO;
    let s = Moment::from_secs;
    let seek = |player: &mut Player<CaptureState>, at| {
        player.handle(host, Control::Seek(Position::At(at)));
    };
    for at in [s(40), s(20)] {
        seek(&mut player, at);
        player.handle(host, Control::Mark(player.at()));
    }
    assert_eq!(player.playback().markers, [s(20), s(40)]);
    let jump = |forward| Control::Jump {
        to: Some(Landmark::Marker),
        forward,
    };
    player.handle(host, jump(true));
    assert_eq!(player.at(), s(40));
    assert!(player.is_paused());
    player.handle(host, jump(true));
    assert_eq!(said(player.playback()), "there are no later marks");
    player.handle(
        host,
        Control::Jump {
            to: None,
            forward: false,
        },
    );
    assert_eq!(player.at(), s(20), "as before");
    player.handle(host, Control::Mark(player.at()));
    assert_eq!(player.playback().markers, [s(40)]);
}

#[test]
fn marks_with_a_text_say_it_when_gone_to() {
    let mut player = player("house-clean.txt");
    let host = Moment::ZERO;
    let s = Moment::from_secs;
    player.add_noted_mark(s(30), "stairs".to_owned());
    player.add_noted_mark(s(20), "glass door".to_owned());
    player.add_noted_mark(s(20), "again".to_owned());
    assert_eq!(player.playback().markers, [s(20), s(30)]);
    let jump = Control::Jump {
        to: Some(Landmark::Marker),
        forward: true,
    };
    player.handle(host, jump);
    assert_eq!(player.at(), s(20));
    assert_eq!(said(player.playback()), "mark: glass door; again");
    player.handle(host, Control::Mark(player.at()));
    assert_eq!(player.playback().markers, [s(30)]);
    player.handle(host, jump);
    assert_eq!(said(player.playback()), "mark: stairs");
    // The recording's own marks are found while it is read.
    let ms = Moment::from_millis;
    player.set_recorded_marks(vec![ms(20_100), ms(30_020), ms(40_000)]);
    assert_eq!(player.playback().markers, [s(30), s(40)]);
    let mut remove_at = |at| {
        player.handle(host, Control::Seek(Position::At(at)));
        player.handle(host, Control::Mark(at));
        said(player.playback())
    };
    assert_eq!(
        remove_at(s(30)),
        "text removed: stairs; the recording keeps its mark at 00:30"
    );
    assert_eq!(
        remove_at(s(40)),
        "mark at 00:40 hidden: the recording keeps it, a new replay shows it"
    );
}

/// Marks of a recorded session are marks of its replay.
#[test]
fn marks_of_a_recorded_session_come_back() {
    use crate::playback::Mark;
    let plain = std::fs::read(groundwave_captures::samples().join("house-clean.txt"));
    let plain = plain.unwrap();
    let session = Session {
        link: "radio".to_owned(),
        start: std::time::UNIX_EPOCH,
        notes: std::collections::BTreeMap::new(),
        configuration: String::new(),
    };
    let mut writer = SessionWriter::new(Vec::new(), &session).unwrap();
    let s = Moment::from_secs;
    for (n, line) in (1_u64..).zip(plain.chunks(80)) {
        let at_ns = n * 1_000_000_000 / 3;
        writer.handle_rx(at_ns, line).unwrap();
        // Now, in the past, and before the beginning; one is removed again.
        for (when, ago, is_set) in [
            (60, s(0), true),
            (90, s(15), true),
            (120, Moment::from_millis(12_500), true),
            (150, Moment::from_millis(22_500), false),
            (180, s(1000), true),
        ] {
            if n == when {
                let event = recorded::to_recorded(Moment::ZERO, &Event::Mark(Mark { ago, is_set }))
                    .unwrap();
                writer.handle_event(at_ns, &event).unwrap();
            }
        }
    }
    let mcap = writer.finish().unwrap();
    let reader = index::read(Arc::new(mcap), Path::new("a.mcap")).unwrap();
    let first = CaptureState::new("radio", Arc::default(), &*reader);
    let mut again = reader.reopen();
    let length = reader.length();
    let timeline = capture::timeline(reader, first.clone());
    let mut player = Player::of_capture(timeline, Moment::ZERO, 1.0, length, None);
    player.handle(Moment::ZERO, Control::TogglePause);
    player.handle(Moment::ZERO, Control::Seek(Position::At(s(5))));
    player.handle(Moment::ZERO, Control::Mark(s(5)));
    assert_eq!(player.take_marked(), Some((s(5), true)));
    read_through(
        first,
        &mut again,
        || true,
        |finding| {
            if let Finding::Marks(marks) = finding {
                player.set_recorded_marks(marks);
            }
            true
        },
    );
    assert_eq!(player.playback().markers, [s(5), s(15), s(20)]);
}

#[test]
fn jumps_pause_at_the_landmark() {
    let mut player = player("house-clean.txt");
    let host = Moment::ZERO;
    let bump = |forward| Control::Jump {
        to: Some(Landmark::Bump),
        forward,
    };
    player.handle(host, bump(true));
    let first = player.at();
    assert_eq!(player.facts().tally().bumps, 1);
    player.handle(host, bump(true));
    assert_eq!(player.facts().tally().bumps, 2);
    player.handle(host, bump(false));
    assert_eq!(player.at(), first);
    player.handle(host, bump(false));
    assert_eq!(said(player.playback()), "there are no earlier bumps");
    player.handle(host, Control::Newest);
    assert!(player.is_at_end());
    player.handle(host, Control::Oldest);
    assert_eq!(player.at(), Moment::ZERO);
}

#[test]
fn notes_name_the_rebound_keys() {
    let chosen = [
        ("playback-loop", "F12"),
        ("mark", "F10"),
        ("ask-jump-forward", "F11"),
    ];
    let keys = chosen.map(|(name, key)| Rebinding {
        context: "dashboard".to_owned(),
        name: name.to_owned(),
        keys: vec![key.to_owned()],
    });
    let config = Config {
        keys: Keymap::with(&keys).unwrap(),
        ..Config::default()
    };
    let reader = capture("house-clean.txt");
    let first = CaptureState::new("radio", Arc::new(config), &*reader);
    let timeline = capture::timeline(reader, first);
    let mut player = Player::of_capture(timeline, Moment::ZERO, 1.0, Moment::ZERO, None);
    let mut note = |control| {
        player.handle(Moment::ZERO, control);
        said(player.playback())
    };
    assert_eq!(
        note(Control::Loop),
        "the loop begins at 00:00; F12 where it ends"
    );
    assert_eq!(
        note(Control::Mark(Moment::ZERO)),
        "marked 00:00; F11 m and N m go to marks"
    );
}
