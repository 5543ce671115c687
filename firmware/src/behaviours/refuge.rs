//! The dark place: whether a robot that avoids light stays where it has got to.
//!
//! Away from the light leads into the next corner behind it, and there it ends, however bright that corner is. So
//! a robot that keeps touching something about one place compares its darkness with the darkest that it has known
//! elsewhere. Where that was darker, or where it knows too few places to tell, it lets the light be for a while:
//! bumpers and prowl then lead it somewhere else.

use crate::odometry::Pose;
use crate::units::ticks;

/// So many contacts about one place: this is as far as the light drives it.
const CONTACTS: u8 = 4;

/// About one place: along both axes no farther than this from the first of them.
const ABOUT_IN: i32 = 24;

/// Places known before one of them is chosen.
const KNOWN: u8 = 2;

/// The light is let be for so long: 15 feet of way.
const ELSEWHERE_TICKS: u16 = ticks(15);

/// No reading is darker.
const DARK: i16 = 255;

/// What it knows of dark places.
#[derive(Clone, Debug, Default)]
pub struct Refuge {
    was_touching: bool,
    /// The first of the contacts, how many there have been, and the darkest reading at them.
    first_in: (i16, i16),
    contacts: u8,
    dark: i16,
    /// The darkest of the places that it has been driven to, and how many they were.
    darkest: i16,
    known: u8,
    elsewhere_ticks: u16,
}

impl Refuge {
    /// Once a tick, for a robot that avoids light: whether it lets the light be. `reading` is the mean of both
    /// cells, 0 bright to 255 dark; readings that differ by less than `equal` are the same.
    pub fn is_left(&mut self, is_touching: bool, pose: &Pose, reading: i16, equal: i16) -> bool {
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
        // What it does not find again it comes to expect less.
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

    /// One contact; for how many ticks it lets the light be then.
    fn touch(refuge: &mut Refuge, x_in: i16, reading: i16) -> u16 {
        let pose = at(x_in);
        let mut ticks = u16::from(refuge.is_left(true, &pose, reading, EQUAL));
        while ticks > 0 && refuge.is_left(false, &pose, reading, EQUAL) {
            ticks += 1;
        }
        refuge.is_left(false, &pose, reading, EQUAL);
        ticks
    }

    /// As many contacts about a place as it takes; whether it leaves.
    fn press(refuge: &mut Refuge, x_in: i16, reading: i16) -> bool {
        for _ in 1..CONTACTS {
            assert_eq!(touch(refuge, x_in, reading), 0);
        }
        touch(refuge, x_in, reading) > 0
    }

    /// One that has left two places, of 200 and 220.
    fn knows_two() -> Refuge {
        let mut refuge = Refuge::default();
        assert!(press(&mut refuge, 0, 200) && press(&mut refuge, 100, 220));
        refuge
    }

    #[test]
    fn it_leaves_the_first_two_places_and_stays_where_it_is_as_dark_as_it_ever_was() {
        assert!(!press(&mut knows_two(), 0, 216));
        assert!(!press(&mut knows_two(), 0, 240));
        assert!(press(&mut knows_two(), 0, 215));
    }

    #[test]
    fn what_it_does_not_find_again_it_comes_to_expect_less() {
        let mut refuge = knows_two();
        let left = (0..10).take_while(|_| press(&mut refuge, 0, 205)).count();
        assert_eq!(left, 3);
    }

    #[test]
    fn it_lets_the_light_be_for_a_quarter_of_a_minute() {
        let mut refuge = Refuge::default();
        for _ in 1..CONTACTS {
            touch(&mut refuge, 0, 200);
        }
        assert_eq!(touch(&mut refuge, 0, 200), 1 + ELSEWHERE_TICKS);
    }

    #[test]
    fn where_it_is_quite_dark_it_stays_at_once() {
        assert!(!press(&mut Refuge::default(), 0, 251));
        assert!(press(&mut Refuge::default(), 0, 250));
    }

    #[test]
    fn contacts_on_the_way_are_no_place() {
        let mut refuge = Refuge::default();
        for x_in in 0..40 {
            assert_eq!(touch(&mut refuge, x_in * 25, 200), 0);
        }
    }

    #[test]
    fn a_switch_that_stays_closed_is_one_contact() {
        let mut refuge = Refuge::default();
        assert!((0..1000).all(|_| !refuge.is_left(true, &at(0), 200, EQUAL)));
    }
}
