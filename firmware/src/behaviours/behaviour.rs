//! The behaviour layer: switches sensors off, and on again, for what has been detected lately.
//!
//! Not one of the eight: it moves nothing. Two rules, and a third that the infrared detectors keep
//! themselves (30 s of detection switch them off for 30 s):
//!
//! - Sonar rests while infrared has been seeing something for a while. Close to a wall echoes come back
//!   over two surfaces, and the longer view is the wrong one.
//! - Photo rests for a minute after six turns more one way than the other: it circles a lamp.

use crate::angle::Angle;
use crate::sensors::Senses;
use crate::units::ticks;
use groundwave_protocol::letters::{Layer, LayerMask};

/// No sensor is switched again before this time: line A is sent three times a second and shows each switch.
const DWELL_TICKS: u16 = ticks(2);

/// What a detection adds to the measure of closeness, which falls by one in each tick without.
const CLOSE_STEP: u8 = 8;

/// From here on the robot is close to something: five detections in a second.
const CLOSE_ENOUGH: u8 = 40;

/// Two seconds and a half after the last detection it no longer is.
const CLOSE_MOST: u8 = 50;

/// So many turns more to one side: it circles.
const CIRCLES: i32 = 6 * 0x1_0000;

/// Turns are forgotten over about 200 s, 4096 ticks: who wanders turns to both sides.
const FORGET_SHIFT: u32 = 12;

/// The lamp is left alone for this long.
const LEFT_ALONE_TICKS: u16 = ticks(60);

/// A sensor's switch.
#[derive(Clone, Debug, Default)]
struct Switch {
    is_off: bool,
    dwell_ticks: u16,
}

impl Switch {
    /// Off or on, when it has been what it is for long enough.
    fn set(&mut self, off: bool, dwell_ticks: u16) {
        if self.dwell_ticks > 0 {
            self.dwell_ticks -= 1;
        } else if off != self.is_off {
            self.is_off = off;
            self.dwell_ticks = dwell_ticks - 1;
        }
    }
}

/// What has been detected lately, and what follows from it.
#[derive(Clone, Debug, Default)]
pub struct SensorSwitches {
    sonar: Switch,
    photo: Switch,
    close: u8,
    turned: i32,
    heading: Option<Angle>,
}

impl SensorSwitches {
    /// Once a tick. `running` are the layers that run at this tick.
    pub fn watch(&mut self, senses: &Senses, running: LayerMask) {
        self.close = if senses.infrared.any() {
            (self.close + CLOSE_STEP).min(CLOSE_MOST)
        } else {
            self.close.saturating_sub(1)
        };
        // On again only when nothing at all is left of it.
        let least = if self.sonar.is_off { 1 } else { CLOSE_ENOUGH };
        self.sonar.set(self.close >= least, DWELL_TICKS);

        let heading = senses.pose.heading;
        let before = self.heading.replace(heading).unwrap_or(heading);
        self.turned += i32::from(heading.minus(before)) - (self.turned >> FORGET_SHIFT);
        if !running.contains(Layer::Photo) {
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

    /// The sensors that are off.
    #[must_use]
    pub fn off(&self) -> LayerMask {
        let mut off = LayerMask::NONE;
        for (layer, switch) in [(Layer::Sonar, &self.sonar), (Layer::Photo, &self.photo)] {
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
            ..Senses::nothing()
        }
    }

    #[test]
    fn sonar_rests_close_to_a_wall_and_comes_back_in_the_open() {
        let mut switches = SensorSwitches::default();
        let mut tick = |infrared| {
            switches.watch(&see(infrared, 0), LayerMask::ALL);
            switches.off().contains(Layer::Sonar)
        };
        // Now and then a detection is not close.
        assert!((0..400).all(|now| !tick(now % 20 == 0)));
        let until_off = (0..100).take_while(|_| !tick(true)).count();
        assert!((3..10).contains(&until_off), "{until_off}");
        assert!((0..100).all(|now| tick(now % 6 == 0)));
        let until_on = (0..100).take_while(|_| tick(false)).count();
        assert!((40..=60).contains(&until_on), "{until_on}");
    }

    #[test]
    fn photo_rests_for_a_minute_after_circling_a_lamp() {
        let mut switches = SensorSwitches::default();
        let mut heading = 0_u16;
        // A turn in 12 s.
        let mut tick = || {
            heading = heading.wrapping_add(273);
            let running = LayerMask::ALL.and(LayerMask::from_bits(!switches.off().bits()));
            switches.watch(&see(false, heading), running);
            switches.off().contains(Layer::Photo)
        };
        let until_off = (0..10_000).take_while(|_| !tick()).count();
        assert!((6 * 240..9 * 240).contains(&until_off), "{until_off}");
        let off = (0..10_000).take_while(|_| tick()).count();
        assert_eq!(off, 1199, "a minute, with the tick that switched it off");
    }

    #[test]
    fn who_turns_to_both_sides_does_not_circle() {
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
        fn no_sensor_is_switched_twice_within_two_seconds(
            seen in proptest::collection::vec((any::<bool>(), -2000_i16..4000, 1_u8..60), 1..60)
        ) {
            let (mut switches, mut heading, mut now) = (SensorSwitches::default(), 0_u16, 0_u32);
            let mut switched: [Option<u32>; 8] = [None; 8];
            for (infrared, turn, ticks) in seen {
                for _ in 0..ticks {
                    heading = heading.wrapping_add_signed(turn);
                    now += 1;
                    let before = switches.off();
                    switches.watch(&see(infrared, heading), LayerMask::ALL);
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
