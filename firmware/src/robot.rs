//! The whole robot. [`Robot::tick`] is its program.

mod autonomy;
mod guards;
mod hiding;
mod layers;
mod lines;
mod shown;
mod uplink;

use crate::angle::Angle;
use crate::arbiter::{self, Holder, MotorGuard, Requests};
use crate::arm::ServoArm;
use crate::behaviours::{ALLOWED_AT_BOOT, BumpSequence, Layers, Passive, SensorSwitches, prowl};
use crate::board::{Identity, Inputs, Outputs, Side};
use crate::cliff::{CliffGuard, Command};
use crate::drive::{Counts, DriveTrain, Motion};
use crate::failsafe::Guard;
use crate::infrared::Infrared;
use crate::odometry::Odometer;
use crate::parameters::{Parameter, Parameters};
use crate::pid::Gains;
use crate::rng::Rng;
use crate::sensors::{Battery, Ranges, Senses, ping_at};
use crate::song::{Song, SongPlayer};
use crate::telemetry::{Events, Schedule, Transmitter};
use autonomy::Autonomy;
use groundwave_protocol::Waypoint;
use groundwave_protocol::arq::Farm;
use groundwave_protocol::receiver::Receiver;
use groundwave_protocol::status_codes::{Layer, LayerMask, Mode};
use groundwave_protocol::telemetry::HOLDERS;

/// Sonar horizon while prowling, inches: the whole range that the sonar can resolve.
const PROWL_HORIZON_IN: u16 = 180;

/// Sonar horizon in modes that do not drive by themselves, inches; nearer obstacles push the robot away.
const REACTIVE_HORIZON_IN: u16 = 48;

/// Sonar horizon on the way to a target, inches: farther walls do not divert the robot.
const ROUTE_HORIZON_IN: u16 = 40;

/// Number of ticks of braking after a stop; from top speed, the wheels stop after two or three.
const BRAKE_TICKS: u8 = 4;

/// Text at the end of the route.
const LIST_FINISHED: &str = "I'm finished with the co-ordinate list";

/// Text when the failsafe acts.
const FAILSAFE_ACTS: &str = "failsafe: the ground is silent";

/// Text when the operator has ended the failsafe.
const FAILSAFE_OVER: &str = "failsafe is over";

/// Texts when an encoder is broken.
const LEFT_MUTE: &str = "left encoder is broken: power and no counts. I stop";
const RIGHT_MUTE: &str = "right encoder is broken: power and no counts. I stop";

/// Text when the robot has come home.
const HOME_REACHED: &str = "I'm home";

/// The robot's program with its complete state.
#[derive(Clone, Debug)]
pub struct Robot {
    identity: Identity,
    parameters: Parameters,
    /// Parameters saved by the board.
    kept: Parameters,
    /// Whether the board must store the parameters.
    must_keep: bool,
    now_ticks: u32,
    mode: Mode,
    /// Mode to which the robot returns after mode Passive.
    mode_before: Mode,
    allowed: LayerMask,
    rng: Rng,

    odometer: Odometer,
    drive: DriveTrain,
    infrared: Infrared,
    ranges: Ranges,
    battery: Battery,
    latest: Inputs,

    layers: Layers,
    switches: SensorSwitches,
    passive: Passive,
    bump_sequence: BumpSequence,
    arm: ServoArm,
    requests: Requests,
    holder: Option<Holder>,
    motion: Motion,
    cliff_guard: CliffGuard,
    /// Guard that controls the motors in place of the holder.
    guarded: Option<MotorGuard>,
    /// With the cliff guard or the critical battery off: ticks until the robot reports it again.
    unguarded_ticks: [u16; 2],
    autonomy: Autonomy,
    song_player: SongPlayer,
    /// Remaining number of ticks of braking after a stop.
    brake_ticks: u8,

    receiver: Receiver,
    farm: Farm,
    guard: Guard,
    /// Number of ticks for which drive frames are accepted without another frame from the ground station.
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
    /// A robot at power-on, with default parameters. It prowls with the layers that are allowed at boot.
    #[must_use]
    pub fn new(identity: Identity) -> Self {
        Self::restored(identity, Parameters::DEFAULT)
    }

    /// A robot at power-on, with the parameters that the board has kept.
    #[must_use]
    pub fn restored(identity: Identity, parameters: Parameters) -> Self {
        Self {
            identity,
            kept: parameters.clone(),
            parameters,
            must_keep: false,
            now_ticks: 0,
            mode: Mode::Prowl,
            mode_before: Mode::Prowl,
            allowed: ALLOWED_AT_BOOT,
            rng: Rng::new(identity.rng_seed),
            odometer: Odometer::default(),
            drive: DriveTrain::default(),
            infrared: Infrared::default(),
            ranges: Ranges::default(),
            battery: Battery::default(),
            latest: Inputs::default(),
            layers: Layers::default(),
            switches: SensorSwitches::default(),
            passive: Passive::default(),
            bump_sequence: BumpSequence::default(),
            arm: ServoArm::default(),
            requests: Requests::default(),
            holder: None,
            motion: Motion::STILL,
            cliff_guard: CliffGuard::default(),
            guarded: None,
            unguarded_ticks: [0; 2],
            autonomy: Autonomy::default(),
            song_player: SongPlayer::default(),
            brake_ticks: 0,
            receiver: Receiver::default(),
            guard: Guard::default(),
            live_ticks: 0,
            farm: Farm::new(identity.robot_id, identity.boots),
            events: Events::default(),
            ticks_won: [0; HOLDERS],
            bumps: 0,
            ticks_late: 0,
            odometer_resets: 0,
            schedule: Schedule::new(identity.restart.text()),
            transmitter: Transmitter::new(identity.duplex),
        }
    }

    /// Runs the program for one tick of 1/20 s, from the sensors to the motors.
    pub fn tick(&mut self, inputs: &Inputs) -> Outputs {
        self.watch_silence();
        self.live_ticks = self.live_ticks.saturating_sub(1);
        self.run_autonomy(inputs);
        let running = self.running();

        // Sensors.
        self.battery.read(inputs);
        let has_sonar = self.allowed().contains(Layer::Sonar);
        if !has_sonar {
            self.ranges = Ranges::default();
        } else if let Some(echo) = inputs.sonar {
            self.ranges.update(echo, self.reach_in());
        }
        let infrared = self
            .infrared
            .tick(self.needs_infrared(running), &self.parameters);
        self.count_bumps(inputs);

        // Odometry.
        let counts = self.drive.measure(inputs);
        self.stop_for_a_mute_encoder();
        self.odometer.fit(&self.parameters);
        self.odometer.advance(counts.left, counts.right);

        // Decisions of all enabled layers.
        let target = self.target();
        let senses = Senses {
            parameters: &self.parameters,
            mode: self.mode,
            target,
            now_ticks: self.now_ticks,
            pose: self.odometer.pose(),
            path_counts: counts.left.saturating_add(counts.right),
            is_standing: self.motion == Motion::STILL && self.drive.is_standing(),
            is_held: self.drive.is_held(),
            turning_cps: self.drive.turning_cps(),
            bumper: inputs.bumper,
            infrared,
            is_confined: target.is_none() && self.infrared.is_confined(),
            sonar: self.ranges,
            photo: inputs.photo_left.zip(inputs.photo_right),
            cliff: inputs.cliff,
            motion: inputs.motion,
            top_hat: inputs.top_hat,
            beacon: inputs.beacon,
            is_docked: inputs.is_docked,
            is_charged: self.autonomy.is_charged(),
            horizon_in: self.horizon_in(target),
            random: self.rng.next_u32(),
        };
        let requests = self.layers.decide(running, &senses);
        self.switches.watch(&senses, running);
        let starts_hiding = self.may_hide() && self.bump_sequence.watch(&senses);

        // The arbiter.
        let winner = arbiter::arbitrate(&requests).filter(|_| self.mode != Mode::Stop);
        self.holder = winner.map(|(holder, _)| holder);
        let motion = winner.map_or(Motion::STILL, |(_, motion)| motion);

        // Guards of the motors: no driving over an edge, and none with the arm raised.
        let by_hand = self.holder == Some(Holder::Layer(Layer::User));
        let command = self.cliff_guard.guard(&senses, counts, motion, by_hand);
        let motion = match command {
            Command::Drive(motion) => motion,
            Command::Brake => Motion::STILL,
        };
        self.motion = self.guard_arm(inputs, motion);
        self.guarded = self.guarded_by(command, motion);

        // Activities that end or begin.
        self.take_arrival();
        self.finish_turns();
        if starts_hiding {
            self.enter(Mode::Passive);
        }

        // PID to pulse widths.
        let (pwm_left, pwm_right) = if self.mode == Mode::Stop {
            self.cliff_guard.rest();
            self.stop_motors(counts)
        } else if command == Command::Brake {
            self.drive.brake(counts)
        } else {
            let gains = Gains::of(&self.parameters);
            self.drive.control(self.motion, counts, &gains)
        };

        // Events for telemetry.
        self.events
            .bumper(inputs.bumper, self.layers.bumpers.is_jammed());
        self.events.infrared(infrared);
        let acts_for = self.cliff_guard.acts_for();
        self.events.cliff(inputs.cliff.map(|now| now.or(acts_for)));
        self.report_guards(inputs);
        self.events.drive(&self.drive);
        let motion = &self.layers.motion;
        self.events.arm(motion.seen(), motion.touched());
        self.events.raised(arbiter::raised(&requests));
        self.count_win();
        self.ticks_late = self.ticks_late.wrapping_add(u16::from(inputs.is_late));

        self.requests = requests;
        self.latest = *inputs;
        self.now_ticks = self.now_ticks.wrapping_add(1);
        Outputs {
            pwm_left,
            pwm_right,
            ping: ping_at(self.now_ticks).filter(|_| has_sonar),
            note_hz: self.song_player.tick(),
            arm_up: self.arm.is_up(),
            keep_parameters: core::mem::take(&mut self.must_keep),
        }
    }

    /// Stops the robot when an encoder is broken: a wheel without counts runs at full power, and no guard knows its speed.
    fn stop_for_a_mute_encoder(&mut self) {
        if let Some(side) = self.drive.mute_side() {
            self.drive.trust_again();
            self.enter(Mode::Stop);
            self.schedule.queue_text(match side {
                Side::Left => LEFT_MUTE,
                Side::Right => RIGHT_MUTE,
            });
        }
    }

    /// Brakes until even the fastest wheels have stopped, then switches the motors off: a faulty encoder must not keep a stopped
    /// robot's motors running.
    fn stop_motors(&mut self, counts: Counts) -> (i16, i16) {
        if self.brake_ticks == 0 {
            self.drive.halt();
            return (0, 0);
        }
        self.brake_ticks -= 1;
        self.drive.brake(counts)
    }

    /// Takes the readings of the infrared detectors for the half cycle that has ended, with the LEDs as the previous call
    /// returned them (off before the first call). Returns whether the LEDs are on in the next one.
    pub fn infrared_sample(&mut self, left: bool, right: bool) -> bool {
        self.infrared.sample(left, right)
    }

    /// Maximum range of the sonars, inches.
    fn reach_in(&self) -> u16 {
        self.parameters.get(Parameter::SonarReach) as u16
    }

    fn horizon_in(&self, target: Option<Waypoint>) -> u16 {
        let horizon_in = match target {
            // Obstacles behind the target are not in the way.
            Some(target) => {
                ROUTE_HORIZON_IN.min(prowl::distance_in(&self.odometer.pose(), target) as u16)
            }
            // Neither sonar nor infrared may turn the robot from its dock.
            None if self.mode == Mode::Forage => 0,
            None if matches!(self.mode, Mode::Prowl | Mode::Wander) => PROWL_HORIZON_IN,
            None => REACTIVE_HORIZON_IN,
        };
        horizon_in.min(self.reach_in())
    }

    /// Enters the failsafe mode if the ground station has been silent for too long.
    fn watch_silence(&mut self) {
        if let Some(mode) = self.guard.tick(self.farm.is_open(), self.mode) {
            self.enter(mode);
            self.schedule.queue_text(FAILSAFE_ACTS);
        }
    }

    /// Ends an active failsafe after a command of the operator.
    fn rearm(&mut self) {
        if self.guard.rearm() {
            self.schedule.queue_text(FAILSAFE_OVER);
        }
    }

    /// Continues with the next point when one has been reached; at the end of the route, stops and sings.
    fn take_arrival(&mut self) {
        let mode = self.mode;
        let list = self.farm.lists().active();
        let Some(is_last) = self.layers.dead_reckoning.take_arrival(mode, list) else {
            return;
        };
        self.schedule.queue_status();
        if is_last {
            self.enter(Mode::Stop);
            let (song, text) = if mode == Mode::GoHome {
                (Song::Home, HOME_REACHED)
            } else {
                (Song::Finished, LIST_FINISHED)
            };
            self.play_song(song);
            self.schedule.queue_text(text);
        }
    }

    fn play_song(&mut self, song: Song) {
        self.song_player.begin(song);
        self.schedule.queue_song(song);
    }

    /// Enters a mode or restarts it, and ends all current activities.
    fn enter(&mut self, mode: Mode) {
        self.song_player.stop();
        let is_new = self.mode != mode;
        if mode == Mode::Stop {
            if is_new {
                self.brake_ticks = BRAKE_TICKS;
            }
            self.drive.halt();
            self.motion = Motion::STILL;
            self.holder = None;
        }
        if is_new {
            self.autonomy.leave(self.mode);
        } else {
            self.autonomy.restart_mode();
        }
        if mode == Mode::Passive {
            self.begin_hiding();
        }
        self.mode = mode;
        self.allow_for(mode);
        self.layers.rest();
        self.schedule.queue_status();
        if mode == Mode::Calibrate {
            self.set_pose(Waypoint { x_in: 0, y_in: 0 }, Angle(0));
        }
    }

    fn set_pose(&mut self, position: Waypoint, heading: Angle) {
        self.odometer.set(position, heading);
        self.layers.bumpers.forget_places();
        self.layers.sonar.forget_heading();
        self.odometer_resets = self.odometer_resets.wrapping_add(1);
        self.events.odometer_reset();
        self.schedule.queue_status();
    }

    fn count_bumps(&mut self, inputs: &Inputs) {
        if inputs.bumper.any() && !self.latest.bumper.any() {
            self.bumps = self.bumps.wrapping_add(1);
        }
    }

    fn count_win(&mut self) {
        let holder = self.holder.filter(|_| self.guarded.is_none());
        let won = holder.map(Holder::place);
        if let Some(ticks) = won.and_then(|place| self.ticks_won.get_mut(place)) {
            *ticks = ticks.wrapping_add(1);
        }
    }
}
