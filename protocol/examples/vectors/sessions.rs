//! Vectors of receipts and eras. They were added after version 1 was frozen, so they have separate files.

use super::judge::Ear;
use super::lines::vector as line_vector;
use super::samples::{ACK, acknowledge, state};
use super::uplink::{EAR, sealed, session, vector as frame_vector};
use groundwave_protocol::command::{Command, ERA_MAX, Key, Message, Open, Order, RECEIPT_MAX};
use groundwave_protocol::telemetry::{Ack, Body, Detail, Line};
use serde_json::Value;

/// Acknowledgements with a receipt or an era.
pub fn lines() -> Vec<Value> {
    let stopped = |receipt| Ack {
        detail: Detail::Stopped { receipt },
        ..ACK
    };
    let era = |era| Ack {
        detail: Detail::Era { era },
        ..ACK
    };
    let line = Line {
        sequence: 42,
        body: Body::State(state()),
        ack: stopped(0x2A5 << 5 | 1),
    };
    vec![
        line_vector("A: stopped, with a receipt", &line.encode()),
        line_vector(
            "K: stopped, with a receipt",
            &acknowledge(44, stopped(0x2A5 << 5 | 2)),
        ),
        line_vector("K: the least receipt", &acknowledge(45, stopped(0))),
        line_vector("K: an era", &acknowledge(49, era(5))),
        line_vector("K: the first era", &acknowledge(52, era(0))),
        line_vector("K: the last era", &acknowledge(55, era(ERA_MAX))),
        line_vector(
            "K: the greatest receipt",
            &acknowledge(47, stopped(RECEIPT_MAX)),
        ),
    ]
}

/// STOPs with a receipt, sessions with an era, good and bad.
pub fn frames() -> Vec<Value> {
    let stop = |about: &str, receipt, key| {
        let frame = Message::Stop(Some(receipt)).encode(key);
        frame_vector(about, EAR, frame.as_bytes())
    };
    let mine = Key::robot(EAR.robot_id);
    let bad = |about: &str, content: &[u8]| frame_vector(about, EAR, &sealed(mine, content));
    let open = |about: &str, replaces, owner, era| {
        let open = Message::Open(Open {
            boot: 1,
            replaces,
            owner,
            era: Some(era),
        });
        frame_vector(about, EAR, open.encode(mine).as_bytes())
    };
    let scan = Message::Command(Command {
        sequence: 1,
        order: Order::Scan,
    });
    let scan = |about: &str, sent, heard| {
        let ear = Ear { era: heard, ..EAR };
        frame_vector(about, ear, scan.encode(session().in_era(sent)).as_bytes())
    };
    vec![
        open(
            "open with an era, the first session after a boot",
            0,
            0x2A5,
            0,
        ),
        open("open, everything as large as it gets", 7, 1023, ERA_MAX),
        bad("leading bits in an era", b"O\"*E$``"),
        bad("an era of two characters", b"O\"*E``"),
        scan("a command in era 5", 5, 5),
        scan("in an era of both halves", 0x2A5, 0x2A5),
        scan("in the last era", ERA_MAX, ERA_MAX),
        scan("a command of another era", 4, 5),
        scan("a command without an era", 0, 5),
        stop("STOP with a receipt", 0x2A5 << 5 | 1, mine),
        stop("to every robot", 0x2A5 << 5 | 2, Key::EVERY_ROBOT),
        stop("to another robot", 1, Key::robot(EAR.robot_id + 1)),
        stop("the least receipt", 0, mine),
        stop("the greatest receipt", RECEIPT_MAX, mine),
        bad("leading bits in a receipt", b"X(``"),
        bad("a receipt of two characters", b"X``"),
        bad("a receipt of four characters", b"X````"),
    ]
}
