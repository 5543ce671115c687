//! Driving by hand: each press of an arrow is valid for a short time, its lease.

use crate::event::{Effect, Moment};

/// Lease of the first press: bridges the pause before the keyboard repeats.
const FIRST_LEASE: Moment = Moment::from_millis(500);

/// Lease of each repetition.
const LEASE: Moment = Moment::from_millis(300);

const SPEED_DEFAULT_IN_S: i8 = 8;
const SPEED_MAX_IN_S: i8 = 12;
const SPEED_STEP_IN_S: i8 = 2;

/// One axis of the virtual stick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Axis {
    direction: i8,
    until: Moment,
}

/// The virtual stick: the motion requested by held arrow keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Stick {
    ahead: Axis,
    right: Axis,
    /// Speed requested by an arrow key, in/s.
    pub(crate) speed_in_s: i8,
    moving: bool,
    /// Whether the terminal reports key releases.
    tells_releases: bool,
}

impl Default for Stick {
    fn default() -> Self {
        Self {
            ahead: Axis::default(),
            right: Axis::default(),
            speed_in_s: SPEED_DEFAULT_IN_S,
            moving: false,
            tells_releases: false,
        }
    }
}

impl Stick {
    /// Takes a pressed or repeated key. Of two held keys only the last repeats; if the terminal reports releases, the
    /// other one is renewed with it.
    pub(super) fn push(&mut self, now: Moment, ahead: i8, right: i8, repeated: bool) -> Effect {
        for (axis, direction) in [(&mut self.ahead, ahead), (&mut self.right, right)] {
            if direction == 0 {
                continue;
            }
            let held = axis.direction == direction && axis.until > now;
            let lease = if repeated || held { LEASE } else { FIRST_LEASE };
            *axis = Axis {
                direction,
                until: (now + lease).max(if held { axis.until } else { now }),
            };
        }
        self.tells_releases |= repeated;
        if self.tells_releases {
            for axis in [&mut self.ahead, &mut self.right] {
                if axis.until > now {
                    axis.until = axis.until.max(now + LEASE);
                }
            }
        }
        self.moving = true;
        self.effect()
    }

    /// Takes a released key.
    pub(super) fn release(&mut self, ahead: i8, right: i8) -> Option<Effect> {
        self.tells_releases = true;
        for (axis, direction) in [(&mut self.ahead, ahead), (&mut self.right, right)] {
            if direction != 0 && axis.direction == direction {
                *axis = Axis::default();
            }
        }
        self.settle()
    }

    /// Handles the passing of time.
    pub(super) fn expire(&mut self, now: Moment) -> Option<Effect> {
        let mut expired = false;
        for axis in [&mut self.ahead, &mut self.right] {
            if axis.direction != 0 && axis.until <= now {
                *axis = Axis::default();
                expired = true;
            }
        }
        if expired { self.settle() } else { None }
    }

    fn settle(&mut self) -> Option<Effect> {
        if !self.moving {
            return None;
        }
        self.moving = self.ahead.direction != 0 || self.right.direction != 0;
        Some(self.effect())
    }

    fn effect(&self) -> Effect {
        if self.moving {
            Effect::Drive {
                velocity_in_s: self.velocity_in_s(),
                rotation_in_s: self.rotation_in_s(),
            }
        } else {
            Effect::DriveEnd
        }
    }

    pub(super) fn faster(&mut self, steps: i8) {
        self.speed_in_s =
            (self.speed_in_s + steps * SPEED_STEP_IN_S).clamp(SPEED_STEP_IN_S, SPEED_MAX_IN_S);
    }

    /// Commanded speed at the centre, in/s.
    pub(crate) const fn velocity_in_s(&self) -> i8 {
        self.ahead.direction * self.speed_in_s
    }

    /// Commanded speed of the left wheel minus that of the right wheel, in/s.
    pub(crate) const fn rotation_in_s(&self) -> i8 {
        self.right.direction * self.speed_in_s
    }

    /// Time at which the next lease ends.
    pub(super) fn next_expiry(&self) -> Option<Moment> {
        [self.ahead, self.right]
            .into_iter()
            .filter(|axis| axis.direction != 0)
            .map(|axis| axis.until)
            .min()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn ms(ms: u64) -> Moment {
        Moment::from_millis(ms)
    }

    #[test]
    fn a_lease_that_is_not_renewed_ends_in_a_standstill() {
        let mut stick = Stick::default();
        let push = stick.push(ms(1000), 1, 0, false);
        assert_eq!(
            push,
            Effect::Drive {
                velocity_in_s: 8,
                rotation_in_s: 0
            }
        );
        assert_eq!(stick.next_expiry(), Some(ms(1500)));
        assert_eq!(stick.expire(ms(1499)), None);
        stick.push(ms(1490), 1, 0, true);
        assert_eq!(stick.expire(ms(1700)), None, "renewed");
        assert_eq!(stick.expire(ms(1790)), Some(Effect::DriveEnd));
        assert_eq!(stick.expire(ms(2000)), None, "once");
    }

    #[test]
    fn two_held_arrows_make_a_curve_on_a_terminal_that_reports_releases() {
        for tells in [true, false] {
            let mut stick = Stick::default();
            stick.push(ms(0), 1, 0, false);
            stick.push(ms(400), 1, 0, tells);
            stick.push(ms(450), 0, 1, false);
            for at in 10..30 {
                stick.push(ms(at * 50), 0, 1, tells);
                stick.expire(ms(at * 50));
            }
            let velocity_in_s = if tells { 8 } else { 0 };
            assert_eq!(stick.velocity_in_s(), velocity_in_s, "{tells}");
            assert_eq!(stick.rotation_in_s(), 8);
            // No more effects follow.
            assert_eq!(stick.expire(ms(1950)), Some(Effect::DriveEnd));
        }
    }

    #[test]
    fn letting_go_of_one_of_two_keys_leaves_the_other() {
        let mut stick = Stick::default();
        stick.push(ms(0), 1, 0, false);
        stick.push(ms(10), 0, 1, false);
        assert_eq!(
            stick.release(0, 1),
            Some(Effect::Drive {
                velocity_in_s: 8,
                rotation_in_s: 0
            })
        );
        assert_eq!(stick.release(1, 0), Some(Effect::DriveEnd));
    }
}
