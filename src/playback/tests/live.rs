//! The past of a live session, from memory and from its recording.

use std::fmt::Write;

use groundwave_protocol::decoder::{Counters, Decoder, Received};
use proptest::prelude::*;
use ratatui::Terminal;
use ratatui::backend::TestBackend;

use super::*;
use crate::capture::Session as About;
use crate::capture::SessionWriter;
use crate::capture::index::Piece;
use crate::event::{Level, LinkEvent, Notice, NoticeCode};
use crate::model::testing::{Scene as Robot, any_event};
use crate::model::{Shown, Ui};
use crate::playback::live::{BYTES_MAX, LivePlayer, REMEMBERED, SPACING};
use crate::recorded::{self, from_recorded};
use crate::station::Station;
use crate::view;

/// A live session and its memory.
struct Session {
    timeline: Timeline<LiveState>,
    facts: Facts,
    now: Moment,
}

impl Session {
    fn new() -> Self {
        let facts = Facts::new(Arc::default());
        let first = LiveState::new(facts.clone(), Moment::ZERO, 0);
        Self {
            timeline: Timeline::new(EventHistory::default(), first, SPACING),
            facts,
            now: Moment::ZERO,
        }
    }

    fn take(&mut self, event: &Event) {
        self.timeline.source_mut().push(self.now, event.clone());
        self.facts.update(self.now, event);
        if self.timeline.wants(self.now) {
            let next = self.timeline.source().count();
            self.timeline
                .keep(LiveState::new(self.facts.clone(), self.now, next));
        }
        let oldest = self.now.saturating_sub(REMEMBERED);
        if let Some(next) = self.timeline.forget_before(oldest).map(LiveState::next) {
            self.timeline.source_mut().forget_before(next);
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
        let mut was = vec![(Moment::ZERO, text_of(&session.facts))];
        for (event, wait_ms) in events.into_iter().filter(|(event, _)| Facts::takes(event)) {
            session.now += Moment::from_millis(wait_ms);
            session.take(&event);
            was.push((session.now, text_of(&session.facts)));
        }
        for place in places {
            let (at, was) = place.get(&was);
            session.timeline.seek(*at);
            prop_assert_eq!(&text_of(session.timeline.facts()), was);
        }
    }
}

/// Cached states go together with their events.
#[test]
fn cached_states_are_forgotten_with_their_events() {
    let mut reader = capture("house-clean.txt");
    let mut decoder = Decoder::default();
    let mut heard = Vec::new();
    while let Some(piece) = reader.next_piece() {
        if let Piece::Received(bytes) = piece {
            for received in decoder.lines(bytes) {
                if let Received::Line(line, raw) = received {
                    let line = Box::new(line);
                    heard.push(Event::Line { line, raw });
                }
            }
        }
    }
    let mut session = Session::new();
    let s = Moment::from_secs;
    session.now = s(1);
    for event in heard.iter().chain(&heard) {
        session.take(event);
    }
    let lines = session.facts.tally().lines;
    session.timeline.complete();
    session.timeline.seek(s(1));
    assert_eq!(session.timeline.line(), Some(lines));
    let next = session.timeline.source().count();
    session
        .timeline
        .keep(LiveState::new(session.facts.clone(), s(1), next));
    let oldest = session.timeline.forget_before(s(2)).map(LiveState::next);
    assert_eq!(oldest, Some(next));
    session.timeline.source_mut().forget_before(next);
    session.now = s(3);
    session.take(&heard[0]);
    session.timeline.seek(s(3));
    session.timeline.seek(s(1));
    assert_eq!(session.timeline.line(), Some(lines));
}

#[test]
fn a_live_session_of_hours_is_remembered_in_bounded_memory() {
    let mut robot = Robot::new(Config::default());
    let mut session = Session::new();
    for n in 0..40_000 {
        robot.state.x_tenths_in = n;
        session.now += Moment::from_millis(333);
        let level = if n % 10_000 == 9_000 {
            Level::Alarm
        } else {
            Level::Info
        };
        let notice = Notice::new(NoticeCode::Other, level, n.to_string());
        session.take(&Event::Notice(notice));
    }
    let from = session.timeline.oldest_at().unwrap();
    let back = session.now.saturating_sub(from);
    assert!(
        back >= REMEMBERED && back < REMEMBERED + SPACING * 2,
        "{back:?}"
    );
    session.timeline.seek(Moment::ZERO);
    assert!(session.timeline.at() <= from, "no farther than it goes");
    let last = session
        .timeline
        .find_last(Landmark::Alarm, session.now, STEPS_MAX);
    let alarm = Moment::from_millis(39_001 * 333);
    assert_eq!(last, Found::At(alarm));
    assert_eq!(
        session
            .timeline
            .find_next(Landmark::Alarm, alarm, STEPS_MAX),
        Found::Nowhere
    );
    assert_eq!(
        session
            .timeline
            .find_last(Landmark::Bump, session.now, STEPS_MAX),
        Found::Nowhere
    );
}

/// A peer on a fast network floods the station between two kept states.
#[test]
fn a_flood_is_remembered_in_bounded_memory() {
    let flood = 3 * BYTES_MAX / size_of::<Event>();
    let text = "x".repeat(70);
    let counters = |n| {
        Event::Counters(Counters {
            shape_rejected: n,
            ..Counters::default()
        })
    };
    let notice = |_| Event::Notice(Notice::new(NoticeCode::Other, Level::Info, text.as_str()));
    let kinds: [&dyn Fn(u64) -> Event; 2] = [&counters, &notice];
    for (kind, event) in kinds.into_iter().enumerate() {
        for step in [Moment::ZERO, Moment::from_nanos(1)] {
            let mut now = Moment::ZERO;
            let mut live = LivePlayer::new(Facts::new(Arc::default()), now, None);
            for n in 0..flood as u64 {
                now += step;
                live.take(now, &event(n));
            }
            let bytes = live.remembered_bytes();
            let place = format!("kind {kind}, a step of {step:?}: {bytes} bytes");
            assert!(bytes <= BYTES_MAX, "{place}");
            assert!(step.is_zero() || bytes >= BYTES_MAX / 2, "{place}");
            // The past can still be shown, and now as well.
            live.handle(now, Control::TogglePause);
            live.handle(now, Control::Seek(Position::Back(Moment::from_micros(1))));
            live.handle(now, Control::Newest);
            assert_eq!(
                text_of(live.shown(now).0),
                text_of(live.present()),
                "{place}"
            );
        }
    }
}

/// The whole screen.
fn screen(facts: &Facts, now: Moment) -> String {
    let ui = Ui::new(Arc::default());
    let shown = Shown {
        facts,
        present: facts,
        ui: &ui,
    };
    let mut terminal = Terminal::new(TestBackend::new(120, 40)).unwrap();
    terminal
        .draw(|frame| view::draw(shown, now, frame.buffer_mut()))
        .unwrap();
    terminal.backend().to_string()
}

/// The facts as text, without the plotted airtime and the last digits of the newest value: the airtime depends on how bytes arrive, and a recording has
/// only the time of each line.
fn known(facts: &Facts) -> String {
    const AIRTIME: &str = "airtime_down_pct: Some(";
    let mut facts = facts.clone();
    facts.plots.forget_airtime();
    let told = text_of(&facts);
    let mut known = String::new();
    let mut rest = &*told;
    while let Some((before, after)) = rest.split_once(AIRTIME) {
        let end = after.find(')').unwrap();
        let percent = after[..end].trim().trim_end_matches(',');
        let percent: f64 = percent.parse().unwrap();
        write!(known, "{before}{AIRTIME}{percent:.0}").unwrap();
        rest = &after[end..];
    }
    known + rest
}

/// A small generator of random numbers.
struct Rng(u64);

impl Rng {
    fn below(&mut self, end: usize) -> usize {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % end
    }
}

/// A listening station, the memory of its session, and its recording.
struct Listening {
    station: Station,
    session: Session,
    writer: SessionWriter<Vec<u8>>,
}

impl Listening {
    const START_NS: u64 = 1_741_944_413_000_000_000;

    fn new() -> Self {
        let about = About {
            link: "radio".to_owned(),
            start: std::time::UNIX_EPOCH + Moment::from_nanos(Self::START_NS),
            notes: std::collections::BTreeMap::new(),
            configuration: String::new(),
        };
        let mut listening = Self {
            station: Station::new(groundwave_protocol::arq::Config::new(1), false),
            session: Session::new(),
            writer: SessionWriter::new(Vec::new(), &about).unwrap(),
        };
        listening.station.handle_link(
            Moment::ZERO,
            LinkEvent::Opened {
                name: "radio".to_owned(),
                can_send: false,
            },
        );
        listening.listen();
        listening
    }

    fn at_ns(&self) -> u64 {
        Self::START_NS + self.session.now.as_nanos() as u64
    }

    fn tell(&mut self, event: &Event) {
        if let Some(event) = recorded::to_recorded(self.session.now, event) {
            self.writer.handle_event(self.at_ns(), &event).unwrap();
        }
        self.session.take(event);
    }

    fn listen(&mut self) {
        while let Some(event) = self.station.poll_event() {
            self.tell(&event);
        }
    }

    /// Runs every timeout until a moment.
    fn pass_to(&mut self, at: Moment) {
        loop {
            let timeouts = [
                self.station.poll_timeout(),
                self.session.facts.poll_timeout(),
            ];
            let due = timeouts.into_iter().flatten().min();
            let Some(due) = due.filter(|due| *due < at) else {
                break;
            };
            self.session.now = due.max(self.session.now);
            self.station.handle_timeout(self.session.now);
            self.listen();
            self.session.take(&Event::Tick);
        }
        self.session.now = at;
    }

    fn hear(&mut self, bytes: &[u8]) {
        self.writer.handle_rx(self.at_ns(), bytes).unwrap();
        self.station.handle_bytes(self.session.now, bytes);
        self.listen();
    }
}

/// A byte stream received live in random chunks, its replayed recording and the past of the live session agree: the same
/// facts, to the last counter, and the same screen at every moment when a line or noise
/// has ended.
#[test]
fn a_live_run_in_any_chunks_and_its_replay_are_the_same_to_the_last_character() {
    for name in CAPTURES {
        for seed in 1..4 {
            let mut rng = Rng(seed);
            let mut live = Listening::new();
            let mut was = Vec::new();
            let mut reader = capture(name);
            let mut from = Moment::ZERO;
            while let Some(at) = reader.next_at() {
                match reader.next_piece().unwrap() {
                    Piece::Received(bytes) => {
                        // Like a port: in random pieces, complete by the end of the line.
                        let mut rest = bytes;
                        while !rest.is_empty() {
                            let cut = 1 + rng.below(rest.len());
                            let left = (rest.len() - cut) as u32;
                            let early = at.saturating_sub(from) * left / bytes.len() as u32;
                            let then = at.saturating_sub(early);
                            live.pass_to(then.max(live.session.now));
                            live.hear(&rest[..cut]);
                            rest = &rest[cut..];
                        }
                        let ends_here = bytes.ends_with(b"\n");
                        if ends_here && rng.below(20) == 0 {
                            let facts = &live.session.facts;
                            was.push((at, known(facts), screen(facts, at), facts.tally().lines));
                        }
                        from = at;
                    }
                    Piece::Sent(bytes) => {
                        live.pass_to(at);
                        live.station.handle_sent(at, bytes);
                        live.writer.handle_tx(live.at_ns(), bytes).unwrap();
                        live.listen();
                    }
                    Piece::Event(event) => match from_recorded(at, &event) {
                        None | Some(Event::Link(_)) => {}
                        Some(event) => {
                            live.pass_to(at);
                            live.tell(&event);
                        }
                    },
                    other => panic!("{other:?}"),
                }
            }
            assert!(was.len() > 5, "{name}");
            let mcap = live.writer.finish().unwrap();
            let reader = index::read(Arc::new(mcap), Path::new("a.mcap")).unwrap();
            let (mut replay, _) = read_whole(reader);
            for (at, facts, drawn, lines) in was {
                let place = format!("{name}, seed {seed}, at {at:?}");
                live.session.timeline.seek(at);
                replay.seek(at);
                for (which, shown) in [
                    ("PAST", live.session.timeline.facts()),
                    ("replay", replay.facts()),
                ] {
                    assert_eq!(shown.tally().lines, lines, "{which}: {place}");
                    assert_eq!(screen(shown, at), drawn, "{which}: {place}");
                    assert!(
                        known(shown) == facts,
                        "{which}: {place}\n{}\n{facts}",
                        known(shown)
                    );
                }
            }
        }
    }
}

#[test]
fn failed_search_leaves_the_session_at_its_newest_moment() {
    let mut session = Session::new();
    for sequence in 0..10 {
        session.now += Moment::from_millis(333);
        let text = format!("line {sequence}");
        let notice = Notice::new(NoticeCode::Other, Level::Info, text);
        session.take(&Event::Notice(notice));
    }
    let now = session.now + Moment::from_secs(1);
    let mut player = Player::of_session(session.timeline, None);
    let jump = |to, forward| Control::Jump {
        to: Some(to),
        forward,
    };
    let seek = Control::Seek;
    for (control, note) in [
        (jump(Landmark::Alarm, true), "there are no later alarms"),
        (jump(Landmark::Bump, false), "there are no earlier bumps"),
        (seek(Position::Line(99_999)), "there is no line 99999"),
        (
            seek(Position::Ahead(now)),
            "the present is the newest moment",
        ),
        (Control::Step { forward: true }, "this is the last line"),
    ] {
        player.set_span(Moment::ZERO, now);
        assert!(!player.leave_newest(now, control), "{control:?}");
        assert!(player.is_at_end(), "{control:?}");
        assert_eq!(said(player.playback()), note);
    }
    for control in [
        seek(Position::Back(Moment::from_secs(1))),
        seek(Position::At(Moment::from_secs(2))),
    ] {
        player.set_span(Moment::ZERO, now);
        assert!(player.leave_newest(now, control), "{control:?}");
        assert!(!player.is_at_end(), "{control:?}");
    }
}
