//! The robot's receiver: bytes to commands, commands to actions.

use super::Robot;
use crate::angle::Angle;
use crate::drive::Motion;
use crate::parameters::Parameter;
use groundwave_protocol::arq::Action;
use groundwave_protocol::command::{Drive, Message, Order};
use groundwave_protocol::status_codes::{Layer, LayerMask, Mode};
use groundwave_protocol::telemetry::Outcome;

impl Robot {
    /// Takes a byte from the radio. A completed command is executed within this call: the next tick acts on it, and the
    /// next acknowledgement confirms it.
    pub fn handle_uplink(&mut self, byte: u8) {
        self.transmitter.handle_byte(byte);
        let session = self.farm.key();
        let Some(message) = self
            .receiver
            .handle_byte(byte, self.identity.robot_id, session)
        else {
            return;
        };
        self.guard.handle_frame();
        let session = self.farm.key();
        let action = self.farm.handle(&message);
        let is_opened = matches!(message, Message::Open(_)) && self.farm.key() != session;
        if is_opened {
            self.schedule.queue_abilities();
        }
        // Proof that the ground station is present now: it has opened a session, or it names a current line in a
        // keepalive.
        let is_live = match message {
            Message::Open(_) => is_opened,
            Message::Keepalive(keepalive) => self.is_fresh(keepalive.heard),
            _ => false,
        };
        if is_live {
            self.live_ticks = LIVE_TICKS;
        }
        match action {
            Action::Stop => {
                self.rearm();
                self.enter(Mode::Stop);
            }
            Action::Execute(order) => {
                let outcome = self.execute(order);
                self.farm.conclude(outcome);
            }
            Action::ListReplaced => {
                self.layers.dead_reckoning.restart();
                self.schedule.queue_status();
            }
            Action::Drive(drive) => self.drive_by_hand(drive),
            Action::Heard => {}
        }
    }

    fn is_fresh(&self, heard: u8) -> bool {
        let age_ticks = self.transmitter.age_ticks(heard, self.now_ticks);
        age_ticks.is_some_and(|age| age <= HEARD_TICKS_MAX)
    }

    fn execute(&mut self, order: Order) -> Outcome {
        match order {
            Order::Mode(mode) if self.is_fitted(mode) => {
                self.rearm();
                self.enter(mode);
            }
            Order::Layers { which, allowed } if allowed.and(self.fitted()) == allowed => {
                let others = self.allowed.and(LayerMask::from_bits(!which.bits()));
                self.allowed = LayerMask::from_bits(others.bits() | allowed.bits());
                self.schedule.queue_status();
            }
            Order::Pose {
                position,
                theta_deg,
            } => self.set_pose(position, Angle::from_degrees(theta_deg)),
            Order::Failsafe(Some(failsafe)) if !failsafe.is_valid() => return Outcome::BadValue,
            Order::Failsafe(failsafe) if failsafe.is_none_or(|f| self.is_fitted(f.mode)) => {
                self.guard.set(failsafe);
            }
            Order::Scan if !self.fitted().contains(Layer::Rotation) => return Outcome::NotFitted,
            // The robot does not turn by itself in manual driving, while hiding or when stopped.
            Order::Scan
                if matches!(self.mode, Mode::User | Mode::Passive)
                    || !self.running().contains(Layer::Rotation) =>
            {
                return Outcome::NotNow;
            }
            Order::Scan => self.layers.rotation.scan(),
            Order::SetParameter { key, value } => return self.set_parameter(key, value),
            Order::ReadParameter { key } => {
                let Some(parameter) = Parameter::with_key(key) else {
                    return Outcome::Unknown;
                };
                self.schedule.queue_parameter(parameter);
            }
            Order::ReadParameters { place: 0 } => {
                for &parameter in Parameter::ALL {
                    self.schedule.queue_parameter(parameter);
                }
            }
            Order::ReadParameters { place } => {
                let Some(&parameter) = Parameter::ALL.get(usize::from(place) - 1) else {
                    return Outcome::BadValue;
                };
                self.schedule.queue_parameter(parameter);
            }
            Order::KeepParameters => self.keep_parameters(),
            Order::Mode(_) | Order::Layers { .. } | Order::Failsafe(_) => {
                return Outcome::NotFitted;
            }
            // The receiver activates lists itself.
            Order::Activate { .. } | Order::Unknown => return Outcome::Unknown,
        }
        Outcome::Done
    }

    /// Whether all layers that a mode needs are fitted.
    #[must_use]
    pub fn is_fitted(&self, mode: Mode) -> bool {
        match mode {
            Mode::Prowl
            | Mode::Reactive
            | Mode::Stop
            | Mode::User
            | Mode::Wander
            | Mode::GoHome
            | Mode::Calibrate => true,
            Mode::Passive => self.fitted().contains(Layer::Motion),
            Mode::Forage => self.latest.beacon.is_some(),
        }
    }

    /// Sets a parameter. The result is reported even if it is refused, because the ground station may not know the limits.
    fn set_parameter(&mut self, key: u32, value: i32) -> Outcome {
        let Some(parameter) = Parameter::with_key(key) else {
            return Outcome::Unknown;
        };
        self.schedule.queue_parameter(parameter);
        let is_set = i16::try_from(value).is_ok_and(|value| self.parameters.set(parameter, value));
        if is_set {
            Outcome::Done
        } else {
            Outcome::BadValue
        }
    }

    /// Makes the board store the parameters after the next tick.
    fn keep_parameters(&mut self) {
        for &parameter in Parameter::ALL {
            if self.kept.get(parameter) != self.parameters.get(parameter) {
                self.schedule.queue_parameter(parameter);
            }
        }
        self.kept = self.parameters.clone();
        self.must_keep = true;
    }

    /// Takes a drive frame. A delayed frame must not move the robot. In mode stop no frame moves it, because
    /// its layers are reset and drop drive frames.
    fn drive_by_hand(&mut self, drive: Drive) {
        if self.is_fresh(drive.heard) && self.live_ticks > 0 && !self.guard.acts() {
            self.farm.take_drive(&drive);
            self.live_ticks = LIVE_TICKS;
            self.layers.user.drive(Motion::new(
                i16::from(drive.velocity_in_s),
                i16::from(drive.rotation_in_s),
            ));
        }
    }
}

/// Number of ticks for which drive frames are accepted after the ground station has proved that it is present. Line numbers
/// repeat after a hundred: a burst of drive frames that a bridge delayed by half a minute names lines that look
/// current, but no such proof precedes it.
const LIVE_TICKS: u8 = 40;

/// Maximum age in ticks of the line that a drive frame names: a long line takes a third of a second, and the newest one
/// may be half a second old.
const HEARD_TICKS_MAX: u8 = 24;
