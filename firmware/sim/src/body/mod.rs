//! The robot's body: two driven wheels, a caster and an 11-inch round outline, simulated at 1 kHz.
//!
//! Limited impulses couple wheels, floor and obstacles: a wheel grips until its traction is spent and then slips; a
//! wall pushes and never pulls. Free driving needs one exact pass; only contacts iterate.

pub(crate) mod arm;
mod battery;
mod contact;
mod floor;
pub(crate) mod hook;
mod motor;
#[cfg(test)]
mod tests;

use sr04_firmware::board::{Outputs, PWM_MAX, Switches};

use crate::dimensions::RADIUS_IN;
use crate::faults::Faults;
use crate::geometry::{Vec2, clockwise, heading};
use crate::rng::Rng;
use crate::scene::Scene;
use battery::Battery;
use contact::Touch;
use floor::FloorEffect;
use hook::BumperSpeed;
use motor::{IN_PER_M, Motor, ROTOR_KG};

const STEP_S: f64 = 0.001;
const MASS_KG: f64 = 4.5;
/// Moment of inertia of a disc, in kg in^2.
const INERTIA: f64 = 0.5 * MASS_KG * RADIUS_IN * RADIUS_IN;
/// Half of the nominal track, inches.
const HALF_TRACK_IN: f64 = 5.0;
/// Weight on each wheel (the caster carries the rest) times the friction of rubber, in kg in/s^2.
const TRACTION: f64 = MASS_KG * 9.81 * IN_PER_M * 0.38 * 0.7;
/// Friction coefficient of the body along a contact.
const RUBBING: f64 = 0.2;
/// Stiffness of the bumper's springs, in kg in/s^2 per inch: 15 newtons per inch.
const BUMPER_STIFFNESS: f64 = 15.0 * IN_PER_M;
/// Solver passes while there are contacts.
const PASSES: u32 = 8;
/// Gap that still counts as a contact, inches.
const SKIN_IN: f64 = 0.02;
/// Maximum measured clearance, inches.
const CLEARANCE_MAX_IN: f64 = 36.0;
/// Maximum overlap beyond the bumper's travel.
const OVERLAP_MAX_IN: f64 = 0.05;

/// Distance of the caster behind the centre, inches.
const TAIL_IN: f64 = 5.0;

/// Speeds below these count as standing.
const STILL_IN_S: f64 = 0.1;
const STILL_RAD_S: f64 = 0.01;

/// Manufacturing tolerance of wheel size and track, as limits of a uniform spread.
const WHEEL_SPREAD: f64 = 0.004;
const TRACK_SPREAD: f64 = 0.01;

/// Conditions of the drive train and the sensors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conditions {
    /// Battery charge at the start, 0 empty to 1 full.
    pub charge: f64,
    /// Voltage of a supply that replaces the battery.
    pub supply_v: Option<f64>,
    /// Dry friction of each wheel as a share of a stalled motor's force at 12 volts.
    pub load_share: f64,
    /// Whether wheels and track have their exact nominal size.
    pub ideal_wheels: bool,
    /// Whether sensors have random errors. Without noise, equal situations give equal readings.
    pub noise: bool,
    /// Faults of edge sensors, bumper switches and encoders.
    pub faults: Faults,
}

impl Default for Conditions {
    fn default() -> Self {
        Self {
            charge: 1.0,
            supply_v: None,
            load_share: 0.08,
            ideal_wheels: false,
            noise: true,
            faults: Faults::default(),
        }
    }
}

/// The body's state.
pub(crate) struct Body {
    pub(crate) center: Vec2,
    pub(crate) theta_rad: f64,
    /// Speed forward, to the right, and clockwise, in/s.
    ahead_in_s: f64,
    right_in_s: f64,
    turn_rad_s: f64,
    left: Motor,
    right: Motor,
    battery: Battery,
    friction: f64,
    half_track_in: f64,
    /// Distance that the body may move before it can touch a fixed obstacle, inches.
    free_in: f64,
    /// Last measured centre, and the clearance to fixed obstacles there.
    measured: (Vec2, f64),
    touches: Vec<Touch>,
    has_fallen: bool,
    is_lifted: bool,
    floor: FloorEffect,
    /// Distance driven, inches.
    pub(crate) path_in: f64,
}

impl Body {
    pub(crate) fn new(
        center: Vec2,
        theta_rad: f64,
        conditions: &Conditions,
        rng: &mut Rng,
    ) -> Self {
        let spread = if conditions.ideal_wheels { 0.0 } else { 1.0 };
        Self {
            center,
            theta_rad,
            ahead_in_s: 0.0,
            right_in_s: 0.0,
            turn_rad_s: 0.0,
            left: Motor::new(rng.spread(WHEEL_SPREAD) * spread),
            right: Motor::new(rng.spread(WHEEL_SPREAD) * spread),
            half_track_in: HALF_TRACK_IN * (1.0 + rng.spread(TRACK_SPREAD) * spread),
            battery: Battery::new(conditions.charge, conditions.supply_v),
            friction: motor::load_friction(conditions.load_share.max(0.0)),
            free_in: 0.0,
            measured: (center, 0.0),
            touches: Vec::new(),
            has_fallen: false,
            is_lifted: false,
            floor: FloorEffect::default(),
            path_in: 0.0,
        }
    }

    /// Advances one millisecond.
    pub(crate) fn step(&mut self, scene: &Scene, outputs: Outputs) {
        let duty_left = duty(outputs.pwm_left);
        let duty_right = duty(outputs.pwm_right);
        let supply_v = self.battery.terminal_v();
        let (left_friction, right_friction) = self.floor.friction;
        self.left
            .drive(duty_left, supply_v, self.friction + left_friction, STEP_S);
        self.right
            .drive(duty_right, supply_v, self.friction + right_friction, STEP_S);
        self.battery.draw(
            duty_left * self.left.current_a + duty_right * self.right.current_a,
            STEP_S,
        );
        if self.has_fallen || self.is_lifted {
            self.left.turn(STEP_S);
            self.right.turn(STEP_S);
            return;
        }
        self.couple();
        self.left.turn(STEP_S);
        self.right.turn(STEP_S);
        self.advance(scene);
        if !scene.drops.is_empty() && self.is_over_an_edge(scene) {
            self.fall();
        }
    }

    /// Updates the effect of the floor at the current position.
    pub(crate) fn update_floor(&mut self, scene: &Scene) {
        if !scene.grounds.is_empty() {
            let axle = clockwise(heading(self.theta_rad)) * self.half_track_in;
            self.floor = FloorEffect::at(scene, self.center, axle);
        }
    }

    /// Speeds at the bumper.
    pub(crate) fn bumper_speed(&self) -> BumperSpeed {
        BumperSpeed {
            ahead_in_s: self.ahead_in_s,
            around_in_s: self.turn_rad_s * RADIUS_IN,
        }
    }

    /// Whether a wheel or the caster has no floor below it. The weight rests on all three; without the caster the robot
    /// tips back.
    fn is_over_an_edge(&self, scene: &Scene) -> bool {
        let forward = heading(self.theta_rad);
        let axle = clockwise(forward) * self.half_track_in;
        [axle, -axle, -forward * TAIL_IN]
            .iter()
            .any(|&offset| scene.drops.has(self.center + offset))
    }

    /// Stops the body for good; its wheels turn in the air.
    fn fall(&mut self) {
        self.has_fallen = true;
        self.halt();
    }

    /// Takes the body off the floor: its wheels turn in the air, and nothing touches it.
    pub(crate) fn lift(&mut self) {
        self.is_lifted = true;
        self.touches.clear();
        self.halt();
    }

    /// Puts the body on the floor at a place that is free.
    pub(crate) fn set_down(&mut self, center: Vec2, theta_rad: f64) {
        self.is_lifted = false;
        (self.center, self.theta_rad) = (center, theta_rad);
        self.free_in = 0.0;
    }

    /// Whether the body is off the floor.
    pub(crate) const fn is_lifted(&self) -> bool {
        self.is_lifted
    }

    const fn halt(&mut self) {
        self.ahead_in_s = 0.0;
        self.right_in_s = 0.0;
        self.turn_rad_s = 0.0;
    }

    /// Rotates the velocity into the turning body and solves wheels, floor and contacts.
    fn couple(&mut self) {
        let turned = self.turn_rad_s * STEP_S;
        let (ahead, right) = (self.ahead_in_s, self.right_in_s);
        self.ahead_in_s += turned * right;
        self.right_in_s -= turned * ahead;
        if self.floor.downhill != Vec2::ZERO {
            let forward = heading(self.theta_rad);
            self.ahead_in_s += self.floor.downhill.dot(forward) * STEP_S;
            self.right_in_s += self.floor.downhill.dot(clockwise(forward)) * STEP_S;
        }
        let passes = if self.touches.is_empty() { 1 } else { PASSES };
        let mut impulses = FloorImpulses::default();
        let mut touches = core::mem::take(&mut self.touches);
        for touch in &mut touches {
            self.spring(touch);
        }
        for _ in 0..passes {
            self.hold_floor(&mut impulses);
            for touch in &mut touches {
                self.hold_back(touch);
            }
        }
        self.touches = touches;
    }

    /// Applies the floor's grip to both wheels and its resistance to sliding sideways, within the traction limit.
    fn hold_floor(&mut self, impulses: &mut FloorImpulses) {
        let arm = self.half_track_in;
        let own = 1.0 / ROTOR_KG + 1.0 / MASS_KG + arm * arm / INERTIA;
        let other = 1.0 / MASS_KG - arm * arm / INERTIA;
        let slip_left = self.left.speed_in_s - (self.ahead_in_s + self.turn_rad_s * arm);
        let slip_right = self.right.speed_in_s - (self.ahead_in_s - self.turn_rad_s * arm);
        let sum = (slip_left + slip_right) / (own + other);
        let difference = (slip_left - slip_right) / (own - other);
        let limit = TRACTION * STEP_S;
        let left = limited(
            &mut impulses.left,
            f64::midpoint(sum, difference),
            -limit,
            limit,
        );
        let right = limited(
            &mut impulses.right,
            f64::midpoint(sum, -difference),
            -limit,
            limit,
        );
        self.left.speed_in_s -= left / ROTOR_KG;
        self.right.speed_in_s -= right / ROTOR_KG;
        self.ahead_in_s += (left + right) / MASS_KG;
        self.turn_rad_s += (left - right) * arm / INERTIA;

        let wanted = -self.right_in_s * MASS_KG;
        self.right_in_s +=
            limited(&mut impulses.across, wanted, -2.0 * limit, 2.0 * limit) / MASS_KG;
    }

    /// Pushes back with the bumper's springs.
    fn spring(&mut self, touch: &mut Touch) {
        touch.friction_impulse = 0.0;
        touch.normal_impulse = 0.0;
        if touch.travel_in > 0.0 && touch.depth_in > 0.0 {
            let push = BUMPER_STIFFNESS * touch.depth_in.min(touch.travel_in) * STEP_S;
            self.ahead_in_s -= touch.ahead * push / MASS_KG;
            self.right_in_s -= touch.right * push / MASS_KG;
        }
    }

    /// Stops the body at the end of the bumper's travel and applies friction along the contact.
    fn hold_back(&mut self, touch: &mut Touch) {
        let approach = self.ahead_in_s * touch.ahead + self.right_in_s * touch.right;
        let allowed = (touch.travel_in - touch.depth_in).max(0.0) / STEP_S;
        let push = (approach - allowed) * MASS_KG;
        let push = limited(&mut touch.normal_impulse, push, 0.0, f64::INFINITY);
        self.ahead_in_s -= touch.ahead * push / MASS_KG;
        self.right_in_s -= touch.right * push / MASS_KG;

        // The tangent is the direction to the solid, turned clockwise.
        let (along_ahead, along_right) = (-touch.right, touch.ahead);
        let rubbing = self.ahead_in_s * along_ahead
            + self.right_in_s * along_right
            + self.turn_rad_s * RADIUS_IN;
        let grip = 1.0 / MASS_KG + RADIUS_IN * RADIUS_IN / INERTIA;
        let limit = RUBBING * touch.normal_impulse;
        let drag = limited(&mut touch.friction_impulse, -rubbing / grip, -limit, limit);
        self.ahead_in_s += along_ahead * drag / MASS_KG;
        self.right_in_s += along_right * drag / MASS_KG;
        self.turn_rad_s += drag * RADIUS_IN / INERTIA;
    }

    /// Moves the body and resolves overlaps.
    fn advance(&mut self, scene: &Scene) {
        let before = (self.center, self.theta_rad);
        let share = 1.0 - self.floor.creep;
        let turned = self.turn_rad_s * STEP_S * share;
        let forward = heading(self.theta_rad + turned / 2.0);
        let moved =
            (forward * self.ahead_in_s + clockwise(forward) * self.right_in_s) * STEP_S * share;
        self.center += moved;
        self.theta_rad += turned;
        let moved_in = moved.length();
        self.path_in += moved_in;
        self.free_in -= moved_in;
        if self.free_in > 0.0 && !self.walker_is_close(scene) {
            self.touches.clear();
            return;
        }
        for _ in 0..PASSES {
            self.look_around(scene);
            let Some(deepest) = self.deepest() else {
                return;
            };
            let excess = deepest.depth_in - deepest.travel_in;
            if excess <= SKIN_IN / 2.0 {
                return;
            }
            self.center -= deepest.toward * excess;
        }
        self.look_around(scene);
        let stuck = self
            .deepest()
            .is_some_and(|touch| touch.depth_in - touch.travel_in > OVERLAP_MAX_IN);
        if stuck {
            (self.center, self.theta_rad) = before;
            self.halt();
            self.look_around(scene);
        }
    }

    /// The contact that exceeds the bumper's travel the most.
    fn deepest(&self) -> Option<Touch> {
        let excess = |touch: &Touch| touch.depth_in - touch.travel_in;
        self.touches
            .iter()
            .copied()
            .max_by(|one, other| excess(one).total_cmp(&excess(other)))
    }

    fn walker_is_close(&self, scene: &Scene) -> bool {
        scene.walkers.iter().any(|walker| {
            let reach = RADIUS_IN + SKIN_IN + walker.radius_in();
            walker.center().distance_squared(self.center) < reach * reach
        })
    }

    /// Finds the contacts and the clearance.
    fn look_around(&mut self, scene: &Scene) {
        let forward = heading(self.theta_rad);
        let rightward = clockwise(forward);
        self.touches.clear();
        let mut nearest = f64::INFINITY;
        scene.near(self.center, RADIUS_IN + 1.0, |near| {
            nearest = nearest.min(near.distance_in);
            if near.distance_in < RADIUS_IN + SKIN_IN {
                self.touches
                    .push(Touch::new(&near, RADIUS_IN, forward, rightward));
            }
        });
        if nearest == f64::INFINITY {
            scene.near(self.center, CLEARANCE_MAX_IN, |near| {
                nearest = nearest.min(near.distance_in);
            });
        }
        let clear = nearest.min(CLEARANCE_MAX_IN);
        self.measured = (self.center, clear);
        self.free_in = clear - RADIUS_IN - SKIN_IN;
    }

    /// A distance around the centre that is certainly free of fixed obstacles, inches.
    pub(crate) fn clearance_in(&self) -> f64 {
        let (center, clear) = self.measured;
        clear - center.distance(self.center)
    }

    pub(crate) fn switches(&self) -> Switches {
        let mut switches = Switches::default();
        for touch in &self.touches {
            touch.press(&mut switches);
        }
        switches
    }

    /// Whether any obstacle touches the outline.
    pub(crate) fn is_touching(&self) -> bool {
        self.touches.iter().any(|touch| touch.depth_in > -SKIN_IN)
    }

    /// Connects or disconnects the charger.
    pub(crate) const fn charge(&mut self, on: bool) {
        self.battery.is_charging = on;
    }

    /// Whether the charger is connected.
    pub(crate) const fn is_charging(&self) -> bool {
        self.battery.is_charging
    }

    /// Whether the body moves or turns enough to trigger a motion detector.
    pub(crate) fn is_moving(&self) -> bool {
        self.ahead_in_s.abs() + self.right_in_s.abs() > STILL_IN_S
            || self.turn_rad_s.abs() > STILL_RAD_S
    }

    /// Whether the robot has gone over an edge of the floor.
    pub(crate) const fn has_fallen(&self) -> bool {
        self.has_fallen
    }

    /// Speed over the floor, negative backward, in/s.
    pub(crate) const fn speed_in_s(&self) -> f64 {
        self.ahead_in_s
    }

    pub(crate) const fn battery(&self) -> &Battery {
        &self.battery
    }

    /// Encoder edges since the last call, left and right.
    pub(crate) fn take_edges(&mut self) -> (u16, u16) {
        (self.left.take_edges(), self.right.take_edges())
    }
}

/// Impulses of the floor in the current step.
#[derive(Default)]
struct FloorImpulses {
    left: f64,
    right: f64,
    across: f64,
}

fn duty(pwm: i16) -> f64 {
    f64::from(pwm.clamp(-PWM_MAX, PWM_MAX)) / f64::from(PWM_MAX)
}

/// Adds an impulse to a sum that stays within limits; returns the part that was added.
fn limited(sum: &mut f64, impulse: f64, least: f64, most: f64) -> f64 {
    let before = *sum;
    *sum = (before + impulse).clamp(least, most);
    *sum - before
}
