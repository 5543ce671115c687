//! Mode Passive: look around, face where humans might be, stop, sing, wait for one, and charge.
//!
//! Not a layer: it asks layers 2 and 6 in turn for what they do, and the singer.

use super::bumpers::side;
use super::{Ending, MotionDetector, Rotation};
use crate::angle::Angle;
use crate::board::Side;
use crate::sensors::Senses;
use crate::units::ticks;

/// A look around that bumps break off is begun anew so often; then it waits where it stands.
const TRIES: u8 = 3;

/// Contacts in the sequence that starts the mode.
const SEQUENCE: usize = 3;

/// They must follow one another within this time.
const SEQUENCE_TICKS: u32 = ticks(60) as u32;

/// What comes next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Stage {
    /// To look around, once nothing else holds the motors.
    #[default]
    Look,
    Looking,
    Facing,
    Waiting,
    Charging,
}

/// What the sequence of states wants of the robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// Nothing at this tick.
    Nothing,
    /// The song.
    Sing,
    /// It is over: back to the mode before.
    Over,
}

/// The sequence of states.
#[derive(Clone, Debug, Default)]
pub struct Passive {
    stage: Stage,
    tries: u8,
}

impl Passive {
    /// Goes on by a tick. `is_free` says that neither the operator nor the bumpers hold the motors,
    /// `ending` how the latest turn ended, if it did.
    pub fn step(
        &mut self,
        heading: Angle,
        ending: Option<Ending>,
        is_free: bool,
        rotation: &mut Rotation,
        motion: &MotionDetector,
    ) -> Step {
        match (self.stage, ending) {
            (Stage::Look, _) if is_free => {
                self.tries += 1;
                rotation.scan();
                self.stage = Stage::Looking;
            }
            (Stage::Looking, Some(Ending::Scanned)) => {
                let humans = rotation.panorama().humans();
                rotation.turn_by(i32::from(humans.minus(heading)));
                self.stage = Stage::Facing;
            }
            (Stage::Looking, Some(_)) if self.tries < TRIES => self.stage = Stage::Look,
            (Stage::Looking | Stage::Facing, Some(_)) => {
                self.stage = Stage::Waiting;
                return Step::Sing;
            }
            (Stage::Waiting, _) if motion.has_fired() => self.stage = Stage::Charging,
            (Stage::Charging, _) if !motion.has_fired() => return Step::Over,
            _ => {}
        }
        Step::Nothing
    }
}

/// Watches the bumper for the sequence of sides that starts the mode. It varies: the dice choose it, and
/// another one after each time.
#[derive(Clone, Debug, Default)]
pub struct BumpSequence {
    wanted: Option<[Option<Side>; SEQUENCE]>,
    /// Newest first.
    contacts: [Option<(u32, Option<Side>)>; SEQUENCE],
    was_pressed: bool,
}

impl BumpSequence {
    /// Whether this tick's contact completes the sequence.
    pub fn watch(&mut self, senses: &Senses) -> bool {
        let wanted = *self.wanted.get_or_insert_with(|| roll(senses.dice));
        let is_new = senses.bumper.any() && !self.was_pressed;
        self.was_pressed = senses.bumper.any();
        if !is_new {
            return false;
        }
        self.contacts.rotate_right(1);
        if let Some(newest) = self.contacts.first_mut() {
            *newest = Some((senses.now_ticks, side(senses.bumper)));
        }
        let fits = self.contacts.iter().zip(wanted).all(|(contact, wanted)| {
            contact.is_some_and(|(at_ticks, side)| {
                side == wanted && senses.now_ticks.wrapping_sub(at_ticks) <= SEQUENCE_TICKS
            })
        });
        if fits {
            self.forget();
        }
        fits
    }

    /// The mode has begun, or cannot: another sequence next time.
    pub fn forget(&mut self) {
        self.wanted = None;
        self.contacts = [None; SEQUENCE];
    }
}

/// A sequence of sides; `None` is the centre.
fn roll(dice: u32) -> [Option<Side>; SEQUENCE] {
    const SIDES: [Option<Side>; 3] = [Some(Side::Left), None, Some(Side::Right)];
    core::array::from_fn(|place| {
        let number = (dice >> (8 * place)) & 0xFF;
        SIDES.get(number as usize % 3).copied().flatten()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::board::Switches;
    use proptest::prelude::*;

    const OPEN: Switches = Switches {
        left: false,
        center: false,
        right: false,
    };

    fn press(side: Option<Side>) -> Switches {
        Switches {
            left: side == Some(Side::Left),
            center: side.is_none(),
            right: side == Some(Side::Right),
        }
    }

    /// Presses and lets go at these ticks; returns whether any contact completed the sequence.
    fn bump(watch: &mut BumpSequence, dice: u32, contacts: &[(u32, Option<Side>)]) -> bool {
        let mut fired = false;
        for &(now_ticks, side) in contacts {
            for bumper in [press(side), press(side), OPEN] {
                fired |= watch.watch(&Senses {
                    now_ticks,
                    bumper,
                    dice,
                    ..Senses::nothing()
                });
            }
        }
        fired
    }

    proptest! {
        #[test]
        fn exactly_the_sequence_that_was_rolled_starts_it(
            dice in 1_u32.., pressed in proptest::array::uniform3(0_u32..3), apart in 1_u32..2000
        ) {
            let mut wanted = roll(dice);
            wanted.reverse();
            let sides = pressed.map(|number| roll(number)[0]);
            let times = [0, apart / 2, apart];
            let contacts: std::vec::Vec<_> = times.into_iter().zip(sides).collect();
            let fired = bump(&mut BumpSequence::default(), dice, &contacts);
            prop_assert_eq!(fired, sides == wanted && apart <= 1200);
        }
    }

    #[test]
    fn sequences_vary() {
        let rolled: std::vec::Vec<_> = [1, 2, 0x0101, 0x02_0000].map(roll).into();
        for (place, sequence) in rolled.iter().enumerate() {
            assert!(!rolled.iter().skip(place + 1).any(|other| other == sequence));
        }
    }

    #[test]
    fn the_stages_follow_one_another() {
        let mut passive = Passive::default();
        let (mut rotation, motion) = (Rotation::default(), MotionDetector::default());
        let mut step = |ending, is_free| {
            let step = passive.step(Angle(0), ending, is_free, &mut rotation, &motion);
            (step, passive.stage, rotation.is_scanning())
        };
        assert_eq!(step(None, false), (Step::Nothing, Stage::Look, false));
        assert_eq!(step(None, true), (Step::Nothing, Stage::Looking, true));
        assert_eq!(step(None, true).1, Stage::Looking);
        let broken = Some(Ending::BrokenOff);
        assert_eq!(step(broken, false).1, Stage::Look);
        assert_eq!(step(None, true).1, Stage::Looking);
        let scanned = step(Some(Ending::Scanned), true);
        assert_eq!(scanned, (Step::Nothing, Stage::Facing, false));
        let turned = Some(Ending::Turned);
        assert_eq!(step(turned, true), (Step::Sing, Stage::Waiting, false));
        assert_eq!(step(None, true), (Step::Nothing, Stage::Waiting, false));
    }

    #[test]
    fn it_waits_where_it_stands_when_it_cannot_look_around() {
        let mut passive = Passive::default();
        let (mut rotation, motion) = (Rotation::default(), MotionDetector::default());
        let mut songs = 0;
        for tick in 0..20 {
            let ending = (tick % 2 == 1).then_some(Ending::BrokenOff);
            let step = passive.step(Angle(0), ending, true, &mut rotation, &motion);
            songs += u8::from(step == Step::Sing);
        }
        assert_eq!(
            (songs, passive.stage, passive.tries),
            (1, Stage::Waiting, TRIES)
        );
    }
}
