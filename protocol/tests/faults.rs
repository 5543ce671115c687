//! Delivery while stations, lists and robots change at the wrong moment.

use crate::world::{DONE, ROBOT_ID, Robot, STOPPED, World, failed, replaced, route};
use groundwave_protocol::Waypoint;
use groundwave_protocol::arq::{CommandStatus, Config, Duplex, Failure, Fop, FopEvent, Task};
use groundwave_protocol::command::{Command, Key, Message, Open, Order};
use groundwave_protocol::decoder::{Decoder, Received};
use groundwave_protocol::digest::digest;
use groundwave_protocol::failsafe::Failsafe;
use groundwave_protocol::receiver::Receiver;
use groundwave_protocol::status_codes::{Link, Mode};
use groundwave_protocol::telemetry::{Ack, AckLine, Body, Detail, Line, StateLine};

fn replaced_by(list: &[Waypoint]) -> FopEvent {
    replaced(digest(list.iter()))
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
fn a_list_that_never_arrives_fails_while_other_frames_do() {
    let mut world = World::new(2, 0.0);
    world.robot.deaf_to = |message| matches!(message, Message::Waypoints(_));
    let event = world.deliver(Task::List(&route(2, 10)));
    assert_eq!(event, failed(Failure::TimedOut));
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
fn only_stop_is_sent_until_it_is_proven() {
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
        let confirmed = world.events.iter().position(|e| *e == STOPPED);
        let concluded = world.events.iter().rposition(|e| *e == DONE);
        assert!(confirmed.is_some() && confirmed < concluded, "seed {seed}");
        for _ in 0..240 * 3 {
            world.step();
        }
        assert_eq!(world.robot.mode, Mode::Prowl, "seed {seed}");
    }
}

/// A line A of a robot in mode stop, as received.
fn stopped_line(sequence: u8) -> Received {
    let line = Line {
        sequence,
        body: Body::State(StateLine {
            mode: Mode::Stop,
            ..StateLine::BLANK
        }),
        ack: Ack {
            boot: 1,
            session: 3,
            detail: Detail::Idle {
                owner: 0,
                robot_id: ROBOT_ID,
            },
            ..Ack::default()
        },
    };
    Received::Line(line, line.encode())
}

/// A line of another robot, as if the followed one was silent for long.
fn line_of(robot_id: u8) -> Received {
    let Received::Line(mut line, _) = stopped_line(0) else {
        unreachable!()
    };
    line.ack.detail = Detail::Idle { owner: 0, robot_id };
    Received::Line(line, line.encode())
}

#[test]
fn a_stop_under_way_stays_with_its_robot() {
    let mut fop = Fop::new(Config::new(1));
    fop.handle_received(0, &stopped_line(0));
    fop.stop(1_000_000);
    assert!(fop.holds_robot());
    fop.handle_received(1_100_000, &line_of(ROBOT_ID + 1));
    let frame = fop.poll_transmit(1_200_000).map(<[u8]>::to_vec).unwrap();
    let mut receiver = Receiver::default();
    let heard = frame
        .iter()
        .find_map(|byte| receiver.handle_byte(*byte, ROBOT_ID, None));
    assert!(matches!(heard, Some(Message::Stop(_))), "{heard:?}");
}

#[test]
fn an_idle_station_takes_the_next_robot_with_nothing_of_the_one_before() {
    let mut fop = Fop::new(Config::new(1));
    fop.handle_received(0, &stopped_line(0));
    assert!(!fop.holds_robot());
    fop.handle_received(60_000_000, &line_of(ROBOT_ID + 1));
    fop.stop(61_000_000);
    let frame = fop.poll_transmit(61_000_000).map(<[u8]>::to_vec).unwrap();
    let mut receiver = Receiver::default();
    let heard = frame
        .iter()
        .find_map(|byte| receiver.handle_byte(*byte, ROBOT_ID + 1, None));
    assert!(matches!(heard, Some(Message::Stop(_))), "{heard:?}");
}

/// A line with mode stop may be older than an order that started the robot, so only the acknowledgement confirms a STOP.
#[test]
fn a_late_line_of_a_stopped_robot_proves_no_stop() {
    let mut fop = Fop::new(Config::new(1));
    fop.handle_received(0, &stopped_line(0));
    fop.stop(1_000_000);
    assert!(fop.poll_transmit(1_000_000).is_some());
    assert_eq!(
        fop.poll_event(),
        Some(FopEvent::Stop(CommandStatus::Sent { frames: 1 }))
    );
    for sequence in 1..20 {
        let arrived_us = 1_000_000 + u64::from(sequence) * 333_000;
        fop.handle_received(arrived_us, &stopped_line(sequence));
        assert_eq!(fop.poll_event(), None, "line {sequence}");
    }
}

/// The downlink takes a second and the uplink loses every STOP: the robot continues to drive, and no event claims otherwise.
#[test]
fn a_stop_that_never_arrives_is_never_proven() {
    for seed in 0..50 {
        let mut world = World::new(seed, 0.0);
        world.down_delay_us = 1_000_000;
        world.deliver(Task::Order(Order::Mode(Mode::Stop)));
        world.deliver(Task::Order(Order::Mode(Mode::Prowl)));
        world.robot.deaf_to = |message| matches!(message, Message::Stop(_));
        for _ in 0..seed * 7 {
            world.step();
        }
        world.fop.stop(world.now_us);
        let end = world.run_until(
            60,
            |event| matches!(event, FopEvent::Stop(status) if status.is_end()),
        );
        assert_eq!(
            end,
            FopEvent::Stop(CommandStatus::Failed(Failure::TimedOut)),
            "seed {seed}"
        );
    }
}

/// The downlink is late and the uplink dead. A second operator stops the robot and starts it again before this station's
/// request, and the station learns of that STOP afterwards.
#[test]
fn the_stop_of_another_operator_before_the_request_proves_nothing() {
    for seed in 0..50 {
        let mut world = World::new(seed, 0.0);
        world.down_delay_us = 2_000_000 + seed * 50_000;
        world.deliver(Task::Order(Order::Mode(Mode::Reactive)));
        let stop = Message::Stop(Some(0x111 << 5 | 1));
        world.robot.hear(&stop, Key::robot(ROBOT_ID));
        for _ in 0..240 {
            world.step();
        }
        let ack = world.robot.farm.ack();
        let open = Message::Open(Open {
            boot: ack.boot,
            replaces: ack.session,
            owner: 0x111,
            era: None,
        });
        world.robot.hear(&open, Key::robot(ROBOT_ID));
        let prowl = Message::Command(Command {
            sequence: 1,
            order: Order::Mode(Mode::Prowl),
        });
        let key = world.robot.farm.key().unwrap();
        world.robot.hear(&prowl, key);
        assert_eq!(world.robot.mode, Mode::Prowl);
        world.deaf = true;
        world.fop.stop(world.now_us);
        let end = world.run_until(
            60,
            |event| matches!(event, FopEvent::Stop(status) if status.is_end()),
        );
        assert_eq!(
            end,
            FopEvent::Stop(CommandStatus::Failed(Failure::TimedOut)),
            "seed {seed}"
        );
    }
}

/// A second request needs a separate STOP, because an order of another station may arrive in between.
#[test]
fn a_stop_before_the_latest_request_does_not_prove_it() {
    let mut fop = Fop::new(Config::new(0x2A5));
    let mut robot = Robot::new(1);
    let mut sequence = 0;
    let mut acknowledge = |fop: &mut Fop, now_us, ack| {
        sequence += 1;
        let line = AckLine {
            sequence,
            ack,
            listens: false,
        };
        fop.handle_received(now_us, &Received::Ack(line));
    };
    let transmit = |fop: &mut Fop, robot: &mut Robot, now_us: u64| {
        for at_us in (now_us..now_us + 50_000).step_by(4_000) {
            while let Some(bytes) = fop.poll_transmit(at_us) {
                for &byte in bytes {
                    robot.handle_byte(byte);
                }
            }
        }
        robot.farm.ack()
    };
    let sent = Some(FopEvent::Stop(CommandStatus::Sent { frames: 1 }));
    fop.stop(0);
    let first = transmit(&mut fop, &mut robot, 0);
    assert_eq!(fop.poll_event(), sent);
    fop.stop(100_000);
    fop.stop(110_000);
    acknowledge(&mut fop, 200_000, first);
    assert_eq!(fop.poll_event(), Some(STOPPED), "the first request");
    acknowledge(&mut fop, 210_000, first);
    assert_eq!(fop.poll_event(), None);
    let second = transmit(&mut fop, &mut robot, 400_000);
    assert_eq!(fop.poll_event(), sent);
    acknowledge(&mut fop, 500_000, first);
    assert_eq!(fop.poll_event(), None);
    acknowledge(&mut fop, 510_000, second);
    assert_eq!(fop.poll_event(), Some(STOPPED), "the others");
    assert_eq!(fop.poll_timeout(), None);
}

/// The downlink is slower than the requests, so a line shows an earlier receipt than the latest. It confirms the requests
/// before that STOP left, once.
#[test]
fn an_earlier_receipt_proves_the_requests_before_it() {
    for later in 1..32 {
        let mut fop = Fop::new(Config::new(0x2A5));
        let mut robot = Robot::new(1);
        let mut acks = Vec::new();
        for now_us in (0..=u64::from(later) + 1).map(|n| n * 400_000) {
            fop.stop(now_us);
            for at_us in (now_us..now_us + 99_000).step_by(4_000) {
                while let Some(bytes) = fop.poll_transmit(at_us) {
                    for &byte in bytes {
                        robot.handle_byte(byte);
                    }
                }
            }
            let sent = FopEvent::Stop(CommandStatus::Sent { frames: 1 });
            assert_eq!(fop.poll_event(), Some(sent));
            acks.push(robot.farm.ack());
        }
        let [before, shown, .., latest] = *acks else {
            panic!("{later} later ones");
        };
        let mut sequence = 0;
        let mut hear = |ack| {
            sequence += 1;
            let line = AckLine {
                sequence,
                ack,
                listens: false,
            };
            fop.handle_received(14_000_000, &Received::Ack(line));
            [fop.poll_event(), fop.poll_event()]
        };
        let earlier = FopEvent::EarlierStop { later };
        assert_eq!(hear(shown), [Some(earlier), None]);
        assert_eq!(hear(shown), [None, None], "{later}: once");
        if later < 31 {
            assert_eq!(hear(before), [None, None], "{later}: the one before");
        }
        assert_eq!(hear(latest), [Some(STOPPED), None], "{later}: the latest");
        assert_eq!(hear(shown), [None, None], "{later}: afterwards");
    }
}

/// After a reboot no session is open, either.
#[test]
fn a_restart_proves_no_stop() {
    let mut world = World::new(1, 0.0);
    world.deliver(Task::Order(Order::Mode(Mode::Prowl)));
    world.robot = Robot::new(9);
    world.robot.deaf_to = |message| matches!(message, Message::Stop(_));
    world.fop.stop(world.now_us);
    let end = world.run_until(
        60,
        |event| matches!(event, FopEvent::Stop(status) if status.is_end()),
    );
    assert_eq!(
        end,
        FopEvent::Stop(CommandStatus::Failed(Failure::TimedOut))
    );
}

/// A task begun between two STOPs, before the first is confirmed, ends with the second.
#[test]
fn a_second_stop_ends_a_task_begun_after_the_first() {
    for seed in 0..50 {
        let mut world = World::new(seed, 0.0);
        world.deliver(Task::Order(Order::Mode(Mode::Reactive)));
        world.fop.stop(world.now_us);
        world.step();
        let prowl = Task::Order(Order::Mode(Mode::Prowl));
        assert!(world.fop.start(world.now_us, prowl));
        world
            .fop
            .drive(world.now_us, 6, 0, world.now_us + 5_000_000);
        world.fop.stop(world.now_us);
        for _ in 0..240 * 5 {
            world.step();
            assert_ne!(world.robot.mode, Mode::Prowl, "seed {seed}");
        }
        let failed = failed(Failure::Stopped);
        assert!(world.events.contains(&failed), "seed {seed}");
        assert_eq!(world.robot.mode, Mode::Stop, "seed {seed}");
        assert_eq!(world.robot.drives, 0, "seed {seed}");
    }
}

/// A line C composed before the order still holds the longer silence.
#[test]
fn keepalives_follow_a_shorter_failsafe_from_its_order_on() {
    let mut world = World::new(1, 0.0);
    let failsafe = |silence_s| {
        let mode = Mode::GoHome;
        Task::Order(Order::Failsafe(Some(Failsafe { silence_s, mode })))
    };
    world.robot.link = Link::Armed;
    world.robot.failsafe = Some(Failsafe {
        silence_s: 300,
        mode: Mode::GoHome,
    });
    world.deliver(failsafe(300));
    world.deliver(failsafe(10));
    let mut silent_us = 0;
    for _ in 0..240 * 60 {
        let heard = world.robot.receiver.counters().frames;
        world.step();
        let is_silent = world.robot.receiver.counters().frames == heard;
        silent_us = if is_silent {
            silent_us + 1_000_000 / 240
        } else {
            0
        };
        assert!(silent_us < 3_000_000, "the robot hears nothing");
    }
}

#[test]
fn repeated_stops_do_not_delay_the_first() {
    let mut fop = Fop::new(Config {
        duplex: Duplex::Half,
        ..Config::new(1)
    });
    let mut sent = Vec::new();
    for now_us in (0..3_000_000).step_by(10_000) {
        fop.stop(now_us);
        fop.handle_timeout(now_us);
        while let Some(bytes) = fop.poll_transmit(now_us) {
            sent.extend_from_slice(bytes);
        }
        while fop.poll_event().is_some() {}
    }
    let count = sent.windows(2).filter(|w| *w == b"\nX").count();
    assert!((3..=5).contains(&count), "{count}");
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
fn lines_of_another_robot_are_ignored() {
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
fn a_line_holds_the_id_of_its_robot() {
    let mut decoder = Decoder::default();
    let Received::Line(_, bytes) = stopped_line(0) else {
        unreachable!()
    };
    let received = decoder.lines(&bytes).next();
    assert_eq!(received.and_then(|r| r.robot_id()), Some(ROBOT_ID));
}
