//! The behaviour layer: switches sensors off and on according to recent detections.
//!
//! It is not one of the eight layers, because it does not move the robot. It has three rules; the infrared detectors apply a fourth
//! themselves (30 s of detections switch them off for 30 s):
//!
//! - Sonar is off after it has led the robot to the side on which infrared detects an obstacle. Close to an oblique wall
//!   the first echo returns by way of a second surface, so the wall appears farther away than the open side.
//! - Photo is off for a minute after twelve more turns to one side than to the other: the robot circles a lamp.
//! - Infrared is off when a reactive robot has moved for a minute without coming to rest, for 30 s and while it then
//!   stands: between walls four feet apart no place is free of detections.

use crate::angle::Angle;
use crate::parameters::Parameter;
use crate::sensors::Senses;
use crate::units::ticks;
use groundwave_protocol::status_codes::{Layer, LayerMask, Mode};

/// Minimum number of ticks between two switchings of a sensor: line A shows each state.
const DWELL_TICKS: u16 = ticks(2);

/// Number of ticks for which a side counts as close after an infrared detection.
const CLOSE_TICKS: u8 = ticks(1) as u8;

/// Doubt at which sonar is switched off. Doubt rises by one per contradicting tick and falls by one in any other tick, so this is two and a half seconds of contradiction, which the mouth of a passage rarely causes.
const DOUBT_ENOUGH: u8 = 50;

/// Maximum doubt: sonar is on again two and a half seconds after the last contradiction.
const DOUBT_MOST: u8 = 50;

/// Maximum sonar range that can be compared with infrared, inches.
const NEAR_IN: u32 = 40;

/// Ratio in percent above which one sonar range counts as longer than the other.
const LONGER_PCT: u32 = 135;

/// Net turn to one side that counts as circling.
const CIRCLES: i32 = 12 * 0x1_0000;

/// Decay of the net turn over about 200 s, 4096 ticks: a wandering robot turns to both sides.
const FORGET_SHIFT: u32 = 12;

/// Number of ticks for which photo stays off after circling.
const LEFT_ALONE_TICKS: u16 = ticks(60);

/// Number of ticks of movement after which a reactive robot is restless.
const RESTLESS_TICKS: u16 = ticks(60);

/// Number of ticks of standing that count as rest: longer than a jam, after which the detectors wake the robot again.
const RESTED_TICKS: u16 = ticks(40);

/// Minimum number of ticks without infrared for a restless robot.
const UNSEEING_TICKS: u16 = ticks(30);

/// On-off state of a sensor.
#[derive(Clone, Debug, Default)]
struct Switch {
    is_off: bool,
    dwell_ticks: u16,
}

impl Switch {
    /// Switches the sensor if its current state has lasted long enough.
    fn set(&mut self, off: bool, dwell_ticks: u16) {
        if self.dwell_ticks > 0 {
            self.dwell_ticks -= 1;
        } else if off != self.is_off {
            self.is_off = off;
            self.dwell_ticks = dwell_ticks - 1;
        }
    }
}

/// Recent detections and the resulting switch states.
#[derive(Clone, Debug, Default)]
pub struct SensorSwitches {
    sonar: Switch,
    photo: Switch,
    infrared: Switch,
    /// Ticks left for which the left and the right side count as close.
    close_ticks: [u8; 2],
    doubt: u8,
    stand_ticks: u16,
    restless_ticks: u16,
    turned: i32,
    heading: Option<Angle>,
}

impl SensorSwitches {
    /// Updates the states once per tick; `running` are the layers that run in this tick.
    pub fn watch(&mut self, senses: &Senses, running: LayerMask) {
        self.doubt = if self.contradicts(senses) {
            (self.doubt + 1).min(DOUBT_MOST)
        } else {
            self.doubt.saturating_sub(1)
        };
        // Sonar returns only when no doubt is left.
        let least = if self.sonar.is_off { 1 } else { DOUBT_ENOUGH };
        self.sonar.set(self.doubt >= least, DWELL_TICKS);

        self.stand_ticks = if senses.is_standing {
            self.stand_ticks.saturating_add(1)
        } else {
            0
        };
        if senses.mode != Mode::Reactive || self.stand_ticks >= RESTED_TICKS {
            self.restless_ticks = 0;
        } else if !senses.is_standing {
            self.restless_ticks = self.restless_ticks.saturating_add(1);
        }
        let is_restless = self.restless_ticks >= RESTLESS_TICKS;
        let stays_off = self.infrared.is_off && senses.is_standing;
        let dwell_ticks = if is_restless {
            UNSEEING_TICKS
        } else {
            DWELL_TICKS
        };
        self.infrared.set(is_restless || stays_off, dwell_ticks);

        let heading = senses.pose.heading;
        let before = self.heading.replace(heading).unwrap_or(heading);
        self.turned += i32::from(heading.minus(before)) - (self.turned >> FORGET_SHIFT);
        if !running.contains(Layer::Photo) || senses.parameters.is_on(Parameter::PhotoAvoid) {
            self.turned = 0;
        }
        let circles = self.turned.abs() >= CIRCLES;
        let dwell_ticks = if circles {
            LEFT_ALONE_TICKS
        } else {
            DWELL_TICKS
        };
        self.photo.set(circles, dwell_ticks);
    }

    /// Whether the longer range is on the one side on which infrared detects an obstacle.
    fn contradicts(&mut self, senses: &Senses) -> bool {
        let seen = [senses.infrared.left, senses.infrared.right];
        for (ticks, seen) in self.close_ticks.iter_mut().zip(seen) {
            *ticks = if seen {
                CLOSE_TICKS
            } else {
                ticks.saturating_sub(1)
            };
        }
        let view = |range_in: Option<u16>| u32::from(range_in.unwrap_or(u16::MAX));
        let (left_in, right_in) = (view(senses.sonar.left_in), view(senses.sonar.right_in));
        let longer = |this_in: u32, other_in: u32| {
            other_in < NEAR_IN && this_in * 100 > other_in * LONGER_PCT
        };
        match self.close_ticks.map(|ticks| ticks > 0) {
            [true, false] => longer(left_in, right_in),
            [false, true] => longer(right_in, left_in),
            _ => false,
        }
    }

    /// Sensors that are switched off.
    #[must_use]
    pub fn off(&self) -> LayerMask {
        let mut off = LayerMask::NONE;
        let switches = [
            (Layer::Infrared, &self.infrared),
            (Layer::Sonar, &self.sonar),
            (Layer::Photo, &self.photo),
        ];
        for (layer, switch) in switches {
            if switch.is_off {
                off = off.with(layer);
            }
        }
        off
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::board::Sides;
    use crate::odometry::Odometer;
    use crate::sensors::Ranges;
    use groundwave_protocol::Waypoint;
    use proptest::prelude::*;

    fn see(infrared: bool, heading: u16) -> Senses<'static> {
        let mut odometer = Odometer::default();
        odometer.set(Waypoint { x_in: 0, y_in: 0 }, Angle(heading));
        Senses {
            infrared: Sides {
                left: infrared,
                right: false,
            },
            pose: odometer.pose(),
            ..Senses::idle()
        }
    }

    #[test]
    fn sonar_is_off_after_leading_to_the_side_of_infrared() {
        let mut switches = SensorSwitches::default();
        // Infrared detects an obstacle on the left.
        let mut tick = |left_in, right_in| {
            let senses = Senses {
                sonar: Ranges {
                    left_in: Some(left_in),
                    right_in: Some(right_in),
                },
                ..see(true, 0)
            };
            switches.watch(&senses, LayerMask::ALL);
            switches.off().contains(Layer::Sonar)
        };
        assert!((0..400).all(|_| !tick(30, 100)), "both sensors agree");
        assert!((0..400).all(|_| !tick(100, 100)));
        let until_off = (0..100).take_while(|_| !tick(100, 30)).count();
        assert!((48..=52).contains(&until_off), "{until_off}");
        assert!((0..400).all(|_| tick(100, 30)));
        let until_on = (0..100).take_while(|_| tick(30, 100)).count();
        assert!((48..=52).contains(&until_on), "{until_on}");
    }

    #[test]
    fn photo_is_off_for_a_minute_after_circling_a_lamp() {
        let mut switches = SensorSwitches::default();
        let mut heading = 0_u16;
        // A turn in 8 s.
        let mut tick = || {
            heading = heading.wrapping_add(410);
            let running = LayerMask::ALL.and(LayerMask::from_bits(!switches.off().bits()));
            switches.watch(&see(false, heading), running);
            switches.off().contains(Layer::Photo)
        };
        let until_off = (0..10_000).take_while(|_| !tick()).count();
        assert!((12 * 160..24 * 160).contains(&until_off), "{until_off}");
        let off = (0..10_000).take_while(|_| tick()).count();
        assert_eq!(off, 1199, "a minute, with the tick that switched it off");
    }

    #[test]
    fn infrared_is_off_for_a_restless_reactive_robot() {
        for (mode, expected) in [(Mode::Reactive, 1199), (Mode::Prowl, 5000)] {
            let mut switches = SensorSwitches::default();
            let mut tick = |is_standing| {
                let senses = Senses {
                    mode,
                    is_standing,
                    ..see(true, 0)
                };
                switches.watch(&senses, LayerMask::ALL);
                switches.off().contains(Layer::Infrared)
            };
            let until_off = (0..5000).take_while(|_| !tick(false)).count();
            assert_eq!(until_off, expected);
            if mode == Mode::Reactive {
                assert!(
                    (0..5000).all(|_| tick(true)),
                    "infrared is off while the robot stands"
                );
                assert!(!tick(false));
            }
        }
    }

    #[test]
    fn turns_to_both_sides_are_no_circling() {
        let mut switches = SensorSwitches::default();
        for turn in 0..100_u16 {
            for step in 0..240_u16 {
                let heading = if turn % 2 == 0 { step } else { 240 - step };
                switches.watch(&see(false, heading.wrapping_mul(600)), LayerMask::ALL);
                assert_eq!(switches.off(), LayerMask::NONE);
            }
        }
    }

    proptest! {
        #[test]
        fn sensors_are_not_switched_twice_within_two_seconds(
            seen in proptest::collection::vec((any::<bool>(), any::<bool>(), -2000_i16..4000, 1_u8..60), 1..60)
        ) {
            let (mut switches, mut heading, mut now) = (SensorSwitches::default(), 0_u16, 0_u32);
            let mut switched: [Option<u32>; 8] = [None; 8];
            for (infrared, longer, turn, ticks) in seen {
                for _ in 0..ticks {
                    heading = heading.wrapping_add_signed(turn);
                    now += 1;
                    let before = switches.off();
                    let senses = Senses {
                        sonar: Ranges {
                            left_in: Some(if longer { 100 } else { 30 }),
                            right_in: Some(35),
                        },
                        ..see(infrared, heading)
                    };
                    switches.watch(&senses, LayerMask::ALL);
                    let changed = before.bits() ^ switches.off().bits();
                    for (bit, latest) in switched.iter_mut().enumerate() {
                        if changed >> bit & 1 != 0 {
                            prop_assert!(latest.is_none_or(|then| now - then >= 40));
                            *latest = Some(now);
                        }
                    }
                }
            }
        }
    }
}
