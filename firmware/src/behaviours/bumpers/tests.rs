use super::*;
use crate::odometry::Odometer;
use crate::sensors::Ranges;

const LEFT: Switches = Switches {
    left: true,
    center: false,
    right: false,
};
const CENTER: Switches = Switches {
    left: false,
    center: true,
    right: false,
};
const RIGHT: Switches = Switches {
    left: false,
    center: false,
    right: true,
};
const FREE: Switches = Switches {
    left: false,
    center: false,
    right: false,
};

/// A robot whose wheels follow commands at once.
struct Bench {
    bumpers: Bumpers,
    odometer: Odometer,
    latest: Motion,
    now_ticks: u32,
    random: u32,
    is_held: bool,
    sonar: Ranges,
}

impl Bench {
    fn new() -> Self {
        Self {
            bumpers: Bumpers::default(),
            odometer: Odometer::default(),
            latest: Motion::STILL,
            now_ticks: 0,
            random: 0,
            is_held: false,
            sonar: Ranges::default(),
        }
    }

    fn tick(&mut self, bumper: Switches) -> Request {
        let (left, right) = self.latest.wheels();
        let (left, right) = (left / 20, right / 20);
        self.odometer.advance(left, right);
        self.now_ticks += 1;
        let request = self.bumpers.decide(&Senses {
            now_ticks: self.now_ticks,
            pose: self.odometer.pose(),
            path_counts: left + right,
            bumper,
            random: self.random,
            is_held: self.is_held,
            sonar: self.sonar,
            ..Senses::idle()
        });
        self.latest = request.motion;
        request
    }

    /// One tick of contact, then none until the manoeuvre ends. Returns the change of heading in degrees, right positive,
    /// and the distance ahead in inches.
    fn bump(&mut self, bumper: Switches) -> (i32, i32) {
        let before = self.odometer.pose();
        self.tick(bumper);
        let mut path_counts = 0;
        for _ in 0..200 {
            let (left, right) = self.latest.wheels();
            path_counts += i32::from((left + right) / 20);
            if !self.tick(FREE).flag {
                let turned = self.odometer.pose().heading.minus(before.heading);
                return (i32::from(turned) * 360 / 65_536, path_counts / 32);
            }
        }
        panic!("the manoeuvre does not end within 200 ticks");
    }

    /// Drives ahead without contact until earlier contacts are forgotten.
    fn drive_on(&mut self, ticks: u32) {
        for _ in 0..ticks {
            assert!(!self.tick(FREE).flag);
            self.latest = Motion::new(12, 0);
        }
    }
}

#[test]
fn no_contact_is_no_request() {
    let mut bench = Bench::new();
    assert_eq!(bench.tick(FREE), Request::QUIET);
}

#[test]
fn contact_backs_up_and_turns_away_from_its_side() {
    for random in [0, 0x0001_0000, 0xFFFF_FFFF] {
        for (switches, away) in [(LEFT, 1), (RIGHT, -1)] {
            let mut bench = Bench::new();
            bench.random = random;
            let (turned_deg, way_in) = bench.bump(switches);
            assert!((-8..=-5).contains(&way_in), "{way_in} in");
            let turned_deg = turned_deg * away;
            assert!((0..=45).contains(&turned_deg), "{turned_deg} degrees");
        }
    }
}

#[test]
fn edge_of_an_opening_turns_the_robot_a_little_toward_the_open_side() {
    let (open, near) = (Some(90), Some(3));
    let left_corner = Switches {
        left: true,
        ..CENTER
    };
    for (switches, left_in, right_in, away) in [
        (CENTER, near, open, 1),
        (CENTER, open, near, -1),
        (left_corner, open, open, 1),
    ] {
        let mut bench = Bench::new();
        bench.sonar = Ranges { left_in, right_in };
        let (turned_deg, _) = bench.bump(switches);
        let turned_deg = turned_deg * away;
        assert!((0..=45).contains(&turned_deg), "{turned_deg} degrees");
    }
    let mut bench = Bench::new();
    bench.sonar = Ranges {
        left_in: near,
        right_in: near,
    };
    assert!(bench.bump(CENTER).0.abs() >= 60);
}

#[test]
fn held_wheels_count_as_a_frontal_contact() {
    for (random, side) in [(0, 1), (1, -1)] {
        let mut bench = Bench::new();
        bench.random = random;
        bench.is_held = true;
        assert_eq!(bench.tick(FREE).motion, BACK);
        bench.is_held = false;
        let (turned_deg, way_in) = bench.bump(FREE);
        assert!((-8..=-5).contains(&way_in), "{way_in} in");
        assert!((80..180).contains(&(turned_deg * side)), "{turned_deg}");
    }
}

#[test]
fn held_wheels_do_not_change_a_running_manoeuvre() {
    let mut bench = Bench::new();
    bench.tick(LEFT);
    bench.is_held = true;
    while bench.tick(FREE).motion == BACK {}
    assert!(bench.latest.rotation_cps > 0);
    // After its end it starts again.
    while bench.tick(FREE).motion != BACK {}
}

#[test]
fn glancing_contact_turns_less_than_a_frontal_one() {
    let left_and_center = Switches {
        center: true,
        ..LEFT
    };
    for random in [0, 0x0010_0000, 0x003F_FF00] {
        let [glancing_deg, frontal_deg] = [LEFT, left_and_center].map(|switches| {
            let mut bench = Bench::new();
            bench.random = random;
            bench.bump(switches).0
        });
        assert!(
            glancing_deg < 45 && frontal_deg > 65,
            "{random:x}: {glancing_deg} {frontal_deg}"
        );
    }
}

#[test]
fn robot_comes_to_rest_after_the_turn() {
    let mut bench = Bench::new();
    bench.tick(CENTER);
    let mut still_ticks = 0;
    loop {
        let request = bench.tick(FREE);
        if !request.flag {
            break;
        }
        still_ticks = if request.motion == Motion::STILL {
            still_ticks + 1
        } else {
            0
        };
    }
    assert_eq!(still_ticks, u32::from(SETTLE_TICKS));
}

#[test]
fn side_of_a_centre_contact_is_random() {
    let turned = [0, 1].map(|random| {
        let mut bench = Bench::new();
        bench.random = random;
        bench.bump(CENTER).0
    });
    assert!(turned[0] > 0 && turned[1] < 0, "{turned:?}");
}

#[test]
fn backing_ignores_contacts_and_turning_restarts_on_one() {
    let mut bench = Bench::new();
    bench.tick(LEFT);
    // Contacts while backing change nothing.
    for switches in [FREE, RIGHT, FREE, CENTER, FREE] {
        assert_eq!(bench.tick(switches).motion, BACK);
    }
    while bench.tick(FREE).motion == BACK {}
    assert!(bench.latest.rotation_cps > 0);
    assert_eq!(bench.tick(RIGHT).motion, BACK);
    while bench.tick(FREE).motion == BACK {}
    assert!(bench.latest.rotation_cps < 0);
}

#[test]
fn blocked_backing_times_out_and_turns() {
    let mut bench = Bench::new();
    bench.tick(LEFT);
    let mut ticks = 1;
    loop {
        // The wheels stand.
        bench.latest = Motion::STILL;
        if bench.tick(FREE).motion != BACK {
            break;
        }
        ticks += 1;
    }
    assert_eq!(ticks, u32::from(BACK_TICKS));
    // A blocked turn times out too.
    for _ in 0..u32::from(u8::MAX) {
        bench.latest = Motion::STILL;
        if !bench.tick(FREE).flag {
            return;
        }
    }
    panic!("the turn does not end");
}

#[test]
fn alternating_contacts_in_a_corner_turn_half_around() {
    for [a, b] in [[RIGHT, LEFT], [LEFT, RIGHT]] {
        let mut bench = Bench::new();
        for switches in [a, b, a] {
            assert!(bench.bump(switches).0.abs() < 100);
        }
        assert!(bench.bump(b).0.abs() > 150);
        // The contacts before the escape are forgotten.
        assert!(bench.bump(a).0.abs() < 100);
    }
}

#[test]
fn slow_zigzag_is_not_a_corner() {
    let mut bench = Bench::new();
    for switches in [RIGHT, LEFT, RIGHT] {
        bench.bump(switches);
        bench.drive_on(110);
    }
    assert!(bench.bump(LEFT).0.abs() < 100);
}

#[test]
fn fifth_bump_without_progress_turns_half_around() {
    let mut bench = Bench::new();
    for bump in 0..4 {
        bench.random = bump & 1;
        assert!(bench.bump(CENTER).0.abs() < 100, "bump {bump}");
        // Ahead again, to about the same position.
        bench.drive_on(10);
    }
    assert!(bench.bump(CENTER).0.abs() > 150);
}

#[test]
fn bumps_with_progress_do_not_escape() {
    let mut bench = Bench::new();
    for bump in 0..8 {
        assert!(bench.bump(LEFT).0.abs() < 100, "bump {bump}");
        bench.drive_on(60);
    }
}

#[test]
fn switch_closed_for_three_seconds_starts_the_jam_sequence() {
    let mut bench = Bench::new();
    for tick in 1..u32::from(JAM_TICKS) {
        bench.tick(CENTER);
        assert!(!bench.bumpers.is_jammed(), "tick {tick}");
    }
    bench.tick(CENTER);
    assert!(bench.bumpers.is_jammed());
    let mut motions = std::vec::Vec::new();
    for _ in 0..400 {
        let request = bench.tick(CENTER);
        assert!(request.flag && bench.bumpers.is_jammed());
        if !motions.contains(&request.motion) {
            motions.push(request.motion);
        }
    }
    assert_eq!(motions.len(), JAM_SEQUENCE.len());
    bench.tick(FREE);
    assert!(!bench.bumpers.is_jammed());
    assert_eq!(bench.tick(FREE), Request::QUIET);
}

#[test]
fn rest_ends_a_manoeuvre() {
    let mut bench = Bench::new();
    bench.tick(LEFT);
    bench.bumpers.rest();
    assert_eq!(bench.tick(FREE), Request::QUIET);
}
