//! Layer 5: photocells. Turns toward the brighter side, or away from it.

use super::behaviour::Behaviour;
use super::refuge::Refuge;
use crate::arbiter::Request;
use crate::drive::Motion;
use crate::parameters::Parameter;
use crate::sensors::Senses;
use crate::units::{cps, ticks};
use groundwave_protocol::status_codes::Mode;

/// Rotation per 1/256 of difference between the cells.
const TURN_PER_STEP_CPS: i16 = cps(1) / 4;

/// Maximum rotation, 34 degrees per second: at the remaining 9 in/s a circle of 15 inches around the foot of a lamp.
const TURN_MOST_CPS: i16 = cps(6);

/// Speed of turning around on the spot: 57 degrees per second.
const SPIN_CPS: i16 = cps(10);

/// Duration of driving ahead after a light straight ahead was switched.
const PULL_TICKS: u8 = ticks(1) as u8;

/// Duration of half a turn at [`SPIN_CPS`].
const ABOUT_TICKS: u8 = ticks(3) as u8;

/// Averaging of the ambient light: about 13 s, or 12 feet of driving.
const AMBIENT_SHIFT: u32 = 8;

/// Number of ticks of turning after which the deadzone of a reactive robot grows by one, so that it comes to rest between lamps
/// and walls.
const TIRE_TICKS: u16 = ticks(1);

/// State of the layer.
#[derive(Clone, Debug, Default)]
pub struct Photo {
    is_turning: bool,
    was_standing: bool,
    /// Average of both cells in 1/256 of a step; `None` before the first reading.
    ambient: Option<[i32; 2]>,
    /// Number of ticks of turning without rest in mode Reactive.
    tired_ticks: u16,
    impulse: Option<Impulse>,
    refuge: Refuge,
}

/// Response to a light straight ahead, which both cells receive equally.
#[derive(Clone, Copy, Debug)]
struct Impulse {
    motion: Motion,
    ticks_left: u8,
}

/// Parameters and readings of a tick.
#[derive(Clone, Copy, Debug)]
struct Light {
    deadzone: i16,
    avoids: bool,
    cells: [i16; 2],
    /// Difference of the cells; positive requests a right turn.
    difference: i16,
}

impl Light {
    fn of(senses: &Senses) -> Option<Self> {
        let (left, right) = senses.photo?;
        let avoids = senses.parameters.is_on(Parameter::PhotoAvoid);
        let (left, right) = (i16::from(left), i16::from(right));
        Some(Self {
            deadzone: senses.parameters.get(Parameter::PhotoDeadzone),
            avoids,
            cells: [left, right],
            // 0 is bright: left minus right is positive with light on the right.
            difference: if avoids { right - left } else { left - right },
        })
    }
}

impl Photo {
    /// Follows the ambient light. A change at rest in mode Reactive means that a lamp was switched; for a robot that avoids
    /// light, an increase while driving means that a light is ahead.
    fn follow_ambient(&mut self, senses: &Senses, light: Light) {
        let now = light.cells.map(|cell| i32::from(cell) << AMBIENT_SHIFT);
        let begins_to_stand = senses.is_standing && !self.was_standing;
        self.was_standing = senses.is_standing;
        let mut ambient = self.ambient.filter(|_| !begins_to_stand).unwrap_or(now);
        let mut brighter = [0_i16; 2];
        for ((ambient, now), brighter) in ambient.iter_mut().zip(now).zip(&mut brighter) {
            *brighter = ((*ambient - now) >> AMBIENT_SHIFT) as i16;
            *ambient += (now - *ambient) >> AMBIENT_SHIFT;
        }
        let [left, right] = brighter;
        let brighter = left.midpoint(right);
        let limit = (light.deadzone / 2).max(1);
        let turn_about = Impulse {
            motion: Motion {
                velocity_cps: 0,
                rotation_cps: if senses.random & 1 == 0 {
                    SPIN_CPS
                } else {
                    -SPIN_CPS
                },
            },
            ticks_left: ABOUT_TICKS,
        };
        if senses.is_standing && senses.mode == Mode::Reactive {
            if left.abs().max(right.abs()) > limit {
                ambient = now;
                self.tired_ticks = 0;
                let pulls = (brighter > 0) != light.avoids;
                let ahead = Impulse {
                    motion: Motion {
                        velocity_cps: senses.top_cps(),
                        rotation_cps: 0,
                    },
                    ticks_left: PULL_TICKS,
                };
                if light.difference.abs() <= light.deadzone {
                    self.impulse = Some(if pulls { ahead } else { turn_about });
                }
            }
        } else if light.avoids && brighter > limit && self.impulse.is_none() {
            ambient = now;
            self.impulse = Some(turn_about);
        }
        self.ambient = Some(ambient);
    }

    /// Whether the robot ignores light in order to find a darker place than the current dead end.
    fn ignores_light(&mut self, senses: &Senses, light: Light) -> bool {
        let [left, right] = light.cells;
        self.refuge.ignores_light(
            senses.bumper.any(),
            &senses.pose,
            left.midpoint(right),
            light.deadzone / 2,
        )
    }
}

impl Behaviour for Photo {
    fn decide(&mut self, senses: &Senses) -> Request {
        let Some(light) = Light::of(senses) else {
            self.rest();
            return Request::QUIET;
        };
        self.follow_ambient(senses, light);
        if light.avoids && self.ignores_light(senses, light) {
            self.impulse = None;
            return Request::QUIET;
        }
        if let Some(Impulse { motion, ticks_left }) = self.impulse {
            self.impulse = (ticks_left > 1).then_some(Impulse {
                motion,
                ticks_left: ticks_left - 1,
            });
            return Request::raise(motion);
        }
        let is_reactive = senses.mode == Mode::Reactive;
        let tired = if is_reactive {
            self.tired_ticks / TIRE_TICKS
        } else {
            0
        };
        let deadzone = light.deadzone.saturating_add_unsigned(tired);
        // Hysteresis: half the deadzone ends a turn that the whole one began, so that noise does not restart it.
        let enough = if self.is_turning {
            deadzone / 2
        } else {
            deadzone
        };
        self.is_turning = light.difference.abs() > enough;
        if !self.is_turning {
            return Request::QUIET;
        }
        if is_reactive {
            self.tired_ticks = self.tired_ticks.saturating_add(1);
        }
        let turn = light.difference.saturating_mul(TURN_PER_STEP_CPS);
        Request::raise(Motion {
            velocity_cps: senses.top_cps(),
            rotation_cps: turn.clamp(-TURN_MOST_CPS, TURN_MOST_CPS),
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
            ..Senses::idle()
        }
    }

    fn decide(left: u8, right: u8) -> Request {
        Photo::default().decide(&see(left, right))
    }

    #[test]
    fn rotation_to_the_brighter_side_grows_with_the_difference() {
        let turns = [109, 120, 132, 200].map(|dark| decide(dark, 100).motion.rotation_cps);
        assert!(turns[0] > 0 && turns.is_sorted(), "{turns:?}");
        assert_eq!(turns[3], TURN_MOST_CPS);
        assert_eq!(decide(100, 120).motion.rotation_cps, -turns[1]);
        assert_eq!(decide(255, 0).motion.velocity_cps, Senses::idle().top_cps());
    }

    #[test]
    fn avoidance_turns_away_from_light() {
        let mut parameters = Parameters::default();
        assert!(parameters.set(Parameter::PhotoAvoid, 1));
        let senses = Senses {
            parameters: &parameters,
            photo: Some((120, 100)),
            ..Senses::idle()
        };
        let away = Photo::default().decide(&senses).motion.rotation_cps;
        assert_eq!(away, -decide(120, 100).motion.rotation_cps);
    }

    #[test]
    fn difference_within_the_deadzone_makes_no_request() {
        assert_eq!(decide(108, 100), Request::QUIET);
        assert!(decide(109, 100).flag);
        assert_eq!(Photo::default().decide(&Senses::idle()), Request::QUIET);
    }

    #[test]
    fn noise_at_the_deadzone_does_not_toggle_the_turn() {
        let mut layer = Photo::default();
        let mut flags = |readings: &[u8]| -> std::vec::Vec<bool> {
            let flag = |&left: &u8| layer.decide(&see(left, 100)).flag;
            readings.iter().map(flag).collect()
        };
        assert_eq!(flags(&[107, 108, 107, 108]), [false; 4]);
        assert_eq!(flags(&[109, 108, 106, 105]), [true; 4]);
        assert_eq!(flags(&[104, 108, 107, 108]), [false; 4]);
    }

    /// At rest, a change of both cells from 150 to `mean`: number of ticks with a request, and the first motion.
    fn at_rest(mean: u8, mode: Mode, avoid: i16) -> (usize, Motion) {
        let mut parameters = Parameters::default();
        parameters.set(Parameter::PhotoAvoid, avoid);
        let mut layer = Photo::default();
        let mut see = |mean: u8| {
            layer.decide(&Senses {
                parameters: &parameters,
                photo: Some((mean, mean)),
                is_standing: true,
                mode,
                ..Senses::idle()
            })
        };
        assert!((0..100).all(|_| !see(150).flag));
        let first = see(mean);
        let after = (0..100).filter(|_| see(mean).flag).count();
        (usize::from(first.flag) + after, first.motion)
    }

    #[test]
    fn switched_lamp_ahead_moves_a_resting_robot() {
        assert_eq!(at_rest(147, Mode::Reactive, 0).0, 0);
        let ahead = Motion {
            velocity_cps: Senses::idle().top_cps(),
            rotation_cps: 0,
        };
        assert_eq!(at_rest(140, Mode::Reactive, 0), (20, ahead));
        assert_eq!(at_rest(160, Mode::Reactive, 1), (20, ahead));
        for (mean, avoid) in [(160, 0), (140, 1)] {
            let (ticks, motion) = at_rest(mean, Mode::Reactive, avoid);
            assert!(ticks == 60 && motion.velocity_cps == 0 && motion.rotation_cps != 0);
        }
        assert_eq!(at_rest(140, Mode::Prowl, 0).0, 0);
    }

    #[test]
    fn avoidance_turns_around_before_a_growing_light() {
        for (avoid, ticks) in [(1, 60), (0, 0)] {
            let mut parameters = Parameters::default();
            parameters.set(Parameter::PhotoAvoid, avoid);
            let mut layer = Photo::default();
            let mut spun = 0;
            // Brighter by a step per half second, then steady.
            for tick in 0..400_u32 {
                let mean = 180 - (tick / 10).min(8) as u8;
                let request = layer.decide(&Senses {
                    parameters: &parameters,
                    photo: Some((mean, mean)),
                    ..Senses::idle()
                });
                spun += u32::from(request.flag && request.motion.velocity_cps == 0);
            }
            assert_eq!(spun, ticks, "avoid {avoid}");
        }
    }

    #[test]
    fn avoidance_ignores_light_in_a_corner() {
        for (avoid, flag) in [(1, false), (0, true)] {
            let mut parameters = Parameters::default();
            parameters.set(Parameter::PhotoAvoid, avoid);
            let mut layer = Photo::default();
            let mut senses = Senses {
                parameters: &parameters,
                photo: Some((200, 220)),
                ..Senses::idle()
            };
            for _ in 0..4 {
                for left in [false, true] {
                    assert!(layer.decide(&senses).flag);
                    senses.bumper.left = left;
                }
            }
            assert_eq!(layer.decide(&senses).flag, flag, "avoid {avoid}");
        }
    }

    #[test]
    fn reactive_robot_tires_of_turning_until_a_light_is_switched() {
        let mut layer = Photo::default();
        let mut see = |left, right, is_standing| {
            layer
                .decide(&Senses {
                    photo: Some((left, right)),
                    mode: Mode::Reactive,
                    is_standing,
                    ..Senses::idle()
                })
                .flag
        };
        let until_tired = (0..10_000).take_while(|_| see(140, 100, false)).count();
        // At half of the deadzone, which grows by 20 for a difference of 40.
        assert!((1300..1600).contains(&until_tired), "{until_tired}");
        assert!((0..1000).all(|_| !see(140, 100, true)));
        assert!(see(120, 80, true));
    }
}
