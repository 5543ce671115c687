//! Tests which lines are another robot's, and which robot is followed.

use groundwave_protocol::decoder::{Decoder, Received};

use crate::reckoning::{Draws, Robot, exactly, hear, hear_next};

#[test]
fn lines_of_another_robot_are_kept_apart_and_not_lost() {
    let (mut own, mut other) = (Robot::new(7), Robot::new(9));
    other.sent = 41;
    let mut decoder = Decoder::default();
    hear(&mut decoder, &own.lines(5));
    for _ in 0..300 {
        let heard = hear(&mut decoder, &[own.next(), other.next()].concat());
        assert_eq!(heard.len(), 1);
        assert_eq!(heard[0].robot_id(), Some(7));
    }
    let counters = decoder.counters();
    assert_eq!(counters.lost(), exactly(0));
    assert_eq!((counters.intact(), counters.other_lines), (305, 300));
    assert_eq!(counters.other_robots, [Some(9), None, None, None]);
    // Without times, the other robot alone is followed after 180 lines.
    assert_eq!(hear(&mut decoder, &other.lines(200)).len(), 22);
    let counters = decoder.counters();
    assert_eq!(
        (counters.robot, counters.replaced_robot),
        (Some(9), Some(7))
    );
    assert_eq!(counters.other_robots[0], Some(7));
    assert_eq!(counters.lost().known_max(), None);
}

/// Two robots with the same boot number. One is hardly heard, and a third of its lines show no id.
#[test]
fn single_lines_of_another_robot_of_the_same_boot_are_hardly_ever_lost_ones() {
    let mut taken = 0;
    for seed in 0..200 {
        let (mut own, mut other) = (Robot::new(7), Robot::new(9));
        own.shows_era = true;
        other.shows_era = true;
        other.sent = seed * 13 % 100;
        let heard_pct = [1, 3, 5, 10, 30, 60][seed as usize % 6];
        let mut draws = Draws(seed);
        let mut decoder = Decoder::default();
        hear(&mut decoder, &own.lines(3));
        for _ in 0..600 {
            hear(&mut decoder, &own.next());
            let line = other.next();
            if draws.per_cent() < heard_pct {
                hear(&mut decoder, &line);
            }
        }
        let lost = decoder.counters().lost();
        // One that fits exactly between the own lines is taken for one of them.
        assert!(lost.max < 20, "seed {seed}, {heard_pct} % heard: {lost:?}");
        taken += u32::from(lost != exactly(0));
    }
    assert!(taken <= 5, "{taken}");
}

/// Hears both robots for some lines each.
fn hear_both(decoder: &mut Decoder, own: &mut Robot, other: &mut Robot, lines: u64) {
    for _ in 0..lines {
        hear_next(decoder, own);
        hear_next(decoder, other);
    }
}

/// Hears only the other robot for some lines, while those of the followed one are lost.
fn hear_other(decoder: &mut Decoder, own: &mut Robot, other: &mut Robot, lines: u64) {
    own.lines(lines);
    for _ in 0..lines {
        hear_next(decoder, other);
    }
}

#[test]
fn a_robot_that_is_silent_for_less_than_a_minute_stays_the_followed_one() {
    for (silent, boot, shows_era) in [15, 21, 99, 150]
        .into_iter()
        .flat_map(|silent| [(3, false), (4, true)].map(|(boot, era)| (silent, boot, era)))
    {
        let mut own = Robot {
            shows_era,
            ..Robot::new(7)
        };
        let mut other = Robot {
            boot,
            sent: 41,
            shows_era,
            ..Robot::new(9)
        };
        let mut decoder = Decoder::default();
        hear_both(&mut decoder, &mut own, &mut other, 60);
        hear_other(&mut decoder, &mut own, &mut other, silent);
        hear_both(&mut decoder, &mut own, &mut other, 40);
        let (counters, case) = (decoder.counters(), (silent, boot));
        assert_eq!(counters.robot, Some(7), "{case:?}");
        assert_eq!(counters.lost(), exactly(silent), "{case:?}");
        assert_eq!(counters.intact(), 100, "{case:?}");
        assert_eq!(counters.other_lines, 100 + silent, "{case:?}");
        assert_eq!(counters.restarts, 0, "{case:?}");
    }
}

#[test]
fn a_robot_that_is_silent_for_a_minute_is_replaced_unless_it_is_held() {
    for (is_held, idle) in [(false, 0), (true, 0), (false, -60)] {
        let (mut own, mut other) = (Robot::new(7), Robot::new(9));
        let mut decoder = Decoder::default();
        decoder.hold_robot(is_held);
        hear_both(&mut decoder, &mut own, &mut other, 60);
        other.idle = idle;
        hear_other(&mut decoder, &mut own, &mut other, 200);
        let (counters, case) = (decoder.counters(), (is_held, idle));
        // 200 lines of a fast robot come in 17 s.
        let is_replaced = !is_held && idle == 0;
        let followed = if is_replaced { 9 } else { 7 };
        assert_eq!(counters.robot, Some(followed), "{case:?}");
        assert_eq!(counters.restarts, 0, "{case:?}");
        let lost = counters.lost();
        assert_eq!((lost.min, lost.is_open), (0, false), "{case:?}");
        // The replaced robot may have sent all the time.
        let is_counted = (175..210).contains(&lost.max);
        assert_eq!(is_counted, is_replaced, "{case:?}: {lost:?}");
    }
}

#[test]
fn several_other_robots_are_kept_apart() {
    let mut own = Robot::new(7);
    let mut others = [9, 11, 12].map(Robot::new);
    for (other, sent) in others.iter_mut().zip([41, 60, 80]) {
        other.sent = sent;
    }
    let mut decoder = Decoder::default();
    for _ in 0..150 {
        hear_next(&mut decoder, &mut own);
        for other in &mut others {
            hear_next(&mut decoder, other);
        }
    }
    let counters = decoder.counters();
    assert_eq!(counters.other_robots, [Some(9), Some(11), Some(12), None]);
    assert_eq!(counters.lost(), exactly(0));
    assert_eq!((counters.intact(), counters.other_lines), (150, 450));
}

/// Lines that show an era have no id, the first one of the other robot among them.
#[test]
fn another_robot_that_comes_later_loses_no_line_of_the_first() {
    for (before, sent, boot) in (10..16_u64)
        .flat_map(|before| (5..36).flat_map(move |sent| [3, 4].map(|boot| (before, sent, boot))))
    {
        // At the same boot, lines so near could be the followed robot's.
        if boot == 3 && (before.saturating_sub(6)..before + 10).contains(&sent) {
            continue;
        }
        let mut own = Robot {
            shows_era: true,
            ..Robot::new(7)
        };
        let mut other = Robot {
            sent,
            // The first lines are not C.
            sent_long: 1,
            boot,
            shows_era: true,
            ..Robot::new(9)
        };
        let mut decoder = Decoder::default();
        hear(&mut decoder, &own.lines(before));
        for _ in 0..60 {
            hear(&mut decoder, &[other.next(), own.next()].concat());
        }
        let (counters, case) = (decoder.counters(), (before, sent, boot));
        assert_eq!(
            (counters.lost(), counters.restarts),
            (exactly(0), 0),
            "{case:?}"
        );
        assert_eq!(counters.intact(), before + 60, "{case:?}");
        assert_eq!(counters.other_lines, 60, "{case:?}");
    }
}

/// Both robots are heard from the first line on; the first lines may show no id. The first id decides which robot is followed.
#[test]
fn robots_heard_from_the_first_line_lose_none() {
    let cases = (0..6_u64).flat_map(|start| {
        (0..100).flat_map(move |sent| [3, 4].map(move |boot| (start, sent, boot)))
    });
    for (start, sent, boot) in cases {
        // At the same boot, lines so near could be the first robot's.
        if boot == 3 && (sent + 10 - start) % 100 < 20 {
            continue;
        }
        let robot = |id, boot, sent| Robot {
            boot,
            sent,
            // The first lines are not C.
            sent_long: 1,
            shows_era: true,
            ..Robot::new(id)
        };
        let (mut one, mut other) = (robot(7, 3, start), robot(9, boot, sent));
        let mut decoder = Decoder::default();
        for _ in 0..60 {
            hear(&mut decoder, &[one.next(), other.next()].concat());
        }
        let (counters, case) = (decoder.counters(), (start, sent, boot));
        assert_eq!((counters.lost().min, counters.restarts), (0, 0), "{case:?}");
        assert!(counters.lost().max < 100, "{case:?}");
        assert!(counters.intact().abs_diff(60) <= 1, "{case:?}");
    }
}

fn long_line(received: &Received) -> Vec<u8> {
    match received {
        Received::Line(_, bytes) => bytes.to_vec(),
        Received::Ack(line) => panic!("{line:?}"),
    }
}

/// The other robot takes a list, so most of its lines show no id: they are no reboots of the followed robot, and are not returned as its lines.
#[test]
fn several_lines_without_an_id_are_no_reboot() {
    for (before, sent, both) in (20..32_u64).flat_map(|before| {
        (0..100)
            .step_by(7)
            .flat_map(move |sent| [1, 3].map(|both| (before, sent, both)))
    }) {
        let mut own = Robot {
            shows_era: true,
            ..Robot::new(7)
        };
        let mut other = Robot {
            boot: 4,
            sent,
            sent_long: 1 + sent % 11,
            takes_list: true,
            ..Robot::new(9)
        };
        let mut decoder = Decoder::default();
        let (mut heard, mut sent_own) = (Vec::new(), Vec::new());
        for n in 0..before + 60 {
            for _ in 0..if n < before { 0 } else { both } {
                heard.extend(hear(&mut decoder, &other.next()));
            }
            decoder.set_time(own.clock * 1000 / 240);
            let line = own.next();
            heard.extend(hear(&mut decoder, &line));
            sent_own.push(line);
        }
        let (counters, case) = (decoder.counters(), (before, sent, both));
        heard.extend(decoder.undecided_lines());
        let heard: Vec<Vec<u8>> = heard.iter().map(long_line).collect();
        assert!(heard == sent_own, "{case:?}: {} lines", heard.len());
        let lost = counters.lost();
        assert_eq!((lost, counters.restarts), (exactly(0), 0), "{case:?}");
        assert_eq!(counters.intact(), before + 60, "{case:?}");
        assert_eq!(counters.other_robots[0], Some(9), "{case:?}");
    }
}

/// A robot whose lines with an era show another boot: its lines are numbered through, so they are its own.
#[test]
fn a_wrong_boot_in_lines_without_an_id_makes_no_other_robot() {
    let mut robot = Robot {
        shows_era: true,
        ..Robot::new(7)
    };
    let mut decoder = Decoder::default();
    for _ in 0..90 {
        robot.boot = if robot.sent % 3 == 1 { 0 } else { 3 };
        hear(&mut decoder, &robot.next());
    }
    let counters = decoder.counters();
    assert_eq!((counters.intact(), counters.other_lines), (90, 0));
    assert!(counters.restarts > 50, "{}", counters.restarts);
}

/// A line without an id after a gap or a boot is counted when the next one comes.
#[test]
fn no_line_after_a_gap_or_boot_is_taken_for_another_robots() {
    for (heard_before, missed, boots) in (20..26).flat_map(|before| {
        [0, 1, 7, 20, 65]
            .into_iter()
            .flat_map(move |missed| [false, true].map(move |boots| (before, missed, boots)))
    }) {
        let mut robot = Robot {
            shows_era: true,
            ..Robot::new(7)
        };
        let mut decoder = Decoder::default();
        let mut heard = hear(&mut decoder, &robot.lines(heard_before));
        if boots {
            (robot.boot, robot.sent, robot.sent_long, robot.clock) = (4, 0, 1, 0);
        }
        robot.lines(missed);
        heard.extend(hear(&mut decoder, &robot.lines(40)));
        let (counters, case) = (decoder.counters(), (heard_before, missed, boots));
        let lost = counters.lost();
        assert_eq!((lost.min, lost.max), (missed, missed), "{case:?}");
        // Without times, the robot may have sent any number of lines before its boot.
        assert_eq!(lost.is_open, boots, "{case:?}");
        assert_eq!(counters.restarts, u64::from(boots), "{case:?}");
        assert_eq!(counters.other_lines, 0, "{case:?}");
        let sequences: Vec<u64> = heard.iter().map(|it| u64::from(it.sequence())).collect();
        let first = if boots { 0 } else { heard_before };
        let expected = (0..heard_before).chain(first + missed..first + missed + 40);
        assert!(
            sequences.into_iter().eq(expected.map(|n| n % 100)),
            "{case:?}"
        );
    }
}

#[test]
fn a_robot_that_follows_another_one_has_not_restarted() {
    let (mut first, mut second) = (Robot::new(7), Robot::new(9));
    (second.boot, second.sent) = (5, 41);
    let mut decoder = Decoder::default();
    hear(&mut decoder, &first.lines(40));
    hear(&mut decoder, &second.lines(300));
    let counters = decoder.counters();
    assert_eq!((counters.restarts, counters.lost().min), (0, 0));
    assert_eq!(counters.intact() + counters.other_lines, 340);
    assert_eq!(counters.robot, Some(9));
}

/// A single line of another robot, whose id is not known, in a gap: its boot, or its sequence, is not between the lines before and after it.
#[test]
fn a_single_line_of_another_robot_in_a_gap_is_no_reboot_and_no_loss() {
    let cases = (0..40).flat_map(|missed| {
        let before = [3, 12, 100].into_iter();
        before.flat_map(move |before| {
            [(1, false), (3, false), (1, true), (3, true)].map(|it| (missed, before, it))
        })
    });
    for (missed, before, (boot, is_timed)) in cases {
        let mut robot = Robot::new(7);
        let mut other = Robot {
            boot,
            sent: before + 52,
            sent_long: 1,
            takes_list: true,
            ..Robot::new(9)
        };
        let mut decoder = Decoder::default();
        let mut heard = Vec::new();
        for n in 0..before + missed + 160 {
            let line = robot.next();
            if is_timed {
                decoder.set_time(robot.clock * 1000 / 240);
            }
            if n == before + missed {
                heard.extend(hear(&mut decoder, &other.next()));
            }
            if !(before..before + missed).contains(&n) {
                heard.extend(hear(&mut decoder, &line));
            }
        }
        let (counters, case) = (decoder.counters(), (missed, before, boot, is_timed));
        assert_eq!(counters.lost(), exactly(missed), "{case:?}");
        let all = before as usize + 160;
        assert_eq!((counters.restarts, heard.len()), (0, all), "{case:?}");
        let counted = (counters.intact(), counters.other_lines);
        assert_eq!(counted, (before + 160, 1), "{case:?}");
    }
}
