use super::*;
use crate::parameters::Parameters;
use proptest::prelude::*;

const FLOOR: Edges = Edges::NONE;

fn senses(cliff: Edges) -> Senses<'static> {
    Senses {
        cliff: Some(cliff),
        ..Senses::idle()
    }
}

/// The guard's commands tick by tick while the robot stands at the same edges.
fn reaction(cliff: Edges, wanted: Motion) -> impl Iterator<Item = Command> {
    let mut guard = CliffGuard::default();
    core::iter::from_fn(move || Some(guard.guard(&senses(cliff), Counts::default(), wanted, false)))
}

fn first_three(cliff: Edges, wanted: Motion) -> [Command; 3] {
    let mut commands = reaction(cliff, wanted);
    core::array::from_fn(|_| commands.next().expect("the reaction has no end"))
}

#[test]
fn complete_floor_passes_every_motion() {
    let mut guard = CliffGuard::default();
    for motion in [Motion::new(12, 0), Motion::new(-8, 4), Motion::new(0, 16)] {
        let command = guard.guard(&senses(FLOOR), Counts::default(), motion, false);
        assert_eq!(command, Command::Drive(motion));
        assert!(!guard.acts() && guard.take_report().is_none());
    }
}

#[test]
fn each_sensor_blocks_only_motions_toward_it() {
    let [ahead, back, right, left] = [
        Motion::new(6, 0),
        Motion::new(-6, 0),
        Motion::new(0, 6),
        Motion::new(0, -6),
    ];
    let cases = [
        (Edges::AHEAD_LEFT, [false, true, false, true]),
        (Edges::AHEAD, [false, true, true, true]),
        (Edges::AHEAD_RIGHT, [false, true, true, false]),
        (Edges::BESIDE_LEFT, [false, true, true, true]),
        (Edges::BEHIND, [true, false, true, true]),
        (Edges::BEHIND_LEFT, [true, false, false, false]),
        (Edges::BEHIND_RIGHT, [true, false, false, false]),
    ];
    for (cliff, allowed) in cases {
        for (motion, allowed) in [ahead, back, right, left].into_iter().zip(allowed) {
            let first = reaction(cliff, motion).next();
            assert_eq!(
                first == Some(Command::Drive(motion)),
                allowed,
                "{cliff:?} {motion:?}"
            );
            assert_eq!(first == Some(Command::Brake), !allowed);
        }
    }
}

#[test]
fn edge_ahead_leads_to_backing_and_a_turn_away() {
    for (cliff, sign) in [(Edges::AHEAD_LEFT, 1), (Edges::AHEAD_RIGHT, -1)] {
        let mut guard = CliffGuard::default();
        let wanted = Motion::new(12, 0);
        assert_eq!(
            guard.guard(&senses(cliff), Counts::default(), wanted, false),
            Command::Brake
        );
        assert_eq!(guard.take_report(), None, "one detection may be false");
        assert_eq!(
            guard.guard(&senses(cliff), Counts::default(), wanted, false),
            Command::Brake
        );
        assert_eq!(guard.take_report(), Some(Missing::Ahead));
        let mut turned = 0;
        let mut seen = senses(cliff);
        let mut counts = Counts::default();
        for _ in 0..400 {
            let Command::Drive(motion) = guard.guard(&seen, counts, wanted, false) else {
                panic!("the guard brakes again");
            };
            if motion == wanted {
                break;
            }
            if motion.velocity_cps < 0 {
                // The robot rolls back from the edge.
                seen.path_counts = -8;
                counts = Counts {
                    left: -4,
                    right: -4,
                };
                seen.cliff = Some(FLOOR);
            } else {
                assert_eq!(motion, Motion::new(0, TURN_IN_S * sign));
                seen.pose.heading.0 = seen.pose.heading.0.wrapping_add_signed(300 * sign);
                turned += 300;
            }
        }
        assert!((0x2AAB..0x5600).contains(&turned), "{turned}");
        assert!(!guard.acts());
    }
}

#[test]
fn edge_behind_leads_ahead_and_backing_is_slow() {
    let mut guard = CliffGuard::default();
    let command = guard.guard(
        &senses(FLOOR),
        Counts::default(),
        Motion::new(-12, 0),
        false,
    );
    assert_eq!(command, Command::Drive(Motion::new(-8, 0)));
    let commands = first_three(Edges::BEHIND, Motion::new(-8, 0));
    let ahead = Command::Drive(Motion::new(5, 0));
    assert_eq!(commands, [Command::Brake, Command::Brake, ahead]);
}

#[test]
fn false_detection_brakes_for_one_tick() {
    let mut guard = CliffGuard::default();
    let wanted = Motion::new(12, 0);
    let mut step = |cliff| guard.guard(&senses(cliff), Counts::default(), wanted, false);
    assert_eq!(step(Edges::AHEAD), Command::Brake);
    for _ in 0..20 {
        assert_eq!(step(FLOOR), Command::Drive(wanted));
    }
    assert!(guard.take_report().is_none() && !guard.acts());
}

#[test]
fn edge_that_every_other_tick_misses_is_confirmed() {
    let mut guard = CliffGuard::default();
    let mut step =
        |cliff| guard.guard(&senses(cliff), Counts::default(), Motion::new(12, 0), false);
    step(Edges::AHEAD);
    step(FLOOR);
    step(Edges::AHEAD);
    assert!(guard.acts() && guard.take_report() == Some(Missing::Ahead));
}

#[test]
fn edge_beside_the_robot_leads_to_backing_the_way_it_came() {
    for cliff in [Edges::BESIDE_LEFT, Edges::BESIDE_RIGHT] {
        let commands = first_three(cliff, Motion::new(12, 0));
        let back = Command::Drive(Motion::new(-5, 0));
        assert_eq!(commands, [Command::Brake, Command::Brake, back]);
    }
}

#[test]
fn arc_backward_that_leads_over_an_edge_beside_is_barred() {
    for (cliff, sign) in [(Edges::BESIDE_LEFT, 1), (Edges::BESIDE_RIGHT, -1)] {
        let first = |motion| reaction(cliff, motion).next();
        assert_eq!(first(Motion::new(-4, 4 * sign)), Some(Command::Brake));
        let away = Motion::new(-4, -4 * sign);
        assert_eq!(first(away), Some(Command::Drive(away)));
    }
}

#[test]
fn manual_driving_is_stopped_but_not_moved() {
    let mut guard = CliffGuard::default();
    let ahead = Motion::new(8, 0);
    for tick in 0..100 {
        let command = guard.guard(&senses(Edges::AHEAD), Counts::default(), ahead, true);
        assert_eq!(command, Command::Brake, "tick {tick}");
        assert_eq!(guard.take_report().is_some(), tick == 1);
    }
    let back = Motion::new(-5, 0);
    for _ in 0..2 {
        guard.guard(&senses(Edges::AHEAD), Counts::default(), back, true);
    }
    let command = guard.guard(&senses(Edges::AHEAD), Counts::default(), back, true);
    assert_eq!(command, Command::Drive(back), "the operator may back off");
}

#[test]
fn edge_that_its_sensor_loses_still_bars_a_robot_that_stands() {
    let (ahead, back) = (Motion::new(10, 0), Motion::new(-5, 0));
    let mut guard = CliffGuard::default();
    let mut step = |cliff, motion, count| {
        let counts = Counts {
            left: count,
            right: count,
        };
        guard.guard(&senses(cliff), counts, motion, true)
    };
    for _ in 0..3 {
        step(Edges::AHEAD_RIGHT, ahead, 0);
    }
    for tick in 0..KNOWN_TICKS - 10 {
        assert_eq!(step(FLOOR, ahead, 0), Command::Brake, "tick {tick}");
    }
    assert_eq!(step(FLOOR, back, 0), Command::Drive(back));
    step(FLOOR, back, -5);
    assert_eq!(step(FLOOR, ahead, 0), Command::Drive(ahead), "after moving");
}

#[test]
fn lifted_robot_stands_until_put_down() {
    let mut guard = CliffGuard::default();
    let ahead = Motion::new(12, 0);
    let mut step = |bits, by_hand| {
        let command = guard.guard(
            &senses(Edges::from_bits(bits)),
            Counts::default(),
            ahead,
            by_hand,
        );
        (command, guard.take_report())
    };
    assert_eq!(step(u8::MAX, false), (Command::Brake, None));
    assert_eq!(step(u8::MAX, false), (Command::Brake, Some(Missing::Below)));
    for tick in 0..400 {
        assert_eq!(step(u8::MAX, tick % 2 == 0), (Command::Brake, None));
    }
    let until_down = usize::from(PUT_DOWN_TICKS) - 1 + HELD_TICKS - usize::from(SURE_COUNT);
    for _ in 0..until_down {
        assert_eq!(step(0, false), (Command::Brake, None));
    }
    assert_eq!(step(0, false), (Command::Drive(ahead), None));
}

#[test]
fn guard_that_is_off_or_not_fitted_passes_every_motion() {
    let mut off = Parameters::DEFAULT;
    assert!(off.set(Parameter::CliffGuard, 0));
    let ahead = Motion::new(12, 0);
    for senses in [
        Senses {
            parameters: &off,
            ..senses(Edges::ALL)
        },
        Senses {
            cliff: None,
            ..senses(Edges::ALL)
        },
    ] {
        let command = CliffGuard::default().guard(&senses, Counts::default(), ahead, false);
        assert_eq!(command, Command::Drive(ahead));
    }
}

proptest! {
    /// With any edges, motions and history: no forward motion while a front sensor detects no floor, and no backward
    /// motion while the rear sensor does.
    #[test]
    fn commands_never_lead_over_an_edge(
        ticks in proptest::collection::vec(
            (any::<u8>(), -300_i16..300, -300_i16..300, -12_i16..12, -12_i16..12, any::<u32>(), any::<bool>(), any::<bool>()),
            1..200,
        ),
    ) {
        let mut guard = CliffGuard::default();
        for (bits, velocity_cps, rotation_cps, left, right, random, bumped, by_hand) in ticks {
            let mut seen = senses(Edges::from_bits(bits));
            seen.random = random;
            seen.bumper.center = bumped;
            seen.path_counts = left + right;
            seen.pose.heading.0 = random as u16;
            let wanted = Motion { velocity_cps, rotation_cps };
            let command = guard.guard(&seen, Counts { left, right }, wanted, by_hand);
            if let Command::Drive(motion) = command {
                let front = Edges::from_bits(bits).meets(Edges::FRONT);
                prop_assert!(!front || motion.velocity_cps <= 0, "{motion:?} with {bits:08b}");
                let rear = Edges::from_bits(bits).meets(Edges::REAR);
                prop_assert!(!rear || motion.velocity_cps >= 0, "{motion:?} with {bits:08b}");
            }
        }
    }
}
