//! Every alarm in one table, with its limits.

use std::borrow::Cow;
use std::cmp::Reverse;
use std::sync::Arc;

use groundwave_protocol::status_codes::{Bump, Cliff, Drive, Infrared, Link as LinkLetter, Power};
use groundwave_protocol::telemetry::StateLine;
use serde::Deserialize;

use super::settings::{AlarmSetting, FieldLimit};
use crate::event::{AlarmEvent, AlarmStatus, Level, Moment, Recording};
use crate::model::keys::Keymap;
use crate::model::link::{Connection, Link};
use crate::model::motors::Motors;
use crate::model::robot::{Robot, is_held, touches};
use crate::model::unseen::Unseen;

/// Code of the alarm of a lost link.
pub(crate) const LINK_LOST: &str = "link_lost";

/// Code of the alarm of a silent robot.
pub(crate) const ROBOT_SILENT: &str = "robot_silent";

/// Limits of the alarms.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Limits {
    /// Battery low at this voltage or below, decivolts.
    pub battery_low_dv: u16,
    /// Battery critical at this voltage or below, decivolts.
    pub battery_critical_dv: u16,
    /// Distance above its limit at which a low or critical battery counts as recovered, decivolts.
    pub battery_hysteresis_dv: u16,
    /// Time below the limit before the alarm, s; starting motors lower the voltage.
    pub battery_for_s: u16,
    /// Time without a line before the robot is silent, s.
    pub silent_s: u16,
    /// Share of lines lost or damaged that raises an alarm, per cent.
    pub loss_pct: u8,
    /// Time above `loss_pct` before the alarm, s.
    pub loss_for_s: u16,
    /// Time for which ordered wheels do not turn before they count as stalled, s.
    pub stalled_s: u16,
    /// Time without floor under several sensors before the robot counts as fallen or lifted, s.
    pub fallen_s: u16,
    /// Time of thrashing between layers before the alarm, s.
    pub thrash_s: u16,
    /// Number of contacts on the left side without its infrared detector that raises an alarm.
    pub left_unseen_bumps: u16,
    /// Likewise on the right side.
    pub right_unseen_bumps: u16,
}

impl Default for Limits {
    /// The thresholds of the SR04's firmware, where it has them.
    fn default() -> Self {
        Self {
            battery_low_dv: 116,
            battery_critical_dv: 112,
            battery_hysteresis_dv: 3,
            battery_for_s: 5,
            silent_s: 5,
            loss_pct: 30,
            loss_for_s: 10,
            stalled_s: 2,
            fallen_s: 2,
            thrash_s: 15,
            left_unseen_bumps: 20,
            right_unseen_bumps: 20,
        }
    }
}

/// The hint for a recording that failed.
const MAKE_ROOM: &str =
    "make room, then press <toggle-recording>; until then memory keeps the newest lines";

/// The hint for a recording on a disk that hangs.
pub(crate) const DISK_IS_SILENT: &str =
    "the disk does not answer; check it; until then memory keeps the newest lines";

/// The hint for a detector that does not see what the bumper touches.
const BLIND: &str = "its infrared detector missed what the bumper touched: clean or replace it";

/// Inputs of the rules.
pub(in crate::model) struct Inputs<'a> {
    pub(in crate::model) now: Moment,
    pub(in crate::model) robot: &'a Robot,
    pub(in crate::model) link: &'a Link,
    pub(in crate::model) motors: &'a Motors,
    pub(in crate::model) recording: &'a Recording,
}

/// The result of a rule.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Sight {
    /// The state of the cause is unknown; the alarm does not change.
    Unknown,
    No,
    /// The cause is present; raises the alarm when it has lasted long enough.
    Yes,
    /// The robot or the recorder reports the cause; raises the alarm at once.
    Certain,
    /// A value to compare with the limit.
    Is(f64),
}

/// Limits of one rule.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds {
    /// Value that raises the alarm.
    pub(crate) raise: f64,
    /// Value that ends the alarm; below `raise` if high values are bad, else above.
    pub(super) clear: f64,
    /// Whether high values are bad.
    pub(super) is_high_bad: bool,
    /// Whether the limit itself raises the alarm.
    pub(super) is_inclusive: bool,
    /// Time beyond the limit before the alarm is raised.
    pub(super) persists: Moment,
}

/// Source of a rule's value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Source {
    /// The robot's line A.
    State,
    /// The robot's line B.
    Status,
    /// Received and lost lines.
    Lines,
    /// This station.
    Station,
    /// A field of the robot's lines.
    Field,
}

/// One row of the table of built-in alarms.
struct BuiltIn {
    code: &'static str,
    level: Level,
    name: &'static str,
    hint: &'static str,
    unit: &'static str,
    logged_here: bool,
    source: Source,
    look: fn(&Inputs<'_>) -> Sight,
    bounds: fn(&Limits) -> Bounds,
}

/// An alarm with its limit.
#[derive(Clone, Debug)]
pub(crate) struct Rule {
    /// Stable code in JSON.
    pub(crate) code: Cow<'static, str>,
    pub(crate) level: Level,
    pub(crate) name: Cow<'static, str>,
    /// Advice for the operator, as a text for [`Keymap::with_keys`](crate::model::keys::Keymap::with_keys); may be empty.
    pub(crate) hint: Cow<'static, str>,
    /// Unit of the value; empty if there is none.
    pub(crate) unit: &'static str,
    /// Whether raising the alarm adds the log line; otherwise another event adds it.
    logged_here: bool,
    /// Source of the value.
    pub(crate) source: Source,
    pub(super) look: Look,
    pub(crate) bounds: Bounds,
}

/// The check of a rule.
#[derive(Clone, Debug)]
pub(super) enum Look {
    /// A built-in function checks the rule.
    BuiltIn(fn(&Inputs<'_>) -> Sight),
    /// The latest value of a field is compared with a limit.
    Field(FieldLimit),
}

/// Unit of a value that is an age.
pub(super) const SECONDS: &str = "s";

/// Time for which the bumper is pressed before it counts as jammed, s.
pub(crate) const PRESSED_S: u16 = 5;

/// The built-in alarms, the worst first.
const BUILT_IN: [BuiltIn; 13] = [
    BuiltIn {
        code: "battery_critical",
        level: Level::Alarm,
        name: "battery critical",
        hint: "switch it off, or charge it",
        unit: "V",
        logged_here: true,
        source: Source::Status,
        look: |inputs| battery(inputs, &[Power::Critical]),
        bounds: |limits| below_dv(limits, limits.battery_critical_dv),
    },
    BuiltIn {
        code: "fallen_or_lifted",
        level: Level::Alarm,
        name: "fallen or lifted",
        hint: "no floor under the robot: go and look",
        unit: "",
        logged_here: true,
        source: Source::State,
        look: |inputs| state_is(inputs, |state| state.cliff == Cliff::Several),
        bounds: |limits| lasting(limits.fallen_s),
    },
    BuiltIn {
        code: "failsafe",
        level: Level::Alarm,
        name: "failsafe",
        hint: "the robot hears no station and acts by itself",
        unit: "",
        logged_here: false,
        source: Source::State,
        look: |inputs| match inputs.robot.state {
            Some(state) if state.value.link == LinkLetter::Failsafe => Sight::Certain,
            Some(_) => Sight::No,
            None => Sight::Unknown,
        },
        bounds: |_| lasting(0),
    },
    BuiltIn {
        code: LINK_LOST,
        level: Level::Alarm,
        name: "link lost",
        hint: "check cable, network or station; reconnecting",
        unit: "",
        logged_here: false,
        source: Source::Station,
        look: |inputs| match inputs.link.connection {
            Connection::Lost { .. } => Sight::Certain,
            Connection::Opening | Connection::Open | Connection::Ended => Sight::No,
        },
        bounds: |_| lasting(0),
    },
    BuiltIn {
        code: ROBOT_SILENT,
        level: Level::Alarm,
        name: "robot silent",
        hint: "is it on, and in range?",
        unit: SECONDS,
        logged_here: true,
        source: Source::Station,
        look: silence,
        bounds: |limits| {
            let raise = f64::from(limits.silent_s.max(1));
            Bounds {
                raise,
                clear: raise - 0.5,
                is_high_bad: true,
                is_inclusive: true,
                persists: Moment::ZERO,
            }
        },
    },
    BuiltIn {
        code: "recording_failed",
        level: Level::Alarm,
        name: "recording failed",
        hint: MAKE_ROOM,
        unit: "",
        logged_here: false,
        source: Source::Station,
        look: |inputs| match inputs.recording.problem {
            Some(_) => Sight::Certain,
            None => Sight::No,
        },
        bounds: |_| lasting(0),
    },
    BuiltIn {
        code: "battery_low",
        level: Level::Alarm,
        name: "battery low",
        hint: "send it home (<modes/mode-go-home>) and charge it",
        unit: "V",
        logged_here: true,
        source: Source::Status,
        look: |inputs| battery(inputs, &[Power::Low, Power::Critical]),
        bounds: |limits| below_dv(limits, limits.battery_low_dv),
    },
    BuiltIn {
        code: "stalled",
        level: Level::Alarm,
        name: "stalled",
        hint: "free the wheels, or STOP (<stop>)",
        unit: "",
        logged_here: true,
        source: Source::State,
        look: |inputs| {
            state_is(inputs, |state| {
                state.drive == Drive::Stalled || is_held(state)
            })
        },
        bounds: |limits| lasting(limits.stalled_s),
    },
    BuiltIn {
        code: "bumper_jammed",
        level: Level::Warning,
        name: "bumper jammed",
        hint: "caught on something; free it",
        unit: "",
        logged_here: true,
        source: Source::State,
        look: |inputs| match inputs.robot.state {
            Some(state) if state.value.bump == Bump::Jammed => Sight::Certain,
            _ => state_is(inputs, |state| touches(state.bump)),
        },
        bounds: |_| lasting(PRESSED_S),
    },
    BuiltIn {
        code: "layers_thrash",
        level: Level::Warning,
        name: "layers thrash",
        hint: "too many changes; forbid a layer (<toggle-layer-bumpers..>)",
        unit: "",
        logged_here: true,
        source: Source::State,
        look: |inputs| {
            if inputs.motors.thrashes(inputs.now) {
                Sight::Yes
            } else {
                Sight::No
            }
        },
        bounds: |limits| lasting(limits.thrash_s),
    },
    BuiltIn {
        code: "lines_not_intact",
        level: Level::Warning,
        name: "lines not intact",
        hint: "weak or disturbed radio; come closer",
        unit: "%",
        logged_here: true,
        source: Source::Lines,
        look: |inputs| match inputs.link.shares(inputs.now) {
            Some(shares) => Sight::Is((shares.unusable() * 100.0).round()),
            None => Sight::Unknown,
        },
        bounds: |limits| {
            let raise = f64::from(limits.loss_pct.max(1));
            Bounds {
                raise,
                clear: raise / 2.0,
                is_high_bad: true,
                is_inclusive: true,
                persists: Moment::from_secs(limits.loss_for_s.into()),
            }
        },
    },
    BuiltIn {
        code: "left_side_blind",
        level: Level::Warning,
        name: "left side blind",
        hint: BLIND,
        unit: "bumps",
        logged_here: true,
        source: Source::State,
        look: |inputs| unseen(inputs, Unseen::left),
        bounds: |limits| contacts(limits.left_unseen_bumps),
    },
    BuiltIn {
        code: "right_side_blind",
        level: Level::Warning,
        name: "right side blind",
        hint: BLIND,
        unit: "bumps",
        logged_here: true,
        source: Source::State,
        look: |inputs| unseen(inputs, Unseen::right),
        bounds: |limits| contacts(limits.right_unseen_bumps),
    },
];

fn lasting(s: u16) -> Bounds {
    Bounds {
        raise: 1.0,
        clear: 0.0,
        is_high_bad: true,
        is_inclusive: true,
        persists: Moment::from_secs(s.into()),
    }
}

fn contacts(limit: u16) -> Bounds {
    Bounds {
        raise: f64::from(limit.max(1)),
        ..lasting(0)
    }
}

fn below_dv(limits: &Limits, limit_dv: u16) -> Bounds {
    Bounds {
        raise: f64::from(limit_dv) / 10.0,
        clear: f64::from(limit_dv.saturating_add(limits.battery_hysteresis_dv.max(1))) / 10.0,
        is_high_bad: false,
        is_inclusive: true,
        persists: Moment::from_secs(limits.battery_for_s.into()),
    }
}

fn battery(inputs: &Inputs<'_>, letters: &[Power]) -> Sight {
    let power = inputs.robot.state.map(|state| state.value.power);
    match (power, inputs.robot.battery()) {
        (Some(Power::Charging | Power::Docked), _) => Sight::No,
        (Some(power), _) if letters.contains(&power) => Sight::Certain,
        (_, Some(status)) => Sight::Is(f64::from(status.value.battery_dv) / 10.0),
        (_, None) => Sight::Unknown,
    }
}

fn state_is(inputs: &Inputs<'_>, bad: fn(&StateLine) -> bool) -> Sight {
    match inputs.robot.state {
        Some(state) if bad(&state.value) => Sight::Yes,
        Some(_) => Sight::No,
        None => Sight::Unknown,
    }
}

fn unseen(inputs: &Inputs<'_>, contacts: fn(Unseen) -> u16) -> Sight {
    match inputs.robot.state {
        Some(state) if state.value.infrared != Infrared::NotFitted => {
            Sight::Is(contacts(inputs.robot.unseen).into())
        }
        _ => Sight::Unknown,
    }
}

fn silence(inputs: &Inputs<'_>) -> Sight {
    let silence = inputs.link.silence(inputs.now);
    silence.map_or(Sight::Unknown, |time| Sight::Is(time.as_secs_f64()))
}

impl Bounds {
    /// Whether a value is beyond the limit.
    pub(crate) fn reaches(self, value: f64) -> bool {
        match (self.is_high_bad, self.is_inclusive) {
            (true, true) => value >= self.raise,
            (true, false) => value > self.raise,
            (false, true) => value <= self.raise,
            (false, false) => value < self.raise,
        }
    }

    /// Whether a value is clear of the limit.
    pub(super) fn is_clear(self, value: f64) -> bool {
        if self.is_high_bad {
            value <= self.clear
        } else {
            value >= self.clear
        }
    }
}

/// The built-in alarms and those of the configuration, the worst first.
pub(crate) fn rules(limits: &Limits, settings: &[AlarmSetting]) -> Arc<[Rule]> {
    let setting = |code: &str| settings.iter().find(|setting| setting.code() == code);
    let built_in = BUILT_IN.iter().filter_map(|row| {
        let setting = setting(row.code);
        let hint = setting.and_then(|setting| setting.hint.clone());
        setting.is_none_or(|setting| setting.enabled).then(|| Rule {
            code: row.code.into(),
            level: setting.and_then(AlarmSetting::level).unwrap_or(row.level),
            name: row.name.into(),
            hint: hint.map_or(row.hint.into(), Cow::Owned),
            unit: row.unit,
            logged_here: row.logged_here,
            source: row.source,
            look: Look::BuiltIn(row.look),
            bounds: (row.bounds)(limits),
        })
    });
    let own = settings.iter().filter(|setting| setting.enabled);
    let own = own.filter_map(|setting| {
        Some(Rule {
            code: setting.code().into(),
            level: setting.level().unwrap_or(Level::Alarm),
            name: setting.name.clone().into(),
            hint: setting.hint.clone().unwrap_or_default().into(),
            unit: setting.unit(),
            logged_here: true,
            source: Source::Field,
            look: Look::Field(setting.limit()?),
            bounds: setting.bounds(),
        })
    });
    let mut rules: Vec<Rule> = built_in.chain(own).collect();
    rules.sort_by_key(|rule| Reverse(rule.level));
    rules.into()
}

/// Whether a built-in alarm has this code.
pub(super) fn is_built_in(code: &str) -> bool {
    BUILT_IN.iter().any(|row| row.code == code)
}

/// Codes of the built-in alarms.
pub(super) fn built_in_codes() -> impl Iterator<Item = &'static str> {
    BUILT_IN.iter().map(|row| row.code)
}

impl Rule {
    /// An event of this alarm without values.
    pub(in crate::model) fn event(&self, status: AlarmStatus) -> AlarmEvent {
        AlarmEvent {
            code: self.code.clone().into_owned(),
            name: self.name.clone().into_owned(),
            level: self.level,
            status,
            began_at: None,
            value: None,
            limit: None,
            unit: if self.is_measured() { self.unit } else { "" }.to_owned(),
            shelved_for: None,
            by: None,
        }
    }

    /// Whether the value is the age of the cause.
    pub(super) fn is_age(&self) -> bool {
        self.unit == SECONDS && matches!(self.look, Look::BuiltIn(_))
    }

    /// Whether the rule has a value, which may be the age of the cause.
    pub(crate) fn is_measured(&self) -> bool {
        match &self.look {
            Look::BuiltIn(_) => !self.unit.is_empty(),
            Look::Field(limit) => limit.equals.is_none(),
        }
    }

    /// Whether the rule has a value other than the age of the cause.
    pub(crate) fn has_figure(&self) -> bool {
        self.is_measured() && !self.is_age()
    }

    /// A value of this rule as text.
    pub(crate) fn figure(&self, value: f64) -> String {
        match (&self.look, self.unit) {
            (_, "V") => format!("{value:.1} V"),
            (Look::BuiltIn(_), unit) => format!("{value:.0} {unit}"),
            (Look::Field(_), unit) => {
                let tenths = (value * 10.0).round() / 10.0;
                format!("{tenths} {unit}").trim_end().to_owned()
            }
        }
    }

    /// The hint for the current state of the recording.
    pub(crate) fn hint_of(&self, recording: &Recording) -> &str {
        if self.hint == MAKE_ROOM && recording.is_disk_silent {
            DISK_IS_SILENT
        } else {
            &self.hint
        }
    }

    /// The log line when the alarm is raised; `None` if another event adds one.
    pub(in crate::model) fn log_text(&self, value: Option<f64>, keys: &Keymap) -> Option<String> {
        let figures = match value {
            Some(value) if self.has_figure() => {
                let limit = self.figure(self.bounds.raise);
                format!(" {} (limit {limit})", self.figure(value))
            }
            _ => String::new(),
        };
        let hint = match &*self.hint {
            "" => String::new(),
            hint => format!(": {}", keys.with_keys(hint)),
        };
        self.logged_here
            .then(|| format!("{}{figures}{hint}", self.name))
    }
}
