//! Frames by themselves, and digests of waypoint lists.

use crate::judge::{self, Ear};
use groundwave_protocol::command::{
    Command, Drive, FRAME_WAYPOINTS_MAX, Frame, Keepalive, Key, Message, Open, Order, Slots,
};
use groundwave_protocol::letters::{LayerMask, Mode};
use groundwave_protocol::{Waypoint, crc, digest::digest};
use serde_json::{Value, json};

const EAR: Ear = Ear {
    robot_id: 7,
    boot: 1,
    session: 3,
    owner: 0x2A5,
};

const CLOSED: Ear = Ear { owner: 0, ..EAR };

fn session() -> Key {
    Key::session(EAR.robot_id, EAR.boot, EAR.session, EAR.owner)
}

fn vector(about: impl Into<String>, ear: Ear, bytes: &[u8]) -> Value {
    let mut vector = ear.hear(bytes);
    vector["about"] = Value::from(about.into());
    vector["robot_id"] = Value::from(ear.robot_id);
    vector["boot"] = Value::from(ear.boot);
    vector["session"] = Value::from(ear.session);
    vector["owner"] = Value::from(ear.owner);
    vector["frame"] = Value::from(judge::text(bytes));
    vector
}

/// Any content under a good checksum.
fn sealed(key: Key, content: &[u8]) -> Vec<u8> {
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

/// Every message at its limits; then everything that must not be heard.
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
    let layers = |bits| Order::Layers(LayerMask::from_bits(bits));
    let mut orders: Vec<_> = Mode::ALL
        .iter()
        .map(|&mode| ("mode", Order::Mode(mode)))
        .collect();
    orders.extend([
        ("no layer", layers(0)),
        ("bumpers, sonar and dead reckoning", layers(0b1001_0010)),
        ("every layer", layers(0xFF)),
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
        said("STOP, the session open or not", EAR, Message::Stop, mine),
        said("STOP without a session", CLOSED, Message::Stop, mine),
        said(
            "STOP to whoever hears it",
            CLOSED,
            Message::Stop,
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
    };
    let stop = Message::Stop.encode(Key::robot(7));
    let stop = stop.as_bytes();
    let mut flipped = scan.to_vec();
    flipped[2] ^= 1;
    let mut no_end = scan.to_vec();
    no_end[8] ^= 0x40;
    let long = [b"\n".to_vec(), vec![b'!'; 89], b"\n".to_vec()].concat();
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
    ]
}

/// Good checksums over what makes no sense. A command is heard all the same: it must be refused.
fn unreadable() -> Vec<Value> {
    let contents: [(&str, &[u8]); 23] = [
        ("no such type", b"Z"),
        ("an acknowledgement is no frame", b"K42`````"),
        ("a command without an order", b"C!"),
        ("a space is no sequence", b"C S"),
        ("no such order", b"C!Z"),
        ("no such mode", b"C!Mp"),
        ("a ninth layer", b"C!L$`"),
        ("theta 360", b"C!P0``0``%H"),
        ("a pose out of bounds", b"C!P`````%G"),
        ("a digest of 33 bits", b"C!A!`#$`````"),
        ("scan takes no argument", b"C!S!"),
        ("tag 0", b"W```0``0``"),
        ("tag 32", b"W@``0``0``"),
        ("block 75", b"W!!+0``0``"),
        ("no waypoint", b"W!``"),
        ("a waypoint and a half", b"W!``0``0``0``"),
        ("a waypoint out of bounds", b"W!`` ````"),
        ("line 100", b"L!D"),
        ("drive with line 100", b"D``9```"),
        ("drive at -32 in/s", b"D@```"),
        ("drive at -64 in/s", b"D```"),
        ("keepalive too long", b"L!!!"),
        ("a letter in lower case", b"l!!"),
    ];
    let mut vectors: Vec<_> = contents
        .iter()
        .map(|&(about, content)| vector(about, EAR, &sealed(session(), content)))
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
