//! Decisions of the robot about its own mode: the end of wandering, the call for the operator or the drive to the dock with a low
//! battery, and the mode after docking and after the calibration square.

use super::Robot;
use crate::behaviours::DockingEvent;
use crate::board::{Inputs, TICK_HZ};
use crate::parameters::Parameter;
use crate::song::Song;
use groundwave_protocol::status_codes::{Layer, LayerMask, Mode};

/// Text at the end of wandering.
const WANDERED: &str = "I have wandered long enough: going home";

/// Text when the battery is low.
const BATTERY_LOW: &str = "my battery is low: please charge me";

/// Text when the battery must not be drained further.
const BATTERY_CRITICAL: &str = "my battery is nearly empty: I stop here, please charge me";

/// Text when a low battery sends the robot to its dock.
const TO_THE_DOCK: &str = "my battery is low: going to my dock";

/// Text on the dock.
const ON_THE_DOCK: &str = "I'm on my dock";

/// Text when the robot leaves the dock.
const CHARGED: &str = "I'm charged";

/// Text at the end of the calibration square.
const SQUARE_DRIVEN: &str = "the square is driven: measure where I am";

/// Text when a contact has ended the square early.
const SQUARE_ENDED: &str = "the square is spoilt: I touched something";

/// Number of ticks between two calls while the battery stays low.
const CALL_TICKS: u16 = 300 * TICK_HZ as u16;

/// Rise above a limit, in tenths of a volt, at which the battery counts as recovered: its voltage rises at rest.
const RECOVERED_DV: i32 = 6;

/// Number of ticks without a rise of the voltage after which a charging battery is full: it rises by a tenth of a volt in a
/// quarter of an hour until the charger limits it, and then takes less and less current.
const FULL_TICKS: u16 = 2700 * TICK_HZ as u16;

/// State of these decisions.
#[derive(Clone, Debug)]
pub(super) struct Autonomy {
    wandered_ticks: u32,
    /// Number of ticks until the next call; `None` while the battery is not low.
    call_ticks: Option<u16>,
    /// Whether the robot has stopped for a critical battery; later commands of the operator are obeyed.
    has_stopped: bool,
    /// While charging: highest voltage so far, and the ticks since it was reached.
    peak_dv: u16,
    level_ticks: u16,
    /// Mode before the drive to the dock.
    resume: Mode,
}

impl Default for Autonomy {
    fn default() -> Self {
        Self {
            wandered_ticks: 0,
            call_ticks: None,
            has_stopped: false,
            peak_dv: 0,
            level_ticks: 0,
            resume: Mode::Stop,
        }
    }
}

impl Autonomy {
    /// Whether the battery is charged.
    pub(super) const fn is_charged(&self) -> bool {
        self.level_ticks >= FULL_TICKS
    }

    /// Handles a restart of the same mode.
    pub(super) const fn restart_mode(&mut self) {
        self.wandered_ticks = 0;
    }

    /// Handles the change from `mode` to another one.
    pub(super) const fn leave(&mut self, mode: Mode) {
        self.restart_mode();
        // A square that was ended early is not driven again.
        self.resume = if matches!(mode, Mode::Calibrate) {
            Mode::Stop
        } else {
            mode
        };
    }
}

impl Robot {
    /// Runs at the start of a tick.
    pub(super) fn run_autonomy(&mut self, inputs: &Inputs) {
        self.watch_battery(inputs);
        self.watch_critical_battery(inputs);
        match self.mode {
            Mode::Wander => self.step_wander(),
            Mode::Forage => self.step_forage(),
            Mode::Calibrate => self.step_calibrate(inputs),
            _ => {}
        }
    }

    fn watch_battery(&mut self, inputs: &Inputs) {
        let decivolts = self.battery.decivolts();
        let autonomy = &mut self.autonomy;
        if !inputs.is_docked || decivolts > autonomy.peak_dv {
            autonomy.level_ticks = 0;
            autonomy.peak_dv = if inputs.is_docked { decivolts } else { 0 };
        }
        autonomy.level_ticks = autonomy.level_ticks.saturating_add(1);
        // The first reading has not been averaged.
        if self.now_ticks == 0 {
            return;
        }
        let above_low_dv =
            i32::from(decivolts) - i32::from(self.parameters.get(Parameter::LowBattery));
        let is_low = if self.autonomy.call_ticks.is_some() {
            above_low_dv < RECOVERED_DV
        } else {
            above_low_dv < 0
        };
        if !is_low || inputs.is_docked {
            self.autonomy.call_ticks = None;
            return;
        }
        let wait = self.autonomy.call_ticks.unwrap_or(0);
        if wait > 0 {
            self.autonomy.call_ticks = Some(wait - 1);
            return;
        }
        self.autonomy.call_ticks = Some(CALL_TICKS);
        let may_forage = may_forage(self.mode) && self.is_fitted(Mode::Forage);
        if self.parameters.is_on(Parameter::Forage) && may_forage {
            self.enter(Mode::Forage);
            self.schedule.queue_text(TO_THE_DOCK);
        } else {
            self.schedule.queue_text(BATTERY_LOW);
        }
        self.play_song(Song::LowBattery);
    }

    /// Stops the motors before the battery is damaged. On the way to its dock the robot continues, because standing drains
    /// the battery too.
    fn watch_critical_battery(&mut self, inputs: &Inputs) {
        if self.now_ticks == 0 {
            return;
        }
        let above_dv = i32::from(self.battery.decivolts())
            - i32::from(self.parameters.get(Parameter::CriticalBattery));
        if inputs.is_docked || above_dv >= RECOVERED_DV {
            self.autonomy.has_stopped = false;
        }
        let stops = above_dv < 0 && !inputs.is_docked && !self.autonomy.has_stopped;
        if stops && self.mode != Mode::Forage {
            self.autonomy.has_stopped = true;
            if self.mode != Mode::Stop {
                self.enter(Mode::Stop);
                self.schedule.queue_text(BATTERY_CRITICAL);
                self.play_song(Song::LowBattery);
            }
        }
    }

    fn step_wander(&mut self) {
        self.autonomy.wandered_ticks += 1;
        let wander_s = self.parameters.get(Parameter::Wander).unsigned_abs();
        if self.autonomy.wandered_ticks > u32::from(wander_s) * TICK_HZ {
            self.enter(Mode::GoHome);
            self.play_song(Song::Alarm);
            self.schedule.queue_text(WANDERED);
        }
    }

    fn step_forage(&mut self) {
        match self.layers.dead_reckoning.take_docking_event() {
            Some(DockingEvent::Docked) => {
                self.play_song(Song::Docked);
                self.schedule.queue_text(ON_THE_DOCK);
                self.schedule.queue_status();
            }
            Some(DockingEvent::Left) => {
                self.enter(self.autonomy.resume);
                self.schedule.queue_text(CHARGED);
            }
            None => {}
        }
    }

    fn step_calibrate(&mut self, inputs: &Inputs) {
        let is_done = self.layers.dead_reckoning.take_square();
        let is_spoilt = inputs.bumper.any();
        if !is_done && !is_spoilt {
            return;
        }
        self.enter(Mode::Stop);
        if is_done {
            self.play_song(Song::Finished);
            self.schedule.queue_text(SQUARE_DRIVEN);
        } else {
            self.schedule.queue_text(SQUARE_ENDED);
        }
    }

    /// Layers that run on the way to the dock, where the bumper touches the dock.
    pub(super) fn enabled_foraging(&self, allowed: LayerMask) -> LayerMask {
        let docking = self.layers.dead_reckoning.docking();
        let allowed = allowed.without(Layer::Photo).without(Layer::Motion);
        if docking.touches_dock() || self.latest.is_docked {
            allowed.without(Layer::Bumpers)
        } else {
            allowed
        }
    }
}

/// Whether the robot may leave this mode for its dock; not if the operator controls it.
const fn may_forage(mode: Mode) -> bool {
    matches!(
        mode,
        Mode::Prowl | Mode::Reactive | Mode::Passive | Mode::Wander | Mode::GoHome
    )
}
