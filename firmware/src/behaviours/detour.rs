//! Detours: when the robot does not come nearer to the target, it follows a wall until it does.
//!
//! After the "Bug" algorithms of Lumelsky and Stepanov (1987), which need no map: drive straight at the target, and
//! where that fails, follow the obstacle until the target is nearer than ever before. The layers above do the following of the wall:
//! this layer only drives an arc toward the wall, and infrared and bumpers push away from it.

use super::prowl;
use crate::drive::Motion;
use crate::sensors::Senses;
use crate::units::ticks;
use groundwave_protocol::Waypoint;

/// Number of ticks without coming nearer that count as no progress.
const STALLED_TICKS: u16 = ticks(15);

/// Minimum decrease of the distance that counts as nearer, inches.
const NEARER_IN: i32 = 6;

/// Decrease below the smallest distance so far at which the obstacle counts as passed, inches.
const PASSED_IN: i32 = 18;

/// Duration of the first attempt at following the wall; it doubles with each attempt.
const ATTEMPT_TICKS: u16 = ticks(60);

/// Maximum number of doublings.
const DOUBLINGS_MOST: u8 = 2;

/// Radius of the arc toward the wall at any speed, inches.
const BOW_RADIUS_IN: i16 = 24;

/// Distance between the wheels in inches.
const TRACK_IN: i16 = 10;

/// Number of ticks of straight driving after a contact with the wall, before the next arc toward it.
const ALONG_TICKS: u16 = ticks(1) / 2;

/// Number of ticks without contact after which there is no wall: more than half of the arc's circle.
const LOST_TICKS: u16 = ticks(8);

/// State of the detour to the current target.
#[derive(Clone, Debug, Default)]
pub struct Detour {
    target: Option<Waypoint>,
    nearest_in: i32,
    stalled_ticks: u16,
    /// Remaining number of ticks for following the wall, and the side of the wall.
    follow_ticks: u16,
    wall_right: bool,
    attempts: u8,
    unmet_ticks: u16,
}

impl Detour {
    /// Motion toward a target.
    pub fn toward(&mut self, senses: &Senses, target: Waypoint) -> Motion {
        let distance_in = prowl::distance_in(&senses.pose, target);
        if self.target != Some(target) {
            *self = Self {
                target: Some(target),
                nearest_in: distance_in,
                wall_right: senses.random & 2 != 0,
                ..Self::default()
            };
        }
        if self.follow_ticks == 0 {
            self.watch(distance_in);
            return prowl::toward(senses, target);
        }
        self.follow_ticks -= 1;
        let passed = distance_in + PASSED_IN <= self.nearest_in;
        if passed || self.follow_ticks == 0 {
            self.follow_ticks = 0;
            self.stalled_ticks = 0;
            self.nearest_in = distance_in;
            // After a failed attempt, follow the wall in the other direction.
            self.wall_right ^= !passed;
            return prowl::toward(senses, target);
        }
        let met = senses.infrared.any() || senses.bumper.any();
        self.unmet_ticks = if met {
            0
        } else {
            self.unmet_ticks.saturating_add(1)
        };
        if self.unmet_ticks >= LOST_TICKS {
            return prowl::toward(senses, target);
        }
        let velocity_cps = senses.top_cps();
        let bow_cps = velocity_cps / BOW_RADIUS_IN * TRACK_IN;
        Motion {
            velocity_cps,
            rotation_cps: match (self.unmet_ticks >= ALONG_TICKS, self.wall_right) {
                (false, _) => 0,
                (true, true) => bow_cps,
                (true, false) => -bow_cps,
            },
        }
    }

    fn watch(&mut self, distance_in: i32) {
        if distance_in + NEARER_IN <= self.nearest_in {
            self.nearest_in = distance_in;
            self.stalled_ticks = 0;
            return;
        }
        self.stalled_ticks += 1;
        if self.stalled_ticks >= STALLED_TICKS {
            self.follow_ticks = ATTEMPT_TICKS << self.attempts;
            self.attempts = (self.attempts + 1).min(DOUBLINGS_MOST);
            self.unmet_ticks = ALONG_TICKS;
        }
    }

    #[cfg(test)]
    const fn is_under_way(&self) -> bool {
        self.follow_ticks > 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::angle::Angle;
    use crate::odometry::Odometer;
    use crate::units::cps;

    const TARGET: Waypoint = Waypoint { x_in: 0, y_in: 200 };

    fn at(y_in: i16) -> Senses<'static> {
        let mut odometer = Odometer::default();
        odometer.set(Waypoint { x_in: 0, y_in }, Angle(0));
        Senses {
            pose: odometer.pose(),
            ..Senses::idle()
        }
    }

    fn stall(detour: &mut Detour, y_in: i16) {
        let mut ticks = 0;
        while !detour.is_under_way() {
            detour.toward(&at(y_in), TARGET);
            ticks += 1;
        }
        assert!(
            (STALLED_TICKS - 1..=STALLED_TICKS).contains(&ticks),
            "{ticks}"
        );
    }

    #[test]
    fn approach_is_straight_while_the_target_comes_nearer() {
        let mut detour = Detour::default();
        for tick in 0..600 {
            let senses = at(tick / 5);
            assert_eq!(
                detour.toward(&senses, TARGET),
                prowl::toward(&senses, TARGET)
            );
        }
        assert!(!detour.is_under_way());
    }

    #[test]
    fn wall_is_followed_until_the_target_is_nearer_than_ever() {
        let mut detour = Detour::default();
        stall(&mut detour, 50);
        let motion = detour.toward(&at(40), TARGET);
        assert!(motion.velocity_cps == cps(12) && motion.rotation_cps != 0);
        detour.toward(&at(67), TARGET);
        assert!(detour.is_under_way());
        let senses = at(68);
        assert_eq!(
            detour.toward(&senses, TARGET),
            prowl::toward(&senses, TARGET)
        );
        assert!(!detour.is_under_way());
    }

    #[test]
    fn second_attempt_is_on_the_other_side_and_twice_as_long() {
        let mut detour = Detour::default();
        let attempt = |detour: &mut Detour| {
            stall(detour, 50);
            let mut senses = at(50);
            let side = detour.toward(&senses, TARGET).rotation_cps.signum();
            senses.infrared.left = true;
            let mut ticks = 1;
            while detour.is_under_way() {
                detour.toward(&senses, TARGET);
                ticks += 1;
            }
            (side, ticks)
        };
        let first = attempt(&mut detour);
        let second = attempt(&mut detour);
        assert_eq!(second, (-first.0, first.1 * 2));
    }

    #[test]
    fn missing_wall_ends_the_arc() {
        let mut detour = Detour::default();
        stall(&mut detour, 50);
        for _ in ALONG_TICKS..LOST_TICKS {
            detour.toward(&at(50), TARGET);
        }
        let senses = at(50);
        assert_eq!(
            detour.toward(&senses, TARGET),
            prowl::toward(&senses, TARGET)
        );
        let mut met = at(50);
        met.bumper.left = true;
        // First along the wall, then toward it.
        assert_eq!(detour.toward(&met, TARGET).rotation_cps, 0);
        for _ in 1..ALONG_TICKS {
            assert_eq!(detour.toward(&at(50), TARGET).rotation_cps, 0);
        }
        assert_ne!(detour.toward(&at(50), TARGET).rotation_cps, 0);
    }

    #[test]
    fn new_target_ends_the_detour() {
        let mut detour = Detour::default();
        stall(&mut detour, 50);
        detour.toward(&at(50), Waypoint { x_in: 9, y_in: 9 });
        assert!(!detour.is_under_way());
    }
}
