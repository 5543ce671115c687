//! The refuge: whether a robot that avoids light stays in the dark place it has reached.
//!
//! Fleeing the light ends in the next corner, however bright that corner is. A robot with repeated contacts in one place
//! therefore compares its darkness with the darkest other place it knows. If that was darker, or if it knows too few
//! places, it ignores light for a while, and bumpers and prowl lead it elsewhere.

use crate::odometry::Pose;
use crate::units::ticks;

/// Number of contacts in one place after which the robot has fled as far as it can.
const CONTACTS: u8 = 4;

/// Maximum distance from the first contact, along each axis, that counts as the same place, inches.
const ABOUT_IN: i32 = 24;

/// Number of known places from which the robot can choose one.
const KNOWN: u8 = 2;

/// Duration of ignoring light: 15 feet of driving.
const ELSEWHERE_TICKS: u16 = ticks(15);

/// Reading of complete darkness.
const DARK: i16 = 255;

/// Known dark places.
#[derive(Clone, Debug, Default)]
pub struct Refuge {
    was_touching: bool,
    /// Position of the first contact in this place, number of contacts, and the darkest reading at them.
    first_in: (i16, i16),
    contacts: u8,
    dark: i16,
    /// Darkest of the known places, and their number.
    darkest: i16,
    known: u8,
    elsewhere_ticks: u16,
}

impl Refuge {
    /// Whether the robot ignores light; call it once per tick while it avoids light. `reading` is the mean of both cells, 0
    /// bright to 255 dark; readings that differ by less than `equal` are equal.
    pub fn ignores_light(
        &mut self,
        is_touching: bool,
        pose: &Pose,
        reading: i16,
        equal: i16,
    ) -> bool {
        let touches = is_touching && !self.was_touching;
        self.was_touching = is_touching;
        if self.elsewhere_ticks > 0 {
            self.elsewhere_ticks -= 1;
            return true;
        }
        if !touches {
            return false;
        }
        let here_in = (
            (pose.x_tenths_in() / 10) as i16,
            (pose.y_tenths_in() / 10) as i16,
        );
        let is_apart = |one: i16, other: i16| (i32::from(one) - i32::from(other)).abs() > ABOUT_IN;
        if self.contacts == 0
            || is_apart(here_in.0, self.first_in.0)
            || is_apart(here_in.1, self.first_in.1)
        {
            self.first_in = here_in;
            self.contacts = 0;
            self.dark = 0;
        }
        self.contacts += 1;
        self.dark = self.dark.max(reading);
        if self.contacts < CONTACTS {
            return false;
        }
        self.contacts = 0;
        if self.dark.saturating_add(equal) >= DARK
            || self.known >= KNOWN && self.dark.saturating_add(equal) >= self.darkest
        {
            return false;
        }
        self.known = (self.known + 1).min(KNOWN);
        // A place that is not found again counts as less dark.
        self.darkest = self.dark.max(self.darkest.saturating_sub(equal));
        self.elsewhere_ticks = ELSEWHERE_TICKS;
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::angle::Angle;
    use crate::odometry::Odometer;
    use groundwave_protocol::Waypoint;

    const EQUAL: i16 = 4;

    fn at(x_in: i16) -> Pose {
        let mut odometer = Odometer::default();
        odometer.set(Waypoint { x_in, y_in: 0 }, Angle(0));
        odometer.pose()
    }

    /// Makes one contact; returns the ticks of ignoring light after it.
    fn touch(refuge: &mut Refuge, x_in: i16, reading: i16) -> u16 {
        let pose = at(x_in);
        let mut ticks = u16::from(refuge.ignores_light(true, &pose, reading, EQUAL));
        while ticks > 0 && refuge.ignores_light(false, &pose, reading, EQUAL) {
            ticks += 1;
        }
        refuge.ignores_light(false, &pose, reading, EQUAL);
        ticks
    }

    /// Makes the contacts of one place; returns whether the robot leaves it.
    fn press(refuge: &mut Refuge, x_in: i16, reading: i16) -> bool {
        for _ in 1..CONTACTS {
            assert_eq!(touch(refuge, x_in, reading), 0);
        }
        touch(refuge, x_in, reading) > 0
    }

    /// A refuge that knows two places with readings of 200 and 220.
    fn knows_two() -> Refuge {
        let mut refuge = Refuge::default();
        assert!(press(&mut refuge, 0, 200) && press(&mut refuge, 100, 220));
        refuge
    }

    #[test]
    fn first_two_places_are_left_and_an_equally_dark_one_is_kept() {
        assert!(!press(&mut knows_two(), 0, 216));
        assert!(!press(&mut knows_two(), 0, 240));
        assert!(press(&mut knows_two(), 0, 215));
    }

    #[test]
    fn expected_darkness_falls_while_it_is_not_found() {
        let mut refuge = knows_two();
        let left = (0..10).take_while(|_| press(&mut refuge, 0, 205)).count();
        assert_eq!(left, 3);
    }

    #[test]
    fn light_is_ignored_for_fifteen_seconds() {
        let mut refuge = Refuge::default();
        for _ in 1..CONTACTS {
            touch(&mut refuge, 0, 200);
        }
        assert_eq!(touch(&mut refuge, 0, 200), 1 + ELSEWHERE_TICKS);
    }

    #[test]
    fn completely_dark_place_is_kept_at_once() {
        assert!(!press(&mut Refuge::default(), 0, 251));
        assert!(press(&mut Refuge::default(), 0, 250));
    }

    #[test]
    fn contacts_along_a_path_are_no_place() {
        let mut refuge = Refuge::default();
        for x_in in 0..40 {
            assert_eq!(touch(&mut refuge, x_in * 25, 200), 0);
        }
    }

    #[test]
    fn switch_that_stays_closed_is_one_contact() {
        let mut refuge = Refuge::default();
        assert!((0..1000).all(|_| !refuge.ignores_light(true, &at(0), 200, EQUAL)));
    }
}
