//! Alarms: a strip under the status line for the unacknowledged ones, and the panel with all alarms and limits.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};

use super::text::{First, wrap};
use super::{Screen, columns, put};
use crate::event::{Level, Moment};
use crate::model::alarms::{LINK_LOST, Raised, Rule, Shown, Source};
use crate::model::link::Connection;
use crate::model::robot::{STATE_STALE, STATUS_STALE};
use crate::model::{Panel, age};

/// Number of columns of a rule's name in the list of limits.
const NAME_COLUMNS: usize = 16;

const INDENT: usize = 2;

/// Label of the key that acknowledges alarms.
const ACKNOWLEDGE: &str = "<acknowledge-alarms>: acknowledge";

/// Time from which a STOP without a confirmation is told.
const STOP_OVERDUE: Moment = Moment::from_secs(2);

/// The hint after the station that shares the link closed the connection.
const STATION_CLOSED: &str = "waits for the station; reconnecting";

impl Screen<'_> {
    /// The alarms that are unacknowledged now, even while the screen shows the past of a live session.
    pub(super) fn calling(&self) -> Vec<(&Rule, Raised)> {
        self.present.alarms.calling(&self.ui.attended)
    }

    /// That the robot has not confirmed a STOP, if so, even while the screen shows the past of a live session.
    pub(super) fn stop_words(&self) -> Option<String> {
        let stop = self.present.ledger.unconfirmed_stop()?;
        let age = self.present_at.saturating_sub(stop.asked_at);
        let is_lost = matches!(self.present.link.connection, Connection::Lost { .. });
        let words = match (stop.status.is_end(), is_lost) {
            _ if self.ui.is_replay() => return None,
            (true, _) => "STOP FAILED: not confirmed; <stop> sends it again".to_owned(),
            (false, true) => {
                "STOP NOT SENT: waits for the link; <cancel-commands> gives up".to_owned()
            }
            (false, false) if age < STOP_OVERDUE => return None,
            (false, false) => format!(
                "STOP NOT CONFIRMED {}: sent until it is; <cancel-commands> gives up",
                age::words(age)
            ),
        };
        Some(self.with_keys(&words))
    }

    /// Draws a STOP that is not confirmed, else the worst unacknowledged alarm, and the number of others.
    pub(super) fn alarm_strip(&self, buffer: &mut Buffer, area: Rect) {
        let calling = self.calling();
        let past = self.ui.playback.as_ref().filter(|past| past.is_live);
        let (when, now) = past.map_or(("", self.now), |past| ("NOW: ", past.until));
        if let Some(words) = self.stop_words() {
            let line = format!("{} {when}{words}", self.theme.glyphs.bad);
            put(buffer, area, 0, &Line::styled(line, self.theme.alarm));
            return;
        }
        let Some((rule, raised)) = calling.first() else {
            return;
        };
        let (glyph, style) = self.alarm_mark(rule, raised);
        let more = match calling.len() {
            1 => String::new(),
            n => format!("+{} more  ", n - 1),
        };
        let right = Span::styled(
            self.with_keys(&format!("{more}{ACKNOWLEDGE}")),
            self.theme.key,
        );
        let words = format!("{glyph} {when}{}", self.alarm_words(rule, raised, now));
        let figure = raised.latest.or(raised.worst).filter(|_| rule.has_figure());
        let figure = figure.map_or_else(String::new, |figure| format!(" {}", rule.figure(figure)));
        let short = format!("{glyph} {when}{}{figure}", rule.name.to_uppercase());
        let hint = match raised.over_at {
            Some(_) => String::new(),
            None => format!(". {}", self.hint_of(rule)),
        };
        let hint = hint.trim_end();
        // What to do is worth more than how long it lasts.
        let room = usize::from(area.width).saturating_sub(columns(&right.content) + 1);
        let forms = [format!("{words}{hint}"), format!("{short}{hint}"), short];
        let mut fitting = forms.into_iter().filter(|form| columns(form) <= room);
        let line = Line::styled(fitting.next().unwrap_or(words), style);
        let line = self.with_right(line, right, usize::from(area.width));
        put(buffer, area, 0, &line);
    }

    pub(super) fn alarms(&self, buffer: &mut Buffer, area: Rect) {
        let theme = &self.theme;
        let width = usize::from(area.width);
        let room = width.saturating_sub(INDENT);
        let mut lines = Vec::new();
        let chosen = self.ui.chosen_alarm(self.facts);
        let mut chosen_row = None;
        for shown in self.ui.listed(self.facts) {
            let first = lines.len();
            if let Some(raised) = shown.raised {
                lines.extend(self.raised_lines(&shown, &raised, room));
            } else {
                let text = format!(
                    "{} {:<NAME_COLUMNS$} {}",
                    theme.glyphs.dot,
                    shown.rule.name,
                    self.standing(&shown)
                );
                lines.push(self.cut(Line::styled(text, theme.dim), width));
            }
            let is_chosen = chosen == Some(shown.index);
            if let Some(line) = lines.get_mut(first).filter(|_| is_chosen) {
                *line = std::mem::take(line).patch_style(theme.lit);
                chosen_row = Some(first);
            }
        }
        let note = Span::styled(self.alarm_note(), theme.dim);
        let title = (Panel::Alarms, "alarms");
        let around = chosen_row.filter(|_| self.ui.alarm.is_some());
        let rows = (lines.len(), around);
        let (below, shown) = self.page(buffer, area, title, Some(note), rows, First::Top);
        for (row, line) in (0..).zip(&lines[shown]) {
            put(buffer, below, row, line);
        }
    }

    /// The lines of a raised alarm, with a hint.
    fn raised_lines(&self, shown: &Shown<'_>, raised: &Raised, room: usize) -> Vec<Line<'static>> {
        let (glyph, style) = match shown.shelved_until {
            Some(_) => (self.theme.glyphs.off, self.theme.dim),
            None => self.alarm_mark(shown.rule, raised),
        };
        let mut words = self.alarm_words(shown.rule, raised, self.now);
        if let Some(left) = self.shelf_words(shown) {
            words += ", ";
            words += &left;
        }
        let rows = wrap(&words, room, room).into_iter();
        let rows = (0..).zip(rows).map(|(n, row)| {
            let glyph = if n == 0 { glyph } else { " " };
            Line::styled(format!("{glyph} {row}"), style)
        });
        let hint = wrap(&self.hint_of(shown.rule), room, room).into_iter();
        let plain = self.theme.plain;
        let hint = hint.map(|row| Line::styled(format!("{:INDENT$}{row}", ""), plain));
        rows.chain(hint).collect()
    }

    /// The time for which an alarm is shelved, as text.
    fn shelf_words(&self, shown: &Shown<'_>) -> Option<String> {
        let left = shown.shelved_until?.saturating_sub(self.now);
        Some(format!("shelved, {} left", age::words(left)))
    }

    fn alarm_note(&self) -> String {
        let calling = self.facts.alarms.calling(&self.ui.attended).len();
        match calling {
            0 => String::new(),
            n => self.with_keys(&format!("{n} new, {ACKNOWLEDGE}")),
        }
    }

    /// Glyph and style of an alarm: active, over or acknowledged.
    fn alarm_mark(&self, rule: &Rule, raised: &Raised) -> (&'static str, Style) {
        let theme = &self.theme;
        let glyphs = theme.glyphs;
        match (raised.is_acknowledged, raised.over_at, rule.level) {
            (true, ..) => (glyphs.done, theme.plain),
            (false, Some(_), _) => (glyphs.off, theme.warning),
            (false, None, Level::Alarm) => (glyphs.bad, theme.alarm),
            (false, None, Level::Info | Level::Warning) => ("!", theme.warning),
        }
    }

    /// The hint of a rule, as a sentence.
    fn hint_of(&self, rule: &Rule) -> String {
        let facts = self.present;
        let hint = if rule.code == LINK_LOST && facts.link.is_closed_by_station() {
            STATION_CLOSED
        } else {
            rule.hint_of(&facts.recording)
        };
        let mut hint = self.with_keys(hint);
        if let Some(first) = hint.get_mut(..1) {
            first.make_ascii_uppercase();
        }
        hint
    }

    /// Name, values and duration of an alarm as text.
    fn alarm_words(&self, rule: &Rule, raised: &Raised, now: Moment) -> String {
        let figure = match raised.worst.filter(|_| rule.has_figure()) {
            Some(worst) => {
                let words = figure_words(rule, raised, worst);
                if rule.bounds.reaches(worst) {
                    format!(" {words} ({})", limit_words(rule))
                } else {
                    format!(" {words}")
                }
            }
            None => String::new(),
        };
        let times = match raised.times {
            1 => String::new(),
            n => format!(" {}{n}", self.theme.glyphs.times),
        };
        let since = age::words(now.saturating_sub(raised.at));
        let when = match raised.over_at {
            Some(over_at) => {
                let ago = age::words(now.saturating_sub(over_at));
                format!("over, {ago} ago")
            }
            None if raised.is_acknowledged => format!("for {since}, acknowledged"),
            None if figure.is_empty() && times.is_empty() => since,
            None => format!("for {since}"),
        };
        format!("{}{figure}{times} {when}", rule.name.to_uppercase())
    }

    /// The value of a rule without an alarm, marked if stale.
    fn standing(&self, shown: &Shown<'_>) -> String {
        let Shown { rule, value, .. } = *shown;
        let robot = &self.facts.robot;
        let known = match rule.source {
            Source::State => robot.state.map(|line| (line.age(self.now), STATE_STALE)),
            Source::Status => robot.status.map(|line| (line.age(self.now), STATUS_STALE)),
            Source::Lines => {
                let age = self.facts.link.newest_age(self.now);
                age.map(|age| (age, STATE_STALE))
            }
            Source::Field if !shown.is_known => None,
            // A rule with a unit needs a measurement first.
            Source::Station if value.is_none() && rule.is_measured() => None,
            Source::Station | Source::Field => Some((Moment::ZERO, STATE_STALE)),
        };
        let shelved = self.shelf_words(shown);
        let Some((age, stale_after)) = known else {
            return shelved.unwrap_or_else(|| "unknown".to_owned());
        };
        let old = self.old_mark(age, stale_after);
        match (shelved, value.filter(|_| rule.has_figure())) {
            (Some(shelved), _) => shelved,
            (None, Some(value)) => {
                format!("{old}{} ({})", rule.figure(value), limit_words(rule))
            }
            (None, None) => format!("{old}quiet"),
        }
    }
}

fn limit_words(rule: &Rule) -> String {
    format!("limit {}", rule.figure(rule.bounds.raise))
}

/// The latest and the worst value as text, each labelled.
fn figure_words(rule: &Rule, raised: &Raised, worst: f64) -> String {
    let worst = rule.figure(worst);
    let latest = raised.latest.map(|latest| rule.figure(latest));
    match (raised.over_at, latest) {
        (Some(_), _) => format!("at worst {worst}"),
        (None, Some(latest)) if latest != worst => format!("{latest}, at worst {worst}"),
        (None, _) => worst,
    }
}
