//! Foraging: to the dock, on it until the battery is full, and off again.
//!
//! By convention the dock stands at the origin: the robot was set down before it, or was told its pose so.
//! Layer 7 goes there; as soon as a receiver sees the dock's beacon the robot follows that, slowly, until the
//! charger's voltage is on its contacts. Where the origin is reached and no beacon is seen, it looks around on
//! the spot and then from other places near by.

use crate::angle::Angle;
use crate::arbiter::Request;
use crate::board::{COUNTS_PER_IN, Side, Sides};
use crate::drive::Motion;
use crate::sensors::Senses;
use crate::units::ticks;
use groundwave_protocol::Waypoint;

/// Where the dock stands.
const DOCK: Waypoint = Waypoint { x_in: 0, y_in: 0 };

/// Straight at the beacon.
const APPROACH: Motion = Motion::new(4, 0);

/// Turning to it: 23 degrees a second.
const TURN_IN_S: i16 = 4;

/// Seen on one side only, it goes on a little while it turns.
const CURVE_IN_S: i16 = 1;

/// Looking around: 34 degrees a second, once round and a bit.
const LOOK_IN_S: i16 = 6;
const LOOK_TICKS: u16 = ticks(12);

/// Without the beacon for so long it has lost it.
const LOST_TICKS: u8 = ticks(10) as u8;

/// Following takes at most this long: the beacon is seen from some 15 feet.
const FOLLOW_TICKS: u16 = ticks(90);

/// How long it pushes on against what its bumper touches while the beacon is straight ahead: that is the dock.
const PUSH_TICKS: u8 = ticks(2) as u8;

/// Contacts that open for less than this have bounced.
const BOUNCE_TICKS: u8 = ticks(1) as u8;

/// Places to look around from lie within this distance of the dock, along each axis.
const NEAR_IN: u32 = 60;

/// Off the dock: far enough to turn.
const LEAVE_COUNTS: i16 = 18 * COUNTS_PER_IN as i16 * 2;
const LEAVE: Motion = Motion::new(-5, 0);
const LEAVE_TICKS: u8 = 6 * ticks(1) as u8;
const TURN_AWAY_TICKS: u8 = 6 * ticks(1) as u8;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// To a place, by dead reckoning.
    Go(Waypoint),
    /// On the spot.
    Look { ticks_left: u16 },
    /// After the beacon, last seen on this side.
    Follow {
        side: Side,
        unseen_ticks: u8,
        ticks_left: u16,
        pushed_ticks: u8,
    },
    /// On the dock.
    Docked { open_ticks: u8 },
    /// Backing off it.
    Leave {
        way_counts: i16,
        ticks_left: u8,
        /// What the bumper touched on the dock it touches still.
        touches: bool,
    },
    /// Turning round.
    TurnAway {
        left_to_go: i32,
        heading: Angle,
        ticks_left: u8,
    },
}

/// What there is to tell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum News {
    /// It stands on the dock.
    Docked,
    /// It is charged, off the dock and has turned away.
    Left,
}

/// The way to the dock and back.
#[derive(Clone, Debug)]
pub struct Docking {
    state: State,
    news: Option<News>,
}

impl Default for Docking {
    fn default() -> Self {
        Self {
            state: State::Go(DOCK),
            news: None,
        }
    }
}

impl Docking {
    /// Where it is on its way to by dead reckoning.
    #[must_use]
    pub const fn target(&self) -> Option<Waypoint> {
        match self.state {
            State::Go(place) => Some(place),
            _ => None,
        }
    }

    /// That place is reached: look around.
    pub const fn arrive(&mut self) {
        self.state = State::Look {
            ticks_left: LOOK_TICKS,
        };
    }

    /// Whether what is near is the dock, so that nothing may turn the robot from it.
    #[must_use]
    pub const fn is_near(&self) -> bool {
        !matches!(self.state, State::Go(_) | State::Look { .. })
    }

    /// Whether what the bumper touches is the dock.
    #[must_use]
    pub const fn touches_dock(&self) -> bool {
        match self.state {
            State::Go(_) | State::Look { .. } | State::TurnAway { .. } => false,
            State::Follow {
                unseen_ticks,
                pushed_ticks,
                ..
            } => unseen_ticks == 0 && pushed_ticks < PUSH_TICKS,
            State::Docked { .. } => true,
            State::Leave { touches, .. } => touches,
        }
    }

    /// What has happened in this tick.
    pub const fn take_news(&mut self) -> Option<News> {
        self.news.take()
    }

    /// `None` while it goes to a place by dead reckoning.
    pub fn decide(&mut self, senses: &Senses) -> Option<Request> {
        self.see(senses);
        let motion = match &mut self.state {
            State::Go(_) => return None,
            State::Look { ticks_left } => {
                *ticks_left -= 1;
                if *ticks_left == 0 {
                    self.state = State::Go(near_by(senses.dice));
                }
                Motion::new(0, LOOK_IN_S)
            }
            State::Follow { .. } => self.follow(senses),
            State::Docked { open_ticks } => {
                *open_ticks = if senses.is_docked { 0 } else { *open_ticks + 1 };
                if *open_ticks >= BOUNCE_TICKS {
                    self.state = State::Look {
                        ticks_left: LOOK_TICKS,
                    };
                } else if senses.is_charged {
                    self.state = State::Leave {
                        way_counts: 0,
                        ticks_left: LEAVE_TICKS,
                        touches: senses.bumper.any(),
                    };
                }
                Motion::STILL
            }
            State::Leave {
                way_counts,
                ticks_left,
                touches,
            } => {
                *touches &= senses.bumper.any();
                *way_counts = way_counts.saturating_add(senses.way_counts);
                *ticks_left -= 1;
                if *way_counts <= -LEAVE_COUNTS || *ticks_left == 0 {
                    self.state = State::TurnAway {
                        left_to_go: 0x8000,
                        heading: senses.pose.heading,
                        ticks_left: TURN_AWAY_TICKS,
                    };
                }
                LEAVE
            }
            State::TurnAway {
                left_to_go,
                heading,
                ticks_left,
            } => {
                *left_to_go -= i32::from(senses.pose.heading.minus(*heading));
                *heading = senses.pose.heading;
                *ticks_left -= 1;
                if *left_to_go <= 0 || *ticks_left == 0 {
                    self.news = Some(News::Left);
                    *self = Self {
                        news: self.news,
                        ..Self::default()
                    };
                }
                Motion::new(0, LOOK_IN_S)
            }
        };
        Some(Request::raise(motion))
    }

    /// The beacon and the contacts decide, whatever it was about; but not on the way off.
    fn see(&mut self, senses: &Senses) {
        let is_leaving = matches!(self.state, State::Leave { .. } | State::TurnAway { .. });
        if is_leaving || matches!(self.state, State::Docked { .. }) {
            return;
        }
        if senses.is_docked {
            self.state = State::Docked { open_ticks: 0 };
            self.news = Some(News::Docked);
            return;
        }
        let beacon = senses.beacon.unwrap_or_default();
        if beacon.any() && !matches!(self.state, State::Follow { .. }) {
            self.state = State::Follow {
                side: Side::Left,
                unseen_ticks: 0,
                ticks_left: FOLLOW_TICKS,
                pushed_ticks: 0,
            };
        }
    }

    fn follow(&mut self, senses: &Senses) -> Motion {
        let beacon = senses.beacon.unwrap_or_default();
        let State::Follow {
            side,
            unseen_ticks,
            ticks_left,
            pushed_ticks,
        } = &mut self.state
        else {
            return Motion::STILL;
        };
        *ticks_left -= 1;
        *unseen_ticks = if beacon.any() { 0 } else { *unseen_ticks + 1 };
        if *ticks_left == 0 || *unseen_ticks >= LOST_TICKS {
            self.state = State::Go(near_by(senses.dice));
            return Motion::STILL;
        }
        let is_ahead = beacon.left && beacon.right;
        *pushed_ticks = match (senses.bumper.any(), is_ahead) {
            (true, true) => pushed_ticks.saturating_add(1),
            (true, false) => PUSH_TICKS,
            (false, _) => 0,
        };
        let turn = |side| match side {
            Side::Left => -TURN_IN_S,
            Side::Right => TURN_IN_S,
        };
        match beacon {
            Sides {
                left: true,
                right: true,
            } => APPROACH,
            Sides {
                left: false,
                right: false,
            } => Motion::new(0, turn(*side)),
            Sides { left, .. } => {
                *side = if left { Side::Left } else { Side::Right };
                Motion::new(CURVE_IN_S, turn(*side))
            }
        }
    }
}

/// A place to look around from.
const fn near_by(dice: u32) -> Waypoint {
    let span = 2 * NEAR_IN + 1;
    Waypoint {
        x_in: ((dice & 0xFFFF) % span) as i16 - NEAR_IN as i16,
        y_in: ((dice >> 16) % span) as i16 - NEAR_IN as i16,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn beacon(left: bool, right: bool) -> Senses<'static> {
        Senses {
            beacon: Some(Sides { left, right }),
            ..Senses::nothing()
        }
    }

    fn motion(docking: &mut Docking, senses: &Senses) -> Motion {
        docking.decide(senses).expect("it is near the dock").motion
    }

    #[test]
    fn it_goes_to_the_origin_looks_around_and_then_elsewhere_near_by() {
        let mut docking = Docking::default();
        let nothing = Senses::nothing();
        assert_eq!(docking.decide(&nothing), None);
        assert_eq!(docking.target(), Some(DOCK));
        docking.arrive();
        for _ in 0..LOOK_TICKS {
            assert_eq!(motion(&mut docking, &nothing), Motion::new(0, LOOK_IN_S));
        }
        let elsewhere = docking.target().expect("a place");
        assert!(elsewhere.x_in.abs() <= 60 && elsewhere.y_in.abs() <= 60);
    }

    #[test]
    fn it_turns_to_the_beacon_and_follows_it() {
        let mut docking = Docking::default();
        assert!(motion(&mut docking, &beacon(true, false)).rotation_cps < 0);
        assert!(docking.is_near());
        assert!(motion(&mut docking, &beacon(false, true)).rotation_cps > 0);
        assert_eq!(motion(&mut docking, &beacon(true, true)), APPROACH);
        // Lost: on the way it was turning last, and at last to look elsewhere.
        let unseen = beacon(false, false);
        assert!(motion(&mut docking, &unseen).rotation_cps > 0);
        for _ in 0..LOST_TICKS {
            docking.decide(&unseen);
        }
        assert!(docking.target().is_some());
    }

    #[test]
    fn a_bump_straight_at_the_beacon_is_the_dock_for_two_seconds() {
        let mut docking = Docking::default();
        let mut ahead = beacon(true, true);
        docking.decide(&ahead);
        ahead.bumper.center = true;
        for tick in 1..PUSH_TICKS {
            assert_eq!(motion(&mut docking, &ahead), APPROACH);
            assert!(docking.touches_dock(), "tick {tick}");
        }
        docking.decide(&ahead);
        assert!(!docking.touches_dock());
        let mut aside = beacon(true, false);
        aside.bumper.left = true;
        let mut docking = Docking::default();
        docking.decide(&aside);
        assert!(!docking.touches_dock(), "something else");
    }

    #[test]
    fn on_the_dock_it_stands_until_it_is_charged_and_then_backs_off_and_turns() {
        let mut docking = Docking::default();
        let mut senses = beacon(true, true);
        senses.is_docked = true;
        assert_eq!(motion(&mut docking, &senses), Motion::STILL);
        assert_eq!(docking.take_news(), Some(News::Docked));
        for _ in 0..1000 {
            assert_eq!(motion(&mut docking, &senses), Motion::STILL);
            assert!(docking.touches_dock() && docking.take_news().is_none());
        }
        // The contacts bounce.
        senses.is_docked = false;
        for _ in 1..BOUNCE_TICKS {
            assert_eq!(motion(&mut docking, &senses), Motion::STILL);
        }
        senses.is_docked = true;
        senses.is_charged = true;
        docking.decide(&senses);
        senses.is_docked = false;
        senses.way_counts = -8;
        let mut backed = 0;
        loop {
            let motion = motion(&mut docking, &senses);
            if motion != LEAVE {
                break;
            }
            backed += 8;
        }
        assert_eq!(backed, i32::from(LEAVE_COUNTS));
        let mut ticks = 0;
        while docking.take_news() != Some(News::Left) {
            senses.pose.heading.0 = senses.pose.heading.0.wrapping_add(300);
            docking.decide(&senses);
            ticks += 1;
        }
        assert!((105..=112).contains(&ticks), "{ticks} ticks of 300");
        assert_eq!(docking.target(), Some(DOCK), "next time from the beginning");
    }

    #[test]
    fn on_its_way_off_only_what_it_touched_on_the_dock_is_the_dock() {
        let mut docking = Docking::default();
        let mut senses = beacon(true, true);
        senses.is_docked = true;
        senses.is_charged = true;
        senses.bumper.center = true;
        docking.decide(&senses);
        assert_eq!(motion(&mut docking, &senses), LEAVE);
        assert!(docking.touches_dock(), "not yet off it");
        senses.bumper.center = false;
        docking.decide(&senses);
        senses.bumper.left = true;
        docking.decide(&senses);
        assert!(!docking.touches_dock(), "somebody in its way");
        while motion(&mut docking, &senses) == LEAVE {}
        assert!(!docking.touches_dock(), "nor while it turns away");
    }

    #[test]
    fn torn_off_the_dock_it_looks_for_it() {
        let mut docking = Docking::default();
        let mut senses = beacon(false, false);
        senses.is_docked = true;
        docking.decide(&senses);
        senses.is_docked = false;
        for _ in 0..BOUNCE_TICKS {
            motion(&mut docking, &senses);
        }
        assert_eq!(motion(&mut docking, &senses), Motion::new(0, LOOK_IN_S));
    }
}
