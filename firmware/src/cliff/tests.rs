use super::*;
use crate::parameters::Parameters;
use proptest::prelude::*;

const FLOOR: Edges = Edges {
    left: false,
    center: false,
    right: false,
    rear: false,
};

fn senses(cliff: Edges) -> Senses<'static> {
    Senses {
        cliff: Some(cliff),
        ..Senses::idle()
    }
}

fn edges(bits: u8) -> Edges {
    Edges {
        left: bits & 1 != 0,
        center: bits & 2 != 0,
        right: bits & 4 != 0,
        rear: bits & 8 != 0,
    }
}

/// The guard's commands tick by tick while the robot stands at the same edges.
fn reaction(cliff: Edges, wanted: Motion) -> impl Iterator<Item = Command> {
    let mut guard = CliffGuard::default();
    core::iter::from_fn(move || Some(guard.guard(&senses(cliff), Counts::default(), wanted, false)))
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
        (edges(1), [false, true, false, true]),
        (edges(2), [false, true, true, true]),
        (edges(4), [false, true, true, false]),
        (edges(8), [true, false, false, false]),
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
    for (cliff, sign) in [(edges(1), 1), (edges(4), -1)] {
        let mut guard = CliffGuard::default();
        let wanted = Motion::new(12, 0);
        assert_eq!(
            guard.guard(&senses(cliff), Counts::default(), wanted, false),
            Command::Brake
        );
        assert_eq!(guard.take_report(), Some(Missing::Ahead));
        let mut turned = 0;
        let mut seen = senses(cliff);
        for _ in 0..400 {
            let Command::Drive(motion) = guard.guard(&seen, Counts::default(), wanted, false)
            else {
                panic!("the guard brakes again");
            };
            if motion == wanted {
                break;
            }
            if motion.velocity_cps < 0 {
                // The robot rolls back from the edge.
                seen.path_counts = -8;
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
    let commands: [Option<Command>; 2] = {
        let mut commands = reaction(edges(8), Motion::new(-8, 0));
        [commands.next(), commands.next()]
    };
    assert_eq!(commands[0], Some(Command::Brake));
    assert_eq!(commands[1], Some(Command::Drive(Motion::new(5, 0))));
}

#[test]
fn manual_driving_is_stopped_but_not_moved() {
    let mut guard = CliffGuard::default();
    let ahead = Motion::new(8, 0);
    for tick in 0..100 {
        let command = guard.guard(&senses(edges(2)), Counts::default(), ahead, true);
        assert_eq!(command, Command::Brake, "tick {tick}");
        assert_eq!(guard.take_report().is_some(), tick == 0);
    }
    let back = Motion::new(-5, 0);
    for _ in 0..2 {
        guard.guard(&senses(edges(2)), Counts::default(), back, true);
    }
    let command = guard.guard(&senses(edges(2)), Counts::default(), back, true);
    assert_eq!(command, Command::Drive(back), "the operator may back off");
}

#[test]
fn lifted_robot_stands_until_put_down() {
    let mut guard = CliffGuard::default();
    let ahead = Motion::new(12, 0);
    let mut step = |bits, by_hand| {
        let command = guard.guard(&senses(edges(bits)), Counts::default(), ahead, by_hand);
        (command, guard.take_report())
    };
    assert_eq!(step(15, false), (Command::Brake, Some(Missing::Below)));
    for tick in 0..400 {
        assert_eq!(step(15, tick % 2 == 0), (Command::Brake, None));
    }
    for _ in 1..PUT_DOWN_TICKS {
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
            ..senses(edges(15))
        },
        Senses {
            cliff: None,
            ..senses(edges(15))
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
            (0_u8..16, -300_i16..300, -300_i16..300, -12_i16..12, -12_i16..12, any::<u32>(), any::<bool>(), any::<bool>()),
            1..200,
        ),
    ) {
        let mut guard = CliffGuard::default();
        for (bits, velocity_cps, rotation_cps, left, right, random, bumped, by_hand) in ticks {
            let mut seen = senses(edges(bits));
            seen.random = random;
            seen.bumper.center = bumped;
            seen.path_counts = left + right;
            seen.pose.heading.0 = random as u16;
            let wanted = Motion { velocity_cps, rotation_cps };
            let command = guard.guard(&seen, Counts { left, right }, wanted, by_hand);
            if let Command::Drive(motion) = command {
                let front = bits & 7 != 0;
                prop_assert!(!front || motion.velocity_cps <= 0, "{motion:?} with {bits:04b}");
                let rear = bits & 8 != 0;
                prop_assert!(!rear || motion.velocity_cps >= 0, "{motion:?} with {bits:04b}");
            }
        }
    }
}
