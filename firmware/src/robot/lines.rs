//! Contents of the telemetry lines.

use super::Robot;
use crate::arbiter::Holder;
use crate::board::TICK_HZ;
use crate::parameters::Parameter;
use crate::song::Note;
use crate::telemetry::{Events, Kind};
use crate::units::in_s;
use groundwave_protocol::status_codes::{
    Arm, Bump, Infrared, Layer, LayerMask, LayerState, Mode, Power,
};
use groundwave_protocol::telemetry::{
    self, AbilitiesLine, Body, CountersLine, FirmwareVersion, LayerStates, ListPlace,
    ParameterLine, ParameterName, Printable, SongLine, StateLine, StatusLine, TextLine,
};

/// Version of this program.
const VERSION: FirmwareVersion = FirmwareVersion { major: 0, minor: 1 };

/// Largest coordinate that fits line A, inches.
const POSITION_MAX_TENTHS_IN: u32 = 999_999;

impl Robot {
    /// The next byte for the radio, once per byte time; `None` leaves the carrier idle for this byte time.
    pub fn poll_downlink(&mut self) -> Option<u8> {
        if self.transmitter.wants_line() {
            let kind = self.schedule.next_kind();
            let body = self.compose(kind);
            self.transmitter.begin(&body, self.now_ticks);
        }
        self.transmitter
            .next_byte(self.now_ticks, |sequence| self.farm.ack_in(sequence))
    }

    fn compose(&mut self, kind: Kind) -> Body {
        match kind {
            Kind::State => {
                let events = core::mem::take(&mut self.events);
                Body::State(self.state_line(&events))
            }
            Kind::Status => Body::Status(self.status_line()),
            Kind::Counters => Body::Counters(self.counters_line()),
            Kind::Text(text) => Body::Text(TextLine::new(text)),
            Kind::Findings => {
                let text = self.layers.rotation.panorama().findings().text();
                Body::Text(TextLine::from_bytes(&text))
            }
            Kind::Parameter(parameter) => Body::Parameter(self.parameter_line(parameter)),
            Kind::Song(song) => Body::Song(song_line(song.notes())),
            Kind::Abilities => Body::Abilities(self.abilities_line()),
        }
    }

    fn state_line(&self, events: &Events) -> StateLine {
        let pose = self.odometer.pose();
        let (x_tenths_in, y_tenths_in) = (pose.x_tenths_in(), pose.y_tenths_in());
        let percent = |reading: u8| (u16::from(reading) * 100 / 256) as u8;
        let is_out_of_range =
            x_tenths_in.unsigned_abs().max(y_tenths_in.unsigned_abs()) > POSITION_MAX_TENTHS_IN;
        let fitted = self.fitted();
        let bump = if fitted.contains(Layer::Bumpers) {
            events.bump()
        } else {
            Bump::NotFitted
        };
        let infrared = if fitted.contains(Layer::Infrared) {
            events.infrared_letter(self.infrared.is_jammed())
        } else {
            Infrared::NotFitted
        };
        StateLine {
            x_tenths_in,
            y_tenths_in,
            theta_deg: pose.theta_deg(),
            velocity_in_s: in_s(self.motion.velocity_cps),
            rotation_in_s: in_s(self.motion.rotation_cps),
            wheel_left_in_s: in_s(self.drive.left_cps()),
            wheel_right_in_s: in_s(self.drive.right_cps()),
            sonar_left_in: self.ranges.left_in,
            sonar_right_in: self.ranges.right_in,
            photo_left_pct: self.latest.photo_left.map(percent),
            photo_right_pct: self.latest.photo_right.map(percent),
            bump,
            infrared,
            cliff: events.cliff_letter(),
            arm: self.arm_letter(events),
            drive: events.drive_letter(is_out_of_range),
            power: self.power(),
            link: self.guard.letter(self.farm.is_open()),
            mode: self.mode,
            layers: self.layer_states(events.layers_raised()),
        }
    }

    fn arm_letter(&self, events: &Events) -> Arm {
        if self.latest.motion.is_none() {
            return Arm::NotFitted;
        }
        events.arm_letter(if self.arm.is_stowed() {
            Arm::Stowed
        } else if self.arm.is_up() && self.layers.motion.is_armed() {
            Arm::Armed
        } else {
            Arm::Up
        })
    }

    fn power(&self) -> Power {
        let below =
            |limit| i32::from(self.battery.decivolts()) < i32::from(self.parameters.get(limit));
        if self.latest.is_docked {
            if self.autonomy.is_charged() {
                Power::Docked
            } else {
                Power::Charging
            }
        } else if below(Parameter::CriticalBattery) {
            Power::Critical
        } else if below(Parameter::LowBattery) {
            Power::Low
        } else {
            Power::Ok
        }
    }

    fn layer_states(&self, raised: LayerMask) -> LayerStates {
        let mut running = self.running();
        if self.infrared.is_jammed() {
            running = running.without(Layer::Infrared);
        }
        let mut states = LayerStates::OFF;
        for layer in Layer::ALL {
            let holds = self.guarded.is_none() && self.holder == Some(Holder::Layer(layer));
            let state = if holds {
                LayerState::Holds
            } else if raised.contains(layer) {
                LayerState::Raised
            } else if running.contains(layer) {
                LayerState::Quiet
            } else {
                LayerState::Off
            };
            states.set(layer, state);
        }
        states
    }

    fn status_line(&self) -> StatusLine {
        let lists = self.farm.lists();
        let count = lists.active().len() as u16;
        StatusLine {
            robot_id: self.identity.robot_id,
            battery_dv: u16::from(self.latest.battery_dv),
            target_in: self.target().map(|target| (target.x_in, target.y_in)),
            list: ListPlace {
                driven: self.driven().min(count),
                count,
            },
            digest: lists.active_digest(),
            max_count: self.infrared.max_count(),
            photo_left: self.latest.photo_left,
            photo_right: self.latest.photo_right,
            fitted: self.fitted(),
            allowed: self.allowed(),
            boots: self.identity.boots,
            odometer_resets: self.odometer_resets,
        }
    }

    fn counters_line(&self) -> CountersLine {
        let heard = self.receiver.counters();
        CountersLine {
            robot_id: self.identity.robot_id,
            uptime_s: self.now_ticks / TICK_HZ,
            boots: self.identity.boots,
            version: VERSION,
            ticks_won: self.ticks_won,
            frames_heard: heard.frames,
            frames_rejected: heard.rejected(),
            ticks_late: self.ticks_late,
            bumps: self.bumps,
            failsafe: self.guard.setting(),
        }
    }

    fn abilities_line(&self) -> AbilitiesLine {
        let modes = Mode::ALL.iter().enumerate();
        let fitted = modes.filter(|(_, mode)| self.is_fitted(**mode));
        AbilitiesLine {
            robot_id: self.identity.robot_id,
            modes: fitted.fold(0, |modes, (bit, _)| modes | 1 << bit),
            ..AbilitiesLine::FULL
        }
    }

    fn parameter_line(&self, parameter: Parameter) -> ParameterLine {
        let definition = parameter.definition();
        ParameterLine {
            place: parameter as u8 + 1,
            count: Parameter::ALL.len() as u8,
            name: ParameterName::new(definition.name),
            value: self.parameters.get(parameter).into(),
            kept: self.kept.get(parameter).into(),
            least: definition.least.into(),
            most: definition.most.into(),
            unit: Printable::new(definition.unit),
        }
    }
}

fn song_line(song: &[Note]) -> SongLine {
    let note = |&(hz, ticks): &Note| telemetry::Note { hz, ticks };
    SongLine::new(song.iter().map(note))
}
