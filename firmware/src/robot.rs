//! The whole robot. [`Robot::tick`] is its program.

mod lines;
mod uplink;

use crate::angle::Angle;
use crate::arbiter::{self, Holder};
use crate::behaviours::{FITTED, Layers, prowl};
use crate::board::{Identity, Inputs, Outputs};
use crate::dice::Dice;
use crate::drive::{DriveTrain, Motion};
use crate::failsafe::Guard;
use crate::infrared::Infrared;
use crate::odometry::{Odometer, Pose};
use crate::parameters::Parameters;
use crate::sensors::{Battery, Ranges, Senses, ping_at};
use crate::song::{self, Note, Singer};
use crate::telemetry::{Events, Schedule, Transmitter};
use groundwave_protocol::Waypoint;
use groundwave_protocol::arq::{Farm, Lists};
use groundwave_protocol::letters::{Layer, LayerMask, Mode};
use groundwave_protocol::receiver::Receiver;
use groundwave_protocol::telemetry::{Ack, HOLDERS};

/// Sonar looks this far ahead while the robot prowls: all it can tell apart.
const PROWL_HORIZON_IN: u16 = 180;

/// Sonar looks this far ahead while nothing drives the robot on: what is nearer pushes it away.
const REACTIVE_HORIZON_IN: u16 = 48;

/// Sonar looks this far ahead on the way to a target: farther walls are no reason to leave the way.
const ROUTE_HORIZON_IN: u16 = 40;

/// What the robot says at the end of its list.
const LIST_FINISHED: &str = "I'm finished with the co-ordinate list";

/// What it says when the ground has been silent for too long.
const FAILSAFE_ACTS: &str = "failsafe: the ground is silent";

/// What it says when the operator has taken over again.
const FAILSAFE_OVER: &str = "failsafe is over";

/// What it says when it has come home.
const HOME_REACHED: &str = "I'm home";

/// The robot's program and everything it remembers.
#[derive(Clone, Debug)]
pub struct Robot {
    identity: Identity,
    parameters: Parameters,
    /// What a reset brings back.
    kept: Parameters,
    /// The board has to write them.
    must_keep: bool,
    now_ticks: u32,
    mode: Mode,
    allowed: LayerMask,
    dice: Dice,

    odometer: Odometer,
    drive: DriveTrain,
    infrared: Infrared,
    ranges: Ranges,
    battery: Battery,
    latest: Inputs,

    layers: Layers,
    holder: Option<Holder>,
    motion: Motion,
    singer: Singer,

    receiver: Receiver,
    farm: Farm,
    guard: Guard,
    /// How long drive frames are obeyed without another sign of the ground.
    live_ticks: u8,

    events: Events,
    ticks_won: [u16; HOLDERS],
    bumps: u16,
    ticks_late: u16,
    odometer_resets: u8,
    schedule: Schedule,
    transmitter: Transmitter,
}

impl Robot {
    /// A robot that has just been switched on. It prowls, with every layer it has.
    #[must_use]
    pub fn new(identity: Identity) -> Self {
        Self::restored(identity, Parameters::DEFAULT)
    }

    /// The same, with the parameters that the board has kept.
    #[must_use]
    pub fn restored(identity: Identity, parameters: Parameters) -> Self {
        Self {
            identity,
            kept: parameters.clone(),
            parameters,
            must_keep: false,
            now_ticks: 0,
            mode: Mode::Prowl,
            allowed: FITTED,
            dice: Dice::new(identity.dice_seed),
            odometer: Odometer::default(),
            drive: DriveTrain::default(),
            infrared: Infrared::default(),
            ranges: Ranges::default(),
            battery: Battery::default(),
            latest: Inputs::default(),
            layers: Layers::default(),
            holder: None,
            motion: Motion::STILL,
            singer: Singer::default(),
            receiver: Receiver::default(),
            guard: Guard::default(),
            live_ticks: 0,
            farm: Farm::new(identity.robot_id, identity.boots),
            events: Events::default(),
            ticks_won: [0; HOLDERS],
            bumps: 0,
            ticks_late: 0,
            odometer_resets: 0,
            schedule: Schedule::default(),
            transmitter: Transmitter::new(identity.duplex),
        }
    }

    /// The program: once every twentieth of a second, from the sensors to the motors.
    pub fn tick(&mut self, inputs: &Inputs) -> Outputs {
        self.watch_silence();
        self.live_ticks = self.live_ticks.saturating_sub(1);
        let enabled = self.enabled();

        // Sensors.
        self.battery.read(inputs);
        if !self.allowed.contains(Layer::Sonar) {
            self.ranges = Ranges::default();
        } else if let Some(echo) = inputs.sonar {
            self.ranges.hear(echo);
        }
        let infrared = self.infrared.tick(enabled.contains(Layer::Infrared));
        self.count_bumps(inputs);

        // Odometry.
        let counts = self.drive.measure(inputs);
        self.odometer.advance(counts.left, counts.right);

        // Every enabled layer in turn.
        let target = self.target();
        let senses = Senses {
            parameters: &self.parameters,
            mode: self.mode,
            target,
            now_ticks: self.now_ticks,
            pose: self.odometer.pose(),
            way_counts: counts.left.saturating_add(counts.right),
            turning_cps: self.drive.turning_cps(),
            bumper: inputs.bumper,
            infrared,
            sonar: self.ranges,
            photo: inputs.photo_left.zip(inputs.photo_right),
            cliff: inputs.cliff.unwrap_or_default(),
            motion: inputs.motion,
            top_hat: inputs.top_hat,
            beacon: inputs.beacon,
            is_docked: inputs.is_docked,
            horizon_in: self.horizon_in(target),
            dice: self.dice.roll(),
        };
        let requests = self.layers.decide(enabled, &senses);
        self.take_arrival();

        // The arbiter.
        let winner = arbiter::arbitrate(&requests).filter(|_| self.mode != Mode::Stop);
        self.holder = winner.map(|(holder, _)| holder);
        self.motion = winner.map_or(Motion::STILL, |(_, motion)| motion);

        // PID to pulse widths.
        let (pwm_left, pwm_right) = if self.mode == Mode::Stop {
            self.drive.halt();
            (0, 0)
        } else {
            self.drive.control(self.motion, counts)
        };

        // What telemetry will tell.
        self.events
            .bumper(inputs.bumper, self.layers.bumpers.is_jammed());
        self.events.infrared(infrared);
        self.events.drive(&self.drive);
        self.events.raised(arbiter::raised(&requests));
        self.count_win();
        self.ticks_late = self.ticks_late.wrapping_add(u16::from(inputs.is_late));

        self.latest = *inputs;
        self.now_ticks = self.now_ticks.wrapping_add(1);
        Outputs {
            pwm_left,
            pwm_right,
            ping: ping_at(self.now_ticks).filter(|_| self.allowed.contains(Layer::Sonar)),
            note_hz: self.singer.tick(),
            arm_up: false,
            keep_parameters: core::mem::take(&mut self.must_keep),
        }
    }

    /// Takes what the infrared detectors read during the half cycle that just ended, with the LEDs as
    /// the previous call returned them (off before the first). Returns whether the LEDs are on next.
    pub fn infrared_look(&mut self, left: bool, right: bool) -> bool {
        self.infrared.look(left, right)
    }

    /// The layers that run in this mode.
    fn enabled(&self) -> LayerMask {
        let allowed = self.allowed.and(FITTED);
        match self.mode {
            Mode::Stop => LayerMask::NONE,
            Mode::Prowl | Mode::GoHome => allowed,
            _ => allowed.without(Layer::DeadReckoning),
        }
    }

    fn horizon_in(&self, target: Option<Waypoint>) -> u16 {
        match target {
            // What stands behind the target is not in the way.
            Some(target) => {
                ROUTE_HORIZON_IN.min(prowl::distance_in(&self.odometer.pose(), target) as u16)
            }
            None if self.mode == Mode::Prowl => PROWL_HORIZON_IN,
            None => REACTIVE_HORIZON_IN,
        }
    }

    /// A ground that has commanded and fallen silent may have left instructions.
    fn watch_silence(&mut self) {
        if let Some(mode) = self.guard.tick(self.farm.is_open(), self.mode) {
            self.enter(mode);
            self.schedule.say(FAILSAFE_ACTS);
        }
    }

    /// The operator commands: a failsafe that acted is over.
    fn rearm(&mut self) {
        if self.guard.rearm() {
            self.schedule.say(FAILSAFE_OVER);
        }
    }

    /// The next point of the list when one has been reached; at its end, stop and sing.
    fn take_arrival(&mut self) {
        let mode = self.mode;
        let list = self.farm.lists().active();
        let Some(is_last) = self.layers.dead_reckoning.take_arrival(mode, list) else {
            return;
        };
        self.schedule.status_changed();
        if is_last {
            self.enter(Mode::Stop);
            self.sing(song::FINISHED);
            self.schedule.say(if mode == Mode::GoHome {
                HOME_REACHED
            } else {
                LIST_FINISHED
            });
        }
    }

    fn sing(&mut self, song: &'static [Note]) {
        self.singer.begin(song);
        self.schedule.sing(song);
    }

    /// Enters a mode; whatever was under way in another one is forgotten.
    fn enter(&mut self, mode: Mode) {
        self.singer.hush();
        if mode == Mode::Stop {
            self.drive.halt();
            self.motion = Motion::STILL;
            self.holder = None;
        }
        if self.mode != mode {
            self.mode = mode;
            self.layers.rest();
            self.schedule.status_changed();
        }
    }

    fn set_pose(&mut self, position: Waypoint, heading: Angle) {
        self.odometer.set(position, heading);
        self.layers.bumpers.forget_places();
        self.odometer_resets = self.odometer_resets.wrapping_add(1);
        self.events.odometer_reset();
        self.schedule.status_changed();
    }

    fn count_bumps(&mut self, inputs: &Inputs) {
        if inputs.bumper.any() && !self.latest.bumper.any() {
            self.bumps = self.bumps.wrapping_add(1);
        }
    }

    fn count_win(&mut self) {
        let won = self.holder.map(Holder::place);
        if let Some(ticks) = won.and_then(|place| self.ticks_won.get_mut(place)) {
            *ticks = ticks.wrapping_add(1);
        }
    }

    /// What the robot has been told to do.
    #[must_use]
    pub const fn mode(&self) -> Mode {
        self.mode
    }

    /// Where it believes to be.
    #[must_use]
    pub const fn pose(&self) -> Pose {
        self.odometer.pose()
    }

    /// Who holds the motors; `None` while they are off.
    #[must_use]
    pub const fn holder(&self) -> Option<Holder> {
        self.holder
    }

    /// The motion that the holder asked for.
    #[must_use]
    pub const fn motion(&self) -> Motion {
        self.motion
    }

    /// The point being driven to.
    #[must_use]
    pub fn target(&self) -> Option<Waypoint> {
        let list = self.farm.lists().active();
        let enabled = self.enabled().contains(Layer::DeadReckoning);
        self.layers
            .dead_reckoning
            .target(self.mode, list)
            .filter(|_| enabled)
    }

    /// What the operator may tune, as it is now.
    #[must_use]
    pub const fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// Both waypoint banks.
    #[must_use]
    pub const fn lists(&self) -> &Lists {
        self.farm.lists()
    }

    /// Points of the active list that have been reached.
    #[must_use]
    pub const fn driven(&self) -> u16 {
        self.layers.dead_reckoning.driven()
    }

    /// Layers that the operator allows, among those fitted.
    #[must_use]
    pub const fn allowed(&self) -> LayerMask {
        self.allowed
    }

    /// What the acknowledgement says at this moment.
    #[must_use]
    pub fn ack(&self) -> Ack {
        self.farm.ack()
    }

    /// The infrared detectors.
    #[must_use]
    pub const fn infrared(&self) -> &Infrared {
        &self.infrared
    }

    /// Whether it ought to get somewhere: in these modes standing about is being stuck.
    #[must_use]
    pub fn is_told_to_move(&self) -> bool {
        matches!(self.mode, Mode::Prowl | Mode::GoHome) || self.motion != Motion::STILL
    }
}
