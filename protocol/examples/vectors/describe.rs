//! Lines, frames and counters as JSON, with the names of SPEC.md.

use groundwave_protocol::command::{Message, Order};
use groundwave_protocol::decoder::{Counters, Received};
use groundwave_protocol::status_codes::{Layer, LayerState, Mode};
use groundwave_protocol::telemetry::{
    AbilitiesLine, Ack, Body, CountersLine, Detail, FieldLine, LayerStates, ParameterLine, Reading,
    SongLine, StateLine, StatusLine,
};
use serde_json::{Value, json};

fn letter(letter: u8) -> String {
    char::from(letter).to_string()
}

fn with(mut object: Value, more: Value) -> Value {
    if let (Value::Object(object), Value::Object(more)) = (&mut object, more) {
        object.extend(more);
    }
    object
}

/// The fields of a line.
pub fn received(received: &Received) -> Value {
    let head = json!({ "sequence": received.sequence(), "ack": ack(*received.ack()) });
    let body = match received {
        Received::Ack(line) => json!({ "type": if line.listens { "G" } else { "K" } }),
        Received::Line(line, _) => match &line.body {
            Body::State(line) => state(line),
            Body::Status(line) => status(line),
            Body::Counters(line) => counters_line(line),
            Body::Text(line) => json!({ "type": "T", "text": line.as_str() }),
            Body::Parameter(line) => parameter(line),
            Body::Song(line) => song(line),
            Body::Abilities(line) => abilities(line),
            Body::Field(line) => field(line),
            Body::Values(line) => {
                json!({ "type": "V", "values": line.values().collect::<Vec<_>>() })
            }
        },
    };
    with(head, body)
}

fn state(line: &StateLine) -> Value {
    json!({
        "type": "A",
        "x_tenths_in": line.x_tenths_in,
        "y_tenths_in": line.y_tenths_in,
        "theta_deg": line.theta_deg,
        "velocity_in_s": line.velocity_in_s,
        "rotation_in_s": line.rotation_in_s,
        "wheel_left_in_s": line.wheel_left_in_s,
        "wheel_right_in_s": line.wheel_right_in_s,
        "sonar_left_in": line.sonar_left_in,
        "sonar_right_in": line.sonar_right_in,
        "photo_left_pct": line.photo_left_pct,
        "photo_right_pct": line.photo_right_pct,
        "bump": letter(line.bump.letter()),
        "infrared": letter(line.infrared.letter()),
        "cliff": letter(line.cliff.letter()),
        "arm": letter(line.arm.letter()),
        "drive": letter(line.drive.letter()),
        "power": letter(line.power.letter()),
        "link": letter(line.link.letter()),
        "mode": letter(line.mode.letter()),
        "layers": layers(line.layers),
    })
}

/// Layers 1 to 7.
fn layers(states: LayerStates) -> Vec<&'static str> {
    let name = |layer| match states.get(layer) {
        LayerState::Off => "off",
        LayerState::Quiet => "quiet",
        LayerState::Raised => "raised",
        LayerState::Holds => "holds",
    };
    Layer::ALL.into_iter().skip(1).map(name).collect()
}

fn status(line: &StatusLine) -> Value {
    json!({
        "type": "B",
        "robot_id": line.robot_id,
        "battery_dv": line.battery_dv,
        "target_in": line.target_in,
        "list_driven": line.list.driven,
        "list_count": line.list.count,
        "digest": line.digest,
        "max_count": line.max_count,
        "photo_left": line.photo_left,
        "photo_right": line.photo_right,
        "fitted": line.fitted.bits(),
        "allowed": line.allowed.bits(),
        "boots": line.boots,
        "odometer_resets": line.odometer_resets,
    })
}

fn counters_line(line: &CountersLine) -> Value {
    json!({
        "type": "C",
        "robot_id": line.robot_id,
        "uptime_s": line.uptime_s,
        "boots": line.boots,
        "version_major": line.version.major,
        "version_minor": line.version.minor,
        "ticks_won": line.ticks_won,
        "frames_heard": line.frames_heard,
        "frames_rejected": line.frames_rejected,
        "ticks_late": line.ticks_late,
        "bumps": line.bumps,
        "failsafe_silence_s": line.failsafe.map(|failsafe| failsafe.silence_s),
        "failsafe_mode": line.failsafe.map(|failsafe| letter(failsafe.mode.letter())),
    })
}

fn parameter(line: &ParameterLine) -> Value {
    json!({
        "type": "P",
        "place": line.place,
        "count": line.count,
        "name": line.name.as_str(),
        "value": line.value,
        "kept": line.kept,
        "least": line.least,
        "most": line.most,
        "unit": line.unit.as_str(),
    })
}

fn song(line: &SongLine) -> Value {
    let notes: Vec<_> = line.notes().map(|note| (note.hz, note.ticks)).collect();
    json!({ "type": "S", "notes": notes })
}

fn abilities(line: &AbilitiesLine) -> Value {
    let modes = Mode::ALL.iter().filter(|mode| line.has_mode(**mode));
    let measured = Reading::ALL
        .iter()
        .filter(|reading| line.measures(**reading));
    json!({
        "type": "I",
        "robot_id": line.robot_id,
        "level": line.level,
        "capacity": line.capacity,
        "modes": modes.map(|mode| char::from(mode.letter())).collect::<String>(),
        "measured": measured.map(|reading| char::from(reading.letter())).collect::<String>(),
        "rate_bytes_per_s": line.rate_bytes_per_s,
        "fields": line.fields,
    })
}

fn field(line: &FieldLine) -> Value {
    json!({
        "type": "F",
        "place": line.place,
        "count": line.count,
        "name": line.name.as_str(),
        "decimals": line.decimals,
        "unit": line.unit.as_str(),
    })
}

/// An acknowledgement.
pub fn ack(ack: Ack) -> Value {
    let detail = match ack.detail {
        Detail::Idle { owner, robot_id } => json!({ "owner": owner, "robot_id": robot_id }),
        Detail::Staging {
            first_missing,
            tag,
            window,
        } => json!({ "first_missing": first_missing, "tag": tag, "window": window }),
        Detail::Era { era } => json!({ "era": era }),
        Detail::Stopped { receipt } => json!({ "receipt": receipt }),
        Detail::CannotHear { robot_id } => json!({ "cannot_hear": true, "robot_id": robot_id }),
    };
    let head = json!({
        "boot": ack.boot,
        "session": ack.session,
        "sequence": ack.sequence,
        "outcome": ack.outcome as u8,
    });
    with(head, detail)
}

/// The counters of a decoder.
pub fn counters(c: &Counters) -> Value {
    json!({
        "bytes": c.bytes,
        "lines": c.lines,
        "ack_lines": c.ack_lines,
        "crc_rejected": c.crc_rejected,
        "shape_rejected": c.shape_rejected,
        "field_rejected": c.field_rejected,
        "lines_lost": c.lines_lost,
        "noise_bytes": c.noise_bytes,
    })
}

/// The fields of a message.
pub fn message(message: &Message) -> Value {
    match message {
        Message::Stop(None) => json!({ "type": "X" }),
        Message::Stop(Some(receipt)) => json!({ "type": "X", "receipt": receipt }),
        Message::Open(open) => {
            let numbers = json!({
                "type": "O",
                "boot": open.boot,
                "replaces": open.replaces,
                "owner": open.owner,
            });
            match open.era {
                Some(era) => with(numbers, json!({ "era": era })),
                None => numbers,
            }
        }
        Message::Command(command) => with(
            json!({ "type": "C", "sequence": command.sequence }),
            order(command.order),
        ),
        Message::Waypoints(slots) => json!({
            "type": "W",
            "tag": slots.tag,
            "first_block": slots.first_block,
            "waypoints": slots.waypoints().iter().map(|w| [w.x_in, w.y_in]).collect::<Vec<_>>(),
        }),
        Message::Drive(drive) => json!({
            "type": "D",
            "velocity_in_s": drive.velocity_in_s,
            "rotation_in_s": drive.rotation_in_s,
            "heard": drive.heard,
            "count": drive.count,
        }),
        Message::Keepalive(keepalive) => json!({ "type": "L", "heard": keepalive.heard }),
    }
}

fn order(order: Order) -> Value {
    match order {
        Order::Mode(mode) => json!({ "order": "M", "mode": letter(mode.letter()) }),
        Order::Layers { which, allowed } => json!({
            "order": "L",
            "which": which.bits(),
            "allowed": allowed.bits(),
        }),
        Order::Failsafe(failsafe) => json!({
            "order": "F",
            "silence_s": failsafe.map_or(0, |failsafe| failsafe.silence_s),
            "mode": letter(failsafe.map_or(Mode::Stop, |failsafe| failsafe.mode).letter()),
        }),
        Order::Pose {
            position,
            theta_deg,
        } => json!({
            "order": "P",
            "x_in": position.x_in,
            "y_in": position.y_in,
            "theta_deg": theta_deg,
        }),
        Order::Scan => json!({ "order": "S" }),
        Order::Activate { tag, count, digest } => json!({
            "order": "A",
            "tag": tag,
            "count": count,
            "digest": digest,
        }),
        Order::SetParameter { key, value } => json!({ "order": "V", "key": key, "value": value }),
        Order::ReadParameter { key } => json!({ "order": "V", "key": key, "value": null }),
        Order::ReadParameters { place } => json!({ "order": "N", "place": place }),
        Order::KeepParameters => json!({ "order": "K" }),
        Order::Unknown => json!({ "order": null }),
    }
}
