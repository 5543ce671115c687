//! The sensors: the robot's measured values, each with its age if stale.

use groundwave_protocol::status_codes::{Arm, Bump, Cliff, Drive, Infrared, Power};
use groundwave_protocol::telemetry::Reading;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};

use super::plots::OF_SENSORS;
use super::text::First;
use super::{Screen, columns, split_top};
use crate::event::Moment;
use crate::model::alarms::PRESSED_S;
use crate::model::robot::{
    COUNTERS_STALE, STATE_STALE, STATUS_STALE, detects, ordered_wheels_in_s, touches,
};
use crate::model::{Panel, age, why, words};

/// Height of the whole panel, rows.
pub(super) const ROWS: u16 = 11;

/// Index of the battery's row among those of line A.
const BATTERY_PLACE: usize = 5;

/// Right end of the alarms' limits on a wide screen, columns.
const LIMITS_COLUMNS: usize = 100;

/// Width of a row's name, columns.
const NAME_COLUMNS: usize = 9;

/// Range of a full sonar bar, inches.
const SONAR_BAR_IN: f64 = 120.0;

/// Range of the battery's plot, decivolts: an empty and a full lead-acid battery.
const VOLTS_DV: (u16, u16) = (105, 138);

/// One row to draw.
struct Row<'a> {
    name: &'static str,
    spans: Vec<Span<'a>>,
    age: Option<Moment>,
    stale_after: Moment,
}

impl Screen<'_> {
    pub(super) fn sensors(&self, buffer: &mut Buffer, area: Rect) {
        let mut lines: Vec<Line<'_>> = self
            .sensor_rows(area.width)
            .into_iter()
            .map(|row| self.sensor_line(area.width, row))
            .collect();
        if lines.is_empty() {
            lines.push(Line::styled("no data yet", self.theme.dim));
        }
        let stale = self.facts.robot.stale(self.now);
        let note = (!stale.is_empty()).then(|| {
            let which = match stale[..] {
                [_, _, _] => "all".to_owned(),
                _ => stale.join(", "),
            };
            let words = format!("{} stale: {which}", self.theme.glyphs.stale);
            Span::styled(words, self.theme.warning)
        });
        let (rows, below) = split_top(area, 1 + lines.len() as u16);
        let title = (Panel::Sensors, "sensors");
        self.pages(buffer, rows, title, note, &lines, First::Top);
        self.plots_below(buffer, below, &OF_SENSORS);
    }

    fn sensor_rows(&self, width: u16) -> Vec<Row<'_>> {
        let mut rows = self.state_rows(width);
        if let Some(battery) = self.battery_row(width) {
            rows.insert(rows.len().min(BATTERY_PLACE), battery);
        }
        rows.extend(self.counts_row(width));
        rows
    }

    fn sensor_line<'r>(&self, width: u16, row: Row<'r>) -> Line<'r> {
        let stale = self.staleness(row.age, row.stale_after);
        let mut spans = vec![Span::styled(
            format!("{:<NAME_COLUMNS$}", row.name),
            self.theme.dim,
        )];
        spans.extend(row.spans);
        let width = usize::from(width);
        let Some(stale) = stale else {
            let line = self.cut(Line::from(spans), width);
            return match self.alarm_limit(row.name) {
                Some(limit) if self.ui.enlarged.is_some() => {
                    let limit = Span::styled(limit, self.theme.dim);
                    self.with_right(line, limit, width.min(LIMITS_COLUMNS))
                }
                _ => line,
            };
        };
        for span in &mut spans {
            span.style = self.theme.dim;
        }
        self.with_right(
            Line::from(spans),
            Span::styled(stale, self.theme.dim),
            width,
        )
    }

    /// The limit at which a row's value raises an alarm, as text.
    fn alarm_limit(&self, name: &str) -> Option<String> {
        let limits = &self.ui.config.limits;
        let volts = |dv: u16| format!("{}.{}", dv / 10, dv % 10);
        let limit = match name {
            "bumper" => format!("jammed after {PRESSED_S} s"),
            "wheels" => format!("stalled after {} s", limits.stalled_s),
            "battery" => format!(
                "{} V low, {} V critical",
                volts(limits.battery_low_dv),
                volts(limits.battery_critical_dv)
            ),
            "drive" => format!("fallen after {} s without floor", limits.fallen_s),
            "robot" => format!("silent after {} s", limits.silent_s),
            _ => return None,
        };
        Some(format!("alarm: {limit}"))
    }

    fn state_rows(&self, width: u16) -> Vec<Row<'_>> {
        let Some(state) = self.facts.robot.state else {
            return Vec::new();
        };
        let age = state.age(self.now);
        let state = state.value;
        let [left_in_s, right_in_s] = ordered_wheels_in_s(&state);
        let has_wheels = self.facts.robot.measures(Reading::Wheels);
        let wheel = |measured: i8, wanted: i32| {
            if has_wheels {
                format!("{measured:+3} of {wanted:+3}")
            } else {
                format!("{wanted:+3} requested")
            }
        };
        let wheels = format!(
            "L {}  R {} in/s",
            wheel(state.wheel_left_in_s, left_in_s),
            wheel(state.wheel_right_in_s, right_in_s)
        );
        let sonar_share = |range_in: Option<u16>| range_in.map(|v| f64::from(v) / SONAR_BAR_IN);
        let sonar_words = |range_in: Option<u16>| match range_in {
            Some(range_in) => format!("{range_in:>3} in"),
            None => "  none".to_owned(),
        };
        let dark_share = |percent: Option<u8>| percent.map(|v| f64::from(v) / 100.0);
        let dark_words = |percent: Option<u8>| match percent {
            Some(percent) => format!("{percent:>4} %"),
            None => "  none".to_owned(),
        };
        let rows = [
            ("bumper", self.bumper(width, state.bump)),
            ("infrared", self.infrared(width, state.infrared)),
            (
                "sonar",
                self.pair(
                    width,
                    [state.sonar_left_in, state.sonar_right_in]
                        .map(|v| (sonar_words(v), sonar_share(v))),
                ),
            ),
            ("wheels", vec![Span::raw(wheels)]),
            (
                "darkness",
                self.pair(
                    width,
                    [state.photo_left_pct, state.photo_right_pct]
                        .map(|v| (dark_words(v), dark_share(v))),
                ),
            ),
            ("drive", self.drive(state.drive, state.cliff)),
            ("arm", self.arm(state.arm)),
        ];
        rows.into_iter()
            .filter(|(name, _)| *name != "sonar" || self.facts.robot.measures(Reading::Sonars))
            .map(|(name, spans)| Row {
                name,
                spans,
                age: Some(age),
                stale_after: STATE_STALE,
            })
            .collect()
    }

    fn bumper(&self, width: u16, bump: Bump) -> Vec<Span<'_>> {
        if touches(bump) {
            let words = format!("{} {}", self.theme.glyphs.bump, why::bump(bump));
            return vec![Span::styled(words, self.theme.holder)];
        }
        let now = Span::styled(why::bump(bump), self.quiet(bump == Bump::NotFitted));
        let last = self.facts.robot.bump;
        let last = last.map(|last| (side(why::bump(last.value)), last.age(self.now)));
        self.with_last(width, now, last)
    }

    fn infrared(&self, width: u16, infrared: Infrared) -> Vec<Span<'_>> {
        if detects(infrared) {
            let words = format!("{} {}", self.theme.glyphs.raised, words::infrared(infrared));
            return vec![Span::styled(words, self.theme.raised)];
        }
        let style = match infrared {
            Infrared::Jammed => self.theme.warning,
            other => self.quiet(other == Infrared::NotFitted),
        };
        let now = Span::styled(words::infrared(infrared), style);
        let last = self.facts.robot.infrared;
        let last = last.map(|last| (words::infrared(last.value), last.age(self.now)));
        self.with_last(width, now, last)
    }

    /// What a sensor says now, and its last contact and the time since then, in the longest words that fit.
    fn with_last<'s>(
        &self,
        width: u16,
        now: Span<'s>,
        last: Option<(&str, Moment)>,
    ) -> Vec<Span<'s>> {
        let room = usize::from(width).saturating_sub(NAME_COLUMNS + columns(&now.content));
        let forms = last.map(|(contact, age)| {
            let ago = age::words(age);
            [
                format!("  last: {contact}, {ago} ago"),
                format!("  {contact} {ago} ago"),
                format!("  last {ago} ago"),
            ]
        });
        let mut fitting = forms
            .into_iter()
            .flatten()
            .filter(|words| columns(words) <= room);
        let last = fitting
            .next()
            .map(|words| Span::styled(words, self.theme.dim));
        [now].into_iter().chain(last).collect()
    }

    fn quiet(&self, not_fitted: bool) -> Style {
        if not_fitted {
            self.theme.dim
        } else {
            self.theme.plain
        }
    }

    /// The left and the right value, each with a bar.
    fn pair(&self, width: u16, values: [(String, Option<f64>); 2]) -> Vec<Span<'_>> {
        let room = usize::from(width).saturating_sub(NAME_COLUMNS + 10);
        let cells = (room / 2).saturating_sub(9).clamp(2, 12);
        let mut spans = Vec::new();
        for (side, (words, share)) in ["L", " R"].into_iter().zip(values) {
            spans.push(Span::raw(format!("{side} {words} ")));
            let bar = match share {
                Some(share) => self.bar(share, cells),
                None => " ".repeat(cells),
            };
            spans.push(Span::styled(bar, self.theme.trail));
        }
        spans
    }

    fn drive(&self, drive: Drive, cliff: Cliff) -> Vec<Span<'_>> {
        let theme = &self.theme;
        let drive_style = match drive {
            Drive::Ok => theme.plain,
            Drive::Stalled => theme.alarm,
            Drive::Saturated | Drive::OdometerReset | Drive::OutOfRange => theme.warning,
        };
        let cliff_style = match cliff {
            Cliff::None => theme.plain,
            Cliff::NotFitted => theme.dim,
            Cliff::Left | Cliff::Center | Cliff::Right | Cliff::Several => theme.alarm,
        };
        vec![
            Span::styled(words::drive(drive), drive_style),
            Span::raw("   "),
            Span::styled(words::cliff(cliff), cliff_style),
        ]
    }

    fn arm(&self, arm: Arm) -> Vec<Span<'_>> {
        let style = match arm {
            Arm::MotionLeft | Arm::MotionRight | Arm::MotionBoth => self.theme.raised,
            Arm::TopHat => self.theme.warning,
            other => self.quiet(other == Arm::NotFitted),
        };
        vec![Span::styled(why::arm(arm), style)]
    }

    fn battery_row(&self, width: u16) -> Option<Row<'_>> {
        let status = self.facts.robot.battery()?;
        let volts = status.value.battery_dv;
        let power = self
            .facts
            .robot
            .state
            .map_or(Power::Ok, |state| state.value.power);
        let style = match power {
            Power::Low | Power::Critical => self.theme.alarm,
            Power::Ok | Power::Docked | Power::Charging => self.theme.plain,
        };
        let room = usize::from(width).saturating_sub(NAME_COLUMNS + 18);
        Some(Row {
            name: "battery",
            spans: vec![
                Span::styled(
                    format!(
                        "{:>2}.{} V {} ",
                        volts / 10,
                        volts % 10,
                        words::power(power)
                    ),
                    style,
                ),
                Span::styled(self.volts_plot(room.min(24)), self.theme.trail),
            ],
            age: Some(status.age(self.now)),
            stale_after: STATUS_STALE,
        })
    }

    /// The battery voltage of the whole session as a plot of `cells` columns.
    fn volts_plot(&self, cells: usize) -> String {
        let samples = self.facts.robot.volts.samples();
        let cells = cells.min(samples.len());
        let (low, high) = VOLTS_DV;
        (0..cells)
            .filter_map(|cell| {
                let from = cell * samples.len() / cells;
                let to = (cell + 1) * samples.len() / cells;
                samples.get(from..to)?.iter().min()
            })
            .map(|volts| {
                let above = usize::from(volts.clamp(&low, &high) - low);
                self.theme.glyphs.column[above * 7 / usize::from(high - low)]
            })
            .collect()
    }

    fn counts_row(&self, width: u16) -> Option<Row<'_>> {
        let counters = self.facts.robot.counters?;
        let c = counters.value;
        let age = Some(counters.age(self.now));
        // The displayed uptime does not advance while the robot is silent.
        let stale_after = if self.is_stale() {
            STATE_STALE
        } else {
            COUNTERS_STALE
        };
        let stale = self.staleness(age, stale_after);
        let taken = NAME_COLUMNS + stale.map_or(0, |words| 1 + columns(&words));
        let mut room = usize::from(width).saturating_sub(taken);
        // A contact is seen up to four seconds before the robot's next count arrives.
        let bumps = c.bumps.max(self.facts.robot.contacts);
        let up = age::words(Moment::from_secs(u64::from(c.uptime_s)));
        let parts = [
            format!("id {}", c.robot_id),
            format!(", up {up}"),
            format!(", bumps {bumps}"),
            format!(", boot {}", c.boots),
            format!(", v{}.{:02}", c.version.major, c.version.minor),
        ];
        // What does not fit is left out whole.
        let fit = parts.into_iter().take_while(|part| {
            let fits = columns(part) <= room;
            room = room.saturating_sub(columns(part));
            fits
        });
        Some(Row {
            name: "robot",
            spans: vec![Span::styled(fit.collect::<String>(), self.theme.dim)],
            age,
            stale_after,
        })
    }
}

/// Shortens `right bumper` to `right` for the bumper's row.
fn side(words: &str) -> &str {
    words.trim_end_matches(" bumper")
}
