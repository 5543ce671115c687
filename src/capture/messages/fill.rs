//! What a line of the robot says, field by field.

use groundwave_protocol::decoder::Received;
use groundwave_protocol::letters::{
    Arm, Bump, Cliff, Drive, Infrared, Layer, LayerState, Link, Mode, Power,
};
use groundwave_protocol::telemetry::{
    Ack, Body, CountersLine, Detail, Note, ParameterLine, SongLine, StateLine, StatusLine, TextLine,
};

use super::Telemetry;

impl From<&Received> for Telemetry {
    fn from(received: &Received) -> Self {
        let mut message = Self {
            sequence: Some(received.sequence().into()),
            ..Self::default()
        };
        message.set_ack(*received.ack());
        message.line_type = Some(match received {
            Received::Ack(_) => 4,
            Received::Line(line, _) => match &line.body {
                Body::State(state) => {
                    message.set_state(state);
                    0
                }
                Body::Status(status) => {
                    message.set_status(status);
                    1
                }
                Body::Counters(counters) => {
                    message.set_counters(counters);
                    2
                }
                Body::Text(text) => {
                    message.set_text(text);
                    3
                }
                Body::Parameter(parameter) => {
                    message.set_parameter(parameter);
                    5
                }
                Body::Song(song) => {
                    message.song = Some(notes(song));
                    6
                }
            },
        });
        message
    }
}

impl Telemetry {
    fn set_ack(&mut self, ack: Ack) {
        self.ack_boot = Some(ack.boot.into());
        self.ack_session = Some(ack.session.into());
        self.ack_sequence = Some(ack.sequence.into());
        self.ack_outcome = Some(ack.outcome as i32);
        match ack.detail {
            Detail::Idle { owner, robot_id } => {
                self.ack_owner = Some(owner.into());
                self.ack_robot_id = Some(robot_id.into());
            }
            Detail::Staging {
                first_missing,
                tag,
                window,
            } => {
                self.ack_list_tag = Some(tag.into());
                self.ack_first_missing_block = Some(first_missing.into());
                self.ack_window_bits = Some(window.into());
            }
        }
    }

    fn set_state(&mut self, line: &StateLine) {
        self.x_in = Some(f64::from(line.x_tenths_in) / 10.0);
        self.y_in = Some(f64::from(line.y_tenths_in) / 10.0);
        self.theta_deg = Some(line.theta_deg.into());
        self.velocity_in_s = Some(line.velocity_in_s.into());
        self.rotation_in_s = Some(line.rotation_in_s.into());
        self.wheel_left_in_s = Some(line.wheel_left_in_s.into());
        self.wheel_right_in_s = Some(line.wheel_right_in_s.into());
        self.sonar_left_in = line.sonar_left_in.map(u32::from);
        self.sonar_right_in = line.sonar_right_in.map(u32::from);
        self.photo_left_pct = line.photo_left_pct.map(u32::from);
        self.photo_right_pct = line.photo_right_pct.map(u32::from);
        self.bump = number(Bump::ALL, line.bump);
        self.infrared = number(Infrared::ALL, line.infrared);
        self.cliff = number(Cliff::ALL, line.cliff);
        self.arm = number(Arm::ALL, line.arm);
        self.drive = number(Drive::ALL, line.drive);
        self.power = number(Power::ALL, line.power);
        self.link = number(Link::ALL, line.link);
        self.mode = number(Mode::ALL, line.mode);
        let layer = |layer| number(LayerState::ALL, line.layers.get(layer));
        self.layer_bumpers = layer(Layer::Bumpers);
        self.layer_rotation = layer(Layer::Rotation);
        self.layer_infrared = layer(Layer::Infrared);
        self.layer_sonar = layer(Layer::Sonar);
        self.layer_photo = layer(Layer::Photo);
        self.layer_motion = layer(Layer::Motion);
        self.layer_dead_reckoning = layer(Layer::DeadReckoning);
        self.holder = line.layers.holder().map(|layer| layer as i32);
    }

    fn set_status(&mut self, line: &StatusLine) {
        self.robot_id = Some(line.robot_id.into());
        self.battery_v = Some(f64::from(line.battery_dv) / 10.0);
        self.target_x_in = line.target_in.map(|(x_in, _)| x_in.into());
        self.target_y_in = line.target_in.map(|(_, y_in)| y_in.into());
        self.waypoints_driven = Some(line.list.driven.into());
        self.waypoints_count = Some(line.list.count.into());
        self.list_digest = Some(line.digest);
        self.max_count = Some(line.max_count.into());
        self.photo_left_raw = line.photo_left.map(u32::from);
        self.photo_right_raw = line.photo_right.map(u32::from);
        self.layers_fitted_bits = Some(line.fitted.bits().into());
        self.layers_allowed_bits = Some(line.allowed.bits().into());
        self.boots = Some(line.boots.into());
        self.odometer_resets = Some(line.odometer_resets.into());
    }

    fn set_counters(&mut self, line: &CountersLine) {
        self.robot_id = Some(line.robot_id.into());
        self.uptime_s = Some(line.uptime_s);
        self.boots = Some(line.boots.into());
        self.firmware_major = Some(line.version.major.into());
        self.firmware_minor = Some(line.version.minor.into());
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
        self.ticks_won_user = user;
        self.ticks_won_bumpers = bumpers;
        self.ticks_won_rotation = rotation;
        self.ticks_won_infrared = infrared;
        self.ticks_won_sonar = sonar;
        self.ticks_won_photo = photo;
        self.ticks_won_motion = motion;
        self.ticks_won_dead_reckoning = route;
        self.ticks_won_prowl = prowl;
        self.frames_heard = Some(line.frames_heard.into());
        self.frames_rejected = Some(line.frames_rejected.into());
        self.ticks_late = Some(line.ticks_late.into());
        self.bumps = Some(line.bumps.into());
        self.failsafe_silence_s = line.failsafe.map(|failsafe| failsafe.silence_s.into());
        self.failsafe_mode = line
            .failsafe
            .and_then(|failsafe| number(Mode::ALL, failsafe.mode));
    }

    fn set_text(&mut self, line: &TextLine) {
        self.text = Some(line.as_str().to_owned());
    }

    fn set_parameter(&mut self, line: &ParameterLine) {
        self.parameter_place = Some(line.place.into());
        self.parameter_count = Some(line.count.into());
        self.parameter_name = Some(line.name.as_str().to_owned());
        self.parameter_value = Some(line.value);
        self.parameter_kept = Some(line.kept);
        self.parameter_least = Some(line.least);
        self.parameter_most = Some(line.most);
        self.parameter_unit = Some(line.unit.as_str().to_owned());
    }
}

/// `523:0.20 0:0.10`. A tick is five hundredths of a second, so two decimals are exact.
fn notes(song: &SongLine) -> String {
    let note = |note: Note| {
        let hundredths = u32::from(note.ticks) * 5;
        format!("{}:{}.{:02}", note.hz, hundredths / 100, hundredths % 100)
    };
    song.notes().map(note).collect::<Vec<_>>().join(" ")
}

/// A state's number in protobuf is its place in the wire's list of states.
fn number<T: Copy + PartialEq>(all: &[T], state: T) -> Option<i32> {
    all.iter().position(|s| *s == state).map(|i| i as i32)
}
