//! Converts a line of the robot to the fields of a message.

use groundwave_protocol::decoder::Received;
use groundwave_protocol::status_codes::{
    Arm, Bump, Cliff, Drive, Infrared, Layer, LayerState, Link, Mode, Power,
};
use groundwave_protocol::telemetry::{
    AbilitiesLine, Ack, AckLine, Body, CountersLine, Detail, Note, ParameterLine, Reading,
    SongLine, StateLine, StatusLine,
};

use super::{LINE_TYPES, Telemetry};

/// Place of a line's type in [`LINE_TYPES`].
pub(crate) fn line_type(received: &Received) -> Option<usize> {
    let letter = match received {
        Received::Ack(_) => AckLine::LETTERS[0],
        Received::Line(line, _) => line.body.line_type().letter(),
    };
    let is_it = |word: &&str| word.as_bytes() == [letter];
    LINE_TYPES.iter().position(is_it)
}

/// Fills the fields that a line contains.
pub(super) fn fill(received: &Received, to: &mut Telemetry) {
    to.line_type = line_type(received).map(|place| place as i32);
    to.sequence = Some(received.sequence().into());
    fill_ack(to, *received.ack());
    if let Received::Line(line, _) = received {
        match &line.body {
            Body::State(state) => fill_state(to, state),
            Body::Status(status) => fill_status(to, status),
            Body::Counters(counters) => fill_counters(to, counters),
            Body::Text(text) => to.text = Some(text.as_str().to_owned()),
            Body::Parameter(parameter) => fill_parameter(to, parameter),
            Body::Song(song) => to.song = Some(notes(song)),
            Body::Abilities(abilities) => fill_abilities(to, abilities),
            // The values are separate messages.
            Body::Field(_) | Body::Values(_) => {}
        }
    }
}

fn fill_ack(to: &mut Telemetry, ack: Ack) {
    to.ack_boot = Some(ack.boot.into());
    to.ack_session = Some(ack.session.into());
    to.ack_sequence = Some(ack.sequence.into());
    to.ack_outcome = Some(ack.outcome as i32);
    match ack.detail {
        Detail::Idle { owner, robot_id } => {
            to.ack_owner = Some(owner.into());
            to.ack_robot_id = Some(robot_id.into());
        }
        Detail::Staging {
            first_missing,
            tag,
            window,
        } => {
            to.ack_first_missing_block = Some(first_missing.into());
            to.ack_window_bits = Some(window.into());
            to.ack_list_tag = Some(tag.into());
        }
        Detail::Era { .. } => {}
        Detail::Stopped { .. } => to.ack_owner = Some(0),
        Detail::CannotHear { robot_id } => to.ack_robot_id = Some(robot_id.into()),
    }
}

fn fill_abilities(to: &mut Telemetry, line: &AbilitiesLine) {
    let modes = Mode::ALL.iter().filter(|mode| line.has_mode(**mode));
    let measured = Reading::ALL
        .iter()
        .filter(|reading| line.measures(**reading));
    to.robot_id = Some(line.robot_id.into());
    to.level = Some(line.level.into());
    to.list_capacity = Some(line.capacity.into());
    to.modes_fitted = Some(modes.map(|mode| char::from(mode.letter())).collect());
    to.measured = Some(measured.map(|it| char::from(it.letter())).collect());
    to.rate_bytes_per_s = Some(line.rate_bytes_per_s);
    to.own_fields = Some(line.fields.into());
}

fn fill_state(to: &mut Telemetry, line: &StateLine) {
    to.x_in = Some(f64::from(line.x_tenths_in) / 10.0);
    to.y_in = Some(f64::from(line.y_tenths_in) / 10.0);
    to.theta_deg = Some(line.theta_deg.into());
    to.velocity_in_s = Some(line.velocity_in_s.into());
    to.rotation_in_s = Some(line.rotation_in_s.into());
    to.wheel_left_in_s = Some(line.wheel_left_in_s.into());
    to.wheel_right_in_s = Some(line.wheel_right_in_s.into());
    to.sonar_left_in = line.sonar_left_in.map(u32::from);
    to.sonar_right_in = line.sonar_right_in.map(u32::from);
    to.photo_left_pct = line.photo_left_pct.map(u32::from);
    to.photo_right_pct = line.photo_right_pct.map(u32::from);
    to.bump = number(Bump::ALL, line.bump);
    to.infrared = number(Infrared::ALL, line.infrared);
    to.cliff = number(Cliff::ALL, line.cliff);
    to.arm = number(Arm::ALL, line.arm);
    to.drive = number(Drive::ALL, line.drive);
    to.power = number(Power::ALL, line.power);
    to.link = number(Link::ALL, line.link);
    to.mode = number(Mode::ALL, line.mode);
    let layer = |layer| number(LayerState::ALL, line.layers.get(layer));
    to.layer_bumpers = layer(Layer::Bumpers);
    to.layer_rotation = layer(Layer::Rotation);
    to.layer_infrared = layer(Layer::Infrared);
    to.layer_sonar = layer(Layer::Sonar);
    to.layer_photo = layer(Layer::Photo);
    to.layer_motion = layer(Layer::Motion);
    to.layer_dead_reckoning = layer(Layer::DeadReckoning);
    to.holder = line.layers.holder().map(|layer| layer as i32);
}

fn fill_status(to: &mut Telemetry, line: &StatusLine) {
    to.robot_id = Some(line.robot_id.into());
    to.battery_v = Some(f64::from(line.battery_dv) / 10.0);
    to.target_x_in = line.target_in.map(|(x_in, _)| x_in.into());
    to.target_y_in = line.target_in.map(|(_, y_in)| y_in.into());
    to.waypoints_driven = Some(line.list.driven.into());
    to.waypoints_count = Some(line.list.count.into());
    to.list_digest = Some(line.digest);
    to.max_count = Some(line.max_count.into());
    to.photo_left_raw = line.photo_left.map(u32::from);
    to.photo_right_raw = line.photo_right.map(u32::from);
    to.layers_fitted_bits = Some(line.fitted.bits().into());
    to.layers_allowed_bits = Some(line.allowed.bits().into());
    to.boots = Some(line.boots.into());
    to.odometer_resets = Some(line.odometer_resets.into());
}

fn fill_counters(to: &mut Telemetry, line: &CountersLine) {
    to.robot_id = Some(line.robot_id.into());
    to.boots = Some(line.boots.into());
    to.uptime_s = Some(line.uptime_s);
    to.firmware_major = Some(line.version.major.into());
    to.firmware_minor = Some(line.version.minor.into());
    let [
        user,
        bumpers,
        rotation,
        infrared,
        sonar,
        photo,
        motion,
        route,
        prowl,
    ] = line.ticks_won.map(|ticks| Some(ticks.into()));
    to.ticks_won_user = user;
    to.ticks_won_bumpers = bumpers;
    to.ticks_won_rotation = rotation;
    to.ticks_won_infrared = infrared;
    to.ticks_won_sonar = sonar;
    to.ticks_won_photo = photo;
    to.ticks_won_motion = motion;
    to.ticks_won_dead_reckoning = route;
    to.ticks_won_prowl = prowl;
    to.frames_heard = Some(line.frames_heard.into());
    to.frames_rejected = Some(line.frames_rejected.into());
    to.ticks_late = Some(line.ticks_late.into());
    to.bumps = Some(line.bumps.into());
    to.failsafe_silence_s = line.failsafe.map(|failsafe| failsafe.silence_s.into());
    to.failsafe_mode = line
        .failsafe
        .and_then(|failsafe| number(Mode::ALL, failsafe.mode));
}

fn fill_parameter(to: &mut Telemetry, line: &ParameterLine) {
    to.parameter_place = Some(line.place.into());
    to.parameter_count = Some(line.count.into());
    to.parameter_name = Some(line.name.as_str().to_owned());
    to.parameter_value = Some(line.value);
    to.parameter_kept = Some(line.kept);
    to.parameter_least = Some(line.least);
    to.parameter_most = Some(line.most);
    to.parameter_unit = Some(line.unit.as_str().to_owned());
}

/// Notes of a song as text: `523:0.20 0:0.10`. A tick is 0.05 s, so two decimals are exact.
fn notes(song: &SongLine) -> String {
    let note = |note: Note| {
        let hundredths = u32::from(note.ticks) * 5;
        format!("{}:{}.{:02}", note.hz, hundredths / 100, hundredths % 100)
    };
    song.notes().map(note).collect::<Vec<_>>().join(" ")
}

/// A state's number in protobuf: its index in the protocol's list of states.
fn number<T: Copy + PartialEq>(all: &[T], state: T) -> Option<i32> {
    all.iter().position(|s| *s == state).map(|i| i as i32)
}
