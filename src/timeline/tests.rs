//! A moment again is that moment: of live sessions made of anything, and of captures.

use std::path::Path;
use std::sync::Arc;

use proptest::prelude::*;

use super::past::{self, REMEMBERED};
use super::reel::{Cursor, Found, STEPS_MAX};
use super::scene::SPACING;
use super::*;
use crate::capture::index::{self, Tape};
use crate::event::{Event, Level, LinkEvent, Moment};
use crate::model::testing::{Scene as Robot, any_event};
use crate::model::{Config, Model};
use crate::travel::{Landmark, Target, Travel};

fn told(model: &Model) -> String {
    format!("{model:?}")
}

fn is_fact(event: &Event) -> bool {
    !matches!(
        event,
        Event::Key(_)
            | Event::Paste(_)
            | Event::Resize { .. }
            | Event::Recording(_)
            | Event::Playback(_)
            | Event::Tick
    )
}

/// A live session as the event loop remembers it.
struct Session {
    reel: Reel<Past>,
    model: Model,
    now: Moment,
}

impl Session {
    fn new() -> Self {
        let model = Model::new(Config::default());
        let first = Past::new(model.clone(), Moment::ZERO, 0);
        Self {
            reel: Reel::new(History::default(), first, past::SPACING),
            model,
            now: Moment::ZERO,
        }
    }

    fn take(&mut self, event: Event) {
        self.reel.supply_mut().push(self.now, event.clone());
        self.model.update(self.now, event);
        if self.reel.wants(self.now) {
            let next = self.reel.supply().count();
            self.reel
                .keep(Past::new(self.model.clone(), self.now, next));
        }
        let oldest = self.now.saturating_sub(REMEMBERED);
        if let Some(next) = self.reel.forget_before(oldest).map(Past::next) {
            self.reel.supply_mut().forget_before(next);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn a_live_session_can_be_seen_as_it_was(
        events in prop::collection::vec((any_event(), 1_u64..20_000), 1..120),
        places in prop::collection::vec(any::<prop::sample::Index>(), 1..12),
    ) {
        let mut session = Session::new();
        let mut was = vec![(Moment::ZERO, told(&session.model))];
        for (event, wait_ms) in events.into_iter().filter(|(event, _)| is_fact(event)) {
            session.now += Moment::from_millis(wait_ms);
            session.take(event);
            was.push((session.now, told(&session.model)));
        }
        for place in places {
            let (at, was) = place.get(&was);
            session.reel.seek(*at);
            prop_assert_eq!(&told(session.reel.model()), was);
        }
    }
}

#[test]
fn a_live_session_of_hours_is_remembered_in_bounded_memory() {
    let mut robot = Robot::new(Config::default());
    let mut session = Session::new();
    for n in 0..40_000 {
        robot.state.x_tenths_in = n;
        session.now += Moment::from_millis(333);
        session.take(Event::Notice {
            level: if n % 10_000 == 9_000 {
                Level::Alarm
            } else {
                Level::Info
            },
            text: n.to_string(),
        });
    }
    let from = session.reel.oldest_at().unwrap();
    let back = session.now.saturating_sub(from);
    assert!(
        back >= REMEMBERED && back < REMEMBERED + past::SPACING * 2,
        "{back:?}"
    );
    session.reel.seek(Moment::ZERO);
    assert!(session.reel.at() <= from, "no farther than it goes");
    let last = session
        .reel
        .find_last(Landmark::Alarm, session.now, STEPS_MAX);
    let alarm = Moment::from_millis(39_001 * 333);
    assert_eq!(last, Found::At(alarm));
    assert_eq!(
        session.reel.find_next(Landmark::Alarm, alarm, STEPS_MAX),
        Found::Nowhere
    );
    assert_eq!(
        session
            .reel
            .find_last(Landmark::Bump, session.now, STEPS_MAX),
        Found::Nowhere
    );
}

fn capture(name: &str) -> Box<dyn Tape + Send> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("captures");
    index::open(&folder.join(name)).unwrap()
}

fn text(bytes: &[u8]) -> Box<dyn Tape + Send> {
    index::read(Arc::new(bytes.to_vec()), Path::new("text")).unwrap()
}

/// A capture with all its states.
fn surveyed(tape: Box<dyn Tape + Send>) -> (Reel<Scene>, Moment) {
    let first = Scene::new("radio", Config::default(), &*tape);
    let mut again = tape.again();
    let mut reel = Reel::new(tape, first.clone(), SPACING);
    let mut end = Moment::ZERO;
    survey(first, &mut again, |finding| {
        match finding {
            Finding::State(scene) => reel.keep(*scene),
            Finding::End(at) => end = at,
        }
        true
    });
    reel.complete();
    (reel, end)
}

fn player(name: &str) -> Player<Scene> {
    let tape = capture(name);
    let (length, unix) = (tape.length(), tape.unix());
    let (reel, end) = surveyed(tape);
    let mut player = Player::of_capture(reel, Moment::ZERO, 1.0, length, unix);
    player.set_read_through(end);
    player
}

const CAPTURES: [&str; 4] = [
    "house-clean.txt",
    "house-noisy.txt",
    "living-room-bursts.txt",
    "demo-commands.mcap",
];

/// Every moment at which something happened, and what was shown then by playing there from the beginning.
fn played(name: &str) -> Vec<(Moment, String)> {
    let mut tape = capture(name);
    let mut scene = Scene::new("radio", Config::default(), &*tape);
    let mut shown = vec![(Moment::ZERO, told(scene.model()))];
    while let Some(at) = scene.next_at(&mut tape) {
        scene.step(&mut tape);
        match shown.last_mut() {
            Some(last) if last.0 == at => last.1 = told(scene.model()),
            _ => shown.push((at, told(scene.model()))),
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
                told(reel.model()) == *shown,
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
            let mut scene = Scene::new("radio", Config::default(), &*tape);
            let mut all = Vec::new();
            while let Some(at) = scene.next_at(&mut tape) {
                let before = scene.model().tally().of(kind);
                scene.step(&mut tape);
                if scene.model().tally().of(kind) > before && all.last() != Some(&at) {
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
    let first = Scene::new("radio", Config::default(), &*tape);
    let mut reel = Reel::new(tape, first, SPACING);
    reel.seek(at);
    assert!(reel.is_partial() && reel.packet().is_none());
    let robot = |reel: &Reel<Scene>| format!("{:?}", reel.model().robot.state);
    assert_eq!(robot(&reel), robot(&whole), "what is new is right");
    assert_eq!(
        reel.find_next(Landmark::Alarm, at, STEPS_MAX),
        Found::NotYet
    );
    let newest = reel.model().newest_line_at();
    assert!(reel.step_back() && reel.model().newest_line_at() < newest);
    assert!(reel.step_forward());
    assert_eq!(reel.model().newest_line_at(), newest);
    while !reel.work(1000) {}
    assert!(!reel.is_partial());
    assert_eq!(told(reel.model()), told(whole.model()));
}

/// What lies where nobody has read yet is waited for, and gone to by itself.
#[test]
fn a_jump_waits_for_what_is_not_read_yet() {
    let calm =
        std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("captures/house-clean.txt"));
    let calm = calm.unwrap();
    let day = calm.repeat(60);
    let lines = 60 * 359;
    let tape = text(&day);
    let length = tape.length();
    let first = Scene::new("radio", Config::default(), &*tape);
    let mut again = tape.again();
    let reel = Reel::new(tape.again(), first.clone(), SPACING);
    let host = Moment::ZERO;
    let mut player = Player::of_capture(reel, host, 1.0, length, None);
    let packet = |number| Travel::Seek(Target::Packet(number));
    player.handle(host, packet(lines - 100));
    let looks = |player: &Player<Scene>| {
        let playback = player.playback();
        let note = playback.note.unwrap_or_default();
        assert_eq!(
            playback.is_looking,
            note.starts_with("looking for packet"),
            "{note}"
        );
        playback.is_looking
    };
    assert!(looks(&player) && player.is_paused());
    // Whoever gives up stands where he stood.
    player.handle(host, Travel::GiveUp);
    assert!(!looks(&player) && player.at() == Moment::ZERO);
    player.handle(host, packet(lines - 100));
    let mut findings = 0;
    survey(first.clone(), &mut again, |finding| {
        if let Finding::State(scene) = finding {
            let at = scene.moment();
            player.reel_mut().keep(*scene);
            player.set_read(at);
            findings += 1;
        }
        looks(&player)
    });
    assert!(findings > 10 && !looks(&player));
    assert_eq!(player.playback().packet, Some(lines - 100));
    // At the end it is known that there is none.
    let mut player = Player::of_capture(
        Reel::new(tape.again(), first, SPACING),
        host,
        1.0,
        length,
        None,
    );
    player.handle(host, packet(lines * 2));
    assert!(looks(&player));
    player.set_read_through(length);
    let note = player.playback().note;
    assert_eq!(note, Some(format!("there is no packet {}", lines * 2)));
}

#[test]
fn time_passes_at_any_speed_and_loops() {
    let mut player = player("house-clean.txt");
    let s = Moment::from_secs;
    let mut host = s(0);
    let mut pass = |player: &mut Player<Scene>, seconds: u64| {
        for _ in 0..seconds * 10 {
            host += Moment::from_millis(100);
            player.advance(host);
        }
        host
    };
    let about = |player: &Player<Scene>, wanted: u64| {
        let off = player.at().abs_diff(s(wanted));
        assert!(
            off < Moment::from_millis(5),
            "{:?}, not {wanted} s",
            player.at()
        );
    };
    let host = pass(&mut player, 10);
    about(&player, 10);
    player.handle(host, Travel::Speed(4.0));
    let host = pass(&mut player, 5);
    about(&player, 30);
    player.handle(host, Travel::TogglePause);
    let shown = told(player.model());
    let host = pass(&mut player, 100);
    about(&player, 30);
    assert_eq!(told(player.model()), shown, "it stands still");
    assert_eq!(player.wake_at(), None, "and costs nothing");
    player.handle(host, Travel::TogglePause);
    player.handle(host, Travel::Speed(0.1));
    let host = pass(&mut player, 10);
    about(&player, 31);
    player.handle(host, Travel::Speed(1.0));
    player.handle(host, Travel::Loop);
    let host = pass(&mut player, 5);
    player.handle(host, Travel::Loop);
    about(&player, 36);
    let host = pass(&mut player, 7);
    about(&player, 33);
    player.handle(host, Travel::Loop);
    player.handle(host, Travel::Speed(f64::MAX));
    let host = pass(&mut player, 1);
    assert!(player.is_at_end() && player.is_paused());
    player.handle(host, Travel::TogglePause);
    about(&player, 0);
}

#[test]
fn every_typed_place_is_gone_to() {
    let mut player = player("demo-commands.mcap");
    let s = Moment::from_secs;
    let host = s(0);
    player.handle(host, Travel::TogglePause);
    let end = player.playback().until;
    let unix = player.playback().unix.unwrap();
    let mut go = |text: &str| {
        let target: Target = text.parse().unwrap();
        player.handle(host, Travel::Seek(target));
        (player.at(), player.playback())
    };
    assert_eq!(go("0:20").0, s(20));
    assert_eq!(go("+5s").0, s(25));
    assert_eq!(go("-10s").0, s(15));
    assert_eq!(go("-10m").0, s(0));
    assert!(go("50%").0.abs_diff(end / 2) <= Moment::from_nanos(1));
    assert_eq!(go("9:59:59").0, end);
    let (at, playback) = go("#30");
    assert_eq!(playback.packet, Some(30));
    assert!(at > s(5) && at < s(20), "{at:?}");
    let (there, playback) = go("#999999");
    assert_eq!(
        (there, playback.note.as_deref()),
        (at, Some("there is no packet 999999"))
    );
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
fn marks_are_set_gone_to_and_taken_away() {
    let mut player = player("house-clean.txt");
    let host = Moment::ZERO;
    let s = Moment::from_secs;
    let seek = |player: &mut Player<Scene>, at| {
        player.handle(host, Travel::Seek(Target::At(at)));
    };
    for at in [s(40), s(20)] {
        seek(&mut player, at);
        player.handle(host, Travel::Mark);
    }
    assert_eq!(player.playback().markers, [s(20), s(40)]);
    let jump = |forward| Travel::Jump {
        to: Some(Landmark::Marker),
        forward,
    };
    player.handle(host, jump(true));
    assert_eq!(player.at(), s(40));
    assert!(player.is_paused());
    player.handle(host, jump(true));
    assert_eq!(
        player.playback().note.as_deref(),
        Some("there are no later markers")
    );
    player.handle(
        host,
        Travel::Jump {
            to: None,
            forward: false,
        },
    );
    assert_eq!(player.at(), s(20), "as before");
    player.handle(host, Travel::Mark);
    assert_eq!(player.playback().markers, [s(40)]);
}

#[test]
fn jumps_stand_still_where_it_happened() {
    let mut player = player("house-clean.txt");
    let host = Moment::ZERO;
    let bump = |forward| Travel::Jump {
        to: Some(Landmark::Bump),
        forward,
    };
    player.handle(host, bump(true));
    let first = player.at();
    assert_eq!(player.model().tally().bumps, 1);
    player.handle(host, bump(true));
    assert_eq!(player.model().tally().bumps, 2);
    player.handle(host, bump(false));
    assert_eq!(player.at(), first);
    player.handle(host, bump(false));
    assert_eq!(
        player.playback().note.as_deref(),
        Some("there are no earlier bumps")
    );
    player.handle(host, Travel::Newest);
    assert!(player.is_at_end());
    player.handle(host, Travel::Oldest);
    assert_eq!(player.at(), Moment::ZERO);
}

/// The same lines with the times of others before them: the same robot, at their times.
#[test]
fn stamped_text_is_played_at_its_own_times() {
    let plain =
        std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("captures/house-clean.txt"));
    let plain = plain.unwrap();
    let mut stamped = Vec::new();
    for (n, line) in plain.split_inclusive(|&byte| byte == b'\n').enumerate() {
        // A robot that was switched off for an hour in the middle.
        let second = n / 3 + if n > 150 { 3600 } else { 0 };
        let (h, m, s) = (22 + second / 3600, second / 60 % 60, second % 60);
        let stamp = format!("2026-11-21T{h:02}:{m:02}:{s:02}Z ");
        stamped.extend(stamp.as_bytes());
        stamped.extend(line);
    }
    let tape = text(&stamped);
    assert_eq!(tape.unix(), Some(Moment::from_hours(498_694)));
    let length = tape.length();
    let (mut reel, end) = surveyed(tape);
    assert!(
        end <= length && end > Moment::from_hours(1),
        "{end:?} of {length:?}"
    );
    let (mut untimed, plain_end) = surveyed(text(&plain));
    reel.seek(end);
    untimed.seek(plain_end);
    assert_eq!(reel.model().tally().lines, untimed.model().tally().lines);
    // In the pause nothing happened, and the link is told to be silent.
    reel.seek(Moment::from_mins(30));
    let silent = reel.model().tally().lines;
    assert_eq!(
        reel.at().as_secs(),
        55,
        "five seconds after the last line it is told"
    );
    reel.seek(Moment::from_mins(50));
    assert_eq!(reel.model().tally().lines, silent);
    // Lines with the same stamp follow each other as on the radio.
    assert!(matches!(reel.seek_line(20, STEPS_MAX), Found::At(_)));
    let times: Vec<Moment> = (0..6)
        .map(|_| {
            assert!(reel.step_forward());
            reel.at()
        })
        .collect();
    assert!(times.is_sorted_by(|a, b| a < b), "{times:?}");
    // Finding a time in a file without reading it through.
    for s in [0, 1, 30, 49, 50, 51, 2000, 3650, 3700] {
        let at = Moment::from_secs(s);
        let place = text(&stamped).find(at);
        let mut tape = text(&stamped);
        tape.go(place);
        let next = tape.next_at().unwrap();
        assert!(next < at || s == 0, "{s}: {next:?}");
        while tape.next_at().is_some_and(|next| next < at) {
            let from = tape.next_at().unwrap();
            tape.next_piece();
            let next = tape.next_at().unwrap_or(Moment::MAX);
            assert!(
                from + Moment::from_secs(1) >= next.min(at) || s >= 2000,
                "{s}"
            );
        }
    }
}

#[test]
fn what_is_cut_off_or_damaged_is_shown_as_far_as_it_goes_and_says_why() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("captures/demo-commands.mcap");
    let whole = std::fs::read(path).unwrap();
    let lines = |bytes: &[u8]| {
        let tape = index::read(Arc::new(bytes.to_vec()), Path::new("x.mcap"));
        let tape = tape.map_err(|error| error.to_string())?;
        let (mut reel, end) = surveyed(tape);
        reel.seek(end);
        let tally = reel.model().tally();
        let log: Vec<String> = reel
            .model()
            .log
            .newest_first()
            .map(|e| e.text.clone())
            .collect();
        assert!(
            log.iter().any(|text| text.contains("session is over")),
            "{log:?}"
        );
        Ok::<_, String>((tally.lines, tally.alarms, log))
    };
    let (all, alarms, _) = lines(&whole).unwrap();
    let mut dice = 7_usize;
    let (mut opened, mut before) = (0, 0);
    for n in 0..120 {
        dice = dice
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        let at = (dice >> 33) % whole.len();
        match lines(&whole[..at]) {
            Ok((some, _, log)) => {
                opened += 1;
                before += some;
                assert!(some <= all);
                let says = log.iter().any(|text| text.contains("interrupted"));
                assert!(says || some == all, "cut at {at}: {some} of {all} lines");
            }
            Err(error) => assert!(error.contains("x.mcap"), "{error}"),
        }
        let mut flipped = whole.clone();
        flipped[at] ^= 1 << (n % 8);
        if let Ok((some, told, log)) = lines(&flipped) {
            assert!(some <= all, "flipped at {at}");
            assert!(
                some == all || told > alarms,
                "flipped at {at}: {some} of {all}: {log:?}"
            );
        }
    }
    assert!(opened > 60 && before > 0, "{opened} opened, {before} lines");
}

#[test]
fn an_empty_capture_ends_at_once() {
    let (mut reel, end) = surveyed(text(b""));
    reel.seek(end);
    assert_eq!(end, Moment::ZERO);
    assert!(!reel.step_forward() && !reel.step_back());
}

/// The station says the same whatever the pieces are, and a scene what a station says.
#[test]
fn a_live_run_in_any_chunks_and_a_replay_know_the_same() {
    use crate::capture::index::Piece;
    use crate::station::Station;
    for name in CAPTURES {
        for seed in 1..4_usize {
            let mut dice = seed;
            let mut tape = capture(name);
            let mut station = Station::new(groundwave_protocol::arq::Config::new(1), false);
            let mut model = Model::new(Config::default());
            station.handle_link(LinkEvent::Opened {
                name: "radio".to_owned(),
                can_send: false,
            });
            let mut now = Moment::ZERO;
            let listen = |now, station: &mut Station, model: &mut Model| {
                while let Some(event) = station.poll_event() {
                    model.update(now, event);
                }
            };
            listen(now, &mut station, &mut model);
            while let Some(at) = tape.next_at() {
                loop {
                    let due = station
                        .poll_timeout()
                        .into_iter()
                        .chain(model.poll_timeout());
                    let Some(due) = due.min().filter(|due| *due < at) else {
                        break;
                    };
                    now = due.max(now);
                    station.handle_timeout(now);
                    listen(now, &mut station, &mut model);
                    model.update(now, Event::Tick);
                }
                now = at;
                match tape.next_piece().unwrap() {
                    Piece::Received(mut bytes) => {
                        while !bytes.is_empty() {
                            dice = dice.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                            let cut = 1 + (dice >> 33) % bytes.len();
                            station.handle_bytes(now, &bytes[..cut]);
                            listen(now, &mut station, &mut model);
                            bytes = &bytes[cut..];
                        }
                    }
                    Piece::Sent(bytes) => station.handle_sent(now, bytes),
                    // What a station of that day told, this one tells of the same bytes; the rest was told to both.
                    Piece::Told(Event::Link(_)) | Piece::Nothing => {}
                    Piece::Told(event) => {
                        model.update(now, event);
                    }
                    other => panic!("{other:?}"),
                }
                listen(now, &mut station, &mut model);
            }
            station.handle_link(LinkEvent::Ended);
            listen(now, &mut station, &mut model);
            let (mut reel, end) = surveyed(capture(name));
            reel.seek(end);
            assert!(told(reel.model()) == told(&model), "{name}, seed {seed}");
        }
    }
}
