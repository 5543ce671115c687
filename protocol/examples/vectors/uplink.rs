//! Vectors of frames and of digests.

use super::judge::{self, Ear};
use groundwave_protocol::command::{
    Command, Drive, FRAME_WAYPOINTS_MAX, Frame, Keepalive, Key, Message, Open, Order, Slots,
};
use groundwave_protocol::failsafe::Failsafe;
use groundwave_protocol::status_codes::{LayerMask, Mode};
use groundwave_protocol::{Waypoint, crc, digest::digest, sixbit};
use serde_json::{Value, json};

pub const EAR: Ear = Ear {
    robot_id: 7,
    boot: 1,
    session: 3,
    owner: 0x2A5,
    era: 0,
};

const CLOSED: Ear = Ear { owner: 0, ..EAR };

pub fn session() -> Key {
    Key::session(EAR.robot_id, EAR.boot, EAR.session, EAR.owner)
}

pub fn vector(about: impl Into<String>, ear: Ear, bytes: &[u8]) -> Value {
    let mut vector = ear.hear(bytes);
    vector["about"] = Value::from(about.into());
    vector["robot_id"] = Value::from(ear.robot_id);
    vector["boot"] = Value::from(ear.boot);
    vector["session"] = Value::from(ear.session);
    vector["owner"] = Value::from(ear.owner);
    if ear.era != 0 {
        vector["era"] = Value::from(ear.era);
    }
    vector["frame"] = Value::from(judge::text(bytes));
    vector
}

/// A frame with any content and a valid checksum.
pub fn sealed(key: Key, content: &[u8]) -> Vec<u8> {
    let trailer = crc::characters(crc::update(key.init(), content));
    [b"\n", content, &trailer[..], b"\n"].concat()
}

fn route(count: i16) -> Vec<Waypoint> {
    (0..count)
        .map(|i| Waypoint {
            x_in: i * 61 % 401 - 200,
            y_in: i * 97 % 601 - 300,
        })
        .collect()
}

/// Each message at its limits, then frames to reject.
pub fn frames() -> Vec<Value> {
    let mut vectors = valid();
    vectors.extend(not_heard());
    vectors.extend(unreadable());
    vectors
}

fn orders() -> Vec<(&'static str, Order)> {
    let pose = |x_in, y_in, theta_deg| Order::Pose {
        position: Waypoint { x_in, y_in },
        theta_deg,
    };
    let layers = |which, allowed| Order::Layers {
        which: LayerMask::from_bits(which),
        allowed: LayerMask::from_bits(allowed),
    };
    let failsafe = |silence_s, mode| Order::Failsafe(Some(Failsafe { silence_s, mode }));
    let mut orders: Vec<_> = Mode::ALL
        .iter()
        .map(|&mode| ("mode", Order::Mode(mode)))
        .collect();
    orders.extend([
        ("no layer at all", layers(0xFF, 0)),
        (
            "bumpers, sonar and dead reckoning and no others",
            layers(0xFF, 0b1001_0010),
        ),
        ("every layer", layers(0xFF, 0xFF)),
        ("sonar on, infrared off", layers(0b0001_1000, 0b0001_0000)),
        ("about no layer", layers(0, 0)),
        ("home after half a minute", failsafe(30, Mode::GoHome)),
        ("stop after the longest silence", failsafe(4095, Mode::Stop)),
        (
            "a silence too short, to be refused",
            failsafe(1, Mode::Stop),
        ),
        ("carry on", Order::Failsafe(None)),
        ("the origin, looking ahead", pose(0, 0, 0)),
        ("the farthest pose", pose(-9999, 9999, 359)),
        ("scan", Order::Scan),
        (
            "activate three waypoints",
            Order::Activate {
                tag: 1,
                count: 3,
                digest: digest(route(3).iter()),
            },
        ),
        (
            "activate, everything as large as it gets",
            Order::Activate {
                tag: 63,
                count: 4095,
                digest: u32::MAX,
            },
        ),
        (
            "clear the list",
            Order::Activate {
                tag: 0,
                count: 0,
                digest: digest([].iter()),
            },
        ),
    ]);
    orders
}

fn valid() -> Vec<Value> {
    let open = |boot, replaces, owner| {
        Message::Open(Open {
            boot,
            replaces,
            owner,
            era: None,
        })
    };
    let drive = |velocity_in_s, rotation_in_s, heard, count| {
        Message::Drive(Drive {
            velocity_in_s,
            rotation_in_s,
            heard,
            count,
        })
    };
    let slots = |tag, first_block, count: usize| {
        Message::Waypoints(Slots::new(tag, first_block, &route(16)[..count]))
    };
    let said =
        |about, ear, message: Message, key| vector(about, ear, message.encode(key).as_bytes());
    let mine = Key::robot(7);
    let mut vectors = vec![
        said(
            "STOP, the session open or not",
            EAR,
            Message::Stop(None),
            mine,
        ),
        said("STOP without a session", CLOSED, Message::Stop(None), mine),
        said(
            "STOP to whoever hears it",
            CLOSED,
            Message::Stop(None),
            Key::EVERY_ROBOT,
        ),
        said(
            "open the first session after a boot",
            CLOSED,
            open(1, 0, 0x2A5),
            mine,
        ),
        said(
            "open, everything as large as it gets",
            EAR,
            open(7, 7, 1023),
            mine,
        ),
        vector("a knock", CLOSED, Frame::knock().as_bytes()),
    ];
    for (sequence, (about, order)) in (1..).zip(orders()) {
        let command = Message::Command(Command { sequence, order });
        vectors.push(said(about, EAR, command, session()));
    }
    let last = Message::Command(Command {
        sequence: 63,
        order: Order::Scan,
    });
    vectors.extend([
        said("the last sequence number", EAR, last, session()),
        said("one waypoint", EAR, slots(1, 0, 1), session()),
        said("a block of four", EAR, slots(1, 0, 4), session()),
        said(
            "the most a frame takes",
            EAR,
            slots(31, 71, FRAME_WAYPOINTS_MAX),
            session(),
        ),
        said("the last block", EAR, slots(2, 74, 4), session()),
        said("ahead, turning right", EAR, drive(6, 4, 42, 1), session()),
        said(
            "back, turning left",
            EAR,
            drive(-31, -63, 99, 15),
            session(),
        ),
        said("as fast as it goes", EAR, drive(31, 63, 0, 0), session()),
        said("still", EAR, drive(0, 0, 7, 8), session()),
        said(
            "keepalive",
            EAR,
            Message::Keepalive(Keepalive { heard: 42 }),
            session(),
        ),
    ]);
    vectors
}

fn not_heard() -> Vec<Value> {
    let scan = Message::Command(Command {
        sequence: 1,
        order: Order::Scan,
    });
    let frame = scan.encode(session());
    let scan = frame.as_bytes();
    let ear = |robot_id, boot, session, owner| Ear {
        robot_id,
        boot,
        session,
        owner,
        era: 0,
    };
    let stop = Message::Stop(None).encode(Key::robot(7));
    let stop = stop.as_bytes();
    let mut flipped = scan.to_vec();
    flipped[2] ^= 1;
    let mut no_end = scan.to_vec();
    no_end[8] ^= 0x40;
    let nobody = Key::session(CLOSED.robot_id, CLOSED.boot, CLOSED.session, CLOSED.owner);
    let long = [b"\n".to_vec(), vec![b'!'; 88], b"\n".to_vec()].concat();
    vec![
        vector("no session is open", CLOSED, scan),
        vector("another robot", ear(8, 1, 3, 0x2A5), scan),
        vector("another boot", ear(7, 2, 3, 0x2A5), scan),
        vector("another session", ear(7, 1, 4, 0x2A5), scan),
        vector("another station's session", ear(7, 1, 3, 0x2A4), scan),
        vector("STOP to another robot", ear(8, 1, 3, 0x2A5), stop),
        vector("a flipped bit", EAR, &flipped),
        vector("not ended yet", EAR, &no_end),
        vector(
            "noise before the leading line feed does no harm",
            EAR,
            &[b"~~~", scan].concat(),
        ),
        vector(
            "noise without a line feed after it does",
            EAR,
            &[b"\n~~~", &scan[1..]].concat(),
        ),
        vector(
            "STOP aborts a frame in flight",
            EAR,
            &[&scan[..5], stop].concat(),
        ),
        vector("too long to be a frame", EAR, &long),
        vector("shorter than a checksum", EAR, b"\nX!!\n"),
        vector("the session's key alone", EAR, &sealed(session(), b"")),
        vector("the robot's key alone", EAR, &sealed(Key::robot(7), b"")),
        vector(
            "nobody's key while no session is open",
            CLOSED,
            Message::Keepalive(Keepalive { heard: 42 })
                .encode(nobody)
                .as_bytes(),
        ),
    ]
}

/// A number in 6-bit characters, valid or not.
fn number(characters: usize, value: u32) -> Vec<u8> {
    let mut written = vec![0; characters];
    sixbit::encode_into(value, &mut written);
    written
}

fn point(x_in: i32, y_in: i32) -> Vec<u8> {
    number(5, ((x_in + 16384) << 15 | (y_in + 16384)) as u32)
}

fn pose(x_in: i32, y_in: i32, theta_deg: u32) -> Vec<u8> {
    [b"C!P".to_vec(), point(x_in, y_in), number(2, theta_deg)].concat()
}

fn one_waypoint(tag: u32, first_block: u32, waypoint: &[u8]) -> Vec<u8> {
    [b"W", &number(2, tag << 7 | first_block)[..], waypoint].concat()
}

fn drive(velocity_in_s: i32, rotation_in_s: i32, heard: i32) -> Vec<u8> {
    let bits = (velocity_in_s & 0x3F) << 18 | (rotation_in_s & 0x7F) << 11 | heard << 4 | 1;
    [b"D".to_vec(), number(4, bits as u32)].concat()
}

/// Frames with a valid checksum and one error each. A command is received nevertheless, and refused.
fn unreadable() -> Vec<Value> {
    let origin = point(0, 0);
    let half = [&origin[..], &origin[..3]].concat();
    let contents = [
        ("no such type", b"Z".to_vec()),
        ("an acknowledgement is no frame", b"K42`````".to_vec()),
        ("a command without an order", b"C!".to_vec()),
        ("a space is no sequence", b"C S".to_vec()),
        ("nor is a letter in lower case", b"CaS".to_vec()),
        ("no such order", b"C!Z".to_vec()),
        ("no such mode", b"C!Mp".to_vec()),
        ("a ninth layer", b"C!L0``".to_vec()),
        ("allowed and not among those meant", b"C!L``!".to_vec()),
        ("a mask without the layers meant", b"C!L\"2".to_vec()),
        ("no silence, and a mode", b"C!F``G".to_vec()),
        ("failsafe without a mode", b"C!F`>".to_vec()),
        ("failsafe with no such mode", b"C!F`>g".to_vec()),
        ("theta 360", pose(0, 0, 360)),
        ("a pose at X 10000", pose(10_000, 0, 0)),
        ("a pose at Y -10000", pose(0, -10_000, 0)),
        ("a digest of 33 bits", b"C!A!`#$`````".to_vec()),
        ("scan takes no argument", b"C!S!".to_vec()),
        ("tag 0", one_waypoint(0, 0, &origin)),
        ("block 127", one_waypoint(1, 127, &origin)),
        ("block 75", one_waypoint(1, 75, &origin)),
        ("no waypoint", one_waypoint(1, 0, &[])),
        ("a waypoint and a half", one_waypoint(1, 0, &half)),
        ("a space in a waypoint", one_waypoint(1, 0, b"@` @`")),
        ("X 10000", one_waypoint(1, 0, &point(10_000, 0))),
        ("X -10000", one_waypoint(1, 0, &point(-10_000, 0))),
        ("Y 10000", one_waypoint(1, 0, &point(0, 10_000))),
        ("Y -10000", one_waypoint(1, 0, &point(0, -10_000))),
        ("line 100", b"L!D".to_vec()),
        ("drive with line 100", drive(0, 0, 100)),
        ("drive at -32 in/s", drive(-32, 0, 42)),
        ("drive turning at -64 in/s", drive(0, -64, 42)),
        ("keepalive too long", b"L!!!".to_vec()),
        ("a type in lower case", b"l!!".to_vec()),
        ("0x61 is no 6-bit character", b"L`a".to_vec()),
        ("0x7F is no 6-bit character", b"L`\x7F".to_vec()),
    ];
    let mut vectors: Vec<_> = contents
        .iter()
        .map(|(about, content)| vector(*about, EAR, &sealed(session(), content)))
        .collect();
    let mine = Key::robot(7);
    vectors.push(vector(
        "nobody opens no session",
        EAR,
        &sealed(mine, b"O```"),
    ));
    vectors.push(vector("leading bits in open", EAR, &sealed(mine, b"O0`!")));
    vectors.push(vector("STOP takes no argument", EAR, &sealed(mine, b"X!")));
    vectors
}

/// Digests of waypoint lists.
pub fn digests() -> Vec<Value> {
    let at = |x_in, y_in| Waypoint { x_in, y_in };
    [
        vec![],
        vec![at(0, 0)],
        vec![at(1, 2)],
        vec![at(2, 1)],
        vec![at(-1, -1)],
        vec![at(120, -36), at(-9999, 9999), at(9999, -9999)],
        route(16),
        route(300),
    ]
    .iter()
    .map(|list| {
        json!({
            "waypoints": list.iter().map(|w| [w.x_in, w.y_in]).collect::<Vec<_>>(),
            "digest": digest(list.iter()),
        })
    })
    .collect()
}
