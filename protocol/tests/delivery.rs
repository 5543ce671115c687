//! Both ends of delivery over a wire that flips bits, in virtual time.

use crate::world::{DONE, ROBOT_ID, Robot, STOPPED, World, failed, replaced, route};
use groundwave_protocol::arq::{CommandStatus, Failure, FopEvent, Task};
use groundwave_protocol::command::{Key, Message, Open, Order};
use groundwave_protocol::digest::digest;
use groundwave_protocol::status_codes::{LayerMask, Mode};
use groundwave_protocol::telemetry::Outcome;

#[test]
fn a_command_is_executed_once_and_proven() {
    for seed in 0..200 {
        for bit_error_rate in [0.0, 1e-3, 3e-3] {
            let mut world = World::new(seed, bit_error_rate);
            let order = Order::Mode(Mode::Reactive);
            assert_eq!(
                world.deliver(Task::Order(order)),
                DONE,
                "seed {seed}, ber {bit_error_rate}"
            );
            let layers = Order::Layers {
                which: LayerMask::ALL,
                allowed: LayerMask::from_bits(0x9A),
            };
            assert_eq!(
                world.deliver(Task::Order(layers)),
                DONE,
                "seed {seed}, ber {bit_error_rate}"
            );
            assert_eq!(
                world.robot.executed,
                [order, layers],
                "seed {seed}, ber {bit_error_rate}"
            );
        }
    }
}

#[test]
fn a_list_arrives_whole_or_not_at_all() {
    for seed in 0..60 {
        for (count, bit_error_rate) in [
            (1, 0.0),
            (40, 0.0),
            (300, 1e-4),
            (40, 1e-3),
            (7, 3e-3),
            (100, 3e-3),
        ] {
            let mut world = World::new(seed, bit_error_rate);
            let list = route(seed, count);
            let event = world.deliver(Task::List(&list));
            let digest = digest(list.iter());
            let context = format!("seed {seed}, {count} waypoints, ber {bit_error_rate}");
            assert_eq!(event, replaced(digest), "{context}");
            assert_eq!(world.robot.farm.lists().active(), list, "{context}");
            assert_eq!(world.robot.lists.len(), 1, "{context}");
        }
    }
}

#[test]
fn an_empty_list_clears() {
    let mut world = World::new(1, 0.0);
    world.deliver(Task::List(&route(1, 5)));
    let event = world.deliver(Task::List(&[]));
    assert_eq!(event, replaced(digest([].iter())));
    assert_eq!(world.robot.farm.lists().active(), []);
}

#[test]
fn a_refusal_has_a_reason_and_the_next_command_is_delivered() {
    let mut world = World::new(1, 0.0);
    let refused = FopEvent::Task(CommandStatus::Refused(Outcome::NotFitted));
    assert_eq!(world.deliver(Task::Order(Order::Scan)), refused);
    assert_eq!(world.deliver(Task::Order(Order::Mode(Mode::Prowl))), DONE);
}

#[test]
fn stop_interrupts_a_transfer_and_no_earlier_command_runs_after_it() {
    for seed in 0..100 {
        let mut world = World::new(seed, if seed % 2 == 0 { 0.0 } else { 1e-3 });
        let list = route(seed, 100);
        assert!(world.fop.start(0, Task::List(&list)));
        for _ in 0..200 + seed * 3 {
            world.step();
        }
        let pressed_us = world.now_us;
        world.fop.stop(pressed_us);
        while world.robot.mode != Mode::Stop {
            world.step();
            assert!(world.now_us < 60_000_000, "never stopped, seed {seed}");
        }
        let heard_s = (world.now_us - pressed_us) as f64 / 1e6;
        assert!(seed % 2 == 1 || heard_s < 0.15, "seed {seed}: {heard_s} s");
        world.run_until(60, |event| *event == STOPPED);
        assert!(
            world.events.contains(&failed(Failure::Stopped)),
            "seed {seed}"
        );
        assert!(world.robot.lists.is_empty(), "seed {seed}");
        assert_eq!(
            world.deliver(Task::Order(Order::Mode(Mode::Prowl))),
            DONE,
            "seed {seed}"
        );
        assert_eq!(world.robot.mode, Mode::Prowl, "seed {seed}");
    }
}

#[test]
fn a_reboot_ends_the_session_and_the_transfer() {
    let mut world = World::new(3, 0.0);
    let list = route(3, 100);
    assert!(world.fop.start(0, Task::List(&list)));
    for _ in 0..400 {
        world.step();
    }
    world.robot = Robot::new(2);
    assert_eq!(world.finish(), failed(Failure::RobotRestarted));
    assert_eq!(
        world.deliver(Task::Order(Order::Mode(Mode::Reactive))),
        DONE
    );
}

#[test]
fn a_second_station_takes_over_and_the_first_reports_it() {
    let mut world = World::new(4, 0.0);
    world.deliver(Task::Order(Order::Mode(Mode::Reactive)));
    let ack = world.robot.farm.ack();
    let open = Open {
        boot: ack.boot,
        replaces: ack.session,
        owner: 0x111,
        era: None,
    };
    for &byte in Message::Open(open).encode(Key::robot(ROBOT_ID)).as_bytes() {
        world.robot.handle_byte(byte);
    }
    world.run_until(5, |event| {
        *event == FopEvent::Session(Err(Failure::TakenOver))
    });
}

#[test]
fn a_task_for_a_deaf_robot_fails_and_never_runs_late() {
    let mut world = World::new(5, 0.0);
    world.deliver(Task::Order(Order::Mode(Mode::Reactive)));
    world.deaf = true;
    let lost = Order::Layers {
        which: LayerMask::ALL,
        allowed: LayerMask::NONE,
    };
    assert_eq!(world.deliver(Task::Order(lost)), failed(Failure::TimedOut));
    world.deaf = false;
    assert_eq!(world.deliver(Task::Order(Order::Mode(Mode::Prowl))), DONE);
    assert!(!world.robot.executed.contains(&lost));
}

#[test]
fn nothing_is_sent_before_the_first_task() {
    let mut world = World::new(6, 0.0);
    for _ in 0..240 * 60 {
        world.step();
        assert!(world.uplink.is_empty());
    }
    assert_eq!(world.events, []);
}
