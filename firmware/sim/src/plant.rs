//! The world and the robot's body as seen from the pins of the robot's board.

use sr04_firmware::board::{Echo, Edges, Inputs, Outputs, Side, Sides, Switches};

use crate::body::arm::Arm;
use crate::body::hook::Hook;
use crate::body::{Body, Conditions};
use crate::dimensions::{ARM_BEHIND_IN, RADIUS_IN};
use crate::faults::Faulty;
use crate::geometry::{Frame, Pose, Vec2};
use crate::rng::{Rng, Stream};
use crate::scene::Scene;
use crate::sensors::infrared::Infrared;
use crate::sensors::motion::{Carrier, MotionDetectors};
use crate::sensors::photocells::Light;
use crate::sensors::sonar::Sonars;
use crate::sensors::{View, beacon, edges};
use crate::time::TICK_MS;
use crate::walker;
use crate::world::{Outline, Point, World};

/// Number of ticks from a ping to its echo.
const ECHO_TICKS: u8 = 2;

/// True state of the robot, independent of what it believes.
///
/// Coordinates are the robot's: the start pose is the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(clippy::struct_excessive_bools, reason = "each is an independent fact")]
pub struct Truth {
    /// Time since the start, milliseconds.
    pub now_ms: u64,
    /// True pose.
    pub pose: Pose,
    /// Whether any obstacle touches the robot's outline.
    pub is_touching: bool,
    /// Whether the robot has gone over an edge of the floor; it stays there.
    pub has_fallen: bool,
    /// Whether an object caught on the bumper holds a switch closed.
    pub is_hooked: bool,
    /// Whether the charger is connected.
    pub is_docked: bool,
    /// Position of the arm with the motion detectors: 0 stowed to 1 raised.
    pub arm_raised: f64,
    /// Speed over the floor, negative backward, in/s.
    pub speed_in_s: f64,
    /// Distance driven since the start, inches.
    pub path_in: f64,
    /// Battery charge, 0 empty to 1 full.
    pub charge: f64,
}

/// The simulated world with the robot's body, without the robot's program.
pub struct Plant {
    now_ms: u64,
    frame: Frame,
    outlines: Vec<Outline>,
    scene: Scene,
    body: Body,
    arm: Arm,
    hook: Hook,
    light: Light,
    infrared: Infrared,
    motion: MotionDetectors,
    sonars: Sonars,
    echo: Option<(u8, Echo)>,
    outputs: Outputs,
    sonar_rng: Rng,
    infrared_rng: Rng,
    photocell_rng: Rng,
    motion_rng: Rng,
    beacon_rng: Rng,
    snag_rng: Rng,
    faulty: Faulty,
}

impl Plant {
    /// A world with the robot at its start; every random event follows from the seed.
    #[must_use]
    pub fn new(world: &World, conditions: &Conditions, seed: u64) -> Self {
        let start = world.start;
        let center = Vec2::new(start.x_in, start.y_in);
        let rng = |stream| Rng::for_sensor(seed, stream, conditions.noise);
        let mut build_rng = Rng::new(seed, Stream::Build);
        Self {
            now_ms: 0,
            frame: world.frame(),
            outlines: world.outlines(),
            scene: Scene::new(world),
            body: Body::new(
                center,
                start.theta_deg.to_radians(),
                conditions,
                &mut build_rng,
            ),
            arm: Arm::default(),
            hook: Hook::default(),
            light: Light {
                lamps: world.lamps.clone(),
                daylight_lux: world.daylight_lux,
            },
            infrared: Infrared::new(),
            motion: MotionDetectors::default(),
            sonars: Sonars::default(),
            echo: None,
            outputs: Outputs::default(),
            sonar_rng: rng(Stream::Sonar),
            infrared_rng: rng(Stream::Infrared),
            photocell_rng: rng(Stream::Photocells),
            motion_rng: rng(Stream::Motion),
            beacon_rng: rng(Stream::Beacon),
            snag_rng: rng(Stream::Snags),
            faulty: Faulty::new(conditions.faults, seed),
        }
    }

    /// Advances the world by one millisecond.
    pub fn step(&mut self) {
        self.now_ms += 1;
        if self.now_ms.is_multiple_of(walker::STEP_MS) {
            for walker in &mut self.scene.walkers {
                walker.step(self.body.center, RADIUS_IN);
            }
            self.body.update_floor(&self.scene);
        }
        self.body.step(&self.scene, self.outputs);
        if self.now_ms.is_multiple_of(TICK_MS) {
            self.step_motion_detectors();
            self.step_dock();
            self.step_hook();
        }
    }

    fn step_hook(&mut self) {
        if !self.scene.snags.is_empty() {
            self.hook.step(
                &self.scene,
                self.body.center,
                self.body.theta_rad,
                self.body.bumper_speed(),
                &mut self.snag_rng,
            );
        }
    }

    fn step_dock(&mut self) {
        if let Some(dock) = &self.scene.dock {
            let is_held =
                !self.body.is_lifted() && dock.holds(self.body.center, self.body.theta_rad);
            self.body.charge(is_held);
        }
    }

    fn step_motion_detectors(&mut self) {
        let view = self.view();
        if self.outputs.arm_up || self.arm.raised() > 0.0 {
            let base = view.point(0.0, -ARM_BEHIND_IN);
            self.arm
                .step(self.outputs.arm_up, self.scene.headroom_in(base));
        }
        let carrier = Carrier {
            view,
            arm_is_up: self.arm.is_up(),
            robot_moves: self.body.is_moving(),
        };
        self.motion.step(&self.scene, carrier, &mut self.motion_rng);
    }

    /// The robot's sensor inputs for a tick. Call it once per tick: it takes the encoder edges and advances a pending
    /// echo.
    pub fn inputs(&mut self) -> Inputs {
        let (counts_left, counts_right) = self.edges();
        let (photo_left, photo_right) =
            self.light
                .read(&self.scene, self.view(), &mut self.photocell_rng);
        Inputs {
            counts_left,
            counts_right,
            bumper: self.switches(),
            sonar: self.finished_echo(),
            photo_left: Some(photo_left),
            photo_right: Some(photo_right),
            battery_dv: self.body.battery().decivolts(),
            cliff: Some(self.floor_edges()),
            motion: Some(self.motion.sides()),
            top_hat: self.arm.top_hat(),
            beacon: self.beacon(),
            is_docked: self.body.is_charging(),
            is_late: false,
        }
    }

    /// Left and right encoder edges since the previous call of this function or of [`Self::inputs`].
    pub fn edges(&mut self) -> (u16, u16) {
        let (left, right) = self.body.take_edges();
        (
            self.faulty.edges(Side::Left, left),
            self.faulty.edges(Side::Right, right),
        )
    }

    fn floor_edges(&mut self) -> Edges {
        if self.body.is_lifted() {
            return Edges::ALL;
        }
        edges::detect(&self.scene, self.view(), &mut self.faulty)
    }

    fn switches(&mut self) -> Switches {
        let mut switches = self.body.switches();
        self.hook.press(&mut switches);
        self.faulty.switches(switches)
    }

    fn beacon(&mut self) -> Option<Sides> {
        let dock = self.scene.dock.as_ref()?;
        Some(beacon::detect(
            &self.scene,
            dock,
            self.view(),
            &mut self.beacon_rng,
        ))
    }

    fn finished_echo(&mut self) -> Option<Echo> {
        let (ticks_left, echo) = self.echo?;
        if ticks_left > 1 {
            self.echo = Some((ticks_left - 1, echo));
            return None;
        }
        self.echo = None;
        Some(echo)
    }

    /// Applies the robot's outputs until the next tick.
    pub fn apply(&mut self, outputs: Outputs) {
        self.outputs = outputs;
        if let Some(side) = outputs.ping {
            let range_in = self.ping(side);
            self.echo = Some((ECHO_TICKS, Echo { side, range_in }));
        }
    }

    /// Range of the first echo of a ping, in inches; `None` without an echo.
    pub fn ping(&mut self, side: Side) -> Option<u16> {
        let view = self.view();
        self.sonars
            .ping(&self.scene, view, side, self.now_ms, &mut self.sonar_rng)
    }

    /// Readings of the left and right infrared detectors while the LEDs are on or off.
    pub fn infrared(&mut self, leds_on: bool) -> (bool, bool) {
        let (view, clearance_in) = (self.view(), self.body.clearance_in());
        self.infrared.sample(
            &self.scene,
            view,
            clearance_in,
            leds_on,
            &mut self.infrared_rng,
        )
    }

    /// Clears the state of the stopped program: encoder edges, a pending echo, motor commands.
    pub fn reset_board(&mut self) {
        self.outputs = Outputs::default();
        self.echo = None;
        self.body.take_edges();
    }

    /// Lifts the robot from the floor; nothing else moves it until [`Self::set_down`].
    pub fn lift(&mut self) {
        self.body.lift();
    }

    /// Puts the robot down at a free place in the coordinates of [`Truth`].
    pub fn set_down(&mut self, pose: Pose) {
        let (center, theta_rad) = self.frame.place(pose);
        self.body.set_down(center, theta_rad);
    }

    /// The robot's current outputs.
    #[must_use]
    pub const fn outputs(&self) -> Outputs {
        self.outputs
    }

    /// True state of the robot.
    #[must_use]
    pub fn truth(&self) -> Truth {
        Truth {
            now_ms: self.now_ms,
            pose: self.frame.pose(self.body.center, self.body.theta_rad),
            is_touching: self.body.is_touching(),
            has_fallen: self.body.has_fallen(),
            is_hooked: self.hook.holds(),
            is_docked: self.body.is_charging(),
            arm_raised: self.arm.raised(),
            speed_in_s: self.body.speed_in_s(),
            path_in: self.body.path_in,
            charge: self.body.battery().charge(),
        }
    }

    /// Walls and furniture in the robot's coordinates.
    #[must_use]
    pub fn outlines(&self) -> &[Outline] {
        &self.outlines
    }

    /// Positions of people and animals in the robot's coordinates, each with its radius in inches.
    pub fn walkers(&self) -> impl Iterator<Item = (Point, f64)> {
        self.scene.walkers.iter().map(|walker| {
            (
                Point::from(self.frame.point(walker.center())),
                walker.radius_in(),
            )
        })
    }

    /// Switches a lamp by name; returns `false` if the world has no lamp of this name.
    pub fn set_lamp(&mut self, name: &str, on: bool) -> bool {
        let lamp = self.light.lamps.iter_mut().find(|lamp| lamp.name == name);
        lamp.map(|lamp| lamp.on = on).is_some()
    }

    fn view(&self) -> View {
        View {
            center: self.body.center,
            theta_rad: self.body.theta_rad,
        }
    }
}
