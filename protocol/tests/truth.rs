//! The number of lost lines against the truth: it lies between the numbers that the decoder gives.

use groundwave_protocol::decoder::Decoder;

use crate::reckoning::{Draws, Robot, exactly, hear};

/// A robot, what is heard of it, and how many of its lines were lost between the first and the latest heard one.
struct Radio {
    robot: Robot,
    decoder: Decoder,
    /// Time before the robot's latest boot, in byte times at 2400 baud.
    before_boot: u64,
    is_timed: bool,
    /// Number of lines lost since the latest heard one.
    pending: u64,
    lost: u64,
    has_heard: bool,
}

impl Radio {
    fn new(robot: Robot, is_timed: bool) -> Self {
        Self {
            robot,
            decoder: Decoder::default(),
            before_boot: 0,
            is_timed,
            pending: 0,
            lost: 0,
            has_heard: false,
        }
    }

    /// Sends a line; returns it.
    fn send(&mut self, is_heard: bool, is_short: bool) -> Vec<u8> {
        let line = if is_short {
            self.robot.next_short()
        } else {
            self.robot.next()
        };
        if is_heard {
            self.arrive(&line);
            self.lost += std::mem::take(&mut self.pending);
            self.has_heard = true;
        } else if self.has_heard {
            self.pending += 1;
        }
        line
    }

    /// Sends a number of long lines.
    fn send_all(&mut self, lines: u64, is_heard: bool) {
        for _ in 0..lines {
            self.send(is_heard, false);
        }
    }

    /// Sends a line that arrives with a wrong byte.
    fn damage(&mut self) {
        let mut line = self.robot.next();
        line[40] ^= 1;
        self.arrive(&line);
    }

    fn arrive(&mut self, line: &[u8]) {
        if self.is_timed {
            let time = self.before_boot + self.robot.clock;
            self.decoder.set_time(time * 1000 / 240);
        }
        hear(&mut self.decoder, line);
    }

    fn boot(&mut self, pause: u64) {
        self.before_boot += self.robot.clock + pause;
        self.robot.clock = 0;
        self.robot.boot = (self.robot.boot + 1) % 8;
        (self.robot.sent, self.robot.sent_long) = (0, 0);
    }
}

/// The mistake of one robot's figures, if there is one.
fn mistake(seed: u64) -> Option<String> {
    let mut draws = Draws(seed);
    let mut below = |end: u64| draws.per_cent() * end / 100;
    let is_timed = below(4) > 0;
    // 2400, 4800, 9600 and 19,200 baud.
    let speed = [1, 1, 2, 4, 8][below(5) as usize];
    let loss_pct = if is_timed {
        [0, 0, 10, 40][below(4) as usize]
    } else {
        0
    };
    let short_pct = if is_timed && speed == 1 {
        [0, 0, 30][below(3) as usize]
    } else {
        0
    };
    let has_boots = below(3) == 0;
    let robot = Robot {
        shows_era: below(2) == 0,
        sent: below(100),
        sent_long: below(12),
        idle: 80 / speed as i64 - 80,
        ..Robot::new(7)
    };
    let mut radio = Radio::new(robot, is_timed);
    for part in 0..4 {
        // The first part shows the rate.
        let heard = speed * (9 + below(30)) + 24 * u64::from(!is_timed || part > 0);
        for n in 0..heard {
            let is_whole = part == 0 && n < 6 * speed;
            let is_short = below(100) < short_pct;
            radio.send(is_whole || below(100) >= loss_pct, is_short);
        }
        let lost = [0, below(8), below(100), below(400)][below(4) as usize];
        let boots_after = below(lost + 1);
        for n in 0..lost {
            if has_boots && n == boots_after {
                radio.boot([0, 80, 400][below(3) as usize]);
            }
            radio.send(false, below(100) < short_pct);
        }
        if has_boots && is_timed && below(2) == 0 {
            // Too few lines for a line C, then another silence.
            radio.send_all(below(10) + 1, true);
            radio.send_all(below(300), false);
        }
    }
    radio.send_all(30, true);
    let told = radio.decoder.counters().lost();
    let max = told.known_max().unwrap_or(u64::MAX);
    let lost = radio.lost;
    (!(told.min..=max).contains(&lost)).then(|| {
        format!(
            "seed {seed}: {told:?}, but {lost} are lost; at {speed} times 2400 baud, timed {is_timed}, loss {loss_pct} %, short {short_pct} %, boots {has_boots}"
        )
    })
}

#[test]
fn the_true_loss_lies_in_the_interval() {
    let wrong: Vec<String> = (0..1000).filter_map(mistake).collect();
    assert!(wrong.is_empty(), "{} of 1000: {wrong:#?}", wrong.len());
}

/// A reboot that only the robot's clock shows leaves the hundreds of an earlier silence possible.
#[test]
fn a_silence_before_a_reboot_with_the_same_boot_number_keeps_its_hundreds() {
    let mut radio = Radio::new(Robot::new(7), true);
    let (boot, parts) = (radio.robot.boot, [(30, true), (106, false), (2, true)]);
    for (lines, is_heard) in parts {
        radio.send_all(lines, is_heard);
    }
    radio.boot(80);
    radio.robot.boot = boot;
    radio.send_all(3, true);
    let (told, lost) = (radio.decoder.counters().lost(), radio.lost);
    assert!(
        (told.min..=told.max).contains(&lost),
        "{told:?}, but {lost} are lost"
    );
}

/// Whether the counts contain the true loss.
fn contains_truth(radio: &Radio) -> bool {
    let told = radio.decoder.counters().lost();
    let max = told.known_max().unwrap_or(u64::MAX);
    (told.min..=max).contains(&radio.lost)
}

/// The first line of a text without timestamps after which the figure is wrong, if there is one.
fn mistake_without_times(seed: u64) -> Option<String> {
    let mut draws = Draws(seed);
    let mut below = |end: u64| draws.per_cent() * end / 100;
    // All lines show the id: a single line without it between two outages may be another robot's.
    let robot = Robot {
        sent: below(100),
        sent_long: below(12),
        ..Robot::new(7)
    };
    let mut radio = Radio::new(robot, false);
    let mut parts = Vec::new();
    for n in 0..=2 + below(3) {
        let heard = [1 + below(5), 1 + below(14), 20 + below(80)][below(3) as usize];
        let lost = [91 + below(3), 94 + below(5), 94 + below(14), below(12)][below(4) as usize];
        let lost = if n == 0 { 0 } else { lost + below(3) / 2 * 100 };
        // Whole hundreds leave no trace until the next line C.
        let lost = lost + u64::from(lost > 0 && lost % 100 == 0);
        parts.push((lost, heard));
        radio.send_all(lost, false);
        for line in 0..heard {
            radio.send(true, false);
            let told = radio.decoder.counters().lost();
            let is_decided = line > 24 && parts[0].1 > 12;
            if !contains_truth(&radio) || told.is_open && is_decided {
                let line = line + 1;
                return Some(format!(
                    "seed {seed}: {told:?}, but {} are lost; at line {line} of the last part, parts {parts:?}",
                    radio.lost
                ));
            }
        }
    }
    None
}

#[test]
fn the_true_loss_of_a_text_without_timestamps_lies_in_the_interval() {
    let wrong: Vec<String> = (0..2000).filter_map(mistake_without_times).collect();
    assert!(wrong.is_empty(), "{} of 2000: {wrong:#?}", wrong.len());
}

/// The first line after a line C after which the figure is wrong, if there is one, of a robot that booted eight times in an outage and goes on with a sequence near
/// the one before.
fn mistake_after_eight_boots(seed: u64) -> Option<String> {
    let mut draws = Draws(seed);
    let mut below = |end: u64| draws.per_cent() * end / 100;
    let mut radio = Radio::new(Robot::new(7), true);
    let (heard, lost_before) = (20 + below(80), below(60));
    radio.send_all(heard, true);
    radio.send_all(lost_before, false);
    for _ in 0..8 {
        radio.boot(80 + below(400));
        radio.send_all(below(9), false);
    }
    let near = (heard + below(12)).saturating_sub(6);
    while radio.robot.sent < near {
        radio.send(false, false);
    }
    for line in 1..=40 {
        radio.send(true, false);
        // Line C shows the boots.
        if line > 12 && !contains_truth(&radio) {
            let (told, lost) = (radio.decoder.counters().lost(), radio.lost);
            return Some(format!(
                "seed {seed}: {told:?}, but {lost} are lost; {heard} heard before, {lost_before} lost before the boots, sequence {near}, line {line}"
            ));
        }
    }
    None
}

#[test]
fn the_true_loss_lies_in_the_interval_after_eight_boots() {
    let wrong: Vec<String> = (0..1000).filter_map(mistake_after_eight_boots).collect();
    assert!(wrong.is_empty(), "{} of 1000: {wrong:#?}", wrong.len());
}

/// A gap that the clock forbids is not counted as lost, so a late line in it is not subtracted.
#[test]
fn a_late_line_in_a_doubted_gap_takes_nothing_from_the_count() {
    let robot = Robot {
        sent: 97,
        sent_long: 3,
        ..Robot::new(7)
    };
    let mut radio = Radio::new(robot, true);
    radio.send_all(12, true);
    assert_eq!(radio.robot.sent % 100, 9);
    // A second later, the sequence is 02, and then 01.
    radio.robot.clock += 160;
    radio.robot.sent += 93;
    radio.send(true, false);
    radio.robot.sent -= 2;
    radio.send(true, false);
    let told = radio.decoder.counters().lost();
    assert!(told.min == 0 && told.max < 100, "{told:?}");
}

/// The mistake of the figures after a long outage in which some lines arrive damaged, if there is one. Damaged lines are not lost.
fn mistake_with_damaged_lines(seed: u64) -> Option<String> {
    let mut draws = Draws(seed);
    let mut below = |end: u64| draws.per_cent() * end / 100;
    let is_timed = below(2) == 0;
    let robot = Robot {
        sent: below(100),
        sent_long: below(12),
        ..Robot::new(7)
    };
    let mut radio = Radio::new(robot, is_timed);
    radio.send_all(30, true);
    let sent = 90 + below(25) + below(2) * 100;
    let damaged: Vec<u64> = (0..=below(3)).map(|_| below(sent)).collect();
    for n in 0..sent {
        if damaged.contains(&n) {
            radio.damage();
        } else {
            radio.send(false, false);
        }
    }
    radio.send_all(30, true);
    let (told, lost) = (radio.decoder.counters().lost(), radio.lost);
    let is_wide = told.known_max().is_none_or(|max| max > told.min + 3);
    (!contains_truth(&radio) || is_wide).then(|| {
        format!(
            "seed {seed}: {told:?}, but {lost} are lost; {sent} sent, damaged {damaged:?}, timed {is_timed}"
        )
    })
}

#[test]
fn the_true_loss_lies_in_the_interval_after_damaged_lines_in_a_long_outage() {
    let wrong: Vec<String> = (0..2000).filter_map(mistake_with_damaged_lines).collect();
    assert!(wrong.is_empty(), "{} of 2000: {wrong:#?}", wrong.len());
}

/// The mistake of the figures after a long outage with a repeated line before or after it, if there is one; the ground's clock shows that the repeated line
/// follows no outage.
fn mistake_with_a_repeated_line(seed: u64) -> Option<String> {
    let mut draws = Draws(seed);
    let mut below = |end: u64| draws.per_cent() * end / 100;
    let robot = Robot {
        sent: below(100),
        sent_long: below(12),
        ..Robot::new(7)
    };
    let mut radio = Radio::new(robot, true);
    let (before, sent, behind) = (30 + below(12), 90 + below(125), below(6) as usize);
    let is_after = below(2) == 0;
    let mut heard: Vec<_> = (0..before).map(|_| radio.send(true, false)).collect();
    if !is_after {
        radio.arrive(&heard[heard.len() - 1 - behind]);
    }
    radio.send_all(sent, false);
    heard.clear();
    for n in 0..30 {
        heard.push(radio.send(true, false));
        if is_after && n == behind + 1 {
            radio.arrive(&heard[1]);
        }
    }
    let told = radio.decoder.counters().lost();
    (told != exactly(radio.lost)).then(|| {
        format!(
            "seed {seed}: {told:?}, but {} are lost; {sent} sent, {behind} behind, after {is_after}",
            radio.lost
        )
    })
}

#[test]
fn a_repeated_line_beside_a_long_outage_is_not_counted() {
    let wrong: Vec<String> = (0..2000).filter_map(mistake_with_a_repeated_line).collect();
    assert!(wrong.is_empty(), "{} of 2000: {wrong:#?}", wrong.len());
}
