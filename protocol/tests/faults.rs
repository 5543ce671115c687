//! What command delivery does when stations, lists and robots come and go at the wrong moment.

mod world;

use groundwave_protocol::Waypoint;
use groundwave_protocol::arq::{Config, Fop, FopEvent, Loss, Task};
use groundwave_protocol::command::{Message, Order};
use groundwave_protocol::decoder::{Decoder, Received};
use groundwave_protocol::digest::digest;
use groundwave_protocol::letters::Mode;
use groundwave_protocol::receiver::Receiver;
use groundwave_protocol::telemetry::{Ack, Body, Detail, Line, Outcome};
use world::{DONE, ROBOT_ID, World, route, state};

fn replaced_by(list: &[Waypoint]) -> FopEvent {
    FopEvent::Concluded {
        outcome: Outcome::Done,
        digest: Some(digest(list.iter())),
    }
}

#[test]
fn a_station_that_starts_in_the_middle_of_another_ones_transfer_takes_over() {
    for seed in 0..50 {
        let mut world = World::new(seed, 0.0);
        assert!(world.fop.start(0, Task::List(&route(seed, 100))));
        while !matches!(world.robot.farm.ack().detail, Detail::Staging { .. }) {
            world.step();
            assert!(world.now_us < 10_000_000, "nothing staged, seed {seed}");
        }
        world.fop = Fop::new(Config::new(0x111));
        world.uplink.clear();
        let list = route(seed + 1000, 20);
        assert_eq!(
            world.deliver(Task::List(&list)),
            replaced_by(&list),
            "seed {seed}"
        );
        assert_eq!(world.robot.farm.lists().active(), list, "seed {seed}");
    }
}

#[test]
fn lists_go_on_arriving_after_the_list_was_cleared() {
    let mut world = World::new(1, 0.0);
    for round in 0..70 {
        let list = route(round, 1 + round as usize % 9);
        assert_eq!(
            world.deliver(Task::List(&list)),
            replaced_by(&list),
            "{round}"
        );
        if round % 17 == 16 {
            assert_eq!(world.deliver(Task::List(&[])), replaced_by(&[]), "{round}");
        }
    }
}

#[test]
fn a_list_that_never_gets_through_fails_though_everything_else_is_heard() {
    let mut world = World::new(2, 0.0);
    world.robot.deaf_to = |message| matches!(message, Message::Waypoints(_));
    let event = world.deliver(Task::List(&route(2, 10)));
    assert_eq!(event, FopEvent::Failed(Loss::TimedOut));
    assert_eq!(
        world.deliver(Task::Order(Order::Mode(Mode::Reactive))),
        DONE
    );
}

#[test]
fn a_list_that_cannot_be_sent_is_not_taken() {
    let mut fop = Fop::new(Config::new(1));
    assert!(!fop.start(0, Task::List(&route(1, 301))));
    let beyond = [Waypoint {
        x_in: 10_000,
        y_in: 0,
    }];
    assert!(!fop.start(0, Task::List(&beyond)));
    assert!(fop.start(0, Task::List(&route(1, 300))));
}

#[test]
fn nothing_but_stop_is_said_until_stop_is_proven() {
    for seed in 0..50 {
        let mut world = World::new(seed, if seed % 2 == 0 { 0.0 } else { 3e-3 });
        world.deliver(Task::Order(Order::Mode(Mode::Reactive)));
        world.fop.stop(world.now_us);
        assert!(
            world
                .fop
                .start(world.now_us, Task::Order(Order::Mode(Mode::Prowl)))
        );
        world.finish();
        let proven = world.events.iter().position(|e| *e == FopEvent::StopProven);
        let concluded = world.events.iter().rposition(|e| *e == DONE);
        assert!(proven.is_some() && proven < concluded, "seed {seed}");
        for _ in 0..240 * 3 {
            world.step();
        }
        assert_eq!(world.robot.mode, Mode::Prowl, "seed {seed}");
    }
}

/// A line A of a robot in stop, as the decoder hands it out.
fn stopped_line(sequence: u8) -> Received {
    let line = Line {
        sequence,
        body: Body::State(state(Mode::Stop)),
        ack: Ack {
            boot: 1,
            detail: Detail::Idle {
                owner: 0,
                robot_id: ROBOT_ID,
            },
            ..Ack::default()
        },
    };
    Received::Line(line, line.encode())
}

#[test]
fn a_line_composed_before_stop_was_off_does_not_prove_it() {
    let config = Config::new(1);
    let mut fop = Fop::new(config);
    fop.handle_received(0, &stopped_line(0));
    let pressed_us = 1_000_000;
    fop.stop(pressed_us);
    assert!(fop.poll_transmit(pressed_us).is_some());
    // STOP takes 7 bytes. A line takes 80, its fields are up to 50 ms old when it begins, and the
    // link may hold it back.
    let byte_us = 1_000_000 / 240;
    let proof_us = pressed_us + 87 * byte_us + 50_000 + config.latency_us;
    fop.handle_received(proof_us - 100, &stopped_line(1));
    assert_eq!(
        fop.poll_event(),
        None,
        "the line may be older than the STOP"
    );
    fop.handle_received(proof_us + 100, &stopped_line(2));
    assert_eq!(fop.poll_event(), Some(FopEvent::StopProven));
}

#[test]
fn hand_drive_ends_with_a_standstill() {
    let mut world = World::new(3, 0.0);
    world.deliver(Task::Order(Order::Mode(Mode::User)));
    world.fop.drive(world.now_us, 6, -4, world.now_us + 450_000);
    let key = world.robot.farm.key();
    let mut receiver = Receiver::default();
    let mut speeds = Vec::new();
    for _ in 0..240 * 2 {
        world.step();
        for &byte in &world.uplink {
            if let Some(Message::Drive(drive)) = receiver.handle_byte(byte, ROBOT_ID, key) {
                speeds.push((drive.velocity_in_s, drive.rotation_in_s));
            }
        }
        world.uplink.clear();
    }
    assert_eq!(speeds, [(6, -4), (6, -4), (6, -4), (0, 0)]);
}

#[test]
fn another_robots_lines_are_not_acted_on() {
    let mut fop = Fop::new(Config {
        robot_id: Some(ROBOT_ID + 1),
        ..Config::new(1)
    });
    assert!(fop.start(0, Task::Order(Order::Scan)));
    fop.handle_received(1_000_000, &stopped_line(0));
    let sent = fop.poll_transmit(1_000_000).map(<[u8]>::to_vec);
    assert_eq!(
        sent.as_deref(),
        Some(&b"\n"[..]),
        "a knock, for its own robot has not been heard"
    );
}

#[test]
fn a_decoder_names_the_robot_that_sent_a_line() {
    let mut decoder = Decoder::default();
    let Received::Line(_, bytes) = stopped_line(0) else {
        unreachable!()
    };
    let (_, received) = decoder.handle_bytes(&bytes);
    assert_eq!(received.and_then(|r| r.robot_id()), Some(ROBOT_ID));
}
