//! The newest reports of the robot, with their moments.

use groundwave_protocol::WAYPOINTS_MAX;
use groundwave_protocol::status_codes::{Bump, Drive, Infrared, Layer, LayerMask, Mode};
use groundwave_protocol::telemetry::{
    AbilitiesLine, Body, CountersLine, Detail, LayerStates, Line, Reading as Measured, StateLine,
    StatusLine,
};

use super::history::History;
use super::unseen::Unseen;
use crate::event::Moment;
use crate::request::{CLIFF_GUARD, CRITICAL_BATTERY, Standing};

/// A value and the time at which it arrived.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Reading<T> {
    pub(crate) value: T,
    pub(crate) at: Moment,
}

impl<T> Reading<T> {
    /// Age of the value.
    pub(crate) fn age(&self, now: Moment) -> Moment {
        now.saturating_sub(self.at)
    }
}

/// Age at which a line A is stale; three are expected a second.
pub(crate) const STATE_STALE: Moment = Moment::from_secs(2);

/// Age at which a line B is stale; one is expected every two seconds.
pub(crate) const STATUS_STALE: Moment = Moment::from_secs(8);

/// Age at which a line C is stale; one is expected every four seconds.
pub(crate) const COUNTERS_STALE: Moment = Moment::from_secs(16);

/// The newest line of each type, and the latest contact and detection.
#[derive(Clone, Debug, Default)]
pub(crate) struct Robot {
    pub(crate) state: Option<Reading<StateLine>>,
    pub(crate) status: Option<Reading<StatusLine>>,
    pub(crate) counters: Option<Reading<CountersLine>>,
    /// Number of contacts since the robot started, or since the session began.
    pub(crate) contacts: u16,
    /// The latest contact.
    pub(crate) bump: Option<Reading<Bump>>,
    /// The latest detection.
    pub(crate) infrared: Option<Reading<Infrared>>,
    /// Contacts that the infrared detectors did not see.
    pub(super) unseen: Unseen,
    /// Battery voltage over the whole session, decivolts.
    pub(crate) volts: History,
    /// Whether the robot reports that it cannot hear.
    pub(crate) is_deaf: bool,
    /// The robot's abilities, from line I.
    pub(crate) abilities: Option<AbilitiesLine>,
    cliff_guard: Switch,
    critical_battery: Switch,
    /// The mode that the robot confirmed since its newest line A.
    confirmed_mode: Option<Mode>,
}

/// Whether a parameter switches a protection off, by the robot's report.
#[derive(Clone, Copy, Debug, Default)]
struct Switch {
    is_off: bool,
    /// Whether the protection is also off after a reset.
    stays_off: bool,
}

impl Robot {
    /// Returns the mode that the newest line A reports, or that the robot has confirmed since.
    pub(crate) fn mode(&self) -> Option<Mode> {
        let reported = self.state.map(|state| state.value.mode);
        self.confirmed_mode.or(reported)
    }

    /// Returns the newest line A's state in the mode that the robot has confirmed since.
    pub(crate) fn state_in_mode(&self) -> Option<Reading<StateLine>> {
        let mut state = self.state?;
        match self.confirmed_mode {
            Some(Mode::Stop) => {
                state.value.mode = Mode::Stop;
                state.value.layers = LayerStates::OFF;
            }
            // Lines A of mode Stop do not show which layers another mode has.
            Some(mode) if state.value.mode != Mode::Stop => state.value.mode = mode,
            _ => {}
        }
        Some(state)
    }

    /// The robot confirmed that it entered a mode.
    pub(super) const fn take_confirmed_mode(&mut self, mode: Mode) {
        self.confirmed_mode = Some(mode);
    }

    pub(super) fn take(&mut self, now: Moment, line: &Line) {
        self.is_deaf = matches!(line.ack.detail, Detail::CannotHear { .. });
        match line.body {
            Body::State(state) => {
                if touches(state.bump) {
                    self.bump = Some(reading(now, state.bump));
                }
                if detects(state.infrared) {
                    self.infrared = Some(reading(now, state.infrared));
                }
                self.unseen.take(&state);
                self.state = Some(reading(now, state));
                self.confirmed_mode = None;
            }
            Body::Status(status) => {
                if measures_battery(&status, self.abilities.as_ref()) {
                    self.volts.push(now, status.battery_dv);
                }
                self.status = Some(reading(now, status));
            }
            Body::Counters(counters) => self.counters = Some(reading(now, counters)),
            Body::Parameter(parameter) => {
                let switch = match parameter.name.as_str() {
                    CLIFF_GUARD => &mut self.cliff_guard,
                    CRITICAL_BATTERY => &mut self.critical_battery,
                    _ => return,
                };
                *switch = Switch {
                    is_off: parameter.value == 0,
                    stays_off: parameter.kept == 0,
                };
            }
            Body::Abilities(abilities) => self.abilities = Some(abilities),
            Body::Text(_) | Body::Song(_) | Body::Field(_) | Body::Values(_) => {}
        }
    }

    /// Takes a restart of the robot: the parameters are the saved ones.
    pub(super) fn take_restart(&mut self) {
        self.confirmed_mode = None;
        self.unseen = Unseen::default();
        self.contacts = 0;
        self.cliff_guard.is_off = self.cliff_guard.stays_off;
        self.critical_battery.is_off = self.critical_battery.stays_off;
    }

    /// Maximum number of waypoints in a route.
    pub(super) fn list_capacity(&self) -> usize {
        self.abilities.map_or(WAYPOINTS_MAX, |robot| {
            usize::from(robot.capacity).min(WAYPOINTS_MAX)
        })
    }

    /// Whether the robot reported its cliff guard off.
    pub(super) const fn is_unguarded(&self) -> bool {
        self.cliff_guard.is_off
    }

    /// The protections that can be switched off, and whether each is off.
    pub(crate) fn protections(&self) -> [(&'static str, bool); 3] {
        [
            ("BUMPERS OFF", self.forbids(Layer::Bumpers)),
            ("CLIFF GUARD OFF", self.cliff_guard.is_off),
            ("CRITICAL BATTERY OFF", self.critical_battery.is_off),
        ]
    }

    /// Names of the stale lines.
    pub(crate) fn stale(&self, now: Moment) -> Vec<&'static str> {
        let old = |age: Option<Moment>, limit| age.is_some_and(|age| age >= limit);
        [
            (
                "sensors",
                old(self.state.map(|line| line.age(now)), STATE_STALE),
            ),
            (
                "battery",
                old(self.status.map(|line| line.age(now)), STATUS_STALE),
            ),
            (
                "robot",
                old(self.counters.map(|line| line.age(now)), COUNTERS_STALE),
            ),
        ]
        .into_iter()
        .filter_map(|(name, is_old)| is_old.then_some(name))
        .collect()
    }

    /// Whether the robot has a reading, as far as known.
    pub(crate) fn measures(&self, reading: Measured) -> bool {
        self.abilities.is_none_or(|robot| robot.measures(reading))
    }

    /// The newest line B with a battery voltage.
    pub(crate) fn battery(&self) -> Option<Reading<StatusLine>> {
        self.status
            .filter(|status| measures_battery(&status.value, self.abilities.as_ref()))
    }

    /// Layers fitted on this robot; `None` before its report.
    pub(crate) fn fitted(&self) -> Option<LayerMask> {
        self.status.map(|status| status.value.fitted)
    }

    /// Layers allowed, by the robot's report.
    pub(crate) fn allowed(&self) -> Option<LayerMask> {
        self.status.map(|status| status.value.allowed)
    }

    /// Whether the robot is known to allow its turns and scans.
    pub(crate) fn turns_on_request(&self) -> bool {
        self.allowed()
            .is_some_and(|allowed| allowed.contains(Layer::Rotation))
    }

    /// Settings that explain a refusal.
    pub(crate) fn standing(&self) -> Standing {
        Standing::new(self.state.map(|state| state.value.mode), self.allowed())
    }

    /// Whether a fitted layer is known to be forbidden.
    pub(crate) fn forbids(&self, layer: Layer) -> bool {
        !self.lacks(layer)
            && self
                .allowed()
                .is_some_and(|allowed| !allowed.contains(layer))
    }

    /// Whether the robot is known to lack a layer.
    pub(crate) fn lacks(&self, layer: Layer) -> bool {
        self.fitted().is_some_and(|fitted| !fitted.contains(layer))
    }
}

/// Whether a line B contains a measured voltage. 0 V means none, because the robot runs.
fn measures_battery(status: &StatusLine, abilities: Option<&AbilitiesLine>) -> bool {
    status.battery_dv > 0 && abilities.is_none_or(|robot| robot.measures(Measured::Battery))
}

const fn reading<T>(at: Moment, value: T) -> Reading<T> {
    Reading { value, at }
}

/// Maximum wheel speed, in/s.
const WHEEL_MAX_IN_S: i32 = 12;

/// Commanded speeds of the left and right wheel, in/s. As in the robot, turning takes precedence over speed
/// if a wheel would be too fast.
pub(crate) fn ordered_wheels_in_s(state: &StateLine) -> [i32; 2] {
    let most = 2 * WHEEL_MAX_IN_S;
    // Doubled, because half of an odd rotation is not whole.
    let turn = i32::from(state.rotation_in_s).clamp(-most, most);
    let room = most - turn.abs();
    let speed = (2 * i32::from(state.velocity_in_s)).clamp(-room, room);
    [speed + turn, speed - turn].map(|doubled| i32::midpoint(doubled, doubled.signum()))
}

/// Whether the wheels reach at most half of the ordered speed although the drive is at full power.
pub(crate) fn is_held(state: &StateLine) -> bool {
    let measured = [state.wheel_left_in_s, state.wheel_right_in_s];
    let mut wheels = ordered_wheels_in_s(state).into_iter().zip(measured);
    state.drive == Drive::Saturated
        && wheels.any(|(ordered, measured)| {
            ordered.abs() >= HELD_ORDER_MIN_IN_S && 2 * i32::from(measured).abs() <= ordered.abs()
        })
}

/// Minimum ordered speed at which a wheel can count as held, in/s; measured speeds are whole numbers.
const HELD_ORDER_MIN_IN_S: i32 = 4;

/// Whether the bumper is pressed.
pub(crate) const fn touches(bump: Bump) -> bool {
    !matches!(bump, Bump::None | Bump::NotFitted)
}

/// Whether an infrared detector triggers.
pub(crate) const fn detects(infrared: Infrared) -> bool {
    matches!(infrared, Infrared::Left | Infrared::Right | Infrared::Both)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::testing::state;

    /// The station limits wheel orders as the robot's `Motion::wheels` does.
    #[test]
    fn orders_of_the_wheels_are_held_to_what_the_robot_gives() {
        for (velocity_in_s, rotation_in_s, wheels) in [
            (10, 0, [10, 10]),
            (12, 2, [12, 10]),
            (-12, 3, [-9, -12]),
            (12, -30, [-12, 12]),
            (0, 7, [4, -4]),
        ] {
            let state = StateLine {
                velocity_in_s,
                rotation_in_s,
                ..state()
            };
            assert_eq!(
                ordered_wheels_in_s(&state),
                wheels,
                "{velocity_in_s} {rotation_in_s}"
            );
        }
    }
}
