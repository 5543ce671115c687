//! The robot's receiver on clean and damaged frames.

use std::collections::HashSet;

use crate::damage::{self, Rng};
use groundwave_protocol::Waypoint;
use groundwave_protocol::command::{
    Command, Drive, FRAME_WAYPOINTS_MAX, FrameType, Keepalive, Key, Message, Open, Order,
    OrderType, Slots,
};
use groundwave_protocol::receiver::Receiver;
use groundwave_protocol::status_codes::{LayerMask, Mode};

const ROBOT_ID: u8 = 7;
const SESSION: Key = Key::session(ROBOT_ID, 1, 1, 0x2A5);

fn key_of(message: &Message) -> Key {
    if message.is_sessionless() {
        Key::robot(ROBOT_ID)
    } else {
        SESSION
    }
}

fn samples() -> Vec<Message> {
    let command = |order| {
        Message::Command(Command {
            sequence: 41,
            order,
        })
    };
    let point = |i: i16| Waypoint {
        x_in: 100 - 37 * i,
        y_in: -9000 + 11 * i,
    };
    let list: Vec<Waypoint> = (0..FRAME_WAYPOINTS_MAX as i16).map(point).collect();
    vec![
        Message::Stop(None),
        Message::Stop(Some(0x2A5)),
        Message::Open(Open {
            boot: 1,
            replaces: 7,
            owner: 0x2A5,
            era: None,
        }),
        command(Order::Mode(Mode::Wander)),
        command(Order::Layers {
            which: LayerMask::ALL,
            allowed: LayerMask::from_bits(0x9A),
        }),
        command(Order::Pose {
            position: point(3),
            theta_deg: 270,
        }),
        command(Order::Scan),
        command(Order::Failsafe(None)),
        command(Order::SetParameter {
            key: 0x12_3456,
            value: -1,
        }),
        command(Order::ReadParameters { place: 0 }),
        command(Order::KeepParameters),
        command(Order::Unknown),
        command(Order::Activate {
            tag: 3,
            count: 300,
            digest: 0xFEDC_BA98,
        }),
        Message::Waypoints(Slots::new(3, 74, &list[..1])),
        Message::Waypoints(Slots::new(3, 8, &list)),
        Message::Drive(Drive {
            velocity_in_s: -6,
            rotation_in_s: 20,
            heard: 42,
            count: 5,
        }),
        Message::Keepalive(Keepalive { heard: 99 }),
    ]
}

#[test]
fn samples_are_of_every_type() {
    let frames: HashSet<_> = samples().iter().map(Message::frame_type).collect();
    assert_eq!(frames, FrameType::ALL.iter().copied().collect());
    let order = |message: Message| match message {
        Message::Command(command) => Some(command.order.order_type()),
        _ => None,
    };
    let orders: HashSet<_> = samples().into_iter().filter_map(order).collect();
    assert_eq!(orders, OrderType::ALL.iter().copied().collect());
}

/// The messages in a stream; checks that the checksum rejects all other byte sequences.
fn hear(bytes: &[u8]) -> Vec<Message> {
    let mut receiver = Receiver::default();
    let heard = bytes
        .iter()
        .filter_map(|&byte| receiver.handle_byte(byte, ROBOT_ID, Some(SESSION)))
        .collect();
    assert_eq!(receiver.counters().unreadable, 0);
    heard
}

/// Flips bits of a frame and appends a good one; checks that only the good one is accepted.
fn judge(message: &Message, bits: &[usize], context: &str) {
    let next = Message::Keepalive(Keepalive { heard: 1 });
    let mut bytes = message.encode(key_of(message)).as_bytes().to_vec();
    for bit in bits {
        bytes[bit / 8] ^= 1 << (bit % 8);
    }
    bytes.extend(next.encode(SESSION).as_bytes());
    assert_eq!(hear(&bytes), [next], "{message:?} bits {bits:?} {context}");
}

fn bits_of(message: &Message) -> usize {
    message.encode(key_of(message)).as_bytes().len() * 8
}

#[test]
fn consecutive_frames_are_accepted() {
    let stream: Vec<u8> = samples()
        .iter()
        .flat_map(|message| message.encode(key_of(message)).as_bytes().to_vec())
        .collect();
    assert_eq!(hear(&stream), samples());
}

#[test]
fn every_flip_of_one_or_two_bits_is_rejected() {
    for message in samples() {
        for first in 0..bits_of(&message) {
            judge(&message, &[first], "");
            for second in first + 1..bits_of(&message) {
                judge(&message, &[first, second], "");
            }
        }
    }
}

#[test]
fn flips_of_three_to_five_bits_are_rejected() {
    let seed = damage::seed();
    let context = format!("seed {seed}");
    let mut rng = Rng(seed);
    for message in samples() {
        for _ in 0..30_000 {
            let count = 3 + rng.below(3);
            let bits = rng.different(count, bits_of(&message));
            judge(&message, &bits, &context);
        }
    }
}

/// A radio may echo the robot's own lines.
#[test]
fn the_robots_own_lines_are_not_commands() {
    for line in damage::samples() {
        let mut stream = b"\n".to_vec();
        stream.extend(&line.bytes);
        stream.extend(&line.bytes[..line.bytes.len() - 2]);
        stream.push(b'\n');
        assert_eq!(hear(&stream), [], "{}", line.name);
    }
}

#[test]
fn noise_is_not_a_command() {
    let seed = damage::seed();
    let mut rng = Rng(seed);
    let noise: Vec<u8> = (0..4 << 20)
        .map(|i: u32| {
            let byte = rng.next() as u8;
            // Every other stretch is made of the characters of frames, with a line feed now and then.
            match (i >> 12 & 1, byte) {
                (0, _) => byte,
                (_, 0..=15) => b'\n',
                (_, byte) => byte & 0x3F | 0x20,
            }
        })
        .collect();
    assert_eq!(hear(&noise), [], "seed {seed}");
}
