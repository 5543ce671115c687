//! Frames of a day, recorded and sent again.

use crate::world::{DONE, ROBOT_ID, Robot, STOPPED, World, failed};
use groundwave_protocol::arq::{Action, Config, Failure, Farm, Fop, FopEvent, Task};
use groundwave_protocol::command::{ERA_MAX, Key, Message, Order};
use groundwave_protocol::receiver::Receiver;
use groundwave_protocol::status_codes::Mode;
use std::collections::BTreeSet;

/// Number of cycles of a command and a STOP in a day.
const CYCLES: u16 = 1000;

/// Number of cycles at which the recording is sent again.
const REPLAYS: u16 = 40;

/// All frames that a station sent, without repetitions.
#[derive(Default)]
struct Recording {
    bytes: Vec<u8>,
    frames: BTreeSet<Vec<u8>>,
}

impl Recording {
    fn take(&mut self, byte: u8) {
        self.bytes.push(byte);
        if byte == b'\n' {
            self.frames
                .insert(std::mem::replace(&mut self.bytes, vec![b'\n']));
        }
    }

    /// The first frame that would do more than stop the robot.
    fn executed_by(&self, farm: &Farm) -> Option<&Vec<u8>> {
        self.frames.iter().find(|frame| {
            let mut farm = farm.clone();
            let mut receiver = Receiver::default();
            let key = farm.key();
            let messages = frame.iter();
            let mut messages =
                messages.filter_map(|&byte| receiver.handle_byte(byte, ROBOT_ID, key));
            messages.any(|message| {
                let acts = !matches!(farm.handle(&message), Action::Heard | Action::Stop);
                acts || matches!(message, Message::Open(_)) && farm.key() != key
            })
        })
    }
}

/// Runs a world until the station's current task or STOP has ended; returns the final event.
fn end(world: &mut World, recording: &mut Recording) -> FopEvent {
    for _ in 0..240 * 60 {
        let seen = world.events.len();
        world.step();
        for byte in std::mem::take(&mut world.sent) {
            recording.take(byte);
        }
        let is_end = |event: &&FopEvent| matches!(event, FopEvent::Task(status) | FopEvent::Stop(status) if status.is_end());
        if let Some(event) = world.events[seen..].iter().find(is_end) {
            return *event;
        }
    }
    panic!("no end within a minute");
}

/// Stations of two owners in turn, and a robot that reboots after `cycles_in_life`. The recording is sent again while a
/// session is open and after a STOP.
fn replay_a_day(owners: [u16; 2], cycles_in_life: u16) {
    let mut recording = Recording::default();
    let mut boots = 1;
    let mut world = World::new(1, 0.0);
    for cycle in 0..CYCLES {
        let about = || format!("cycle {cycle}, owners {owners:?}");
        if cycle % cycles_in_life == 0 {
            boots += 1;
            world.robot = Robot::new(boots);
        }
        if cycle % 100 == 0 {
            let owner = owners[usize::from(cycle / 100 % 2)];
            world.fop = Fop::new(Config::new(owner));
        }
        let prowl = Task::Order(Order::Mode(Mode::Prowl));
        // The station learns of a reboot only at the next line; the reboot ends the task.
        while {
            assert!(world.fop.start(world.now_us, prowl));
            let ended = end(&mut world, &mut recording);
            assert!(
                ended == DONE || cycle % cycles_in_life == 0,
                "{ended:?}, {}",
                about()
            );
            ended != DONE
        } {}
        let must_replay = cycle % (CYCLES / REPLAYS) == 0;
        if must_replay {
            assert_eq!(
                recording.executed_by(&world.robot.farm),
                None,
                "{}",
                about()
            );
        }
        world.fop.stop(world.now_us);
        assert_eq!(end(&mut world, &mut recording), STOPPED, "{}", about());
        if must_replay {
            assert_eq!(
                recording.executed_by(&world.robot.farm),
                None,
                "{}",
                about()
            );
        }
    }
    assert!(recording.frames.len() > 2 * usize::from(CYCLES));
}

#[test]
fn no_frame_of_a_day_executes_again() {
    replay_a_day([0x2A5, 0x2A5], CYCLES);
    replay_a_day([0x2A5, 0x111], CYCLES);
}

#[test]
fn no_frame_of_a_day_with_many_reboots_executes_again() {
    replay_a_day([0x2A5, 0x2A5], 45);
    replay_a_day([0x2A5, 0x111], 7);
}

/// A session with more commands than it has sequences.
#[test]
fn no_frame_of_a_long_session_executes_again() {
    let mut recording = Recording::default();
    let mut world = World::new(1, 0.0);
    for n in 0..200 {
        let route = crate::world::route(n, 1);
        let task = if n % 2 == 0 {
            Task::List(&route)
        } else {
            Task::Order(Order::Mode(Mode::Prowl))
        };
        assert!(world.fop.start(world.now_us, task));
        assert_ne!(end(&mut world, &mut recording), failed(Failure::TimedOut));
        let executed = recording.executed_by(&world.robot.farm);
        assert_eq!(executed, None, "after task {n}");
    }
}

/// Keys differ for any owner within 128 eras, and for one owner in all eras.
#[test]
fn keys_of_a_robot_differ() {
    let mut keys = BTreeSet::new();
    for era in 0..128 {
        for session in 1..8 {
            for owner in [1, 0x111, 0x2A5, 0x3FF] {
                let key = Key::session(ROBOT_ID, 1, session, owner).in_era(era);
                assert!(
                    keys.insert(key.init()),
                    "era {era}, session {session}, owner {owner}"
                );
                assert_eq!(key.init() >> 23, 0, "no line's");
            }
        }
    }
    let mut keys = BTreeSet::new();
    for era in 0..=ERA_MAX {
        assert!(keys.insert(Key::session(ROBOT_ID, 1, 1, 0x2A5).in_era(era).init()));
    }
}
