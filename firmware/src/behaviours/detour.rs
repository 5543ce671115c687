//! The way round: when a target comes no nearer, keep to a wall until it does.
//!
//! After Lumelsky and Stepanov's "Bug" algorithms (1987), which need no map: go straight to the target, and
//! where that leads nowhere follow the obstacle until the target is nearer than it has ever been. The
//! following is done by the layers above: this one only drives a bow toward the wall, which infrared and
//! bumpers push away from.

use super::prowl;
use crate::drive::Motion;
use crate::sensors::Senses;
use crate::units::ticks;
use groundwave_protocol::Waypoint;

/// So long without getting nearer is no progress.
const STALLED_TICKS: u16 = ticks(15);

/// Less nearer than this is none.
const NEARER_IN: i32 = 6;

/// Nearer by this than ever before: the obstacle is passed.
const PASSED_IN: i32 = 18;

/// The first attempt follows the wall for so long; each one after it twice as long.
const ATTEMPT_TICKS: u16 = ticks(60);

/// Attempts do not get longer than so many times doubled.
const DOUBLINGS_MOST: u8 = 2;

/// The bow toward the wall: 24 inches of radius at any speed.
const BOW_RADIUS_IN: i16 = 24;

/// From wheel to wheel, inches.
const TRACK_IN: i16 = 10;

/// The wall that was just met is beside the robot for so long: it drives on along it before it bows to it again.
const ALONG_TICKS: u16 = ticks(1) / 2;

/// Nothing met for so long: more than half a circle of the bow, so there is no wall.
const LOST_TICKS: u16 = ticks(8);

/// Where it stands with the present target.
#[derive(Clone, Debug, Default)]
pub struct Detour {
    target: Option<Waypoint>,
    nearest_in: i32,
    stalled_ticks: u16,
    /// The side to keep the wall on, and for how long still.
    follow_ticks: u16,
    wall_right: bool,
    attempts: u8,
    unmet_ticks: u16,
}

impl Detour {
    /// The way to a target.
    pub fn toward(&mut self, senses: &Senses, target: Waypoint) -> Motion {
        let distance_in = prowl::distance_in(&senses.pose, target);
        if self.target != Some(target) {
            *self = Self {
                target: Some(target),
                nearest_in: distance_in,
                wall_right: senses.dice & 2 != 0,
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
            // What did not help may help the other way round.
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
            ..Senses::nothing()
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
    fn as_long_as_it_gets_nearer_it_goes_straight() {
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
    fn without_progress_it_bows_to_a_wall_until_the_target_is_nearer_than_ever() {
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
    fn the_next_attempt_keeps_the_other_hand_on_the_wall_for_longer() {
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
    fn where_no_wall_is_it_does_not_circle() {
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
        // Along what it has met, and then to it.
        assert_eq!(detour.toward(&met, TARGET).rotation_cps, 0);
        for _ in 1..ALONG_TICKS {
            assert_eq!(detour.toward(&at(50), TARGET).rotation_cps, 0);
        }
        assert_ne!(detour.toward(&at(50), TARGET).rotation_cps, 0);
    }

    #[test]
    fn another_target_is_another_matter() {
        let mut detour = Detour::default();
        stall(&mut detour, 50);
        detour.toward(&at(50), Waypoint { x_in: 9, y_in: 9 });
        assert!(!detour.is_under_way());
    }
}
