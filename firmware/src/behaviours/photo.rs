//! Layer 5: photocells. Toward the brighter side, or away from it.

use super::Behaviour;
use crate::arbiter::Request;
use crate::drive::Motion;
use crate::parameters::Parameter;
use crate::sensors::Senses;
use crate::units::{cps, ticks};
use groundwave_protocol::letters::Mode;

/// Rotation for each 256th by which the cells differ: 32 of them, a lamp well to one side, turn at 8 in/s.
const TURN_PER_STEP_CPS: i16 = cps(8) / 32;

/// The sharpest turn, 57 degrees a second, at which the robot still drives on.
const TURN_MOST_CPS: i16 = cps(10);

/// A change of the light as a whole by so many deadzones is one that somebody has made.
const STARTLE_DEADZONES: i16 = 2;

/// It pulls for this long.
const STARTLE_TICKS: u8 = ticks(1) as u8;

/// What the light as a whole has been is averaged over about 1.6 s.
const AMBIENT_SHIFT: u32 = 5;

/// Parts of a step in that average.
const PARTS: i16 = 32;

/// What it remembers of the light.
#[derive(Clone, Debug, Default)]
pub struct Photo {
    is_turning: bool,
    /// The mean of both cells, averaged, in [`PARTS`]; `None` before the first reading.
    ambient: Option<i16>,
    startle: Option<Startle>,
}

/// Somebody has switched a light.
#[derive(Clone, Copy, Debug)]
struct Startle {
    brighter: bool,
    ticks_left: u8,
}

impl Photo {
    /// A robot at rest feels a lamp that goes on or off straight ahead, where both cells see it alike.
    /// One that drives meets shadows all the time.
    fn feel(&mut self, senses: &Senses, mean: i16, deadzone: i16) {
        let ambient = self.ambient.get_or_insert(mean * PARTS);
        let change = *ambient / PARTS - mean;
        *ambient += (mean * PARTS - *ambient) >> AMBIENT_SHIFT;
        if !senses.is_standing || senses.mode != Mode::Reactive {
            return;
        }
        if change.abs() > STARTLE_DEADZONES * deadzone.max(1) {
            *ambient = mean * PARTS;
            self.startle = Some(Startle {
                brighter: change > 0,
                ticks_left: STARTLE_TICKS,
            });
        }
    }
}

impl Behaviour for Photo {
    fn decide(&mut self, senses: &Senses) -> Request {
        let Some((left, right)) = senses.photo else {
            self.rest();
            return Request::QUIET;
        };
        let deadzone = senses.parameters.get(Parameter::PhotoDeadzone);
        let avoids = senses.parameters.is_on(Parameter::PhotoAvoid);
        self.feel(senses, i16::from(u8::midpoint(left, right)), deadzone);

        let (left, right) = (i16::from(left), i16::from(right));
        // 0 is bright: a positive difference is light on the right.
        let difference = if avoids { right - left } else { left - right };
        // Half the deadzone ends a turn that the whole one began, so that noise at its edge does not
        // begin it again and again.
        let enough = if self.is_turning {
            deadzone / 2
        } else {
            deadzone
        };
        self.is_turning = difference.abs() > enough;
        if self.is_turning {
            let turn = difference.saturating_mul(TURN_PER_STEP_CPS);
            return Request::raise(Motion {
                velocity_cps: senses.top_cps(),
                rotation_cps: turn.clamp(-TURN_MOST_CPS, TURN_MOST_CPS),
            });
        }
        let Some(startle) = &mut self.startle else {
            return Request::QUIET;
        };
        startle.ticks_left -= 1;
        let pulls = startle.brighter != avoids;
        if startle.ticks_left == 0 {
            self.startle = None;
        }
        Request::raise(if pulls {
            Motion {
                velocity_cps: senses.top_cps(),
                rotation_cps: 0,
            }
        } else {
            Motion {
                velocity_cps: 0,
                rotation_cps: senses.the_way_it_turns(TURN_MOST_CPS),
            }
        })
    }

    fn rest(&mut self) {
        *self = Self::default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::Parameters;

    fn see(left: u8, right: u8) -> Senses<'static> {
        Senses {
            photo: Some((left, right)),
            ..Senses::nothing()
        }
    }

    fn decide(left: u8, right: u8) -> Request {
        Photo::default().decide(&see(left, right))
    }

    #[test]
    fn it_turns_to_the_brighter_side_the_more_the_cells_differ() {
        let turns = [109, 120, 132, 200].map(|dark| decide(dark, 100).motion.rotation_cps);
        assert!(turns[0] > 0 && turns.is_sorted(), "{turns:?}");
        assert_eq!(turns[3], TURN_MOST_CPS);
        assert_eq!(decide(100, 120).motion.rotation_cps, -turns[1]);
        assert_eq!(
            decide(255, 0).motion.velocity_cps,
            Senses::nothing().top_cps()
        );
    }

    #[test]
    fn told_to_avoid_it_turns_away() {
        let mut parameters = Parameters::default();
        assert!(parameters.set(Parameter::PhotoAvoid, 1));
        let senses = Senses {
            parameters: &parameters,
            photo: Some((120, 100)),
            ..Senses::nothing()
        };
        let away = Photo::default().decide(&senses).motion.rotation_cps;
        assert_eq!(away, -decide(120, 100).motion.rotation_cps);
    }

    #[test]
    fn within_the_deadzone_it_is_quiet() {
        assert_eq!(decide(108, 100), Request::QUIET);
        assert!(decide(109, 100).flag);
        assert_eq!(Photo::default().decide(&Senses::nothing()), Request::QUIET);
    }

    #[test]
    fn noise_at_the_edge_of_the_deadzone_does_not_make_it_hunt() {
        let mut layer = Photo::default();
        let mut flags = |readings: &[u8]| -> std::vec::Vec<bool> {
            let flag = |&left: &u8| layer.decide(&see(left, 100)).flag;
            readings.iter().map(flag).collect()
        };
        assert_eq!(flags(&[107, 108, 107, 108]), [false; 4]);
        assert_eq!(flags(&[109, 108, 106, 105]), [true; 4]);
        assert_eq!(flags(&[104, 108, 107, 108]), [false; 4]);
    }

    /// At rest, after the light has been steady at 150 for a while, `mean` on both cells.
    fn at_rest(mean: u8, mode: Mode, avoid: i16) -> (u32, Motion) {
        let mut parameters = Parameters::default();
        parameters.set(Parameter::PhotoAvoid, avoid);
        let mut layer = Photo::default();
        let mut see = |mean: u8| {
            layer.decide(&Senses {
                parameters: &parameters,
                photo: Some((mean, mean)),
                is_standing: true,
                mode,
                ..Senses::nothing()
            })
        };
        assert!((0..100).all(|_| !see(150).flag));
        let first = see(mean);
        let after = (0..100).filter(|_| see(mean).flag).count() as u32;
        (u32::from(first.flag) + after, first.motion)
    }

    #[test]
    fn at_rest_a_lamp_that_goes_on_straight_ahead_pulls_for_a_second() {
        assert_eq!(at_rest(135, Mode::Reactive, 0).0, 0);
        let ahead = Motion {
            velocity_cps: Senses::nothing().top_cps(),
            rotation_cps: 0,
        };
        assert_eq!(at_rest(100, Mode::Reactive, 0), (20, ahead));
        assert_eq!(at_rest(200, Mode::Reactive, 1), (20, ahead));
        for (mean, avoid) in [(200, 0), (100, 1)] {
            let (ticks, motion) = at_rest(mean, Mode::Reactive, avoid);
            assert!(ticks == 20 && motion.velocity_cps == 0 && motion.rotation_cps != 0);
        }
        assert_eq!(at_rest(100, Mode::Prowl, 0).0, 0);
    }
}
