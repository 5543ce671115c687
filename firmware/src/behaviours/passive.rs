//! Mode Passive: scan, face the likely direction of people, stop, sing, wait for motion and charge.
//!
//! The mode is not a layer: it requests turns from layer 2, motion detection from layer 6, and the song.

use super::bumpers::side;
use super::motion::MotionDetector;
use super::rotation::{Ending, Rotation};
use crate::angle::Angle;
use crate::board::Side;
use crate::sensors::Senses;
use crate::units::ticks;

/// Number of scans tried before the robot waits at its position; contacts end a scan.
const TRIES: u8 = 3;

/// Number of contacts in the sequence that starts the mode.
const SEQUENCE: usize = 3;

/// Maximum time of the sequence.
const SEQUENCE_TICKS: u32 = ticks(60) as u32;

/// Stage of the mode.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Stage {
    /// Starts a scan when the motors are free.
    #[default]
    Scan,
    Scanning,
    Facing,
    Waiting,
    Charging,
}

/// Action that the mode requests.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// Continue without an action.
    Continue,
    /// Play the song.
    Sing,
    /// Return to the previous mode.
    Over,
}

/// State of the mode.
#[derive(Clone, Debug, Default)]
pub struct Passive {
    stage: Stage,
    tries: u8,
}

impl Passive {
    /// Advances one tick. `is_free` is whether neither the operator nor the bumpers control the motors; `ending` is the result
    /// of a turn that has ended.
    pub fn step(
        &mut self,
        heading: Angle,
        ending: Option<Ending>,
        is_free: bool,
        rotation: &mut Rotation,
        motion: &MotionDetector,
    ) -> Step {
        match (self.stage, ending) {
            (Stage::Scan, _) if is_free => {
                self.tries += 1;
                rotation.scan();
                self.stage = Stage::Scanning;
            }
            (Stage::Scanning, Some(Ending::Scanned)) => {
                let humans = rotation.panorama().humans();
                rotation.turn_by(i32::from(humans.minus(heading)));
                self.stage = Stage::Facing;
            }
            (Stage::Scanning, Some(_)) if self.tries < TRIES => self.stage = Stage::Scan,
            (Stage::Scanning | Stage::Facing, Some(_)) => {
                self.stage = Stage::Waiting;
                return Step::Sing;
            }
            (Stage::Waiting, _) if motion.has_fired() => self.stage = Stage::Charging,
            (Stage::Charging, _) if !motion.has_fired() => return Step::Over,
            _ => {}
        }
        Step::Continue
    }
}

/// Detects the sequence of bumper sides that starts the mode. The sequence is random, and a new one is drawn after each
/// time.
#[derive(Clone, Debug, Default)]
pub struct BumpSequence {
    wanted: Option<[Option<Side>; SEQUENCE]>,
    /// Latest contacts, newest first.
    contacts: [Option<(u32, Option<Side>)>; SEQUENCE],
    was_pressed: bool,
}

impl BumpSequence {
    /// Whether a contact in this tick completes the sequence.
    pub fn watch(&mut self, senses: &Senses) -> bool {
        let wanted = *self.wanted.get_or_insert_with(|| roll(senses.random));
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

    /// Draws a new sequence and drops the contacts.
    pub fn forget(&mut self) {
        self.wanted = None;
        self.contacts = [None; SEQUENCE];
    }
}

/// A random sequence of sides; `None` is the centre.
fn roll(random: u32) -> [Option<Side>; SEQUENCE] {
    const SIDES: [Option<Side>; 3] = [Some(Side::Left), None, Some(Side::Right)];
    core::array::from_fn(|place| {
        let number = (random >> (8 * place)) & 0xFF;
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

    /// Presses and releases at these ticks; returns whether a contact completed the sequence.
    fn bump(watch: &mut BumpSequence, random: u32, contacts: &[(u32, Option<Side>)]) -> bool {
        let mut fired = false;
        for &(now_ticks, side) in contacts {
            for bumper in [press(side), press(side), OPEN] {
                fired |= watch.watch(&Senses {
                    now_ticks,
                    bumper,
                    random,
                    ..Senses::idle()
                });
            }
        }
        fired
    }

    proptest! {
        #[test]
        fn only_the_drawn_sequence_starts_the_mode(
            random in 1_u32.., pressed in proptest::array::uniform3(0_u32..3), apart in 1_u32..2000
        ) {
            let mut wanted = roll(random);
            wanted.reverse();
            let sides = pressed.map(|number| roll(number)[0]);
            let times = [0, apart / 2, apart];
            let contacts: std::vec::Vec<_> = times.into_iter().zip(sides).collect();
            let fired = bump(&mut BumpSequence::default(), random, &contacts);
            prop_assert_eq!(fired, sides == wanted && apart <= 1200);
        }
    }

    #[test]
    fn drawn_sequences_vary() {
        let rolled: std::vec::Vec<_> = [1, 2, 0x0101, 0x02_0000].map(roll).into();
        for (place, sequence) in rolled.iter().enumerate() {
            assert!(!rolled.iter().skip(place + 1).any(|other| other == sequence));
        }
    }

    #[test]
    fn stages_follow_in_order() {
        let mut passive = Passive::default();
        let (mut rotation, motion) = (Rotation::default(), MotionDetector::default());
        let mut step = |ending, is_free| {
            let step = passive.step(Angle(0), ending, is_free, &mut rotation, &motion);
            (step, passive.stage, rotation.is_scanning())
        };
        assert_eq!(step(None, false), (Step::Continue, Stage::Scan, false));
        assert_eq!(step(None, true), (Step::Continue, Stage::Scanning, true));
        assert_eq!(step(None, true).1, Stage::Scanning);
        let broken = Some(Ending::BrokenOff);
        assert_eq!(step(broken, false).1, Stage::Scan);
        assert_eq!(step(None, true).1, Stage::Scanning);
        let scanned = step(Some(Ending::Scanned), true);
        assert_eq!(scanned, (Step::Continue, Stage::Facing, false));
        let turned = Some(Ending::Turned);
        assert_eq!(step(turned, true), (Step::Sing, Stage::Waiting, false));
        assert_eq!(step(None, true), (Step::Continue, Stage::Waiting, false));
    }

    #[test]
    fn failed_scans_end_in_waiting() {
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
