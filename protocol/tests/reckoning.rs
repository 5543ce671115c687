//! Tests which lines count as lost and as damaged.

use groundwave_protocol::decoder::{Counters, Decoder, Lost, Received};
use groundwave_protocol::telemetry::{
    Ack, AckLine, Body, CountersLine, Detail, Line, StateLine, TextLine,
};
use proptest::prelude::*;

/// A robot that sends a line C, then eleven others, in turn.
pub struct Robot {
    pub id: u8,
    pub boot: u8,
    /// Time of the robot's clock, in byte times at 2400 baud.
    pub clock: u64,
    pub sent: u64,
    pub sent_long: u64,
    /// Number of frames heard; each is acknowledged by a short line.
    pub heard: u16,
    /// Pause after each line, in byte times; negative for a robot that is faster than 2400 baud.
    pub idle: i64,
    /// Whether every third line shows the era of the session in place of the robot's id, as SPEC.md asks.
    pub shows_era: bool,
    /// Whether a list is under way, so that only lines B and C show the robot's id.
    pub takes_list: bool,
}

impl Robot {
    pub const fn new(id: u8) -> Self {
        Self {
            id,
            boot: 3,
            clock: 240 * 100,
            sent: 0,
            sent_long: 0,
            heard: 0,
            idle: 0,
            shows_era: false,
            takes_list: false,
        }
    }

    fn ack(&self) -> Ack {
        let detail = if self.takes_list || self.shows_era && self.sent % 3 == 1 {
            Detail::Era { era: 5 }
        } else {
            Detail::Idle {
                owner: 0,
                robot_id: self.id,
            }
        };
        Ack {
            boot: self.boot,
            detail,
            ..Ack::default()
        }
    }

    pub fn next(&mut self) -> Vec<u8> {
        let body = match self.sent_long % 12 {
            0 => Body::Counters(CountersLine {
                robot_id: self.id,
                uptime_s: (self.clock / 240) as u32,
                boots: self.boot.into(),
                frames_heard: self.heard,
                ..CountersLine::default()
            }),
            6 => Body::Text(TextLine::new("here")),
            _ => Body::State(StateLine::BLANK),
        };
        let line = Line {
            sequence: (self.sent % 100) as u8,
            body,
            ack: self.ack(),
        };
        self.sent += 1;
        self.sent_long += 1;
        self.clock = (self.clock + 80).saturating_add_signed(self.idle);
        line.encode().to_vec()
    }

    pub fn next_short(&mut self) -> Vec<u8> {
        let line = AckLine {
            sequence: (self.sent % 100) as u8,
            ack: self.ack(),
            listens: false,
        };
        self.sent += 1;
        self.heard += 1;
        self.clock += 14;
        line.encode().to_vec()
    }

    /// The bytes of a number of lines.
    pub fn lines(&mut self, count: u64) -> Vec<u8> {
        (0..count).flat_map(|_| self.next()).collect()
    }
}

/// Draws numbers by the generator `SplitMix64`.
pub struct Draws(pub u64);

impl Draws {
    /// A number below 100.
    pub const fn per_cent(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        (mixed ^ (mixed >> 31)) % 100
    }
}

pub fn hear(decoder: &mut Decoder, mut bytes: &[u8]) -> Vec<Received> {
    std::iter::from_fn(|| decoder.next_own_line(&mut bytes)).collect()
}

pub fn exactly(lines: u64) -> Lost {
    Lost::between(lines, lines)
}

/// Hears the robot's next line at the time at which it ends.
pub fn hear_next(decoder: &mut Decoder, robot: &mut Robot) {
    decoder.set_time(robot.clock * 1000 / 240);
    hear(decoder, &robot.next());
}

/// The counts if `missed` of the lines between two parts of a stream do not arrive.
fn after_a_gap(robot: &mut Robot, missed: u64) -> Counters {
    let mut decoder = Decoder::default();
    hear(&mut decoder, &robot.lines(120));
    robot.lines(missed);
    hear(&mut decoder, &robot.lines(40));
    *decoder.counters()
}

#[test]
fn an_outage_of_a_hundred_lines_and_more_is_counted_in_full() {
    for missed in [0, 1, 65, 93, 94, 97, 99, 100, 101, 165, 200, 734] {
        let counters = after_a_gap(&mut Robot::new(7), missed);
        assert_eq!(counters.lost(), exactly(missed), "{missed}");
    }
}

#[test]
fn a_long_gap_without_times_is_open_until_the_robots_clock_shows_its_lines() {
    for missed in [9, 65, 93, 165, 734] {
        let mut robot = Robot::new(7);
        let mut decoder = Decoder::default();
        hear(&mut decoder, &robot.lines(121));
        robot.lines(missed);
        let mut said = Vec::new();
        for _ in 0..40 {
            hear(&mut decoder, &robot.next());
            said.push(decoder.counters().lost());
        }
        assert_eq!(said[0].known_max(), None, "{missed}");
        assert_eq!(said[0].min, missed % 100, "{missed}");
        assert_eq!(said[39], exactly(missed));
        // A clock with the pause shows the number at once.
        let mut robot = Robot::new(7);
        let mut decoder = Decoder::default();
        for n in 0..122 {
            if n == 121 {
                robot.lines(missed);
            }
            hear_next(&mut decoder, &mut robot);
        }
        assert_eq!(decoder.counters().lost().known_max(), Some(missed));
    }
}

/// Lines that a bridge delivers every five seconds were in the air before.
#[test]
fn lines_delivered_together_are_no_sign_of_a_missing_pause() {
    for missed in [0, 8, 20] {
        let mut robot = Robot::new(7);
        let mut decoder = Decoder::default();
        for n in 0..240 {
            if n == 200 {
                robot.lines(missed);
            }
            let sent_ms = robot.clock * 1000 / 240;
            decoder.set_time(sent_ms.next_multiple_of(5000));
            hear(&mut decoder, &robot.next());
            assert_eq!(decoder.counters().unclocked_gaps, 0, "{missed} {n}");
        }
        assert_eq!(decoder.counters().lost(), exactly(missed));
    }
}

/// The rate is not known at the first lines: a robot may be fast, and bytes that waited in the port come at once.
#[test]
fn first_lines_are_no_sign_of_a_missing_pause() {
    for (line_ms, pause_ms) in [(21, 9 * 21), (50, 9 * 50), (83, 9 * 83), (0, 333)] {
        let mut robot = Robot::new(7);
        let mut decoder = Decoder::default();
        for n in 0..5 {
            decoder.set_time(n * line_ms);
            hear(&mut decoder, &robot.next());
        }
        robot.lines(9);
        decoder.set_time(5 * line_ms + pause_ms);
        hear(&mut decoder, &robot.next());
        assert_eq!(decoder.counters().lost(), exactly(9), "{line_ms} ms");
    }
}

#[test]
fn a_slower_robot_is_measured_by_its_own_clock() {
    let mut robot = Robot::new(7);
    robot.idle = 160;
    assert_eq!(after_a_gap(&mut robot, 165).lost(), exactly(165));
}

/// Not one part between two lines C may be without loss: the parts with lost lines tell how fast the robot sends, too.
#[test]
fn a_lossy_link_at_any_rate_is_measured_by_the_robots_clock() {
    for (lines_per_s, idle) in [(1, 160), (2, 40), (3, 0), (5, -32), (10, -56), (20, -68)] {
        for lost_pct in [10, 40, 60, 80] {
            for seed in 0..8 {
                let mut robot = Robot {
                    idle,
                    ..Robot::new(7)
                };
                let mut decoder = Decoder::default();
                let mut draws = Draws(seed);
                let (mut missed, mut pending) = (0, 0);
                for n in 0..2000 {
                    let line = robot.next();
                    // The hundreds before the first line C are unknown.
                    let is_lost = (900..1230).contains(&n) || draws.per_cent() < lost_pct;
                    if is_lost && n > 0 {
                        pending += 1;
                    } else {
                        hear(&mut decoder, &line);
                        missed += std::mem::take(&mut pending);
                    }
                }
                // The hundreds are known at a line C.
                for _ in 0..13 {
                    let line = robot.next();
                    hear(&mut decoder, &line);
                    missed += std::mem::take(&mut pending);
                }
                let lost = decoder.counters().lost();
                let told = format!(
                    "{lines_per_s} lines a second, {lost_pct} %, seed {seed}: {missed} lost, told {lost:?}"
                );
                assert!(lost.min <= missed && missed <= lost.max, "{told}");
                // Most of it is not doubtful unless hardly a line arrives.
                assert!(lost_pct == 80 || lost.max - lost.min <= 200, "{told}");
            }
        }
    }
}

#[test]
fn an_outage_with_short_lines_around_it_is_an_interval() {
    let mut robot = Robot::new(7);
    let mut decoder = Decoder::default();
    let mixed = |robot: &mut Robot, count: u64| -> Vec<u8> {
        let part = |robot: &mut Robot| {
            let long = robot.next();
            [
                long,
                robot.next_short(),
                robot.next_short(),
                robot.next_short(),
            ]
            .concat()
        };
        (0..count).flat_map(|_| part(robot)).collect()
    };
    hear(&mut decoder, &mixed(&mut robot, 60));
    let before = robot.sent;
    robot.lines(165);
    let missed = robot.sent - before;
    hear(&mut decoder, &mixed(&mut robot, 30));
    let lost = decoder.counters().lost();
    assert!(lost.min < lost.max && lost.max <= missed + 300, "{lost:?}");
    assert!((lost.min..=lost.max).contains(&missed), "{lost:?}");
    assert_eq!(lost.min % 100, 65);
}

/// The robot acknowledged commands while it was not heard, so that more lines fit into the time.
#[test]
fn an_outage_with_short_lines_in_it_is_an_interval() {
    for (rounds, short) in [(40, 1), (40, 3), (60, 2), (90, 1), (20, 3)] {
        let mut robot = Robot::new(7);
        let mut decoder = Decoder::default();
        hear(&mut decoder, &robot.lines(121));
        let before = robot.sent;
        for _ in 0..rounds {
            robot.next();
            (0..short).for_each(|_| drop(robot.next_short()));
        }
        let missed = robot.sent - before;
        hear(&mut decoder, &robot.lines(30));
        let lost = decoder.counters().lost();
        assert!(
            (lost.min..=lost.max).contains(&missed),
            "{missed} of {rounds} times {short}: {lost:?}"
        );
    }
}

#[test]
fn damaged_lines_are_not_lost_and_are_counted_by_type() {
    let mut robot = Robot::new(7);
    let mut decoder = Decoder::default();
    for n in 0..240 {
        let mut line = robot.next();
        if n % 12 == 6 {
            line[30] ^= 2;
        }
        if n == 100 {
            line.remove(50);
        }
        if n == 124 {
            line[79] = b'x';
        }
        hear(&mut decoder, &line);
    }
    let counters = decoder.counters();
    assert_eq!(counters.lost(), exactly(0));
    assert_eq!(counters.lines_lost, 22, "by the sequence alone");
    let damaged = counters.damaged;
    let of = |letter| {
        damaged
            .by_type()
            .find(|(it, _)| *it == letter)
            .map(|it| it.1)
    };
    assert_eq!((of('T'), of('A'), of('?')), (Some(20), Some(0), Some(2)));
    assert_eq!(damaged.total(), 22);
}

#[test]
fn the_first_line_after_a_silence_is_counted_at_once() {
    for heard_before in 20..26 {
        let mut robot = Robot {
            shows_era: true,
            ..Robot::new(7)
        };
        let mut decoder = Decoder::default();
        for _ in 0..heard_before {
            hear_next(&mut decoder, &mut robot);
        }
        robot.lines(65);
        hear_next(&mut decoder, &mut robot);
        assert_eq!(decoder.counters().lost(), exactly(65), "{heard_before}");
    }
}

/// Lines since a boot are certainly lost, and the uptime limits the hundreds among them.
#[test]
fn lines_between_a_boot_and_the_first_line_heard_are_lost() {
    for (missed, boot) in [(0, 4), (1, 4), (57, 4), (157, 4), (57, 3)] {
        let (mut before, mut after) = (Robot::new(7), Robot::new(7));
        (after.boot, after.clock) = (boot, 0);
        let mut decoder = Decoder::default();
        hear(&mut decoder, &before.lines(50));
        after.lines(missed);
        hear(&mut decoder, &after.lines(40));
        let counters = decoder.counters();
        let (lost, case) = (counters.lost(), (missed, boot));
        assert_eq!(counters.restarts, 1, "{case:?}");
        assert_eq!(lost.min, missed % 100, "{case:?}");
        assert!(
            lost.max >= missed && lost.max <= missed + 100,
            "{lost:?} {case:?}"
        );
        if missed < 100 {
            assert!(lost.max < 100, "{lost:?} {case:?}");
        }
    }
}

/// Until the robot's next line C, the ground's clock gives the number of lines that may have been lost in a silence.
#[test]
fn a_silence_may_hide_hundreds_until_the_robots_clock_shows_them() {
    for missed in [20, 93, 94, 98, 99, 100, 165, 199, 520] {
        let mut robot = Robot::new(7);
        let mut decoder = Decoder::default();
        let mut said = Vec::new();
        for n in 0..200 {
            if n == 121 {
                robot.lines(missed);
            }
            hear_next(&mut decoder, &mut robot);
            said.push(decoder.counters().lost());
        }
        // The same sequence again could also be the same line.
        let least = if missed % 100 == 99 { 0 } else { missed % 100 };
        let then = Lost::between(least, missed);
        assert_eq!((said[120], said[121]), (exactly(0), then), "{missed}");
        assert_eq!(said[199], exactly(missed));
        // Missing bytes make the count uncertain until the end.
        let mut decoder = Decoder::default();
        let mut robot = Robot::new(7);
        for n in 0..40 {
            if n == 21 {
                robot.lines(missed);
            }
            hear_next(&mut decoder, &mut robot);
            if n == 22 {
                decoder.skip();
            }
        }
        let lost = decoder.counters().lost();
        assert!(
            lost.min <= missed && lost.max == missed,
            "{missed} {lost:?}"
        );
    }
}

/// The silence limits the number of lines sent before a boot in it.
#[test]
fn lines_before_a_boot_in_a_silence_are_unknown() {
    // The same boot counter modulo 8 shows the boot only in line C.
    for (silent_s, boot) in [(3600, 4), (60, 4), (60, 3), (12, 4)] {
        let mut robot = Robot::new(7);
        let mut decoder = Decoder::default();
        for _ in 0..60 {
            hear_next(&mut decoder, &mut robot);
        }
        let heard_until = robot.clock;
        let mut after = Robot {
            boot,
            clock: 0,
            ..Robot::new(7)
        };
        after.lines(30);
        // The ground's clock goes on through the boot.
        let zero = heard_until + silent_s * 240 - after.clock;
        let mut ranges = Vec::new();
        for _ in 0..40 {
            decoder.set_time((zero + after.clock) * 1000 / 240);
            hear(&mut decoder, &after.next());
            ranges.push(decoder.counters().lost());
        }
        let (counters, case) = (decoder.counters(), (silent_s, boot));
        assert_eq!(counters.restarts, 1, "{case:?}");
        let lost = counters.lost();
        assert_eq!((lost.min, lost.is_open), (30, false), "{case:?}");
        let sent = silent_s * 3;
        assert!(
            (sent..sent + sent / 5 + 15).contains(&lost.max),
            "{case:?}: {lost:?}"
        );
        if boot == 4 {
            assert!(ranges.iter().all(|it| it.max == lost.max), "{ranges:?}");
        }
    }
}

/// A robot that boots at once has lost nothing; in a pause, it may have sent a few lines before the boot.
#[test]
fn the_pause_before_a_boot_limits_the_lines_lost_in_it() {
    // The same boot counter modulo 8 shows the boot only in line C.
    for (pause, boot, max) in [(0, 4, 0), (40, 4, 0), (240, 4, 3), (240, 3, 3)] {
        let mut robot = Robot::new(7);
        let mut decoder = Decoder::default();
        for _ in 0..60 {
            hear_next(&mut decoder, &mut robot);
        }
        let zero = robot.clock + pause;
        let mut after = Robot {
            boot,
            clock: 0,
            ..Robot::new(7)
        };
        for _ in 0..40 {
            decoder.set_time((zero + after.clock) * 1000 / 240);
            hear(&mut decoder, &after.next());
        }
        let lost = decoder.counters().lost();
        assert_eq!(lost, Lost::between(0, max), "{pause} {boot}");
    }
}

/// The robot's own lines are neither damaged nor noise of damaged lines.
#[test]
fn lines_of_the_robots_own_are_no_damaged_ones() {
    let mut robot = Robot::new(7);
    let mut decoder = Decoder::default();
    for n in 0..100 {
        let own = format!("battery=12.{n} x=4.5\r\n\r\n");
        hear(&mut decoder, &robot.next());
        let before = decoder.counters().damaged;
        hear(&mut decoder, own.as_bytes());
        decoder.disown(own.len(), before);
        if n % 10 == 0 {
            robot.next();
        }
    }
    let counters = decoder.counters();
    assert_eq!(
        (counters.damaged.total(), counters.lost()),
        (0, exactly(10))
    );
}

proptest! {
    /// Lines that arrive damaged are never lost, whichever bits are wrong, including those of their line ends.
    #[test]
    fn damaged_lines_are_never_lost(
        errors in prop::collection::vec((0_u64..300, 0_usize..80, 0_u8..8), 1..40),
        ends in prop::collection::vec((0_u64..300, 78_usize..80, 0_u8..8), 0..20),
    ) {
        let mut robot = Robot::new(7);
        let mut decoder = Decoder::default();
        let mut damaged = std::collections::BTreeSet::new();
        for n in 0..320 {
            let mut line = robot.next();
            for (_, byte, bit) in errors.iter().chain(&ends).filter(|(of, ..)| *of == n) {
                line[*byte] ^= 1 << bit;
                damaged.insert(n);
            }
            hear(&mut decoder, &line);
        }
        let damaged = damaged.range(1..).count() as u64;
        let counters = decoder.counters();
        prop_assert_eq!(counters.lost(), exactly(0));
        let told = counters.damaged.total();
        prop_assert!(told.abs_diff(damaged) <= 1 + damaged / 20, "{told} of {damaged}");
    }

    /// Whichever lines are missed, the true number is within the interval, and without short lines the number is exact.
    #[test]
    fn the_true_number_is_in_the_interval(
        gaps in prop::collection::vec((10_u64..200, 0_u64..400), 1..8),
        idle in 0_i64..100,
    ) {
        let mut robot = Robot { idle, ..Robot::new(7) };
        let mut decoder = Decoder::default();
        hear(&mut decoder, &robot.lines(40));
        let mut missed = 0;
        for (heard, lost) in gaps {
            robot.lines(lost);
            missed += lost;
            hear(&mut decoder, &robot.lines(heard));
        }
        hear(&mut decoder, &robot.lines(13));
        let lost = decoder.counters().lost();
        prop_assert!(lost.min <= missed && missed <= lost.max, "{missed} {lost:?}");
        prop_assert!(lost.max - lost.min <= 200, "{missed} {lost:?}");
    }
}

/// The lines of the first 20 s come faster than the robot sent them: they had waited. That says nothing of the robot's rate, and so of hundreds
/// of lost lines.
#[test]
fn lines_that_waited_before_the_first_one_was_read_hide_no_hundreds() {
    for (speed, missed, at) in (2..9_u64).flat_map(|speed| {
        [1, 3, 8, 20]
            .into_iter()
            .flat_map(move |missed| [14, 26, 37, 50].map(|at| (speed, missed, at)))
    }) {
        let mut robot = Robot::new(7);
        let mut decoder = Decoder::default();
        let begin = robot.clock;
        let waited = |clock: u64| clock.min(begin + 60 * 80);
        for n in 0..240 {
            let line = robot.next();
            if (at..at + missed).contains(&n) {
                continue;
            }
            let late = (waited(begin + 60 * 80) - waited(robot.clock)) / speed;
            decoder.set_time((robot.clock.max(begin + 60 * 80) - late) * 1000 / 240);
            hear(&mut decoder, &line);
        }
        let lost = decoder.counters().lost();
        assert!(
            lost.min <= missed && lost.max == missed,
            "{speed} times as fast, {missed} missed at {at}: {lost:?}"
        );
    }
}
