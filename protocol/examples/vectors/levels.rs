//! Vectors of robots that implement a part of the protocol.

use super::lines::vector as line_vector;
use super::samples::{acknowledge, state};
use groundwave_protocol::telemetry::{Ack, Body, Detail, Line};
use serde_json::Value;

/// Lines of a robot that cannot hear.
pub fn lines() -> Vec<Value> {
    let cannot_hear = |robot_id| Ack {
        detail: Detail::CannotHear { robot_id },
        ..Ack::default()
    };
    let staging = |tag, window| Ack {
        detail: Detail::Staging {
            first_missing: 79,
            tag,
            window,
        },
        ..Ack::default()
    };
    let line = |sequence, robot_id| {
        let body = Body::State(state());
        Line {
            sequence,
            body,
            ack: cannot_hear(robot_id),
        }
        .encode()
    };
    vec![
        line_vector("A: level 1, robot 7 cannot hear", &line(0, 7)),
        line_vector("A: level 1, robot 99 cannot hear", &line(99, 99)),
        line_vector(
            "K: a set bit above the id is block 79",
            &acknowledge(1, staging(0, 0x80)),
        ),
        line_vector("K: a tag is block 79", &acknowledge(2, staging(1, 0))),
    ]
}
