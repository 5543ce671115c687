//! Outages in constructed sessions.

use groundwave_protocol::decoder::Decoder;
use groundwave_protocol::telemetry::{Ack, Body, CountersLine, Line, StateLine, TextLine};

use super::*;
use crate::chunk::{counters_until, set_time};

/// A robot that sends three lines per second; every twelfth is a line C.
struct Robot {
    sent: u64,
    boots: u16,
    /// Time at which the robot booted, milliseconds.
    since_ms: u64,
}

impl Robot {
    const fn new() -> Self {
        Self {
            sent: 0,
            boots: 4,
            since_ms: 0,
        }
    }

    fn line(&mut self, at_ms: u64) -> [u8; 80] {
        let body = match self.sent % 12 {
            0 => Body::Counters(CountersLine {
                robot_id: 7,
                uptime_s: ((at_ms - self.since_ms) / 1000) as u32,
                boots: self.boots,
                ..CountersLine::default()
            }),
            6 => Body::Text(TextLine::new("here")),
            _ => Body::State(StateLine::BLANK),
        };
        let line = Line {
            sequence: (self.sent % 100) as u8,
            body,
            ack: Ack {
                boot: (self.boots % 8) as u8,
                ..Ack::default()
            },
        };
        self.sent += 1;
        line.encode()
    }
}

/// Fate of the lines from a time on, in seconds.
#[derive(Clone, Copy)]
enum Fate {
    Arrive,
    Silence,
    Noise,
    Unplug,
    Suspend,
    Reboot,
}

/// The outages of a session of three minutes, found live.
fn session(fates: &[(u64, Fate)]) -> Vec<Outage> {
    let (mut robot, mut decoder, mut outages) =
        (Robot::new(), Decoder::default(), Outages::default());
    let (mut fate, mut asleep_since, mut found) = (Fate::Arrive, None, Vec::new());
    for n in 0..540_u64 {
        let at_ms = n * 1000 / 3;
        let now = Moment::from_millis(at_ms);
        for (_, next) in fates.iter().filter(|(at_s, _)| at_s * 3 == n) {
            fate = *next;
            match fate {
                Fate::Unplug => {
                    decoder.interrupt();
                    outages.handle_unplugged(now);
                }
                Fate::Suspend => asleep_since = Some(now),
                Fate::Reboot => {
                    robot = Robot {
                        sent: 0,
                        boots: robot.boots + 1,
                        since_ms: at_ms,
                    };
                    fate = Fate::Arrive;
                }
                Fate::Arrive | Fate::Silence | Fate::Noise => {}
            }
        }
        let line = robot.line(at_ms);
        let mut bytes: &[u8] = match fate {
            Fate::Arrive => &line,
            Fate::Noise => &[b'~'; 80],
            _ => &[],
        };
        if asleep_since.is_some() && !matches!(fate, Fate::Arrive) {
            continue;
        }
        if let Some(since) = asleep_since.take() {
            outages.handle_suspension(since);
        }
        set_time(&mut decoder, now);
        while let Some(received) = decoder.next_own_line(&mut bytes) {
            outages.handle_line(now, &received, decoder.counters());
        }
        outages.handle_timeout(now, decoder.counters());
        found.extend(std::iter::from_fn(|| outages.poll()));
    }
    let end = Moment::from_mins(3);
    outages.finish(end, &counters_until(&decoder, end));
    found.extend(std::iter::from_fn(|| outages.poll()));
    found
}

/// The outages that ended: cause, seconds from and to, lines lost.
fn ended(fates: &[(u64, Fate)]) -> Vec<(OutageCause, u64, u64, u64)> {
    let found = session(fates).into_iter().filter(|it| it.end.is_some());
    let found = found.filter_map(|outage| {
        let min = outage.lost.min;
        // What the robot sent before its boot is unknown.
        let is_exact = outage.lost.known_max() == Some(min);
        assert!(
            is_exact || outage.cause == OutageCause::Rebooted,
            "{outage}"
        );
        Some((
            outage.cause,
            outage.begin.as_secs(),
            outage.end?.as_secs(),
            min,
        ))
    });
    found.collect()
}

#[test]
fn each_outage_has_its_cause_its_times_and_its_lines() {
    for (fate, cause, begin_s) in [
        (Fate::Silence, OutageCause::Silent, 59),
        (Fate::Noise, OutageCause::Damaged, 59),
        (Fate::Unplug, OutageCause::Unplugged, 60),
        (Fate::Suspend, OutageCause::Suspended, 59),
    ] {
        let found = ended(&[(60, fate), (115, Fate::Arrive)]);
        assert_eq!(found, [(cause, begin_s, 115, 165)]);
    }
}

/// The first line after an outage had begun before it: the second one shows how many lines were lost.
#[test]
fn a_line_that_an_outage_interrupted_ends_it() {
    // A line A, and a line C, which settles earlier outages.
    for interrupted in [179, 180] {
        let (mut robot, mut decoder, mut list) =
            (Robot::new(), Decoder::default(), OutageList::default());
        for n in 0..300_u64 {
            let at_ms = n * 1000 / 3;
            let line = robot.line(at_ms);
            let delay_ms = if n == interrupted { 3000 } else { 0 };
            let now = Moment::from_millis(at_ms + delay_ms);
            let is_lost = (interrupted + 1..interrupted + 10).contains(&n);
            let mut bytes = if is_lost { &[] } else { &line[..] };
            set_time(&mut decoder, now);
            while let Some(received) = decoder.next_own_line(&mut bytes) {
                list.handle_line(now, &received, decoder.counters());
            }
        }
        let outages = list.into_outages(Moment::from_secs(100), decoder.counters());
        let lost: Vec<_> = outages.iter().map(|it| (it.cause, it.lost)).collect();
        assert_eq!(lost, [(OutageCause::Silent, Lost::between(9, 9))]);
    }
}

/// A recording has the lines that waited before the end of the suspension, and among them a line C.
#[test]
fn a_suspension_that_is_told_after_the_lines_that_waited_explains_the_silence() {
    for told_after in [0, 1, 14, 40] {
        let (mut robot, mut decoder, mut list) =
            (Robot::new(), Decoder::default(), OutageList::default());
        let woken = Moment::from_secs(115);
        for n in 0..540_u64 {
            let at_ms = n * 1000 / 3;
            let line = robot.line(at_ms);
            let is_waiting = (180..345).contains(&n);
            let now = if is_waiting {
                woken
            } else {
                Moment::from_millis(at_ms)
            };
            if n == 180 + told_after {
                let event = StationEvent::suspended(Moment::from_secs(55));
                list.handle_event(woken, &event);
            }
            let mut bytes = &line[..];
            while let Some(received) = decoder.next_own_line(&mut bytes) {
                list.handle_line(now, &received, decoder.counters());
            }
        }
        let [outage] = list.into_outages(Moment::from_mins(3), decoder.counters())[..] else {
            panic!("one");
        };
        let expected = Outage {
            cause: OutageCause::Suspended,
            begin: Moment::from_millis(59_666),
            end: Some(woken),
            lost: Lost::default(),
        };
        assert_eq!(outage, expected, "after {told_after} lines");
    }
}

#[test]
fn times_that_go_back_make_no_outage_longer() {
    let (mut robot, mut decoder, mut outages) =
        (Robot::new(), Decoder::default(), Outages::default());
    for at_s in [100, 103, 7, 8, 1, 90, 2] {
        if at_s == 7 {
            decoder.interrupt();
            outages.handle_unplugged(Moment::from_secs(6));
        }
        let now = Moment::from_secs(at_s);
        let line = robot.line(100_000);
        let mut bytes: &[u8] = &line;
        while let Some(received) = decoder.next_own_line(&mut bytes) {
            outages.handle_line(now, &received, decoder.counters());
        }
        outages.handle_timeout(now, decoder.counters());
    }
    outages.finish(Moment::from_secs(3), decoder.counters());
    let mut ended = 0;
    while let Some(outage) = outages.poll() {
        if let Some(end) = outage.end {
            assert!(outage.begin <= end, "{outage}");
            ended += 1;
        }
    }
    assert!(ended > 0, "one began when the link was lost");
}

#[test]
fn an_outage_is_reported_when_it_begins_and_when_its_lines_are_known() {
    let found = session(&[(60, Fate::Silence), (70, Fate::Arrive)]);
    let words: Vec<String> = found.iter().map(Outage::to_string).collect();
    assert_eq!(
        words,
        [
            "silent from 59.7 s on",
            "silent 10.3 s from 59.7 s: 30 lines lost"
        ]
    );
}

/// The outages of a stream in which a number of lines is lost, and the next line comes early or late by some milliseconds.
fn with_jitter(lost: u64, jitter_ms: i64) -> Vec<Outage> {
    let (mut robot, mut decoder, mut list) =
        (Robot::new(), Decoder::default(), OutageList::default());
    for n in 0..300_u64 {
        let at_ms = n * 1000 / 3;
        let line = robot.line(at_ms);
        if (100..100 + lost).contains(&n) {
            continue;
        }
        let late_ms = if n == 100 + lost { jitter_ms } else { 0 };
        let now = Moment::from_millis(at_ms.saturating_add_signed(late_ms));
        let mut bytes = &line[..];
        while let Some(received) = decoder.next_own_line(&mut bytes) {
            list.handle_line(now, &received, decoder.counters());
        }
    }
    list.into_outages(Moment::from_secs(100), decoder.counters())
}

#[test]
fn jitter_does_not_decide_whether_equal_gaps_are_outages() {
    for jitter_ms in [-100, -1, 0, 1, 100] {
        assert_eq!(with_jitter(5, jitter_ms), [], "{jitter_ms} ms");
        assert_eq!(with_jitter(6, jitter_ms).len(), 1, "{jitter_ms} ms");
    }
}

#[test]
fn each_reported_beginning_is_that_of_an_outage_that_ends() {
    use Fate::{Arrive, Noise, Reboot, Silence, Suspend, Unplug};
    for (fates, cause) in [
        (
            &[(60, Silence), (64, Unplug), (70, Arrive)][..],
            OutageCause::Unplugged,
        ),
        (
            &[(60, Silence), (64, Suspend), (70, Arrive)],
            OutageCause::Suspended,
        ),
        (&[(60, Suspend), (70, Arrive)], OutageCause::Suspended),
        (&[(60, Silence), (70, Reboot)], OutageCause::Rebooted),
        (&[(60, Noise), (70, Arrive)], OutageCause::Damaged),
        (&[(60, Unplug), (70, Reboot)], OutageCause::Unplugged),
    ] {
        let found = session(fates);
        let (begun, ended): (Vec<&Outage>, Vec<&Outage>) =
            found.iter().partition(|it| it.end.is_none());
        assert!(begun.len() <= 1, "{found:?}");
        assert_eq!(ended[0].cause, cause, "{found:?}");
        assert!(
            begun.iter().all(|it| it.begin == ended[0].begin),
            "{found:?}"
        );
    }
}

/// A station that wakes reports the silence at once, before the lines that waited and the suspension are known.
#[test]
fn a_reported_beginning_stays_also_if_the_silence_was_a_suspension() {
    for (is_told_first, is_explained_first) in
        [(true, true), (true, false), (false, true), (false, false)]
    {
        let (mut robot, mut decoder, mut outages) =
            (Robot::new(), Decoder::default(), Outages::default());
        let mut found = Vec::new();
        let since = Moment::from_millis(20_100);
        for n in 0..200_u64 {
            let at_ms = n * 1000 / 3;
            let now = Moment::from_millis(at_ms);
            let line = robot.line(at_ms);
            if (61..90).contains(&n) {
                continue;
            }
            if n == 90 {
                if is_told_first {
                    outages.handle_timeout(now, decoder.counters());
                }
                if is_explained_first {
                    outages.handle_suspension(since);
                    outages.handle_timeout(now, decoder.counters());
                }
            }
            let mut bytes = &line[..];
            while let Some(received) = decoder.next_own_line(&mut bytes) {
                outages.handle_line(now, &received, decoder.counters());
            }
            if n == 90 && !is_explained_first {
                outages.handle_suspension(since);
            }
            outages.handle_timeout(now, decoder.counters());
            found.extend(std::iter::from_fn(|| outages.poll()));
        }
        let case = (is_told_first, is_explained_first);
        let begin = Moment::from_secs(20);
        let ended: Vec<_> = found.iter().filter(|it| it.end.is_some()).collect();
        assert_eq!(ended.len(), 1, "{case:?} {found:?}");
        assert_eq!(ended[0].cause, OutageCause::Suspended, "{case:?}");
        assert!(
            found.iter().all(|it| it.begin == begin),
            "{case:?} {found:?}"
        );
    }
}

#[test]
fn an_outage_is_reported_as_begun_only_when_it_is_certain() {
    let (mut robot, mut decoder, mut outages) =
        (Robot::new(), Decoder::default(), Outages::default());
    for (line_ms, looks_ms) in [(1000, 3390), (3390, 5600)] {
        let now = Moment::from_millis(line_ms);
        let line = robot.line(line_ms);
        let mut bytes = &line[..];
        while let Some(received) = decoder.next_own_line(&mut bytes) {
            outages.handle_line(now, &received, decoder.counters());
        }
        outages.handle_timeout(Moment::from_millis(looks_ms), decoder.counters());
        assert_eq!(outages.poll(), None);
    }
    outages.handle_timeout(Moment::from_millis(5800), decoder.counters());
    assert_eq!(
        outages.poll().map(|it| it.begin),
        Some(Moment::from_millis(3390))
    );
}

#[test]
fn one_that_lasts_at_the_end_has_no_end() {
    for (fate, cause) in [
        (Fate::Silence, OutageCause::Silent),
        (Fate::Noise, OutageCause::Damaged),
        (Fate::Unplug, OutageCause::Unplugged),
    ] {
        let [begun, at_end] = session(&[(60, fate)])[..] else {
            panic!("{cause:?}");
        };
        assert_eq!((begun.cause, begun.end), (cause, None));
        assert_eq!(begun.lost.known_max(), None, "nothing is known yet");
        assert_eq!((at_end.cause, at_end.begin), (cause, begun.begin));
        assert_eq!((at_end.end, at_end.lost.min), (None, 0));
        // Three lines per second for two minutes.
        let max = at_end.lost.known_max().unwrap();
        assert!((360..=385).contains(&max), "{at_end}");
    }
}

#[test]
fn a_reboot_is_a_separate_outage_on_a_cable() {
    use OutageCause::{Rebooted, Unplugged};
    assert_eq!(ended(&[(60, Fate::Reboot)]), [(Rebooted, 59, 60, 0)]);
    let found = session(&[(60, Fate::Unplug), (70, Fate::Reboot)]);
    let ended: Vec<_> = found.iter().filter(|it| it.end.is_some()).collect();
    let causes: Vec<_> = ended.iter().map(|it| it.cause).collect();
    assert_eq!(causes, [Unplugged, Rebooted]);
    // The lines that the robot may have sent before it booted count once.
    let max = ended[0].lost.known_max().unwrap();
    assert!((30..=37).contains(&max), "{}", ended[0]);
    assert_eq!(ended[1].lost, Lost::default());
}

/// The outages in a capture without times, in which some lines are lost, and the lines C from the number `end` on.
fn without_times(lost: std::ops::Range<u64>, end: u64) -> Vec<Outage> {
    let (mut robot, mut decoder, mut list) =
        (Robot::new(), Decoder::default(), OutageList::default());
    let mut now = Moment::ZERO;
    for n in 0..600_u64 {
        let line = robot.line(n * 1000 / 3);
        if lost.contains(&n) || line[0] == b'C' && n >= end {
            continue;
        }
        now += Moment::from_millis(333);
        set_time(&mut decoder, now);
        let mut bytes = &line[..];
        while let Some(received) = decoder.next_own_line(&mut bytes) {
            list.handle_line(now, &received, decoder.counters());
        }
    }
    list.into_outages(now, decoder.counters())
}

#[test]
fn a_gap_that_only_the_robots_clock_shows_is_found() {
    let [outage] = without_times(200..400, u64::MAX)[..] else {
        panic!("one");
    };
    assert_eq!(
        (outage.cause, outage.lost.min, outage.lost.max),
        (OutageCause::Gap, 200, 200)
    );
}

#[test]
fn a_gap_without_times_is_where_the_sequence_shows_it_and_has_all_its_lines() {
    for first in 200..212 {
        let [outage] = without_times(first..first + 165, u64::MAX)[..] else {
            panic!("one");
        };
        let begin = Moment::from_millis(333 * first);
        assert_eq!((outage.cause, outage.begin), (OutageCause::Gap, begin));
        let words = format!("gap at {:.1} s: 165 lines lost", begin.as_secs_f64());
        assert_eq!(outage.to_string(), words);
    }
}

#[test]
fn lines_lost_in_a_gap_without_times_and_without_a_line_c_after_it_are_a_minimum() {
    for (lost, least) in [(165, 65), (265, 65), (80, 80), (9, 9)] {
        let [outage] = without_times(200..200 + lost, 200)[..] else {
            panic!("one");
        };
        // The lines C are missing, too.
        assert!(outage.lost.min >= least, "{outage}");
        assert_eq!(outage.lost.known_max(), None, "{outage}");
        assert!(outage.to_string().ends_with(" lines lost"), "{outage}");
        assert!(outage.to_string().contains(": at least "), "{outage}");
    }
}

#[test]
fn single_lines_lost_without_times_are_no_outage() {
    assert_eq!(without_times(200..203, 200), []);
}

/// The rest of a line that had begun before an outage ends the outage; the line after it would show the lines lost.
#[test]
fn an_outage_that_ends_with_the_last_line_is_an_interval() {
    let (mut robot, mut decoder, mut outages) =
        (Robot::new(), Decoder::default(), Outages::default());
    let mut now = Moment::ZERO;
    for n in 0..60 {
        now = Moment::from_millis(n * 1000 / 3 + if n == 59 { 20_000 } else { 0 });
        set_time(&mut decoder, now);
        let line = robot.line(n * 1000 / 3);
        let mut bytes = &line[..];
        while let Some(received) = decoder.next_own_line(&mut bytes) {
            outages.handle_line(now, &received, decoder.counters());
        }
    }
    let counters = counters_until(&decoder, now);
    outages.finish(now, &counters);
    let outage = outages.poll().unwrap();
    assert_eq!(outage.end, Some(now));
    assert_eq!(outage.lost, counters.lost());
    assert!(
        outage.lost.min == 0 && (59..80).contains(&outage.lost.max),
        "{outage}"
    );
}

/// In text without timestamps, other bytes than the robot's take up time.
#[test]
fn one_that_lasts_without_measured_times_is_open() {
    let (mut robot, mut decoder, mut outages) =
        (Robot::new(), Decoder::default(), Outages::default());
    for n in 0..30 {
        let line = robot.line(n * 1000 / 3);
        let mut bytes = &line[..];
        while let Some(received) = decoder.next_own_line(&mut bytes) {
            let now = Moment::from_millis(n * 1000 / 3);
            outages.handle_line(now, &received, decoder.counters());
        }
    }
    assert_eq!(decoder.next_own_line(&mut &[b'.'; 600][..]), None);
    let end = Moment::from_secs(30);
    let totals = counters_until(&decoder, end);
    outages.finish(end, &totals);
    let outage = outages.poll().unwrap();
    assert_eq!((outage.end, outage.lost.known_max()), (None, None));
    assert_eq!(totals.lost().known_max(), None);
}
