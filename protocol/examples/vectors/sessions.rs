//! Vectors of receipts. They were added after version 1 was frozen, so they have files of their own.

use super::lines::vector as line_vector;
use super::samples::{ACK, acknowledge, state};
use super::uplink::{EAR, sealed, vector as frame_vector};
use groundwave_protocol::command::{Key, Message, RECEIPT_MAX};
use groundwave_protocol::telemetry::{Ack, Body, Detail, Line};
use serde_json::Value;

/// Acknowledgements with a receipt.
pub fn lines() -> Vec<Value> {
    let stopped = |receipt| Ack {
        detail: Detail::Stopped { receipt },
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
        line_vector(
            "K: the greatest receipt",
            &acknowledge(47, stopped(RECEIPT_MAX)),
        ),
    ]
}

/// STOPs with a receipt, good and bad.
pub fn frames() -> Vec<Value> {
    let stop = |about: &str, receipt, key| {
        let frame = Message::Stop(Some(receipt)).encode(key);
        frame_vector(about, EAR, frame.as_bytes())
    };
    let mine = Key::robot(EAR.robot_id);
    let bad = |about: &str, content: &[u8]| frame_vector(about, EAR, &sealed(mine, content));
    vec![
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
