//! Foraging: to the dock, charging until the battery is full, and off the dock.
//!
//! By convention the dock is at the origin: the robot starts in front of it, or its pose has been set accordingly. Layer 7
//! drives there. As soon as a receiver detects the dock's beacon, the robot follows it slowly until the charger's voltage
//! is on its contacts. If it reaches the origin without the beacon, it scans on the spot and then from other positions
//! nearby.

use crate::angle::Angle;
use crate::arbiter::Request;
use crate::board::{COUNTS_PER_IN, Side, Sides};
use crate::drive::Motion;
use crate::sensors::Senses;
use crate::units::ticks;
use groundwave_protocol::Waypoint;

/// Position of the dock.
const DOCK: Waypoint = Waypoint { x_in: 0, y_in: 0 };

/// Approach straight at the beacon.
const APPROACH: Motion = Motion::new(4, 0);

/// Speed of turning to the beacon: 23 degrees per second.
const TURN_IN_S: i16 = 4;

/// Forward speed while the beacon is on one side only, in/s.
const CURVE_IN_S: i16 = 1;

/// Rotation while the robot looks for the beacon, 34 degrees per second, and its duration, a little more than a turn.
const SCAN_IN_S: i16 = 6;
const SCAN_TICKS: u16 = ticks(12);

/// Number of ticks without the beacon after which it is lost.
const LOST_TICKS: u8 = ticks(10) as u8;

/// Maximum duration of following: the beacon is visible from about 15 feet.
const FOLLOW_TICKS: u16 = ticks(90);

/// Number of ticks of pushing against a contact with the beacon straight ahead: the contact is the dock.
const PUSH_TICKS: u8 = ticks(2) as u8;

/// Maximum number of ticks for which bouncing contacts may open.
const BOUNCE_TICKS: u8 = ticks(1) as u8;

/// Maximum distance from the dock of other scan positions, along each axis, inches.
const NEAR_IN: u32 = 60;

/// Backing off the dock: far enough to turn.
const LEAVE_COUNTS: i16 = 18 * COUNTS_PER_IN as i16 * 2;
const LEAVE: Motion = Motion::new(-5, 0);
const LEAVE_TICKS: u8 = 6 * ticks(1) as u8;
const TURN_AWAY_TICKS: u8 = 6 * ticks(1) as u8;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// Drives to a position by dead reckoning.
    Go(Waypoint),
    /// Scans on the spot.
    Scan { ticks_left: u16 },
    /// Follows the beacon, last detected on this side.
    Follow {
        side: Side,
        unseen_ticks: u8,
        ticks_left: u16,
        pushed_ticks: u8,
    },
    /// Stands on the dock.
    Docked { open_ticks: u8 },
    /// Backs off the dock.
    Leave {
        path_counts: i16,
        ticks_left: u8,
        /// Whether the contact on the dock still lasts.
        touches: bool,
    },
    /// Turns around.
    TurnAway {
        left_to_go: i32,
        heading: Angle,
        ticks_left: u8,
    },
}

/// Events of docking.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DockingEvent {
    /// The robot stands on the dock.
    Docked,
    /// The robot is charged, off the dock and has turned away.
    Left,
}

/// State of docking.
#[derive(Clone, Debug)]
pub struct Docking {
    state: State,
    event: Option<DockingEvent>,
}

impl Default for Docking {
    fn default() -> Self {
        Self {
            state: State::Go(DOCK),
            event: None,
        }
    }
}

impl Docking {
    /// Target of dead reckoning.
    #[must_use]
    pub const fn target(&self) -> Option<Waypoint> {
        match self.state {
            State::Go(place) => Some(place),
            _ => None,
        }
    }

    /// Handles the arrival at the target: starts a scan.
    pub const fn arrive(&mut self) {
        self.state = State::Scan {
            ticks_left: SCAN_TICKS,
        };
    }

    /// Whether the robot is near the dock and no layer may turn it away.
    #[must_use]
    pub const fn is_near(&self) -> bool {
        !matches!(self.state, State::Go(_) | State::Scan { .. })
    }

    /// Whether the bumper touches the dock.
    #[must_use]
    pub const fn touches_dock(&self) -> bool {
        match self.state {
            State::Go(_) | State::Scan { .. } | State::TurnAway { .. } => false,
            State::Follow {
                unseen_ticks,
                pushed_ticks,
                ..
            } => unseen_ticks == 0 && pushed_ticks < PUSH_TICKS,
            State::Docked { .. } => true,
            State::Leave { touches, .. } => touches,
        }
    }

    /// Event of this tick.
    pub const fn take_event(&mut self) -> Option<DockingEvent> {
        self.event.take()
    }

    /// Request of this tick; `None` while dead reckoning drives to a position.
    pub fn decide(&mut self, senses: &Senses) -> Option<Request> {
        self.see(senses);
        let motion = match &mut self.state {
            State::Go(_) => return None,
            State::Scan { ticks_left } => {
                *ticks_left -= 1;
                if *ticks_left == 0 {
                    self.state = State::Go(near_by(senses.random));
                }
                Motion::new(0, SCAN_IN_S)
            }
            State::Follow { .. } => self.follow(senses),
            State::Docked { open_ticks } => {
                *open_ticks = if senses.is_docked { 0 } else { *open_ticks + 1 };
                if *open_ticks >= BOUNCE_TICKS {
                    self.state = State::Scan {
                        ticks_left: SCAN_TICKS,
                    };
                } else if senses.is_charged {
                    self.state = State::Leave {
                        path_counts: 0,
                        ticks_left: LEAVE_TICKS,
                        touches: senses.bumper.any(),
                    };
                }
                Motion::STILL
            }
            State::Leave {
                path_counts,
                ticks_left,
                touches,
            } => {
                *touches &= senses.bumper.any();
                *path_counts = path_counts.saturating_add(senses.path_counts);
                *ticks_left -= 1;
                if *path_counts <= -LEAVE_COUNTS || *ticks_left == 0 {
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
                    self.event = Some(DockingEvent::Left);
                    *self = Self {
                        event: self.event,
                        ..Self::default()
                    };
                }
                Motion::new(0, SCAN_IN_S)
            }
        };
        Some(Request::raise(motion))
    }

    /// Handles beacon and contacts, except while leaving the dock.
    fn see(&mut self, senses: &Senses) {
        let is_leaving = matches!(self.state, State::Leave { .. } | State::TurnAway { .. });
        if is_leaving || matches!(self.state, State::Docked { .. }) {
            return;
        }
        if senses.is_docked {
            self.state = State::Docked { open_ticks: 0 };
            self.event = Some(DockingEvent::Docked);
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
            self.state = State::Go(near_by(senses.random));
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

/// A random position near the dock to scan from.
const fn near_by(random: u32) -> Waypoint {
    let span = 2 * NEAR_IN + 1;
    Waypoint {
        x_in: ((random & 0xFFFF) % span) as i16 - NEAR_IN as i16,
        y_in: ((random >> 16) % span) as i16 - NEAR_IN as i16,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn beacon(left: bool, right: bool) -> Senses<'static> {
        Senses {
            beacon: Some(Sides { left, right }),
            ..Senses::idle()
        }
    }

    fn motion(docking: &mut Docking, senses: &Senses) -> Motion {
        docking
            .decide(senses)
            .expect("the robot is near the dock")
            .motion
    }

    #[test]
    fn missing_beacon_leads_to_scans_at_the_origin_and_nearby() {
        let mut docking = Docking::default();
        let idle = Senses::idle();
        assert_eq!(docking.decide(&idle), None);
        assert_eq!(docking.target(), Some(DOCK));
        docking.arrive();
        for _ in 0..SCAN_TICKS {
            assert_eq!(motion(&mut docking, &idle), Motion::new(0, SCAN_IN_S));
        }
        let elsewhere = docking.target().expect("there is a position");
        assert!(elsewhere.x_in.abs() <= 60 && elsewhere.y_in.abs() <= 60);
    }

    #[test]
    fn beacon_is_turned_to_and_followed() {
        let mut docking = Docking::default();
        assert!(motion(&mut docking, &beacon(true, false)).rotation_cps < 0);
        assert!(docking.is_near());
        assert!(motion(&mut docking, &beacon(false, true)).rotation_cps > 0);
        assert_eq!(motion(&mut docking, &beacon(true, true)), APPROACH);
        // Lost: first turn in the latest direction, at last scan elsewhere.
        let unseen = beacon(false, false);
        assert!(motion(&mut docking, &unseen).rotation_cps > 0);
        for _ in 0..LOST_TICKS {
            docking.decide(&unseen);
        }
        assert!(docking.target().is_some());
    }

    #[test]
    fn contact_straight_ahead_is_the_dock_for_two_seconds() {
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
        assert!(!docking.touches_dock(), "another obstacle");
    }

    #[test]
    fn docked_robot_waits_until_charged_then_backs_off_and_turns() {
        let mut docking = Docking::default();
        let mut senses = beacon(true, true);
        senses.is_docked = true;
        assert_eq!(motion(&mut docking, &senses), Motion::STILL);
        assert_eq!(docking.take_event(), Some(DockingEvent::Docked));
        for _ in 0..1000 {
            assert_eq!(motion(&mut docking, &senses), Motion::STILL);
            assert!(docking.touches_dock() && docking.take_event().is_none());
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
        senses.path_counts = -8;
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
        while docking.take_event() != Some(DockingEvent::Left) {
            senses.pose.heading.0 = senses.pose.heading.0.wrapping_add(300);
            docking.decide(&senses);
            ticks += 1;
        }
        assert!((105..=112).contains(&ticks), "{ticks} ticks of 300");
        assert_eq!(
            docking.target(),
            Some(DOCK),
            "the next docking starts again"
        );
    }

    #[test]
    fn contact_while_leaving_is_the_dock_only_until_released() {
        let mut docking = Docking::default();
        let mut senses = beacon(true, true);
        senses.is_docked = true;
        senses.is_charged = true;
        senses.bumper.center = true;
        docking.decide(&senses);
        assert_eq!(motion(&mut docking, &senses), LEAVE);
        assert!(docking.touches_dock(), "still at the dock");
        senses.bumper.center = false;
        docking.decide(&senses);
        senses.bumper.left = true;
        docking.decide(&senses);
        assert!(!docking.touches_dock(), "another obstacle");
        while motion(&mut docking, &senses) == LEAVE {}
        assert!(!docking.touches_dock(), "not the dock while turning away");
    }

    #[test]
    fn lost_contacts_start_a_scan() {
        let mut docking = Docking::default();
        let mut senses = beacon(false, false);
        senses.is_docked = true;
        docking.decide(&senses);
        senses.is_docked = false;
        for _ in 0..BOUNCE_TICKS {
            motion(&mut docking, &senses);
        }
        assert_eq!(motion(&mut docking, &senses), Motion::new(0, SCAN_IN_S));
    }
}
