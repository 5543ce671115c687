//! Every alarm in one table, with its limits.

use groundwave_protocol::status_codes::{Bump, Cliff, Drive, Link as LinkLetter, Power};
use groundwave_protocol::telemetry::StateLine;
use serde::Deserialize;

use crate::event::{Level, Moment, Recording};
use crate::model::Config;
use crate::model::link::{Connection, Link};
use crate::model::motors::Motors;
use crate::model::robot::{Robot, is_held, touches};

/// Limits of the alarms.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Limits {
    /// Battery low at this voltage or below, decivolts.
    pub battery_low_dv: u16,
    /// Battery critical at this voltage or below, decivolts.
    pub battery_critical_dv: u16,
    /// A low or critical battery recovers this far above its limit, decivolts.
    pub battery_hysteresis_dv: u16,
    /// Time below the limit before the alarm, s: starting motors draw the voltage down.
    pub battery_for_s: u16,
    /// Time without a line before the robot is silent, s.
    pub silent_s: u16,
    /// Share of lines lost or damaged that raises an alarm, per cent.
    pub loss_pct: u8,
    /// Time above that share before the alarm, s.
    pub loss_for_s: u16,
    /// Time that ordered wheels stand still before they are stalled, s.
    pub stalled_s: u16,
    /// Time without floor under several sensors before the robot counts as fallen or lifted, s.
    pub fallen_s: u16,
    /// Time that layers take the motors from each other before the alarm, s.
    pub thrash_s: u16,
}

impl Default for Limits {
    /// The thresholds of the SR04's own firmware where it has them.
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
        }
    }
}

/// The hint for a recording that failed.
const MAKE_ROOM: &str =
    "make room, then <toggle-recording> records on; until then memory keeps the newest";

/// The hint for a recording on a disk that hangs.
pub(crate) const DISK_IS_SILENT: &str =
    "the disk does not answer; check it; until then memory keeps the newest";

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
    /// Unknown: the alarm stays as it was.
    Unknown,
    No,
    /// The cause is there; counts when it has lasted.
    Yes,
    /// The robot or the recorder reports it; counts at once.
    Certain,
    /// A figure to compare with the limit.
    Is(f64),
}

/// Limits of one rule.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds {
    /// The figure that raises the alarm.
    pub(crate) raise: f64,
    /// The figure that clears it; below `raise` if high figures are bad, else above.
    clear: f64,
    /// Time beyond the limit before the alarm is raised.
    pub(super) persists: Moment,
}

/// Where a rule's figure comes from.
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
}

/// One row of the table.
#[derive(Debug)]
pub(crate) struct Rule {
    /// Its name in JSON.
    pub(crate) code: &'static str,
    pub(crate) level: Level,
    pub(crate) name: &'static str,
    /// What to do about it, for [`Keymap::told`](crate::model::keys::Keymap::told).
    pub(crate) hint: &'static str,
    /// Unit of the figure; empty where there is none.
    pub(crate) unit: &'static str,
    /// Whether raising it adds the log line; otherwise another event does.
    logged_here: bool,
    /// Where its figure comes from.
    pub(crate) source: Source,
    pub(super) look: fn(&Inputs<'_>) -> Sight,
    bounds: fn(&Limits) -> Bounds,
}

/// Unit of a figure that is an age.
pub(super) const SECONDS: &str = "s";

/// Time that the bumper is pressed before it counts as jammed, s.
pub(crate) const PRESSED_S: u16 = 5;

pub(super) const RULES_COUNT: usize = 11;

/// Every alarm, the worst first.
pub(crate) const RULES: [Rule; RULES_COUNT] = [
    Rule {
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
    Rule {
        code: "fallen_or_lifted",
        level: Level::Alarm,
        name: "fallen or lifted",
        hint: "no floor under it: go and look",
        unit: "",
        logged_here: true,
        source: Source::State,
        look: |inputs| state_is(inputs, |state| state.cliff == Cliff::Several),
        bounds: |limits| lasting(limits.fallen_s),
    },
    Rule {
        code: "failsafe",
        level: Level::Alarm,
        name: "failsafe",
        hint: "it hears no ground station and acts by itself",
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
    Rule {
        code: "link_lost",
        level: Level::Alarm,
        name: "link lost",
        hint: "check cable or network; reconnecting",
        unit: "",
        logged_here: false,
        source: Source::Station,
        look: |inputs| match inputs.link.connection {
            Connection::Lost { .. } => Sight::Certain,
            Connection::Opening | Connection::Open | Connection::Ended => Sight::No,
        },
        bounds: |_| lasting(0),
    },
    Rule {
        code: "robot_silent",
        level: Level::Alarm,
        name: "robot silent",
        hint: "is it on, and in reach?",
        unit: SECONDS,
        logged_here: true,
        source: Source::Station,
        look: silence,
        bounds: |limits| {
            let raise = f64::from(limits.silent_s.max(1));
            Bounds {
                raise,
                clear: raise - 0.5,
                persists: Moment::ZERO,
            }
        },
    },
    Rule {
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
    Rule {
        code: "battery_low",
        level: Level::Alarm,
        name: "battery low",
        hint: "call it home (<modes/mode-go-home>) and charge it",
        unit: "V",
        logged_here: true,
        source: Source::Status,
        look: |inputs| battery(inputs, &[Power::Low, Power::Critical]),
        bounds: |limits| below_dv(limits, limits.battery_low_dv),
    },
    Rule {
        code: "stalled",
        level: Level::Alarm,
        name: "stalled",
        hint: "its wheels are held: free it, or STOP (<stop>)",
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
    Rule {
        code: "bumper_jammed",
        level: Level::Warning,
        name: "bumper jammed",
        hint: "something hooks its bumper: free it if it does not",
        unit: "",
        logged_here: true,
        source: Source::State,
        look: |inputs| match inputs.robot.state {
            Some(state) if state.value.bump == Bump::Jammed => Sight::Certain,
            _ => state_is(inputs, |state| touches(state.bump)),
        },
        bounds: |_| lasting(PRESSED_S),
    },
    Rule {
        code: "layers_thrash",
        level: Level::Warning,
        name: "layers thrash",
        hint: "they take the motors from each other: forbid one (<toggle-layer-bumpers..>)",
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
    Rule {
        code: "lines_not_intact",
        level: Level::Warning,
        name: "lines not intact",
        hint: "a weak or disturbed radio: come closer",
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
                persists: Moment::from_secs(limits.loss_for_s.into()),
            }
        },
    },
];

fn lasting(s: u16) -> Bounds {
    Bounds {
        raise: 1.0,
        clear: 0.0,
        persists: Moment::from_secs(s.into()),
    }
}

fn below_dv(limits: &Limits, limit_dv: u16) -> Bounds {
    Bounds {
        raise: f64::from(limit_dv) / 10.0,
        clear: f64::from(limit_dv.saturating_add(limits.battery_hysteresis_dv.max(1))) / 10.0,
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

fn silence(inputs: &Inputs<'_>) -> Sight {
    match (&inputs.link.connection, inputs.link.newest_age(inputs.now)) {
        (Connection::Open, Some(age)) => Sight::Is(age.as_secs_f64()),
        _ => Sight::Unknown,
    }
}

impl Bounds {
    pub(super) fn is_high_bad(self) -> bool {
        self.raise > self.clear
    }

    /// Whether a figure reaches the limit.
    pub(super) fn reaches(self, value: f64) -> bool {
        if self.is_high_bad() {
            value >= self.raise
        } else {
            value <= self.raise
        }
    }

    /// Whether a figure is clear of the limit.
    pub(super) fn is_clear(self, value: f64) -> bool {
        if self.is_high_bad() {
            value <= self.clear
        } else {
            value >= self.clear
        }
    }
}

impl Rule {
    pub(crate) fn bounds(&self, limits: &Limits) -> Bounds {
        (self.bounds)(limits)
    }

    /// Whether a figure reaches the limit.
    pub(crate) fn is_beyond(&self, value: f64, limits: &Limits) -> bool {
        self.bounds(limits).reaches(value)
    }

    /// Whether it has a figure besides its age.
    pub(crate) fn has_figure(&self) -> bool {
        !matches!(self.unit, "" | SECONDS)
    }

    /// A figure of this rule in words.
    pub(crate) fn figure(&self, value: f64) -> String {
        match self.unit {
            "V" => format!("{value:.1} V"),
            unit => format!("{value:.0} {unit}"),
        }
    }
}

impl Rule {
    /// The hint for a recording as it is.
    pub(crate) fn hint_of(&self, recording: &Recording) -> &'static str {
        if self.hint == MAKE_ROOM && recording.is_disk_silent {
            DISK_IS_SILENT
        } else {
            self.hint
        }
    }

    /// The log line when it is raised; `None` when another event adds one.
    pub(in crate::model) fn log_text(&self, value: Option<f64>, config: &Config) -> Option<String> {
        let figures = match value {
            Some(value) if self.has_figure() => {
                let limit = self.figure(self.bounds(&config.limits).raise);
                format!(" {} (limit {limit})", self.figure(value))
            }
            _ => String::new(),
        };
        self.logged_here
            .then(|| format!("{}{figures}: {}", self.name, config.keys.told(self.hint)))
    }
}
